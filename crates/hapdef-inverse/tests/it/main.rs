//! The integration tests of hapdef-inverse: one program.

mod calibration;
mod conditioning;
mod confidence_regions;
mod examples;
mod limb;
mod placement;
mod recovery;
mod response;
mod stability;
mod tracking;
mod tracking_allocations;
mod world;
