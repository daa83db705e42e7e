//! Aggregates of strongly coupled block rows, and the tentative prolongation on them.
//!
//! Vaněk, Mandel and Brezina, "Algebraic multigrid by smoothed aggregation for second and fourth
//! order elliptic problems", Computing 56 (1996), section 5: Algorithm 5.1 for the aggregates,
//! Algorithm 4.1 for the local orthonormalisation of the near-null space.

use super::bsr::{Block, Bsr};

/// The near-null space at one block row of size B: six modes.
pub(super) type Modes<const B: usize> = [[f64; 6]; B];

/// Which aggregate each block row belongs to.
pub(super) struct Aggregates {
    pub(super) of_row: Vec<u32>,
    pub(super) n: usize,
}

const NONE: u32 = u32::MAX;

/// A mode whose part orthogonal to the earlier ones is below this share of it is not independent.
const INDEPENDENT_ABOVE: f64 = 1e-8;

impl Aggregates {
    /// Row j is strongly coupled to row i if ‖Aᵢⱼ‖ > `threshold` √(‖Aᵢᵢ‖ ‖Aⱼⱼ‖), Frobenius norms.
    pub(super) fn build<const B: usize>(a: &Bsr<B, B>, threshold: f64) -> Self {
        let strong = Strong::build(a, threshold);
        let mut aggregates = Self { of_row: vec![NONE; a.n_rows()], n: 0 };
        aggregates.found(&strong);
        aggregates.join(&strong);
        aggregates.collect_rest(&strong);
        aggregates
    }

    /// A row whose strong neighbourhood is wholly free founds an aggregate of it.
    fn found(&mut self, strong: &Strong) {
        for row in 0..self.of_row.len() {
            let free = |&other: &u32| self.of_row[other as usize] == NONE;
            let neighbours = strong.of(row);
            if self.of_row[row] == NONE
                && !neighbours.is_empty()
                && neighbours.iter().map(|(other, _)| other).all(free)
            {
                self.start(row, neighbours);
            }
        }
    }

    /// The other rows join the founded aggregate that they are most strongly coupled to.
    fn join(&mut self, strong: &Strong) {
        let founded = self.of_row.clone();
        for row in (0..founded.len()).filter(|&row| founded[row] == NONE) {
            let mut best = (0.0, NONE);
            for &(other, strength) in strong.of(row) {
                if founded[other as usize] != NONE && strength > best.0 {
                    best = (strength, founded[other as usize]);
                }
            }
            self.of_row[row] = best.1;
        }
    }

    /// What is left: each row with its free strong neighbours.
    fn collect_rest(&mut self, strong: &Strong) {
        for row in 0..self.of_row.len() {
            if self.of_row[row] == NONE {
                self.start(row, strong.of(row));
            }
        }
    }

    fn start(&mut self, row: usize, neighbours: &[(u32, f64)]) {
        let aggregate = self.n as u32;
        self.n += 1;
        self.of_row[row] = aggregate;
        for &(other, _) in neighbours {
            if self.of_row[other as usize] == NONE {
                self.of_row[other as usize] = aggregate;
            }
        }
    }

    /// The tentative prolongation P̂ with P̂ᵀP̂ = I, and the modes `coarse` with P̂ `coarse` = `modes`.
    ///
    /// Where an aggregate's modes depend on each other (a single solid node has no rotation), the
    /// superfluous columns of P̂ are zero.
    pub(super) fn tentative<const B: usize>(
        &self,
        modes: &[Modes<B>],
    ) -> (Bsr<B, 6>, Vec<Modes<6>>) {
        let mut members: Vec<Vec<u32>> = vec![Vec::new(); self.n];
        for (row, &aggregate) in self.of_row.iter().enumerate() {
            members[aggregate as usize].push(row as u32);
        }
        let mut blocks: Vec<Block<B, 6>> = modes.to_vec();
        let coarse = members.iter().map(|rows| orthonormalise(rows, &mut blocks)).collect();
        let p = Bsr {
            row_ptr: (0..=modes.len()).collect(),
            columns: self.of_row.clone(),
            blocks,
            n_cols: self.n,
        };
        (p, coarse)
    }
}

/// Strong neighbours of each row with their strengths; itself left out.
struct Strong {
    row_ptr: Vec<usize>,
    entries: Vec<(u32, f64)>,
}

impl Strong {
    fn build<const B: usize>(a: &Bsr<B, B>, threshold: f64) -> Self {
        let diagonal: Vec<f64> = (0..a.n_rows())
            .map(|row| {
                let own = a.row(row).find(|(column, _)| *column == row);
                own.map_or(0.0, |(_, block)| frobenius(block))
            })
            .collect();
        let mut strong = Self { row_ptr: vec![0], entries: Vec::new() };
        for row in 0..a.n_rows() {
            for (column, block) in a.row(row).filter(|(column, _)| *column != row) {
                let strength = frobenius(block) / (diagonal[row] * diagonal[column]).sqrt();
                if strength > threshold {
                    strong.entries.push((column as u32, strength));
                }
            }
            strong.row_ptr.push(strong.entries.len());
        }
        strong
    }

    fn of(&self, row: usize) -> &[(u32, f64)] {
        &self.entries[self.row_ptr[row]..self.row_ptr[row + 1]]
    }
}

fn frobenius<const B: usize>(block: &Block<B, B>) -> f64 {
    block.as_flattened().iter().map(|v| v * v).sum::<f64>().sqrt()
}

/// Gram–Schmidt, twice, of the six columns on `rows`; returns the triangular factor.
fn orthonormalise<const B: usize>(rows: &[u32], blocks: &mut [Block<B, 6>]) -> Modes<6> {
    let mut factor = [[0.0; 6]; 6];
    for c in 0..6 {
        let whole = dot(rows, blocks, c, c).sqrt();
        for _ in 0..2 {
            for earlier in 0..c {
                let share = dot(rows, blocks, earlier, c);
                factor[earlier][c] += share;
                for &row in rows {
                    for values in &mut blocks[row as usize] {
                        values[c] -= share * values[earlier];
                    }
                }
            }
        }
        let left = dot(rows, blocks, c, c).sqrt();
        let keep = left > INDEPENDENT_ABOVE * whole;
        factor[c][c] = if keep { left } else { 0.0 };
        for &row in rows {
            for values in &mut blocks[row as usize] {
                values[c] = if keep { values[c] / left } else { 0.0 };
            }
        }
    }
    factor
}

fn dot<const B: usize>(rows: &[u32], blocks: &[Block<B, 6>], a: usize, b: usize) -> f64 {
    let values = rows.iter().flat_map(|&row| &blocks[row as usize]);
    values.map(|v| v[a] * v[b]).sum()
}
