//! From a surface to the wall: cleaned as asked, measured if asked, remeshed, moved to mid-wall.

use hapdef_mesh::{
    MeshError, PointIndex, RemeshInfo, RemeshParams, ShellSurface, SkinSide, SolidShell,
    SolidShellParams, SurfaceDefects, SurfaceFault, SurfaceMesh, clean_surface, remesh,
    shell_from_solid,
};

use super::info::{MeasuredWall, SurfaceCounts, WallInfo, quartiles};
use super::stopwatch::Stopwatch;
use super::{ShellLimbParams, WallChoice};
use crate::error::HapdefError;

/// Edges along the longest extent where no edge length is given.
const EDGES_ALONG: f64 = 40.0;

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
        let edge_m = params
            .edge_m
            .unwrap_or(cleaned.bounding_box().longest_m() / EDGES_ALONG);
        let remesh_params = RemeshParams::new(edge_m);
        let made = match params.wall {
            WallChoice::Constant(thickness_m) => {
                let (skin, info) = remesh(&cleaned, &remesh_params)?;
                watch.lap("remesh");
                let thickness_m = vec![thickness_m; skin.vertices().len()];
                Made {
                    skin,
                    thickness_m,
                    info,
                    side: params.side,
                    measured: None,
                }
            }
            WallChoice::Measured => {
                let found = shell_from_solid(&cleaned, &SolidShellParams::default())?;
                watch.lap("measure");
                let (skin, info) = remesh(&found.skin, &remesh_params)?;
                watch.lap("remesh");
                Made {
                    thickness_m: carried(&found, &skin)?,
                    skin,
                    info,
                    side: SkinSide::Outer,
                    measured: Some(measured_wall(&found)),
                }
            }
        };
        let shell = ShellSurface::from_skin(&made.skin, &made.thickness_m, made.side);
        let shell = shell.map_err(advise_on_folds)?;
        watch.lap("mid-wall");
        let count = |mesh: &SurfaceMesh, defects: &SurfaceDefects| {
            SurfaceCounts::new(mesh.vertices().len(), mesh.triangles().len(), defects)
        };
        let info = WallInfo {
            given: count(given, &clean.before),
            cleaned: count(&cleaned, &clean.after),
            n_welded_vertices: clean.n_welded_vertices,
            n_dropped_triangles: [
                clean.n_collapsed_triangles,
                clean.n_degenerate_dropped,
                clean.n_doubled_dropped,
                clean.n_other_body_triangles,
            ],
            body_volumes_m3: clean.body_volumes_m3,
            measured: made.measured,
            remeshed: count(&made.skin, &SurfaceDefects::of(&made.skin)),
            target_edge_m: edge_m,
            edge_quantiles_m: made.info.edge_quantiles_m,
            distance_m: made.info.distance.largest_m(),
            volume_change: made.info.volume_change(),
            side: name_of(made.side),
            thickness_quantiles_m: quartiles(made.thickness_m.iter().copied()),
            wall_volume_m3: shell.volume_m3(),
        };
        Ok(Self {
            skin: made.skin,
            side: made.side,
            shell,
            info,
        })
    }
}

struct Made {
    skin: SurfaceMesh,
    thickness_m: Vec<f64>,
    info: RemeshInfo,
    side: SkinSide,
    measured: Option<MeasuredWall>,
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
