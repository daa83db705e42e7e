//! The membrane: the ANDES triangle with drilling rotations, on a curved surface.
//!
//! Source: C. A. Felippa, A study of optimal membrane triangles with drilling freedoms, Comput.
//! Methods Appl. Mech. Eng. 192 (2003) 2125–2168, sections 4 and 5. Flat facets give that element,
//! written by its sides. On a curved surface a flat facet stretches when the surface bends, by a
//! strain of the order of h²κδκ that locks thin shells; two terms that vanish on flat meshes take it
//! away, see [`basic_strain`].

use nalgebra::{Matrix3, SMatrix, Vector3};

use super::facet::Facet;

/// α_b of the force lumping: the optimal value of Felippa (2003), table 2.
const ALPHA_B: f64 = 1.5;
/// β₀ of the higher-order stiffness: the floor that Felippa (2003), table 2, sets for the optimal
/// ½(1 − 4ν²). The optimum is exact for beams of rectangles, but stiffens distorted cells and thin
/// warped shells.
const BETA_0: f64 = 0.01;
/// β₁…β₉ of the optimal element OPT, Felippa (2003), table 2.
const BETA: [f64; 9] = [1.0, 2.0, 1.0, 0.0, 1.0, -1.0, -1.0, -1.0, -2.0];
/// Weight of the corners' common drilling rotation in the higher-order strain (1 in the source): it
/// holds the one mode that the steps between corners don't, and is not free of bending on a curved
/// surface.
const COMMON_DRILLING: f64 = 0.1;

/// Three strains or rotations by the twelve deformations.
pub(super) type ByDeformation = SMatrix<f64, 3, 12>;

/// The stiffness `[12, 12]` of the deformations for the plane-stress matrix `force_n_m` integrated
/// over the thickness, N/m.
pub(super) fn stiffness(facet: &Facet, force_n_m: &Matrix3<f64>) -> SMatrix<f64, 12, 12> {
    let basic = basic_strain(facet);
    let mut k = basic.transpose() * force_n_m * basic * facet.area_m2;
    let corners = corner_strains(facet);
    let drilling = corner_drilling(facet);
    // 9/4 β₀ ∫ of a linear strain by the mid-side rule
    let factor = 0.75 * BETA_0 * facet.area_m2;
    for i in 0..3 {
        let strain = (corners[i] + corners[(i + 1) % 3]) * 0.5 * drilling;
        k += strain.transpose() * force_n_m * strain * factor;
    }
    k
}

/// The element's mean membrane strain (ε₁₁, ε₂₂, γ₁₂).
///
/// The strain of the linear triangle, and two terms for each side p → q of length l:
/// - Felippa's force lumping (2003, equation 15), whose rows sum up by sides to
///   α_b/(12 A) s⊥ s⊥ᵀ Δθ. The step Δθ is ½(d_p + d_q)·(R_q − R_p) with the directors d, equal for
///   both neighbours of the side and zero in inextensional bending up to h³; on a flat mesh it is
///   the difference of the drilling rotations.
/// - (Δd·s)(Δβ·s)/12 as strain along the side, tied like the covariant strains of the MITC family:
///   the mean over the side of z′w′, the strain of a shallow arch (Marguerre 1938), for a height
///   and a deflection that are quadratic along it.
pub(super) fn basic_strain(facet: &Facet) -> ByDeformation {
    let mut b = ByDeformation::zeros();
    b.fixed_view_mut::<3, 3>(0, 0).fill_with_identity();
    let from_sides = strain_from_sides(facet);
    for i in 0..3 {
        let j = (i + 1) % 3;
        let side = facet.side(i);
        let across = Vector3::new(side.y * side.y, side.x * side.x, -2.0 * side.x * side.y);
        b += across * facet.drilling_step(i) * (ALPHA_B / (12.0 * facet.area_m2));
        let bow = (facet.lean(j, &side) - facet.lean(i, &side)) / (12.0 * side.norm_squared());
        for (end, sign) in [(i, -1.0), (j, 1.0)] {
            for axis in 0..2 {
                let mut column = b.column_mut(6 + 2 * end + axis);
                column += from_sides.column(i) * (sign * bow * side[axis]);
            }
        }
    }
    b
}

/// The drilling rotations of the corners, built from the steps between them.
fn corner_drilling(facet: &Facet) -> ByDeformation {
    let steps = [0, 1, 2].map(|i| facet.drilling_step(i));
    let mut d = ByDeformation::zeros();
    for i in 0..3 {
        d.set_row(i, &((steps[(i + 2) % 3] - steps[i]) / 3.0));
        for j in 0..3 {
            d[(i, 3 + j)] += COMMON_DRILLING / 3.0;
        }
    }
    d
}

/// Strain (ε₁₁, ε₂₂, γ₁₂) by the strains along the three sides, Felippa (2003), equation 27.
fn strain_from_sides(facet: &Facet) -> Matrix3<f64> {
    let area = facet.area_m2;
    Matrix3::from_columns(&[0, 1, 2].map(|i| {
        let (p, q) = (facet.side((i + 1) % 3), facet.side((i + 2) % 3));
        Vector3::new(-p.y * q.y, -p.x * q.x, p.y * q.x + p.x * q.y)
            * (facet.side(i).norm_squared() / (4.0 * area * area))
    }))
}

/// The higher-order strains at the corners by their drilling rotations: T_e Q₁, T_e Q₂, T_e Q₃ of
/// Felippa (2003), equations 28–30.
fn corner_strains(facet: &Facet) -> [Matrix3<f64>; 3] {
    let from_sides = strain_from_sides(facet);
    // rows of Q₁; Q₂ and Q₃ follow by turning rows and columns with the corners
    [0, 1, 2].map(|corner| {
        let along_sides = Matrix3::from_fn(|side, node| {
            let row = (side + 3 - corner) % 3;
            let column = (node + 3 - corner) % 3;
            BETA[3 * row + column] * 2.0 * facet.area_m2 / (3.0 * facet.side(side).norm_squared())
        });
        from_sides * along_sides
    })
}
