//! The methods the paper compares its networks with.

mod knn;
mod linear;
mod svr;

pub use knn::{Knn, KnnParams, OwnRow};
pub use linear::{LinearAccumulator, LinearParams, LinearRegression};
pub use svr::{Svr, SvrParams};
