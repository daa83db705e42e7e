//! A board of your own: lines of integers, as the paper's authors' sketch prints them.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use hapdef::touch::{Touch, TouchEstimator};
use hapdef_daq::csv_line::CsvDecoder;
use nalgebra::Point3;

use super::scene::Placed;

/// µε of a count where nothing else is said: 12 bits over ±4 × 256 µε.
pub const UE_PER_COUNT: f64 = 0.5;
/// Lines at the beginning in which nothing touches: their mean is the tare.
const N_TARE: usize = 50;
/// Face and force of the made-up press, N.
const PRESSED: (usize, f64) = (700, 12.0);

/// A contact that was found.
#[derive(Debug)]
pub struct Found {
    pub force_n: f64,
    pub position_m: Point3<f64>,
    /// Distance from the made-up press, mm; none of readings from a file.
    pub miss_mm: Option<f64>,
}

/// The contacts in the mean of what comes after the tare. `ue_per_count` is how much strain moves a
/// reading of the board by one, µε: forces are in proportion to it.
pub fn own_board(file: Option<&Path>, ue_per_count: f64) -> Result<Vec<Found>> {
    ensure!(
        ue_per_count.is_finite() && ue_per_count != 0.0,
        "expected the µε of a count, found {ue_per_count}: the bridge's range over the converter's counts"
    );
    let placed = Placed::load()?;
    let n_gauges = placed.map.n_gauges();
    let (place, readings_ue) = placed.press(PRESSED.0, PRESSED.1)?;
    let text = match file {
        Some(path) => std::fs::read(path).with_context(|| path.display().to_string())?,
        None => made_up(&readings_ue, ue_per_count).into_bytes(),
    };
    let mut lines: Vec<Vec<i32>> = Vec::new();
    let mut decoder = CsvDecoder::new(n_gauges);
    decoder.push(&text, &mut |_, values| lines.push(values.to_vec()));
    ensure!(
        lines.len() > N_TARE,
        "expected more than {N_TARE} lines of {n_gauges} integers from 0 to 4095, found {}",
        lines.len()
    );
    let (untouched, touched) = lines.split_at(N_TARE);
    let (zero, mean) = (mean(untouched), mean(touched));
    let tared = mean.iter().zip(zero).map(|(value, zero)| (value - zero) * ue_per_count);
    let made_up_at = file.is_none().then_some(place);
    let mut touch = Touch::default();
    let tared_ue: Vec<f64> = tared.collect();
    placed.estimator()?.estimate(&tared_ue, &mut touch)?;
    let found = touch.contacts.iter().map(|contact| Found {
        force_n: contact.force_n,
        position_m: contact.position_m,
        miss_mm: made_up_at.map(|place| (contact.position_m - place).norm() * 1e3),
    });
    Ok(found.collect())
}

/// Mean of each column, counts.
fn mean(lines: &[Vec<i32>]) -> Vec<f64> {
    let mut sums = vec![0.0; lines[0].len()];
    for line in lines {
        sums.iter_mut().zip(line).for_each(|(sum, v)| *sum += f64::from(*v));
    }
    sums.iter().map(|sum| sum / lines.len() as f64).collect()
}

/// What a board would print: a line whose beginning is missing, the tare, then the press. A gauge's zero
/// lies somewhere, and its last bit wobbles.
fn made_up(readings_ue: &[f64], ue_per_count: f64) -> String {
    let mut text = "1,2048\n".to_owned();
    for line in 0..3 * N_TARE {
        let count = |(gauge, reading): (usize, &f64)| {
            let zero = 2000.0 + 9.3 * gauge as f64 + (line % 3) as f64 - 1.0;
            let strain = if line < N_TARE { 0.0 } else { *reading };
            (zero + strain / ue_per_count).round().to_string()
        };
        let counts: Vec<String> = readings_ue.iter().enumerate().map(count).collect();
        let _ = writeln!(text, "{}", counts.join(","));
    }
    text
}

#[test]
fn the_press_is_found_in_whole_counts() {
    let found = own_board(None, UE_PER_COUNT).unwrap();
    assert_eq!(found.len(), 1, "{found:?}");
    let (force_n, miss_mm) = (found[0].force_n, found[0].miss_mm.unwrap());
    // Rounding to half a microstrain is all that stands between.
    assert!((force_n - PRESSED.1).abs() < 0.3, "{force_n} N");
    assert!(miss_mm < 0.5, "{miss_mm} mm");
}

#[test]
fn a_file_gives_what_the_made_up_lines_give_and_a_short_one_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("board.csv");
    let placed = Placed::load().unwrap();
    let (_, readings_ue) = placed.press(PRESSED.0, PRESSED.1).unwrap();
    let text = made_up(&readings_ue, UE_PER_COUNT);
    std::fs::write(&file, &text).unwrap();
    let read = |ue_per_count| own_board(Some(&file), ue_per_count);
    let (of_file, made_up) = (read(0.5).unwrap(), own_board(None, 0.5).unwrap());
    assert_eq!(of_file.len(), made_up.len());
    assert_eq!(of_file[0].force_n, made_up[0].force_n);
    assert_eq!(of_file[0].position_m, made_up[0].position_m);
    assert!(of_file[0].miss_mm.is_none());
    let twice = read(1.0).unwrap();
    let factor = twice[0].force_n / of_file[0].force_n;
    assert!((factor - 2.0).abs() < 0.01, "{factor}");
    let refused = read(0.0).unwrap_err().to_string();
    assert!(refused.contains("µε of a count, found 0"), "{refused}");
    let begin: Vec<&str> = text.lines().take(1 + N_TARE).collect();
    std::fs::write(&file, begin.join("\n") + "\n").unwrap();
    let refused = read(0.5).unwrap_err().to_string();
    assert!(refused.ends_with("found 50"), "{refused}");
    let absent = own_board(Some(&folder.path().join("no.csv")), 0.5).unwrap_err();
    assert!(absent.to_string().ends_with("no.csv"), "{absent}");
}
