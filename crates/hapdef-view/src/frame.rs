//! What is shown at one time.

use hapdef_contact::{Contact, GaugeHealth, TouchPhase};
use nalgebra::Vector3;

use crate::error::ViewError;

/// What is shown at one time. Reuse one: [`crate::ViewHandle::push`] copies it.
#[derive(Clone, Debug, Default)]
pub struct ViewFrame {
    /// Time of the readings, s, from any origin.
    pub t_s: f64,
    /// Tared readings `[n_gauges]`, µε; not finite: none.
    pub readings_ue: Vec<f64>,
    /// Lowest and highest reading of each gauge since the frame before `[n_gauges]`, µε; empty: the readings.
    pub ranges_ue: Vec<[f64; 2]>,
    /// State of the gauges `[n_gauges]`; empty: all well.
    pub gauge_health: Vec<GaugeHealth>,
    /// Whether something touches, and whether that can be known.
    pub phase: TouchPhase,
    /// The contacts are those of an earlier time.
    pub is_stale: bool,
    /// Probability of readings that are explained as badly; not finite: not known.
    pub p_value: f64,
    /// The contacts.
    pub contacts: Vec<ContactMark>,
    /// Other explanations of the same readings, with their probabilities; each has its contacts.
    pub alternatives: Vec<(f64, Vec<ContactMark>)>,
    /// What a simulated limb is truly pressed by; empty: nothing, or not known.
    pub truths: Vec<ContactMark>,
    /// Displacement of the surface.
    pub displacement: Displacement,
    /// Rate, losses, latency, recording.
    pub health: Health,
    /// Where in a recording this frame is, when one is replayed.
    pub replay: Option<ReplayPosition>,
}

/// One contact as it is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactMark {
    /// The contact; where its direction is not known it presses against the normal.
    pub contact: Contact,
    /// Outward unit normal of the drawn surface there.
    pub normal: Vector3<f64>,
    /// Least and largest force since the frame before, N; `None`: the force.
    pub force_range_n: Option<[f64; 2]>,
}

/// Displacement of the first k surface nodes, m; of the others it is not known.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Displacement {
    /// Not known.
    #[default]
    None,
    /// Its length `[k]`; drawn as if inward.
    Magnitude(Vec<f32>),
    /// The vectors `[k][3]`.
    Vector(Vec<[f32; 3]>),
}

/// Rate, losses, latency, recording. Not finite: not known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Health {
    /// Frames per second.
    pub rate_hz: f64,
    /// Frames lost on the way since the start.
    pub n_lost: u64,
    /// Frames that came and were dropped since the start, as computing was too slow for them.
    pub n_dropped: u64,
    /// Packets refused for their CRC since the start.
    pub n_crc_errors: u64,
    /// Median time from sample to contact, µs.
    pub latency_p50_us: f64,
    /// Its 99th percentile, µs.
    pub latency_p99_us: f64,
    /// Residual of the clock map, µs.
    pub clock_residual_us: f64,
    /// The recording.
    pub recording: Recording,
}

/// State of the recording.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Recording {
    /// None.
    #[default]
    Off,
    /// Going on for so many seconds.
    On {
        /// Seconds on file.
        recorded_s: f64,
    },
    /// It stopped with an error.
    Failed,
}

/// Where in a recording a frame is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReplayPosition {
    /// From its beginning, s.
    pub position_s: f64,
    /// Its length, s.
    pub duration_s: f64,
    /// Whether it stands still because somebody stopped it.
    pub is_paused: bool,
}

impl Default for Health {
    /// Nothing known, nothing lost.
    fn default() -> Self {
        Self {
            rate_hz: f64::NAN,
            n_lost: 0,
            n_dropped: 0,
            n_crc_errors: 0,
            latency_p50_us: f64::NAN,
            latency_p99_us: f64::NAN,
            clock_residual_us: f64::NAN,
            recording: Recording::Off,
        }
    }
}

impl ViewFrame {
    /// Whether it fits a picture of `n_nodes` and `n_gauges`.
    pub(crate) fn check(&self, n_nodes: usize, n_gauges: usize) -> Result<(), ViewError> {
        same("readings", n_gauges, self.readings_ue.len())?;
        if !self.ranges_ue.is_empty() {
            same("ranges of readings", n_gauges, self.ranges_ue.len())?;
        }
        if !self.gauge_health.is_empty() {
            same("states of gauges", n_gauges, self.gauge_health.len())?;
        }
        let n_displaced = match &self.displacement {
            Displacement::None => 0,
            Displacement::Magnitude(lengths) => lengths.len(),
            Displacement::Vector(vectors) => vectors.len(),
        };
        if n_displaced > n_nodes {
            same("displacements", n_nodes, n_displaced)?;
        }
        let alternatives = self.alternatives.iter().flat_map(|(_, contacts)| contacts);
        self.contacts
            .iter()
            .chain(alternatives)
            .chain(&self.truths)
            .enumerate()
            .try_for_each(|(index, contact)| contact.check(index))
    }
}

impl ContactMark {
    /// The force on the limb, N.
    pub(crate) fn force_vector_n(&self) -> Vector3<f64> {
        self.contact.direction.unwrap_or(-self.normal) * self.contact.force_n
    }

    fn check(&self, index: usize) -> Result<(), ViewError> {
        let position = self.contact.position_m.coords;
        let named =
            [("position", position), ("normal", self.normal), ("force", self.force_vector_n())];
        let fault = named.iter().find(|(_, vector)| !vector.iter().all(|c| c.is_finite()));
        match fault {
            None => Ok(()),
            Some(&(what, _)) => Err(ViewError::ContactNumber { index, what }),
        }
    }
}

fn same(what: &'static str, expected: usize, found: usize) -> Result<(), ViewError> {
    if expected == found {
        return Ok(());
    }
    Err(ViewError::FrameShape { what, expected, found })
}

#[cfg(test)]
mod tests {
    use hapdef_contact::{Contact, GaugeHealth};
    use nalgebra::{Point3, Vector3};

    use super::{ContactMark, Displacement, ViewFrame};

    fn mark(force_n: f64) -> ContactMark {
        let contact = Contact::new(Point3::origin(), force_n);
        ContactMark { contact, normal: Vector3::z(), force_range_n: None }
    }

    #[track_caller]
    fn refused(frame: &ViewFrame, why: &str) {
        let text = frame.check(4, 2).unwrap_err().to_string();
        assert!(text.contains(why), "{text}");
    }

    #[test]
    fn shapes_are_compared() {
        let good = ViewFrame { readings_ue: vec![f64::NAN, 1.0], ..ViewFrame::default() };
        assert!(good.check(4, 2).is_ok());
        refused(&ViewFrame::default(), "0 readings, the page was started with 2");
        refused(
            &ViewFrame { displacement: Displacement::Magnitude(vec![0.0; 5]), ..good.clone() },
            "5 displacements, the page was started with 4",
        );
        refused(
            &ViewFrame { gauge_health: vec![GaugeHealth::Dead], ..good.clone() },
            "1 states of gauges",
        );
        refused(
            &ViewFrame { ranges_ue: vec![[0.0; 2]], ..good.clone() },
            "1 ranges of readings, the page was started with 2",
        );
        refused(
            &ViewFrame { truths: vec![mark(f64::NAN)], ..good.clone() },
            "contact 0 of a frame has a force",
        );
        refused(
            &ViewFrame { alternatives: vec![(0.5, vec![mark(1.0), mark(f64::NAN)])], ..good },
            "contact 1 of a frame has a force",
        );
    }
}
