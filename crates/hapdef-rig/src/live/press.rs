//! What presses on the limb at a time: asked for, and true.

use std::sync::{Arc, Mutex, PoisonError};

use hapdef_contact::Contact;
use nalgebra::{Point3, Vector3};

use super::limb::{LiveLimb, SurfacePoint};

/// A contact that a caller wants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pressed {
    /// The caller's number for it.
    pub id: u32,
    /// Where, m; the nearest point of the surface is pressed.
    pub position_m: Point3<f64>,
    /// Normal force into the limb, N; nothing is pressed unless it is above 0.
    pub force_n: f64,
    /// Force along the skin, N; what of it is not along the skin is left out.
    pub shear_n: Vector3<f64>,
}

/// A contact as it is: ground truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrueContact {
    /// The script's or the caller's number for it.
    pub id: u32,
    /// Where on the surface.
    pub point: SurfacePoint,
    /// Where in space, m.
    pub position_m: Point3<f64>,
    /// Unit vector out of the limb.
    pub normal: Vector3<f64>,
    /// Normal force, N.
    pub force_n: f64,
    /// Force along the skin, N.
    pub shear_n: Vector3<f64>,
}

/// Ground truth of one DATA packet. `(boot_id, seq)` names the packet.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TruthFrame {
    /// Start of the device that the packet belongs to.
    pub boot_id: u32,
    /// Number of the packet.
    pub seq: u32,
    /// Device time of the sample instant, µs.
    pub t_device_us: u64,
    /// Time since the play began, without the device's drift, s.
    pub t_s: f64,
    /// What presses then, the script's contacts first.
    pub contacts: Vec<TrueContact>,
    /// How much there is of each load on the whole limb that is no contact `[n_loads]`, in its unit.
    pub loads: Vec<f64>,
}

/// Sets what is pressed by hand, from any thread: the device takes it up with its next frame.
#[derive(Clone, Debug, Default)]
pub struct PressHandle {
    pressed: Arc<Mutex<Vec<Pressed>>>,
}

impl Pressed {
    /// A normal press.
    #[must_use]
    pub fn normal(id: u32, position_m: Point3<f64>, force_n: f64) -> Self {
        Self { id, position_m, force_n, shear_n: Vector3::zeros() }
    }

    /// What it does on the limb; `None` if it does not press or a number is not finite.
    #[must_use]
    pub fn on(&self, limb: &LiveLimb) -> Option<TrueContact> {
        let is_finite = self.force_n.is_finite() && self.shear_n.iter().all(|c| c.is_finite());
        if !is_finite || self.force_n <= 0.0 {
            return None;
        }
        let (point, _) = limb.nearest(&self.position_m)?;
        Some(TrueContact::new(limb, self.id, point, self.force_n, &self.shear_n))
    }
}

impl TrueContact {
    /// A contact at a point; of `shear_n` the part along the skin counts.
    #[must_use]
    pub fn new(
        limb: &LiveLimb,
        id: u32,
        point: SurfacePoint,
        force_n: f64,
        shear_n: &Vector3<f64>,
    ) -> Self {
        let normal = -limb.inward(&point);
        Self {
            id,
            point,
            position_m: limb.position_m(&point),
            normal,
            force_n,
            shear_n: shear_n - normal * normal.dot(shear_n),
        }
    }

    /// What an estimator that is right would say of its normal force.
    #[must_use]
    pub fn contact(&self) -> Contact {
        Contact {
            direction: Some(-self.normal),
            id: Some(self.id.into()),
            ..Contact::new(self.position_m, self.force_n)
        }
    }

    /// The force on the limb, N.
    #[must_use]
    pub fn force_vector_n(&self) -> Vector3<f64> {
        self.shear_n - self.normal * self.force_n
    }
}

impl PressHandle {
    /// Nothing pressed.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Replaces what is pressed; an empty list lets go.
    pub fn set(&self, pressed: Vec<Pressed>) {
        *self.lock() = pressed;
    }

    /// What is pressed now.
    #[must_use]
    pub fn pressed(&self) -> Vec<Pressed> {
        self.lock().clone()
    }

    /// Copies what is pressed into `out`, which keeps its room.
    pub(super) fn read_into(&self, out: &mut Vec<Pressed>) {
        out.clear();
        out.extend_from_slice(&self.lock());
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Vec<Pressed>> {
        self.pressed.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
