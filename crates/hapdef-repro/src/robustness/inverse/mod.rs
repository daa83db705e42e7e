//! Contacts by superposition at their extremes.

mod calibration;
mod conditioning;
mod estimator;
mod layouts;
mod tracker;
mod world;

pub use world::InverseWorld;

use super::table::Trials;

/// Every row of docs/stability-inverse.md, in its order.
pub fn trials(world: &InverseWorld) -> Trials<InverseWorld> {
    let mut rows = Trials::new(world.clone());
    estimator::add(rows.of("estimator"));
    layouts::add(&mut rows);
    tracker::add(rows.of("tracker"));
    calibration::add(rows.of("calibration"));
    conditioning::add(rows.of("conditioning"));
    rows
}
