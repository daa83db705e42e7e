//! The live page: a limb in the browser with its deformation, contacts, forces and gauges, and the
//! server behind it.
//!
//! [`ViewServer::start`] takes [`ViewParams`] and a [`LimbPicture`], listens, and gives a
//! [`ViewHandle`]. [`ViewHandle::push`] hands on a [`ViewFrame`] and never waits for a viewer: each
//! sees the newest frame when it is ready for one. What people do on the page comes out of
//! [`ViewHandle::commands`] as [`ViewCommand`]s. The page is embedded, needs no network, and is shown
//! only to the hosts that are allowed; commands need the [`Token`] of [`ViewHandle::url`].
//!
//! `docs/view.md` has the messages on the wire byte by byte. This crate knows nothing of how
//! contacts are found.

mod assets;
mod client;
mod client_stats;
mod command;
mod device;
mod error;
mod feed;
mod frame;
mod guard;
mod params;
mod picture;
mod server;
mod token;
mod wire;

pub use client_stats::ClientInfo;
pub use command::{MOST_FINGERS, ViewCommand};
pub use device::DeviceState;
pub use error::ViewError;
pub use frame::{ContactMark, Displacement, Health, Recording, ReplayPosition, ViewFrame};
pub use params::{Offers, PressOffer, ViewParams};
pub use picture::{GaugeSite, LimbPicture};
pub use server::{ViewHandle, ViewPusher, ViewServer};
pub use token::Token;
