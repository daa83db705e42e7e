//! A made-up limb whose response is known everywhere: a barrel with gauges that see ring modes,
//! bending and a lobe of their own, smooth as elasticity is.
#![allow(clippy::unwrap_used, reason = "what can't be prepared fails its test or its benchmark")]
#![allow(dead_code, reason = "each test uses a part of it")]

use std::f64::consts::TAU;
use std::sync::Arc;

use hapdef_inverse::{
    ContactEstimator, EstimatorParams, NoiseParams, ResponseMap, ResponseParams, ScanSites, Skin,
    SkinFaces, SkinParams, SkinPoint,
};
use nalgebra::{Point3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

pub const RADIUS_M: f64 = 0.035;
pub const LENGTH_M: f64 = 0.11;

/// What a gauge sees, µε/N.
#[derive(Clone, Debug)]
pub struct Gauge {
    pub angle: f64,
    pub height_m: f64,
    modes: [f64; 4],
    phases: [f64; 4],
    reach_m: f64,
    along: bool,
}

#[derive(Clone, Debug)]
pub struct World {
    pub gauges: Vec<Gauge>,
    pub map: Arc<ResponseMap>,
    pub sites: Arc<ScanSites>,
}

impl World {
    pub fn new(n_gauges: usize, n_sites: usize, seed: u64) -> Self {
        Self::on(barrel(28, 22, true), n_gauges, n_sites, seed)
    }

    pub fn on(skin: Skin, n_gauges: usize, n_sites: usize, seed: u64) -> Self {
        let gauges = draw_gauges(n_gauges, seed);
        let adjoint: Vec<Vector3<f64>> = skin
            .nodes()
            .iter()
            .flat_map(|x| gauges.iter().map(|g| g.response(x)).collect::<Vec<_>>())
            .collect();
        let params = ResponseParams::default();
        let map = ResponseMap::from_nodal(skin, n_gauges, &adjoint, &params).unwrap();
        let sites = ScanSites::farthest(map.skin(), n_sites).unwrap();
        Self { gauges, map: Arc::new(map), sites: Arc::new(sites) }
    }

    /// The gauges' formulas on the subdivided six-node faces of the skin.
    pub fn subdivided(&self) -> ResponseMap {
        let skin = self.map.skin();
        let points = skin.subdivided_points();
        let values = points.iter().flat_map(|point| {
            let x = skin.position(point);
            let gauges = self.gauges.iter();
            gauges.map(|gauge| gauge.response(&x)).collect::<Vec<_>>()
        });
        let values: Vec<_> = values.collect();
        ResponseMap::from_subdivided(skin.clone(), self.gauges.len(), &values).unwrap()
    }

    pub fn estimator(&self, noise: NoiseParams, params: EstimatorParams) -> ContactEstimator {
        ContactEstimator::new(self.map.clone(), self.sites.clone(), noise, params).unwrap()
    }

    /// Readings of the map itself, without noise.
    pub fn readings(&self, contacts: &[(SkinPoint, f64)]) -> Vec<f64> {
        let mut y = vec![0.0; self.gauges.len()];
        for (point, force_n) in contacts {
            for (y, g) in y.iter_mut().zip(self.map.normal(point)) {
                *y += force_n * g;
            }
        }
        y
    }

    /// Points at least `gap_m` apart, uniform over the skin's faces.
    pub fn draw_points(&self, n: usize, gap_m: f64, rng: &mut ChaCha8Rng) -> Vec<SkinPoint> {
        let skin = self.map.skin();
        let mut points: Vec<SkinPoint> = Vec::new();
        while points.len() < n {
            let point = draw_point(skin, rng);
            let x = skin.position(&point);
            let is_apart = |p: &SkinPoint| (skin.position(p) - x).norm() >= gap_m;
            if points.iter().all(is_apart) {
                points.push(point);
            }
        }
        points
    }
}

pub fn draw_point(skin: &Skin, rng: &mut ChaCha8Rng) -> SkinPoint {
    let face = rng.random_range(0..skin.n_faces());
    SkinPoint::drawn(skin, face, [rng.random(), rng.random()]).unwrap()
}

pub fn add_noise(y: &mut [f64], sd: f64, rng: &mut ChaCha8Rng) {
    for y in y {
        let n: f64 = StandardNormal.sample(rng);
        *y += sd * n;
    }
}

fn draw_gauges(n: usize, seed: u64) -> Vec<Gauge> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..n)
        .map(|i| Gauge {
            angle: TAU * (i as f64 * 0.618_034 + 0.05 * rng.random::<f64>()),
            height_m: LENGTH_M * (0.15 + 0.7 * ((i as f64 * 0.754_878) % 1.0)),
            modes: [3.0, 5.0, 3.0, 1.5].map(|a| a * rng.random_range(0.7..1.3)),
            phases: std::array::from_fn(|_| rng.random_range(-0.6..0.6)),
            reach_m: rng.random_range(0.03..0.05),
            along: i % 2 == 0,
        })
        .collect()
}

impl Gauge {
    /// Reading per newton in each direction at `x`.
    pub fn response(&self, x: &Point3<f64>) -> Vector3<f64> {
        let out = Vector3::new(x.x, 0.0, x.z) / x.x.hypot(x.z);
        let around = Vector3::new(-out.z, 0.0, out.x);
        let g = self.normal(x);
        // a push along the skin acts like other pushes elsewhere
        let turned = |angle: f64, up_m: f64| {
            let (s, c) = angle.sin_cos();
            Point3::new(c * x.x - s * x.z, x.y + up_m, s * x.x + c * x.z)
        };
        let (far, near) = (turned(0.9, 0.02), turned(-1.3, -0.015));
        -out * g + around * (0.5 * self.normal(&far)) + Vector3::y() * (0.4 * self.normal(&near))
    }

    /// Reading per newton against the normal at `x`.
    pub fn normal(&self, x: &Point3<f64>) -> f64 {
        let turn = x.z.atan2(x.x) - self.angle;
        let dy = x.y - self.height_m;
        let fade = (-0.5 * (dy / self.reach_m).powi(2)).exp();
        let mut g = 0.0;
        for (n, (a, phase)) in self.modes.iter().zip(&self.phases).enumerate() {
            g += a * fade * ((n as f64 + 1.0) * turn + phase).cos();
        }
        let lever = 4.0 * (x.y / LENGTH_M).powi(2) * turn.cos();
        let (u, v) = (2.0 * RADIUS_M * (0.5 * turn).sin(), dy);
        let d_2 = (u * u + v * v) / 0.012_f64.powi(2);
        let stretch = if self.along { v * v - u * u } else { u * u - v * v };
        g + lever + 14.0 * (0.6 + stretch / 0.012_f64.powi(2)) * (-0.5 * d_2).exp()
    }
}

/// An open barrel of `n_around × n_up` squares, each of two faces.
pub fn barrel(n_around: u32, n_up: u32, is_quadratic: bool) -> Skin {
    let fine = if is_quadratic { 2 } else { 1 };
    let (wide, high) = (fine * n_around, fine * n_up);
    let mut nodes = Vec::new();
    for j in 0..=high {
        for i in 0..wide {
            let angle = TAU * f64::from(i) / f64::from(wide);
            let y = LENGTH_M * f64::from(j) / f64::from(high);
            nodes.push(Point3::new(RADIUS_M * angle.cos(), y, RADIUS_M * angle.sin()));
        }
    }
    let at = |i: u32, j: u32| j * wide + i % wide;
    let (mut flat, mut curved) = (Vec::new(), Vec::new());
    for j in 0..n_up {
        for i in 0..n_around {
            let c = |a: u32, b: u32| at(fine * i + a, fine * j + b);
            if is_quadratic {
                curved.push([c(0, 0), c(0, 2), c(2, 2), c(0, 1), c(1, 2), c(1, 1)]);
                curved.push([c(0, 0), c(2, 2), c(2, 0), c(1, 1), c(2, 1), c(1, 0)]);
            } else {
                flat.push([c(0, 0), c(0, 1), c(1, 1)]);
                flat.push([c(0, 0), c(1, 1), c(1, 0)]);
            }
        }
    }
    let faces = if is_quadratic { SkinFaces::Quadratic(&curved) } else { SkinFaces::Linear(&flat) };
    // the nodes on the rims have the barrel's normals, too
    let normals: Vec<Vector3<f64>> =
        nodes.iter().map(|x| Vector3::new(x.x, 0.0, x.z) / RADIUS_M).collect();
    let nodes = nodes.clone();
    Skin::new(nodes, faces, Some(&normals), &SkinParams::default()).unwrap()
}

/// One-to-one matching that minimises the summed distance; distances by true contact, m.
pub fn matched(truth: &[Point3<f64>], found: &[Point3<f64>]) -> Vec<Option<usize>> {
    fn best(
        i: usize,
        truth: &[Point3<f64>],
        found: &[Point3<f64>],
        used: &mut Vec<bool>,
    ) -> (f64, Vec<Option<usize>>) {
        if i == truth.len() {
            return (0.0, Vec::new());
        }
        let mut result = best(i + 1, truth, found, used);
        result.0 += 10.0;
        result.1.insert(0, None);
        for j in 0..found.len() {
            if used[j] {
                continue;
            }
            used[j] = true;
            let (cost, mut rest) = best(i + 1, truth, found, used);
            used[j] = false;
            let cost = cost + (truth[i] - found[j]).norm();
            if cost < result.0 {
                rest.insert(0, Some(j));
                result = (cost, rest);
            }
        }
        result
    }
    best(0, truth, found, &mut vec![false; found.len()]).1
}
