//! The nets of the pipeline: which there are and what each is trained on.

use std::ops::Range;

use hapdef_data::{DatasetReader, Split, StandardiserFit};
use hapdef_nets::train::{BatchSource, MemorySource, SourceError};
use hapdef_nets::{MlpSpec, Scale};
use serde::{Deserialize, Serialize};

use super::dataset::{Datasets, samples_path};
use super::dataset_rows::Dataset;
use crate::cache::Stage;
use crate::error::HapdefError;
use crate::profile::OutputScale;
use crate::work::WorkKind;

/// Name of a trained net in its stage's folder; its checkpoints lie there while it is trained.
pub(super) const CHECKPOINT_FILE: &str = "net.json";

/// A net of the pipeline.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum NetKind {
    /// F_T: readings → virtual gauges, on the rig's single presses.
    Transfer,
    /// F_R: virtual gauges → map, on simulated sets of one up to so many contacts.
    Reconstruction {
        /// Contacts of the last set: 1 trains on I, 2 on I–II, and so on.
        n_sets: usize,
    },
    /// F_S: displacement and position of a contact → its force, on simulated single contacts.
    Sensitivity,
    /// Readings → position and force, on the rig's single presses: the single-contact baseline.
    Direct,
}

/// Rows that are read together while a scale is fitted.
const BLOCK: usize = 512;

/// Most samples a validation looks at, spread over the sets.
const MAX_VALIDATION: usize = 1000;

impl From<NetKind> for WorkKind {
    fn from(net: NetKind) -> Self {
        match net {
            NetKind::Transfer => Self::Transfer,
            NetKind::Reconstruction { .. } => Self::Reconstruction,
            NetKind::Sensitivity => Self::Sensitivity,
            NetKind::Direct => Self::Direct,
        }
    }
}

impl NetKind {
    /// Name for files and people.
    #[must_use]
    pub fn name(self) -> String {
        match self {
            Self::Transfer => "transfer".into(),
            Self::Reconstruction { n_sets } => format!("reconstruction-{n_sets}"),
            Self::Sensitivity => "sensitivity".into(),
            Self::Direct => "direct".into(),
        }
    }

    /// The datasets it is trained on.
    #[must_use]
    pub fn datasets(self, data: &Datasets) -> Vec<&Stage> {
        match self {
            Self::Transfer | Self::Direct => vec![&data.rig_single],
            Self::Reconstruction { n_sets } => data.simulated.iter().take(n_sets).collect(),
            Self::Sensitivity => data.simulated.iter().take(1).collect(),
        }
    }

    /// The paper's architecture for samples of these widths.
    #[must_use]
    pub fn spec(self, n_inputs: usize, n_outputs: usize) -> MlpSpec {
        match self {
            Self::Transfer => MlpSpec::transfer(n_inputs, n_outputs),
            Self::Reconstruction { .. } => MlpSpec::reconstruction(n_inputs, n_outputs),
            Self::Sensitivity => MlpSpec::sensitivity(),
            Self::Direct => MlpSpec::direct(n_inputs),
        }
    }

    /// Training and validation samples.
    pub(super) fn samples(self, data: &Datasets) -> Result<[Box<dyn BatchSource>; 2], HapdefError> {
        let stages = self.datasets(data);
        let columns = match self {
            Self::Transfer => ["readings", "virtual_gauges"],
            Self::Reconstruction { .. } => ["virtual_gauges", "deformation"],
            Self::Sensitivity => {
                return memory_sources(stages[0], sensitivity_rows);
            }
            Self::Direct => {
                return memory_sources(stages[0], direct_rows);
            }
        };
        let train = StreamedRows::open(&stages, columns, |split| split.train)?;
        let most = MAX_VALIDATION / stages.len();
        let validation = StreamedRows::open(&stages, columns, |split| {
            let Range { start, end } = split.validation;
            start..end.min(start + most)
        })?;
        Ok([Box::new(train), Box::new(validation)])
    }
}

/// Means and deviations of a source's inputs and outputs; those that never vary have the deviation
/// 0, and no say.
pub(super) fn fit_scales(
    samples: &mut dyn BatchSource,
    outputs: OutputScale,
) -> Result<[Scale; 2], HapdefError> {
    let (n_in, n_out) = (samples.n_inputs(), samples.n_outputs());
    let mut fits = [StandardiserFit::new(n_in), StandardiserFit::new(n_out)];
    let rows: Vec<usize> = (0..samples.n_samples()).collect();
    for block in rows.chunks(BLOCK) {
        let (mut x, mut y) = (vec![0.0; block.len() * n_in], vec![0.0; block.len() * n_out]);
        samples.fill(block, &mut x, &mut y).map_err(source_error)?;
        fits[0].push(&x)?;
        fits[1].push(&y)?;
    }
    let [x, y] = fits;
    let ((x, _), (mut y, _)) = (x.finish()?, y.finish()?);
    if outputs == OutputScale::One {
        let squares: f64 = y.std.iter().map(|s| f64::from(*s).powi(2)).sum();
        y.std.fill((squares / n_out as f64).sqrt() as f32);
    }
    Ok([Scale::new(x.mean, x.std)?, Scale::new(y.mean, y.std)?])
}

fn source_error(error: SourceError) -> HapdefError {
    match error.downcast::<hapdef_data::DataError>() {
        Ok(error) => (*error).into(),
        Err(other) => HapdefError::File {
            path: "samples".into(),
            source: std::io::Error::other(other.to_string()),
        },
    }
}

/// Rows of one or several dataset files, one tensor in and one out, read when asked for.
struct StreamedRows {
    parts: Vec<(DatasetReader, Range<usize>)>,
    columns: [&'static str; 2],
    widths: [usize; 2],
}

impl StreamedRows {
    fn open(
        stages: &[&Stage],
        columns: [&'static str; 2],
        block: impl Fn(Split) -> Range<usize>,
    ) -> Result<Self, HapdefError> {
        let mut parts = Vec::with_capacity(stages.len());
        let mut widths = [0; 2];
        for stage in stages {
            let reader = DatasetReader::open(&samples_path(stage))?;
            widths = [reader.width(columns[0])?, reader.width(columns[1])?];
            let rows = block(Split::of(reader.n())?);
            parts.push((reader, rows));
        }
        Ok(Self { parts, columns, widths })
    }

    fn locate(&self, row: usize) -> Option<(usize, usize)> {
        let mut first = 0;
        for (part, (_, rows)) in self.parts.iter().enumerate() {
            if row < first + rows.len() {
                return Some((part, rows.start + row - first));
            }
            first += rows.len();
        }
        None
    }
}

impl BatchSource for StreamedRows {
    fn n_samples(&self) -> usize {
        self.parts.iter().map(|(_, rows)| rows.len()).sum()
    }

    fn n_inputs(&self) -> usize {
        self.widths[0]
    }

    fn n_outputs(&self) -> usize {
        self.widths[1]
    }

    fn fill(&mut self, rows: &[usize], x: &mut [f32], y: &mut [f32]) -> Result<(), SourceError> {
        let [n_in, n_out] = self.widths;
        let targets = x.chunks_exact_mut(n_in).zip(y.chunks_exact_mut(n_out));
        for (&row, (x, y)) in rows.iter().zip(targets) {
            let (part, row) = self.locate(row).ok_or("a row past the end of the samples")?;
            let reader = &mut self.parts[part].0;
            reader.read_rows(self.columns[0], row..row + 1, x)?;
            reader.read_rows(self.columns[1], row..row + 1, y)?;
        }
        Ok(())
    }
}

/// Inputs and outputs of samples, with their widths.
type Rows = (Vec<f32>, usize, Vec<f32>, usize);

fn memory_sources(
    stage: &Stage,
    rows_of: impl Fn(&mut Dataset, Range<usize>) -> Result<Rows, HapdefError>,
) -> Result<[Box<dyn BatchSource>; 2], HapdefError> {
    let mut presses = Dataset::open(stage)?;
    let split = presses.split()?;
    let mut source = |rows| -> Result<Box<dyn BatchSource>, HapdefError> {
        let (x, n_in, y, n_out) = rows_of(&mut presses, rows)?;
        Ok(Box::new(MemorySource::new(n_in, n_out, x, y)?))
    };
    Ok([source(split.train)?, source(split.validation)?])
}

/// `(D_i, P_i) → A` of single contacts (the paper's equation 3).
fn sensitivity_rows(presses: &mut Dataset, rows: Range<usize>) -> Result<Rows, HapdefError> {
    let pressed = presses.drawn(rows.clone())?;
    let contacts = presses.contacts(rows.clone())?;
    let (mut features, mut forces) = (Vec::new(), Vec::new());
    for ((row, pressed), [x, y, z, force_n]) in rows.zip(pressed).zip(contacts) {
        let map = presses.maps(row..row + 1)?;
        features.extend([map[pressed[0].node], x, y, z]);
        forces.push(force_n);
    }
    Ok((features, 4, forces, 1))
}

/// Readings → position and force of single presses.
fn direct_rows(presses: &mut Dataset, rows: Range<usize>) -> Result<Rows, HapdefError> {
    let n = rows.len();
    let readings = presses.readings(rows.clone())?;
    let n_gauges = readings.len() / n.max(1);
    Ok((readings, n_gauges, presses.contacts(rows)?.into_flattened(), 4))
}
