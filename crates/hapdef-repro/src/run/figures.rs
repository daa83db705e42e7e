//! The report's figures.

use std::path::Path;

use anyhow::{Context, Result};
use hapdef::stages::{EvalReport, NetKind, samples_path};
use hapdef::{ComplianceTable, Hapdefx, HapdefxScratch, Limb, Pipeline, Run, Stage};
use hapdef_data::DatasetReader;
use hapdef_mesh::{VertexField, write_glb};
use hapdef_repro::{
    Figure, FigureContent, LimbMarker, LimbPicture, LineChart, RenderParams, Series, Table1,
    Unrolled, UnrolledMarker, lines_svg, render_limb_png, table1_svg, unroll, unrolled_svg,
};
use nalgebra::Vector3;
use serde_json::Value;

/// Makes every figure.
pub(crate) fn figures(
    run: &Run,
    limb: &Limb,
    done: &Pipeline,
    table1: &Table1,
) -> Result<Vec<Figure>> {
    let surface = Surface::of(run, limb)?;
    let mut figures = vec![rigidity(&surface, limb, done)?];
    figures.extend(double_example(run, &surface, done)?);
    figures.push(svg(
        "table1.svg",
        "Table 1, ours beside the paper's.",
        table1_svg(table1)?,
    ));
    figures.push(training_curves(done)?);
    if let Some((_, scores)) = &done.eval {
        figures.extend(error_by_force(scores)?);
    }
    Ok(figures)
}

/// Writes the skin with the rigidity map as vertex colours, for any glTF viewer.
pub(crate) fn write_surface(path: &Path, limb: &Limb, done: &Pipeline) -> Result<()> {
    let values = self_compliance(limb, done)?;
    let field = VertexField {
        name: "self_compliance_um_per_n",
        values: &values,
        range: None,
    };
    Ok(write_glb(
        path,
        &limb.skin.surface(&limb.mesh)?,
        Some(&field),
    )?)
}

/// The skin as the pictures need it.
struct Surface {
    positions: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    up_axis: usize,
}

impl Surface {
    fn of(run: &Run, limb: &Limb) -> Result<Self> {
        let mesh = limb.skin.surface(&limb.mesh)?;
        let axis = Vector3::from(run.scene.geometry.axis.direction);
        Ok(Self {
            positions: mesh.vertices().iter().map(|p| p.coords.into()).collect(),
            triangles: mesh.triangles().to_vec(),
            up_axis: axis.iamax(),
        })
    }

    /// Seen from where the first mark is, if there is one.
    fn picture(
        &self,
        file: &str,
        caption: &str,
        values: &[f64],
        marks: &[LimbMarker],
    ) -> Result<Figure> {
        let picture = LimbPicture {
            positions: &self.positions,
            triangles: &self.triangles,
            values,
            markers: marks,
        };
        let mut params = RenderParams {
            up_axis: self.up_axis,
            ..RenderParams::default()
        };
        if let Some(first) = marks.first() {
            let towards = unroll(&[first.position], &self.positions, self.up_axis)?;
            params.azimuth_rad = towards[0][0];
        }
        let content = FigureContent::Png(render_limb_png(&picture, &params)?);
        Ok(Figure {
            file: file.into(),
            caption: caption.into(),
            content,
        })
    }

    fn unrolled(
        &self,
        file: &str,
        caption: &str,
        values: &[f64],
        marks: &[LimbMarker],
        range: Option<[f64; 2]>,
    ) -> Result<Figure> {
        let points = unroll(&self.positions, &self.positions, self.up_axis)?;
        let at: Vec<[f64; 3]> = marks.iter().map(|mark| mark.position).collect();
        let at = unroll(&at, &self.positions, self.up_axis)?;
        let markers: Vec<UnrolledMarker> = at
            .iter()
            .zip(marks)
            .map(|(at, mark)| UnrolledMarker {
                at: *at,
                truth: mark.truth,
            })
            .collect();
        let text = unrolled_svg(&Unrolled {
            title: caption,
            value_label: "displacement, µm",
            points: &points,
            values,
            range,
            markers: &markers,
            arrows: &[],
        })?;
        Ok(svg(file, caption, text))
    }
}

/// Figure 3 of the paper: displacement for the same force everywhere.
fn rigidity(surface: &Surface, limb: &Limb, done: &Pipeline) -> Result<Figure> {
    let values = self_compliance(limb, done)?;
    let caption = "Displacement of each surface node for one newton on itself, µm (figure 3 of \
                   the paper, lighter is softer).";
    surface.picture("rigidity.png", caption, &values, &[])
}

fn self_compliance(limb: &Limb, done: &Pipeline) -> Result<Vec<f64>> {
    let path = done.compliance.dir.join("compliance.safetensors");
    let table = ComplianceTable::read(&path, limb.n_surface_nodes())?;
    Ok(table.self_compliance_um_per_n())
}

/// Figures 6 and 9A: a double press, true map and what the chain makes of the readings.
fn double_example(run: &Run, surface: &Surface, done: &Pipeline) -> Result<Vec<Figure>> {
    let (Some(data), Some(nets)) = (&done.data, &done.nets) else {
        return Ok(vec![]);
    };
    let Some(stage) = &data.rig_double else {
        return Ok(vec![]);
    };
    let row = run.profile.n_amplitudes - 1;
    let [readings, truth, positions] =
        read_row(stage, row, ["readings", "deformation", "contact_positions"])?;
    let chain = Hapdefx::new(
        nets.load(NetKind::Transfer)?,
        nets.load(NetKind::Reconstruction {
            n_sets: data.simulated.len(),
        })?,
        nets.load(NetKind::Sensitivity)?,
        surface.positions.clone(),
        &run.scene.estimator,
    )?;
    let mut scratch = HapdefxScratch::default();
    let mut map = vec![0.0; truth.len()];
    chain.maps(&readings, &mut scratch, &mut map)?;
    let found = chain.top_with_spread(&chain.candidates(&map, &mut scratch)?, 2)?;
    let true_marks = positions.chunks_exact(3).map(|p| LimbMarker {
        position: [p[0], p[1], p[2]].map(f64::from),
        truth: true,
    });
    let found_marks = found.iter().map(|c| LimbMarker {
        position: c.position_m,
        truth: false,
    });
    let marks: Vec<LimbMarker> = true_marks.chain(found_marks).collect();
    let as_f64 = |values: &[f32]| values.iter().map(|v| f64::from(*v)).collect::<Vec<f64>>();
    let (truth, map) = (as_f64(&truth), as_f64(&map));
    let range = Some([0.0, truth.iter().copied().fold(0.0, f64::max)]);
    Ok(vec![
        surface.picture(
            "double_true.png",
            "A double press of the simulated rig: the simulated map, µm, and the true contacts.",
            &truth,
            &marks[..2],
        )?,
        surface.unrolled(
            "double_true.svg",
            "Double press, true map unrolled, true and found contacts",
            &truth,
            &marks,
            range,
        )?,
        surface.unrolled(
            "double_found.svg",
            "The same from ten gauge readings, true and found contacts",
            &map,
            &marks,
            range,
        )?,
    ])
}

/// Row `row` of three tensors of a dataset.
fn read_row(stage: &Stage, row: usize, tensors: [&str; 3]) -> Result<[Vec<f32>; 3]> {
    let mut reader = DatasetReader::open(&samples_path(stage))?;
    let mut rows = [vec![], vec![], vec![]];
    for (tensor, values) in tensors.into_iter().zip(&mut rows) {
        values.resize(reader.width(tensor)?, 0.0);
        reader.read_rows(tensor, row..row + 1, values)?;
    }
    Ok(rows)
}

fn training_curves(done: &Pipeline) -> Result<Figure> {
    let nets = done.nets.iter().flat_map(|nets| &nets.nets);
    let series = nets.filter_map(|net| {
        let history = &net.stage.record.info["history"];
        let steps = history["step"].as_array()?;
        let losses = history["validation_loss"].as_array()?;
        let point = |(x, y): (&Value, &Value)| Some((x.as_f64()?, y.as_f64()?));
        let points = steps.iter().zip(losses).filter_map(point).collect();
        Some(Series {
            name: net.kind.name(),
            points,
        })
    });
    let chart = LineChart {
        title: "Validation loss".into(),
        x_label: "step".into(),
        y_label: "root mean square error, standardised outputs".into(),
        log_y: true,
        dots: false,
        series: series.collect(),
    };
    Ok(svg(
        "training.svg",
        "Validation loss over the training of each net.",
        lines_svg(&chart)?,
    ))
}

/// Figures 9B and C: errors of the varied contact against its force.
fn error_by_force(scores: &EvalReport) -> Result<Vec<Figure>> {
    let Some(double) = &scores.double else {
        return Ok(vec![]);
    };
    if double.error_by_force.is_empty() {
        return Ok(vec![]);
    }
    let chart = |title: &str, y_label: &str, value: &dyn Fn(&hapdef::stages::ForceBin) -> f64| {
        let points = double
            .error_by_force
            .iter()
            .map(|bin| (bin.force_n, value(bin)));
        lines_svg(&LineChart {
            title: title.into(),
            x_label: "force of the varied contact, N".into(),
            y_label: y_label.into(),
            log_y: false,
            dots: true,
            series: vec![Series {
                name: "one-to-one, T + 1".into(),
                points: points.collect(),
            }],
        })
        .context("error against force")
    };
    let position = chart("Position error against force", "mm", &|bin| bin.position_mm)?;
    let force = chart("Force error against force", "N", &|bin| bin.force_error_n)?;
    Ok(vec![
        svg(
            "double_position.svg",
            "Double contacts, one-to-one: position error of the varied contact where it was found (figure 9B).",
            position,
        ),
        svg(
            "double_force.svg",
            "Double contacts, one-to-one: force error of the varied contact where it was found (figure 9C).",
            force,
        ),
    ])
}

fn svg(file: &str, caption: &str, text: String) -> Figure {
    Figure {
        file: file.into(),
        caption: caption.into(),
        content: FigureContent::Svg(text),
    }
}
