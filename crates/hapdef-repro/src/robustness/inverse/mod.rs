//! Contacts by superposition at their extremes.

mod calibration;
mod conditioning;
mod estimator;
mod layouts;
mod tracker;
mod world;

use std::sync::Arc;

pub use world::InverseWorld;

use super::table::Trial;

/// Every row, in the table's order.
pub(super) fn trials(world: &Arc<InverseWorld>) -> Vec<Trial> {
    let mut all = Vec::new();
    estimator::trials(&mut all, world);
    layouts::trials(&mut all, world);
    tracker::trials(&mut all, world);
    calibration::trials(&mut all, world);
    conditioning::trials(&mut all, world.seed());
    all
}
