//! Drawing contacts: random places at a distance from each other, random forces.

use hapdef_contact::DrawnContact;
use nalgebra::Point3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::error::HapdefError;
use crate::scene::ContactSpec;

/// Tries for one sample before the spacing is called too large.
const MAX_TRIES: usize = 10_000;

/// First stream of the generator that numbered samples take; sets take the streams of their
/// contact counts.
const NUMBERED_STREAMS: u64 = 1 << 32;

/// Draws `n_samples` samples of `n_contacts` contacts each, at least the scene's spacing apart.
/// The stream depends on `seed` and on `n_contacts` only.
///
/// # Errors
/// [`HapdefError::TooCrowded`] when a sample finds no room on the skin.
pub fn draw_contacts(
    points: &[Point3<f64>],
    contact: &ContactSpec,
    n_contacts: usize,
    n_samples: usize,
    seed: u64,
) -> Result<Vec<Vec<DrawnContact>>, HapdefError> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(n_contacts as u64);
    (0..n_samples)
        .map(|_| {
            let mut sample = vec![DrawnContact::NONE; n_contacts];
            draw_one(points, contact, &mut sample, &mut rng)?;
            Ok(sample)
        })
        .collect()
}

/// Draws sample `number` of an endless sequence of samples of as many contacts as `sample` has.
/// The sample depends on `seed`, its number and its count only, so any can be drawn without the
/// ones before it; none is one that [`draw_contacts`] draws.
///
/// # Errors
/// [`HapdefError::TooCrowded`] when the sample finds no room on the skin.
pub fn draw_numbered(
    points: &[Point3<f64>],
    contact: &ContactSpec,
    seed: u64,
    number: u64,
    sample: &mut [DrawnContact],
) -> Result<(), HapdefError> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(NUMBERED_STREAMS + number);
    draw_one(points, contact, sample, &mut rng)
}

fn draw_one(
    points: &[Point3<f64>],
    contact: &ContactSpec,
    sample: &mut [DrawnContact],
    rng: &mut ChaCha8Rng,
) -> Result<(), HapdefError> {
    for _ in 0..MAX_TRIES {
        for contact in &mut *sample {
            contact.node = rng.random_range(0..points.len());
        }
        if !spaced(points, sample, contact.min_spacing_m) {
            continue;
        }
        let [low, high] = contact.force_range_n;
        for contact in sample {
            contact.force_n = rng.random_range(low..=high);
        }
        return Ok(());
    }
    let n_contacts = sample.len();
    Err(HapdefError::TooCrowded {
        n_contacts,
        n_nodes: points.len(),
        spacing_mm: contact.min_spacing_m * 1e3,
        tries: MAX_TRIES,
    })
}

fn spaced(points: &[Point3<f64>], sample: &[DrawnContact], spacing_m: f64) -> bool {
    (0..sample.len()).all(|i| {
        (0..i).all(|j| {
            let (a, b) = (sample[i].node, sample[j].node);
            a != b && (points[a] - points[b]).norm() >= spacing_m
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{ContactRegion, LoadDirection};

    fn contact(min_spacing_m: f64) -> ContactSpec {
        ContactSpec {
            region: ContactRegion::OuterSkin {},
            tip_radius_m: 0.002,
            force_range_n: [0.0, 34.0],
            direction: LoadDirection::Normal,
            min_spacing_m,
            max_contacts: 4,
        }
    }

    fn line() -> Vec<Point3<f64>> {
        (0..50).map(|i| Point3::new(f64::from(i) * 1e-3, 0.0, 0.0)).collect()
    }

    #[test]
    fn contacts_keep_their_distance_and_range() {
        let points = line();
        for sample in draw_contacts(&points, &contact(0.01), 3, 500, 7).unwrap() {
            for (i, a) in sample.iter().enumerate() {
                assert!((0.0..=34.0).contains(&a.force_n));
                for b in &sample[..i] {
                    assert!((points[a.node] - points[b.node]).norm() >= 0.01);
                }
            }
        }
    }

    #[test]
    fn the_seed_decides_and_sets_differ() {
        let points = line();
        let draw = |n, seed| draw_contacts(&points, &contact(0.0), n, 20, seed).unwrap();
        assert_eq!(draw(2, 1), draw(2, 1));
        assert_ne!(draw(2, 1), draw(2, 2));
        assert_ne!(draw(1, 1)[0][0], draw(2, 1)[0][0]);
    }

    #[test]
    fn a_number_decides_its_sample_and_follows_the_rules() {
        let (points, contact) = (line(), contact(0.01));
        let draw = |seed, number| {
            let mut sample = [DrawnContact::NONE; 3];
            draw_numbered(&points, &contact, seed, number, &mut sample).unwrap();
            sample
        };
        let sets: Vec<_> = (0..500).map(|number| draw(7, number)).collect();
        for (number, sample) in sets.iter().enumerate() {
            for (i, a) in sample.iter().enumerate() {
                assert!((0.0..=34.0).contains(&a.force_n));
                let room = |b: &DrawnContact| (points[a.node] - points[b.node]).norm() >= 0.01;
                assert!(sample[..i].iter().all(room));
            }
            assert!(!sets[..number].contains(sample));
        }
        assert_eq!(draw(7, 123), sets[123]);
        assert_ne!(draw(8, 123), sets[123]);
        let fixed = draw_contacts(&points, &contact, 3, 500, 7).unwrap();
        assert!(fixed.iter().all(|sample| !sets.iter().any(|s| s[..] == sample[..])));
    }

    #[test]
    fn a_crowded_skin_is_refused() {
        let error = draw_contacts(&line(), &contact(0.03), 4, 1, 1).unwrap_err();
        assert!(matches!(error, HapdefError::TooCrowded { n_contacts: 4, .. }), "{error}");
    }
}
