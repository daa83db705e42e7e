//! Which dataset.

use serde::{Deserialize, Serialize};

/// What a dataset's samples are.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum DatasetKind {
    /// Simulated samples of one to four contacts: the paper's sets I to IV.
    Simulated {
        /// Contacts of each sample.
        n_contacts: usize,
    },
    /// Single presses with the rig's readings.
    RigSingle,
    /// Double presses with the rig's readings; for testing only.
    RigDouble,
}
