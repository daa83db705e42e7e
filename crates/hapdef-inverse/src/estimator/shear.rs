//! Contacts with forces in three directions, refined from normal ones.

use hapdef_contact::MAX_CONTACTS;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use crate::dense::{dot, solve_lower};
use crate::error::{InverseError, check_not_negative};
use crate::estimator::ContactEstimator;
use crate::estimator::output::ShearContact;
use crate::skin_point::SkinPoint;
use crate::walk::AtWall;

/// Unknowns of a contact: two on the surface and a force.
const N: usize = 5;

/// Steps of a round at most.
const MAX_STEPS: usize = 60;

/// Rounds in which the map's error is set anew from the forces.
const N_ROUNDS: usize = 3;

/// Steps of the projected gradient that keeps forces within their cones.
const MAX_PROJECTIONS: usize = 400;

impl ContactEstimator {
    /// Contacts that press with friction, refined from `points` by damped Gauss–Newton steps: each
    /// has a force within the cone of `friction` (tangential over normal at most; infinite leaves
    /// only the sign of the normal force) and takes five unknowns, so that the live gauges carry
    /// one for every five of them. The covariance is that of the unconstrained linearised problem
    /// with a prior of the expected force, or of the force found if that is larger. Returns the contacts in the order of `points`, and χ².
    ///
    /// # Errors
    /// [`InverseError::TooManyContacts`], [`InverseError::Reading`], [`InverseError::Length`],
    /// [`InverseError::Parameter`] for a friction that is negative or NaN.
    pub fn refine_shear(
        &self,
        readings: &[f64],
        points: &[SkinPoint],
        friction: f64,
    ) -> Result<(Vec<ShearContact>, f64), InverseError> {
        check_not_negative("friction", friction.min(f64::MAX))?;
        let (found, most) = (points.len(), (self.model.m / N).min(MAX_CONTACTS));
        if found > most {
            return Err(InverseError::TooManyContacts { found, most });
        }
        let mut z = vec![0.0; self.model.width];
        self.model.whiten(readings, &mut z)?;
        let mut problem = Problem { estimator: self, z, l: None, friction };
        let mut state = problem.state(points.to_vec());
        let n_rounds = if self.model.base.is_some() { N_ROUNDS } else { 1 };
        for _ in 0..n_rounds {
            problem.set_covariance(&state);
            state = problem.descended(state.points);
        }
        Ok((problem.report(&state), state.chi2))
    }
}

struct Problem<'a> {
    estimator: &'a ContactEstimator,
    /// The frame, whitened for the scan `[width]`.
    z: Vec<f64>,
    /// Factor of the covariance at the forces `[m, m]`; `None` for the scan's own.
    l: Option<Vec<f64>>,
    friction: f64,
}

struct State {
    points: Vec<SkinPoint>,
    forces: Vec<Vector3<f64>>,
    /// `[5 n]` columns of the whitened Jacobian.
    columns: Vec<Vec<f64>>,
    residual: Vec<f64>,
    chi2: f64,
}

impl Problem<'_> {
    /// The covariance with the map's error at the state's forces.
    fn set_covariance(&mut self, state: &State) {
        let model = &self.estimator.model;
        let forces_n = state.forces.iter().map(|force| force.norm());
        let mut l = vec![0.0; model.m * model.m];
        let is_set = model.set_covariance(state.points.iter().zip(forces_n), &mut l);
        self.l = is_set.then_some(l);
    }

    /// A row of the scan's whitening in the covariance's.
    fn whitened(&self, mut row: Vec<f64>) -> Vec<f64> {
        if let Some(l) = &self.l {
            let m = self.estimator.model.m;
            solve_lower(l, m, &mut row[..m]);
        }
        row
    }

    /// Damped Gauss–Newton steps from `points`, the covariance held.
    fn descended(&self, points: Vec<SkinPoint>) -> State {
        let mut state = self.state(points);
        let mut damping = 1e-3;
        for _ in 0..MAX_STEPS {
            let before = state.chi2;
            let step = self.step(&state, damping);
            let trial = self.state(self.walked(&state, &step));
            if trial.chi2 < before {
                state = trial;
                damping = f64::max(damping * 0.2, 1e-9);
                if before - state.chi2 <= self.estimator.params.chi2_tolerance {
                    break;
                }
            } else if damping > 1e6 {
                break;
            } else {
                damping *= 8.0;
            }
        }
        state
    }

    /// Forces and residual at `points`.
    fn state(&self, points: Vec<SkinPoint>) -> State {
        let model = &self.estimator.model;
        let width = model.width;
        let mut values = Vec::new();
        let mut slopes = Vec::new();
        for point in &points {
            let weights = model.interpolant().weights(&point.bary(), &model.skin().frame(point));
            let combined = |w| {
                let mut row = vec![0.0; 3 * width];
                model.interpolant().combine(model.vector_rows(), point, w, &mut row);
                row
            };
            values.push(combined(&weights.value));
            slopes.push(weights.slope.each_ref().map(combined));
        }
        let axis =
            |rows: &[f64], a: usize| self.whitened(rows[a * width..(a + 1) * width].to_vec());
        let z = self.whitened(self.z.clone());
        let force_columns: Vec<Vec<f64>> = values
            .iter()
            .flat_map(|rows| (0..3).map(|a| axis(rows, a)).collect::<Vec<_>>())
            .collect();
        let forces = self.forces(&points, &force_columns, &z);
        let mut residual = z;
        for (i, force) in forces.iter().enumerate() {
            for a in 0..3 {
                crate::dense::add_scaled(&mut residual, -force[a], &force_columns[3 * i + a]);
            }
        }
        let mut columns = Vec::with_capacity(N * points.len());
        for (i, force) in forces.iter().enumerate() {
            for slope in &slopes[i] {
                let mut column = vec![0.0; width];
                for a in 0..3 {
                    crate::dense::add_scaled(&mut column, force[a], &axis(slope, a));
                }
                columns.push(column);
            }
            columns.extend_from_slice(&force_columns[3 * i..3 * i + 3]);
        }
        let chi2 = dot(&residual, &residual);
        State { points, forces, columns, residual, chi2 }
    }

    /// The forces within their cones that explain most, by projected gradient with Nesterov's
    /// momentum (Beck and Teboulle 2009).
    fn forces(&self, points: &[SkinPoint], columns: &[Vec<f64>], z: &[f64]) -> Vec<Vector3<f64>> {
        let n = columns.len();
        let h = DMatrix::from_fn(n, n, |i, j| dot(&columns[i], &columns[j]));
        let c = DVector::from_fn(n, |i, _| dot(&columns[i], z));
        let inward: Vec<_> =
            points.iter().map(|p| -self.estimator.model.skin().normal(p)).collect();
        let prior = 1e-9 * h.trace().max(f64::MIN_POSITIVE);
        let damped = &h + DMatrix::identity(n, n) * prior;
        let mut x = damped.cholesky().map_or_else(|| DVector::zeros(n), |l| l.solve(&c));
        if self.project(&mut x, &inward) {
            let steepness = h.norm().max(f64::MIN_POSITIVE);
            let (mut ahead, mut momentum) = (x.clone(), 1.0_f64);
            for _ in 0..MAX_PROJECTIONS {
                let mut next = &ahead - (&h * &ahead - &c) / steepness;
                self.project(&mut next, &inward);
                let grown = 0.5 * (1.0 + (1.0 + 4.0 * momentum * momentum).sqrt());
                ahead = &next + (&next - &x) * ((momentum - 1.0) / grown);
                (x, momentum) = (next, grown);
            }
        }
        (0..points.len()).map(|i| Vector3::new(x[3 * i], x[3 * i + 1], x[3 * i + 2])).collect()
    }

    /// Puts each force into its cone; whether any was outside.
    fn project(&self, x: &mut DVector<f64>, inward: &[Vector3<f64>]) -> bool {
        let mut is_moved = false;
        for (i, inward) in inward.iter().enumerate() {
            let force = Vector3::new(x[3 * i], x[3 * i + 1], x[3 * i + 2]);
            let inside = in_cone(&force, inward, self.friction);
            is_moved |= (inside - force).norm() > 1e-12 * force.norm();
            for a in 0..3 {
                x[3 * i + a] = inside[a];
            }
        }
        is_moved
    }

    fn information(&self, state: &State) -> DMatrix<f64> {
        let n = state.columns.len();
        DMatrix::from_fn(n, n, |i, j| dot(&state.columns[i], &state.columns[j]))
    }

    fn step(&self, state: &State, damping: f64) -> DVector<f64> {
        let n = state.columns.len();
        let mut a = self.information(state);
        let floor = 1e-12 * a.trace() + f64::MIN_POSITIVE;
        for i in 0..n {
            a[(i, i)] += damping * a[(i, i)] + floor;
        }
        let b = DVector::from_fn(n, |i, _| dot(&state.columns[i], &state.residual));
        a.cholesky().map_or_else(|| DVector::zeros(n), |l| l.solve(&b))
    }

    fn walked(&self, state: &State, step: &DVector<f64>) -> Vec<SkinPoint> {
        let skin = self.estimator.model.skin();
        let moved = |(i, point): (usize, &SkinPoint)| {
            let [t1, t2] = skin.tangents(point);
            let along = t1 * step[N * i] + t2 * step[N * i + 1];
            let longest = self.estimator.params.max_step_m;
            let scale = (longest / along.norm().max(f64::MIN_POSITIVE)).min(1.0);
            skin.walk(point, &(along * scale), AtWall::Slide).point
        };
        state.points.iter().enumerate().map(moved).collect()
    }

    fn report(&self, state: &State) -> Vec<ShearContact> {
        let n = state.columns.len();
        let skin_sd_m = (self.estimator.model.skin().area_m2() / std::f64::consts::TAU).sqrt();
        // no narrower than the force found, whose error grows with it
        let force_sd_n = |i: usize| {
            let found_n = state.forces[i].norm();
            self.estimator.params.force_scale_n.max(found_n)
        };
        let prior = |q: usize| {
            if q % N < 2 { skin_sd_m } else { force_sd_n(q / N) }
        };
        let scaled = self.information(state);
        let scaled = DMatrix::from_fn(n, n, |i, j| {
            f64::from(u8::from(i == j)) + prior(i) * prior(j) * scaled[(i, j)]
        });
        let covariance = scaled.cholesky().map_or_else(|| DMatrix::identity(n, n), |l| l.inverse());
        let entry = |i: usize, j: usize| prior(i) * prior(j) * covariance[(i, j)];
        let (skin, place_factor) = (self.estimator.model.skin(), self.estimator.model.place_factor);
        let contact = |i: usize| ShearContact {
            point: state.points[i],
            position_m: skin.position(&state.points[i]),
            force_vector_n: state.forces[i],
            position_covariance_m2: std::array::from_fn(|p| {
                std::array::from_fn(|q| place_factor * entry(N * i + p, N * i + q))
            }),
            force_covariance_n2: Matrix3::from_fn(|p, q| entry(N * i + 2 + p, N * i + 2 + q)),
        };
        (0..state.points.len()).map(contact).collect()
    }
}

/// The nearest force in the cone |tangential| ≤ μ · normal around `inward`.
fn in_cone(force: &Vector3<f64>, inward: &Vector3<f64>, friction: f64) -> Vector3<f64> {
    let along = force.dot(inward);
    let across = force - inward * along;
    let tangential = across.norm();
    if friction.is_infinite() {
        return across + inward * along.max(0.0);
    }
    if tangential <= friction * along {
        return *force;
    }
    let pressed = (along + friction * tangential) / (1.0 + friction * friction);
    if pressed <= 0.0 || tangential == 0.0 {
        return Vector3::zeros();
    }
    inward * pressed + across * (friction * pressed / tangential)
}
