//! From a surface to gauge readings by a shell model: for limbs of which there is a glTF skin but
//! no solid mesh.
//!
//! [`shell_limb`] makes the model and its readings, [`ShellLimb::against_extruded`] and
//! [`ShellLimb::against_solid`] tell how far it is from a solid one.

mod against;
mod compare;
mod differences;
mod extruded;
mod info;
mod maps;
mod mount;
mod output;
mod params;
mod press;
mod report;
mod response;
mod sites;
mod stopwatch;
mod thin_wall;
mod wall;

pub use compare::{Answered, PressDifference, ShellComparison, ShellVerdict};
pub use differences::{Differences, GOOD_DIFFERENCE};
pub use info::{
    EdgeRefused, GaugeInfo, MeasuredWall, ModelInfo, MountInfo, ShellLimbInfo, StageTime,
    SurfaceCounts, WallInfo,
};
pub use maps::{AboveGood, GaugeDifference, ShellMaps, TouchDifference};
pub use output::write_measured_wall;
pub use params::{MountChoice, MountEnd, ShellLimbParams, WallChoice};
pub use report::{ReportSource, SHELL_REPORT_HTML, SHELL_REPORT_JSON, SceneSource};
pub use response::{ShellLimb, shell_limb};
pub(crate) use sites::on_wall;
pub use thin_wall::ThinWall;
