//! What of the displacement a map shows, and the true maps.

use hapdef::{ComplianceTable, DrawnContact, SuperpositionScratch};
use nalgebra::Vector3;
use rayon::prelude::*;
use serde::Serialize;

/// What of the displacement a map shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Target {
    /// Its magnitude, the paper's choice. Two contacts' magnitudes don't add up.
    Magnitude,
    /// Its part along the direction of a press at the node. Adds up.
    Normal,
    /// All of it, three numbers a node. Adds up.
    Vector,
}

/// True maps of any contacts.
pub(super) struct TrueMaps<'a> {
    pub(super) table: &'a ComplianceTable,
    /// Direction of a press at each surface node.
    pub(super) directions: &'a [Vector3<f64>],
}

impl Target {
    pub(super) const ALL: [Self; 3] = [Self::Magnitude, Self::Normal, Self::Vector];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Magnitude => "magnitude",
            Self::Normal => "displacement along the press",
            Self::Vector => "displacement vector",
        }
    }

    /// Numbers of a map of `n_surface` nodes.
    pub(super) fn width(self, n_surface: usize) -> usize {
        match self {
            Self::Vector => 3 * n_surface,
            _ => n_surface,
        }
    }

    /// What k-Max looks at, `[n, n_surface]`, of maps `[n, width]`, µm.
    pub(super) fn field(self, maps: Vec<f32>) -> Vec<f32> {
        match self {
            Self::Vector => {
                let vectors = maps.as_chunks::<3>().0.iter();
                vectors.map(|[x, y, z]| (x * x + y * y + z * z).sqrt()).collect()
            }
            _ => maps,
        }
    }
}

impl TrueMaps<'_> {
    /// Maps `[n, width]`, µm, of presses.
    pub(super) fn of(&self, target: Target, presses: &[Vec<DrawnContact>]) -> Vec<f32> {
        let n_surface = self.directions.len();
        self.each(target.width(n_surface), presses, |scratch, contacts, map| {
            let vectors = &self.table.vectors(contacts, scratch)[..n_surface];
            if target == Target::Vector {
                return write_um(vectors.as_flattened().iter().copied(), map);
            }
            let vectors = vectors.iter().map(|u| Vector3::from(*u));
            match target {
                Target::Normal => {
                    write_um(vectors.zip(self.directions).map(|(u, d)| u.dot(d)), map);
                }
                _ => write_um(vectors.map(|u| u.norm()), map),
            }
        })
    }

    /// Virtual gauges `[n, n_virtual]`, µm, of presses.
    pub(super) fn virtual_gauges(&self, presses: &[Vec<DrawnContact>]) -> Vec<f32> {
        self.each(self.table.n_virtual(), presses, |scratch, contacts, out| {
            let mut map = vec![0.0; self.table.n_surface()];
            self.table.superpose(contacts, scratch, &mut map, out);
        })
    }

    /// Displacement vectors of the virtual gauges `[n, n_virtual, 3]`, µm, of presses. They add up.
    pub(super) fn virtual_vectors(&self, presses: &[Vec<DrawnContact>]) -> Vec<f32> {
        self.each(3 * self.table.n_virtual(), presses, |scratch, contacts, out| {
            let vectors = &self.table.vectors(contacts, scratch)[self.table.n_surface()..];
            write_um(vectors.as_flattened().iter().copied(), out);
        })
    }

    /// What `write` makes of each press, `[n, width]`.
    fn each(
        &self,
        width: usize,
        presses: &[Vec<DrawnContact>],
        write: impl Fn(&mut SuperpositionScratch, &[DrawnContact], &mut [f32]) + Sync,
    ) -> Vec<f32> {
        let mut out = vec![0.0; presses.len() * width];
        out.par_chunks_exact_mut(width).zip(presses).for_each_init(
            || self.table.scratch(),
            |scratch, (out, contacts)| write(scratch, contacts, out),
        );
        out
    }
}

fn write_um(metres: impl Iterator<Item = f64>, out: &mut [f32]) {
    for (out, metres) in out.iter_mut().zip(metres) {
        *out = (metres * 1e6) as f32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_and_vectors_add_up_and_magnitudes_do_not() {
        let rows = [[3.0, 0.0, 4.0, 0.0, 1.0, 0.0], [-3.0, 0.0, 1.0, 2.0, 0.0, 0.0]];
        let metres: Vec<f64> = rows.concat().iter().map(|v| v * 1e-6).collect();
        let table = ComplianceTable::new(2, 2, &metres);
        let directions = [Vector3::z(), Vector3::x()];
        let maps = TrueMaps { table: &table, directions: &directions };
        let press = |node| DrawnContact { node, force_n: 1.0 };
        let presses = [vec![press(0)], vec![press(1)], vec![press(0), press(1)]];
        let adds_up = |target: Target| {
            let all = maps.of(target, &presses);
            let (a, rest) = all.split_at(target.width(2));
            let (b, both) = rest.split_at(target.width(2));
            let sums = a.iter().zip(b).map(|(a, b)| a + b);
            sums.zip(both).all(|(sum, both)| (sum - both).abs() < 1e-6)
        };
        assert!(adds_up(Target::Vector) && adds_up(Target::Normal));
        assert!(!adds_up(Target::Magnitude));
        let vectors = Target::Vector.field(maps.of(Target::Vector, &presses));
        let magnitudes = maps.of(Target::Magnitude, &presses);
        assert!(vectors.iter().zip(&magnitudes).all(|(a, b)| (a - b).abs() < 1e-6));
        assert_eq!(maps.of(Target::Normal, &presses)[..2], [4.0, 0.0]);
    }

    #[test]
    fn vectors_of_virtual_gauges_add_up() {
        let metres = [1.0, 2.0, 3.0, -3.0, 0.0, 4.0].map(|um| um * 1e-6);
        let table = ComplianceTable::new(1, 2, &metres);
        let maps = TrueMaps { table: &table, directions: &[Vector3::z()] };
        let press = |force_n| DrawnContact { node: 0, force_n };
        let presses = [vec![press(1.0)], vec![press(1.0), press(2.0)]];
        let found = maps.virtual_vectors(&presses);
        for (found, expected) in found.iter().zip([-3.0, 0.0, 4.0, -9.0, 0.0, 12.0]) {
            assert!((found - expected).abs() < 1e-5, "{found} {expected}");
        }
        assert_eq!(found.len(), 6);
    }
}
