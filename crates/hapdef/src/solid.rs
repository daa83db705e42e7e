//! The solid of a limb, read from its deck or made of its skin, with what the scene finds on it.

use std::path::Path;

use hapdef_mesh::{
    BoundarySurface, DeckMaterial, DeckParams, DeckReading, FeNodeId, LengthUnit, MeshError,
    OuterSkinParams, PointIndex, RadialRegionParams, SkinRegion, SolidDeck, Tet10Mesh, Tri6Face,
    deck_includes, outer_skin, radial_region, read_deck_with, refine_unfolded,
};
use nalgebra::{Point3, Unit, Vector3};

use crate::error::HapdefError;
use crate::limb_axis::{extent_m, principal_axis};
use crate::scene::{Axis, ContactRegion, Geometry, LimbEnd, Mount, Scene, Shape, WallThickness};
use crate::skin_solid::{Outside, SkinSolid};

/// Depth that counts as wall below a deck's skin where the scene doesn't say, m.
const DECK_WALL_M: f64 = 3e-3;

/// As deep below a skin as its wall is thick, and half as much again.
const WALL_MARGIN: f64 = 1.5;

/// A solid with what the scene finds on it.
pub(crate) struct Solid {
    /// In metres, refined.
    pub(crate) mesh: Tet10Mesh,
    pub(crate) boundary: BoundarySurface,
    pub(crate) skin: SkinRegion,
    /// The outside of a skin's wall.
    pub(crate) outside: Option<Outside>,
    /// Nodes held fast, ascending.
    pub(crate) clamped: Vec<FeNodeId>,
    /// Nodes that the next joint is fixed to, ascending; none where the scene names no flange.
    pub(crate) flange: Vec<FeNodeId>,
    /// The limb's long axis.
    pub(crate) axis: Axis,
    /// The material of the file, if it states one.
    pub(crate) material: Option<DeckMaterial>,
    /// What of the file was passed over, and what was made of it, a sentence each.
    pub(crate) notes: Vec<String>,
    /// Depth that counts as wall where the scene doesn't say, m.
    pub(crate) max_wall_m: f64,
    /// Hash of the bytes of all files it is made of.
    pub(crate) hash: String,
}

/// A solid as its file has it, in metres.
struct Source {
    deck: SolidDeck,
    /// What is outside, where that is known.
    outside: Option<Outside>,
    max_wall_m: f64,
    hash: String,
}

impl Solid {
    /// The solid of the scene's geometry, refined as it says.
    ///
    /// # Errors
    /// [`HapdefError`] when deck, skin, mount or contact region are not usable.
    pub(crate) fn load(scene: &Scene, scene_dir: &Path) -> Result<Self, HapdefError> {
        let path = scene_dir.join(scene.geometry.shape.file());
        let source = match &scene.geometry.shape {
            Shape::Deck(_) => Source::of_deck(scene, &path)?,
            Shape::Skin(skin) => {
                let solid = SkinSolid::load(skin, scene.geometry.unit, scene_dir)?;
                Source::of_skin(solid, geometry_hash(&scene.geometry, scene_dir)?)
            }
        };
        Self::of(scene, source, scene.geometry.refinements)
    }

    /// A skin's solid with what the scene finds on it, of files that `hash` stands for.
    ///
    /// # Errors
    /// [`HapdefError`] when the mount is not usable.
    pub(crate) fn of_skin(
        scene: &Scene,
        solid: SkinSolid,
        hash: String,
    ) -> Result<Self, HapdefError> {
        Self::of(scene, Source::of_skin(solid, hash), scene.geometry.refinements)
    }

    /// The deck at `path` in the scene's unit, not refined, with the scene's mount and contact region.
    ///
    /// # Errors
    /// [`HapdefError`] when the deck, the mount or the skin is not usable.
    pub(crate) fn of_deck(scene: &Scene, path: &Path) -> Result<Self, HapdefError> {
        Self::of(scene, Source::of_deck(scene, path)?, 0)
    }

    fn of(scene: &Scene, source: Source, refinements: u32) -> Result<Self, HapdefError> {
        let Source { deck, mut outside, max_wall_m, hash } = source;
        let boundary = deck.mesh.boundary();
        let axis = scene.geometry.axis.unwrap_or_else(|| principal_axis(&deck.mesh, &boundary));
        let mut clamped = find_mount(&scene.mount, &deck, &axis)?;
        let mut flange = find_flange(scene, &deck, &axis, &clamped)?;
        let SolidDeck { mut mesh, material, notes, .. } = deck;
        for _ in 0..refinements {
            let refined = refine_unfolded(&mesh)?;
            clamped = refined.node_set(&clamped);
            flange = refined.node_set(&flange);
            outside = outside.map(|outside| outside.refined(&refined));
            mesh = refined.mesh;
        }
        let boundary = mesh.boundary();
        let region = &scene.contact.region;
        let faces = outside.as_ref().map(|outside| &outside.faces[..]);
        let skin = find_skin(region, &axis, &mesh, &boundary, faces, &clamped)?;
        Ok(Self {
            mesh,
            boundary,
            skin,
            outside,
            clamped,
            flange,
            axis,
            material,
            notes,
            max_wall_m,
            hash,
        })
    }
}

impl Source {
    fn of_skin(solid: SkinSolid, hash: String) -> Self {
        let (max_wall_m, outside) = (WALL_MARGIN * solid.thickest_m, Some(solid.outside));
        Self { deck: solid.deck, outside, max_wall_m, hash }
    }

    fn of_deck(scene: &Scene, path: &Path) -> Result<Self, HapdefError> {
        let hash = deck_hash(path)?;
        let reading = match scene.mount {
            Mount::Deck {} => DeckReading::Supports,
            _ => DeckReading::Mesh,
        };
        let params = DeckParams { reading, ..DeckParams::default() };
        let deck = in_metres(read_deck_with(path, &params)?, &scene.geometry)?;
        Ok(Self { deck, outside: None, max_wall_m: DECK_WALL_M, hash })
    }
}

/// Hash of the bytes of a deck file and of the files it includes.
///
/// # Errors
/// [`HapdefError::NoDeck`] when it can't be read.
pub(crate) fn deck_hash(path: &Path) -> Result<String, HapdefError> {
    // a deck that can't be read at all says so when it is read
    let included = deck_includes(path, DeckParams::default().max_bytes).unwrap_or_default();
    let files = std::iter::once(path).chain(included.iter().map(|file| file.as_path()));
    hash_of("geometry.solid_deck", files)
}

/// Hash of the bytes of all files that a scene's geometry is made of.
///
/// # Errors
/// [`HapdefError::NoDeck`] when one can't be read.
pub(crate) fn geometry_hash(geometry: &Geometry, scene_dir: &Path) -> Result<String, HapdefError> {
    match &geometry.shape {
        Shape::Deck(deck) => deck_hash(&scene_dir.join(deck)),
        Shape::Skin(skin) => {
            let wall = match &skin.wall {
                WallThickness::Constant(_) | WallThickness::Regions(_) => None,
                WallThickness::File(file) => Some(scene_dir.join(file)),
            };
            let skin = scene_dir.join(&skin.file);
            hash_of("geometry.skin", [&skin].into_iter().chain(&wall).map(|file| file.as_path()))
        }
    }
}

fn hash_of<'a>(
    field: &'static str,
    files: impl Iterator<Item = &'a Path>,
) -> Result<String, HapdefError> {
    let mut hasher = blake3::Hasher::new();
    for path in files {
        let no_file = |source| HapdefError::NoDeck { field, path: path.to_owned(), source };
        hasher.update(&std::fs::read(path).map_err(no_file)?);
    }
    Ok(hasher.finalize().to_hex().to_string())
}

/// The boundary faces that the scene's contact region names; `outside` where those are known.
fn find_skin(
    region: &ContactRegion,
    axis: &Axis,
    mesh: &Tet10Mesh,
    boundary: &BoundarySurface,
    outside: Option<&[Tri6Face]>,
    clamped: &[FeNodeId],
) -> Result<SkinRegion, MeshError> {
    let outer = || match outside {
        Some(faces) => Ok::<_, MeshError>(faces.to_vec()),
        None => Ok(outer_skin(mesh, boundary, &OuterSkinParams::default())?.faces),
    };
    match region {
        ContactRegion::Radial { min_normal_dot_radial, min_radius_m, axial_range_m } => {
            let params = RadialRegionParams {
                axis_point: Point3::from(axis.point_m),
                axis_dir: Vector3::from(axis.direction),
                min_normal_dot_radial: *min_normal_dot_radial,
                min_radius_m: *min_radius_m,
                axial_range_m: (axial_range_m[0], axial_range_m[1]),
            };
            radial_region(mesh, boundary, &params)
        }
        ContactRegion::OuterSkin {} => SkinRegion::new(mesh, outer()?),
        ContactRegion::FreeSkin { mount_gap_m } => {
            let mut faces = outer()?;
            let held: Vec<_> = clamped.iter().map(|node| mesh.position(*node)).collect();
            let held = PointIndex::new(&held);
            let is_left_out = |node: &FeNodeId| {
                let nearest = held.nearest(&mesh.position(*node));
                clamped.binary_search(node).is_ok()
                    || nearest.is_some_and(|(_, distance_m)| distance_m < *mount_gap_m)
            };
            faces.retain(|face| !face.nodes.iter().any(is_left_out));
            SkinRegion::new(mesh, faces)
        }
    }
}

/// Millimetre decks become metres, unless they say their unit and were read in it; their MPa and
/// t/mm³ become Pa and kg/m³.
fn in_metres(mut deck: SolidDeck, geometry: &Geometry) -> Result<SolidDeck, HapdefError> {
    match deck.unit {
        Some(unit) if unit == geometry.unit => return Ok(deck),
        Some(deck) => return Err(HapdefError::DeckUnit { deck, scene: geometry.unit }),
        None if geometry.unit == LengthUnit::Metre => return Ok(deck),
        None => {}
    }
    let nodes = deck.mesh.nodes().iter().map(|x| x * 1e-3).collect();
    deck.mesh = Tet10Mesh::new(nodes, deck.mesh.elements().to_vec())?;
    deck.material.iter_mut().for_each(DeckMaterial::from_millimetres);
    deck.face_tractions.iter_mut().for_each(|face| face.traction_pa *= 1e6);
    Ok(deck)
}

/// The nodes that the scene's flange names.
fn find_flange(
    scene: &Scene,
    deck: &SolidDeck,
    axis: &Axis,
    clamped: &[FeNodeId],
) -> Result<Vec<FeNodeId>, HapdefError> {
    let Some(flange) = scene.loads.as_ref().and_then(|loads| loads.flange.as_ref()) else {
        return Ok(Vec::new());
    };
    let nodes = find_mount(&flange.at, deck, axis).map_err(|error| match error {
        HapdefError::NoMount { what, .. } => HapdefError::NoFlange { what },
        other => other,
    })?;
    if nodes.iter().any(|node| clamped.contains(node)) {
        return Err(HapdefError::NoFlange {
            what: "some of its nodes are held by the mount".into(),
        });
    }
    Ok(nodes)
}

fn find_mount(mount: &Mount, deck: &SolidDeck, axis: &Axis) -> Result<Vec<FeNodeId>, HapdefError> {
    let no_mount = |what: String, advice: String| HapdefError::NoMount { what, advice };
    let (nodes, empty) = match mount {
        Mount::Deck {} => (deck.fixed_nodes.clone(), "the deck fixes no node"),
        Mount::NodeSet { name } => {
            let nodes = deck.node_sets.get(name).cloned().ok_or_else(|| {
                let known: Vec<&str> = deck.node_sets.keys().map(String::as_str).collect();
                let advice = match known[..] {
                    [] => "it has none: mount the limb by a plane, a box or an end".to_owned(),
                    _ => format!("it has: {}", known.join(", ")),
                };
                no_mount(format!("the deck has no node set {name:?}"), advice)
            })?;
            (nodes, "the node set is empty")
        }
        Mount::Box { min_m, max_m } => {
            let inside = |x: &Point3<f64>| (0..3).all(|i| (min_m[i]..=max_m[i]).contains(&x[i]));
            (deck.mesh.nodes_where(inside), "no node lies in the box")
        }
        Mount::Plane { point_m, normal } => {
            let (point, normal) = (Point3::from(*point_m), Vector3::from(*normal));
            let beyond = |x: &Point3<f64>| (x - point).dot(&normal) >= 0.0;
            (deck.mesh.nodes_where(beyond), "no node lies on the plane or beyond it")
        }
        Mount::End { end, length_m } => {
            let along = Unit::new_normalize(Vector3::from(axis.direction));
            let [low, high] = extent_m(deck.mesh.nodes(), &along);
            let held = |x: &Point3<f64>| match end {
                LimbEnd::Low => x.coords.dot(&along) - low <= *length_m,
                LimbEnd::High => high - x.coords.dot(&along) <= *length_m,
            };
            (deck.mesh.nodes_where(held), "no node lies at that end")
        }
    };
    if nodes.is_empty() {
        let advice = "without a mount the limb floats: name a node set, a box, a plane or an end, or \
                      fix nodes in the deck";
        return Err(no_mount(empty.into(), advice.into()));
    }
    if nodes.len() == deck.mesh.nodes().len() {
        let what = "it holds every node of the limb".into();
        let advice = "nothing could be felt: let it hold one end (the normal of a plane points out of \
                      the limb)";
        return Err(no_mount(what, advice.into()));
    }
    Ok(nodes)
}
