//! What makes a triangle unusable as a shell element.

/// Why a shell element is not usable.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "a variant's message is its documentation")]
pub enum ShellElementProblem {
    #[error("its nodes lie on a line (area {area_m2:e} m²); collapse it or remesh")]
    Flat { area_m2: f64 },
    #[error(
        "the director ({}, {}, {}) at corner {corner} has the cosine {cos} to the facet's normal; \
         expected a unit vector with at least 0.5", director[0], director[1], director[2]
    )]
    Director { corner: usize, director: [f64; 3], cos: f64 },
    #[error("the wall at corner {corner} is {thickness_m} m; it must be finite and positive")]
    Thickness { corner: usize, thickness_m: f64 },
}
