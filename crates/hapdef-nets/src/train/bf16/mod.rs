//! Products of matrices rounded to bfloat16, summed in 32 bits, where the processor multiplies them
//! itself: tile by tile (AMX) or register by register (AVX-512 BF16).
//!
//! bfloat16 is the upper half of an f32: the same range, 8 significant bits. One instruction adds
//! two products or more to a sum, so two neighbours along the summed direction (a pair) share a
//! 32-bit word. Both matrices are packed once ([`Left`], [`Right`]) in the order in which either
//! unit reads them, and a tile of 16 × 48 sums is computed at a time.
//!
//! Every sum runs over the pairs in one order, in blocks of a fixed number, whatever the threads
//! do: a product has the same bits on any number of threads.

mod amx;
mod dot;
mod pack;

use crate::train::view::View;

/// Rows of a tile.
pub(super) const TILE_ROWS: usize = 16;

/// Columns of a tile.
const TILE_COLUMNS: usize = 48;

/// Pairs of a group: a row of a group fills 64 bytes.
const GROUP_PAIRS: usize = 16;

/// Groups of a block: those of a panel of columns fill half of a core's nearest cache, and every
/// panel of rows meets them there.
const BLOCK_GROUPS: usize = 8;

/// The pairs of one group: one row of the left matrix after the other, or one column of the right
/// matrix beside the other.
type LeftGroup = [[u32; GROUP_PAIRS]; TILE_ROWS];
type RightGroup = [[u32; TILE_COLUMNS]; GROUP_PAIRS];

/// Sums of the products of a panel of rows and a panel of columns.
type Tile = [[f32; TILE_COLUMNS]; TILE_ROWS];

/// Where the sums of a tile go: whole rows of the result, at a column.
struct Target<'a> {
    rows: &'a mut [f32],
    columns: usize,
    at: usize,
    /// Whether the sums replace what is there; they are added to it otherwise.
    is_first: bool,
}

/// The left matrix of a product: panel after panel of [`TILE_ROWS`] rows, each group after group.
#[derive(Default)]
pub(super) struct Left {
    groups: Vec<LeftGroup>,
    n_groups: usize,
}

/// The right matrix of a product: block after block of [`BLOCK_GROUPS`] groups, within each panel
/// after panel of [`TILE_COLUMNS`] columns. The last block may have groups that are not used.
#[derive(Default)]
pub(super) struct Right {
    groups: Vec<RightGroup>,
    n_groups: usize,
    n_panels: usize,
}

/// Proof that the processor has the instructions, and which.
#[derive(Clone, Copy, Debug)]
pub(super) enum Bf16Unit {
    /// AMX.
    Tiles(dot::Dot, amx::Amx),
    /// AVX-512 BF16.
    Registers(dot::Dot),
}

impl Bf16Unit {
    /// The fastest unit that the processor has, if it has one.
    pub(super) fn detect() -> Option<Self> {
        let dot = dot::Dot::detect()?;
        Some(match amx::Amx::detect() {
            Some(amx) => Self::Tiles(dot, amx),
            None => Self::Registers(dot),
        })
    }

    /// Packs `[rows, depth]` as the left matrix.
    pub(super) fn pack_left(self, left: &mut Left, matrix: View<'_>) {
        self.dot().pack_left(left, matrix);
    }

    /// Packs `[columns, depth]`, that is the transpose of the right matrix.
    pub(super) fn pack_right(self, right: &mut Right, matrix: View<'_>) {
        self.dot().pack_right(right, matrix);
    }

    /// `out`, `[rows, columns]` row-major, becomes the product of `rows` rows of `left`, from row
    /// `first_row` on (a multiple of [`TILE_ROWS`]), and `right`.
    pub(super) fn multiply(
        self,
        left: &Left,
        first_row: usize,
        right: &Right,
        columns: usize,
        out: &mut [f32],
    ) {
        let product =
            Product { left: &left.groups[first_row / TILE_ROWS * left.n_groups..], right, columns };
        match self {
            Self::Tiles(_, amx) => amx.with_tiles(|tiles| {
                product.write(out, |target, a, b| tiles.multiply(target, a, b));
            }),
            Self::Registers(dot) => product.write(out, |target, a, b| dot.multiply(target, a, b)),
        }
    }

    fn dot(self) -> dot::Dot {
        match self {
            Self::Tiles(dot, _) | Self::Registers(dot) => dot,
        }
    }
}

/// Panels of rows times panels of columns.
struct Product<'a> {
    left: &'a [LeftGroup],
    right: &'a Right,
    columns: usize,
}

impl Product<'_> {
    /// Tile after tile, each by `multiply`.
    fn write(&self, out: &mut [f32], multiply: impl Fn(Target<'_>, &[LeftGroup], &[RightGroup])) {
        let n_groups = self.right.n_groups;
        let n_panels = self.right.n_panels;
        for j in 0..n_panels {
            let blocks = self.right.groups.chunks_exact(BLOCK_GROUPS);
            let blocks = blocks.skip(j).step_by(n_panels);
            for (from, b) in (0..n_groups).step_by(BLOCK_GROUPS).zip(blocks) {
                let groups = from..(from + BLOCK_GROUPS).min(n_groups);
                let panels = self.left.chunks_exact(n_groups);
                for (rows, a) in out.chunks_mut(TILE_ROWS * self.columns).zip(panels) {
                    let target = Target {
                        rows,
                        columns: self.columns,
                        at: j * TILE_COLUMNS,
                        is_first: from == 0,
                    };
                    multiply(target, &a[groups.clone()], &b[..groups.len()]);
                }
            }
        }
    }
}

impl Target<'_> {
    /// Whether all of a tile lies within the result.
    fn is_whole(&self) -> bool {
        self.rows.len() == TILE_ROWS * self.columns && self.at + TILE_COLUMNS <= self.columns
    }

    /// The sums so far.
    fn read(&self, tile: &mut Tile) {
        if !self.is_first {
            let width = TILE_COLUMNS.min(self.columns - self.at);
            for (row, sums) in self.rows.chunks_exact(self.columns).zip(tile) {
                sums[..width].copy_from_slice(&row[self.at..self.at + width]);
            }
        }
    }

    /// Takes the sums; what lies beyond the result is left out.
    fn write(&mut self, tile: &Tile) {
        let width = TILE_COLUMNS.min(self.columns - self.at);
        for (row, sums) in self.rows.chunks_exact_mut(self.columns).zip(tile) {
            row[self.at..self.at + width].copy_from_slice(&sums[..width]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both units sum the same rounded products; only the order differs.
    #[test]
    fn tiles_and_registers_agree() {
        let Some(Bf16Unit::Tiles(dot, amx)) = Bf16Unit::detect() else {
            return;
        };
        let (m, n, k) = (83, 101, 777);
        let wave = |n: usize, f: f32| (0..n).map(|i| (f * i as f32).sin()).collect::<Vec<_>>();
        let (a, b) = (wave(m * k, 0.37), wave(n * k, 0.11));
        let (mut left, mut right) = (Left::default(), Right::default());
        let units = [Bf16Unit::Tiles(dot, amx), Bf16Unit::Registers(dot)];
        let [tiles, registers] = units.map(|unit| {
            unit.pack_left(&mut left, View::new(&a, m, k));
            unit.pack_right(&mut right, View::new(&b, n, k));
            let mut out = vec![f32::NAN; m * n];
            unit.multiply(&left, 0, &right, n, &mut out);
            out
        });
        for (t, r) in tiles.iter().zip(&registers) {
            assert!((t - r).abs() < 1e-3, "{t} {r}");
        }
    }
}
