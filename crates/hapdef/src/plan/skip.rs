//! What a scene can leave out.

use serde::Serialize;

/// Work that is left out because nothing that the scene wants needs it. `tests/it/skips` proves of each
/// that the result that is wanted stays the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Skip {
    /// Right-hand sides for nodes that are held or that nothing touches.
    UntouchedNodes,
    /// Right-hand sides for forces along the skin, which no contact has.
    TangentialLoads,
    /// A right-hand side for every node, where one for each gauge tells the same.
    LoadsAtEveryNode,
    /// The solve of the gauges' response, which a calibration has.
    CalibratedResponse,
    /// Datasets of more contacts than the scene has.
    LargerSets,
    /// Nets that only the scores compare with.
    OtherNets,
    /// The nets' scores.
    Scores,
    /// What only the estimator needs that the scene does not choose.
    OtherEstimator,
    /// The compliance of the skin, where no map is wanted.
    UnwantedMap,
    /// Shear and wider tips in the noise, where nothing rubs and none is wider.
    Friction,
    /// Pairs, where the scene has one contact at most.
    UnwantedPairs,
    /// Pairs, where the gauges carry no second contact.
    UncarriedPairs,
    /// The search in frames that nothing touches.
    UntouchedFrames,
}
