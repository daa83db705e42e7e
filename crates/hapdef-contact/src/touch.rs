//! The result of one frame.

use nalgebra::Point3;

use crate::MAX_CONTACTS;
use crate::contact::Contact;
use crate::state::{Verdict, WhyNot};

/// Other explanations of a frame for which room is made ahead.
const N_ALTERNATIVES: usize = 16;

/// The result of one frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Touch {
    /// The contacts: the strongest first, of an estimator that follows them the oldest first.
    pub contacts: Vec<Contact>,
    /// Names of the contacts that were let go in this frame, where the estimator gives names.
    pub released: Vec<u64>,
    /// How good the explanation is, where the estimator can tell.
    pub quality: Option<Quality>,
    /// Other explanations of the frame, the best first, where they were asked for and the estimator
    /// has them.
    pub alternatives: Vec<Alternative>,
}

/// How good an explanation of a frame is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// What the frame decides.
    pub verdict: Verdict,
    /// χ² of the residual.
    pub chi2: f64,
    /// Its degrees of freedom.
    pub n_dof: usize,
    /// The probability of a χ² as large.
    pub p_value: f64,
    /// Other explanations that are nearly as good.
    pub n_alternatives: usize,
}

/// Another explanation of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alternative {
    /// −2 ln evidence less the best's.
    pub delta_cost: f64,
    n_contacts: usize,
    positions_m: [Point3<f64>; MAX_CONTACTS],
    forces_n: [f64; MAX_CONTACTS],
}

impl Touch {
    /// Nothing touches; with room for what a frame may hold, so that filling it allocates nothing.
    #[must_use]
    pub fn with_room() -> Self {
        Self {
            contacts: Vec::with_capacity(MAX_CONTACTS),
            released: Vec::with_capacity(MAX_CONTACTS),
            quality: None,
            alternatives: Vec::with_capacity(N_ALTERNATIVES),
        }
    }

    /// Nothing touches, and nothing is known of how sure that is.
    pub fn clear(&mut self) {
        self.contacts.clear();
        self.released.clear();
        self.alternatives.clear();
        self.quality = None;
    }

    /// Takes over what `from` says; allocates only to grow.
    pub fn copy_from(&mut self, from: &Self) {
        self.contacts.clone_from(&from.contacts);
        self.released.clone_from(&from.released);
        self.alternatives.clone_from(&from.alternatives);
        self.quality = from.quality;
    }
}

impl Quality {
    /// Whether the frame decides for the contacts reported, or for none.
    #[must_use]
    pub fn is_identified(&self) -> bool {
        self.why_not().is_none()
    }

    /// Why not, if it doesn't.
    #[must_use]
    pub fn why_not(&self) -> Option<WhyNot> {
        match self.verdict {
            Verdict::NotIdentifiable(why) => Some(why),
            Verdict::Untouched | Verdict::Identified => None,
        }
    }
}

impl Alternative {
    /// An explanation by contacts, (m, N) each; those beyond [`MAX_CONTACTS`] are left out.
    #[must_use]
    pub fn new(delta_cost: f64, contacts: impl IntoIterator<Item = (Point3<f64>, f64)>) -> Self {
        let mut alternative = Self {
            delta_cost,
            n_contacts: 0,
            positions_m: [Point3::origin(); MAX_CONTACTS],
            forces_n: [0.0; MAX_CONTACTS],
        };
        for (i, (position_m, force_n)) in contacts.into_iter().take(MAX_CONTACTS).enumerate() {
            alternative.positions_m[i] = position_m;
            alternative.forces_n[i] = force_n;
            alternative.n_contacts = i + 1;
        }
        alternative
    }

    /// Its contacts: position, m, and normal force, N.
    pub fn contacts(&self) -> impl ExactSizeIterator<Item = (Point3<f64>, f64)> + Clone + '_ {
        let places = self.positions_m[..self.n_contacts].iter().copied();
        places.zip(self.forces_n.iter().copied())
    }
}
