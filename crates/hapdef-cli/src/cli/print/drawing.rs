//! The places of gauges, drawn 1:1.

use std::fmt::Write as _;

use hapdef::GaugePlace;

/// A sheet of A4 and the cells on it, mm.
const SHEET_MM: [f64; 2] = [210.0, 297.0];
const CELL_MM: [f64; 2] = [64.0, 64.0];
const COLUMNS: usize = 3;
const ROWS: usize = 4;

/// From the sheet's corner to the first cell, mm.
const MARGIN_MM: [f64; 2] = [9.0, 28.0];

/// A rim nearer than this is drawn where it is, mm.
const NEAR_MM: f64 = 24.0;

/// Names of the four ways to a rim, in the order of [`GaugePlace::rims_m`].
const WAYS: [&str; 4] = ["away from the mount", "towards the mount", "left", "right"];

/// One SVG file for every twelve places.
pub(super) fn pages(name: &str, places: &[GaugePlace]) -> Vec<String> {
    places.chunks(COLUMNS * ROWS).map(|places| page(name, places)).collect()
}

/// The distances to the rims in words.
pub(super) fn rims(place: &GaugePlace) -> String {
    let text = |(way, rim): (&str, &Option<f64>)| match rim {
        Some(rim_m) => format!("{way} {:.1}", 1e3 * rim_m),
        None => format!("{way} –"),
    };
    let rims: Vec<String> = WAYS.into_iter().zip(&place.rims_m).map(text).collect();
    // what rounds to -0 is 0
    let turn_deg = (10.0 * place.turn_rad.to_degrees()).round() / 10.0 + 0.0;
    format!("{}; {turn_deg:.1}° to the left of the limb's axis", rims.join(", "))
}

fn page(name: &str, places: &[GaugePlace]) -> String {
    let [width, height] = SHEET_MM;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}mm\" height=\"{height}mm\" \
         viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"3\" fill=\"none\" \
         stroke=\"#000\" stroke-width=\"0.2\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#fff\" stroke=\"none\"/>\n"
    );
    text(&mut svg, [9.0, 10.0], &format!("{name}: places of gauges, 1:1"));
    let hint = "Print at 100 %: this line is 50 mm. Seen from where the gauge is glued; up is away from the mount.";
    text(&mut svg, [9.0, 15.0], hint);
    line(&mut svg, [9.0, 19.0], [59.0, 19.0], 0.4);
    for (i, place) in places.iter().enumerate() {
        let (column, row) = (i % COLUMNS, i / COLUMNS);
        let x = MARGIN_MM[0] + (column as f64 + 0.5) * CELL_MM[0];
        let y = MARGIN_MM[1] + (row as f64 + 0.5) * CELL_MM[1];
        cell(&mut svg, [x, y], place);
    }
    svg.push_str("</svg>\n");
    svg
}

/// A place with its middle at (x, y), the limb's axis upward.
fn cell(svg: &mut String, [x, y]: [f64; 2], place: &GaugePlace) {
    let name = format!("{}, {:.1}°", place.name, place.turn_rad.to_degrees());
    text(svg, [x - 29.0, y - 27.0], &name);
    line(svg, [x, y - NEAR_MM], [x, y + NEAR_MM], 0.1);
    line(svg, [x - NEAR_MM, y], [x + NEAR_MM, y], 0.1);
    let [length, width] = place.size_m.map(|m| 1e3 * m);
    // SVG turns clockwise, and its y goes down.
    let _ = writeln!(
        svg,
        "<g transform=\"translate({x:.3} {y:.3}) rotate({:.3})\"><rect x=\"{:.3}\" y=\"{:.3}\" \
         width=\"{width:.3}\" height=\"{length:.3}\" stroke-width=\"0.3\"/><path d=\"M0 {:.3}V{:.3}l-1 2m1 -2l1 2\" \
         stroke-width=\"0.3\"/></g>",
        -place.turn_rad.to_degrees(),
        -0.5 * width,
        -0.5 * length,
        0.5 * length + 3.0,
        -0.5 * length - 3.0
    );
    let ways = [[0.0, -1.0], [0.0, 1.0], [-1.0, 0.0], [1.0, 0.0]];
    for ([u, v], rim_m) in ways.into_iter().zip(place.rims_m) {
        let Some(rim) = rim_m.map(|m| 1e3 * m) else { continue };
        let at = rim.min(NEAR_MM);
        let (px, py) = (x + u * at, y + v * at);
        if rim <= NEAR_MM {
            line(svg, [px - 4.0 * v, py - 4.0 * u], [px + 4.0 * v, py + 4.0 * u], 0.6);
        }
        text(
            svg,
            [px + 0.8 + 0.3 * v.abs(), py + if v > 0.0 { 3.5 } else { -0.8 }],
            &format!("{rim:.1}"),
        );
    }
}

fn line(svg: &mut String, [x1, y1]: [f64; 2], [x2, y2]: [f64; 2], width: f64) {
    let _ =
        writeln!(svg, "<path d=\"M{x1:.3} {y1:.3}L{x2:.3} {y2:.3}\" stroke-width=\"{width}\"/>");
}

fn text(svg: &mut String, [x, y]: [f64; 2], words: &str) {
    let words = words.replace('&', "&amp;").replace('<', "&lt;");
    let _ = writeln!(
        svg,
        "<text x=\"{x:.3}\" y=\"{y:.3}\" fill=\"#000\" stroke=\"none\">{words}</text>"
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(name: &str) -> GaugePlace {
        GaugePlace {
            name: name.into(),
            size_m: [0.008, 0.005],
            turn_rad: 0.5,
            rims_m: [Some(0.012), Some(0.05), None, Some(0.02)],
        }
    }

    #[test]
    fn a_sheet_is_a4_and_drawn_1_to_1() {
        let sheets = pages("a & b", &vec![place("g0"); 13]);
        assert_eq!(sheets.len(), 2);
        assert!(sheets[0].contains("width=\"210mm\" height=\"297mm\" viewBox=\"0 0 210 297\""));
        assert!(
            sheets[0].contains("a &amp; b") && sheets[0].contains("M9.000 19.000L59.000 19.000")
        );
        // The first cell's middle is at (41, 60): its rims at 12 mm above and 20 mm to the right.
        assert!(sheets[1].contains("M45.000 48.000L37.000 48.000"), "{}", sheets[1]);
        assert!(sheets[1].contains("M61.000 56.000L61.000 64.000"), "{}", sheets[1]);
        assert!(sheets[1].contains("width=\"5.000\" height=\"8.000\""));
        assert!(sheets[1].contains(">50.0</text>") && !sheets[1].contains("–"));
    }

    #[test]
    fn rims_are_said_in_words() {
        let words = rims(&place("g0"));
        assert_eq!(
            words,
            "away from the mount 12.0, towards the mount 50.0, left –, right 20.0; 28.6° to the left of the limb's axis"
        );
        let along = rims(&GaugePlace { turn_rad: -1e-9, ..place("g0") });
        assert!(along.ends_with("; 0.0° to the left of the limb's axis"), "{along}");
    }
}
