//! Contacts by superposition at their extremes.

mod calibration;
mod conditioning;
mod estimator;
mod layouts;
mod tracker;
mod world;

use std::sync::Arc;

pub use world::InverseWorld;

use super::table::{Rows, Trial};

/// Every row, in the table's order.
pub(super) fn trials(world: &Arc<InverseWorld>) -> Vec<Trial> {
    let on = |case, add: fn(&mut Rows<Arc<InverseWorld>>)| {
        let mut rows = Rows::new(case, world.clone());
        add(&mut rows);
        rows.into_trials()
    };
    let mut conditioning = Rows::new("conditioning", world.seed());
    conditioning::add(&mut conditioning);
    [
        on("estimator", estimator::add),
        on("estimator", layouts::add),
        on("tracker", tracker::add),
        on("calibration", calibration::add),
        conditioning.into_trials(),
    ]
    .into_iter()
    .flatten()
    .collect()
}
