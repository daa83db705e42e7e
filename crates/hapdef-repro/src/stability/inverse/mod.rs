//! Contacts by superposition at their extremes.

mod calibration;
mod conditioning;
mod estimator;
mod layouts;
mod tracker;
mod world;

use std::sync::Arc;

pub use world::InverseWorld;

use super::row::Case;

/// Every row, in the table's order.
pub(super) fn cases(world: &Arc<InverseWorld>) -> Vec<Case> {
    let mut all = Vec::new();
    estimator::cases(&mut all, world);
    layouts::cases(&mut all, world);
    tracker::cases(&mut all, world);
    calibration::cases(&mut all, world);
    conditioning::cases(&mut all, world.seed());
    all
}
