//! What `hapdef recalibrate` says.

use hapdef::touch::{JournalTouch, Recalibrator};
use hapdef_cli::shown;
use serde_json::{Value, json};

/// So many touches refused one after the other say more of the limb than of the touches.
const MANY_REFUSED: usize = 3;

pub(super) fn print_touches(
    recalibrator: &Recalibrator,
    touches: &[JournalTouch],
    gauges: &[&str],
) {
    for touch in touches.iter().filter(|touch| !touch.is_accepted) {
        println!("{}", refused(touch, gauges));
    }
    let n_accepted = touches.iter().filter(|touch| touch.is_accepted).count();
    println!("{n_accepted} of {} touches taken", touches.len());
    let last = touches.iter().rev().take_while(|touch| !touch.is_accepted).count();
    if last >= MANY_REFUSED {
        println!(
            "the last {last} were refused: if they were where and as strong as the table says, gains have moved \
             farther than --gain-sd-pct and --drift-per-touch-pct allow, or a gauge came off: calibrate anew"
        );
    }
    print_gains(recalibrator, gauges);
    print_files(recalibrator);
}

pub(super) fn print_undone(recalibrator: &Recalibrator, n_undone: usize) {
    let left = recalibrator.since().map_or(0, |since| since.n_touches);
    let state = if left == 0 { "; the calibration is as it was pressed" } else { "" };
    println!("{n_undone} touches undone, {left} left{state}");
    print_files(recalibrator);
}

pub(super) fn as_json(
    recalibrator: &Recalibrator,
    touches: &[JournalTouch],
    n_undone: usize,
) -> Value {
    let since = recalibrator.since();
    json!({
        "n_taken": touches.iter().filter(|touch| touch.is_accepted).count(),
        "n_refused": touches.iter().filter(|touch| !touch.is_accepted).count(),
        "n_undone": n_undone,
        "n_touches": since.as_ref().map_or(0, |since| since.n_touches),
        "gains": since.as_ref().map(|since| &since.gains),
        "gain_sds": gain_sds(recalibrator),
        "zeros_ue": recalibrator.zeros_ue().iter().map(|zero| zero.0).collect::<Vec<_>>(),
        "touches": touches,
        "journal": recalibrator.journal_path(),
    })
}

fn refused(touch: &JournalTouch, gauges: &[&str]) -> String {
    let gauge = touch.worst_gauge();
    let [x, y, z] = touch.position_m.map(|x| x * 1e3);
    let force_n = touch.force_n.iter().map(|f| f * f).sum::<f64>().sqrt();
    let (expected, beyond) = (touch.expected_ue[gauge], touch.innovation_ue[gauge]);
    format!(
        "{}: refused: {force_n:.1} N at ({x:.1}, {y:.1}, {z:.1}) mm: χ² {:.0}, at most {:.0}; {} reads {:.1} µε, \
         expected {expected:.1} ± {:.1}: was it there, and so strong?",
        touch.from,
        touch.chi2,
        touch.limit,
        gauges.get(gauge).copied().unwrap_or("a gauge"),
        expected + beyond,
        touch.innovation_sd_ue[gauge],
    )
}

fn print_gains(recalibrator: &Recalibrator, gauges: &[&str]) {
    let Some(since) = recalibrator.since() else {
        return;
    };
    let width = gauges.iter().map(|name| name.chars().count()).max().unwrap_or(0).max(5);
    println!("\n{:width$}  gain since the calibration, %", "gauge");
    for ((name, gain), sd) in gauges.iter().zip(&since.gains).zip(gain_sds(recalibrator)) {
        println!("{name:width$}  {:+.2} ± {:.2}", gain * 100.0, sd * 100.0);
    }
    let zeros = recalibrator.zeros_ue();
    if let Some((zero, sd)) = zeros.iter().max_by(|a, b| a.0.abs().total_cmp(&b.0.abs())) {
        println!("zeros are off by up to {:.1} ± {sd:.1} µε", zero.abs());
    }
}

fn print_files(recalibrator: &Recalibrator) {
    println!("\n{}\n{}", shown(recalibrator.path()), shown(recalibrator.journal_path()));
}

fn gain_sds(recalibrator: &Recalibrator) -> Vec<f64> {
    let Some(since) = recalibrator.since() else {
        return Vec::new();
    };
    let n = since.gains.len();
    (0..n).map(|i| since.covariance[i * (n + 1)].sqrt()).collect()
}
