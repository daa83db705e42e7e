//! The held end of a limb.

use hapdef_mesh::{FeNodeId, SurfaceMesh};
use hapdef_sim::SimError;

use super::info::MountInfo;
use super::{MountChoice, MountEnd};
use crate::error::HapdefError;

/// The part of the extent that is held where no length is given.
const HELD_SHARE: f64 = 0.05;

/// The vertices of `skin` that are held, ascending.
pub(super) fn clamped(
    skin: &SurfaceMesh,
    choice: &MountChoice,
) -> Result<(Vec<FeNodeId>, MountInfo), HapdefError> {
    let bounds = skin.bounding_box();
    let size = bounds.size_m();
    let axis = choice.axis.unwrap_or(size.imax());
    let length_m = choice.length_m.unwrap_or(HELD_SHARE * size[axis]);
    if !(length_m > 0.0 && length_m < size[axis]) {
        return Err(SimError::Parameter {
            what: "the length of the mount (m)",
            value: length_m,
            expected: "above 0 and shorter than the limb",
        }
        .into());
    }
    let coordinates = skin.vertices().iter().map(|place| place[axis]);
    let from_end: Vec<f64> = match choice.end {
        MountEnd::Low => {
            let low = coordinates.clone().fold(f64::INFINITY, f64::min);
            coordinates.map(|c| c - low).collect()
        }
        MountEnd::High => {
            let high = coordinates.clone().fold(f64::NEG_INFINITY, f64::max);
            coordinates.map(|c| high - c).collect()
        }
    };
    let held = (0..from_end.len()).filter(|&i| from_end[i] <= length_m);
    let nodes: Vec<FeNodeId> = held.map(FeNodeId::from_index).collect();
    let info = MountInfo {
        axis: ['x', 'y', 'z'][axis],
        end: match choice.end {
            MountEnd::Low => "low",
            MountEnd::High => "high",
        },
        length_m,
        n_clamped: nodes.len(),
    };
    Ok((nodes, info))
}
