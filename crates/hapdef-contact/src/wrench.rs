//! The force and moment that all contacts have together.

use nalgebra::{
    DMatrix, DVector, Matrix3, Matrix6, Matrix6x3, Matrix6xX, Point3, Vector3, Vector6,
};

use crate::contact::Contact;

/// A force, and its moment about a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wrench {
    /// The point that the moment is about, m.
    pub about_m: Point3<f64>,
    /// The force on the limb, N.
    pub force_n: Vector3<f64>,
    /// Its moment, N m.
    pub moment_nm: Vector3<f64>,
    /// Covariance of (force, moment), N and N m; `None` where that of a contact is not known. Errors of
    /// different contacts are taken as independent.
    pub covariance: Option<Matrix6<f64>>,
}

/// What forces and torques a wrench puts on joints.
#[derive(Clone, Debug, PartialEq)]
pub struct JointTorques {
    /// `[n_joints]`, N m of joints that turn, N of those that slide.
    pub torques: DVector<f64>,
    /// Its covariance `[n_joints, n_joints]`, where that of the wrench is known.
    pub covariance: Option<DMatrix<f64>>,
}

impl Wrench {
    /// No force.
    #[must_use]
    pub fn zero(about_m: Point3<f64>) -> Self {
        let (force_n, moment_nm) = (Vector3::zeros(), Vector3::zeros());
        Self { about_m, force_n, moment_nm, covariance: Some(Matrix6::zeros()) }
    }

    /// The net wrench of normal forces: F = Σ f d and M = Σ (p − a) × f d over contacts at p with force f along d,
    /// about a. Its covariance is Σ J C Jᵀ, C a contact's covariance of (place along t₁, along t₂, force) and J = ∂(F, M)/∂
    /// of these: (0, f t₁ × d), (0, f t₂ × d), (d, (p − a) × d); how the skin's direction changes with the place is
    /// left out. `None` where a contact's direction is not known.
    #[must_use]
    pub fn of(contacts: &[Contact], about_m: Point3<f64>) -> Option<Self> {
        contacts.iter().try_fold(Self::zero(about_m), |net, contact| {
            let direction = contact.direction?;
            let arm_m = contact.position_m - about_m;
            let covariance = net.covariance.zip(contact.uncertainty).map(|(net, sure)| {
                let [along_1, along_2] =
                    sure.tangents.map(|t| t.cross(&direction) * contact.force_n);
                let none = Vector3::zeros();
                let force = Matrix3::from_columns(&[none, none, direction]);
                let moment = Matrix3::from_columns(&[along_1, along_2, arm_m.cross(&direction)]);
                let mut slopes = Matrix6x3::zeros();
                slopes.fixed_rows_mut::<3>(0).copy_from(&force);
                slopes.fixed_rows_mut::<3>(3).copy_from(&moment);
                net + slopes * sure.covariance * slopes.transpose()
            });
            let force_n = direction * contact.force_n;
            Some(Self {
                about_m,
                force_n: net.force_n + force_n,
                moment_nm: net.moment_nm + arm_m.cross(&force_n),
                covariance,
            })
        })
    }

    /// The same about another point b: M_b = M_a + (a − b) × F.
    #[must_use]
    pub fn about(&self, about_m: Point3<f64>) -> Self {
        let arm_m = self.about_m - about_m;
        let mut shift = Matrix6::identity();
        shift.fixed_view_mut::<3, 3>(3, 0).copy_from(&arm_m.cross_matrix());
        Self {
            about_m,
            force_n: self.force_n,
            moment_nm: self.moment_nm + arm_m.cross(&self.force_n),
            covariance: self.covariance.map(|c| shift * c * shift.transpose()),
        }
    }

    /// The external torques τ = Jᵀ (F, M) of joints whose unit rates move the limb's point [`Wrench::about_m`] by the
    /// first three rows of a column of `jacobian` `[6, n_joints]`, m/s, and turn the limb by the last three, rad/s, both
    /// in the axes of the wrench: the order of KDL and Pinocchio. Their covariance is Jᵀ C J.
    #[must_use]
    pub fn joint_torques(&self, jacobian: &Matrix6xX<f64>) -> JointTorques {
        let (f, m) = (self.force_n, self.moment_nm);
        let wrench = Vector6::new(f.x, f.y, f.z, m.x, m.y, m.z);
        let transposed = jacobian.transpose();
        let on_joints = |c: Matrix6<f64>| {
            let covariance = &transposed * c * jacobian;
            DMatrix::from_column_slice(jacobian.ncols(), jacobian.ncols(), covariance.as_slice())
        };
        let torques = &transposed * wrench;
        JointTorques {
            torques: DVector::from_column_slice(torques.as_slice()),
            covariance: self.covariance.map(on_joints),
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Unit;
    use proptest::prelude::*;

    use super::*;
    use crate::uncertainty::Uncertainty;

    fn contact(place: [f64; 3], toward: [f64; 3], force_n: f64) -> Contact {
        let direction = Unit::new_normalize(Vector3::from(toward)).into_inner();
        let along = if direction.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
        let first = Unit::new_normalize(along.cross(&direction)).into_inner();
        let covariance = Matrix3::new(4e-6, 1e-6, 1e-4, 1e-6, 9e-6, -2e-4, 1e-4, -2e-4, 0.04);
        let tangents = [first, direction.cross(&first)];
        Contact {
            direction: Some(direction),
            uncertainty: Some(Uncertainty { tangents, covariance }),
            ..Contact::new(place.into(), force_n)
        }
    }

    fn numbers(wrench: &Wrench) -> Vector6<f64> {
        let mut all = Vector6::zeros();
        all.fixed_rows_mut::<3>(0).copy_from(&wrench.force_n);
        all.fixed_rows_mut::<3>(3).copy_from(&wrench.moment_nm);
        all
    }

    prop_compose! {
        fn any_contact()(
            place in prop::array::uniform3(-0.3..0.3f64),
            toward in prop::array::uniform3(0.1..1.0f64),
            force_n in 0.1..30.0f64,
        ) -> Contact {
            contact(place, toward, force_n)
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn a_wrench_is_the_same_whichever_point_it_was_first_taken_about(
            contacts in prop::collection::vec(any_contact(), 0..4),
            a in prop::array::uniform3(-1.0..1.0f64),
            b in prop::array::uniform3(-1.0..1.0f64),
        ) {
            let moved = Wrench::of(&contacts, a.into()).unwrap().about(b.into());
            let direct = Wrench::of(&contacts, b.into()).unwrap();
            prop_assert!((numbers(&moved) - numbers(&direct)).amax() < 1e-10);
            prop_assert!((moved.covariance.unwrap() - direct.covariance.unwrap()).amax() < 1e-10);
        }

        /// The power of the wrench on a limb that turns about a hinge is that of the hinge's torque.
        #[test]
        fn a_hinges_torque_is_the_moment_along_it(
            contacts in prop::collection::vec(any_contact(), 1..4),
            hinge in prop::array::uniform3(-1.0..1.0f64),
            axis in prop::array::uniform3(0.1..1.0f64),
        ) {
            let (hinge, axis) = (Point3::from(hinge), Unit::new_normalize(Vector3::from(axis)));
            let net = Wrench::of(&contacts, Point3::origin()).unwrap();
            let moves = axis.cross(&(net.about_m - hinge));
            let column = Vector6::new(moves.x, moves.y, moves.z, axis.x, axis.y, axis.z);
            let found = net.joint_torques(&Matrix6xX::from_columns(&[column]));
            let at_hinge = net.about(hinge);
            prop_assert!((found.torques[0] - at_hinge.moment_nm.dot(&axis)).abs() < 1e-10);
            let moment = at_hinge.covariance.unwrap();
            let moment = moment.fixed_view::<3, 3>(3, 3);
            let variance = axis.dot(&(moment * axis.into_inner()));
            prop_assert!((found.covariance.unwrap()[(0, 0)] - variance).abs() < 1e-10);
        }

        /// The covariance is that of the wrench by finite differences of place and force.
        #[test]
        fn slopes_are_finite_differences(pressed in any_contact()) {
            let sure = pressed.uncertainty.unwrap();
            let net = |d: [f64; 3]| {
                let mut moved = pressed;
                moved.position_m += sure.tangents[0] * d[0] + sure.tangents[1] * d[1];
                moved.force_n += d[2];
                numbers(&Wrench::of(&[moved], Point3::new(0.1, -0.2, 0.3)).unwrap())
            };
            let columns = [0, 1, 2].map(|k| {
                let step = |h: f64| std::array::from_fn(|i| if i == k { h } else { 0.0 });
                (net(step(1e-4)) - net(step(-1e-4))) / 2e-4
            });
            let slopes = Matrix6x3::from_columns(&columns);
            let expected = slopes * sure.covariance * slopes.transpose();
            let found = Wrench::of(&[pressed], Point3::new(0.1, -0.2, 0.3)).unwrap();
            prop_assert!((found.covariance.unwrap() - expected).amax() < 1e-9);
        }
    }

    #[test]
    fn what_is_not_known_of_a_contact_is_not_known_of_all() {
        let known = contact([0.1, 0.0, 0.0], [0.0, 0.0, 1.0], 2.0);
        let about = Point3::origin();
        let blunt = Contact { uncertainty: None, ..known };
        let net = Wrench::of(&[known, blunt], about).unwrap();
        assert_eq!((net.force_n, net.covariance), (Vector3::z() * 4.0, None));
        assert_eq!(net.moment_nm, Vector3::y() * -0.4);
        assert_eq!(Wrench::of(&[Contact { direction: None, ..known }], about), None);
        assert_eq!(Wrench::of(&[], about), Some(Wrench::zero(about)));
    }
}
