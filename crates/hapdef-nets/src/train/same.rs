//! What a resumed training must have in common with the one it continues.

use std::path::Path;

use crate::error::NetsError;
use crate::params::TrainParams;

/// Fails if `asked` would make another training of the one that `path` holds.
pub(super) fn check_same(
    path: &Path,
    saved: &TrainParams,
    asked: &TrainParams,
) -> Result<(), NetsError> {
    let fields = |p: &TrainParams| {
        let steps = p.final_learning_rate.map(|_| p.steps);
        // Where looks change the result, their steps must be the same.
        let look = if p.keep_best || p.patience > 0 { p.validate_every } else { 0 };
        [
            ("seed", p.seed.to_string()),
            ("batch", p.batch.to_string()),
            ("learning_rate", p.learning_rate.to_string()),
            ("final_learning_rate", format!("{:?}", p.final_learning_rate)),
            ("warmup_steps", p.warmup_steps.to_string()),
            ("l2", p.l2.to_string()),
            ("backend", format!("{:?}", p.backend)),
            ("loss", format!("{:?}", p.loss)),
            ("validate_every", look.to_string()),
            ("keep_best", p.keep_best.to_string()),
            ("patience", p.patience.to_string()),
            ("steps", format!("{steps:?}")),
        ]
    };
    for ((name, saved), (_, asked)) in fields(saved).into_iter().zip(fields(asked)) {
        if saved != asked {
            return Err(NetsError::ResumeParams { path: path.to_path_buf(), name, saved, asked });
        }
    }
    Ok(())
}
