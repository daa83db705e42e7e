//! A script on a limb: what presses at any time.

use nalgebra::{Point3, Vector3};

use super::limb::{LiveLimb, SurfacePoint};
use super::press::TrueContact;
use super::script::{PressEvent, PressScript, ScriptedContact, require};
use crate::error::RigError;

/// Farthest a place of a script may lie off the skin, m.
const MAX_OFF_SKIN_M: f64 = 5e-3;

/// A script whose places have been found on a limb.
#[derive(Clone, Debug)]
pub struct Play {
    tracks: Vec<Track>,
    repeat_s: Option<f64>,
}

#[derive(Clone, Debug)]
struct Track {
    id: u32,
    steps: Vec<Step>,
}

/// From `at_s` to `end_s` force and place change; then they hold until the next step.
#[derive(Clone, Debug)]
struct Step {
    at_s: f64,
    end_s: f64,
    from: Force,
    to: Force,
    is_impact: bool,
    place: Place,
}

/// Normal force, N, and force along the skin, N.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Force {
    normal_n: f64,
    shear_n: Vector3<f64>,
}

#[derive(Clone, Debug)]
enum Place {
    At(SurfacePoint),
    /// Corners of a path and the length up to each, m.
    Along(Vec<(Point3<f64>, f64)>),
}

impl Play {
    /// Finds the places of a script on `limb`.
    ///
    /// # Errors
    /// [`RigError::Script`] for a script that is not in order, or a place more than 5 mm off the skin.
    pub fn new(script: &PressScript, limb: &LiveLimb) -> Result<Self, RigError> {
        script.check()?;
        let contacts = script.contacts.iter().enumerate();
        Ok(Self {
            tracks: contacts
                .map(|(i, contact)| Track::new(i, contact, limb))
                .collect::<Result<_, _>>()?,
            repeat_s: script.repeat_s,
        })
    }

    /// Adds what presses at `t_s` to `out`, in the script's order.
    pub fn at(&self, t_s: f64, limb: &LiveLimb, out: &mut Vec<TrueContact>) {
        let t_s = self.repeat_s.map_or(t_s, |repeat_s| t_s.rem_euclid(repeat_s));
        out.extend(self.tracks.iter().filter_map(|track| track.at(t_s, limb)));
    }
}

impl Track {
    fn new(index: usize, contact: &ScriptedContact, limb: &LiveLimb) -> Result<Self, RigError> {
        let mut force = Force::default();
        let mut place: Option<Place> = None;
        let mut steps = Vec::with_capacity(contact.events.len());
        for (k, event) in contact.events.iter().enumerate() {
            let path = format!("contacts[{index}].events[{k}]");
            let step = Step::new(event, force, place.as_ref(), limb, &path)?;
            force = if step.is_impact { Force::default() } else { step.to };
            place = Some(step.place.clone());
            steps.push(step);
        }
        Ok(Self { id: contact.id, steps })
    }

    fn at(&self, t_s: f64, limb: &LiveLimb) -> Option<TrueContact> {
        let n_begun = self.steps.partition_point(|step| step.at_s <= t_s);
        let step = &self.steps[n_begun.checked_sub(1)?];
        let force = step.force(t_s);
        if force.normal_n <= 0.0 {
            return None;
        }
        let point = step.place.at(step.share(t_s), limb)?;
        Some(TrueContact::new(limb, self.id, point, force.normal_n, &force.shear_n))
    }
}

impl Step {
    fn new(
        event: &PressEvent,
        from: Force,
        place: Option<&Place>,
        limb: &LiveLimb,
        path: &str,
    ) -> Result<Self, RigError> {
        let force = |normal_n: &f64, shear_n: &[f64; 3]| Force {
            normal_n: *normal_n,
            shear_n: Vector3::from(*shear_n),
        };
        let stays = || Place::At(place.map_or(FIRST, |place| place.end(limb)));
        let (to, place) = match event {
            PressEvent::Arrive { position_m, force_n, shear_n, .. } => (
                force(force_n, shear_n),
                Place::At(on_skin(limb, position_m, &format!("{path}.position_m"))?),
            ),
            PressEvent::Press { force_n, shear_n, .. } => (force(force_n, shear_n), stays()),
            PressEvent::Slide { path_m, .. } => {
                let start = limb.position_m(&place.map_or(FIRST, |place| place.end(limb)));
                (from, Place::along(start, path_m, limb, path)?)
            }
            PressEvent::Leave { .. } => (Force::default(), stays()),
            PressEvent::Impact { position_m, force_n, .. } => (
                force(force_n, &[0.0; 3]),
                Place::At(on_skin(limb, position_m, &format!("{path}.position_m"))?),
            ),
        };
        Ok(Self {
            at_s: event.at_s(),
            end_s: event.end_s(),
            from,
            to,
            is_impact: matches!(event, PressEvent::Impact { .. }),
            place,
        })
    }

    /// How much of the step has passed, 0 to 1.
    fn share(&self, t_s: f64) -> f64 {
        if t_s >= self.end_s {
            return 1.0;
        }
        (t_s - self.at_s) / (self.end_s - self.at_s)
    }

    fn force(&self, t_s: f64) -> Force {
        use std::f64::consts::PI;
        let share = self.share(t_s);
        let weight = match (self.is_impact, share >= 1.0) {
            (true, true) => 0.0,
            (true, false) => (PI * share).sin(),
            (false, true) => 1.0,
            (false, false) => (1.0 - (PI * share).cos()) / 2.0,
        };
        let from = if self.is_impact { Force::default() } else { self.from };
        Force {
            normal_n: from.normal_n + (self.to.normal_n - from.normal_n) * weight,
            shear_n: from.shear_n + (self.to.shear_n - from.shear_n) * weight,
        }
    }
}

/// Stands where no place is needed: a checked script names one before it is used.
const FIRST: SurfacePoint = SurfacePoint { face: 0, bary: [1.0, 0.0, 0.0] };

impl Place {
    fn along(
        start: Point3<f64>,
        path_m: &[[f64; 3]],
        limb: &LiveLimb,
        path: &str,
    ) -> Result<Self, RigError> {
        let mut corners = vec![(start, 0.0)];
        for (i, position_m) in path_m.iter().enumerate() {
            let point = on_skin(limb, position_m, &format!("{path}.path_m[{i}]"))?;
            let next = limb.position_m(&point);
            let (last, length_m) = corners[i];
            corners.push((next, length_m + (next - last).norm()));
        }
        Ok(Self::Along(corners))
    }

    fn at(&self, share: f64, limb: &LiveLimb) -> Option<SurfacePoint> {
        let corners = match self {
            Self::At(point) => return Some(*point),
            Self::Along(corners) => corners,
        };
        let (end, whole_m) = corners[corners.len() - 1];
        let along_m = share * whole_m;
        let next = corners.partition_point(|(_, length_m)| *length_m <= along_m);
        let position = match corners.get(next) {
            Some((to, to_m)) if next > 0 => {
                let (from, from_m) = corners[next - 1];
                from + (to - from) * ((along_m - from_m) / (to_m - from_m))
            }
            _ => end,
        };
        limb.nearest(&position).map(|(point, _)| point)
    }

    fn end(&self, limb: &LiveLimb) -> SurfacePoint {
        self.at(1.0, limb).unwrap_or(FIRST)
    }
}

fn on_skin(limb: &LiveLimb, position_m: &[f64; 3], path: &str) -> Result<SurfacePoint, RigError> {
    let found = limb.nearest(&Point3::from(*position_m));
    let off_m = found.map_or(f64::INFINITY, |(_, distance_m)| distance_m);
    let expected = "a place at most 5 mm off the skin";
    let text = format!("{position_m:?}, {:.1} mm off", off_m * 1e3);
    require(off_m <= MAX_OFF_SKIN_M, path, expected, text)?;
    Ok(found.map_or(FIRST, |(point, _)| point))
}
