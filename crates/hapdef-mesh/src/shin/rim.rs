//! The rims of holes on the unrolled surface.

use std::f64::consts::TAU;

use super::ShinParams;
use super::lines::{Along, Around};

/// A place on the unrolled surface: angle and height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    pub(super) theta: f64,
    pub(super) y_m: f64,
}

/// A hole's rim: centre, half axes in m, and the radius that turns angle into arc length.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ellipse {
    centre: Place,
    half_axes_m: (f64, f64),
    pub(super) radius_m: f64,
}

impl Ellipse {
    /// 0 at the centre, 1 on the rim.
    pub(super) fn distance(&self, place: Place) -> f64 {
        let [x, y] = self.offset_m(place);
        (x / self.half_axes_m.0).hypot(y / self.half_axes_m.1)
    }

    /// Along the ray from the centre onto the rim.
    pub(super) fn project(&self, place: Place) -> Place {
        let scale = 1.0 / self.distance(place).max(f64::MIN_POSITIVE);
        let [x, y] = self.offset_m(place);
        Place {
            theta: self.centre.theta + x * scale / self.radius_m,
            y_m: self.centre.y_m + y * scale,
        }
    }

    pub(super) fn offset_m(&self, place: Place) -> [f64; 2] {
        [turn(place.theta - self.centre.theta) * self.radius_m, place.y_m - self.centre.y_m]
    }
}

/// The rims of the holes of `params`.
pub(super) fn ellipses(params: &ShinParams, around: &Around, along: &Along) -> Vec<Ellipse> {
    let place = |hole: &super::ShinHole| {
        let (first, width) = around.sectors[hole.sector];
        let (bottom_m, height_m) = along.bands[hole.band];
        let theta = first + width * hole.centre.0;
        let y_m = bottom_m + height_m * hole.centre.1;
        let radius_m = params.outline.mean_radius_m(y_m);
        let half_axes_m = (width * radius_m * hole.half_axes.0, height_m * hole.half_axes.1);
        Ellipse { centre: Place { theta, y_m }, half_axes_m, radius_m }
    };
    params.holes.iter().map(place).collect()
}

/// An angle difference within ±π.
pub(super) fn turn(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}
