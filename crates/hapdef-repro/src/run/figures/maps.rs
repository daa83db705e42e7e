//! Maps on the limb: figures 3, 5B, 6, 7 and 9A.

use anyhow::Result;
use hapdef::Limb;
use hapdef_report::{Figure, LimbMarker, Mark};

use super::super::examples::Example;
use super::surface::{Panel, Surface, marks};

/// Figures that show the limb from two sides: what stands above, and where the viewer stands, rad.
const SIDES: [(&str, f64); 2] = [
    ("seen from 30°", std::f64::consts::FRAC_PI_6),
    ("seen from 210°", std::f64::consts::FRAC_PI_6 + std::f64::consts::PI),
];

/// Figure 3: displacement for the same force everywhere.
pub(super) fn rigidity(surface: &Surface, um_per_n: &[f64]) -> Result<Vec<Figure>> {
    let panel =
        |title| Panel { title, label: "µm per N", values: um_per_n, range: None, marks: &[] };
    Ok(vec![
        surface.renders(
            "rigidity-limb.svg",
            "Figure 3: displacement of each surface node for one newton on itself, µm; lighter \
             is softer. Two sides.",
            &SIDES.map(|(title, side)| (panel(title), side)),
        )?,
        surface.unrolled(
            "rigidity.svg",
            "Figure 3, unrolled.",
            &[panel("one newton on each node in turn")],
        )?,
    ])
}

/// Figure 5B: the virtual gauges around each gauge's centre.
pub(super) fn patches(surface: &Surface, limb: &Limb) -> Result<Vec<Figure>> {
    let grey = vec![f64::NAN; surface.positions.len()];
    let nodes = limb.patches.iter().flat_map(|patch| &patch.nodes);
    let nodes = nodes.map(|node| limb.mesh.nodes()[node.index()].coords.into());
    let mut shown = marks(nodes, Mark::Dot);
    let centres = limb.sites.iter().map(|site| site.position.coords.into());
    shown.extend(marks(centres, Mark::Gauge));
    let panel =
        |title| Panel { title, label: "", values: &grey, range: Some([0.0, 1.0]), marks: &shown };
    Ok(vec![
        surface.renders(
            "figure5b-limb.svg",
            "Figure 5B: gauges (yellow) and their virtual gauges (blue dots); faint on the far \
             side. Two sides.",
            &SIDES.map(|(title, side)| (panel(title), side)),
        )?,
        surface.unrolled("figure5b.svg", "Figure 5B, unrolled.", &[panel("")])?,
    ])
}

/// True map, predicted map and their difference, unrolled and on the limb.
pub(super) fn example(surface: &Surface, example: &Example) -> Result<Vec<Figure>> {
    let difference: Vec<f64> = example
        .truth_um
        .iter()
        .zip(&example.found_um)
        .map(|(truth, found)| (found - truth).abs())
        .collect();
    let truth = marks(example.truth.iter().map(|c| c.0), Mark::True);
    let candidates = marks(example.candidates.iter().map(|c| c.position_m), Mark::Dot);
    let picked = marks(example.picked.iter().map(|c| c.position_m), Mark::Found);
    let all: Vec<LimbMarker> = [&truth[..], &candidates, &picked].concat();
    let largest = example.truth_um.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let panel = |title: &'static str, values, marks| Panel {
        title,
        label: "µm",
        values,
        range: Some([0.0, largest]),
        marks,
    };
    let towards = match truth.first() {
        Some(first) => surface.unroll(&[first.position])?[0][0],
        None => SIDES[0].1,
    };
    let caption = format!(
        "{}. Rings: true contacts; dots: candidates; crosses: those picked.",
        example.caption
    );
    Ok(vec![
        surface.unrolled(
            &format!("{}.svg", example.stem),
            &caption,
            &[
                panel("true map", &example.truth_um, &truth),
                panel("predicted map", &example.found_um, &all),
                panel("|difference|", &difference, &truth),
            ],
        )?,
        surface.renders(
            &format!("{}-limb.svg", example.stem),
            "The same on the limb.",
            &[
                (panel("true map", &example.truth_um, &truth), towards),
                (panel("predicted map", &example.found_um, &all), towards),
            ],
        )?,
    ])
}
