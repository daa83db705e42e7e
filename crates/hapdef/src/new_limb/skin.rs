//! A surface to a skin with a wall that fits: as it is where it is clean, else wrapped.

use hapdef_mesh::{
    CleanParams, MeshError, RemeshParams, SkinSide, SurfaceDefects, SurfaceFault, SurfaceMesh,
    WrapParams, Wrapped, clean_surface, remesh, wrap,
};

use crate::error::HapdefError;
use crate::skin_solid::{WELD_M, extruded};

/// Edges along the longest extent where no edge length is given.
const EDGES_ALONG: f64 = 40.0;

/// What the edge length is multiplied with while no wall fits, and how often.
const SHORTER: f64 = 0.75;
const MAX_SHORTENED: usize = 2;

/// An open surface must enclose this much with its openings closed, as a part of its area to the power
/// 3/2: a tube five times as long as wide has 0.09, a sheet 0; nothing tells which side of that is outside.
const LEAST_ENCLOSED: f64 = 0.01;

/// A skin that a wall fits into.
#[derive(Debug)]
pub(super) struct Skin {
    pub(super) surface: SurfaceMesh,
    /// The wall at each vertex, inward `[n_vertices]`, m.
    pub(super) wall_m: Vec<f64>,
    /// How it was made, a sentence each.
    pub(super) said: Vec<String>,
}

impl Skin {
    /// The skin of `given`: cleaned and remeshed, or wrapped where that gives no body that a wall fits
    /// into.
    ///
    /// # Errors
    /// [`HapdefError::Mesh`] for a surface that can't be wrapped faithfully, [`HapdefError::Sheet`] for one
    /// without an outside.
    pub(super) fn of(
        given: &SurfaceMesh,
        wall_m: f64,
        edge_m: Option<f64>,
        n_threads: usize,
    ) -> Result<Self, HapdefError> {
        match Self::as_it_is(given, wall_m, edge_m) {
            Err(HapdefError::Mesh(MeshError::Surface(why))) => {
                let params = WrapParams { edge_m, n_threads, ..WrapParams::new(wall_m) };
                let mut skin = Self::wrapped(wrap(given, &params)?);
                skin.said.insert(0, format!("wrapped, as it can't be taken as it is: {why}"));
                Ok(skin)
            }
            result => result,
        }
    }

    fn wrapped(Wrapped { skin, wall_m, info }: Wrapped) -> Self {
        let n = skin.triangles().len();
        let mm = [info.edge_m, info.skin_to_input_m, info.round_over_m].map(|x_m| 1e3 * x_m);
        let mut said = vec![
            format!(
                "{n} triangles with edges of {:.1} mm, 95 % of them within {:.2} mm of the surface; \
                 corners rounded by {:.1} mm",
                mm[0], mm[1], mm[2]
            ),
            format!(
                "{:.1} % of the outside lost, as it is thin; {:.1} % of the skin bridges gaps",
                100.0 * info.share_lost,
                100.0 * info.share_bridged
            ),
        ];
        if info.n_thinned > 0 {
            said.push(format!(
                "the wall is thinner at {} vertices, where it would fold",
                info.n_thinned
            ));
        }
        Self { surface: skin, wall_m, said }
    }

    fn as_it_is(
        given: &SurfaceMesh,
        wall_m: f64,
        edge_m: Option<f64>,
    ) -> Result<Self, HapdefError> {
        let (surface, mut said) = cleaned(given)?;
        let (surface, edge_m) = remeshed(&surface, wall_m, edge_m)?;
        let (n, mm) = (surface.triangles().len(), 1e3 * edge_m);
        said.push(format!("remeshed to {n} triangles with edges of {mm:.1} mm"));
        Ok(Self { wall_m: vec![wall_m; surface.vertices().len()], surface, said })
    }
}

/// One oriented body without seams, doubled or degenerate triangles.
fn cleaned(given: &SurfaceMesh) -> Result<(SurfaceMesh, Vec<String>), HapdefError> {
    let params = CleanParams {
        weld_tolerance_m: Some(WELD_M),
        drop_degenerate: true,
        drop_doubled: true,
        orient: true,
        ..CleanParams::default()
    };
    let (surface, info) = clean_surface(given, &params)?;
    if !info.after.is_manifold() {
        let defects = Box::new(info.after);
        let fault = SurfaceFault::Defects { wanted: "a manifold surface", defects };
        return Err(MeshError::from(fault).into());
    }
    if info.body_volumes_m3.len() != 1 {
        let fault = SurfaceFault::Bodies { volumes_m3: info.body_volumes_m3 };
        return Err(MeshError::from(fault).into());
    }
    check_encloses(&surface, &info.after)?;
    let counts = [
        (info.n_degenerate_dropped + info.n_collapsed_triangles, "triangles without area dropped"),
        (info.n_doubled_dropped, "doubled triangles dropped"),
        (info.n_turned, "triangles turned over"),
        (info.after.open_edges.n, "open edges: the wall has rims there"),
    ];
    let counts = counts.iter().filter(|(n, _)| *n > 0);
    Ok((surface, counts.map(|(n, what)| format!("{n} {what}")).collect()))
}

/// Refuses a sheet, of which nothing says where its outside is.
fn check_encloses(surface: &SurfaceMesh, defects: &SurfaceDefects) -> Result<(), HapdefError> {
    let centre = surface.bounding_box().centre();
    let flux = |t: usize| (surface.corners(t)[0] - centre).dot(&surface.area_normal_m2(t)) / 3.0;
    let volume_m3: f64 = (0..surface.triangles().len()).map(flux).sum();
    let share = volume_m3 / surface.area_m2().powf(1.5);
    if defects.is_closed() || share >= LEAST_ENCLOSED {
        return Ok(());
    }
    Err(HapdefError::Sheet { n_open_edges: defects.open_edges.n })
}

/// The surface with edges of one length that the wall fits behind, and that length.
fn remeshed(
    surface: &SurfaceMesh,
    wall_m: f64,
    edge_m: Option<f64>,
) -> Result<(SurfaceMesh, f64), MeshError> {
    let mut target_m = edge_m.unwrap_or(surface.bounding_box().longest_m() / EDGES_ALONG);
    let made = |target_m| {
        let (skin, _) = remesh(surface, &RemeshParams::new(target_m))?;
        extruded(&skin, &vec![wall_m; skin.vertices().len()], SkinSide::Outer)?;
        Ok(skin)
    };
    for _ in 0..MAX_SHORTENED {
        match made(target_m) {
            Err(MeshError::Surface(_)) if edge_m.is_none() => target_m *= SHORTER,
            result => return result.map(|skin| (skin, target_m)),
        }
    }
    made(target_m).map(|skin| (skin, target_m))
}
