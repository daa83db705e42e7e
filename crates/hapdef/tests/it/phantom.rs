//! A recorded phantom: a press beside one that slides and one that holds was reported as 132 N at the rim.

use std::path::Path;

use hapdef::touch::{SearchPlace, Touch, TouchEstimator};
use hapdef::{OpenParams, OpenScene};
use nalgebra::Point3;

use crate::support::shared;

/// Frame in which the readings begin to move by the third press; 20 ms later it has to be known.
const ONSET: usize = 1015;
/// Frame in which it is 14 N strong.
const AT_14_N: usize = 1062;
/// No force of the recording is beyond 34 N; the map is off by its usual error. Beyond it the runtime reports no
/// contact, beyond half more nothing is believed.
const MOST_N: f64 = 1.1 * 34.0;
const BELIEVED_N: f64 = 1.5 * 34.0;
/// Frames whose forces may be beyond: when a contact begins to slide again.
const N_BEYOND: usize = 5;

#[test]
fn the_recorded_phantom_is_the_press_that_it_was() {
    let Some(csv) = shared("inputs/live-faults/phantom_132N_readings.csv") else { return };
    let text = std::fs::read_to_string(csv).unwrap();
    let out = tempfile::tempdir().unwrap();
    let params = OpenParams { results: out.path().to_owned(), threads: 2, ..OpenParams::default() };
    let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/shin/demo.json");
    let scene = OpenScene::with_params(&demo, params).unwrap();
    let mut tracker = scene.solve().unwrap().tracker(SearchPlace::Here).unwrap();
    let third = Point3::new(-0.033, 0.097, -0.015);
    let (mut touch, mut n_beyond) = (Touch::with_room(), 0);
    for (frame, line) in text.lines().enumerate() {
        let readings: Vec<f64> = line.split(',').map(|word| word.parse().unwrap()).collect();
        tracker.estimate(&readings, &mut touch).unwrap();
        let contacts = &touch.contacts;
        if frame < ONSET + 20 {
            continue;
        }
        let strongest_n = contacts.iter().map(|c| c.force_n).fold(0.0, f64::max);
        assert!(strongest_n < BELIEVED_N, "frame {frame}: {contacts:?}");
        if strongest_n > MOST_N {
            n_beyond += 1;
            assert!(!touch.quality.unwrap().is_identified(), "frame {frame}: {touch:?}");
        }
        assert_eq!(contacts.len(), 3, "frame {frame}: {contacts:?}");
        let near = contacts.iter().find(|c| (c.position_m - third).norm() < 5e-3);
        let force_n = near.map(|c| c.force_n);
        assert!(force_n.is_some(), "frame {frame}: {contacts:?}");
        let is_14_n = force_n.is_some_and(|force_n| (force_n - 14.0).abs() < 1.5);
        assert!(frame != AT_14_N || is_14_n, "{force_n:?} N");
    }
    assert!(n_beyond <= N_BEYOND, "{n_beyond} frames");
}
