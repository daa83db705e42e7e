//! Strain gauges on solids, and what they read for a force anywhere.

pub(crate) mod response;
pub(crate) mod strain_gauge;
pub(crate) mod wall;

pub use response::GaugeResponse;
pub use strain_gauge::{GaugeParams, GaugeSite, GaugeStrain};
