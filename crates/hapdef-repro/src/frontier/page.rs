//! The frontier as METRIC lines, tables, plots and a page.

use anyhow::Result;
use hapdef::Run;
use hapdef_report::{
    Figure, FigureContent, LineChart, MetricLog, NamedText, Report, ReportTable, Series,
    SkippedStage, TextCell, TextTable, lines_svg, write_report,
};

use super::point::{Family, Point, best_within, error_mm, on_front, table};
use super::scaling::Growth;
use super::skips::{Compared, Skips};
use super::{ChainFrontierArgs, Measured, limits, planned};
use crate::run::facts;
use crate::run::summary::terminal_table;

/// Budgets of a frame, µs, and who has them.
const BUDGETS: [(&str, f64); 3] = [
    ("100 µs, as a microcontroller has", 100.0),
    ("1 ms", 1000.0),
    ("offline", f64::INFINITY),
];

const NOTE: &str = "Simulated: the scene's rig, another and perturbed mesh, with noise and \
    converter. Mesh: the limb's own solid, each element of it cut into eight, or a shell of its skin \
    without ribs and rings. One and two contacts, matched one to one: mean error of position, mm, and force, N; \
    share of the contacts of two within 10 mm; by superposition the number of contacts is estimated, \
    the paper's chain is given it. Map: mean error of the displacement of the whole skin. Times are \
    those of frames of two contacts on one core, the median of three rounds' medians ± half their \
    range; every way is measured beside the usual one (searched, refined mesh, the scene's gauges, \
    300 presses) and scaled by it, so that a slow hour does not count. Followed: two contacts that \
    come one after the other, searches left to a second thread. Design: solves, calibration or \
    training, preparation. Front: no other way is both faster and nearer.";

/// Prints the figures and writes `frontier/` under the scene's folder.
pub(super) fn write(args: &ChainFrontierArgs, run: &Run, measured: &Measured) -> Result<()> {
    let mut log = MetricLog::new(std::io::stdout(), facts::metric_context_of(args.test_seed));
    metrics(measured, &mut log)?;
    let report = Report {
        title: format!("hapdef: error against run time, {}", run.scene.name),
        scene: run.scene.name.clone(),
        profile: run.profile.name.clone(),
        seed: args.test_seed,
        facts: facts_of(args, run, measured),
        tables: tables(measured)?,
        figures: figures(measured)?,
        metrics: log.records().to_vec(),
        skipped: skipped(args, measured),
        hashes: facts::input_hashes(run)?,
        ..Report::default()
    };
    for table in &report.tables {
        println!("{}\n{}", table.title, terminal_table(&table.text));
    }
    let folder = args.scene.out.join(&run.scene.name).join("frontier");
    let paths = write_report(&folder, &report)?;
    hapdef::write_json(&folder.join("frontier.json"), measured)?;
    log.append_to(&args.scene.out.join("metrics.json"))?;
    if let Some(path) = &args.write {
        limits::write(path, args, run, &report, &measured.points)?;
    }
    for path in paths.iter().rev().take(3) {
        println!("{}", path.display());
    }
    Ok(())
}

fn metrics(measured: &Measured, log: &mut MetricLog<std::io::Stdout>) -> Result<()> {
    log.value("frontier.points", measured.points.len() as f64, "1")?;
    match planned::worst_ratio(&measured.planned) {
        Some(ratio) => log.value("frontier.plan_time_ratio_worst", ratio, "1")?,
        None => log.skipped("frontier.plan_time_ratio_worst", "--without-nets")?,
    }
    let skips = &measured.skips;
    log.value("frontier.design_speedup", skips.design_speedup(), "1")?;
    log.value("frontier.frame_speedup", skips.followed.speedup(), "1")?;
    for growth in &measured.growths {
        let name = match (growth.with, growth.theory) {
            ("nodes", "1.5") => "frontier.factor_exponent",
            ("nodes", "0") => "frontier.frame_nodes_exponent",
            ("gauges", _) => "frontier.frame_gauges_exponent",
            _ => continue,
        };
        log.value(name, growth.exponent, "1")?;
    }
    Ok(())
}

fn facts_of(args: &ChainFrontierArgs, run: &Run, measured: &Measured) -> Vec<NamedText> {
    let mut facts = facts::of_run(run);
    let named = |name: &str, text: String| NamedText {
        name: name.into(),
        text,
    };
    facts.push(named(
        "frames",
        format!(
            "{} of one contact and as many of two, seed {}, on which nothing was tuned",
            args.frames, args.test_seed
        ),
    ));
    facts.push(named(
        "budget",
        format!(
            "{} minutes: {} ways by superposition of {}",
            args.minutes,
            measured
                .points
                .iter()
                .filter(|p| p.family != Family::Chain)
                .count(),
            measured.n_ways
        ),
    ));
    facts
}

fn skipped(args: &ChainFrontierArgs, measured: &Measured) -> Vec<SkippedStage> {
    let mut skipped = Vec::new();
    let mut skip = |name: &str, reason: String| {
        skipped.push(SkippedStage {
            name: name.into(),
            reason,
        });
    };
    if args.without_nets {
        skip("the paper's chain, plan", "--without-nets".into());
    }
    let n = measured.points.iter().filter(|p| p.family != Family::Chain);
    let n_left = measured.n_ways - n.count();
    if n_left > 0 {
        let reason = format!("{} minutes are over; more go on from here", args.minutes);
        skip(&format!("{n_left} further ways"), reason);
    }
    skipped
}

fn tables(measured: &Measured) -> Result<Vec<ReportTable>> {
    let mut tables = vec![
        recommended(&measured.points)?,
        ReportTable {
            title: "Every way from readings to contacts".into(),
            note: NOTE.into(),
            text: table(&measured.points),
            data: serde_json::to_value(&measured.points)?,
        },
        skips_table(&measured.skips)?,
        growth_table(&measured.growths)?,
    ];
    if !measured.planned.is_empty() {
        tables.push(planned::table(&measured.planned)?);
    }
    Ok(tables)
}

/// The way of least error within each budget.
fn recommended(points: &[Point]) -> Result<ReportTable> {
    let header = [
        "a frame's budget",
        "way",
        "two: mean, mm",
        "p99, µs",
        "design, s",
    ];
    let best = |(name, budget_us): &(&str, f64)| {
        let best = best_within(points, *budget_us, error_mm);
        let cells = match best {
            Some(p) => [
                (*name).to_owned(),
                p.name.clone(),
                format!("{:.2}", error_mm(p)),
                format!("{:.0}", p.frame.p99_us),
                format!("{:.1}", p.design.all_s()),
            ],
            None => [*name, "none", "–", "–", "–"].map(str::to_owned),
        };
        cells.map(TextCell::plain).to_vec()
    };
    let chosen = BUDGETS.map(|(_, budget)| best_within(points, budget, error_mm));
    Ok(ReportTable {
        title: "Recommended".into(),
        note:
            "Of the ways below that of least mean error with two contacts whose 99 % quantile is \
               within the budget, on this machine."
                .into(),
        text: TextTable {
            header: header.map(str::to_owned).to_vec(),
            rows: BUDGETS.iter().map(best).collect(),
        },
        data: serde_json::to_value(chosen)?,
    })
}

fn skips_table(skips: &Skips) -> Result<ReportTable> {
    let header = ["", "everything", "single contacts", "times faster"];
    let row = |name: &str, full: String, lean: String, ratio: f64| {
        let cells = [name.to_owned(), full, lean, format!("{ratio:.1}")];
        cells.map(TextCell::plain).to_vec()
    };
    let frame_row = |name: &str, both: &Compared| {
        let (full, lean) = (both.full_us, both.lean_us);
        row(
            name,
            format!("{full:.1}"),
            format!("{lean:.1}"),
            both.speedup(),
        )
    };
    Ok(ReportTable {
        title: "What is left out pays".into(),
        note: format!(
            "The scene as it is, with the displacement of the whole skin, and the same with \
             contact.max_contacts 1 and contacts alone, on frames of one contact. Searched, nothing \
             known before: of {} answers the first finds one contact in {}, both the same to rounding \
             in {}. Followed, as in live use: {}, {}, {}.",
            skips.searched.n,
            skips.searched.n_single,
            skips.searched.n_equal,
            skips.followed.n,
            skips.followed.n_single,
            skips.followed.n_equal
        ),
        text: TextTable {
            header: header.map(str::to_owned).to_vec(),
            rows: vec![
                row(
                    "design, s",
                    format!("{:.2}", skips.full_design_s),
                    format!("{:.2}", skips.lean_design_s),
                    skips.design_speedup(),
                ),
                frame_row("a frame that is searched, µs", &skips.searched),
                frame_row("a frame of a contact that is followed, µs", &skips.followed),
            ],
        },
        data: serde_json::to_value(skips)?,
    })
}

fn growth_table(growths: &[Growth]) -> Result<ReportTable> {
    let header = ["", "with", "exponent", "theory", "measured"];
    let row = |g: &Growth| {
        let points = g.points.iter().map(|(x, y)| format!("{x:.0}: {y:.3}"));
        let points: Vec<String> = points.collect();
        let cells = [
            g.what.clone(),
            g.with.to_owned(),
            format!("{:.2}", g.exponent),
            g.theory.to_owned(),
            points.join(" · "),
        ];
        cells.map(TextCell::plain).to_vec()
    };
    Ok(ReportTable {
        title: "How times grow".into(),
        note:
            "Tubes of a limb's size, one element through the wall; 10 gauges where nothing else is \
               said. Exponent: slope of the logarithms over the larger half of the sizes. Theory: \
               nested dissection of a surface takes n^1.5 operations and n log n entries."
                .into(),
        text: TextTable {
            header: header.map(str::to_owned).to_vec(),
            rows: growths.iter().map(row).collect(),
        },
        data: serde_json::to_value(growths)?,
    })
}

fn figures(measured: &Measured) -> Result<Vec<Figure>> {
    let mut figures = vec![Figure {
        file: "frontier.svg".into(),
        caption: "Mean position error with two contacts against the time of a frame. Line: the \
                  front."
            .into(),
        content: FigureContent::Svg(lines_svg(&cloud(&measured.points))?),
    }];
    for with in ["nodes", "gauges", "contacts", "frames"] {
        let series: Vec<Series> = measured
            .growths
            .iter()
            .filter(|g| g.with == with)
            .map(|g| Series {
                name: g.what.clone(),
                points: g.points.iter().map(|(x, y)| (x.log10(), *y)).collect(),
            })
            .collect();
        let chart = LineChart {
            title: format!("Growth with {with}"),
            x_label: format!("log₁₀ of the number of {with}"),
            y_label: "as named".into(),
            log_y: true,
            dots: true,
            series,
        };
        figures.push(Figure {
            file: format!("growth-{with}.svg"),
            caption: format!("How times grow with {with}."),
            content: FigureContent::Svg(lines_svg(&chart)?),
        });
    }
    Ok(figures)
}

fn cloud(points: &[Point]) -> LineChart {
    let at = |p: &Point| (p.frame.p50_us.log10(), error_mm(p));
    let dots = |family: Family, name: &str| Series {
        name: name.into(),
        // what is not finite breaks the line
        points: points
            .iter()
            .filter(|p| p.family == family)
            .flat_map(|p| [at(p), (f64::NAN, f64::NAN)])
            .collect(),
    };
    let is_front = on_front(points, error_mm);
    let mut front: Vec<(f64, f64)> = points
        .iter()
        .zip(is_front)
        .filter(|(_, is_front)| *is_front)
        .map(|(p, _)| at(p))
        .collect();
    front.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut series = vec![
        Series {
            name: "front".into(),
            points: front,
        },
        dots(Family::Searched, "superposition"),
        dots(Family::Followed, "followed"),
        dots(Family::Chain, "the paper's chain"),
    ];
    series.retain(|s| !s.points.is_empty());
    LineChart {
        title: "Position error against run time".into(),
        x_label: "log₁₀ of the median time of a frame in µs".into(),
        y_label: "mean position error of two contacts, mm".into(),
        log_y: true,
        dots: true,
        series,
    }
}
