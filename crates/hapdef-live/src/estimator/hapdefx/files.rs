//! The chain as files of a bundle.

use std::collections::BTreeMap;

use hapdef_kmax::KMaxGraph;
use hapdef_nets::Net;
use safetensors::tensor::{TensorView, serialize};
use safetensors::{Dtype, SafeTensorError, SafeTensors};

use super::{ChainNets, Hapdefx};
use crate::error::LiveError;

/// Names of the files.
const TRANSFER: &str = "transfer.safetensors";
const RECONSTRUCTION: &str = "reconstruction.safetensors";
const SENSITIVITY: &str = "sensitivity.safetensors";
const PLACES: &str = "places.safetensors";

/// Tensors of the places: positions `[n_surface, 3]`; the neighbours of all nodes, node by node, and
/// how many each has `[n_surface]`; the floor `[1]`.
const POINTS: &str = "points_m";
const NEIGHBOURS: &str = "neighbours";
const N_NEIGHBOURS: &str = "n_neighbours";
const FLOOR: &str = "floor_um";

impl Hapdefx {
    /// The chain as files by name; the same chain always gives the same bytes.
    ///
    /// # Errors
    /// [`LiveError::Net`] or [`LiveError::NotABundle`] when a file can't be made.
    pub fn to_files(&self) -> Result<BTreeMap<String, Vec<u8>>, LiveError> {
        let files = [
            (TRANSFER, self.nets.transfer.to_bytes()?),
            (RECONSTRUCTION, self.nets.reconstruction.to_bytes()?),
            (SENSITIVITY, self.nets.sensitivity.to_bytes()?),
            (PLACES, self.places().map_err(|e| refused(e.to_string()))?),
        ];
        let named = files.map(|(name, bytes)| (name.to_owned(), bytes));
        Ok(named.into_iter().collect())
    }

    /// The chain of such files, bit for bit.
    ///
    /// # Errors
    /// [`LiveError::NotABundle`] when a file is missing or no such file; as [`Hapdefx::new`].
    pub fn from_files(files: &BTreeMap<String, Vec<u8>>) -> Result<Self, LiveError> {
        let file = |name: &str| {
            let bytes = files.get(name);
            bytes.ok_or_else(|| refused(format!("its nets lack {name}")))
        };
        let net = |name: &str| Ok::<Net, LiveError>(Net::from_bytes(file(name)?, name)?);
        let nets = ChainNets {
            transfer: net(TRANSFER)?,
            reconstruction: net(RECONSTRUCTION)?,
            sensitivity: net(SENSITIVITY)?,
        };
        let places = Places::open(file(PLACES)?)?;
        let points = places.numbers(POINTS, f64::from_le_bytes)?;
        let points = points.as_chunks::<3>().0.to_vec();
        Self::new(nets, places.graph()?, points, places.floor_um()?)
    }

    fn places(&self) -> Result<Vec<u8>, SafeTensorError> {
        let n = self.points_m.len();
        let points = self.points_m.iter().flatten();
        let points: Vec<u8> = points.flat_map(|x| x.to_le_bytes()).collect();
        let rows = (0..n).map(|node| self.graph.neighbours(node).count() as u32);
        let rows: Vec<u8> = rows.flat_map(u32::to_le_bytes).collect();
        let neighbours = (0..n).flat_map(|node| self.graph.neighbours(node));
        let neighbours: Vec<u8> = neighbours.flat_map(|j| (j as u32).to_le_bytes()).collect();
        let floor = self.floor_um.to_le_bytes();
        let (u32s, f64s) = (Dtype::U32, Dtype::F64);
        let views = [
            (POINTS, TensorView::new(f64s, vec![n, 3], &points)?),
            (N_NEIGHBOURS, TensorView::new(u32s, vec![n], &rows)?),
            (NEIGHBOURS, TensorView::new(u32s, vec![neighbours.len() / 4], &neighbours)?),
            (FLOOR, TensorView::new(Dtype::F32, vec![1], &floor)?),
        ];
        serialize(views, None)
    }
}

/// The file of places.
struct Places<'a> {
    tensors: SafeTensors<'a>,
}

impl<'a> Places<'a> {
    fn open(bytes: &'a [u8]) -> Result<Self, LiveError> {
        let tensors = SafeTensors::deserialize(bytes);
        Ok(Self { tensors: tensors.map_err(|e| refused(format!("{PLACES}: {e}")))? })
    }

    fn graph(&self) -> Result<KMaxGraph, LiveError> {
        let neighbours = self.numbers(NEIGHBOURS, u32::from_le_bytes)?;
        let (mut rows, mut rest) = (Vec::new(), &neighbours[..]);
        for n in self.numbers(N_NEIGHBOURS, u32::from_le_bytes)? {
            let (row, after) = rest.split_at_checked(n as usize).ok_or_else(|| {
                let found = neighbours.len();
                refused(format!("{PLACES}: {NEIGHBOURS}: {found} are too few"))
            })?;
            rows.push(row.iter().copied());
            rest = after;
        }
        Ok(KMaxGraph::from_neighbours(rows)?)
    }

    fn floor_um(&self) -> Result<f32, LiveError> {
        let floor = self.numbers(FLOOR, f32::from_le_bytes)?;
        let floor = floor.first().copied().filter(|floor| floor.is_finite());
        floor.ok_or_else(|| refused(format!("{PLACES}: {FLOOR} is no number")))
    }

    /// All numbers of a tensor, of `N` bytes each.
    fn numbers<T, const N: usize>(
        &self,
        name: &str,
        of: impl Fn([u8; N]) -> T,
    ) -> Result<Vec<T>, LiveError> {
        let tensor = self.tensors.tensor(name);
        let tensor = tensor.map_err(|e| refused(format!("{PLACES}: {name}: {e}")))?;
        let (words, _) = tensor.data().as_chunks::<N>();
        Ok(words.iter().map(|word| of(*word)).collect())
    }
}

fn refused(what: String) -> LiveError {
    LiveError::NotABundle { file: "the paper's chain".to_owned(), what }
}
