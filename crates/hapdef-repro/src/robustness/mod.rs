//! Whether a baseline, a net, superposition or a part around them is ever silently wrong: data and
//! settings at their extremes.
//!
//! Rows draw their data by a seed, of which 0 is that of the tables.
//!
//! Every row says what must hold. It is `accurate` where that holds, `refused` where the method
//! gave a typed error, and wrong where neither is so.

/// The bound as the tests of hapdef-nets have it, from the words of [`hapdef_nets::infer::Precision`].
#[path = "../../../hapdef-nets/tests/it/infer/bound.rs"]
mod bound;
mod cases;
mod inverse;
mod parts;
mod plant;
mod quantised;
mod table;

pub use inverse::{InverseWorld, trials as inverse_trials};
pub use parts::trials as parts_trials;
pub use plant::Plant;
pub use table::{INVERSE_TABLE, NETS_TABLE, PARTS_TABLE, Trials};

/// Every row of docs/stability-nets.md in its order; `seed` draws their data.
pub fn nets_trials(seed: u64) -> Trials<Plant> {
    let mut rows = Trials::new(Plant::new(seed, plant::net(3e-3)));
    cases::add(&mut rows, seed);
    quantised::add(&mut rows, seed);
    rows
}
