//! Values at the points of a regular grid.

use nalgebra::Point3;
use rayon::prelude::*;

use super::WrapFault;
use super::distance::Distances;
use crate::BoundingBox;

/// Points that a grid may have: five fields in single precision then take 1 GB.
const MAX_POINTS: usize = 50_000_000;

/// Layers of points that one task of [`Grid::distances`] fills.
const LAYERS: usize = 8;

/// A grid of `n` points along x, y, z; point (i, j, k) has the number (k n_y + j) n_x + i.
pub(super) struct Grid {
    pub n: [usize; 3],
    pub origin: Point3<f64>,
    pub spacing_m: f64,
}

/// The distances wanted: exact within `width_m` of `level_m`, elsewhere bounds on the same side.
pub(super) struct Band {
    pub level_m: f64,
    pub width_m: f64,
}

impl Grid {
    /// The grid around a box with a margin.
    pub(super) fn around(
        bounds: &BoundingBox,
        margin_m: f64,
        spacing_m: f64,
    ) -> Result<Self, WrapFault> {
        let counts = bounds.size_m().map(|size| ((size + 2.0 * margin_m) / spacing_m).ceil() + 1.0);
        if counts.product() > MAX_POINTS as f64 {
            let (grid_m, n_points, max_points) = (spacing_m, counts.product(), MAX_POINTS);
            return Err(WrapFault::Grid { grid_m, n_points, max_points });
        }
        let origin = bounds.min.map(|x| x - margin_m);
        Ok(Self { n: counts.map(|n| n as usize).into(), origin, spacing_m })
    }

    pub(super) fn len(&self) -> usize {
        self.n.iter().product()
    }

    pub(super) fn number(&self, [i, j, k]: [usize; 3]) -> usize {
        (k * self.n[1] + j) * self.n[0] + i
    }

    pub(super) fn point(&self, ijk: [usize; 3]) -> Point3<f64> {
        Point3::from([0, 1, 2].map(|a| self.origin[a] + ijk[a] as f64 * self.spacing_m))
    }

    /// The distances of all points that are `wanted`, m; the others get the band's upper end.
    pub(super) fn distances(
        &self,
        to: &Distances,
        band: &Band,
        wanted: impl Fn(usize) -> bool + Sync,
    ) -> Vec<f32> {
        let high = (band.level_m + band.width_m) as f32;
        let mut values = vec![high; self.len()];
        let layer = self.n[0] * self.n[1];
        values.par_chunks_mut(layer * LAYERS).enumerate().for_each(|(chunk, values)| {
            let first = chunk * LAYERS;
            let fill = Fill { grid: self, to, band, wanted: &wanted, first: first * layer };
            for j in (0..self.n[1]).step_by(LAYERS) {
                for i in (0..self.n[0]).step_by(LAYERS) {
                    fill.block([i, j, first], LAYERS, values);
                }
            }
        });
        values
    }

    /// The points that are `open` and connected, along axes, with the first point, which is.
    pub(super) fn flood(&self, open: impl Fn(usize) -> bool) -> Vec<bool> {
        let mut is_reached = vec![false; self.len()];
        self.spread(0, &open, &mut is_reached);
        is_reached
    }

    /// The largest set of points that are `inside` and connected along axes, and its share of all
    /// those points; `None` where there is none.
    pub(super) fn largest(&self, inside: impl Fn(usize) -> bool) -> Option<(Vec<bool>, f64)> {
        let mut is_seen = vec![false; self.len()];
        let (mut most, mut start, mut all) = (0, 0, 0);
        for point in 0..self.len() {
            if !is_seen[point] && inside(point) {
                let n = self.spread(point, &inside, &mut is_seen);
                all += n;
                if n > most {
                    (most, start) = (n, point);
                }
            }
        }
        let mut set = vec![false; self.len()];
        (most > 0).then(|| {
            self.spread(start, &inside, &mut set);
            (set, most as f64 / all as f64)
        })
    }

    /// Marks `start` and what is connected with it; returns how many points that are.
    fn spread(&self, start: usize, inside: &impl Fn(usize) -> bool, seen: &mut [bool]) -> usize {
        let mut stack = vec![start];
        seen[start] = true;
        let mut n = 0;
        while let Some(point) = stack.pop() {
            n += 1;
            for next in self.neighbours(point) {
                if !seen[next] && inside(next) {
                    seen[next] = true;
                    stack.push(next);
                }
            }
        }
        n
    }

    fn neighbours(&self, point: usize) -> impl Iterator<Item = usize> + use<> {
        let [nx, ny, nz] = self.n;
        let (i, j, k) = (point % nx, point / nx % ny, point / (nx * ny));
        let at = move |exists: bool, other: usize| exists.then_some(other);
        [
            at(i > 0, point.wrapping_sub(1)),
            at(i + 1 < nx, point + 1),
            at(j > 0, point.wrapping_sub(nx)),
            at(j + 1 < ny, point + nx),
            at(k > 0, point.wrapping_sub(nx * ny)),
            at(k + 1 < nz, point + nx * ny),
        ]
        .into_iter()
        .flatten()
    }

    /// The value at any place, linear in each coordinate between points.
    pub(super) fn between(&self, values: &[f32], place: &Point3<f64>) -> f64 {
        let (mut base, mut weight) = ([0; 3], [0.0; 3]);
        for a in 0..3 {
            let x = (place[a] - self.origin[a]) / self.spacing_m;
            let x = x.clamp(0.0, (self.n[a] - 1) as f64);
            base[a] = (x as usize).min(self.n[a] - 2);
            weight[a] = x - base[a] as f64;
        }
        let mut sum = 0.0;
        for corner in 0..8 {
            let bit = |a: usize| corner >> a & 1;
            let share = |a: usize| if bit(a) == 1 { weight[a] } else { 1.0 - weight[a] };
            let value = values[self.number([0, 1, 2].map(|a| base[a] + bit(a)))];
            sum += share(0) * share(1) * share(2) * f64::from(value);
        }
        sum
    }
}

/// One chunk of layers being filled with distances.
struct Fill<'a, F> {
    grid: &'a Grid,
    to: &'a Distances,
    band: &'a Band,
    wanted: &'a F,
    /// The number of the chunk's first point.
    first: usize,
}

impl<F: Fn(usize) -> bool> Fill<'_, F> {
    /// Fills a cube of `size` points a side, a power of two: a distance changes at most as fast as
    /// the place, so that its middle tells whether all are out of the band.
    fn block(&self, start: [usize; 3], size: usize, values: &mut [f32]) {
        let n = self.grid.n;
        let ends = [0, 1, 2].map(|a| (start[a] + size).min(n[a]));
        let rows = (start[2]..ends[2]).flat_map(|k| (start[1]..ends[1]).map(move |j| (j, k)));
        let row = |(j, k)| {
            let first = self.grid.number([start[0], j, k]);
            first..first + ends[0].saturating_sub(start[0])
        };
        let points = || rows.clone().flat_map(row).filter(|&point| (self.wanted)(point));
        if points().next().is_none() {
            return;
        }
        let half_m = 0.5 * (size - 1) as f64 * self.grid.spacing_m;
        let middle = self.grid.point(start).map(|x| x + half_m);
        let middle_m = self.to.at_m(&middle);
        // A hundredth of the spacing for single precision.
        let reach_m = 3.0_f64.sqrt() * half_m + 0.01 * self.grid.spacing_m;
        let Band { level_m, width_m } = self.band;
        let (low, high) = (level_m - width_m, level_m + width_m);
        if size == 1 || middle_m - reach_m > high || middle_m + reach_m < low {
            points().for_each(|p| values[p - self.first] = middle_m.clamp(low, high) as f32);
            return;
        }
        let half = size / 2;
        for part in 0..8 {
            let corner = [0, 1, 2].map(|a| start[a] + half * (part >> a & 1));
            if (0..3).all(|a| corner[a] < n[a]) {
                self.block(corner, half, values);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::triangles::tests::{cuboid, sphere};

    fn grid() -> Grid {
        Grid::around(&cuboid(0.1, 0.06, 0.04).bounding_box(), 0.02, 0.005).unwrap()
    }

    #[test]
    fn distances_are_exact_in_the_band_and_beyond_it_on_the_right_side() {
        let (grid, ball) = (grid(), sphere(3).scaled(0.03).unwrap());
        let to = Distances::to(&ball).unwrap();
        let band = Band { level_m: 0.02, width_m: 0.008 };
        let values = grid.distances(&to, &band, |_| true);
        let all = (0..grid.n[2]).flat_map(|k| (0..grid.n[1]).map(move |j| (j, k)));
        for (i, (j, k)) in all.flat_map(|jk| (0..grid.n[0]).map(move |i| (i, jk))) {
            let exact = to.at_m(&grid.point([i, j, k])).clamp(0.012, 0.028);
            let found = f64::from(values[grid.number([i, j, k])]);
            assert!((found - exact).abs() < 1e-8, "{i} {j} {k}: {found} {exact}");
        }
        let none = grid.distances(&to, &band, |_| false);
        assert!(none.iter().all(|v| *v == 0.028));
    }

    #[test]
    fn a_flood_stops_at_walls_and_the_largest_set_is_found() {
        let grid = grid();
        let i_of = |point: usize| point % grid.n[0];
        let reached = grid.flood(|point| i_of(point) != 4);
        assert_eq!(reached.iter().filter(|r| **r).count(), 4 * grid.n[1] * grid.n[2]);
        let (set, share) = grid.largest(|point| i_of(point) != 4).unwrap();
        assert!(!set[0] && set[grid.n[0] - 1]);
        let n = grid.n[0] as f64;
        assert!((share - (n - 5.0) / (n - 1.0)).abs() < 1e-12);
        assert!(grid.largest(|_| false).is_none());
    }

    #[test]
    fn linear_fields_are_met_between_the_points() {
        let grid = grid();
        let linear = |p: &Point3<f64>| 2.0 * p.x - 3.0 * p.y + 0.5 * p.z + 0.1;
        let at = |point: usize| {
            let [nx, ny, _] = grid.n;
            linear(&grid.point([point % nx, point / nx % ny, point / (nx * ny)])) as f32
        };
        let values: Vec<f32> = (0..grid.len()).map(at).collect();
        for place in [[0.0, 0.0, 0.0], [0.031, 0.017, 0.013], [0.1199, 0.0799, 0.0599]] {
            let place = Point3::from(place);
            assert!((grid.between(&values, &place) - linear(&place)).abs() < 1e-7);
        }
    }

    #[test]
    fn too_many_points_are_refused() {
        let error = Grid::around(&cuboid(1.0, 1.0, 1.0).bounding_box(), 0.1, 1e-4).err().unwrap();
        assert!(error.to_string().contains("check the unit"), "{error}");
    }
}
