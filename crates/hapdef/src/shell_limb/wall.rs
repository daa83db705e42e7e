//! From a surface to the wall: cleaned as asked, measured if asked, remeshed, moved to mid-wall.

use hapdef_mesh::{
    MeshError, PointIndex, RemeshInfo, RemeshParams, ShellSurface, SkinSide, SolidShell,
    SolidShellParams, SurfaceDefects, SurfaceFault, SurfaceMesh, clean_surface, remesh,
    shell_from_solid,
};

use super::info::{EdgeRefused, MeasuredWall, SurfaceCounts, WallInfo, quartiles};
use super::stopwatch::Stopwatch;
use super::{ShellLimbParams, WallChoice};
use crate::error::HapdefError;

/// Edges along the longest extent where no edge length is given.
const EDGES_ALONG: f64 = 40.0;

/// Halvings of that edge length, at most, while the remeshed skin strays or folds.
const MAX_HALVINGS: usize = 2;

/// A skin and the shell of its wall; vertex `i` of both is node `i`.
pub(super) struct Wall {
    pub skin: SurfaceMesh,
    pub side: SkinSide,
    pub shell: ShellSurface,
    pub info: WallInfo,
}

impl Wall {
    pub fn new(
        given: &SurfaceMesh,
        params: &ShellLimbParams,
        watch: &mut Stopwatch,
    ) -> Result<Self, HapdefError> {
        let (cleaned, clean) = clean_surface(given, &params.clean)?;
        watch.lap("clean");
        let source = Source::new(cleaned, params)?;
        if source.found.is_some() {
            watch.lap("measure");
        }
        let (made, edge_m, edges_refused) = source.remeshed(params)?;
        watch.lap("remesh");
        let count = |mesh: &SurfaceMesh, defects: &SurfaceDefects| {
            SurfaceCounts::new(mesh.vertices().len(), mesh.triangles().len(), defects)
        };
        let info = WallInfo {
            given: count(given, &clean.before),
            cleaned: count(&source.cleaned, &clean.after),
            n_welded_vertices: clean.n_welded_vertices,
            n_dropped_triangles: [
                clean.n_collapsed_triangles,
                clean.n_degenerate_dropped,
                clean.n_doubled_dropped,
                clean.n_other_body_triangles,
            ],
            n_turned_triangles: clean.n_turned,
            body_volumes_m3: clean.body_volumes_m3,
            measured: source.found.as_ref().map(measured_wall),
            remeshed: count(&made.skin, &SurfaceDefects::of(&made.skin)),
            target_edge_m: edge_m,
            edges_refused,
            edge_quantiles_m: made.info.edge_quantiles_m,
            distance_m: made.info.distance.largest_m(),
            area_before_remesh_m2: made.info.area_m2[0],
            volume_change: made.info.volume_change(),
            side: name_of(source.side),
            thickness_quantiles_m: quartiles(made.shell.thickness_m().iter().copied()),
            wall_volume_m3: made.shell.volume_m3(),
        };
        Ok(Self { skin: made.skin, side: source.side, shell: made.shell, info })
    }
}

/// The surface as cleaned, and the wall found in it where it is measured.
struct Source {
    cleaned: SurfaceMesh,
    found: Option<SolidShell>,
    side: SkinSide,
    constant_m: f64,
}

/// A remeshed skin and its shell.
struct Made {
    skin: SurfaceMesh,
    shell: ShellSurface,
    info: RemeshInfo,
}

impl Source {
    fn new(cleaned: SurfaceMesh, params: &ShellLimbParams) -> Result<Self, HapdefError> {
        let (found, side, constant_m) = match params.wall {
            WallChoice::Constant(thickness_m) => (None, params.side, thickness_m),
            WallChoice::Measured => {
                let found = shell_from_solid(&cleaned, &SolidShellParams::default())?;
                (Some(found), SkinSide::Outer, 0.0)
            }
        };
        Ok(Self { cleaned, found, side, constant_m })
    }

    /// The skin and shell with the edge length asked for; where none is, with the default one,
    /// halved while the result strays or folds. Also which edge lengths were refused, and why.
    fn remeshed(
        &self,
        params: &ShellLimbParams,
    ) -> Result<(Made, f64, Vec<EdgeRefused>), HapdefError> {
        let longest_m = self.cleaned.bounding_box().longest_m();
        let mut edge_m = params.edge_m.unwrap_or(longest_m / EDGES_ALONG);
        let mut refused = Vec::new();
        loop {
            match self.made(edge_m) {
                Ok(made) => return Ok((made, edge_m, refused)),
                Err(error) if params.edge_m.is_some() || refused.len() == MAX_HALVINGS => {
                    return Err(advise_on_folds(error));
                }
                Err(MeshError::Surface(
                    cause @ (SurfaceFault::OffsetFolds { .. } | SurfaceFault::RemeshStrays { .. }),
                )) => refused.push(EdgeRefused { edge_m, cause: cause.to_string() }),
                Err(error) => return Err(error.into()),
            }
            edge_m *= 0.5;
        }
    }

    fn made(&self, edge_m: f64) -> Result<Made, MeshError> {
        let given = self.found.as_ref().map_or(&self.cleaned, |f| &f.skin);
        let (skin, info) = remesh(given, &RemeshParams::new(edge_m))?;
        let thickness_m = match &self.found {
            Some(found) => carried(found, &skin)?,
            None => vec![self.constant_m; skin.vertices().len()],
        };
        let shell = ShellSurface::from_skin(&skin, &thickness_m, self.side)?;
        Ok(Made { skin, shell, info })
    }
}

/// The thickness at each vertex of the remeshed skin: that of the nearest vertex measured at.
fn carried(found: &SolidShell, skin: &SurfaceMesh) -> Result<Vec<f64>, MeshError> {
    let index = PointIndex::new(found.skin.vertices());
    let thickness = |(node, place)| match index.nearest(place) {
        Some((nearest, _)) => Ok(found.thickness_m[nearest]),
        None => Err(SurfaceFault::NoNormal { node }.into()),
    };
    skin.vertices().iter().enumerate().map(thickness).collect()
}

fn measured_wall(found: &SolidShell) -> MeasuredWall {
    let info = &found.info;
    MeasuredWall {
        not_shell_share: info.not_shell_share,
        solid_core_share: info.solid_core_share,
        no_wall_share: info.no_wall_share,
        too_thick_share: info.too_thick_share,
        island_share: info.island_share,
        solid_volume_m3: info.solid_volume_m3,
        shell_volume_m3: info.shell_volume_m3,
    }
}

fn advise_on_folds(error: MeshError) -> HapdefError {
    match error {
        MeshError::Surface(SurfaceFault::OffsetFolds { .. }) => HapdefError::WallFolds(error),
        other => other.into(),
    }
}

fn name_of(side: SkinSide) -> &'static str {
    match side {
        SkinSide::Outer => "outer",
        SkinSide::Middle => "middle",
        SkinSide::Inner => "inner",
    }
}
