//! From what is found to what is drawn.

use hapdef_contact::{Alternative, Contact, Touch};
use nalgebra::{Point3, Vector3};

use crate::frame::{ContactMark, ViewFrame};
use crate::ranges::Ranges;

/// Other explanations that are shown, and how probable they must be.
const MOST_ALTERNATIVES: usize = 3;
const LEAST_PROBABILITY: f64 = 0.05;

impl ContactMark {
    /// A contact where the surface's outward normal is `normal`.
    #[must_use]
    pub fn new(contact: Contact, normal: Vector3<f64>) -> Self {
        Self { contact, normal, force_range_n: None }
    }
}

impl ViewFrame {
    /// Shows contacts and the other explanations that are worth it; `normal_at` is the surface's outward normal near a
    /// point.
    pub fn show_touch(&mut self, touch: &Touch, normal_at: impl Fn(&Point3<f64>) -> Vector3<f64>) {
        let mark = |contact: Contact| ContactMark::new(contact, normal_at(&contact.position_m));
        self.p_value = touch.quality.map_or(f64::NAN, |quality| quality.p_value);
        self.contacts.clear();
        self.contacts.extend(touch.contacts.iter().map(|contact| mark(*contact)));
        self.alternatives.clear();
        for (probability, other) in probable(&touch.alternatives) {
            let marks = other.contacts().map(|(at, force_n)| mark(Contact::new(at, force_n)));
            self.alternatives.push((probability, marks.collect()));
        }
    }

    /// Shows how far readings and forces went since the frame before.
    pub fn show_ranges(&mut self, ranges: &Ranges) {
        self.ranges_ue.clone_from(&ranges.readings_ue);
        for (place, mark) in self.contacts.iter_mut().enumerate() {
            mark.force_range_n = ranges.force_n(mark.contact.number(place));
        }
    }
}

/// The other explanations that are worth showing, with how probable they are beside the best one and
/// each other: exp(−Δ/2), Δ in −2 ln evidence.
fn probable(others: &[Alternative]) -> impl Iterator<Item = (f64, &Alternative)> {
    let weight = |other: &Alternative| (-0.5 * other.delta_cost).exp();
    let sum = 1.0 + others.iter().map(weight).sum::<f64>();
    let others = others.iter().map(move |other| (weight(other) / sum, other));
    let others = others.filter(|(probability, _)| *probability >= LEAST_PROBABILITY);
    others.take(MOST_ALTERNATIVES)
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::{Alternative, probable};

    fn other(delta_cost: f64) -> Alternative {
        Alternative::new(delta_cost, [(Point3::origin(), 1.0)])
    }

    #[test]
    fn explanations_are_shown_as_probable_as_their_evidence_says() {
        // as good as the best one; e times and 20 times less probable; and one of no account
        let others = [0.0, 2.0, 2.0 * 20.0_f64.ln(), 50.0].map(other);
        let shown: Vec<f64> = probable(&others).map(|(p, _)| p).collect();
        let sum = 2.0 + (-1.0_f64).exp() + 0.05;
        assert_eq!(shown.len(), 2, "{shown:?}");
        assert!((shown[0] - 1.0 / sum).abs() < 1e-9, "{shown:?}");
        assert!((shown[1] - (-1.0_f64).exp() / sum).abs() < 1e-9);
        assert_eq!(probable(&[0.0; 9].map(other)).count(), 3);
        assert_eq!(probable(&[]).count(), 0);
    }
}
