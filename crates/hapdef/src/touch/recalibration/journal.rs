//! The journal of known touches: a line of JSON for each, beside the calibration that they keep up to date.

use std::path::{Path, PathBuf};

use hapdef_inverse::{TouchInfo, TouchZero};
use serde::{Deserialize, Serialize};

use super::declared::{DeclaredForce, DeclaredTouch, TouchAssumptions};
use crate::error::HapdefError;

/// A line of the journal.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum JournalEntry {
    /// A touch, taken or refused.
    Touch(Box<JournalTouch>),
    /// Touches were undone.
    Undo(JournalUndo),
}

/// A touch and what became of it.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct JournalTouch {
    /// Hash of the presses of the calibration that it was for.
    pub calibration: String,
    /// When it was taken, s since 1970.
    pub unix_s: u64,
    /// Where it comes from.
    pub from: String,
    /// When it touched, on the touches' own clock, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub t_s: Option<f64>,
    /// Where, m.
    pub position_m: [f64; 3],
    /// Standard deviation of the place, m.
    pub position_sd_m: f64,
    /// Force on the skin, N.
    pub force_n: [f64; 3],
    /// Standard deviation of each of its components, N.
    pub force_sd_n: f64,
    /// Readings `[n_gauges]`, µε.
    pub readings_ue: Vec<f64>,
    /// Whether the zero is taken off them already.
    pub is_tared: bool,
    /// Readings just before, untouched `[n_gauges]`, µε.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub untouched_ue: Option<Vec<f64>>,
    /// What was assumed.
    pub assumed: TouchAssumptions,
    /// Whether it was taken.
    pub is_accepted: bool,
    /// χ² of what was read beyond what was expected.
    pub chi2: f64,
    /// The χ² beyond which touches are refused.
    pub limit: f64,
    /// Readings that were expected `[n_gauges]`, µε.
    pub expected_ue: Vec<f64>,
    /// What was read beyond them `[n_gauges]`, µε.
    pub innovation_ue: Vec<f64>,
    /// Its standard deviation `[n_gauges]`, µε.
    pub innovation_sd_ue: Vec<f64>,
    /// Relative change of each gain since the calibration, before the touch `[n_gauges]`.
    pub gains_before: Vec<f64>,
    /// The same after it.
    pub gains_after: Vec<f64>,
}

/// Touches that were undone.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct JournalUndo {
    /// Hash of the presses of the calibration that they were for.
    pub calibration: String,
    /// When, s since 1970.
    pub unix_s: u64,
    /// How many, of those that were taken, the last first.
    pub n_touches: usize,
    /// Relative change of each gain since the calibration, before `[n_gauges]`.
    pub gains_before: Vec<f64>,
    /// The same after.
    pub gains_after: Vec<f64>,
}

/// When an entry is made, and for which calibration.
pub(super) struct Stamp {
    pub(super) calibration: String,
    pub(super) unix_s: u64,
}

impl JournalTouch {
    /// What became of `touch`, which pressed with `force_n`.
    pub(super) fn new(
        stamp: Stamp,
        touch: &DeclaredTouch,
        force_n: [f64; 3],
        assumed: TouchAssumptions,
        info: TouchInfo,
    ) -> Self {
        let untouched_ue = match &touch.zero {
            TouchZero::Untouched(readings) => Some(readings.clone()),
            TouchZero::Tared | TouchZero::Followed => None,
        };
        Self {
            calibration: stamp.calibration,
            unix_s: stamp.unix_s,
            from: touch.from.clone(),
            t_s: touch.t_s,
            position_m: touch.position_m,
            position_sd_m: touch.position_sd_m,
            force_n,
            force_sd_n: touch.force_sd_n,
            readings_ue: touch.readings_ue.clone(),
            is_tared: touch.zero == TouchZero::Tared,
            untouched_ue,
            assumed,
            is_accepted: info.is_accepted,
            chi2: info.chi2,
            limit: info.limit,
            expected_ue: info.expected,
            innovation_ue: info.innovation,
            innovation_sd_ue: info.innovation_sd,
            gains_before: info.gains_before,
            gains_after: info.gains_after,
        }
    }

    /// The touch as it was declared.
    pub(super) fn declared(&self) -> DeclaredTouch {
        let zero = match &self.untouched_ue {
            Some(readings) => TouchZero::Untouched(readings.clone()),
            None if self.is_tared => TouchZero::Tared,
            None => TouchZero::Followed,
        };
        DeclaredTouch {
            from: self.from.clone(),
            t_s: self.t_s,
            position_m: self.position_m,
            force: DeclaredForce::Vector(self.force_n),
            position_sd_m: self.position_sd_m,
            force_sd_n: self.force_sd_n,
            readings_ue: self.readings_ue.clone(),
            zero,
        }
    }

    /// The gauge whose reading was farthest from what was expected, by its standard deviation.
    #[must_use]
    pub fn worst_gauge(&self) -> usize {
        let off =
            |gauge: &usize| (self.innovation_ue[*gauge] / self.innovation_sd_ue[*gauge]).abs();
        let gauges = 0..self.innovation_ue.len().min(self.innovation_sd_ue.len());
        gauges.max_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(0)
    }
}

impl JournalEntry {
    /// Hash of the presses of the calibration that it was for.
    fn calibration(&self) -> &str {
        match self {
            Self::Touch(touch) => &touch.calibration,
            Self::Undo(undo) => &undo.calibration,
        }
    }
}

/// The journal beside the calibration at `path`: its name with `.touches.jsonl` after it.
pub(super) fn journal_path(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".touches.jsonl");
    name.into()
}

/// The text of the journal at `path`; empty where there is none.
pub(super) fn read_text(path: &Path) -> Result<String, HapdefError> {
    match std::fs::read_to_string(path) {
        Ok(text) => Ok(text),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(String::new()),
        Err(error) => Err(HapdefError::file(path)(error)),
    }
}

/// Touches of the journal `text` that were taken and not undone, in their order, for one calibration.
pub(super) fn in_use(
    path: &Path,
    text: &str,
    calibration: &str,
) -> Result<Vec<JournalTouch>, HapdefError> {
    let mut kept = Vec::new();
    for (i, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        let entry: JournalEntry = serde_json::from_str(line).map_err(|error| {
            let what = format!(
                "line {}: expected a touch or an undo as hapdef recalibrate writes it, found one that is not: \
                 {error}; put the line right, or rename the file and go back with --undo",
                i + 1
            );
            HapdefError::Journal { path: path.to_owned(), what }
        })?;
        if entry.calibration() != calibration {
            continue;
        }
        match entry {
            JournalEntry::Touch(touch) if touch.is_accepted => kept.push(*touch),
            JournalEntry::Touch(_) => {}
            JournalEntry::Undo(undo) => {
                kept.truncate(kept.len().saturating_sub(undo.n_touches));
            }
        }
    }
    Ok(kept)
}
