//! A body that the supports do not hold, and how it can move.

use std::fmt;

use nalgebra::{Point3, Vector3};

/// A body that the supports do not hold.
#[derive(Clone, Debug, PartialEq)]
pub struct FloatingBody {
    /// The first of its elements, counted from 0.
    pub first_element: usize,
    /// How many elements it has.
    pub n_elements: usize,
    /// The mean of its nodes, m.
    pub centre_m: Point3<f64>,
    /// How many of its nodes are held in some direction.
    pub n_held: usize,
    /// A basis of its free motions; for a body with hinges, the motion of the part that moves most.
    pub free: Vec<RigidMotion>,
}

/// A small rigid motion u(x) = translation + rotation × (x − centre).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidMotion {
    /// The point the rotation is taken about, m.
    pub centre_m: Point3<f64>,
    /// Translation, m, at the scale where the rotation below moves the body by its own size.
    pub translation: Vector3<f64>,
    /// Rotation vector, rad.
    pub rotation: Vector3<f64>,
}

impl fmt::Display for RigidMotion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let angle_2 = self.rotation.norm_squared();
        if angle_2 == 0.0 {
            let [x, y, z] = (self.translation / self.translation.norm()).into();
            return write!(f, "translation along ({x:.3}, {y:.3}, {z:.3})");
        }
        let foot = self.centre_m + self.rotation.cross(&self.translation) / angle_2;
        let [x, y, z] = (self.rotation / angle_2.sqrt()).into();
        write!(
            f,
            "rotation about ({x:.3}, {y:.3}, {z:.3}) through ({:.4}, {:.4}, {:.4}) m",
            foot.x, foot.y, foot.z
        )
    }
}

impl fmt::Display for FloatingBody {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let c = &self.centre_m;
        write!(
            f,
            "the body of {} elements from element {} on, centred at ({:.4}, {:.4}, {:.4}) m with {} \
             held nodes, has {} free motions: ",
            self.n_elements,
            self.first_element,
            c.x,
            c.y,
            c.z,
            self.n_held,
            self.free.len()
        )?;
        let free: Vec<String> = self.free.iter().map(ToString::to_string).collect();
        f.write_str(&free.join(", "))
    }
}
