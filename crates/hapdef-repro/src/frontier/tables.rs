//! The frontier's tables: what to choose, every configuration, what leaving out pays, how times grow.

use anyhow::Result;
use hapdef::Run;
use hapdef::scene::{RigMesh, Scene};
use hapdef_bench::{Column, or_dash, page_table, table, text_table};
use hapdef_report::{MetricContext, ReportTable};

use super::figures::STUDY;
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
    let points = &measured.points;
    let title = |what: &str| format!("Every configuration from readings to contacts: {what}");
    let errors = configurations_table::errors(points);
    let times = configurations_table::times(points);
    let mut tables = vec![
        recommended(points)?,
        STUDY.goal_table(measured)?,
        page_table(title("errors"), errors_note(&run.scene), errors, points)?,
        page_table(title("times"), TIMES_NOTE, times, &())?,
        skips_table(&measured.skips)?,
        page_table(
            "How time and memory grow",
            GROWTH_NOTE,
            table(&GROWTH, &measured.growths),
            &measured.growths,
        )?,
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

/// The configuration of least error within a budget.
struct Recommended<'a> {
    frame: &'static str,
    budget: &'static str,
    best: Option<&'a Point>,
}

impl Recommended<'_> {
    fn of_best(&self, cell: impl Fn(&Point) -> String) -> String {
        or_dash(self.best.map(cell))
    }
}

fn recommended_columns<'a>() -> [Column<Recommended<'a>>; 9] {
    [
        Column::new("a frame", |r| r.frame.to_owned()),
        Column::new("its budget", |r| r.budget.to_owned()),
        Column::new("configuration", |r| r.best.map_or("none".to_owned(), |p| p.name.clone())),
        Column::new("two: GOSPA, mm", |r| r.of_best(|p| format!("{:.2}", error_mm(p)))),
        Column::new("mean, mm", |r| r.of_best(|p| format!("{:.2}", p.double.mean_mm))),
        Column::new("missed", |r| r.of_best(|p| format!("{:.1} %", p.double.missed_pct))),
        Column::new("clean", |r| r.of_best(|p| format!("{:.0} %", p.double.clean_pct))),
        Column::new("p99, µs", |r| r.of_best(|p| format!("{:.0}", p.frame.p99_us))),
        Column::new("design, s", |r| r.of_best(|p| format!("{:.1}", p.design.all_s()))),
    ]
}

/// What is recommended within each budget, for searches and for live use.
fn recommended(points: &[Point]) -> Result<ReportTable> {
    let frames = [
        ("searched, nothing known before", Family::Searched),
        ("followed from those before, live", Family::Followed),
    ];
    let rows = frames.iter().flat_map(|(frame, family)| {
        BUDGETS.map(|(budget, budget_us)| Recommended {
            frame,
            budget,
            best: best_within(points, *family, budget_us),
        })
    });
    let rows: Vec<Recommended<'_>> = rows.collect();
    let note = format!(
        "Of the configurations by superposition below that of least GOSPA with two contacts whose 99 % quantile \
         is within the budget. Timed on this machine ({}); no microcontroller was. Followed contacts \
         leave searches to a second thread; where there is none, a frame in which something new \
         touches takes as long as its search.",
        MetricContext::here(0).machine
    );
    let best: Vec<Option<&Point>> = rows.iter().map(|row| row.best).collect();
    Ok(page_table("Recommended", note, table(&recommended_columns(), &rows), &best)?)
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
    let note = format!(
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
    );
    Ok(page_table("What is left out pays", note, text_table(header, rows), skips)?)
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

const GROWTH_NOTE: &str = "Tubes of a limb's size, one element through the wall; 10 gauges where nothing else is \
    said. Exponent: slope of the logarithms, the smallest third of the sizes left out. \
    Theory: nested dissection of a surface takes n^1.5 operations and n log n entries. Memory: \
    what is kept, the factor's entries and the gauges' fields at every node and on the skin.";
