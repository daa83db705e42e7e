//! A limb with fields as colours: what the page's script draws.

use hapdef_mesh::SurfaceMesh;
use hapdef_mesh::colour::viridis;
use serde_json::{Value, json};

use crate::text::escape_html as escape;

/// Colours of the scale.
const N_COLOURS: usize = 48;

/// Coordinates are rounded to this, m.
const POINT_STEP_M: f64 = 1e-5;

/// Longer side of a drawing, pixels; drawn at twice that for print.
const DRAWING_PX: f64 = 250.0;

/// Height of the strip below a drawing that has the length bar, at the drawing's doubled size.
const RULER_PX: usize = 46;

/// Boxes of the colour bar, and the width of one, pixels.
const N_BOXES: usize = 24;
const BOX_PX: usize = 10;

/// A limb, fields on it, and marked places.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LimbView {
    /// Vertices, m.
    pub points_m: Vec<[f64; 3]>,
    /// Triangles, seen from outside counter-clockwise.
    pub triangles: Vec<[u32; 3]>,
    /// The fields, each drawn from four sides.
    pub maps: Vec<LimbMap>,
    /// Places that get a numbered ring, such as gauges, m.
    pub marks_m: Vec<[f64; 3]>,
}

/// A field on a limb.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LimbMap {
    /// What it is.
    pub title: String,
    /// Unit of what is shown.
    pub unit: String,
    /// Shown values are the map's times this.
    pub factor: f64,
    /// A value for each vertex; NaN is grey.
    pub values: Vec<f64>,
    /// Values of the first and of the last colour.
    pub range: [f64; 2],
}

impl LimbView {
    /// A surface, fields with a value for each of its vertices, and marked places.
    #[must_use]
    pub fn new(surface: &SurfaceMesh, maps: Vec<LimbMap>, marks_m: Vec<[f64; 3]>) -> Self {
        Self {
            points_m: surface.vertices().iter().map(|p| p.coords.into()).collect(),
            triangles: surface.triangles().to_vec(),
            maps,
            marks_m,
        }
    }

    /// Its elements; `number` is its place among the page's limbs.
    pub(super) fn html(&self, number: usize) -> String {
        let maps = self.maps.iter().enumerate();
        let figures: String = maps.map(|(i, map)| self.figure(number, i, map)).collect();
        figures + &self.turnable(number)
    }

    /// The four sides, seen with the long axis upright.
    fn figure(&self, number: usize, at: usize, map: &LimbMap) -> String {
        let names = ["x", "y", "z"];
        let [a, b] = [1, 2].map(|i| names[(self.up() + i) % 3]);
        let [width, height] = self.pixels();
        let height = height + RULER_PX;
        let sides = [("front", "+", b), ("left", "+", a), ("back", "−", b), ("right", "−", a)];
        let view = |(turn, (side, sign, axis))| {
            format!(
                "<div><canvas data-limb=\"{number}\" data-map=\"{at}\" data-turn=\"{turn}\" \
                 width=\"{width}\" height=\"{height}\" role=\"img\" aria-label=\"{}, {side}\"></canvas>\
                 <br/>{side}, from {sign}{axis}</div>",
                escape(&map.title)
            )
        };
        let views: String = (0..).zip(sides).map(view).collect();
        format!(
            "<figure><figcaption>{}, {}{}</figcaption><div class=\"views\">{views}</div></figure>\n",
            escape(&map.title),
            escape(&map.unit),
            map.scale()
        )
    }

    fn turnable(&self, number: usize) -> String {
        let option = |(i, map): (usize, &LimbMap)| {
            let (title, unit) = (escape(&map.title), escape(&map.unit));
            format!("<option value=\"{i}\">{title}, {unit}</option>")
        };
        let options: String = self.maps.iter().enumerate().map(option).collect();
        let side = self.pixels().into_iter().max().unwrap_or_default();
        let height = side + RULER_PX;
        format!(
            "<figure class=\"screen\"><figcaption>Drag or arrow keys turn, wheel or + and − zoom: \
             <select aria-label=\"field\">{options}</select></figcaption><canvas class=\"turn\" \
             data-limb=\"{number}\" width=\"{side}\" height=\"{height}\" tabindex=\"0\" role=\"img\" \
             aria-label=\"The limb. Arrow keys turn it, plus and minus zoom.\"></canvas></figure>\n"
        )
    }

    /// The axis that is drawn upright: the longest.
    fn up(&self) -> usize {
        let size = self.extent(|low, high| high - low);
        (0..3).max_by(|i, j| size[*i].total_cmp(&size[*j])).unwrap_or_default()
    }

    fn extent(&self, of: impl Fn(f64, f64) -> f64) -> [f64; 3] {
        [0, 1, 2].map(|axis| {
            let along = || self.points_m.iter().map(|p| p[axis]);
            let (low, high) = (along().reduce(f64::min), along().reduce(f64::max));
            of(low.unwrap_or_default(), high.unwrap_or_default())
        })
    }

    /// Width and height that hold the limb turned any way about the upright axis, m.
    fn size_m(&self) -> [f64; 2] {
        let size = self.extent(|low, high| high - low);
        let [a, b] = [1, 2].map(|i| size[(self.up() + i) % 3]);
        [a.hypot(b), size[self.up()]]
    }

    fn pixels(&self) -> [usize; 2] {
        let size = self.size_m();
        let longer = size[0].max(size[1]).max(f64::MIN_POSITIVE);
        size.map(|s| (2.0 * DRAWING_PX * s / longer).ceil() as usize)
    }

    fn data(&self) -> Value {
        let steps = |x: f64| (x / POINT_STEP_M).round() as i64;
        let flat = |points: &[[f64; 3]]| -> Vec<i64> {
            points.iter().flatten().map(|x| steps(*x)).collect()
        };
        json!({
            "up": self.up(),
            "points": flat(&self.points_m),
            "marks": flat(&self.marks_m),
            "centre": self.extent(|low, high| 0.5 * (low + high)).map(steps),
            "size": self.size_m().map(steps),
            "triangles": self.triangles.iter().flatten().collect::<Vec<_>>(),
            "maps": self.maps.iter().map(LimbMap::data).collect::<Vec<_>>(),
        })
    }
}

impl LimbMap {
    fn data(&self) -> Value {
        let values: Vec<Option<f64>> = self.values.iter().map(|v| rounded(*v)).collect();
        json!({ "low": self.range[0], "high": self.range[1], "values": values })
    }

    /// The colours with numbers below.
    fn scale(&self) -> String {
        let box_of = |i: usize| {
            let [r, g, b] = viridis((i as f64 + 0.5) / N_BOXES as f64);
            format!(
                "<rect x=\"{}\" width=\"{BOX_PX}\" height=\"10\" fill=\"#{r:02x}{g:02x}{b:02x}\"/>",
                i * BOX_PX
            )
        };
        let tick = |i: usize| {
            let part = i as f64 / 4.0;
            let [low, high] = self.range;
            let value = digits(self.factor * (low + part * (high - low)));
            let anchor = ["start", "middle", "middle", "middle", "end"][i];
            let x = part * (N_BOXES * BOX_PX) as f64;
            format!("<text x=\"{x}\" y=\"22\" text-anchor=\"{anchor}\">{value}</text>")
        };
        let boxes: String = (0..N_BOXES).map(box_of).collect();
        let ticks: String = (0..5).map(tick).collect();
        format!(
            "<svg class=\"scale\" width=\"{0}\" height=\"26\" viewBox=\"0 0 {0} 26\">{boxes}{ticks}</svg>",
            N_BOXES * BOX_PX
        )
    }
}

/// The script's data: a palette, and the limbs.
pub(super) fn data(limbs: &[&LimbView]) -> Value {
    let hex = |i: usize| {
        let [r, g, b] = viridis(i as f64 / (N_COLOURS - 1) as f64);
        format!("#{r:02x}{g:02x}{b:02x}")
    };
    json!({
        "palette": (0..N_COLOURS).map(hex).collect::<Vec<_>>(),
        "step_mm": POINT_STEP_M * 1e3,
        "ruler_px": RULER_PX,
        "limbs": limbs.iter().map(|limb| limb.data()).collect::<Vec<_>>(),
    })
}

/// Four digits; nothing for what has no value.
fn rounded(value: f64) -> Option<f64> {
    let text = format!("{value:.3e}");
    text.parse().ok().filter(|v: &f64| v.is_finite())
}

fn digits(value: f64) -> String {
    match value.abs() {
        a if a >= 100.0 || a == 0.0 => format!("{value:.0}"),
        a if a >= 10.0 => format!("{value:.1}"),
        _ => format!("{value:.2}"),
    }
}
