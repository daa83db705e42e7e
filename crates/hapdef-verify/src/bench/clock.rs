//! Wall and processor seconds of one piece of work.

use std::time::Instant;

/// What a piece of work took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Took {
    /// Seconds on the wall.
    pub(crate) wall_s: f64,
    /// Seconds of all threads of this process, in steps of 10 ms; on a busy machine these compare.
    pub(crate) processor_s: f64,
}

/// Runs `work` and times it.
pub(crate) fn timed<T>(work: impl FnOnce() -> T) -> (T, Took) {
    let (started, before) = (Instant::now(), processor_s());
    let done = work();
    let took =
        Took { wall_s: started.elapsed().as_secs_f64(), processor_s: processor_s() - before };
    (done, took)
}

/// User and system seconds of this process so far; NaN where /proc has none.
fn processor_s() -> f64 {
    // utime and stime are the 12th and 13th field after the name in brackets, in 1/100 s (proc(5))
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields = text.rsplit_once(')').map_or("", |(_, rest)| rest);
    let ticks: Vec<f64> =
        fields.split_whitespace().skip(11).take(2).filter_map(|field| field.parse().ok()).collect();
    match ticks[..] {
        [user, system] => (user + system) / 100.0,
        _ => f64::NAN,
    }
}
