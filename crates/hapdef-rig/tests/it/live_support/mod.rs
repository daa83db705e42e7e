//! A plate as a limb, and a device on it.

#![allow(dead_code, reason = "each test uses its part")]

use std::sync::Arc;

use hapdef_rig::ElectronicsParams;
use hapdef_rig::live::{
    LiveElectronics, LiveElectronicsParams, LiveLimb, LiveSurface, Play, PressEvent, PressScript,
    RigDevice, RigDeviceParams, ScriptedContact,
};
use nalgebra::{Point3, Vector3};

/// Gauges of the plate.
pub const N_GAUGES: usize = 3;

/// Column of a gauge at a place: quadratic, so that the faces' shape functions have it exactly.
pub fn column(gauge: usize, x: &Point3<f64>) -> Vector3<f64> {
    let g = gauge as f64 + 1.0;
    let (u, v) = (x.x * 20.0, x.y * 20.0);
    Vector3::new(g * u, v - g, -10.0 * g - 3.0 * u * v + g * u * u)
}

/// A plate of 100 × 60 mm in the plane z = 0, pressed from above: 10 × 6 cells of two faces.
pub fn plate() -> Arc<LiveLimb> {
    let (nx, ny) = (10_u32, 6_u32);
    let wide = 2 * nx + 1;
    let node = |i: u32, j: u32| j * wide + i;
    let nodes: Vec<Point3<f64>> = (0..2 * ny + 1)
        .flat_map(|j| (0..wide).map(move |i| Point3::new(i as f64 * 5e-3, j as f64 * 5e-3, 0.0)))
        .collect();
    let mut faces = Vec::new();
    for j in (0..2 * ny).step_by(2) {
        for i in (0..2 * nx).step_by(2) {
            let at = |a: u32, b: u32| node(i + a, j + b);
            faces.push([at(0, 0), at(2, 0), at(2, 2), at(1, 0), at(2, 1), at(1, 1)]);
            faces.push([at(0, 0), at(2, 2), at(0, 2), at(1, 1), at(1, 2), at(0, 1)]);
        }
    }
    let columns = nodes.iter().flat_map(|x| (0..N_GAUGES).map(|gauge| column(gauge, x))).collect();
    let inward = vec![-Vector3::z(); nodes.len()];
    let surface = LiveSurface { nodes, faces, inward };
    Arc::new(LiveLimb::new(surface, N_GAUGES, columns).unwrap())
}

/// Noise of 1 µε, 16 bits, room for 1.5 times 30 N.
pub fn electronics(seed: u64) -> LiveElectronicsParams {
    LiveElectronicsParams::new(ElectronicsParams {
        noise_ue: 1.0,
        adc_bits: 16,
        headroom: 1.5,
        seed,
    })
}

/// A device on the plate.
pub fn device(script: Option<&PressScript>, params: RigDeviceParams, seed: u64) -> RigDevice {
    let limb = plate();
    let play = script.map(|script| Play::new(script, &limb).unwrap());
    let largest = limb.largest_ue(30.0);
    let electronics = LiveElectronics::new(electronics(seed), params.rate_hz, &largest).unwrap();
    RigDevice::new(limb, play, electronics, params).unwrap()
}

/// Two contacts at once, one of which slides, presses harder and leaves, then an impact.
pub fn script() -> PressScript {
    let here = [0.02, 0.02, 0.0];
    let first = vec![
        PressEvent::Arrive {
            at_s: 0.1,
            for_s: 0.1,
            position_m: here,
            force_n: 10.0,
            shear_n: [0.0; 3],
        },
        PressEvent::Slide {
            at_s: 0.3,
            for_s: 0.2,
            path_m: vec![[0.04, 0.02, 0.0], [0.04, 0.04, 0.0]],
        },
        PressEvent::Press { at_s: 0.6, for_s: 0.1, force_n: 20.0, shear_n: [2.0, 0.0, 5.0] },
        PressEvent::Leave { at_s: 0.8, for_s: 0.1 },
    ];
    let second = vec![
        PressEvent::Arrive {
            at_s: 0.15,
            for_s: 0.0,
            position_m: [0.08, 0.05, 0.001],
            force_n: 5.0,
            shear_n: [0.0; 3],
        },
        PressEvent::Leave { at_s: 0.9, for_s: 0.0 },
        PressEvent::Impact { at_s: 0.95, for_s: 0.02, position_m: here, force_n: 30.0 },
    ];
    let contact = |(id, events)| ScriptedContact { id, events };
    PressScript::new([(1, first), (7, second)].map(contact).to_vec())
}
