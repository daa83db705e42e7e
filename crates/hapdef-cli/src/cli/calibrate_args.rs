//! Arguments of `hapdef calibrate`, from a table or from presses as they come.

use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;
use hapdef::{SOURCE_FORMS, SourceArg, SourceArgError};
use hapdef_cli::SceneArgs;

use super::topic::TopicArgs;

#[derive(Args)]
#[command(after_help = "Examples:\n  \
    hapdef calibrate fixtures/shin/placed.json presses.csv calibration.json\n  \
    hapdef calibrate fixtures/shin/placed.json presses.csv calibration.json --live serial:/dev/ttyACM0\n\n\
    The table has a press a line: x_m, y_m, z_m, force_n, then the tared reading of each gauge in \
    µε; a first line of names is allowed. Name the result in the scene: estimator.calibration.")]
pub(crate) struct CalibrateArgs {
    #[command(flatten)]
    pub(super) scene: SceneArgs,
    /// The table of presses; or an MCAP file, with --topic. With --live the table is written, and --topic is one
    /// of the source.
    pub(super) table: PathBuf,
    #[command(flatten)]
    pub(super) topic: TopicArgs,
    /// The file to write.
    pub(super) calibration: PathBuf,
    /// Standard deviation of a reading's noise, µε, quantisation included.
    #[arg(long, default_value_t = 1.0)]
    pub(super) noise_ue: f64,
    /// Standard deviation of a press's position along the skin, mm.
    #[arg(long, default_value_t = 0.0)]
    pub(super) position_sd_mm: f64,
    /// Standard deviation of a press's force, N.
    #[arg(long, default_value_t = 0.0)]
    pub(super) force_sd_n: f64,
    /// Farthest a press may lie from the skin, mm.
    #[arg(long, default_value_t = 2.0)]
    pub(super) off_skin_mm: f64,
    /// Print the figures as JSON.
    #[arg(long)]
    pub(super) json: bool,
    #[command(flatten)]
    pub(super) live: LiveArgs,
}

#[derive(Args)]
pub(crate) struct LiveArgs {
    #[arg(long, value_name = "SOURCE", help = format!(
        "Ask for presses, read them, and write the table: {SOURCE_FORMS}, or virtual, the scene's \
         simulated rig, pressed where it is asked for"
    ))]
    live: Option<PressSource>,
    /// Presses to ask for.
    #[arg(long, default_value_t = 60, requires = "live")]
    pub(super) presses: usize,
    /// Normal force to press with, N.
    #[arg(long, default_value_t = 10.0, requires = "live")]
    pub(super) force_n: f64,
}

/// Where presses come from.
#[derive(Clone, Debug)]
pub(crate) enum PressSource {
    /// The scene's virtual rig.
    Virtual,
    /// A device.
    Device(SourceArg),
}

impl CalibrateArgs {
    /// Where live presses come from, of the topic that is named; `None` for a table.
    pub(super) fn press_source(&self) -> Result<Option<PressSource>, SourceArgError> {
        Ok(match &self.live.live {
            Some(PressSource::Device(source)) => Some(PressSource::Device(self.topic.of(source)?)),
            Some(PressSource::Virtual) if self.topic.topic.is_some() => {
                return Err(SourceArgError::Topic { found: "virtual".to_owned() });
            }
            other => other.clone(),
        })
    }
}

impl FromStr for PressSource {
    type Err = SourceArgError;

    fn from_str(text: &str) -> Result<Self, SourceArgError> {
        if text == "virtual" {
            return Ok(Self::Virtual);
        }
        text.parse().map(Self::Device)
    }
}
