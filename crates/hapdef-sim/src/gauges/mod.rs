//! Readings that are linear in the displacement, and what they are for a force anywhere; strain
//! gauges on solids.

mod functional;
pub(crate) mod response;
pub(crate) mod strain_gauge;
pub(crate) mod wall;

pub use functional::{LinearFunctional, NodeWeight};
pub use response::GaugeResponse;
pub use strain_gauge::{GaugeParams, GaugeSite, GaugeStrain};
