//! Datasets on disk and their scales.

use std::path::Path;

use hapdef_data::{DatasetReader, DatasetWriter, Split, StandardiserFit, TensorSpec};

use super::{in_folder, keep_share};
use crate::error::ReproError;
use crate::robustness::table::Trials;

/// Values at the ends of what 32 bits hold.
const ENDS: [f32; 8] = [f32::MAX, f32::MIN, f32::MIN_POSITIVE, 1e-45, -1e-45, 0.0, -0.0, 1.0];

const N_ROWS: usize = 6;

/// The file that rows write.
const FILE: &str = "set.safetensors";

pub(super) fn add(rows: &mut Trials<u64>) {
    let holds = ("bits that differ when read back", 0.0);
    rows.accurate("values at the ends of f32", holds, |_| {
        let back = in_folder(FILE, |path| {
            write(path, &ENDS)?;
            read(path)
        })?;
        let differ = |(a, b): (&f32, &f32)| a.to_bits() != b.to_bits();
        let expected = ENDS.repeat(N_ROWS);
        Ok(expected.iter().zip(&back).filter(|p| differ(*p)).count() as f64)
    });
    for (extreme, mean, size) in [
        ("a column at 1e6 that varies by 1", 1e6, 1.0),
        ("a column of 1e-30", 0.0, 1e-30),
        ("a column of 1e30", 0.0, 1e30),
    ] {
        let holds = ("the deviation, relative error", 1e-3);
        let error = move |_: &_| deviation_error(mean, size);
        rows.of("standardiser").accurate(extreme, holds, error);
    }
    rows.of("dataset").all_refused([
        ("a value is NaN", "NaN", || in_folder(FILE, |path| write(path, &[1.0, f32::NAN]))),
        ("a value is infinite", "inf", || in_folder(FILE, |path| write(path, &[f32::INFINITY]))),
        ("the file's second half is missing", "", || in_folder(FILE, |path| cut(path, 0.5))),
        ("the file's last byte is missing", "", || in_folder(FILE, |path| cut(path, 0.999))),
        ("the file is empty", "", || in_folder(FILE, |path| cut(path, 0.0))),
        ("four samples to be split", "4", || Ok(Split::of(4)?.n() as f64)),
    ]);
}

fn write(path: &Path, row: &[f32]) -> Result<f64, ReproError> {
    let spec = TensorSpec::f32("values", row.len(), "1");
    let mut writer = DatasetWriter::create(path, N_ROWS, &[spec])?;
    for _ in 0..N_ROWS {
        writer.append("values", row)?;
    }
    Ok(writer.finish()?.n as f64)
}

fn read(path: &Path) -> Result<Vec<f32>, ReproError> {
    let mut reader = DatasetReader::open(path)?;
    let mut back = vec![0.0_f32; N_ROWS * reader.width("values")?];
    reader.read_rows("values", 0..N_ROWS, &mut back)?;
    Ok(back)
}

/// Reads a file of which only a share is left.
fn cut(path: &Path, share: f64) -> Result<f64, ReproError> {
    write(path, &ENDS)?;
    keep_share(path, share)?;
    Ok(read(path)?.len() as f64)
}

/// Relative error of the deviation of 1,000 values around `mean`, ±`size` in turn.
fn deviation_error(mean: f32, size: f32) -> Result<f64, ReproError> {
    let mut fit = StandardiserFit::new(1);
    for i in 0..1000 {
        fit.push(&[if i % 2 == 0 { mean + size } else { mean - size }])?;
    }
    let (standardiser, _) = fit.finish()?;
    Ok(f64::from(standardiser.std[0] / size - 1.0).abs())
}
