//! Slices of candle tensors: reading them, and changing them in place.

use std::cell::Cell;

use candle_core::{CpuStorage, InplaceOp1, InplaceOp2, Layout, Result, Storage, Tensor, bail};

/// Hands the values of a contiguous CPU tensor to `f`.
pub(super) fn read<R>(tensor: &Tensor, f: impl FnOnce(&[f32]) -> R) -> Result<R> {
    let (storage, layout) = tensor.storage_and_layout();
    match &*storage {
        Storage::Cpu(storage) => Ok(f(values(storage, layout)?)),
        _ => bail!("the tensor is not on the CPU"),
    }
}

/// Lets `f` change the values of a contiguous CPU tensor.
pub(super) fn edit(tensor: &Tensor, f: impl FnOnce(&mut [f32])) -> Result<()> {
    tensor.inplace_op1(&Once(Cell::new(Some(f))))
}

/// Lets `f` change the values of a contiguous CPU tensor, given those of another.
pub(super) fn edit_with(
    tensor: &Tensor,
    other: &Tensor,
    f: impl FnOnce(&mut [f32], &[f32]),
) -> Result<()> {
    tensor.inplace_op2(other, &OnceWith(Cell::new(Some(f))))
}

/// An operation that runs once; candle asks for one that could run often.
struct Once<F>(Cell<Option<F>>);

struct OnceWith<F>(Cell<Option<F>>);

impl<F: FnOnce(&mut [f32])> InplaceOp1 for Once<F> {
    fn name(&self) -> &'static str {
        "edit"
    }

    fn cpu_fwd(&self, storage: &mut CpuStorage, layout: &Layout) -> Result<()> {
        let target = values_mut(storage, layout)?;
        if let Some(f) = self.0.take() {
            f(target);
        }
        Ok(())
    }
}

impl<F: FnOnce(&mut [f32], &[f32])> InplaceOp2 for OnceWith<F> {
    fn name(&self) -> &'static str {
        "edit_with"
    }

    fn cpu_fwd(
        &self,
        storage: &mut CpuStorage,
        layout: &Layout,
        other: &CpuStorage,
        other_layout: &Layout,
    ) -> Result<()> {
        let (target, other) = (values_mut(storage, layout)?, values(other, other_layout)?);
        if let Some(f) = self.0.take() {
            f(target, other);
        }
        Ok(())
    }
}

fn values<'a>(storage: &'a CpuStorage, layout: &Layout) -> Result<&'a [f32]> {
    match (storage, layout.contiguous_offsets()) {
        (CpuStorage::F32(all), Some((start, end))) => Ok(&all[start..end]),
        _ => bail!("the tensor is not a contiguous block of f32"),
    }
}

fn values_mut<'a>(storage: &'a mut CpuStorage, layout: &Layout) -> Result<&'a mut [f32]> {
    match (storage, layout.contiguous_offsets()) {
        (CpuStorage::F32(all), Some((start, end))) => Ok(&mut all[start..end]),
        _ => bail!("the tensor is not a contiguous block of f32"),
    }
}
