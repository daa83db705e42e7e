//! The pipeline's stages, in order. Each is a function from what it needs to a cached folder.

mod dataset;
mod dataset_kind;
mod dataset_rows;
mod drawn;
mod eval;
mod in_modes;
pub(crate) mod keys;
mod mesh_check;
mod nets;
mod rig;
mod rig_channels;
mod simulate;
mod train;
mod training;

pub use dataset::{Datasets, datasets, samples_path};
pub use dataset_kind::DatasetKind;
pub use dataset_rows::{Dataset, blocks};
pub use drawn::DrawnSamples;
pub use eval::{DoubleScores, EvalReport, SingleScores, eval, trained_chain};
pub use mesh_check::mesh_check;
pub use nets::NetKind;
pub use rig::{check_rig_mesh, real_limb, rig};
pub(crate) use rig::{rig_key, rig_solid};
pub use simulate::{compliance, compliance_table};
pub use train::{TrainedNet, TrainedNets, train, train_kinds};
pub use training::Training;
