//! The residual of a block of solutions, one row of the matrix after the other.
//!
//! A row's product stays in registers until its norms are taken; nothing but the solution is read
//! from memory, and nothing is written unless the residual itself is wanted.

use pulp::{Arch, Simd, WithSimd};

use crate::factor::analysis::Analysis;
use crate::factor::panel::{Columns, Three, Wide as _, add_row, for_vectors, load, store, zero};
use crate::system::assembly::BlockMatrix;

/// What a load is on one unknown three-vector, in one column.
#[derive(Clone, Copy)]
pub(crate) struct Entry {
    pub(crate) place: u32,
    pub(crate) column: u32,
    pub(crate) force: [f64; 3],
}

impl Entry {
    pub(crate) fn place(&self) -> usize {
        self.place as usize
    }
}

/// Norms per column; a NaN in a residual makes its square sum NaN, not its maximum.
#[derive(Default)]
pub(crate) struct Norms {
    /// Σ r², for r = b − K x.
    pub(crate) left_squares: Vec<f64>,
    /// The largest |s r|, with s the Jacobi scale.
    pub(crate) left_scaled: Vec<f64>,
    /// Σ b².
    pub(crate) loaded_squares: Vec<f64>,
    /// The largest |s b|.
    pub(crate) loaded_scaled: Vec<f64>,
    /// The largest |x / s|.
    pub(crate) moved_scaled: Vec<f64>,
}

/// b − K x for right-hand sides given by `entries`, ascending by place.
pub(crate) struct Residual<'a> {
    pub(crate) matrix: &'a BlockMatrix,
    pub(crate) analysis: &'a Analysis,
    /// The Jacobi scale of each equation.
    pub(crate) scale: &'a [f64],
    pub(crate) entries: &'a [Entry],
    pub(crate) x: &'a Columns,
}

impl Residual<'_> {
    /// Takes the norms; the residual itself goes to `keep` where there is one.
    pub(crate) fn norms(&self, keep: Option<&mut Columns>) -> Norms {
        let stride = self.x.stride();
        let mut norms = Norms::zeros(stride);
        let mut at_row = vec![0.0; 3 * stride + stride];
        let at_row = aligned(&mut at_row, 3 * stride);
        Arch::new().dispatch(Pass {
            residual: self,
            norms: &mut norms,
            keep: keep.map(Columns::values_mut),
            load: at_row,
        });
        norms
    }
}

fn aligned(buffer: &mut [f64], len: usize) -> &mut [f64] {
    let offset = buffer.as_ptr().align_offset(64).min(buffer.len() - len);
    &mut buffer[offset..offset + len]
}

impl Norms {
    fn zeros(n: usize) -> Self {
        let zeros = || vec![0.0; n];
        Self {
            left_squares: zeros(),
            left_scaled: zeros(),
            loaded_squares: zeros(),
            loaded_scaled: zeros(),
            moved_scaled: zeros(),
        }
    }
}

struct Pass<'a, 'b> {
    residual: &'a Residual<'b>,
    norms: &'a mut Norms,
    keep: Option<&'a mut [f64]>,
    /// The load's three rows at one node.
    load: &'a mut [f64],
}

impl WithSimd for Pass<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Pass { residual, norms, mut keep, load: b } = self;
        let n = residual.x.stride() / S::F64_LANES;
        let x = S::as_simd_f64s(residual.x.values()).0;
        let mut entries = residual.entries;
        for node in 0..residual.analysis.n_nodes() {
            let here = entries.partition_point(|entry| entry.place as usize == node);
            if here > 0 {
                norms.add_load(&entries[..here], residual, b);
                entries = &entries[here..];
            }
            let s: [f64; 3] = std::array::from_fn(|c| residual.scale[3 * node + c]);
            let rows = Rows { residual, x, n, node, s };
            let keep = keep.as_deref_mut().map(|keep| {
                let len = 3 * residual.x.stride();
                S::as_mut_simd_f64s(&mut keep[node * len..(node + 1) * len]).0
            });
            rows.take(simd, S::as_simd_f64s(b).0, norms, keep);
            if here > 0 {
                b.fill(0.0);
            }
        }
    }
}

impl Norms {
    /// Writes the loads of one node to `b` and takes their norms.
    fn add_load(&mut self, entries: &[Entry], residual: &Residual<'_>, b: &mut [f64]) {
        let stride = residual.x.stride();
        for entry in entries {
            for c in 0..3 {
                b[c * stride + entry.column as usize] += entry.force[c];
            }
        }
        for c in 0..3 {
            let scale = residual.scale[3 * entries[0].place as usize + c];
            for (column, value) in b[c * stride..(c + 1) * stride].iter().enumerate() {
                self.loaded_squares[column] += value * value;
                self.loaded_scaled[column] = self.loaded_scaled[column].max((scale * value).abs());
            }
        }
    }
}

/// Three rows of the residual.
struct Rows<'a, 'b, V> {
    residual: &'a Residual<'b>,
    x: &'a [V],
    n: usize,
    node: usize,
    s: [f64; 3],
}

impl<V: Copy> Rows<'_, '_, V> {
    #[inline(always)]
    fn take<S: Simd<f64s = V>>(
        &self,
        simd: S,
        b: &[V],
        norms: &mut Norms,
        mut keep: Option<&mut [V]>,
    ) {
        let n = self.n;
        for_vectors!(simd, n, |at, N| {
            let sums: Three<S, N> = self.product::<S, N>(simd, at);
            let mut left = load::<S, N>(b, n, at);
            for r in 0..3 {
                for v in 0..N {
                    left[r][v] = simd.sub_f64s(left[r][v], sums[r][v]);
                }
            }
            if let Some(keep) = keep.as_deref_mut() {
                store::<S, N>(&left, keep, n, at);
            }
            let moved = load::<S, N>(&self.x[3 * self.node * n..], n, at);
            largest(simd, &mut norms.left_scaled, at, &left, self.s);
            largest(simd, &mut norms.moved_scaled, at, &moved, self.s.map(f64::recip));
            let squares = S::as_mut_simd_f64s(&mut norms.left_squares).0;
            for r in 0..3 {
                for v in 0..N {
                    squares[at + v] = simd.mul_add_e_f64s(left[r][v], left[r][v], squares[at + v]);
                }
            }
        });
    }

    /// The three rows of K x.
    #[inline(always)]
    fn product<S: Simd<f64s = V>, const N: usize>(&self, simd: S, at: usize) -> Three<S, N> {
        let (matrix, n, node) = (self.residual.matrix, self.n, self.node);
        let mut sums = zero::<S, N>(simd);
        for &(row, slot) in self.residual.analysis.column(node) {
            let a = &matrix.blocks[slot as usize];
            let x = &self.x[3 * row as usize * n..3 * (row as usize + 1) * n];
            for c in 0..3 {
                let a = [a[3 * c], a[3 * c + 1], a[3 * c + 2]];
                add_row(simd, &mut sums, a, &x[c * n + at..]);
            }
        }
        let pattern = &matrix.pattern;
        for slot in pattern.row_ptr[node]..pattern.row_ptr[node + 1] {
            let (a, column) = (&matrix.blocks[slot], pattern.columns[slot] as usize);
            let x = &self.x[3 * column * n..3 * (column + 1) * n];
            for c in 0..3 {
                add_row(simd, &mut sums, [a[c], a[3 + c], a[6 + c]], &x[c * n + at..]);
            }
        }
        sums
    }
}

/// Raises `so_far` to |scale · row| where that is larger.
#[inline(always)]
fn largest<S: Simd, const N: usize>(
    simd: S,
    so_far: &mut [f64],
    at: usize,
    rows: &Three<S, N>,
    scale: [f64; 3],
) {
    let so_far = &mut S::as_mut_simd_f64s(so_far).0[at..at + N];
    for r in 0..3 {
        let scale = simd.splat_f64s(scale[r]);
        for v in 0..N {
            let size = simd.abs_f64s(simd.mul_f64s(scale, rows[r][v]));
            so_far[v] = simd.max_f64s(so_far[v], size);
        }
    }
}
