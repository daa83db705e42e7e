//! What makes a triangle unusable as a shell element.

/// Why a shell element is not usable.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ShellElementProblem {
    /// The three nodes lie on a line.
    #[error("its nodes lie on a line (area {area_m2:e} m²); collapse it or remesh")]
    Flat {
        /// The triangle's area, m².
        area_m2: f64,
    },
    /// A director that is not a unit vector within 60° of the facet's normal.
    #[error(
        "the director ({}, {}, {}) at corner {corner} has the cosine {cos} to the facet's normal; \
         expected a unit vector with at least 0.5", director[0], director[1], director[2]
    )]
    Director {
        /// The corner, 0..3.
        corner: usize,
        /// The director found.
        director: [f64; 3],
        /// Cosine of its angle to the facet's normal.
        cos: f64,
    },
    /// A thickness that is not finite and positive.
    #[error("the wall at corner {corner} is {thickness_m} m; it must be finite and positive")]
    Thickness {
        /// The corner, 0..3.
        corner: usize,
        /// The thickness found, m.
        thickness_m: f64,
    },
}
