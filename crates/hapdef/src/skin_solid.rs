//! From a skin and the thickness of its wall to a solid.

use std::path::Path;

use hapdef_bench::stats;
use hapdef_mesh::{
    CleanParams, ExtrudeParams, Extrusion, FaceCurve, GltfParams, LengthUnit, MeshError,
    RefinedSolid, SkinRegion, SkinSide, SolidDeck, SurfaceFault, SurfaceMesh, Tet10Mesh, Tri6Face,
    clean_surface, extrude, read_surface,
};

use crate::error::HapdefError;
use crate::scene::{SkinShape, WallRegions, WallThickness};

/// Vertices no farther apart than this are one, m: seams that an exporter split.
pub(crate) const WELD_M: f64 = 1e-6;

/// Triangles that meet at more than this meet in an edge that stays sharp, rad: 40°.
const FEATURE_ANGLE_RAD: f64 = 40.0 * std::f64::consts::PI / 180.0;

/// Walls thicker than this many median edges get two layers of wedges.
const MAX_LAYER_PER_EDGE: f64 = 1.0;

/// A wall of ten-node tetrahedra.
pub(crate) struct SkinSolid {
    /// The mesh, as a deck that states nothing else.
    pub(crate) deck: SolidDeck,
    /// The wall's outside.
    pub(crate) outside: Outside,
    /// The wall where it is thickest, m.
    pub(crate) thickest_m: f64,
}

/// The outside of a wall, as faces of its solid.
pub(crate) struct Outside {
    pub(crate) faces: Vec<Tri6Face>,
    /// How thick the wall is at each node of the solid `[n_fe_nodes]`, m; 0 at those not outside.
    pub(crate) thickness_m: Vec<f64>,
}

impl Outside {
    /// The same as a region of the solid, and how thick the wall is at its nodes `[region.nodes]`, m.
    ///
    /// # Errors
    /// As [`SkinRegion::new`].
    pub(crate) fn region(&self, solid: &Tet10Mesh) -> Result<(SkinRegion, Vec<f64>), MeshError> {
        let region = SkinRegion::new(solid, self.faces.clone())?;
        let thickness_m = region.nodes.iter().map(|node| self.thickness_m[node.index()]).collect();
        Ok((region, thickness_m))
    }

    /// The outside of the solid refined.
    pub(crate) fn refined(mut self, refined: &RefinedSolid) -> Self {
        self.faces = refined.faces(&self.faces);
        self.thickness_m.resize(refined.mesh.nodes().len(), 0.0);
        self.with_middles()
    }

    /// The same with the means of the ends in the middle of edges.
    fn with_middles(mut self) -> Self {
        for face in &self.faces {
            for (middle, [a, b]) in [(3, [0, 1]), (4, [1, 2]), (5, [2, 0])] {
                let ends = [a, b].map(|i| self.thickness_m[face.nodes[i].index()]);
                self.thickness_m[face.nodes[middle].index()] = 0.5 * (ends[0] + ends[1]);
            }
        }
        self
    }
}

impl SkinSolid {
    /// The wall that a scene's geometry describes, in metres.
    ///
    /// # Errors
    /// [`HapdefError::SkinNotClean`] for a surface that is not one oriented body,
    /// [`HapdefError::SkinWall`] for thicknesses that don't fit it, [`HapdefError::SkinFolds`] for a
    /// wall that folds or crosses; [`HapdefError::Mesh`] for a file that can't be read.
    pub(crate) fn load(
        skin: &SkinShape,
        unit: LengthUnit,
        scene_dir: &Path,
    ) -> Result<Self, HapdefError> {
        let path = scene_dir.join(&skin.file);
        let surface = read_clean(&path, unit)?;
        let thickness_m = match &skin.wall {
            WallThickness::Constant(wall_m) => vec![*wall_m; surface.vertices().len()],
            WallThickness::File(file) => {
                read_thickness(&scene_dir.join(file), surface.vertices().len())?
            }
            WallThickness::Regions(regions) => by_region(&path, &surface, regions)?,
        };
        Self::of(&surface, &thickness_m, skin.side.into())
            .map_err(|source| HapdefError::SkinFolds { path, source })
    }

    /// The wall of a clean skin, `thickness_m` `[n_vertices]` thick.
    ///
    /// # Errors
    /// As [`extrude`].
    pub(crate) fn of(
        surface: &SurfaceMesh,
        thickness_m: &[f64],
        side: SkinSide,
    ) -> Result<Self, MeshError> {
        let wall = extruded(surface, thickness_m, side)?;
        let mut at_nodes_m = vec![0.0; wall.mesh.nodes().len()];
        for (vertex, wall_m) in thickness_m.iter().enumerate() {
            at_nodes_m[wall.node(vertex as u32, 0).index()] = *wall_m;
        }
        let outside = Outside { faces: level_faces(&wall, 0), thickness_m: at_nodes_m };
        Ok(Self {
            outside: outside.with_middles(),
            deck: deck_of(wall),
            thickest_m: thickness_m.iter().copied().fold(0.0, f64::max),
        })
    }
}

/// The wall behind a clean skin, `thickness_m` `[n_vertices]` thick: curved between the skin's vertices
/// but at sharp edges, of one layer of wedges, of two where it is thicker than the skin's edges are long.
///
/// # Errors
/// As [`extrude`].
fn extruded(
    skin: &SurfaceMesh,
    thickness_m: &[f64],
    side: SkinSide,
) -> Result<Extrusion, MeshError> {
    let thickest_m = thickness_m.iter().copied().fold(0.0, f64::max);
    let is_thick = thickest_m > MAX_LAYER_PER_EDGE * median_edge_m(skin);
    let params = ExtrudeParams {
        side,
        n_layers: 1 + usize::from(is_thick),
        curve: FaceCurve::PointNormal { feature_angle_rad: FEATURE_ANGLE_RAD },
    };
    extrude(skin, thickness_m, &params)
}

/// Boundary faces of a wall whose corners are all on one level.
fn level_faces(wall: &Extrusion, level: usize) -> Vec<Tri6Face> {
    let is_level = |node: &hapdef_mesh::FeNodeId| node.index() % (wall.n_layers + 1) == level;
    let faces = wall.mesh.boundary().faces.into_iter();
    faces.filter(|face| face.nodes[..3].iter().all(is_level)).collect()
}

/// The surface of a file in metres, its seams joined, refused unless it is one oriented body.
fn read_clean(path: &Path, unit: LengthUnit) -> Result<SurfaceMesh, HapdefError> {
    let no_file =
        |source| HapdefError::NoDeck { field: "geometry.skin", path: path.into(), source };
    std::fs::File::open(path).map_err(no_file)?;
    let given = read_surface(path, &GltfParams { unit, ..GltfParams::default() })?.mesh;
    let params = CleanParams { weld_tolerance_m: Some(WELD_M), ..CleanParams::default() };
    let (surface, info) = clean_surface(&given, &params)?;
    let refused = |source| HapdefError::SkinNotClean { path: path.into(), source };
    if !info.after.is_manifold() {
        let defects = Box::new(info.after);
        return Err(refused(SurfaceFault::Defects { wanted: "a manifold surface", defects }));
    }
    if info.body_volumes_m3.len() != 1 {
        return Err(refused(SurfaceFault::Bodies { volumes_m3: info.body_volumes_m3 }));
    }
    if info.after.is_closed() && info.after.volume_m3 <= 0.0 {
        let size = surface.bounding_box().size_m();
        let box_volume_m3 = size.x * size.y * size.z;
        return Err(refused(SurfaceFault::Volume {
            volume_m3: info.after.volume_m3,
            box_volume_m3,
        }));
    }
    Ok(surface)
}

/// One thickness a line, m.
fn read_thickness(path: &Path, n_vertices: usize) -> Result<Vec<f64>, HapdefError> {
    let refused = |what: String| HapdefError::SkinWall { path: path.into(), what };
    let no_file =
        |source| HapdefError::NoDeck { field: "geometry.wall_m", path: path.into(), source };
    let text = std::fs::read_to_string(path).map_err(no_file)?;
    let number = |(i, line): (usize, &str)| match line.trim().parse::<f64>() {
        Ok(wall_m) if wall_m > 0.0 && wall_m.is_finite() => Ok(wall_m),
        _ => Err(refused(format!("line {}: expected metres above 0, found {line:?}", i + 1))),
    };
    let thickness_m: Vec<f64> = text.lines().enumerate().map(number).collect::<Result<_, _>>()?;
    match thickness_m.len() {
        n if n == n_vertices => Ok(thickness_m),
        n => Err(refused(format!(
            "expected {n_vertices} lines, one a vertex of the skin, found {n}"
        ))),
    }
}

/// The thickness at each vertex, m, where each box has some.
fn by_region(
    path: &Path,
    surface: &SurfaceMesh,
    regions: &WallRegions,
) -> Result<Vec<f64>, HapdefError> {
    let mut thickness_m = vec![regions.elsewhere_m; surface.vertices().len()];
    for (i, region) in regions.boxes.iter().enumerate() {
        let inside = |vertex: &usize| region.has(&surface.vertices()[*vertex]);
        let inside: Vec<usize> = (0..thickness_m.len()).filter(inside).collect();
        if inside.is_empty() {
            let what = format!("geometry.wall_m.boxes[{i}]: no vertex of the skin is in it");
            return Err(HapdefError::SkinWall { path: path.into(), what });
        }
        inside.into_iter().for_each(|vertex| thickness_m[vertex] = region.wall_m);
    }
    Ok(thickness_m)
}

fn median_edge_m(skin: &SurfaceMesh) -> f64 {
    let sides = (0..skin.triangles().len()).flat_map(|t| {
        let [a, b, c] = skin.corners(t);
        [(b - a).norm(), (c - b).norm(), (a - c).norm()]
    });
    stats::median(sides)
}

fn deck_of(wall: Extrusion) -> SolidDeck {
    SolidDeck {
        mesh: wall.mesh,
        node_labels: Vec::new(),
        element_labels: Vec::new(),
        node_sets: Default::default(),
        material: None,
        fixed_nodes: Vec::new(),
        nodal_forces: Vec::new(),
        face_tractions: Vec::new(),
        unused_node_labels: Vec::new(),
        unit: None,
        notes: Vec::new(),
    }
}
