//! The methods the paper compares its networks with.

mod knn;
mod linear;
mod svr;

pub use knn::{Knn, KnnParams, Neighbours, OwnRow};
pub use linear::{LinearAccumulator, LinearInfo, LinearParams, LinearRegression};
pub use svr::{Svr, SvrInfo, SvrParams};
