//! In place of products in bfloat16 where the processor has none.

use crate::train::view::View;

/// Rows of a tile.
pub(super) const TILE_ROWS: usize = 16;

/// The left matrix of a product.
#[derive(Default)]
pub(super) struct Left;

/// The right matrix of a product.
#[derive(Default)]
pub(super) struct Right;

/// A unit that no processor of this kind has.
#[derive(Clone, Copy, Debug)]
pub(super) enum Bf16Unit {}

impl Bf16Unit {
    pub(super) fn detect() -> Option<Self> {
        None
    }

    pub(super) fn pack_left(self, _: &mut Left, _: View<'_>) {
        match self {}
    }

    pub(super) fn pack_right(self, _: &mut Right, _: View<'_>) {
        match self {}
    }

    pub(super) fn multiply(self, _: &Left, _: usize, _: &Right, _: usize, _: &mut [f32]) {
        match self {}
    }
}
