//! Peaks between nodes: a quadratic through the nodes around a peak of k-Max.

use nalgebra::{DVector, Point3};
use nalgebra::{Dyn, Matrix2, OMatrix, U6, Vector2, Vector3};

/// Nodes around the peak that the quadratic is fitted to, besides the peak.
const N_AROUND: usize = 12;

/// Where fields peak between the nodes of a skin.
pub(super) struct Refiner<'a> {
    /// Positions of the nodes, m.
    pub(super) points: &'a [Point3<f64>],
    /// A direction across the skin at each node.
    pub(super) across: &'a [Vector3<f64>],
}

impl Refiner<'_> {
    /// The place of the peak at `node` of a field: the top of the least-squares quadratic over the
    /// plane across the skin, no farther than the nearest node; `node` itself where the quadratic
    /// has no top.
    pub(super) fn peak(&self, field: &[f32], node: usize) -> [f64; 3] {
        let place = self.points[node];
        match self.offset(field, node) {
            Some(offset) => (place + offset).coords.into(),
            None => place.coords.into(),
        }
    }

    fn offset(&self, field: &[f32], node: usize) -> Option<Vector3<f64>> {
        let around = self.around(node);
        let (first, last) = (around.first()?, around.last()?);
        let (nearest, farthest) = (first.0, last.0);
        let across = self.across[node];
        let u = across.cross(&least_along(&across)).try_normalize(0.0)?;
        let v = across.cross(&u);
        let rows = || around.iter().map(|(_, j)| *j).chain([node]);
        let n = around.len() + 1;
        let mut a = OMatrix::<f64, Dyn, U6>::zeros(n);
        let mut b = DVector::zeros(n);
        for (i, j) in rows().enumerate() {
            let d = (self.points[j] - self.points[node]) / farthest;
            let (x, y) = (d.dot(&u), d.dot(&v));
            for (k, value) in [1.0, x, y, x * x, x * y, y * y].into_iter().enumerate() {
                a[(i, k)] = value;
            }
            b[i] = f64::from(field[j]);
        }
        let c = a.svd(true, true).solve(&b, 1e-9).ok()?;
        let curvature = Matrix2::new(2.0 * c[3], c[4], c[4], 2.0 * c[5]);
        if curvature.trace() >= 0.0 || curvature.determinant() <= 0.0 {
            return None;
        }
        let top = -(curvature.try_inverse()? * Vector2::new(c[1], c[2])) * farthest;
        let top = top * (nearest / top.norm().max(nearest));
        Some(u * top.x + v * top.y)
    }

    /// The nearest other nodes with their distances, nearest first.
    fn around(&self, node: usize) -> Vec<(f64, usize)> {
        let others = (0..self.points.len()).filter(|j| *j != node);
        let distance = |j: usize| (self.points[j] - self.points[node]).norm();
        let mut all: Vec<(f64, usize)> = others.map(|j| (distance(j), j)).collect();
        let order = |a: &(f64, usize), b: &(f64, usize)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
        let n = N_AROUND.min(all.len());
        if n < all.len() {
            all.select_nth_unstable_by(n, order);
            all.truncate(n);
        }
        all.sort_by(order);
        all
    }
}

/// The axis that a direction has least of.
fn least_along(direction: &Vector3<f64>) -> Vector3<f64> {
    let mut axis = Vector3::zeros();
    axis[direction.iamin()] = 1.0;
    axis
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> Vec<Point3<f64>> {
        let at = |i: i32, j: i32| Point3::new(f64::from(i) * 2e-3, f64::from(j) * 2e-3, 0.01);
        (-4..=4).flat_map(|i| (-4..=4).map(move |j| at(i, j))).collect()
    }

    #[test]
    fn the_top_of_a_quadratic_is_found_and_a_saddle_is_left() {
        let points = grid();
        let across = vec![Vector3::z(); points.len()];
        let refiner = Refiner { points: &points, across: &across };
        let node = points.iter().position(|p| p.xy().coords.norm() < 1e-9).unwrap();
        let field = |f: fn(f64, f64) -> f64| -> Vec<f32> {
            points.iter().map(|p| f(p.x * 1e3, p.y * 1e3) as f32).collect()
        };
        let top = field(|x, y| 90.0 - (x - 0.4).powi(2) - 2.0 * (y + 0.7).powi(2) - 0.3 * x * y);
        let found = refiner.peak(&top, node);
        // ∇ = 0: 2 (x − 0.4) + 0.3 y = 0 and 4 (y + 0.7) + 0.3 x = 0
        let exact =
            Matrix2::new(2.0, 0.3, 0.3, 4.0).try_inverse().unwrap() * Vector2::new(0.8, -2.8);
        assert!((found[0] * 1e3 - exact.x).abs() < 1e-4, "{found:?} {exact}");
        assert!((found[1] * 1e3 - exact.y).abs() < 1e-4, "{found:?} {exact}");
        assert!((found[2] - 0.01).abs() < 1e-12);
        let saddle = field(|x, y| x * x - y * y);
        assert_eq!(refiner.peak(&saddle, node), [0.0, 0.0, 0.01]);
        let far = field(|x, y| -(x - 9.0).powi(2) - y * y);
        let found = refiner.peak(&far, node);
        assert!((found[0] - 2e-3).abs() < 1e-9, "no farther than a node: {found:?}");
    }
}
