//! A surface to a skin with a wall that fits: as it is where it is clean, else wrapped.

use std::path::Path;

use hapdef_mesh::{
    CleanParams, MeshError, PointIndex, RemeshParams, SkinSide, SolidShellInfo, SolidShellParams,
    SurfaceDefects, SurfaceFault, SurfaceMesh, WrapParams, Wrapped, clean_surface, remesh,
    shell_from_solid, wrap, write_glb,
};
use nalgebra::Point3;

use super::text::write_text;
use crate::error::HapdefError;
use crate::scene::WallThickness;
use crate::skin_solid::{SkinSolid, WELD_M};
use crate::wall_shell::WallShell;

/// The files of a skin and its wall.
pub(crate) const SKIN: &str = "skin.glb";
pub(crate) const WALL: &str = "wall.txt";

/// Edges along the longest extent where no edge length is given.
const EDGES_ALONG: f64 = 40.0;

/// What the edge length is multiplied with while no wall fits, and how often.
const SHORTER: f64 = 0.75;
const MAX_SHORTENED: usize = 2;

/// An open surface must enclose this much with its openings closed, as a part of its area to the power
/// 3/2: a tube five times as long as wide has 0.09, a sheet 0; nothing tells which side of that is outside.
const LEAST_ENCLOSED: f64 = 0.01;

/// How thick the wall of a surface is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WallChoice {
    /// The same everywhere, m: the surface is a skin.
    Constant(f64),
    /// As measured: the surface is a closed solid with an outer and an inner wall.
    Measured,
}

/// How a surface becomes a skin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SkinParams {
    /// What is done to the surface first.
    pub(crate) clean: CleanParams,
    pub(crate) wall: WallChoice,
    /// Which side of the wall the surface is.
    pub(crate) side: SkinSide,
    /// The edge length wanted, m.
    pub(crate) edge_m: Option<f64>,
    /// Whether the middle of the wall must fit, too.
    pub(crate) is_shell: bool,
    pub(crate) n_threads: usize,
}

/// A skin that a wall fits into.
#[derive(Debug)]
pub(crate) struct Skin {
    pub(crate) surface: SurfaceMesh,
    /// The wall at each vertex `[n_vertices]`, m.
    pub(crate) wall_m: Vec<f64>,
    pub(crate) edge_m: f64,
    /// How it was made, a sentence each.
    pub(crate) said: Vec<String>,
}

impl SkinParams {
    /// All repairs that keep a surface what it is, for a wall inward.
    pub(crate) fn repaired(wall_m: f64, edge_m: Option<f64>, n_threads: usize) -> Self {
        let clean = CleanParams {
            weld_tolerance_m: Some(WELD_M),
            drop_degenerate: true,
            drop_doubled: true,
            orient: true,
            ..CleanParams::default()
        };
        let (wall, side) = (WallChoice::Constant(wall_m), SkinSide::Outer);
        Self { clean, wall, side, edge_m, is_shell: false, n_threads }
    }
}

impl Skin {
    /// The skin of `given`: cleaned and remeshed, or wrapped where that gives no body that a wall of a
    /// given thickness fits into.
    ///
    /// # Errors
    /// [`HapdefError::Mesh`] for a surface that can't be wrapped faithfully or has no wall that could be
    /// measured, [`HapdefError::Sheet`] for one without an outside.
    pub(crate) fn of(given: &SurfaceMesh, params: &SkinParams) -> Result<Self, HapdefError> {
        let mut skin = Self::exactly_of(given, params)?;
        // as a file has it: where faces meet, rounding decides which of them a part of a gauge is on
        let rounded = |place: &Point3<f64>| place.map(|x| f64::from(x as f32));
        let vertices = skin.surface.vertices().iter().map(rounded).collect();
        skin.surface = SurfaceMesh::new(vertices, skin.surface.triangles().to_vec())?;
        Ok(skin)
    }

    fn exactly_of(given: &SurfaceMesh, params: &SkinParams) -> Result<Self, HapdefError> {
        match (Self::as_it_is(given, params), params.wall) {
            (Err(HapdefError::Mesh(MeshError::Surface(why))), WallChoice::Constant(wall_m)) => {
                let (edge_m, n_threads) = (params.edge_m, params.n_threads);
                let wrapping = WrapParams { edge_m, n_threads, ..WrapParams::new(wall_m) };
                let mut skin = match wrap(given, &wrapping) {
                    Ok(wrapped) => Self::wrapped(wrapped),
                    Err(_) if is_fold(&MeshError::Surface(why.clone())) => {
                        return Err(MeshError::Surface(why).into());
                    }
                    Err(error) => return Err(error.into()),
                };
                skin.said.insert(0, format!("wrapped, as it can't be taken as it is: {why}"));
                Ok(skin)
            }
            (result, _) => result,
        }
    }

    /// Writes the skin, and the thickness of its wall at all vertices where it is not everywhere the same,
    /// into `folder`; the wall as a scene has it.
    ///
    /// # Errors
    /// [`HapdefError::File`] and [`HapdefError::Mesh`] when the disk refuses.
    pub(crate) fn write(&self, folder: &Path) -> Result<WallThickness, HapdefError> {
        write_glb(&folder.join(SKIN), &self.surface, None)?;
        if self.wall_m.iter().all(|wall_m| *wall_m == self.wall_m[0]) {
            return Ok(WallThickness::Constant(self.wall_m[0]));
        }
        let lines: String = self.wall_m.iter().map(|wall_m| format!("{wall_m:.7}\n")).collect();
        write_text(&folder.join(WALL), &lines)?;
        Ok(WallThickness::File(WALL.into()))
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
        Self { surface: skin, wall_m, edge_m: info.edge_m, said }
    }

    fn as_it_is(given: &SurfaceMesh, params: &SkinParams) -> Result<Self, HapdefError> {
        let (surface, mut said) = cleaned(given, params)?;
        let (skin, wall_m, edge_m) = match params.wall {
            WallChoice::Constant(wall_m) => {
                remeshed(&surface, params, &|skin| vec![wall_m; skin.vertices().len()])?
            }
            WallChoice::Measured => {
                let found = shell_from_solid(&surface, &SolidShellParams::default())?;
                said.push(measured(&found.info));
                let index = PointIndex::new(found.skin.vertices());
                let nearest = |place: &Point3<f64>| {
                    index.nearest(place).map_or(0.0, |(v, _)| found.thickness_m[v])
                };
                let carried = |skin: &SurfaceMesh| skin.vertices().iter().map(nearest).collect();
                remeshed(&found.skin, params, &carried)?
            }
        };
        let (n, mm) = (skin.triangles().len(), 1e3 * edge_m);
        said.push(format!("remeshed to {n} triangles with edges of {mm:.1} mm"));
        Ok(Self { surface: skin, wall_m, edge_m, said })
    }
}

fn measured(info: &SolidShellInfo) -> String {
    let percent = |share: f64| 100.0 * share;
    format!(
        "{:.1} % of the outer skin is no shell: {:.1} % solid core, {:.1} % without a parallel wall, \
         {:.1} % too thick, {:.1} % in islands; the solid has {:.3} cm³, its shell {:.3} cm³",
        percent(info.not_shell_share),
        percent(info.solid_core_share),
        percent(info.no_wall_share),
        percent(info.too_thick_share),
        percent(info.island_share),
        1e6 * info.solid_volume_m3,
        1e6 * info.shell_volume_m3
    )
}

/// The surface cleaned as asked: of a skin one oriented body.
fn cleaned(
    given: &SurfaceMesh,
    params: &SkinParams,
) -> Result<(SurfaceMesh, Vec<String>), HapdefError> {
    let (surface, info) = clean_surface(given, &params.clean)?;
    if !info.after.is_manifold() {
        let defects = Box::new(info.after);
        let fault = SurfaceFault::Defects { wanted: "a manifold surface", defects };
        return Err(MeshError::from(fault).into());
    }
    if params.wall != WallChoice::Measured {
        let n_bodies = info.body_volumes_m3.len();
        if n_bodies != 1 && info.n_other_body_triangles == 0 {
            let fault = SurfaceFault::Bodies { volumes_m3: info.body_volumes_m3 };
            return Err(MeshError::from(fault).into());
        }
        check_encloses(&surface, &info.after)?;
    }
    let counts = [
        (info.n_degenerate_dropped + info.n_collapsed_triangles, "triangles without area dropped"),
        (info.n_doubled_dropped, "doubled triangles dropped"),
        (info.n_other_body_triangles, "triangles of other bodies dropped"),
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

/// The surface with edges of one length that its wall fits behind, that wall and that length.
fn remeshed(
    surface: &SurfaceMesh,
    params: &SkinParams,
    wall_of: &dyn Fn(&SurfaceMesh) -> Vec<f64>,
) -> Result<(SurfaceMesh, Vec<f64>, f64), HapdefError> {
    let edge_m = params.edge_m;
    let mut target_m = edge_m.unwrap_or(surface.bounding_box().longest_m() / EDGES_ALONG);
    let made = |target_m| {
        let (skin, _) = remesh(surface, &RemeshParams::new(target_m))?;
        let wall_m = wall_of(&skin);
        let solid = SkinSolid::of(&skin, &wall_m, params.side)?;
        if params.is_shell {
            let (outside, thickness_m) = solid.outside.region(&solid.deck.mesh)?;
            WallShell::new(&solid.deck.mesh, &outside, &thickness_m)?;
        }
        Ok((skin, wall_m, target_m))
    };
    for _ in 0..MAX_SHORTENED {
        match made(target_m) {
            Err(HapdefError::Mesh(MeshError::Surface(_))) if edge_m.is_none() => {
                target_m *= SHORTER;
            }
            result => return result,
        }
    }
    made(target_m)
}

/// Whether a wall is too thick for its skin.
pub(crate) fn is_fold(error: &MeshError) -> bool {
    use SurfaceFault::{ExtrusionFolds, OffsetFolds};
    matches!(error, MeshError::Surface(OffsetFolds { .. } | ExtrusionFolds { .. }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box of 40 x 30 x 50 mm.
    fn block() -> SurfaceMesh {
        let corner = |i: u32| {
            let [x, y, z] = [i & 1, i >> 1 & 1, i >> 2].map(f64::from);
            Point3::new(0.04 * x, 0.03 * y, 0.05 * z)
        };
        let faces = vec![
            [0, 2, 1],
            [1, 2, 3],
            [4, 5, 6],
            [5, 7, 6],
            [0, 1, 4],
            [1, 5, 4],
            [2, 6, 3],
            [3, 6, 7],
            [0, 4, 2],
            [2, 4, 6],
            [1, 3, 5],
            [3, 7, 5],
        ];
        SurfaceMesh::new((0..8).map(corner).collect(), faces).unwrap()
    }

    #[test]
    fn a_wall_that_was_thinned_is_said() {
        let params = WrapParams { edge_m: Some(0.004), ..WrapParams::new(0.002) };
        let mut wrapped = wrap(&block(), &params).unwrap();
        wrapped.info.n_thinned = 3;
        let said = Skin::wrapped(wrapped.clone()).said.join("; ");
        assert!(said.contains("the wall is thinner at 3 vertices, where it would fold"), "{said}");
        wrapped.info.n_thinned = 0;
        assert!(!Skin::wrapped(wrapped).said.join("; ").contains("would fold"));
    }
}
