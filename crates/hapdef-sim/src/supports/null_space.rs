//! The motions that a set of constraints leaves free, in a basis that people can read.

use nalgebra::{DMatrix, SymmetricEigen, Vector3};

/// Singular values below this share of the largest count as free.
const FREE_BELOW: f64 = 1e-6;

/// Columns spanning the null space of a Gram matrix.
pub(crate) fn null_space(gram: DMatrix<f64>) -> DMatrix<f64> {
    let eigen = SymmetricEigen::new(gram);
    let limit = FREE_BELOW * FREE_BELOW * eigen.eigenvalues.amax();
    let free: Vec<usize> =
        (0..eigen.eigenvalues.len()).filter(|&i| eigen.eigenvalues[i] <= limit).collect();
    eigen.eigenvectors.select_columns(&free)
}

/// A basis (translation, rotation) of the span of `modes` `[6, n]` with single rotations and
/// translations where there are such: reduced row echelon form, rotations first.
pub(crate) fn readable_basis(modes: &DMatrix<f64>) -> Vec<(Vector3<f64>, Vector3<f64>)> {
    let mut rows: Vec<[f64; 6]> =
        modes.column_iter().map(|m| [m[3], m[4], m[5], m[0], m[1], m[2]]).collect();
    let mut rank = 0;
    for column in 0..6 {
        let Some(pivot) = (rank..rows.len())
            .max_by(|&a, &b| rows[a][column].abs().total_cmp(&rows[b][column].abs()))
        else {
            break;
        };
        if rows[pivot][column].abs() < 1e-3 {
            continue;
        }
        rows.swap(rank, pivot);
        let scale = rows[rank][column];
        let lead = rows[rank].map(|v| v / scale);
        for row in &mut rows {
            let factor = row[column];
            for (v, l) in row.iter_mut().zip(lead) {
                *v -= factor * l;
            }
        }
        rows[rank] = lead;
        rank += 1;
    }
    let clean = |v: f64| if v.abs() < 1e-9 { 0.0 } else { v };
    rows[..rank]
        .iter()
        .map(|r| r.map(clean))
        .map(|r| (Vector3::new(r[3], r[4], r[5]), Vector3::new(r[0], r[1], r[2])))
        .collect()
}
