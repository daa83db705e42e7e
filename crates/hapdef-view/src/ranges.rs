//! Lowest and highest values of the frames that come between two pictures, so that no peak is lost.

use hapdef_contact::Contact;

/// Ranges of readings and forces over some frames.
#[derive(Clone, Debug, Default)]
pub struct Ranges {
    /// Of each gauge `[n_gauges]`, µε; empty before the first frame.
    pub readings_ue: Vec<[f64; 2]>,
    /// Number of a contact and range of its force, N.
    forces_n: Vec<(u32, [f64; 2])>,
}

impl Ranges {
    /// Takes a frame's tared readings `[n_gauges]`, µε, and contacts.
    pub fn take(&mut self, tared_ue: &[f64], contacts: &[Contact]) {
        if self.readings_ue.len() != tared_ue.len() {
            self.readings_ue.clear();
            self.readings_ue.resize(tared_ue.len(), [f64::NAN; 2]);
        }
        for (range, &reading) in self.readings_ue.iter_mut().zip(tared_ue) {
            widen(range, reading);
        }
        for (place, contact) in contacts.iter().enumerate() {
            let number = contact.number(place);
            match self.forces_n.iter_mut().find(|(known, _)| *known == number) {
                Some((_, range)) => widen(range, contact.force_n),
                None => self.forces_n.push((number, [contact.force_n; 2])),
            }
        }
    }

    /// Range of a contact's force, N; `None` for one that was not there.
    #[must_use]
    pub fn force_n(&self, number: u32) -> Option<[f64; 2]> {
        self.forces_n.iter().find(|(known, _)| *known == number).map(|(_, range)| *range)
    }
}

/// What is not a number widens nothing.
fn widen(range: &mut [f64; 2], value: f64) {
    *range = [range[0].min(value), range[1].max(value)];
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;

    #[test]
    fn a_peak_between_two_pictures_is_kept() {
        let mut ranges = Ranges::default();
        for (reading, force_n) in [(1.0, 2.0), (f64::NAN, 7.0), (-4.0, 3.0)] {
            let contact = Contact { id: Some(9), ..Contact::new(Point3::origin(), force_n) };
            ranges.take(&[reading, f64::NAN], &[contact]);
        }
        assert_eq!(ranges.readings_ue[0], [-4.0, 1.0]);
        assert!(ranges.readings_ue[1][0].is_nan());
        assert_eq!(ranges.force_n(9), Some([2.0, 7.0]));
        assert_eq!(ranges.force_n(8), None);
    }
}
