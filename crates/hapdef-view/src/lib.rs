//! The live page: a limb in the browser with its deformation, contacts, forces and gauges, and the
//! server behind it.
//!
//! [`ViewServer::start`] takes [`ViewParams`] and a [`LimbPicture`], listens, and gives a
//! [`ViewHandle`]. [`ViewHandle::push`] hands on a [`ViewFrame`] and never waits for a viewer: each
//! sees the newest frame when it is ready for one. What people do on the page comes out of
//! [`ViewHandle::commands`] as [`ViewCommand`]s. The page is embedded, needs no network, and is shown
//! only to the hosts that are allowed; commands need the [`Token`] of [`ViewHandle::url`].
//! [`ViewServer::start_robot`] shows several limbs on one page, at one port and with one token.
//!
//! Without the feature `server` there are the messages alone: a [`LocalPage`] makes them for a page that
//! is reached otherwise, as in a browser that runs the whole program; [`static_files`] are that page.
//!
//! `docs/view.md` has the messages on the wire byte by byte. This crate knows nothing of how
//! contacts are found.

#[cfg(feature = "server")]
mod assets;
#[cfg(feature = "server")]
mod client;
#[cfg(feature = "server")]
mod client_stats;
mod command;
mod device;
mod error;
#[cfg(feature = "server")]
mod feed;
mod frame;
#[cfg(feature = "server")]
mod guard;
mod local;
mod marks;
mod offers;
#[cfg(feature = "server")]
mod params;
mod picture;
mod ranges;
#[cfg(feature = "server")]
mod robot_page;
#[cfg(feature = "server")]
mod server;
#[cfg(feature = "server")]
mod site;
#[cfg(feature = "server")]
mod static_page;
#[cfg(feature = "server")]
mod token;
mod wire;

#[cfg(feature = "server")]
pub use client_stats::ClientInfo;
pub use command::{MOST_FINGERS, ViewCommand};
pub use device::DeviceState;
pub use error::ViewError;
pub use frame::{ContactMark, Displacement, Health, Recording, ReplayPosition, ViewFrame};
pub use local::LocalPage;
pub use offers::{Offers, PressOffer};
#[cfg(feature = "server")]
pub use params::ViewParams;
pub use picture::{GaugeSite, LimbPicture};
pub use ranges::Ranges;
#[cfg(feature = "server")]
pub use server::{RobotView, ViewHandle, ViewPusher, ViewServer};
#[cfg(feature = "server")]
pub use static_page::{STATIC_MODEL, STATIC_MODULE, StaticFile, static_files};
#[cfg(feature = "server")]
pub use token::Token;
