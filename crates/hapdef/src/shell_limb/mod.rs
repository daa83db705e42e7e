//! From a surface to gauge readings by a shell, for limbs of which there is no solid mesh: a scene of the
//! skin and its wall with gauges spread over it, solved, and compared with solids.

mod against;
mod compare;
mod limb;
mod maps;
mod output;
mod page;
mod params;
mod report;
mod spread;

pub use crate::new_limb::WallChoice;
pub use compare::{Answered, SceneSource, ShellComparison, ShellVerdict};
pub use limb::{GaugeInfo, ModelInfo, ShellLimb, ShellLimbInfo, WallInfo};
pub use maps::{AboveGood, GaugeDifference, PressDifference, ShellMaps};
pub use output::write_measured_wall;
pub use params::{MountInfo, ShellLimbParams};
pub use report::{SHELL_REPORT_HTML, SHELL_REPORT_JSON};
