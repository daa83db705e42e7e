//! What the page's script draws: the limb's triangles and the fields on them.

use hapdef_mesh::SurfaceMesh;
use hapdef_mesh::colour::viridis;
use serde_json::{Value, json};

use super::super::ShellComparison;
use super::super::info::quantile;

/// Colours of the scale.
const N_COLOURS: usize = 48;

/// Coordinates are rounded to this, m.
const POINT_STEP_M: f64 = 1e-5;

/// Differences above this have the last colour, unless most are below.
const LEAST_DIFFERENCE_RANGE: f64 = 0.2;

/// One field over the limb.
pub(super) struct Picture<'a> {
    pub title: &'static str,
    pub unit: &'static str,
    /// Shown values are the map's times this.
    pub factor: f64,
    pub values: &'a [f64],
    pub range: [f64; 2],
}

/// The fields of a comparison: of displacement, then of readings, each of the solid, the shell and
/// their difference. Solid and shell have one scale.
pub(super) fn pictures(comparison: &ShellComparison) -> Vec<Picture<'_>> {
    let maps = &comparison.maps;
    let rows = [
        (
            &maps.tip,
            "µm/N",
            [
                "displacement under the tip: solid",
                "displacement under the tip: shell",
                "displacement: shell from solid",
            ],
        ),
        (
            &maps.readings,
            "µε/N",
            [
                "gauge strain, all gauges: solid",
                "gauge strain, all gauges: shell",
                "gauge strain: shell from solid",
            ],
        ),
    ];
    let of_row = |(fields, unit, titles)| of_row(fields, unit, titles);
    rows.into_iter().flat_map(of_row).collect()
}

fn of_row<'a>(
    fields: &'a [Vec<f64>; 3],
    unit: &'static str,
    titles: [&'static str; 3],
) -> [Picture<'a>; 3] {
    let [solid, shell, difference] = fields.each_ref().map(Vec::as_slice);
    let compared = |values: &[f64]| values.iter().copied().filter(|v| !v.is_nan()).collect();
    let answers: Vec<f64> = [compared(solid), compared(shell)].concat();
    let most = quantile(answers, 0.99);
    let differences: Vec<f64> = compared(difference);
    let far = quantile(differences, 0.95).max(LEAST_DIFFERENCE_RANGE);
    let picture = |title, values, unit, factor, high| Picture {
        title,
        unit,
        factor,
        values,
        range: [0.0, high],
    };
    [
        picture(titles[0], solid, unit, 1.0, most),
        picture(titles[1], shell, unit, 1.0, most),
        picture(titles[2], difference, "%", 100.0, far),
    ]
}

/// The script's data: a palette, and for each comparison the limb with its maps.
pub(super) fn data(comparisons: &[ShellComparison]) -> Value {
    let hex = |i: usize| {
        let [r, g, b] = viridis(i as f64 / (N_COLOURS - 1) as f64);
        format!("#{r:02x}{g:02x}{b:02x}")
    };
    json!({
        "palette": (0..N_COLOURS).map(hex).collect::<Vec<_>>(),
        "limbs": comparisons.iter().map(limb).collect::<Vec<_>>(),
    })
}

fn limb(comparison: &ShellComparison) -> Value {
    let skin = &comparison.skin;
    let steps = |x: f64| (x / POINT_STEP_M).round() as i64;
    let points: Vec<i64> = skin
        .vertices()
        .iter()
        .flat_map(|p| p.coords.map(steps).data.0[0])
        .collect();
    let centre: [f64; 3] = skin.bounding_box().centre().coords.into();
    let map = |picture: &Picture<'_>| {
        let values: Vec<Option<f64>> = picture.values.iter().map(|v| rounded(*v)).collect();
        json!({ "low": picture.range[0], "high": picture.range[1], "values": values })
    };
    json!({
        "up": up(skin),
        "points": points,
        "centre": centre.map(steps),
        "size": size_m(skin).map(steps),
        "triangles": skin.triangles().iter().flatten().collect::<Vec<_>>(),
        "maps": pictures(comparison).iter().map(map).collect::<Vec<_>>(),
    })
}

/// The axis that is drawn upright: the longest.
pub(super) fn up(skin: &SurfaceMesh) -> usize {
    skin.bounding_box().size_m().imax()
}

/// Width and height that hold the limb turned any way about the upright axis, m.
pub(super) fn size_m(skin: &SurfaceMesh) -> [f64; 2] {
    let size = skin.bounding_box().size_m();
    let [a, b] = [1, 2].map(|i| size[(up(skin) + i) % 3]);
    [a.hypot(b), size[up(skin)]]
}

/// Four digits; nothing for what was not compared.
fn rounded(value: f64) -> Option<f64> {
    let text = format!("{value:.3e}");
    text.parse().ok().filter(|v: &f64| v.is_finite())
}
