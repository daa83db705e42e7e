//! Dirty surfaces to one closed skin that a wall fits into.
//!
//! The input is a soup: doubled, inverted and crossing triangles, inner bodies and gaps don't matter,
//! as only unsigned distances to it are asked for. The skin is what remains of the outside after a
//! closing by δ and an opening by r (Serra, Image Analysis and Mathematical Morphology, 1982):
//!
//! 1. flood {u > δ} from outside, u the distance to the soup: what isn't reached is inside;
//! 2. the core is what lies deeper than r inside the closed shape, which is deeper than δ + r below
//!    the flood's edge;
//! 3. the skin is the surface at the distance r from the core, remeshed.
//!
//! Nothing is silent: [`WrapInfo`] has the places that were lost or bridged, and a skin that strays
//! is refused with a [`WrapFault`] that has them, too.

mod caps;
mod distance;
mod fault;
mod fidelity;
mod field;
mod grid;
mod info;
mod input;
mod level_set;
mod params;
mod places;
mod skin;
mod thin;

pub use fault::WrapFault;
pub use info::{WrapInfo, WrapSeconds, Wrapped};
pub use params::WrapParams;
pub use places::WrapPlaces;

use self::input::Input;
use self::params::Sizes;
use crate::{MeshError, SurfaceMesh};

/// The skin of a soup of triangles (m), with a wall that fits into it.
///
/// Openings are capped first. The skin is rounded, convex and concave, by the radius r, which is
/// 1.5 times the wall: whatever is thinner than 2 r goes, and gaps narrower than 2 δ are bridged. Where the
/// wall would fold it is thinned at 0.5 % of the vertices at most. The result is the same on any
/// number of threads.
///
/// # Errors
/// [`MeshError::Wrap`]: nothing thick enough is enclosed, more than allowed is lost or bridged, or
/// no edge length gives a skin that the wall fits into. [`MeshError::Surface`]: a bad parameter.
pub fn wrap(soup: &SurfaceMesh, params: &WrapParams) -> Result<Wrapped, MeshError> {
    let sizes = params.sizes(soup)?;
    let threads = rayon::ThreadPoolBuilder::new().num_threads(params.n_threads).build();
    let threads = threads.map_err(|cause| WrapFault::Threads { cause: cause.to_string() })?;
    threads.install(|| faithful(soup, params, &sizes))
}

/// The first of the closings that gives a faithful skin, or the fault of the one that loses least.
fn faithful(soup: &SurfaceMesh, params: &WrapParams, sizes: &Sizes) -> Result<Wrapped, MeshError> {
    let input = Input::new(soup, sizes)?;
    let (first_m, wider_m) = (sizes.close_m, sizes.wider_m);
    let first = match skin::of_closing(&input, params, sizes, first_m) {
        Err(MeshError::Wrap(fault)) => fault,
        other => return other,
    };
    let Some(wider_m) = wider_m.filter(|wider_m| *wider_m > first_m) else {
        return Err(first.into());
    };
    match skin::of_closing(&input, params, sizes, wider_m) {
        Err(MeshError::Wrap(second)) if first.share_lost() <= second.share_lost() => {
            Err(first.into())
        }
        other => other,
    }
}
