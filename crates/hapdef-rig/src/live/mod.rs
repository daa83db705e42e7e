//! The virtual limb, live: presses played on the perturbed limb, through gauge electronics, as a device
//! that speaks HDP1.
//!
//! A [`LiveLimb`] tells the strains for forces anywhere on its surface; a [`PressScript`], written or
//! drawn by [`random_script`], becomes a [`Play`] on it, and a [`PressHandle`] presses by hand;
//! [`LiveElectronics`] makes codes of strains. [`RigDevice`] is all of that behind HDP1: at a
//! [`DevicePort`] it is run by [`run_rig`] or [`spawn_rig`], as a [`RigLink`] it is read directly. Every
//! frame's ground truth comes as a [`TruthFrame`]. Everything is simulated.

mod device;
mod electronics;
mod events;
mod faults;
mod flicker;
mod hands;
mod limb;
mod link;
mod loads;
mod nearest;
mod play;
mod port;
mod press;
#[cfg(unix)]
mod pty;
mod random;
mod run;
mod script;
mod sensors;
mod truth;

pub use device::{RigDevice, RigDeviceParams};
pub use electronics::{BridgeParams, CreepTerm, LiveElectronics, LiveElectronicsParams};
pub use faults::RigFault;
pub use hands::{Hands, HandsParams};
pub use limb::{LiveLimb, LiveSurface, SurfacePoint};
pub use link::{RigClock, RigLink};
pub use loads::{LimbLoads, LoadHandle, MovingLoads};
pub use play::Play;
pub use port::{DevicePort, PortState, TcpPort};
pub use press::{PressHandle, Pressed, TrueContact, TruthFrame};
#[cfg(unix)]
pub use pty::PtyPort;
pub use random::{RandomScriptParams, random_script};
pub use run::{RunInfo, RunParams, RunningRig, run_rig, spawn_rig};
pub use script::{PressEvent, PressScript, ScriptedContact};
pub use sensors::{LoadSensorParams, LoadSensors};
