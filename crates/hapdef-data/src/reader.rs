//! Reading rows of a dataset by their offset.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::{Path, PathBuf};

use safetensors::tensor::{Metadata, TensorInfo};

use crate::error::DataError;
use crate::tensor::{ELEMENT_BYTES, Element, ElementKind};
use crate::writer::first_not_finite;

/// An open dataset.
#[derive(Debug)]
pub struct DatasetReader {
    path: PathBuf,
    file: File,
    n: usize,
    tensors: Vec<StoredTensor>,
    bytes: Vec<u8>,
}

#[derive(Debug)]
struct StoredTensor {
    name: String,
    kind: ElementKind,
    width: usize,
    start: u64,
}

/// Numbers that are read together.
const PIECE: usize = 1 << 16;

/// A longer header than this is taken for damage; a dataset's has a few hundred bytes.
const MAX_HEADER_BYTES: u64 = 1 << 24;

impl DatasetReader {
    /// Opens a dataset and checks its header, its shapes and its length.
    pub fn open(path: &Path) -> Result<Self, DataError> {
        let mut file = File::open(path).map_err(DataError::io("open", path))?;
        let (metadata, data_start) = read_header(path, &mut file)?;
        let expected = data_start + metadata.data_len() as u64;
        let got = file.metadata().map_err(DataError::io("read", path))?.len();
        if got != expected {
            return Err(DataError::FileLength { path: path.to_path_buf(), expected, got });
        }
        let infos = metadata.tensors();
        let names = metadata.offset_keys();
        let n = names.first().and_then(|name| infos[name].shape.first().copied()).unwrap_or(0);
        let tensors = names
            .iter()
            .map(|name| stored_tensor(path, name, infos[name], n, data_start))
            .collect::<Result<_, _>>()?;
        Ok(Self { path: path.to_path_buf(), file, n, tensors, bytes: Vec::new() })
    }

    /// Number of samples.
    pub fn n(&self) -> usize {
        self.n
    }

    /// Where the dataset lies.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Names of the tensors, in the file's order.
    pub fn tensor_names(&self) -> impl Iterator<Item = &str> {
        self.tensors.iter().map(|t| t.name.as_str())
    }

    /// Numbers per row of a tensor. Fails if there is no such tensor.
    pub fn width(&self, tensor: &str) -> Result<usize, DataError> {
        Ok(self.tensors[self.find(tensor)?].width)
    }

    /// Kind of the numbers of a tensor. Fails if there is no such tensor.
    pub fn kind(&self, tensor: &str) -> Result<ElementKind, DataError> {
        Ok(self.tensors[self.find(tensor)?].kind)
    }

    /// Reads consecutive rows into `out`, `[rows.len(), width]`, row-major.
    ///
    /// Fails on an unknown tensor, on another kind of number, on rows past the end, on an `out` of
    /// another length, and on a value that is not finite.
    pub fn read_rows<T: Element>(
        &mut self,
        tensor: &str,
        rows: Range<usize>,
        out: &mut [T],
    ) -> Result<(), DataError> {
        let idx = self.find_kind(tensor, T::KIND)?;
        self.check_out(idx, rows.len(), out.len())?;
        self.read_block(idx, rows, out)
    }

    /// Reads the rows of the given indices, in that order, repeats allowed, into `out`,
    /// `[rows.len(), width]`, row-major. Runs of consecutive indices are read in one piece.
    ///
    /// Fails as [`DatasetReader::read_rows`] does.
    pub fn read_rows_at<T: Element>(
        &mut self,
        tensor: &str,
        rows: &[usize],
        out: &mut [T],
    ) -> Result<(), DataError> {
        let idx = self.find_kind(tensor, T::KIND)?;
        self.check_out(idx, rows.len(), out.len())?;
        let width = self.tensors[idx].width;
        let mut done = 0;
        for run in rows.chunk_by(|a, b| a.checked_add(1) == Some(*b)) {
            let block = &mut out[done * width..(done + run.len()) * width];
            // The end saturates so that an absurd index reaches the check in `read_block`.
            self.read_block(idx, run[0]..run[0].saturating_add(run.len()), block)?;
            done += run.len();
        }
        Ok(())
    }

    fn find(&self, tensor: &str) -> Result<usize, DataError> {
        self.tensors.iter().position(|t| t.name == tensor).ok_or_else(|| DataError::NoSuchTensor {
            path: self.path.clone(),
            tensor: tensor.to_owned(),
            available: self.tensor_names().map(str::to_owned).collect(),
        })
    }

    fn find_kind(&self, tensor: &str, asked: ElementKind) -> Result<usize, DataError> {
        let idx = self.find(tensor)?;
        if self.tensors[idx].kind == asked {
            return Ok(idx);
        }
        Err(DataError::ElementKind {
            path: self.path.clone(),
            tensor: tensor.to_owned(),
            held: self.tensors[idx].kind,
            asked,
        })
    }

    fn check_out(&self, idx: usize, n_rows: usize, got: usize) -> Result<(), DataError> {
        let stored = &self.tensors[idx];
        let expected = n_rows.saturating_mul(stored.width);
        if got == expected {
            return Ok(());
        }
        Err(DataError::SliceLength {
            path: self.path.clone(),
            tensor: stored.name.clone(),
            width: stored.width,
            expected,
            got,
        })
    }

    fn read_block<T: Element>(
        &mut self,
        idx: usize,
        rows: Range<usize>,
        out: &mut [T],
    ) -> Result<(), DataError> {
        let stored = &self.tensors[idx];
        if rows.end > self.n {
            return Err(DataError::RowOutOfRange {
                path: self.path.clone(),
                tensor: stored.name.clone(),
                row: rows.start.max(self.n),
                n: self.n,
            });
        }
        let first = stored.start + (rows.start * stored.width * ELEMENT_BYTES) as u64;
        let failed = |e| DataError::io("read", &self.path)(e);
        self.file.seek(SeekFrom::Start(first)).map_err(failed)?;
        for (nth, piece) in out.chunks_mut(PIECE).enumerate() {
            self.bytes.resize(piece.len() * ELEMENT_BYTES, 0);
            self.file.read_exact(&mut self.bytes).map_err(failed)?;
            let (numbers, _) = self.bytes.as_chunks::<ELEMENT_BYTES>();
            for (value, number) in piece.iter_mut().zip(numbers) {
                *value = T::from_le(*number);
            }
            if let Some((at, value)) = first_not_finite(piece) {
                let at = nth * PIECE + at;
                return Err(DataError::NotFinite {
                    path: self.path.clone(),
                    tensor: stored.name.clone(),
                    row: rows.start + at / stored.width,
                    column: at % stored.width,
                    value,
                });
            }
        }
        Ok(())
    }
}

fn read_header(path: &Path, file: &mut File) -> Result<(Metadata, u64), DataError> {
    let bad = |detail: String| DataError::Header { path: path.to_path_buf(), detail };
    let mut length = [0; 8];
    file.read_exact(&mut length)
        .map_err(|e| bad(format!("the first eight bytes are missing ({e})")))?;
    let n_bytes = u64::from_le_bytes(length);
    if n_bytes > MAX_HEADER_BYTES {
        return Err(bad(format!("it promises a header of {n_bytes} bytes")));
    }
    let mut json = vec![0; n_bytes as usize];
    file.read_exact(&mut json)
        .map_err(|e| bad(format!("the header of {n_bytes} bytes is cut off ({e})")))?;
    let metadata: Metadata = serde_json::from_slice(&json).map_err(|e| bad(e.to_string()))?;
    Ok((metadata, 8 + n_bytes))
}

fn stored_tensor(
    path: &Path,
    name: &str,
    info: &TensorInfo,
    n: usize,
    data_start: u64,
) -> Result<StoredTensor, DataError> {
    match (info.shape.as_slice(), ElementKind::from_dtype(info.dtype)) {
        (&[rows, width], Some(kind)) if rows == n && width >= 1 => Ok(StoredTensor {
            name: name.to_owned(),
            kind,
            width,
            start: data_start + info.data_offsets.0 as u64,
        }),
        _ => Err(DataError::Shape {
            path: path.to_path_buf(),
            tensor: name.to_owned(),
            shape: info.shape.clone(),
            n,
        }),
    }
}
