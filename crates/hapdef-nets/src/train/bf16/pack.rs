//! Matrices rounded to bfloat16 and laid out as tiles read them.

#![expect(
    unsafe_code,
    reason = "calls of functions that need a processor's extension; each says why it is sound"
)]

use std::ops::Range;

use rayon::prelude::*;

use super::dot::Dot;
use super::{
    BLOCK_GROUPS, GROUP_PAIRS, Left, LeftGroup, Right, RightGroup, TILE_COLUMNS, TILE_ROWS,
};
use crate::train::view::View;

/// Columns of the depth in a group.
const GROUP_DEPTH: usize = 2 * GROUP_PAIRS;

/// Panels that one thread packs between two looks for more work.
const PACK_GRAIN: usize = 4;

/// The pairs of a group for 16 rows of a matrix.
type Square = [[u32; GROUP_PAIRS]; GROUP_PAIRS];

impl Dot {
    /// Packs `[rows, depth]` as the left matrix.
    pub(super) fn pack_left(self, left: &mut Left, matrix: View<'_>) {
        left.n_groups = matrix.columns.div_ceil(GROUP_DEPTH);
        let n_panels = matrix.rows.div_ceil(TILE_ROWS);
        let empty = [[0; GROUP_PAIRS]; TILE_ROWS];
        left.groups.resize(n_panels * left.n_groups, empty);
        let panels = left.groups.par_chunks_exact_mut(left.n_groups.max(1));
        let panels = panels.enumerate().with_min_len(PACK_GRAIN);
        panels.for_each(|(i, groups)| {
            let rows = i * TILE_ROWS..((i + 1) * TILE_ROWS).min(matrix.rows);
            // SAFETY: `Dot` exists only where `detect` found the extensions.
            unsafe { left_panel(groups, matrix, rows) }
        });
    }

    /// Packs `[columns, depth]`, that is the transpose of the right matrix.
    pub(super) fn pack_right(self, right: &mut Right, matrix: View<'_>) {
        right.n_groups = matrix.columns.div_ceil(GROUP_DEPTH);
        right.n_panels = matrix.rows.div_ceil(TILE_COLUMNS);
        let n_blocks = right.n_groups.div_ceil(BLOCK_GROUPS);
        let empty = [[0; TILE_COLUMNS]; GROUP_PAIRS];
        let n_groups = n_blocks * right.n_panels * BLOCK_GROUPS;
        right.groups.resize(n_groups, empty);
        let n_panels = right.n_panels.max(1);
        if matrix.transposed {
            let blocks = right.groups.par_chunks_exact_mut(n_panels * BLOCK_GROUPS);
            blocks.enumerate().for_each(|(block, groups)| {
                // SAFETY: `Dot` exists only where `detect` found the extensions.
                unsafe { right_block(groups, matrix, block) }
            });
        } else {
            let panels = right.groups.par_chunks_exact_mut(BLOCK_GROUPS).enumerate();
            panels.with_min_len(PACK_GRAIN).for_each(|(i, groups)| {
                // SAFETY: `Dot` exists only where `detect` found the extensions.
                unsafe { right_panel(groups, matrix, i / n_panels, i % n_panels) }
            });
        }
    }
}

/// Some rows of the left matrix, whole.
#[target_feature(enable = "avx512f,avx512bw")]
fn left_panel(groups: &mut [LeftGroup], matrix: View<'_>, rows: Range<usize>) {
    let mut square = [[0; GROUP_PAIRS]; GROUP_PAIRS];
    for (i, group) in groups.iter_mut().enumerate() {
        if matrix.transposed {
            let zeros = [0.0; TILE_ROWS];
            let column = |c: usize| match c < matrix.columns {
                true => &matrix.values()[c * matrix.rows + rows.start..c * matrix.rows + rows.end],
                false => &zeros[..rows.len()],
            };
            for (pair, words) in square.iter_mut().enumerate() {
                let first = i * GROUP_DEPTH + 2 * pair;
                interleave(words, column(first), column(first + 1));
            }
            transpose(&square, group, 0);
        } else {
            fill(group, matrix, rows.clone(), i);
        }
    }
}

/// A panel of columns within a block of groups, from columns that are contiguous.
#[target_feature(enable = "avx512f,avx512bw")]
fn right_panel(groups: &mut [RightGroup], matrix: View<'_>, block: usize, panel: usize) {
    for at in (0..TILE_COLUMNS).step_by(GROUP_PAIRS) {
        let first = (panel * TILE_COLUMNS + at).min(matrix.rows);
        let lanes = first..(first + GROUP_PAIRS).min(matrix.rows);
        let mut square = [[0; GROUP_PAIRS]; GROUP_PAIRS];
        for (i, group) in groups.iter_mut().enumerate() {
            fill(&mut square, matrix, lanes.clone(), block * BLOCK_GROUPS + i);
            transpose(&square, group, at);
        }
    }
}

/// All panels of a block of groups, from a matrix of which one depth of all columns is contiguous.
#[target_feature(enable = "avx512f,avx512bw")]
fn right_block(groups: &mut [RightGroup], matrix: View<'_>, block: usize) {
    let zeros = vec![0.0; matrix.rows];
    let depth = |c: usize| match c < matrix.columns {
        true => &matrix.values()[c * matrix.rows..(c + 1) * matrix.rows],
        false => &zeros,
    };
    for i in 0..BLOCK_GROUPS {
        for pair in 0..GROUP_PAIRS {
            let first = (block * BLOCK_GROUPS + i) * GROUP_DEPTH + 2 * pair;
            let (a, b) = (depth(first), depth(first + 1));
            let both = a.chunks(TILE_COLUMNS).zip(b.chunks(TILE_COLUMNS));
            for (panel, (a, b)) in groups.chunks_exact_mut(BLOCK_GROUPS).zip(both) {
                interleave(&mut panel[i][pair], a, b);
            }
        }
    }
}

/// `square` becomes group `i` of up to 16 rows that are contiguous; 0 beyond the matrix.
#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
fn fill(square: &mut Square, matrix: View<'_>, rows: Range<usize>, i: usize) {
    let from = (i * GROUP_DEPTH).min(matrix.columns);
    let to = (from + GROUP_DEPTH).min(matrix.columns);
    if rows.len() < GROUP_PAIRS || to - from < GROUP_DEPTH {
        *square = [[0; GROUP_PAIRS]; GROUP_PAIRS];
    }
    for (words, row) in square.iter_mut().zip(rows) {
        let row = &matrix.values()[row * matrix.columns + from..row * matrix.columns + to];
        let (pairs, rest) = row.as_chunks::<2>();
        for (pair, [a, b]) in words.iter_mut().zip(pairs) {
            *pair = word(*a, *b);
        }
        if let [last] = rest {
            words[pairs.len()] = word(*last, 0.0);
        }
    }
}

/// One pair of every lane, 0 beyond the last.
#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
fn interleave<const N: usize>(words: &mut [u32; N], a: &[f32], b: &[f32]) {
    if let (Ok(a), Ok(b)) = (<&[f32; N]>::try_from(a), <&[f32; N]>::try_from(b)) {
        for ((pair, a), b) in words.iter_mut().zip(a).zip(b) {
            *pair = word(*a, *b);
        }
    } else {
        words.fill(0);
        for ((pair, a), b) in words.iter_mut().zip(a).zip(b) {
            *pair = word(*a, *b);
        }
    }
}

/// Columns `at` and on of `group` become the rows of `square`.
#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
fn transpose<const N: usize>(square: &Square, group: &mut [[u32; N]; GROUP_PAIRS], at: usize) {
    for (pair, row) in group.iter_mut().enumerate() {
        for (to, words) in row[at..at + GROUP_PAIRS].iter_mut().zip(square) {
            *to = words[pair];
        }
    }
}

/// Two numbers rounded to bfloat16, the first in the lower half.
#[inline]
fn word(a: f32, b: f32) -> u32 {
    rounded(a) >> 16 | rounded(b) & 0xffff_0000
}

/// The bits of a number with the upper half rounded to nearest, ties to even. The lower half is
/// left as it comes.
#[inline]
fn rounded(value: f32) -> u32 {
    let bits = value.to_bits();
    bits.wrapping_add(0x7fff + (bits >> 16 & 1))
}
