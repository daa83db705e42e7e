//! A guided calibration: where to press next, whether the press is held still, what the map gains.
//!
//! A [`CalibrationSession`] takes frame after frame and says what is to be done; whoever runs it, a
//! person at a terminal or a probing robot, does it. It knows no port and no clock.

mod hold;
mod plan;
mod state;
mod table;

pub use hold::HoldParams;
pub use state::{
    AskedPress, CalibrationSession, HeldPress, SessionEvent, SessionParams, SessionProgress,
};
pub use table::{PressRow, write_press_table};
