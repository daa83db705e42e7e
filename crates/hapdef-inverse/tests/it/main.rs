//! The integration tests of hapdef-inverse: one program.

mod calibration;
mod conditioning;
mod examples;
mod limb;
mod placement;
mod recovery;
mod response;
mod stability;
mod told_regions;
mod tracking;
mod tracking_allocations;
mod world;
