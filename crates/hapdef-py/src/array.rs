//! NumPy arrays in and out, with their shapes checked.

use nalgebra::{Point3, Vector3};
use numpy::{
    AllowTypeChange, Element, IntoPyArray, PyArray1, PyArray2, PyArray3, PyArrayLike1,
    PyArrayLike2, PyArrayMethods,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Numbers `[n]` in whatever form NumPy takes.
pub(crate) type Numbers<'py> = PyArrayLike1<'py, f64, AllowTypeChange>;
/// Numbers `[n, m]` in whatever form NumPy takes.
pub(crate) type Table<'py> = PyArrayLike2<'py, f64, AllowTypeChange>;

/// Hands a list `[n]` to NumPy without copying it.
pub(crate) fn one<T: Element>(py: Python<'_>, list: Vec<T>) -> Py<PyArray1<T>> {
    list.into_pyarray(py).unbind()
}

/// Hands a list `[rows, columns]` to NumPy without copying it.
pub(crate) fn two<T: Element>(
    py: Python<'_>,
    list: Vec<T>,
    shape: [usize; 2],
) -> PyResult<Py<PyArray2<T>>> {
    Ok(list.into_pyarray(py).reshape(shape)?.unbind())
}

/// Hands a list `[n, rows, columns]` to NumPy without copying it.
pub(crate) fn three<T: Element>(
    py: Python<'_>,
    list: Vec<T>,
    shape: [usize; 3],
) -> PyResult<Py<PyArray3<T>>> {
    Ok(list.into_pyarray(py).reshape(shape)?.unbind())
}

/// Vectors as an array `[n, 3]`.
pub(crate) fn vectors(py: Python<'_>, list: &[Vector3<f64>]) -> PyResult<Py<PyArray2<f64>>> {
    let numbers = list.iter().flat_map(|v| [v.x, v.y, v.z]).collect();
    two(py, numbers, [list.len(), 3])
}

/// Positions as an array `[n, 3]`.
pub(crate) fn positions(py: Python<'_>, list: &[Point3<f64>]) -> PyResult<Py<PyArray2<f64>>> {
    let numbers = list.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
    two(py, numbers, [list.len(), 3])
}

/// Rows `[n, 3]` of an argument.
///
/// # Errors
/// `ValueError` for another width or a number that is not finite.
pub(crate) fn triples(name: &str, table: &Table<'_>) -> PyResult<Vec<[f64; 3]>> {
    let flat = rows(name, table, 3)?;
    Ok(flat.as_chunks::<3>().0.to_vec())
}

/// Rows `[n, width]` of an argument, one after the other.
///
/// # Errors
/// `ValueError` for another width or a number that is not finite.
pub(crate) fn rows(name: &str, table: &Table<'_>, width: usize) -> PyResult<Vec<f64>> {
    let view = table.as_array();
    if view.ncols() != width {
        return Err(PyValueError::new_err(format!(
            "{name}: expected an array of shape [n, {width}], found {:?}",
            view.shape()
        )));
    }
    finite(name, view.iter().copied().collect())
}

/// Numbers of an argument, one for each of `n`.
///
/// # Errors
/// `ValueError` for another length or a number that is not finite.
pub(crate) fn numbers(name: &str, list: &Numbers<'_>, n: usize) -> PyResult<Vec<f64>> {
    let view = list.as_array();
    if view.len() != n {
        return Err(PyValueError::new_err(format!(
            "{name}: expected {n} numbers, one for each row, found {}",
            view.len()
        )));
    }
    finite(name, view.iter().copied().collect())
}

fn finite(name: &str, list: Vec<f64>) -> PyResult<Vec<f64>> {
    match list.iter().position(|v| !v.is_finite()) {
        None => Ok(list),
        Some(i) => Err(PyValueError::new_err(format!(
            "{name}: number {i} is {}, expected finite ones",
            list[i]
        ))),
    }
}
