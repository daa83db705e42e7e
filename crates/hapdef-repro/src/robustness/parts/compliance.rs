//! The table of displacements per newton: on disk, and superposed.

use std::path::Path;

use hapdef::{ComplianceTable, DrawnContact};

use super::{in_folder, keep_share};
use crate::error::ReproError;
use crate::robustness::table::Trials;

/// Surface nodes; there is a virtual gauge besides.
const N: usize = 5;

/// A usual displacement per newton, m/N.
const USUAL_M_PER_N: f64 = 1e-5;

/// The file that rows write.
const FILE: &str = "compliance.safetensors";

pub(super) fn add(rows: &mut Trials<u64>) {
    for size_m_per_n in [1e-30, 1e-12, 1e3] {
        let holds = ("the largest displacement of 10 N read back, relative error", 1e-6);
        rows.accurate(format!("{size_m_per_n:e} m/N"), holds, move |_| {
            let back = in_folder(FILE, |path| {
                table(size_m_per_n).write(path)?;
                Ok(ComplianceTable::read(path, N)?)
            })?;
            Ok(worst_error(&back, size_m_per_n, &[(0, 10.0)]))
        });
    }
    for force_n in [1e-6, 1e6] {
        let holds = ("their displacement, relative error", 1e-6);
        rows.accurate(format!("two forces of {force_n:e} N"), holds, move |_| {
            let table = table(USUAL_M_PER_N);
            Ok(worst_error(&table, USUAL_M_PER_N, &[(0, force_n), (3, force_n)]))
        });
    }
    let holds = ("what the smaller adds to the larger, relative error", 1e-6);
    rows.accurate("1e6 N and 1e-3 N at one node", holds, |_| {
        let table = table(USUAL_M_PER_N);
        let [both, large, small] = [&[(2, 1e6), (2, 1e-3)][..], &[(2, 1e6)], &[(2, 1e-3)]]
            .map(|contacts| largest_m(&table, contacts));
        Ok(((both - large) / small - 1.0).abs())
    });
    rows.all_refused([
        ("an entry is NaN", "NaN", || n_read(|path| spoilt(path, |rows| rows[7] = f64::NAN))),
        ("an entry is beyond 32 bits", "inf", || {
            n_read(|path| spoilt(path, |rows| rows[7] = 1e39))
        }),
        ("the file's last byte is missing", "", || n_read(|path| cut(path, 0.999))),
        ("half the file is missing", "", || n_read(|path| cut(path, 0.5))),
        ("the table of another limb", "expected 6 loads", || {
            n_read(|path| {
                table(USUAL_M_PER_N).write(path)?;
                Ok(ComplianceTable::read(path, N + 1)?)
            })
        }),
    ]);
}

/// Rows `[N, N + 1, 3]`, m/N: no two alike, none beyond `size_m_per_n`.
fn rows(size_m_per_n: f64) -> Vec<f64> {
    let n = N * (N + 1) * 3;
    let each = (0..n).map(|i| size_m_per_n * (1.0 - i as f64 / (2 * n) as f64));
    each.collect()
}

fn table(size_m_per_n: f64) -> ComplianceTable {
    ComplianceTable::new(N, N + 1, &rows(size_m_per_n))
}

fn largest_m(table: &ComplianceTable, contacts: &[(usize, f64)]) -> f64 {
    let contacts: Vec<DrawnContact> =
        contacts.iter().map(|&(node, force_n)| DrawnContact { node, force_n }).collect();
    let mut scratch = table.scratch();
    let vectors = table.vectors(&contacts, &mut scratch).iter().flatten();
    vectors.fold(0.0, |most: f64, u| most.max(u.abs()))
}

/// Of the largest displacement under `contacts`, against sums of 64 bits.
fn worst_error(table: &ComplianceTable, size_m_per_n: f64, contacts: &[(usize, f64)]) -> f64 {
    let (rows, width) = (rows(size_m_per_n), (N + 1) * 3);
    let exact = (0..width).map(|i| {
        let parts = contacts.iter().map(|(node, f)| f * rows[node * width + i]);
        parts.sum::<f64>()
    });
    let exact = exact.fold(0.0, |most: f64, u| most.max(u.abs()));
    (largest_m(table, contacts) / exact - 1.0).abs()
}

/// Surface nodes of a table that is made in a folder.
fn n_read(make: fn(&Path) -> Result<ComplianceTable, ReproError>) -> Result<f64, ReproError> {
    Ok(in_folder(FILE, make)?.n_surface() as f64)
}

fn spoilt(path: &Path, spoil: fn(&mut [f64])) -> Result<ComplianceTable, ReproError> {
    let mut rows = rows(USUAL_M_PER_N);
    spoil(&mut rows);
    ComplianceTable::new(N, N + 1, &rows).write(path)?;
    Ok(ComplianceTable::read(path, N)?)
}

/// Reads a file of which only a share is left.
fn cut(path: &Path, share: f64) -> Result<ComplianceTable, ReproError> {
    table(USUAL_M_PER_N).write(path)?;
    keep_share(path, share)?;
    Ok(ComplianceTable::read(path, N)?)
}
