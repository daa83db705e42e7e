//! Products of matrices in 32 bits, by the crate gemm.

#![expect(unsafe_code, reason = "gemm takes pointers; the one call is here, after its checks")]

use gemm::{Parallelism, gemm};

use crate::train::view::View;

/// `out`, `[left.rows, right.columns]` row-major, becomes the product. Its bits don't depend on the
/// number of threads.
pub(super) fn multiply(left: View<'_>, right: View<'_>, out: &mut [f32]) {
    let (m, k, n) = (left.rows, left.columns, right.columns);
    assert_eq!(k, right.rows, "depth of a product");
    assert_eq!(out.len(), m * n, "values of a product");
    let [left_row, left_column] = strides(left);
    let [right_row, right_column] = strides(right);
    // SAFETY: a `View` holds rows × columns values, and its strides reach each of them and no
    // other; `out` holds m × n and is borrowed alone; the pointers live through the call.
    unsafe {
        gemm(
            m,
            n,
            k,
            out.as_mut_ptr(),
            1,
            n.cast_signed(),
            false,
            left.values().as_ptr(),
            left_column,
            left_row,
            right.values().as_ptr(),
            right_column,
            right_row,
            0.0_f32,
            1.0_f32,
            false,
            false,
            false,
            Parallelism::Rayon(rayon::current_num_threads()),
        );
    }
}

/// Distance of neighbours down a column and along a row, in values.
fn strides(view: View<'_>) -> [isize; 2] {
    match view.transposed {
        true => [1, view.rows.cast_signed()],
        false => [view.columns.cast_signed(), 1],
    }
}
