//! Where a skin is not its input.

use nalgebra::Point3;

/// Where skin and input are farther apart than 1.1 r: points a picture can show.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WrapPlaces {
    /// Points of the input's outside that the skin leaves out.
    pub lost: Vec<Point3<f64>>,
    /// What the lost points stand for, m².
    pub lost_m2: f64,
    /// Points of the skin where there is no input: gaps bridged, openings capped.
    pub bridged: Vec<Point3<f64>>,
    /// What the bridged points stand for, m².
    pub bridged_m2: f64,
}
