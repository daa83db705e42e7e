//! The condition number, the bound on the forward error, and what refinement does for it.

use crate::common;

use common::{cases, faces_where, mapped_box, nodes_where, straight_box};
use hapdef_mesh::{FaceTraction, FeNodeId, Tet10Mesh};
use hapdef_sim::{
    ComplianceParams, ElasticModel, ElasticParams, IsotropicMaterial, NodalLoad, SimError,
    SolveInfo, SolveParams, SolverChoice,
};
use nalgebra::{DMatrix, Point3, SymmetricEigen, Vector3};
use proptest::prelude::*;

const E_PA: f64 = 2e9;

/// A bar [0, 2] × [0, 1]² m whose parts x < 1 and x > 1 have their own modulus factors, ν = 0,
/// clamped at x = 0 and pulled at x = 2: bars in series, which linear elements meet exactly.
struct Series {
    mesh: Tet10Mesh,
    factors: [f64; 2],
    pull_pa: f64,
}

impl Series {
    /// `layer` is the height of the middle layer of elements, as a share of the others'.
    fn new(layer: f64, factors: [f64; 2]) -> Self {
        let height = 2.0 + layer;
        let mesh = mapped_box([4, 2, 3], [1.0; 3], |p| {
            let levels = [0.0, 1.0, 1.0 + layer, height];
            let at = 3.0 * p.z;
            let low = (at as usize).min(2);
            let z = levels[low] + (at - low as f64) * (levels[low + 1] - levels[low]);
            Point3::new(2.0 * p.x, p.y, z / height)
        });
        Self { mesh, factors, pull_pa: 1e6 }
    }

    fn model(&self, n_threads: usize) -> ElasticModel {
        self.try_model(n_threads).unwrap()
    }

    fn try_model(&self, n_threads: usize) -> Result<ElasticModel, SimError> {
        let material = IsotropicMaterial::new(E_PA, 0.0, 1.0).unwrap();
        let clamped = nodes_where(&self.mesh, |p| p.x == 0.0);
        let params = ElasticParams {
            element_stiffness_scale: Some(scales(&self.mesh, self.factors)),
            solver: SolverChoice::Direct,
            n_threads,
            ..ElasticParams::new(material, clamped)
        };
        ElasticModel::build(&self.mesh, &params)
    }

    fn load(&self) -> NodalLoad {
        let end = faces_where(&self.mesh, |p| p.x == 2.0);
        let pull = |nodes| FaceTraction { nodes, traction_pa: Vector3::x() * self.pull_pa };
        let tractions: Vec<_> = end.iter().map(|face| pull(face.nodes)).collect();
        NodalLoad::traction(&self.mesh, &tractions).unwrap()
    }

    fn exact(&self, p: &Point3<f64>) -> Vector3<f64> {
        let strain = self.factors.map(|f| self.pull_pa / (f * E_PA));
        let x = p.x.min(1.0) * strain[0] + (p.x - 1.0).max(0.0) * strain[1];
        Vector3::new(x, 0.0, 0.0)
    }

    /// The largest error of a displacement over the largest displacement, and the solve's info.
    fn error(&self, solve: SolveParams) -> Result<(f64, SolveInfo), SimError> {
        let all: Vec<_> = (0..self.mesh.nodes().len()).map(FeNodeId::from_index).collect();
        let params = ComplianceParams { solve, ..ComplianceParams::default() };
        let (found, info) = self.try_model(1)?.compliance(&[self.load()], &all, &params)?;
        let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
        for (p, u) in self.mesh.nodes().iter().zip(found.row(0).chunks_exact(3)) {
            let exact = self.exact(p);
            worst = worst.max((Vector3::from_column_slice(u) - exact).norm());
            largest = largest.max(exact.norm());
        }
        Ok((worst / largest, info))
    }
}

fn scales(mesh: &Tet10Mesh, factors: [f64; 2]) -> Vec<f64> {
    let centre = |nodes: &[FeNodeId; 10]| nodes[..4].iter().map(|&n| mesh.position(n).x).sum();
    let sums = mesh.elements().iter().map(centre);
    sums.map(|sum: f64| factors[usize::from(sum > 4.0)]).collect()
}

/// λmax / λmin of the Jacobi-scaled stiffness by a dense eigenvalue solver.
fn dense_condition(model: &ElasticModel) -> f64 {
    let k = model.stiffness_matrix().unwrap();
    let n = k.col_ptr.len() - 1;
    let mut dense = DMatrix::zeros(n, n);
    for j in 0..n {
        for e in k.col_ptr[j] as usize..k.col_ptr[j + 1] as usize {
            let i = k.row_idx[e] as usize;
            (dense[(i, j)], dense[(j, i)]) = (k.values[e], k.values[e]);
        }
    }
    let s: Vec<f64> = (0..n).map(|i| 1.0 / dense[(i, i)].sqrt()).collect();
    let scaled = DMatrix::from_fn(n, n, |i, j| s[i] * dense[(i, j)] * s[j]);
    let eigenvalues = SymmetricEigen::new(scaled).eigenvalues;
    eigenvalues.max() / eigenvalues.min()
}

/// ‖K̂‖∞ exceeds λmax by a factor that the elements' valence sets.
#[track_caller]
fn check_condition(what: &str, model: &ElasticModel) {
    let (estimate, dense) = (model.condition(), dense_condition(model));
    let ratio = estimate / dense;
    assert!(
        (1.0..6.0).contains(&ratio),
        "{what}: estimate {estimate:e}, dense {dense:e}, ratio {ratio}"
    );
}

#[test]
fn the_condition_number_is_that_of_dense_eigenvalues() {
    for factors in [[1.0, 1.0], [1e6, 1.0], [1.0, 1e3], [1.0, 1e6]] {
        check_condition(&format!("factors {factors:?}"), &Series::new(1.0, factors).model(1));
    }
    for layer in [0.1, 0.01, 1e-3] {
        check_condition(&format!("layer {layer}"), &Series::new(layer, [1.0; 2]).model(1));
    }
    let mesh = straight_box([3, 3, 3], [1.0; 3]);
    for nu in [0.3, 0.49, 0.4999, 0.499_999] {
        let material = IsotropicMaterial::new(E_PA, nu, 1.0).unwrap();
        let params = ElasticParams::new(material, nodes_where(&mesh, |p| p.x == 0.0));
        check_condition(&format!("ν {nu}"), &ElasticModel::build(&mesh, &params).unwrap());
    }
    let plate = straight_box([6, 6, 1], [1.0, 1.0, 1e-3]);
    let params = common::params(nodes_where(&plate, |p| p.x == 0.0));
    check_condition("plate", &ElasticModel::build(&plate, &params).unwrap());
}

/// Neither refuses nor extends, whatever comes.
fn plain() -> SolveParams {
    SolveParams {
        extend_above_condition: f64::INFINITY,
        max_forward_error: f64::INFINITY,
        fail_above: f64::INFINITY,
        ..SolveParams::default()
    }
}

fn extended() -> SolveParams {
    SolveParams { extend_above_condition: 0.0, ..plain() }
}

proptest! {
    #![proptest_config(cases(24))]

    #[test]
    fn the_bound_holds_and_extended_residuals_do_not_harm(
        supported in -8.0..8.0_f64,
        free in -8.0..8.0_f64,
        layer in -3.0..0.0_f64,
    ) {
        let series = Series::new(10f64.powf(layer), [supported, free].map(|p| 10f64.powf(p)));
        let (error, info) = match series.error(plain()) {
            // a floating jump times the layer's own condition, at the end of f64
            Err(SimError::NotPositiveDefinite { .. }) if free - supported - 3.0 * layer > 12.0 => {
                return Ok(());
            }
            solved => solved.unwrap(),
        };
        let bound = info.forward_error_bound();
        prop_assert!(error <= bound, "plain: error {error:e}, bound {bound:e}");
        let (error_extended, info) = series.error(extended()).unwrap();
        let bound = info.forward_error_bound();
        prop_assert!(error_extended <= bound, "extended: error {error_extended:e}, bound {bound:e}");
        // what is left is the rounding of the stiffness, which no residual sees
        prop_assert!(
            error_extended <= 2.0 * error + 0.05 * bound,
            "{error:e} became {error_extended:e}"
        );
        prop_assert!(info.worst_backward_error <= 1e-14);
    }
}

#[test]
fn beyond_the_limit_is_an_error_on_any_number_of_threads() {
    let series = Series::new(1.0, [1.0, 1e13]);
    let solve = |n_threads| series.model(n_threads).solve(&series.load());
    let (one, two) = (solve(1).unwrap_err(), solve(2).unwrap_err());
    assert_eq!(format!("{one:?}"), format!("{two:?}"));
    let SimError::IllConditioned { condition, bound, limit, .. } = one else {
        panic!("{one}");
    };
    assert!(condition > 1e12 && bound > limit, "{condition:e} {bound:e}");
    // the same jump the other way round is harmless
    let (error, info) = Series::new(1.0, [1e13, 1.0]).error(SolveParams::default()).unwrap();
    assert!(error <= info.forward_error_bound() && error < 1e-12, "{error:e}");
}

#[test]
fn an_ill_conditioned_solution_is_the_same_on_two_threads() {
    let series = Series::new(0.01, [1.0, 1e5]);
    let solve = |n_threads| series.model(n_threads).solve(&series.load()).unwrap();
    let ((u, info), (v, same)) = (solve(1), solve(2));
    assert!(info.condition.unwrap() > SolveParams::default().extend_above_condition);
    assert_eq!(u, v);
    assert_eq!(info.condition, same.condition);
    assert_eq!(info.worst_backward_error, same.worst_backward_error);
}
