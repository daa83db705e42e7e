//! Samples of F_R that are drawn and superposed when they are asked for: as many as a training
//! wants, and nothing on disk.

use hapdef_contact::DrawnContact;
use hapdef_nets::train::{BatchSource, SourceError};
use nalgebra::Point3;
use rayon::prelude::*;

use crate::compliance::ComplianceTable;
use crate::sampling::draw_numbered;
use crate::scene::ContactSpec;

/// Most contacts of a sample.
const MAX_CONTACTS: usize = 16;

/// Rows that one thread computes between two looks for more work.
const GRAIN: usize = 8;

/// Samples without end: virtual gauges → map, µm. Sample n has 1 + n mod `n_sets` contacts, and is
/// what the dataset stage would write for the same contacts. It depends on the seed and its number
/// alone.
pub struct DrawnSamples<'a> {
    table: &'a ComplianceTable,
    points: &'a [Point3<f64>],
    contact: &'a ContactSpec,
    n_sets: usize,
    seed: u64,
    n_pass: usize,
}

impl<'a> DrawnSamples<'a> {
    /// Samples of one up to `n_sets` contacts (16 at most), of which `n_pass` count as one pass.
    /// `points` are the surface nodes that the rows of `table` belong to.
    #[must_use]
    pub fn new(
        table: &'a ComplianceTable,
        points: &'a [Point3<f64>],
        contact: &'a ContactSpec,
        n_sets: usize,
        seed: u64,
        n_pass: usize,
    ) -> Self {
        Self { table, points, contact, n_sets: n_sets.clamp(1, MAX_CONTACTS), seed, n_pass }
    }

    /// Contacts of sample `number`, written to the front of `sample`; returns how many they are.
    fn contacts(
        &self,
        number: usize,
        sample: &mut [DrawnContact; MAX_CONTACTS],
    ) -> Result<usize, SourceError> {
        let n = 1 + number % self.n_sets;
        let sample = &mut sample[..n];
        draw_numbered(self.points, self.contact, self.seed, number as u64, sample)?;
        Ok(n)
    }
}

impl BatchSource for DrawnSamples<'_> {
    fn n_samples(&self) -> usize {
        self.n_pass
    }

    fn is_endless(&self) -> bool {
        true
    }

    fn n_inputs(&self) -> usize {
        self.table.n_virtual()
    }

    fn n_outputs(&self) -> usize {
        self.table.n_surface()
    }

    fn fill(&mut self, rows: &[usize], x: &mut [f32], y: &mut [f32]) -> Result<(), SourceError> {
        let source = &*self;
        let targets = x.par_chunks_exact_mut(self.n_inputs());
        rows.par_iter()
            .zip(targets.zip(y.par_chunks_exact_mut(self.n_outputs())))
            .with_min_len(GRAIN)
            .try_for_each_init(
                || (self.table.scratch(), [DrawnContact::NONE; MAX_CONTACTS]),
                |(scratch, sample), (number, (x, y))| {
                    let n = source.contacts(*number, sample)?;
                    source.table.superpose(&sample[..n], scratch, y, x);
                    Ok(())
                },
            )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{ContactRegion, LoadDirection};

    fn contact() -> ContactSpec {
        ContactSpec {
            region: ContactRegion::OuterSkin {},
            tip_radius_m: 0.002,
            force_range_n: [0.0, 34.0],
            direction: LoadDirection::Normal,
            min_spacing_m: 2e-3,
            max_contacts: 4,
        }
    }

    /// 40 nodes on a line and 7 virtual gauges.
    fn limb() -> (Vec<Point3<f64>>, ComplianceTable) {
        let points = (0..40).map(|i| Point3::new(f64::from(i) * 1e-3, 0.0, 0.0));
        let wave = |i: usize| 1e-6 * (1.3 * (i * i % 9973) as f64).sin();
        let values: Vec<f64> = (0..40 * 47 * 3).map(wave).collect();
        (points.collect(), ComplianceTable::new(40, 47, &values))
    }

    #[test]
    fn a_sample_is_what_the_dataset_stage_writes_for_its_contacts() {
        let ((points, table), contact) = (limb(), contact());
        let mut source = DrawnSamples::new(&table, &points, &contact, 3, 5, 10);
        let rows = [0, 1, 2, 77, 1 << 40];
        let (mut x, mut y) = (vec![0.0; 5 * 7], vec![0.0; 5 * 40]);
        source.fill(&rows, &mut x, &mut y).unwrap();
        for (i, row) in rows.into_iter().enumerate() {
            let mut sample = [DrawnContact::NONE; MAX_CONTACTS];
            let n = source.contacts(row, &mut sample).unwrap();
            assert_eq!(n, 1 + row % 3);
            let (mut map, mut gauges) = (vec![0.0; 40], vec![0.0; 7]);
            table.superpose(&sample[..n], &mut table.scratch(), &mut map, &mut gauges);
            assert_eq!(y[i * 40..][..40], map);
            assert_eq!(x[i * 7..][..7], gauges);
        }
    }

    #[test]
    fn a_batch_depends_on_its_numbers_alone() {
        let ((points, table), contact) = (limb(), contact());
        let filled = |threads: usize, rows: &[usize]| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let mut source = DrawnSamples::new(&table, &points, &contact, 4, 5, 10);
            let (mut x, mut y) = (vec![0.0; rows.len() * 7], vec![0.0; rows.len() * 40]);
            let fill = || source.fill(rows, &mut x, &mut y).map_err(|e| e.to_string());
            pool.build().unwrap().install(fill).unwrap();
            (x, y)
        };
        let all: Vec<usize> = (0..100).collect();
        let (x, y) = filled(1, &all);
        assert_eq!(filled(2, &all), (x.clone(), y.clone()));
        let (x_late, y_late) = filled(2, &all[50..]);
        assert_eq!((&x[50 * 7..], &y[50 * 40..]), (&x_late[..], &y_late[..]));
    }

    #[test]
    fn a_crowded_skin_is_told() {
        let ((points, table), mut contact) = (limb(), contact());
        contact.min_spacing_m = 1.0;
        let mut source = DrawnSamples::new(&table, &points, &contact, 2, 5, 10);
        let error = source.fill(&[1], &mut [0.0; 7], &mut [0.0; 40]).unwrap_err();
        assert!(error.to_string().contains('2'), "{error}");
    }
}
