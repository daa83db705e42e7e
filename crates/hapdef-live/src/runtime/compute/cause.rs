//! What moved readings that should stand still: contacts, contacts that let go, or drift.

use hapdef_inverse::chi_square_tail;

use super::conditioning::Conditioning;
use crate::estimator::Explained;

/// An explanation less probable than this is none.
pub(super) const LEAST_P: f64 = 1e-2;

/// A contact with less force explains nothing here, N: it is as strong as what contacts are let go at.
const LEAST_FORCE_N: f64 = 0.5;

/// While something touches, drift in any direction is reckoned with for so long at most, s, as the zero's line remembers:
/// without a limit two presses held for a minute would be drift of a minute, and be tared.
pub(super) const MOST_DRIFT_S: f64 = 10.0;

/// Contacts explain a steady zero, which drift does not, if they are no misfit of one frame in a million: of three presses
/// at a time 2 in 100 are found less well than by [`LEAST_P`].
const MISFIT_P: f64 = 1e-6;

/// How much more evidence a release needs than a press, in −2 ln: one touch in a thousand is taken to be what was tared
/// unseen. Without it a limb with few gauges and a map that is not calibrated takes presses for releases (8 gauges: up to 4.3 in
/// favour of them; true releases on ten calibrated gauges: 99 and more).
const RELEASE_MARGIN: f64 = 13.8;

/// Whether contacts explain the readings.
pub(super) fn is_press(found: &Explained) -> bool {
    found.p_value > MISFIT_P && is_strong(found)
}

fn is_strong(found: &Explained) -> bool {
    found.contacts.iter().any(|contact| contact.force_n > LEAST_FORCE_N)
}

/// Whether `found` explains the readings within their noise, and `other` does not with as few contacts.
pub(super) fn is_better(found: &Explained, other: &Explained) -> bool {
    let is_good = found.p_value > LEAST_P && !found.contacts.is_empty();
    is_good && (other.p_value <= LEAST_P || other.contacts.len() > found.contacts.len())
}

/// Whether something that was tared unseen let go: mirrored contacts explain the readings within their noise, and
/// pressing ones are that much less probable.
pub(super) fn is_release(released: &Explained, pressing: &Explained) -> bool {
    let is_explained = released.p_value > LEAST_P && is_strong(released);
    is_explained && pressing.cost - released.cost > RELEASE_MARGIN
}

/// Whether drift that had `time_s` for it moved the zero by `shift` `[n_gauges]`, µε, of which contacts need
/// `noise_ue` `[n_gauges]` to be explained, too.
pub(super) fn is_drift(
    conditioning: &Conditioning,
    shift: &[f64],
    noise_ue: &[f64],
    time_s: f64,
) -> bool {
    // lengths are those of the device
    let Ok(beyond) = conditioning.conditioner.beyond_drift(shift, time_s) else {
        return false;
    };
    let each = beyond.iter().zip(noise_ue).zip(&conditioning.out.live);
    let (mut chi2, mut n_live) = (0.0, 0);
    for ((beyond, noise), _) in each.filter(|(_, is_live)| **is_live) {
        chi2 += (beyond / noise).powi(2);
        n_live += 1;
    }
    chi_square_tail(chi2, n_live) > LEAST_P
}

#[cfg(test)]
mod tests {
    use hapdef_contact::Contact;
    use nalgebra::Point3;

    use super::*;

    fn explained(p_value: f64, cost: f64) -> Explained {
        let contacts = vec![Contact::new(Point3::origin(), 10.0)];
        Explained { contacts, p_value, cost }
    }

    /// Costs as found on an uncalibrated forearm with 8 gauges that was pressed, and on the bundled one at a release.
    #[test]
    fn a_release_needs_more_evidence_than_a_press() {
        assert!(!is_release(&explained(2.1e-2, 100.0), &explained(1.4e-3, 104.0)));
        assert!(is_release(&explained(0.99, 100.0), &explained(2.5e-11, 199.2)));
        let weak = Explained { contacts: Vec::new(), ..explained(0.99, 100.0) };
        assert!(!is_release(&weak, &explained(0.0, 1e4)));
        assert!(!is_release(&explained(1e-3, 100.0), &explained(0.0, 1e4)), "not explained");
    }
}
