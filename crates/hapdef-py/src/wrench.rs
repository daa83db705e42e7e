//! The net wrench of contacts.

use hapdef_live::Wrench;
use nalgebra::Matrix6xX;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::array::{Numbers, Table, numbers, one, rows, two};

/// The force and moment of all contacts together.
#[pyclass(frozen, module = "hapdef", name = "Wrench")]
#[derive(Clone)]
pub struct PyWrench {
    wrench: Wrench,
}

/// What a wrench puts on joints.
#[pyclass(frozen, get_all, module = "hapdef", name = "JointTorques")]
pub struct PyJointTorques {
    /// N m of joints that turn, N of those that slide, `[n_joints]`.
    torques: Py<PyArray1<f64>>,
    /// Their covariance `[n_joints, n_joints]`, where that of the wrench is known.
    covariance: Option<Py<PyArray2<f64>>>,
}

#[pymethods]
impl PyWrench {
    /// The point that the moment is about, m, `[3]`.
    #[getter]
    fn about_m(&self, py: Python<'_>) -> Py<PyArray1<f64>> {
        one(py, self.wrench.about_m.coords.as_slice().to_vec())
    }

    /// The force on the limb, N, `[3]`.
    #[getter]
    fn force_n(&self, py: Python<'_>) -> Py<PyArray1<f64>> {
        one(py, self.wrench.force_n.as_slice().to_vec())
    }

    /// Its moment, N m, `[3]`.
    #[getter]
    fn moment_nm(&self, py: Python<'_>) -> Py<PyArray1<f64>> {
        one(py, self.wrench.moment_nm.as_slice().to_vec())
    }

    /// Covariance of (force, moment), `[6, 6]`, where that of every contact is known.
    #[getter]
    fn covariance(&self, py: Python<'_>) -> PyResult<Option<Py<PyArray2<f64>>>> {
        self.wrench.covariance.map(|c| two(py, c.as_slice().to_vec(), [6, 6])).transpose()
    }

    /// The same about another point, m, `[3]`.
    fn about(&self, point_m: Numbers<'_>) -> PyResult<Self> {
        Ok(Self { wrench: self.wrench.about(point(&point_m)?) })
    }

    /// The external torques Jᵀ (force, moment) of joints; `jacobian` `[6, n_joints]` has the velocity of the point
    /// `about_m` in its first three rows and the angular velocity in its last, for unit rates of the joints.
    fn joint_torques(&self, py: Python<'_>, jacobian: Table<'_>) -> PyResult<PyJointTorques> {
        let n = jacobian.as_array().ncols();
        let flat = rows("jacobian", &jacobian, n)?;
        let n_rows = jacobian.as_array().nrows();
        if n_rows != 6 {
            return Err(pyo3::exceptions::PyValueError::new_err(format!(
                "jacobian: expected an array of shape [6, n_joints], found {n_rows} rows"
            )));
        }
        let found = self.wrench.joint_torques(&Matrix6xX::from_row_slice(&flat));
        let covariance = found.covariance.map(|c| two(py, c.as_slice().to_vec(), [n, n]));
        Ok(PyJointTorques {
            torques: one(py, found.torques.as_slice().to_vec()),
            covariance: covariance.transpose()?,
        })
    }

    fn __repr__(&self) -> String {
        let [x, y, z] = self.wrench.force_n.into();
        let [a, b, c] = self.wrench.moment_nm.into();
        format!("Wrench(force ({x:.3}, {y:.3}, {z:.3}) N, moment ({a:.4}, {b:.4}, {c:.4}) N m)")
    }
}

impl PyWrench {
    /// Wraps a wrench.
    pub(crate) fn new(wrench: Wrench) -> Self {
        Self { wrench }
    }
}

/// A point of the limb's frame.
pub(crate) fn point(point_m: &Numbers<'_>) -> PyResult<nalgebra::Point3<f64>> {
    let numbers = numbers("point", point_m, 3)?;
    Ok(nalgebra::Point3::from_slice(&numbers))
}
