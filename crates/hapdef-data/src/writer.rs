//! Writing a dataset row by row.

use std::fs::{self, File};
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use safetensors::tensor::{Metadata, TensorInfo};

use crate::error::DataError;
use crate::tensor::{ELEMENT_BYTES, Element, TensorSpec};

/// Streams a dataset to a file.
///
/// The number of samples and all tensors are known at the start, so the header is written first
/// and every block of rows goes to its final place. The file grows under a temporary name beside
/// the final one and is renamed by [`DatasetWriter::finish`]; a writer dropped before that removes
/// it.
#[derive(Debug)]
pub struct DatasetWriter {
    path: PathBuf,
    partial_path: PathBuf,
    file: File,
    tensors: Vec<OpenTensor>,
    n: usize,
    data_start: u64,
    bytes: Vec<u8>,
    is_finished: bool,
}

/// What a finished dataset is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DatasetInfo {
    /// Where it lies.
    pub path: PathBuf,
    /// Number of samples.
    pub n: usize,
    /// Size of the file in bytes.
    pub n_bytes: u64,
}

#[derive(Debug)]
struct OpenTensor {
    spec: TensorSpec,
    offset: u64,
    written: usize,
}

impl DatasetWriter {
    /// Starts a dataset of `n` samples with the given tensors at `path`.
    ///
    /// Fails on a name given twice, on a width of 0, and if the file cannot be made.
    pub fn create(path: &Path, n: usize, tensors: &[TensorSpec]) -> Result<Self, DataError> {
        check_names(path, n, tensors)?;
        let (header, opened) = lay_out(path, n, tensors)?;
        let partial_path = partial_path(path);
        let mut file =
            File::create(&partial_path).map_err(DataError::io("create", &partial_path))?;
        file.write_all(&header).map_err(DataError::io("write", &partial_path))?;
        Ok(Self {
            path: path.to_path_buf(),
            partial_path,
            file,
            tensors: opened,
            n,
            data_start: header.len() as u64,
            bytes: Vec::new(),
            is_finished: false,
        })
    }

    /// Appends rows to a tensor: `rows` is `[m, width]`, row-major, any m.
    ///
    /// The tensors need not be filled in step. Fails on an unknown tensor, on another kind of
    /// number, on a slice that is not whole rows, on more than n rows, and on a value that is not
    /// finite; nothing of the block is then written.
    pub fn append<T: Element>(&mut self, tensor: &str, rows: &[T]) -> Result<(), DataError> {
        let idx = self.find(tensor)?;
        self.check_block(idx, rows)?;
        let open = &mut self.tensors[idx];
        let row_bytes = open.spec.width * ELEMENT_BYTES;
        let start = self.data_start + open.offset + (open.written * row_bytes) as u64;
        self.bytes.clear();
        self.bytes.extend(rows.iter().flat_map(|v| v.to_le()));
        self.file
            .seek(SeekFrom::Start(start))
            .and_then(|_| self.file.write_all(&self.bytes))
            .map_err(DataError::io("write", &self.partial_path))?;
        open.written += rows.len() / open.spec.width;
        Ok(())
    }

    /// Completes the dataset: checks that every tensor has its n rows, flushes to the disk, and
    /// gives the file its name, replacing an older file of that name.
    pub fn finish(mut self) -> Result<DatasetInfo, DataError> {
        if let Some(short) = self.tensors.iter().find(|t| t.written < self.n) {
            return Err(DataError::MissingRows {
                path: self.path.clone(),
                tensor: short.spec.name.clone(),
                written: short.written,
                n: self.n,
            });
        }
        self.file.sync_all().map_err(DataError::io("flush", &self.partial_path))?;
        fs::rename(&self.partial_path, &self.path).map_err(DataError::io("rename", &self.path))?;
        self.is_finished = true;
        let data_bytes: u64 = self.tensors.iter().map(|t| t.n_bytes(self.n)).sum();
        Ok(DatasetInfo {
            path: self.path.clone(),
            n: self.n,
            n_bytes: self.data_start + data_bytes,
        })
    }

    fn find(&self, tensor: &str) -> Result<usize, DataError> {
        self.tensors.iter().position(|t| t.spec.name == tensor).ok_or_else(|| {
            DataError::NoSuchTensor {
                path: self.path.clone(),
                tensor: tensor.to_owned(),
                available: self.tensors.iter().map(|t| t.spec.name.clone()).collect(),
            }
        })
    }

    fn check_block<T: Element>(&self, idx: usize, rows: &[T]) -> Result<(), DataError> {
        let OpenTensor { spec, written, .. } = &self.tensors[idx];
        let (path, tensor) = (self.path.clone(), spec.name.clone());
        if T::KIND != spec.kind {
            return Err(DataError::ElementKind { path, tensor, held: spec.kind, asked: T::KIND });
        }
        let n_rows = rows.len() / spec.width;
        if !rows.len().is_multiple_of(spec.width) {
            return Err(DataError::SliceLength {
                path,
                tensor,
                width: spec.width,
                expected: n_rows * spec.width,
                got: rows.len(),
            });
        }
        if written + n_rows > self.n {
            return Err(DataError::RowOutOfRange {
                path,
                tensor,
                row: written + n_rows - 1,
                n: self.n,
            });
        }
        match first_not_finite(rows) {
            Some((at, value)) => Err(DataError::NotFinite {
                path,
                tensor,
                row: written + at / spec.width,
                column: at % spec.width,
                value,
            }),
            None => Ok(()),
        }
    }
}

impl Drop for DatasetWriter {
    fn drop(&mut self) {
        if !self.is_finished {
            // Nothing can be reported from here, and a leftover file does no harm.
            let _ = fs::remove_file(&self.partial_path);
        }
    }
}

impl OpenTensor {
    fn n_bytes(&self, n: usize) -> u64 {
        (n * self.spec.width * ELEMENT_BYTES) as u64
    }
}

/// Position and value of the first number that is NaN or infinite.
pub(crate) fn first_not_finite<T: Element>(values: &[T]) -> Option<(usize, f32)> {
    let mut numbered = values.iter().enumerate();
    numbered.find_map(|(at, v)| v.not_finite().map(|value| (at, value)))
}

fn check_names(path: &Path, n: usize, tensors: &[TensorSpec]) -> Result<(), DataError> {
    for (i, spec) in tensors.iter().enumerate() {
        if tensors[..i].iter().any(|other| other.name == spec.name) {
            return Err(DataError::TensorNamedTwice {
                path: path.to_path_buf(),
                tensor: spec.name.clone(),
            });
        }
        if spec.width == 0 {
            return Err(DataError::Shape {
                path: path.to_path_buf(),
                tensor: spec.name.clone(),
                shape: vec![n, 0],
                n,
            });
        }
    }
    Ok(())
}

/// The safetensors header (length, JSON padded to eight bytes) and the place of every tensor.
fn lay_out(
    path: &Path,
    n: usize,
    tensors: &[TensorSpec],
) -> Result<(Vec<u8>, Vec<OpenTensor>), DataError> {
    let mut infos = Vec::with_capacity(tensors.len());
    let mut opened = Vec::with_capacity(tensors.len());
    let mut offset = 0;
    for spec in tensors {
        let end = offset + n * spec.width * ELEMENT_BYTES;
        let info = TensorInfo {
            dtype: spec.kind.dtype(),
            shape: vec![n, spec.width],
            data_offsets: (offset, end),
        };
        infos.push((spec.name.clone(), info));
        opened.push(OpenTensor { spec: spec.clone(), offset: offset as u64, written: 0 });
        offset = end;
    }
    let bad_header = |detail: String| DataError::Header { path: path.to_path_buf(), detail };
    let metadata = Metadata::new(None, infos).map_err(|e| bad_header(e.to_string()))?;
    let mut json = serde_json::to_vec(&metadata).map_err(|e| bad_header(e.to_string()))?;
    json.resize(json.len().next_multiple_of(8), b' ');
    let mut header = (json.len() as u64).to_le_bytes().to_vec();
    header.extend(json);
    Ok((header, opened))
}

fn partial_path(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(".partial");
    path.with_file_name(name)
}
