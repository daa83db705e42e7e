//! The report's figures, in the paper's order.

mod errors;
mod maps;
mod surface;

use std::path::Path;

use anyhow::Result;
use hapdef::{ComplianceTable, Limb, Pipeline};
use hapdef_bench::dotted_lines;
use hapdef_mesh::{VertexField, write_glb};
use hapdef_report::{Figure, LimbMap, LimbView, LineChart, Series};
use serde_json::Value;

use self::surface::Surface;
use super::examples::{Example, examples};
use super::made::Made;
use crate::tables::table1_bars;

/// Makes every figure.
pub(crate) fn figures(made: &Made<'_>) -> Result<Vec<Figure>> {
    let examples = examples(made.run, made.limb, made.done)?;
    let surface = Surface::of(made.limb)?;
    let mut figures = maps::rigidity(&surface, &self_compliance(made.limb, made.done)?)?;
    figures.push(errors::figure_4a(&made.singles)?);
    figures.push(errors::figure_4b(&surface, &made.singles)?);
    if let Some(sizes) = &made.sizes {
        figures.extend(errors::figure_5a(sizes)?);
    }
    figures.extend(maps::patches(&surface, made.limb)?);
    let (doubles, others): (Vec<&Example>, Vec<&Example>) =
        examples.iter().partition(|example| example.stem.starts_with("figure9"));
    for example in others {
        figures.extend(maps::example(&surface, example)?);
    }
    let strongest_n = made.strongest_n();
    figures.extend(errors::figure_8(&made.singles, strongest_n)?);
    for example in doubles {
        figures.extend(maps::example(&surface, example)?);
    }
    figures.extend(errors::figure_9(&made.chain, &made.frames.rig_double, strongest_n)?);
    figures.push(Figure::bars(
        "table1.svg",
        "Table 1, mean absolute error, ours beside the paper's.",
        &table1_bars(&made.table1[0]),
    )?);
    figures.push(training_curves(made.done)?);
    Ok(figures)
}

/// Writes the skin with the rigidity map as vertex colours, for any glTF viewer.
pub(crate) fn write_surface(path: &Path, limb: &Limb, done: &Pipeline) -> Result<()> {
    let values = self_compliance(limb, done)?;
    let field = VertexField { name: "self_compliance_um_per_n", values: &values, range: None };
    Ok(write_glb(path, &limb.skin.surface(&limb.mesh)?, Some(&field))?)
}

/// The same on the page, to be turned, with the gauges.
pub(crate) fn limb_view(limb: &Limb, done: &Pipeline) -> Result<LimbView> {
    let values = self_compliance(limb, done)?;
    let map = LimbMap {
        title: "Figure 3: one newton on each node in turn".into(),
        unit: "µm".into(),
        factor: 1.0,
        range: [0.0, values.iter().copied().fold(0.0, f64::max)],
        values,
    };
    let gauges = limb.sites.iter().map(|site| site.position.coords.into());
    let surface = limb.skin.surface(&limb.mesh)?;
    Ok(LimbView::new(&surface, vec![map], gauges.collect()))
}

fn self_compliance(limb: &Limb, done: &Pipeline) -> Result<Vec<f64>> {
    let path = done.compliance.dir.join("compliance.safetensors");
    let table = ComplianceTable::read(&path, limb.n_surface_nodes())?;
    Ok(table.self_compliance_um_per_n())
}

fn training_curves(done: &Pipeline) -> Result<Figure> {
    let nets = done.nets.iter().flat_map(|nets| &nets.nets);
    let series = nets.filter_map(|net| {
        let history = &net.stage.record.info["history"];
        let steps = history["step"].as_array()?;
        let losses = history["validation_loss"].as_array()?;
        let point = |(x, y): (&Value, &Value)| Some((x.as_f64()?, y.as_f64()?));
        let points = steps.iter().zip(losses).filter_map(point).collect();
        Some(Series { name: net.kind.name(), points })
    });
    let labels = ["step", "root mean square error, standardised outputs"];
    let chart = dotted_lines("Validation loss", labels, [false, true], series);
    let chart = LineChart { dots: false, ..chart };
    Ok(Figure::lines("training.svg", "Validation loss over the training of each net.", &chart)?)
}
