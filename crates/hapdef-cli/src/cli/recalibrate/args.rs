//! Arguments of `hapdef recalibrate`.

use std::path::PathBuf;

use clap::Args;
use hapdef::touch::TouchAssumptions;
use hapdef_cli::SceneArgs;

use crate::cli::topic::TopicArgs;

#[derive(Args)]
#[command(after_help = "Examples:\n  \
    hapdef recalibrate my-limb touches.csv\n  \
    hapdef recalibrate my-limb --undo 3\n  \
    hapdef recalibrate my-limb --undo\n\n\
    The file that the scene names as estimator.calibration is brought up to date: contacts, live and bundle have the \
    gains from then on, a bundle when it is made anew. A touch a line, named in the first one: x_m, y_m, z_m, then \
    force_n (against the skin) or fx_n, fy_n, fz_n (the force on the skin), and each gauge's tared reading in µε, \
    such as\n\n  \
    t_s,x_m,y_m,z_m,force_n,g0_ue,g1_ue,g2_ue\n  \
    1764374400,0.0412,0.0875,0.0031,12.0,41.2,-8.7,103.5\n\n\
    t_s (when, s), position_sd_mm and force_sd_n may be left out. A line of force 0 is a frame in which nothing \
    touches: readings of the lines after it are above it. A touch that does not fit is refused. Each is recorded in \
    the file beside the calibration that ends in .touches.jsonl.")]
pub(crate) struct RecalibrateArgs {
    #[command(flatten)]
    pub(super) scene: SceneArgs,
    /// The table of known touches; or an MCAP file, with --topic.
    #[arg(required_unless_present = "undo")]
    pub(super) table: Option<PathBuf>,
    #[command(flatten)]
    pub(super) topic: TopicArgs,
    /// Go back to before the last N touches that were taken, or before all of them.
    #[arg(long, value_name = "N", num_args = 0..=1, conflicts_with = "table")]
    pub(super) undo: Option<Option<usize>>,
    /// Standard deviation of a reading's noise, µε, quantisation included.
    #[arg(long, default_value_t = 1.0)]
    noise_ue: f64,
    /// Standard deviation of a touch's place along the skin, mm, where the table does not say it.
    #[arg(long, default_value_t = 0.5)]
    pub(super) position_sd_mm: f64,
    /// Standard deviation of each component of a touch's force, N, where the table does not say it.
    #[arg(long, default_value_t = 0.1)]
    pub(super) force_sd_n: f64,
    /// Farthest a touch may lie from the skin, mm.
    #[arg(long, default_value_t = 2.0)]
    off_skin_mm: f64,
    /// How far gains may have changed between the calibration and the first touch, standard deviation, %.
    #[arg(long, default_value_t = 3.0)]
    gain_sd_pct: f64,
    /// How far gains change from one touch to the next, standard deviation, %: what is forgotten.
    #[arg(long, default_value_t = 0.1)]
    drift_per_touch_pct: f64,
    /// How far gains change in an hour, standard deviation, %, where the table has times.
    #[arg(long, default_value_t = 0.2)]
    drift_per_hour_pct: f64,
    /// Refuse a touch whose readings are less probable than this.
    #[arg(long, default_value_t = 1e-6)]
    refuse_p: f64,
    /// Print what became of each touch as JSON.
    #[arg(long)]
    pub(super) json: bool,
}

impl RecalibrateArgs {
    pub(super) fn assumed(&self) -> TouchAssumptions {
        TouchAssumptions {
            noise_ue: self.noise_ue,
            gain_sd: self.gain_sd_pct * 1e-2,
            gain_drift_per_touch: self.drift_per_touch_pct * 1e-2,
            gain_drift_per_hour: self.drift_per_hour_pct * 1e-2,
            refuse_p: self.refuse_p,
            off_skin_m: self.off_skin_mm * 1e-3,
        }
    }
}
