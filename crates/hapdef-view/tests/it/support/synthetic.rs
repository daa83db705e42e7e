//! A made-up limb with made-up readings: nothing here is computed by elasticity.

use hapdef_contact::{Contact, GaugeHealth, TouchPhase, Uncertainty};
use hapdef_view::{ContactMark, Displacement, GaugeSite, LimbPicture, ViewFrame};
use nalgebra::{Matrix3, Vector3};

const N_RINGS: usize = 67;
const N_AROUND: usize = 48;
const LENGTH_M: f64 = 0.32;
/// Width of the dent that a force makes, m.
const DENT_M: f64 = 0.022;
/// Depth of the dent, m for each newton.
const DENT_M_PER_N: f64 = 18e-6;
/// Reading at the force, µε for each newton.
const STRAIN_UE_PER_N: f64 = 42.0;

/// A force on the limb.
#[derive(Clone, Copy, Debug)]
pub struct Touch {
    pub id: u32,
    pub point_m: [f64; 3],
    pub normal: [f64; 3],
    pub force_n: f64,
}

/// A limb of 3,216 nodes with ten gauges.
pub fn picture() -> LimbPicture {
    let mut picture = LimbPicture {
        title: "Made-up shin".to_owned(),
        up: Some([0.0, 0.0, 1.0]),
        view_from: Some([1.0, -0.55, 0.0]),
        ..LimbPicture::default()
    };
    for ring in 0..N_RINGS {
        for step in 0..N_AROUND {
            let (point, normal) = on_limb(angle(step), height(ring));
            picture.vertices_m.push(point.map(|c| c as f32));
            picture.normals.push(normal.map(|c| c as f32));
        }
    }
    let node = |ring: usize, step: usize| (ring * N_AROUND + step % N_AROUND) as u32;
    for ring in 0..N_RINGS - 1 {
        for step in 0..N_AROUND {
            let [a, b] = [node(ring, step), node(ring, step + 1)];
            let [c, d] = [node(ring + 1, step), node(ring + 1, step + 1)];
            picture.triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    picture.gauges = (0..10).map(gauge).collect();
    picture
}

/// Point and outward normal at an angle and a height.
pub fn on_limb(theta: f64, z: f64) -> ([f64; 3], [f64; 3]) {
    let point = |theta: f64, z: f64| {
        let s = z / LENGTH_M;
        let radius = 0.034 + 0.014 * (std::f64::consts::PI * (0.15 + 0.8 * s)).sin() + 0.008 * s;
        let flat = 1.0 - 0.16 * theta.cos().powi(3);
        let bow = 0.012 * (std::f64::consts::PI * s).sin();
        [radius * flat * theta.cos() + bow, 0.9 * radius * theta.sin(), z]
    };
    let (h, at) = (1e-5, point(theta, z));
    let along = sub(point(theta + h, z), point(theta - h, z));
    let up = sub(point(theta, z + h), point(theta, z - h));
    (at, unit(cross(along, up)))
}

/// Two touches that wander, of which one comes and goes.
pub fn wandering(t: f64) -> Vec<Touch> {
    let touch = |id, theta: f64, z: f64, force_n: f64| {
        let (point_m, normal) = on_limb(theta, z);
        Touch { id, point_m, normal, force_n }
    };
    let first = touch(
        0,
        -0.75 + 0.45 * (0.7 * t).sin(),
        0.215 + 0.035 * (0.5 * t).cos(),
        5.0 + 2.2 * (1.3 * t).sin(),
    );
    let strength = 4.5 * (0.45 * t + 0.6).sin();
    let second = touch(1, 0.1 + 0.3 * (0.4 * t).cos(), 0.095 + 0.03 * (0.9 * t).sin(), strength);
    if strength > 0.6 { vec![first, second] } else { vec![first] }
}

/// What the page shows of `touches` at `t`, into `frame`. The contacts are where the touches are.
pub fn show(picture: &LimbPicture, touches: &[Touch], t: f64, frame: &mut ViewFrame) {
    frame.t_s = t;
    frame.phase = if touches.is_empty() { TouchPhase::Untouched } else { TouchPhase::Touched };
    frame.contacts = touches.iter().map(mark).collect();
    frame.p_value = 0.4;
    let depth = |point: [f64; 3], normal: [f64; 3]| {
        let mut moved = [0.0; 3];
        for touch in touches {
            let r = length(sub(point, touch.point_m)) / DENT_M;
            let facing = (0.2 + 0.8 * dot(normal, touch.normal)).max(0.0);
            let by = DENT_M_PER_N * touch.force_n * facing * (-0.5 * r * r).exp();
            (0..3).for_each(|k| moved[k] -= by * touch.normal[k]);
        }
        moved
    };
    let nodes = picture.vertices_m.iter().zip(&picture.normals);
    let displaced = nodes.map(|(v, n)| depth(v.map(f64::from), n.map(f64::from)).map(|c| c as f32));
    frame.displacement = Displacement::Vector(displaced.collect());
    frame.readings_ue.clear();
    for (i, gauge) in picture.gauges.iter().enumerate() {
        let strain = touches.iter().map(|touch| {
            let r = length(sub(gauge.position_m, touch.point_m)) / 0.05;
            STRAIN_UE_PER_N * touch.force_n * (1.0 - r * r) * (-0.7 * r * r).exp()
        });
        let reading = strain.sum::<f64>() + 0.8 * noise(t, i);
        frame.readings_ue.push(reading.clamp(-400.0, 400.0));
    }
    frame.gauge_health = vec![GaugeHealth::Good; picture.gauges.len()];
}

/// The mark of a touch.
pub fn mark(touch: &Touch) -> ContactMark {
    let across = unit(cross([0.0, 0.0, 1.0], touch.normal));
    let tangents = [across, cross(touch.normal, across)].map(Vector3::from);
    let force_sd_n: f64 = 0.04 + 0.03 * touch.force_n;
    let (xy, force) = (1.6e-6, force_sd_n.powi(2));
    let covariance = Matrix3::new(3.2e-6, xy, 0.0, xy, 7.0e-6, 0.0, 0.0, 0.0, force);
    ContactMark {
        contact: Contact {
            id: Some(touch.id.into()),
            uncertainty: Some(Uncertainty { tangents, covariance }),
            ..Contact::new(touch.point_m.into(), touch.force_n)
        },
        normal: touch.normal.into(),
        force_range_n: None,
    }
}

fn gauge(i: usize) -> GaugeSite {
    let (column, row) = (i % 2, i / 2);
    let theta = -0.95 + 1.15 * column as f64 + 0.25 * (row % 2) as f64;
    let (position_m, normal) = on_limb(theta, 0.05 + 0.055 * row as f64);
    let across = unit(cross([0.0, 0.0, 1.0], normal));
    let along = cross(normal, across);
    GaugeSite {
        name: format!("G{}", i + 1),
        position_m,
        axis: if row % 2 == 0 { along } else { across },
    }
}

/// White noise by a hash of the time, in −1…1.
fn noise(t: f64, i: usize) -> f64 {
    let mut x = t.to_bits() ^ (i as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    for shift in [30, 27, 31] {
        x = (x ^ (x >> shift)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    }
    (x >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

fn angle(step: usize) -> f64 {
    std::f64::consts::TAU * step as f64 / N_AROUND as f64
}

fn height(ring: usize) -> f64 {
    LENGTH_M * ring as f64 / (N_RINGS - 1) as f64
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| a[k] - b[k])
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn length(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3])
}

fn unit(a: [f64; 3]) -> [f64; 3] {
    a.map(|c| c / length(a))
}
