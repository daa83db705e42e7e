//! Rows that are wanted of every solution, and the one solution that checks them all.

use hapdef_mesh::FeNodeId;

use crate::factor::cholesky::Factor;
use crate::factor::panel::Columns;
use crate::supports::unknowns::{Link, Unknowns};
use crate::system::product::Entry;

/// Wanted rows of K x = b, and z = K⁻¹ w for a w of them.
///
/// K is symmetric, so wᵀ x = zᵀ b for every load b: a check of the wanted rows that needs no others
/// (R. Freivalds, Probabilistic machines can use less running time, IFIP Congress 1977, checks a
/// product in the same way).
pub(crate) struct Wanted {
    /// Supernodes on the paths from wanted rows to the root.
    pub(crate) supernodes: Vec<bool>,
    /// A reciprocity error above this asks for the full solution.
    pub(crate) doubt_above: f64,
    /// w: ±1 in each wanted row of the Jacobi-scaled system, ascending by place.
    weights: Vec<Entry>,
    /// z `[n_equations]`.
    adjoint: Vec<f64>,
    /// ‖ẑ‖∞ of the scaled system.
    adjoint_size: f64,
}

impl Wanted {
    /// The rows that `weights` name and the solution z `adjoint` `[n_equations]` for them.
    pub(crate) fn new(
        weights: Vec<Entry>,
        adjoint: Vec<f64>,
        factor: &Factor,
        doubt_above: f64,
    ) -> Self {
        let sizes = adjoint.iter().zip(factor.scale()).map(|(z, s)| (z / s).abs());
        let adjoint_size = sizes.fold(0.0, f64::max);
        let supernodes = factor.reached(weights.iter().map(Entry::place));
        Self { supernodes, doubt_above, weights, adjoint, adjoint_size }
    }

    /// The largest reciprocity error of a block's columns, NaN if one is:
    /// |wᵀ x − zᵀ b| / (‖ŵ‖₁ ‖x̂‖∞ + ‖b̂‖₁ ‖ẑ‖∞), with ‖x̂‖∞ over the wanted rows.
    pub(crate) fn reciprocity_error(
        &self,
        scale: &[f64],
        entries: &[Entry],
        x: &Columns,
        n_columns: usize,
    ) -> f64 {
        let (mut apart, mut size) = (vec![0.0; n_columns], vec![0.0_f64; n_columns]);
        for weight in &self.weights {
            for c in 0..3 {
                let row = 3 * weight.place() + c;
                let (w, s) = (weight.force[c], scale[row]);
                for ((apart, size), x) in apart.iter_mut().zip(&mut size).zip(x.row(row)) {
                    *apart += w * x;
                    *size = size.max((x / s).abs());
                }
            }
        }
        size.iter_mut().for_each(|size| *size *= 3.0 * self.weights.len() as f64);
        for entry in entries {
            let column = entry.column as usize;
            for (c, force) in entry.force.iter().enumerate() {
                let row = 3 * entry.place() + c;
                apart[column] -= self.adjoint[row] * force;
                size[column] += (scale[row] * force).abs() * self.adjoint_size;
            }
        }
        let errors = apart.iter().zip(&size);
        errors
            .map(|(apart, size)| if *apart == 0.0 { 0.0 } else { apart.abs() / size })
            .max_by(f64::total_cmp)
            .unwrap_or(0.0)
    }
}

/// One entry per place that moves a node of `nodes`.
pub(crate) fn weights(nodes: &[FeNodeId], unknowns: &Unknowns, scale: &[f64]) -> Vec<Entry> {
    let links = nodes.iter().map(|&node| unknowns.translation(node));
    let mut places: Vec<usize> = links.flat_map(Link::places).collect();
    places.sort_unstable();
    places.dedup();
    let entry = |place: usize| Entry {
        place: place as u32,
        column: 0,
        force: std::array::from_fn(|c| sign(3 * place + c) / scale[3 * place + c]),
    };
    places.into_iter().map(entry).collect()
}

/// 1 or −1 without pattern, the same every time: a bit of SplitMix64 (G. Steele, D. Lea and
/// C. Flood, OOPSLA 2014).
fn sign(i: usize) -> f64 {
    let mut bits = (i as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    if (bits ^ (bits >> 31)) & 1 == 0 { 1.0 } else { -1.0 }
}

#[cfg(test)]
mod tests {
    use hapdef_mesh::Tet10Mesh;
    use nalgebra::{Point3, Vector3};

    use super::*;
    use crate::iterative::Solver;
    use crate::model::solve_block::{System, Workspace};
    use crate::{ElasticModel, ElasticParams, IsotropicMaterial, NodalLoad, SolveParams};

    /// A chain of `n` tetrahedra, each on the last face of the one before.
    fn chain(n: usize) -> Tet10Mesh {
        let corner = |i: usize| {
            let angle = 2.0 * i as f64;
            Point3::new(angle.cos(), angle.sin(), 0.6 * i as f64)
        };
        let mut nodes: Vec<Point3<f64>> = (0..n + 3).map(corner).collect();
        let mut middles = std::collections::BTreeMap::new();
        let mut elements = Vec::new();
        for first in 0..n {
            let mut corners = [0, 1, 2, 3].map(|i| first + i);
            let [a, b, c, d] = corners.map(|i| nodes[i]);
            if (b - a).cross(&(c - a)).dot(&(d - a)) < 0.0 {
                corners.swap(2, 3);
            }
            let mut element = corners.to_vec();
            for [a, b] in hapdef_mesh::TET10_EDGES {
                let (a, b) = (corners[a].min(corners[b]), corners[a].max(corners[b]));
                element.push(*middles.entry((a, b)).or_insert_with(|| {
                    nodes.push(nalgebra::center(&nodes[a], &nodes[b]));
                    nodes.len() - 1
                }));
            }
            elements.push(std::array::from_fn(|i| FeNodeId::from_index(element[i])));
        }
        Tet10Mesh::new(nodes, elements).unwrap()
    }

    fn with_system(test: impl FnOnce(&System<'_>)) {
        let material = IsotropicMaterial::new(2e9, 0.3, 1000.0).unwrap();
        let clamped = [0, 1, 2].map(FeNodeId::from_index).to_vec();
        let model =
            ElasticModel::build(&chain(400), &ElasticParams::new(material, clamped)).unwrap();
        let Solver::Direct(factor) = &model.solver else {
            panic!("a small model is factored");
        };
        test(&System { model: &model, factor, extended: false });
    }

    const ALL: [usize; 9] = [0, 1, 2, 3, 4, 5, 6, 7, 8];

    fn loads() -> Vec<NodalLoad> {
        let node = |i: usize| FeNodeId::from_index(40 * i + 9);
        let force = |i: usize| Vector3::new(1.0, -0.3 * i as f64, 2.0);
        (0..9).map(|i| NodalLoad::nodal(node(i), force(i))).collect()
    }

    /// Rows half way to the root.
    fn wanted(system: &System<'_>) -> Wanted {
        let middle = system.factor.analysis.nodes(system.factor.analysis.n_supernodes() / 2);
        let owners = &system.model.structure.unknowns.owners()[middle];
        let nodes: Vec<FeNodeId> = owners.iter().map(|owner| owner.node).collect();
        system.wanted(&nodes, 1e-9, &SolveParams::default()).unwrap()
    }

    fn solved(system: &System<'_>, wanted: Option<&Wanted>, fill: f64) -> Workspace {
        let loads = loads();
        let mut workspace = Workspace::default();
        workspace.x.reshape(system.factor.scale().len(), ALL.len());
        workspace.x.values_mut().fill(fill);
        workspace.solve(system, &loads, &ALL, &SolveParams::default(), wanted);
        workspace
    }

    #[test]
    fn wanted_rows_read_no_others_and_are_the_same_bit_for_bit() {
        with_system(|system| {
            let wanted = wanted(system);
            let n = wanted.supernodes.len();
            let full = solved(system, None, f64::NAN);
            let part = solved(system, Some(&wanted), f64::NAN);
            let (mut n_same, mut n_left) = (0, 0);
            for s in 0..n {
                let nodes = system.factor.analysis.nodes(s);
                for row in 3 * nodes.start..3 * nodes.end {
                    let bits = |w: &Workspace| -> Vec<u64> {
                        w.x.row(row)[..9].iter().map(|v| v.to_bits()).collect()
                    };
                    if wanted.supernodes[s] {
                        assert_eq!(bits(&full), bits(&part), "row {row}");
                        n_same += 1;
                    } else {
                        n_left += usize::from(bits(&full) != bits(&part));
                    }
                }
            }
            assert!(n_same > 0 && n_left > n, "{n_same} rows solved, {n_left} left");
        });
    }

    #[test]
    fn loads_in_doubt_are_solved_in_full() {
        with_system(|system| {
            let mut wanted = wanted(system);
            let full = solved(system, None, f64::NAN);
            let run = |wanted: &Wanted| {
                let (loads, params) = (loads(), SolveParams::default());
                let mut workspace = Workspace::default();
                let reached = workspace.solve(system, &loads, &ALL, &params, Some(wanted));
                (workspace.parts().1, reached.n_residuals)
            };
            assert_eq!(run(&wanted).1, 0);
            wanted.doubt_above = -1.0;
            let (x, n_residuals) = run(&wanted);
            assert_eq!(n_residuals, ALL.len());
            assert_eq!(x.values(), full.parts().1.values());
        });
    }

    #[test]
    fn a_wrong_value_is_seen_by_reciprocity() {
        with_system(|system| {
            let wanted = wanted(system);
            let workspace = solved(system, Some(&wanted), 0.0);
            let (entries, mut x) = workspace.parts();
            let error =
                |x: &Columns| wanted.reciprocity_error(system.factor.scale(), &entries, x, 9);
            assert!(error(&x) < 1e-13, "{:e}", error(&x));
            let row = 3 * wanted.weights[0].place() + 2;
            for wrong in [1.001, -1.0, f64::NAN] {
                let right = x.row(row)[4];
                x.rows_mut(row..row + 1)[4] = right * wrong;
                let seen = error(&x);
                assert!(seen.is_nan() || seen > 1e-9, "{wrong}: {seen:e}");
                x.rows_mut(row..row + 1)[4] = right;
            }
        });
    }
}
