//! Tensors and bytes in files, written so that a crash leaves the old file or the new one.

use std::fs::{self, File};
use std::io::Write;
use std::path::Path;

use safetensors::tensor::TensorView;
use safetensors::{Dtype, SafeTensorError, SafeTensors};

use crate::error::NetsError;

/// A tensor on its way to a file.
pub(crate) struct NamedTensor<'a> {
    pub(crate) name: String,
    pub(crate) shape: Vec<usize>,
    pub(crate) values: &'a [f32],
}

/// Writes under a temporary name in the same folder, flushes to the disk, then renames.
pub(crate) fn write_atomic(path: &Path, bytes: &[u8]) -> Result<(), NetsError> {
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(".partial");
    let partial = path.with_file_name(name);
    File::create(&partial)
        .and_then(|mut file| file.write_all(bytes).and_then(|()| file.sync_all()))
        .map_err(io("write", &partial))?;
    fs::rename(&partial, path).map_err(io("rename", path))
}

/// Reads a whole file.
pub(crate) fn read(path: &Path) -> Result<Vec<u8>, NetsError> {
    fs::read(path).map_err(io("read", path))
}

/// Writes named tensors as one safetensors file.
pub(crate) fn write_tensors(path: &Path, tensors: &[NamedTensor<'_>]) -> Result<(), NetsError> {
    write_atomic(path, &tensor_bytes(path, tensors, None)?)
}

/// Named tensors as the bytes of a safetensors file, with one entry (name, text) of metadata.
pub(crate) fn tensor_bytes(
    path: &Path,
    tensors: &[NamedTensor<'_>],
    entry: Option<(&str, String)>,
) -> Result<Vec<u8>, NetsError> {
    let invalid = unreadable(path);
    let to_bytes = |t: &NamedTensor<'_>| t.values.iter().flat_map(|v| v.to_le_bytes()).collect();
    let bytes: Vec<Vec<u8>> = tensors.iter().map(to_bytes).collect();
    let mut views = Vec::with_capacity(tensors.len());
    for (tensor, bytes) in tensors.iter().zip(&bytes) {
        let view = TensorView::new(Dtype::F32, tensor.shape.clone(), bytes).map_err(&invalid)?;
        views.push((&tensor.name, view));
    }
    let metadata = entry.map(|(name, text)| [(name.to_owned(), text)].into_iter().collect());
    safetensors::serialize(views, metadata).map_err(invalid)
}

/// Reads named f32 tensors of known shapes from a safetensors file, in the order asked for.
/// Others in the file are passed over. Fails on values that are not finite.
pub(crate) fn read_tensors(
    path: &Path,
    wanted: &[(String, Vec<usize>)],
) -> Result<Vec<Vec<f32>>, NetsError> {
    tensors_of(path, &read(path)?, wanted)
}

/// The same from the bytes of `path`.
pub(crate) fn tensors_of(
    path: &Path,
    bytes: &[u8],
    wanted: &[(String, Vec<usize>)],
) -> Result<Vec<Vec<f32>>, NetsError> {
    let file = SafeTensors::deserialize(bytes).map_err(unreadable(path))?;
    let each = wanted.iter();
    each.map(|(name, shape)| read_tensor(path, &file, name, shape)).collect()
}

/// An entry of a safetensors file's metadata, if it is there.
pub(crate) fn metadata_entry(
    path: &Path,
    bytes: &[u8],
    name: &str,
) -> Result<Option<String>, NetsError> {
    let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(unreadable(path))?;
    let entries = metadata.metadata().as_ref();
    Ok(entries.and_then(|entries| entries.get(name).cloned()))
}

fn read_tensor(
    path: &Path,
    file: &SafeTensors<'_>,
    name: &str,
    shape: &[usize],
) -> Result<Vec<f32>, NetsError> {
    let found = match file.tensor(name) {
        Ok(view) if view.dtype() == Dtype::F32 && view.shape() == shape => Ok(view),
        Ok(view) => Err(format!("{:?} {:?}", view.dtype(), view.shape())),
        Err(_) => Err("none of that name".to_owned()),
    };
    let view = found.map_err(|found| NetsError::Tensor {
        path: path.to_path_buf(),
        tensor: name.to_owned(),
        expected: shape.to_vec(),
        found,
    })?;
    let (numbers, _) = view.data().as_chunks::<4>();
    let values: Vec<f32> = numbers.iter().map(|b| f32::from_le_bytes(*b)).collect();
    match values.iter().position(|v| !v.is_finite()) {
        Some(index) => Err(NetsError::Weight {
            path: path.to_path_buf(),
            tensor: name.to_owned(),
            index,
            value: values[index],
        }),
        None => Ok(values),
    }
}

fn unreadable(path: &Path) -> impl Fn(SafeTensorError) -> NetsError {
    let path = path.to_path_buf();
    move |source| NetsError::Safetensors { path: path.clone(), source }
}

fn io(action: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> NetsError {
    let path = path.to_path_buf();
    move |source| NetsError::Io { action, path, source }
}
