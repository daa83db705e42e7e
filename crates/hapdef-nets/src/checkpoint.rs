//! A net in files: one JSON file that says everything but the weights, and names the safetensors
//! files that hold the weights and, if the training may go on, the optimiser's moments.
//!
//! The safetensors files carry the step in their names and are complete before the JSON file is
//! replaced, so whatever interrupts the writing, the JSON file names a whole set.

use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::error::NetsError;
use crate::files::{NamedTensor, read, read_tensors, write_atomic, write_tensors};
use crate::mlp::{Layer, Mlp};
use crate::net::{Net, Scale};
use crate::optimiser::Moments;
use crate::params::TrainParams;
use crate::spec::MlpSpec;

/// Version of the JSON file's fields that this crate writes and reads.
pub const CHECKPOINT_FORMAT_VERSION: u32 = 1;

/// How a net came to be what it is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainRecord {
    /// Steps of the optimiser so far.
    pub step: u64,
    /// The knobs.
    pub params: TrainParams,
    /// √MSE of the last batch plus the penalty, standardised outputs.
    pub train_loss: Option<f64>,
    /// √MSE of the validation set when last looked at, standardised outputs.
    pub validation_loss: Option<f64>,
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
    let replaced = parse(path).ok();
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let weights_file = format!("{stem}-{}.safetensors", record.step);
    let moments_file = moments.map(|_| format!("{stem}-{}.moments.safetensors", record.step));
    write_tensors(
        &path.with_file_name(&weights_file),
        &weight_tensors(net.mlp()),
    )?;
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
    };
    let mut json = serde_json::to_vec_pretty(&file).map_err(invalid(path))?;
    json.push(b'\n');
    write_atomic(path, &json)?;
    if let Some(replaced) = replaced {
        remove_replaced(path, &replaced, &file);
    }
    Ok(())
}

/// Reads the net of a checkpoint, and how it came to be.
pub fn load(path: &Path) -> Result<(Net, TrainRecord), NetsError> {
    let file = parse(path)?;
    Ok((read_net(path, &file)?, file.record))
}

/// Reads a checkpoint with the optimiser's moments, one per layer. Fails if it has none.
pub fn load_for_resume(path: &Path) -> Result<(Net, TrainRecord, Vec<Moments>), NetsError> {
    let file = parse(path)?;
    let net = read_net(path, &file)?;
    let Some(name) = &file.moments_file else {
        return Err(NetsError::NotResumable {
            path: path.to_path_buf(),
        });
    };
    let mut tensors = read_tensors(&sibling(path, name)?, &moment_shapes(&file.spec))?.into_iter();
    let mut moments = vec![];
    while let (Some(weights_m), Some(weights_v), Some(bias_m), Some(bias_v)) = (
        tensors.next(),
        tensors.next(),
        tensors.next(),
        tensors.next(),
    ) {
        moments.push(Moments {
            weights_m,
            weights_v,
            bias_m,
            bias_v,
        });
    }
    Ok((net, file.record, moments))
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

fn read_net(path: &Path, file: &CheckpointFile) -> Result<Net, NetsError> {
    file.spec.check()?;
    file.input_scale.check()?;
    file.output_scale.check()?;
    let weights_path = sibling(path, &file.weights_file)?;
    let mut tensors = read_tensors(&weights_path, &weight_shapes(&file.spec))?.into_iter();
    let mut layers = vec![];
    while let (Some(weights), Some(bias)) = (tensors.next(), tensors.next()) {
        layers.push(Layer { weights, bias });
    }
    let mlp = Mlp::from_layers(&file.spec, layers)?;
    Net::new(mlp, file.input_scale.clone(), file.output_scale.clone())
}

fn weight_shapes(spec: &MlpSpec) -> Vec<(String, Vec<usize>)> {
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
        [
            (format!("{name}.m"), shape.clone()),
            (format!("{name}.v"), shape),
        ]
    })
    .collect()
}

fn weight_tensors(mlp: &Mlp) -> Vec<NamedTensor<'_>> {
    let slices = mlp
        .layers()
        .iter()
        .flat_map(|layer| [&layer.weights[..], &layer.bias[..]]);
    named(weight_shapes(mlp.spec()), slices)
}

fn moment_tensors<'a>(
    spec: &MlpSpec,
    moments: &'a [Moments],
) -> Result<Vec<NamedTensor<'a>>, NetsError> {
    crate::error::check_length("moments", spec.layer_shapes().len(), moments.len())?;
    let slices = moments.iter().flat_map(|m| {
        [
            &m.weights_m[..],
            &m.weights_v[..],
            &m.bias_m[..],
            &m.bias_v[..],
        ]
    });
    Ok(named(moment_shapes(spec), slices))
}

fn named<'a>(
    shapes: Vec<(String, Vec<usize>)>,
    slices: impl Iterator<Item = &'a [f32]>,
) -> Vec<NamedTensor<'a>> {
    let pairs = shapes.into_iter().zip(slices);
    pairs
        .map(|((name, shape), values)| NamedTensor {
            name,
            shape,
            values,
        })
        .collect()
}

/// The path of a file that the checkpoint names; only a plain name in the same folder will do.
fn sibling(path: &Path, name: &str) -> Result<PathBuf, NetsError> {
    if Path::new(name)
        .file_name()
        .is_some_and(|plain| plain == name)
    {
        return Ok(path.with_file_name(name));
    }
    Err(NetsError::FileName {
        path: path.to_path_buf(),
        name: name.to_owned(),
    })
}

fn remove_replaced(path: &Path, replaced: &CheckpointFile, kept: &CheckpointFile) {
    let old = [Some(&replaced.weights_file), replaced.moments_file.as_ref()];
    let new = [Some(&kept.weights_file), kept.moments_file.as_ref()];
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
    move |source| NetsError::Json {
        path: path.clone(),
        source,
    }
}
