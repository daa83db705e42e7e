//! The page: verdicts, parameters, tables, the limb from four sides.

use super::super::{Answered, GOOD_DIFFERENCE, ShellComparison, ShellLimb, ShellVerdict};
use super::pictures::{Picture, data, pictures, size_m, up};
use super::{Fact, ReportSource};
use hapdef_mesh::colour::viridis;

const STYLE: &str = include_str!("page.css");

const SCRIPT: &str = include_str!("page.js");

/// Longer side of a drawing, pixels; drawn at twice that for print.
const DRAWING_PX: f64 = 250.0;

/// The whole page.
pub(super) fn page(
    limb: &ShellLimb,
    source: &ReportSource,
    facts: &[Fact],
    comparisons: &[ShellComparison],
) -> String {
    let title = format!("Shell against solid: {}", escape(&source.file));
    let facts: String = facts.iter().map(|(name, text)| fact(name, text)).collect();
    let sections: String = comparisons.iter().enumerate().map(section).collect();
    // The data are numbers and colours: nothing in them ends the script element.
    let data = data(comparisons);
    format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\"/>\n\
         <title>{title}</title>\n<style>\n{STYLE}</style></head>\n<body>\n<h1>{title}</h1>\n\
         <dl>{facts}{}</dl>\n{sections}\
         <script type=\"application/json\" id=\"data\">{data}</script>\n\
         <script>\n//<![CDATA[\n{SCRIPT}//]]>\n</script>\n</body></html>\n",
        fact("thin wall", &limb.thin_wall().to_string())
    )
}

fn fact(name: &str, text: &str) -> String {
    format!("<dt>{}</dt><dd>{}</dd>", escape(name), escape(text))
}

fn section((number, comparison): (usize, &ShellComparison)) -> String {
    let pictures = pictures(comparison);
    let figures: String = (0..)
        .zip(&pictures)
        .map(|(map, picture)| figure(number, map, picture, comparison))
        .collect();
    format!(
        "<h2>Against {}</h2>\n{}{}{}{figures}{}{}",
        escape(&comparison.solid),
        verdict(comparison),
        medians(comparison),
        shares(comparison),
        turnable(number, &pictures, comparison),
        gauges(comparison)
    )
}

fn verdict(comparison: &ShellComparison) -> String {
    let (class, text) = match comparison.recommendation() {
        Some(text) => (" solid", text),
        None if comparison.verdict == ShellVerdict::SolidTooCoarse => (
            "",
            "no verdict: the solid itself changes by more than 10 % when its edges are halved"
                .into(),
        ),
        None if comparison.coarser_solid.is_some() => ("", "the shell is good here".into()),
        None => (
            "",
            "the shell is good here, as far as this solid is fine enough".into(),
        ),
    };
    format!("<p class=\"verdict{class}\">{}</p>\n", escape(&text))
}

fn medians(comparison: &ShellComparison) -> String {
    let mut rows = rows_of("shell", &comparison.shell);
    if let Some(coarser) = &comparison.coarser_solid {
        rows += &rows_of("solid, edges twice as long", coarser);
    }
    format!(
        "<table><tr><th>from the solid</th><th>median %</th><th>worst %</th><th>overall %</th>\
         <th>ratio, median</th></tr>{rows}</table>\n"
    )
}

fn rows_of(who: &str, answered: &Answered) -> String {
    [("gauge strain", &answered.readings), ("displacement", &answered.tip)]
        .map(|(what, d)| {
            format!(
                "<tr><td>{who}: {what}</td><td>{:.1}</td><td>{:.1}</td><td>{:.1}</td><td>{:.3}</td></tr>",
                100.0 * d.median,
                100.0 * d.worst,
                100.0 * d.overall,
                d.median_ratio
            )
        })
        .concat()
}

fn shares(comparison: &ShellComparison) -> String {
    let above = &comparison.above_good;
    format!(
        "<p>Off by more than {:.0} %: {:.1} % of the compared surface by displacement ({} presses), \
         {:.1} % by gauge strain ({} places). {} FE nodes, {} equations. Each place has a newton of \
         its own; the map shows the answer at the nearest place. Dark grey: not compared, held or \
         not wholly on the shell ({} places). Light grey: the inner side.</p>\n",
        100.0 * GOOD_DIFFERENCE,
        100.0 * above.tip_share,
        comparison.presses.len(),
        100.0 * above.readings_share,
        comparison.n_touches,
        comparison.n_fe_nodes,
        comparison.n_equations,
        comparison.n_touches_left_out
    )
}

/// The four sides, seen with the long axis upright.
fn figure(limb: usize, map: usize, picture: &Picture<'_>, comparison: &ShellComparison) -> String {
    let names = ["x", "y", "z"];
    let [a, b] = [1, 2].map(|i| names[(up(&comparison.skin) + i) % 3]);
    let [width, height] = pixels(comparison);
    let sides = [
        ("front", "+", b),
        ("left", "+", a),
        ("back", "−", b),
        ("right", "−", a),
    ];
    let views: String = (0..)
        .zip(sides)
        .map(|(turn, (side, sign, axis))| {
            format!(
                "<div><canvas data-limb=\"{limb}\" data-map=\"{map}\" data-turn=\"{turn}\" \
                 width=\"{width}\" height=\"{height}\"></canvas><br/>{side}, from {sign}{axis}</div>"
            )
        })
        .collect();
    format!(
        "<figure><figcaption>{}, {}{}</figcaption><div class=\"views\">{views}</div></figure>\n",
        picture.title,
        picture.unit,
        scale(picture)
    )
}

fn pixels(comparison: &ShellComparison) -> [usize; 2] {
    let size = size_m(&comparison.skin);
    let longer = size[0].max(size[1]).max(f64::MIN_POSITIVE);
    size.map(|s| (2.0 * DRAWING_PX * s / longer).ceil() as usize)
}

/// The colours with numbers below.
fn scale(picture: &Picture<'_>) -> String {
    const N: usize = 24;
    const STEP: usize = 10;
    let box_of = |i: usize| {
        let [r, g, b] = viridis((i as f64 + 0.5) / N as f64);
        format!(
            "<rect x=\"{}\" width=\"{STEP}\" height=\"10\" fill=\"#{r:02x}{g:02x}{b:02x}\"/>",
            i * STEP
        )
    };
    let tick = |i: usize| {
        let part = i as f64 / 4.0;
        let [low, high] = picture.range;
        let value = picture.factor * (low + part * (high - low));
        let anchor = ["start", "middle", "middle", "middle", "end"][i];
        let x = part * (N * STEP) as f64;
        format!(
            "<text x=\"{x}\" y=\"22\" text-anchor=\"{anchor}\">{}</text>",
            digits(value)
        )
    };
    let boxes: String = (0..N).map(box_of).collect();
    let ticks: String = (0..5).map(tick).collect();
    format!(
        "<svg class=\"scale\" width=\"{0}\" height=\"26\" viewBox=\"0 0 {0} 26\">{boxes}{ticks}</svg>",
        N * STEP
    )
}

fn turnable(limb: usize, pictures: &[Picture<'_>], comparison: &ShellComparison) -> String {
    let option = |(map, picture): (usize, &Picture<'_>)| {
        format!(
            "<option value=\"{map}\">{}, {}</option>",
            picture.title, picture.unit
        )
    };
    let options: String = (0..).zip(pictures).map(option).collect();
    let side = pixels(comparison).into_iter().max().unwrap_or_default();
    format!(
        "<figure class=\"screen\"><figcaption>Drag to turn: <select>{options}</select></figcaption>\
         <canvas class=\"turn\" data-limb=\"{limb}\" width=\"{side}\" height=\"{side}\"></canvas></figure>\n"
    )
}

/// Each gauge where the solid's reads most, as numbers and bars; the difference is over all places.
fn gauges(comparison: &ShellComparison) -> String {
    const FULL_PX: f64 = 160.0;
    let largest = comparison
        .gauges
        .iter()
        .flat_map(|g| [g.solid_ue_per_n.abs(), g.shell_ue_per_n.abs()])
        .fold(f64::MIN_POSITIVE, f64::max);
    let bar = |y: usize, value: f64, t: f64| {
        let [r, g, b] = viridis(t);
        format!(
            "<rect y=\"{y}\" width=\"{:.1}\" height=\"6\" fill=\"#{r:02x}{g:02x}{b:02x}\"/>",
            FULL_PX * value.abs() / largest
        )
    };
    let rows: String = (0..)
        .zip(&comparison.gauges)
        .map(|(i, g)| {
            let [x, y, z] = g.position_m.map(|c| 1e3 * c);
            format!(
                "<tr><td>g{i}</td><td>{x:.1} {y:.1} {z:.1}</td><td>{:.1}</td><td>{:.1}</td>\
                 <td>{:.1}</td><td><svg width=\"{FULL_PX}\" height=\"14\">{}{}</svg></td></tr>",
                g.solid_ue_per_n,
                g.shell_ue_per_n,
                100.0 * g.difference,
                bar(0, g.solid_ue_per_n, 0.25),
                bar(7, g.shell_ue_per_n, 0.75)
            )
        })
        .collect();
    format!(
        "<h3>Gauges</h3><table><tr><th>gauge</th><th>at, mm</th><th>solid µε/N</th>\
         <th>shell µε/N</th><th>difference %</th><th>solid above, shell below</th></tr>{rows}</table>\n\
         <p>Readings are for a newton where the solid's gauge reads most; differences are over all \
         {} places.</p>\n",
        comparison.n_touches
    )
}

fn digits(value: f64) -> String {
    match value.abs() {
        a if a >= 100.0 || a == 0.0 => format!("{value:.0}"),
        a if a >= 10.0 => format!("{value:.1}"),
        _ => format!("{value:.2}"),
    }
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}
