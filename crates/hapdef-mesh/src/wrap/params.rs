//! How a surface is wrapped, and the lengths that follow from it.

use crate::{MeshError, SurfaceFault, SurfaceMesh};

/// How a surface is wrapped. What is `None` follows from the wall and the surface's length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WrapParams {
    /// The thickness t of the wall that is to fit inside the skin, m.
    pub wall_m: f64,
    /// The skin's edge length, m; by default a fortieth of the surface's length, 2 r at most. It is
    /// shortened by a quarter, up to four times, where no wall fits.
    pub edge_m: Option<f64>,
    /// The spacing of the grid that is flooded, m; by default t / 2, or 1/400 of the length if that
    /// is more.
    pub grid_m: Option<f64>,
    /// The radius r that corners are rounded to, convex and concave, m; by default 1.5 t, which a wall
    /// on the inner side needs to fit.
    pub round_over_m: Option<f64>,
    /// The closing δ, m, r at least: gaps up to twice this wide are bridged. By default 1.5 t, and
    /// 5 t where that is not faithful.
    pub close_m: Option<f64>,
    /// The largest share of the outside that may be farther than 1.1 r from the skin.
    pub max_lost_share: f64,
    /// The largest share of the skin that may be farther than 1.1 r from the surface as given.
    pub max_bridged_share: f64,
    /// Threads that distances are computed on.
    pub n_threads: usize,
}

impl WrapParams {
    /// Up to 5 % lost and a third bridged (a tube as long as wide has a third in its two openings);
    /// all threads that the machine has.
    #[must_use]
    pub fn new(wall_m: f64) -> Self {
        Self {
            wall_m,
            edge_m: None,
            grid_m: None,
            round_over_m: None,
            close_m: None,
            max_lost_share: 0.05,
            max_bridged_share: 1.0 / 3.0,
            n_threads: std::thread::available_parallelism().map_or(1, usize::from),
        }
    }

    /// All lengths, checked.
    pub(super) fn sizes(&self, soup: &SurfaceMesh) -> Result<Sizes, MeshError> {
        let length_m = soup.bounding_box().longest_m();
        let wall_m = self.wall_m;
        let round_over_m = self.round_over_m.unwrap_or(1.5 * wall_m);
        let sizes = Sizes {
            wall_m,
            edge_m: self.edge_m.unwrap_or((length_m / 40.0).min(2.0 * round_over_m)),
            grid_m: self.grid_m.unwrap_or((0.5 * wall_m).max(length_m / 400.0)),
            round_over_m,
            close_m: self.close_m.unwrap_or(round_over_m.max(1.5 * wall_m)),
            wider_m: self.close_m.is_none().then_some(5.0 * wall_m),
        };
        self.check(&sizes)?;
        Ok(sizes)
    }

    fn check(&self, sizes: &Sizes) -> Result<(), SurfaceFault> {
        let is_positive = |x: f64| x > 0.0 && x.is_finite();
        let is_share = |x: f64| (0.0..=1.0).contains(&x);
        let (r, close_m) = (sizes.round_over_m, sizes.close_m);
        let checks = [
            ("wall_m", self.wall_m, "above 0 and finite", is_positive(self.wall_m)),
            ("edge_m", sizes.edge_m, "above 0 and finite", is_positive(sizes.edge_m)),
            ("round_over_m", r, "above the wall and finite", r > self.wall_m && is_positive(r)),
            // A creaseless surface needs several points within r.
            (
                "grid_m",
                sizes.grid_m,
                "above 0 and at most the radius that corners are rounded to: thicken the wall",
                is_positive(sizes.grid_m) && sizes.grid_m <= r,
            ),
            // Below r the closed shape has creases that remeshing refuses.
            (
                "close_m",
                close_m,
                "at least the radius that corners are rounded to, and finite",
                close_m >= r && close_m.is_finite(),
            ),
            (
                "max_lost_share",
                self.max_lost_share,
                "between 0 and 1",
                is_share(self.max_lost_share),
            ),
            (
                "max_bridged_share",
                self.max_bridged_share,
                "between 0 and 1",
                is_share(self.max_bridged_share),
            ),
            ("n_threads", self.n_threads as f64, "at least 1", self.n_threads > 0),
        ];
        match checks.into_iter().find(|check| !check.3) {
            Some((name, found, wanted, _)) => Err(SurfaceFault::Parameter { name, found, wanted }),
            None => Ok(()),
        }
    }
}

/// The lengths of one wrap, m, as [`WrapParams`] names them.
pub(super) struct Sizes {
    pub wall_m: f64,
    pub edge_m: f64,
    pub grid_m: f64,
    pub round_over_m: f64,
    pub close_m: f64,
    /// What δ is where the first one is not faithful.
    pub wider_m: Option<f64>,
}

impl Sizes {
    /// Farther than this from the other surface a place counts as lost or bridged, m.
    pub(super) fn far_m(&self) -> f64 {
        1.1 * self.round_over_m
    }
}
