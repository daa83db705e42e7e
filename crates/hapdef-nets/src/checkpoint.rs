//! A net in files: one JSON file that says everything but the weights, and names the safetensors
//! files that hold the weights and, if the training may go on, the optimiser's moments.
//!
//! The safetensors files carry the step in their names and are complete before the JSON file is
//! replaced, so whatever interrupts the writing, the JSON file names a whole set.

use std::fs;
use std::path::{Path, PathBuf};

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::{Map, Value};

use crate::error::NetsError;
use crate::files::{NamedTensor, read, read_tensors, write_atomic, write_tensors};
use crate::mlp::{Layer, Mlp};
use crate::net::{Net, Scale};
use crate::optimiser::Moments;
use crate::params::TrainParams;
use crate::spec::MlpSpec;

/// Version of the JSON file's fields that this crate writes and reads.
pub const CHECKPOINT_FORMAT_VERSION: u32 = 2;

/// A parameter that there was once.
const PRECISION: &str = "precision";

/// How a net came to be what it is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainRecord {
    /// Steps of the optimiser so far.
    pub step: u64,
    /// The parameters.
    #[serde(deserialize_with = "params_of_file")]
    pub params: TrainParams,
    /// Loss of the last batch plus the penalty, standardised outputs.
    pub train_loss: Option<f64>,
    /// Loss of the validation set when last looked at, standardised outputs.
    pub validation_loss: Option<f64>,
    /// Every look at the validation set, the first one first.
    pub looks: Vec<Look>,
    /// Step of the look whose weights are kept as the best, if the parameters ask for that.
    pub best_step: Option<u64>,
}

/// A look at the validation set.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Look {
    /// Steps done before it.
    pub step: u64,
    /// Loss of the batch of the last step plus the penalty, standardised outputs; none before the
    /// first step.
    pub train_loss: Option<f64>,
    /// Loss of the validation set, standardised outputs.
    pub validation_loss: f64,
}

/// A training at a point from which it can go on.
#[derive(Debug, Clone, PartialEq)]
pub struct Resumable {
    /// The net with the weights of the last step.
    pub net: Net,
    /// How it came to be what it is.
    pub record: TrainRecord,
    /// The optimiser's moments, one per layer.
    pub moments: Vec<Moments>,
    /// The weights of [`TrainRecord::best_step`], where those are not the net's own.
    pub best: Option<Mlp>,
}

impl TrainRecord {
    /// Before the first step.
    pub fn new(params: TrainParams) -> Self {
        Self {
            step: 0,
            params,
            train_loss: None,
            validation_loss: None,
            looks: vec![],
            best_step: None,
        }
    }

    /// The look with the lowest validation loss, the first of equals.
    pub fn lowest(&self) -> Option<&Look> {
        let by_loss = |a: &&Look, b: &&Look| a.validation_loss.total_cmp(&b.validation_loss);
        self.looks.iter().min_by(by_loss)
    }

    /// Looks since the one with the lowest validation loss.
    pub fn looks_since_lowest(&self) -> u64 {
        let Some(lowest) = self.lowest() else {
            return 0;
        };
        self.looks.iter().filter(|l| l.step > lowest.step).count() as u64
    }
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct CheckpointFile {
    format_version: u32,
    spec: MlpSpec,
    input_scale: Scale,
    output_scale: Scale,
    record: TrainRecord,
    weights_file: String,
    moments_file: Option<String>,
    /// The best weights, where they are not those of `weights_file`.
    best_file: Option<String>,
}

impl CheckpointFile {
    /// Names of the safetensors files.
    fn files(&self) -> [Option<&String>; 3] {
        let weights = Some(&self.weights_file);
        [weights, self.moments_file.as_ref(), self.best_file.as_ref()]
    }
}

/// Writes a net to `path` (the JSON file) and safetensors files beside it, with the optimiser's
/// moments if given, and removes the safetensors files of the checkpoint it replaces.
///
/// Fails if there are not as many moments as layers.
pub fn save(
    path: &Path,
    net: &Net,
    record: &TrainRecord,
    moments: Option<&[Moments]>,
) -> Result<(), NetsError> {
    save_all(path, net, record, moments, None)
}

/// Writes a net as [`save`] does, and the weights `best` of [`TrainRecord::best_step`], which
/// [`load`] then gives instead of the net's own.
pub(crate) fn save_all(
    path: &Path,
    net: &Net,
    record: &TrainRecord,
    moments: Option<&[Moments]>,
    best: Option<&Mlp>,
) -> Result<(), NetsError> {
    let replaced = parse(path).ok();
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let weights_file = format!("{stem}-{}.safetensors", record.step);
    let moments_file = moments.map(|_| format!("{stem}-{}.moments.safetensors", record.step));
    let best_file = best.map(|_| format!("{stem}-{}.best.safetensors", record.step));
    write_tensors(&path.with_file_name(&weights_file), &weight_tensors(net.mlp()))?;
    if let (Some(best), Some(name)) = (best, &best_file) {
        write_tensors(&path.with_file_name(name), &weight_tensors(best))?;
    }
    if let (Some(moments), Some(name)) = (moments, &moments_file) {
        let tensors = moment_tensors(net.mlp().spec(), moments)?;
        write_tensors(&path.with_file_name(name), &tensors)?;
    }
    let file = CheckpointFile {
        format_version: CHECKPOINT_FORMAT_VERSION,
        spec: net.mlp().spec().clone(),
        input_scale: net.input_scale().clone(),
        output_scale: net.output_scale().clone(),
        record: record.clone(),
        weights_file,
        moments_file,
        best_file,
    };
    let mut json = serde_json::to_vec_pretty(&file).map_err(invalid(path))?;
    json.push(b'\n');
    write_atomic(path, &json)?;
    if let Some(replaced) = replaced {
        remove_replaced(path, &replaced, &file);
    }
    Ok(())
}

/// Reads the net of a checkpoint, with the best weights if it has them, and how it came to be.
pub fn load(path: &Path) -> Result<(Net, TrainRecord), NetsError> {
    let file = parse(path)?;
    let weights = file.best_file.as_ref().unwrap_or(&file.weights_file);
    let mlp = read_mlp(path, &file.spec, weights)?;
    Ok((net_of(mlp, &file)?, file.record))
}

/// Reads a checkpoint with what a training needs to go on. Fails if it has no moments.
pub fn load_for_resume(path: &Path) -> Result<Resumable, NetsError> {
    let file = parse(path)?;
    check_precision(path)?;
    let net = net_of(read_mlp(path, &file.spec, &file.weights_file)?, &file)?;
    let best = match &file.best_file {
        Some(name) => Some(read_mlp(path, &file.spec, name)?),
        None => None,
    };
    let Some(name) = &file.moments_file else {
        return Err(NetsError::NotResumable { path: path.to_path_buf() });
    };
    let mut tensors = read_tensors(&sibling(path, name)?, &moment_shapes(&file.spec))?.into_iter();
    let mut moments = vec![];
    while let (Some(weights_m), Some(weights_v), Some(bias_m), Some(bias_v)) =
        (tensors.next(), tensors.next(), tensors.next(), tensors.next())
    {
        moments.push(Moments { weights_m, weights_v, bias_m, bias_v });
    }
    Ok(Resumable { net, record: file.record, moments, best })
}

/// The parameters in a file. Files of trainings in f32 or bfloat16 name the precision of the products,
/// which is f32 alone now.
fn params_of_file<'de, D: Deserializer<'de>>(file: D) -> Result<TrainParams, D::Error> {
    let mut fields = Map::deserialize(file)?;
    fields.remove(PRECISION);
    TrainParams::deserialize(Value::Object(fields)).map_err(D::Error::custom)
}

/// Fails where a file names a precision of the products other than f32: such a training can't go on
/// with the same bits. Its weights are in f32 all the same, and [`load`] reads them.
fn check_precision(path: &Path) -> Result<(), NetsError> {
    let file: Value = serde_json::from_slice(&read(path)?).map_err(invalid(path))?;
    match file["record"]["params"][PRECISION].as_str() {
        Some(saved) if saved != "f32" => Err(NetsError::ResumeParams {
            path: path.to_path_buf(),
            name: PRECISION,
            saved: saved.to_owned(),
            asked: "f32, the only precision of a training".into(),
        }),
        _ => Ok(()),
    }
}

fn parse(path: &Path) -> Result<CheckpointFile, NetsError> {
    #[derive(Deserialize)]
    struct VersionOnly {
        format_version: u32,
    }
    let json = read(path)?;
    let version: VersionOnly = serde_json::from_slice(&json).map_err(invalid(path))?;
    if version.format_version != CHECKPOINT_FORMAT_VERSION {
        return Err(NetsError::FormatVersion {
            path: path.to_path_buf(),
            found: version.format_version,
            known: CHECKPOINT_FORMAT_VERSION,
        });
    }
    serde_json::from_slice(&json).map_err(invalid(path))
}

fn net_of(mlp: Mlp, file: &CheckpointFile) -> Result<Net, NetsError> {
    file.input_scale.check()?;
    file.output_scale.check()?;
    Net::new(mlp, file.input_scale.clone(), file.output_scale.clone())
}

fn read_mlp(path: &Path, spec: &MlpSpec, name: &str) -> Result<Mlp, NetsError> {
    spec.check()?;
    mlp_of(spec, read_tensors(&sibling(path, name)?, &weight_shapes(spec))?)
}

/// The network of tensors as [`weight_shapes`] has them.
pub(crate) fn mlp_of(spec: &MlpSpec, tensors: Vec<Vec<f32>>) -> Result<Mlp, NetsError> {
    let (mut tensors, mut layers) = (tensors.into_iter(), vec![]);
    while let (Some(weights), Some(bias)) = (tensors.next(), tensors.next()) {
        layers.push(Layer { weights, bias });
    }
    Mlp::from_layers(spec, layers)
}

/// Names and shapes of the weights and biases, layer by layer.
pub(crate) fn weight_shapes(spec: &MlpSpec) -> Vec<(String, Vec<usize>)> {
    let layers = spec.layer_shapes().into_iter().enumerate();
    layers
        .flat_map(|(i, (n_in, n_out))| {
            [
                (format!("layers.{i}.weight"), vec![n_out, n_in]),
                (format!("layers.{i}.bias"), vec![n_out]),
            ]
        })
        .collect()
}

fn moment_shapes(spec: &MlpSpec) -> Vec<(String, Vec<usize>)> {
    let each = weight_shapes(spec).into_iter();
    each.flat_map(|(name, shape)| {
        [(format!("{name}.m"), shape.clone()), (format!("{name}.v"), shape)]
    })
    .collect()
}

/// The weights and biases, layer by layer.
pub(crate) fn weight_tensors(mlp: &Mlp) -> Vec<NamedTensor<'_>> {
    let slices = mlp.layers().iter().flat_map(|layer| [&layer.weights[..], &layer.bias[..]]);
    named(weight_shapes(mlp.spec()), slices)
}

fn moment_tensors<'a>(
    spec: &MlpSpec,
    moments: &'a [Moments],
) -> Result<Vec<NamedTensor<'a>>, NetsError> {
    crate::error::check_length("moments", spec.layer_shapes().len(), moments.len())?;
    let slices = moments
        .iter()
        .flat_map(|m| [&m.weights_m[..], &m.weights_v[..], &m.bias_m[..], &m.bias_v[..]]);
    Ok(named(moment_shapes(spec), slices))
}

fn named<'a>(
    shapes: Vec<(String, Vec<usize>)>,
    slices: impl Iterator<Item = &'a [f32]>,
) -> Vec<NamedTensor<'a>> {
    let pairs = shapes.into_iter().zip(slices);
    pairs.map(|((name, shape), values)| NamedTensor { name, shape, values }).collect()
}

/// The path of a file that the checkpoint names; only a plain name in the same folder will do.
fn sibling(path: &Path, name: &str) -> Result<PathBuf, NetsError> {
    if Path::new(name).file_name().is_some_and(|plain| plain == name) {
        return Ok(path.with_file_name(name));
    }
    Err(NetsError::FileName { path: path.to_path_buf(), name: name.to_owned() })
}

fn remove_replaced(path: &Path, replaced: &CheckpointFile, kept: &CheckpointFile) {
    let (old, new) = (replaced.files(), kept.files());
    for name in old.into_iter().flatten() {
        if !new.contains(&Some(name))
            && let Ok(stale) = sibling(path, name)
        {
            // The new checkpoint is whole; a stale file left behind does no harm.
            let _ = fs::remove_file(stale);
        }
    }
}

fn invalid(path: &Path) -> impl Fn(serde_json::Error) -> NetsError {
    let path = path.to_path_buf();
    move |source| NetsError::Json { path: path.clone(), source }
}
