//! The frontier's tables: what to choose, every configuration, what leaving out pays, how times grow.

use anyhow::Result;
use hapdef::Run;
use hapdef::scene::{RigMesh, Scene};
use hapdef_bench::{Column, goal_table, table, text_table};
use hapdef_report::{MetricContext, ReportTable};

use super::figures::{GOALS, GOALS_NOTE};
use super::frames::contacts_in_words;
use super::growth::Growth;
use super::point::{Family, Point, best_within, error_mm};
use super::skips::{Compared, Skips};
use super::{Measured, configurations_table, planned};
use crate::run::scores::GOSPA;

/// Budgets of a frame, µs.
const BUDGETS: [(&str, f64); 3] = [("100 µs", 100.0), ("1 ms", 1000.0), ("any", f64::INFINITY)];

/// What is to be known of the table of times.
const TIMES_NOTE: &str = "Times of n frames of two contacts, on one core, in five rounds: no pair twice in \
    searches; followed ones from the second contact on. p50: the median of the rounds' medians; p99: the \
    99 % quantile of all; each ± half the range of the rounds' own. Slowest: of followed ones any frame, \
    those of no or one contact, too. Every configuration is measured beside the usual one (searched, refined mesh, the \
    scene's gauges, 300 presses) and scaled by it, so that a slow hour does not count. Design: solves, \
    calibration or training, preparation; of the paper's chain in the run that made each stage. Front: no \
    other configuration that knows as much before is both faster and nearer by GOSPA; S: of searches and the paper's \
    chain, F: of followed configurations.";

/// Every table of the page.
pub(super) fn tables(run: &Run, measured: &Measured) -> Result<Vec<ReportTable>> {
    let mut tables = vec![
        recommended(&measured.points)?,
        goal_table(&GOALS, measured, GOALS_NOTE)?,
        ReportTable {
            title: "Every configuration from readings to contacts: errors".into(),
            note: errors_note(&run.scene),
            text: configurations_table::errors(&measured.points),
            data: serde_json::to_value(&measured.points)?,
        },
        ReportTable {
            title: "Every configuration from readings to contacts: times".into(),
            note: TIMES_NOTE.into(),
            text: configurations_table::times(&measured.points),
            data: serde_json::Value::Null,
        },
        skips_table(&measured.skips)?,
        growth_table(&measured.growths)?,
    ];
    if !measured.planned.is_empty() {
        tables.push(planned::table(&measured.planned)?);
    }
    Ok(tables)
}

/// What is to be known of the tables of configurations.
pub(super) fn note(scene: &Scene) -> String {
    format!("{} {TIMES_NOTE}", errors_note(scene))
}

fn errors_note(scene: &Scene) -> String {
    let rig = match scene.rig.mesh {
        RigMesh::Deck { .. } => "a mesh of its own, not the limb's, perturbed",
        RigMesh::Refined { .. } => {
            "the limb's own mesh refined, perturbed: refined configurations have its discretisation error, as on \
             hardware they would not"
        }
    };
    let contacts = contacts_in_words(scene);
    let cutoff_mm = GOSPA.cutoff_m * 1e3;
    let alone_mm = 0.5 * cutoff_mm;
    format!(
        "Simulated: the scene's rig, {rig}, with noise and converter. Mesh: the limb's own solid, each \
         element of it cut into eight, or a shell of its skin without ribs and rings. {contacts}; the \
         same contacts for all configurations. Search: every frame for itself. Followed: the contacts of a frame \
         one after the other, scored when all have been there for a while, searches left to a second \
         thread. The number of contacts is estimated by superposition and given to the paper's chain. \
         GOSPA, by which configurations are ranked: the sum over the frames of min over pairings γ of \
         Σ d + c/2 · (missed + spurious), c = {cutoff_mm} mm, over the number of true contacts \
         (Rahmathullah, García-Fernández and Svensson 2017, α = 2, p = 1): each missed or spurious \
         contact costs {alone_mm} mm, a pair farther apart than c both. All other errors are means over \
         contacts matched one to one, of position, mm, and force, N; missed: true contacts without a \
         match; spurious: contacts without a true one, per 100 frames; clean: frames with the right \
         number of contacts, all within 10 mm. Map: mean error of the displacement of the whole skin."
    )
}

/// The configuration of least error within each budget, for searches and for live use.
fn recommended(points: &[Point]) -> Result<ReportTable> {
    let header = [
        "a frame",
        "its budget",
        "configuration",
        "two: GOSPA, mm",
        "mean, mm",
        "missed",
        "clean",
        "p99, µs",
        "design, s",
    ];
    let (mut rows, mut data) = (Vec::new(), Vec::new());
    for (frame, family) in [
        ("searched, nothing known before", Family::Searched),
        ("followed from those before, live", Family::Followed),
    ] {
        for (budget, budget_us) in BUDGETS {
            let best = best_within(points, family, budget_us);
            let of_best = best.map_or_else(no_way, recommended_cells);
            let [configuration, gospa, mean, missed, clean, p99, design] = of_best;
            let (frame, budget) = (frame.to_owned(), budget.to_owned());
            rows.push([frame, budget, configuration, gospa, mean, missed, clean, p99, design]);
            data.push(best);
        }
    }
    Ok(ReportTable {
        title: "Recommended".into(),
        note: format!(
            "Of the configurations by superposition below that of least GOSPA with two contacts whose 99 % quantile \
             is within the budget. Timed on this machine ({}); no microcontroller was. Followed contacts \
             leave searches to a second thread; where there is none, a frame in which something new \
             touches takes as long as its search.",
            MetricContext::here(0).machine
        ),
        text: text_table(header, rows),
        data: serde_json::to_value(data)?,
    })
}

fn no_way() -> [String; 7] {
    ["none", "–", "–", "–", "–", "–", "–"].map(str::to_owned)
}

fn recommended_cells(p: &Point) -> [String; 7] {
    [
        p.name.clone(),
        format!("{:.2}", error_mm(p)),
        format!("{:.2}", p.double.mean_mm),
        format!("{:.1} %", p.double.missed_pct),
        format!("{:.0} %", p.double.clean_pct),
        format!("{:.0}", p.frame.p99_us),
        format!("{:.1}", p.design.all_s()),
    ]
}

fn skips_table(skips: &Skips) -> Result<ReportTable> {
    let header = ["", "everything", "single contacts", "times faster"];
    let row = |name: &str, full: String, lean: String, ratio: f64| {
        [name.to_owned(), full, lean, format!("{ratio:.1}")]
    };
    let frame_rows = |name: &str, both: &Compared| {
        let lean = format!("{:.2}", both.lean_us);
        let of = |full_us: f64| format!("{full_us:.2}");
        let alone = format!("{name}, contacts alone, µs");
        [
            row(&format!("{name}, µs"), of(both.full_us), lean.clone(), both.speedup()),
            row(&alone, of(both.contacts_us), lean, both.contacts_speedup()),
        ]
    };
    let mut rows = vec![row(
        "design, s",
        format!("{:.2}", skips.full_design_s),
        format!("{:.2}", skips.lean_design_s),
        skips.design_speedup(),
    )];
    rows.extend(frame_rows("a frame that is searched", &skips.searched));
    rows.extend(frame_rows("a frame of a contact that is followed", &skips.followed));
    Ok(ReportTable {
        title: "What is left out pays".into(),
        note: format!(
            "The scene as it is, contact.max_contacts {}, with the displacement of the whole skin, and the \
             same with contact.max_contacts 1 and contacts alone, on frames of one contact; designs \
             without a calibration, nothing from a cache, medians of three made in turns. Searched, \
             nothing known before: of {} answers the first finds one contact in {}, both the same to \
             rounding in {}. Followed, as in live use: {}, {}, {}; where a contact is followed to depends \
             on the frames before. A followed frame is faster by the displacement of the skin, which the \
             live page wants some 60 times a second and a sink may want in every frame.",
            skips.max_contacts,
            skips.searched.n,
            skips.searched.n_single,
            skips.searched.n_equal,
            skips.followed.n,
            skips.followed.n_single,
            skips.followed.n_equal
        ),
        text: text_table(header, rows),
        data: serde_json::to_value(skips)?,
    })
}

const GROWTH: [Column<Growth>; 6] = [
    Column::new("", |g| g.what.to_owned()),
    Column::new("with", |g| g.with.to_owned()),
    Column::new("exponent", |g| format!("{:.2}", g.exponent)),
    Column::new("theory", |g| g.theory.to_owned()),
    Column::new("fitted from", |g| format!("{:.0} to {:.0}", g.fitted[0], g.fitted[1])),
    Column::new("measured", |g| {
        let points = g.points.iter().map(|(x, y)| format!("{x:.0}: {y:.3}"));
        points.collect::<Vec<_>>().join(" · ")
    }),
];

fn growth_table(growths: &[Growth]) -> Result<ReportTable> {
    Ok(ReportTable {
        title: "How time and memory grow".into(),
        note: "Tubes of a limb's size, one element through the wall; 10 gauges where nothing else is \
               said. Exponent: slope of the logarithms, the smallest third of the sizes left out. \
               Theory: nested dissection of a surface takes n^1.5 operations and n log n entries. Memory: \
               what is kept, the factor's entries and the gauges' fields at every node and on the skin."
            .into(),
        text: table(&GROWTH, growths),
        data: serde_json::to_value(growths)?,
    })
}
