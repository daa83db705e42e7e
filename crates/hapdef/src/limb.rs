//! The limb of a scene: mesh, skin, supports, material, gauges, all checked.

use std::path::Path;

use hapdef_mesh::{
    BoundarySurface, DeckMaterial, DeckParams, DeckReading, FeNodeId, GaugePatch, LengthUnit,
    MeshError, OuterSkinParams, RadialRegionParams, SkinRegion, SolidDeck, Tet10Mesh,
    deck_includes, gauge_patch, outer_skin, radial_region, read_deck_with, refine_unfolded,
};
use hapdef_sim::{GaugeParams, GaugeSite, GaugeStrain, IsotropicMaterial, NodalLoad, PressedSkin};
use nalgebra::{Point3, Unit, Vector3};
use rayon::prelude::*;

use crate::error::HapdefError;
use crate::scene::{
    Axis, ContactRegion, GaugeEntry, GaugeSpec, Geometry, LoadDirection, MaterialSpec, Mount, Scene,
};

/// Farthest a gauge's centre may be from its wall, m.
const MAX_GAUGE_OFFSET_M: f64 = 1e-3;

/// Everything geometric that a scene says about its limb.
pub struct Limb {
    /// The solid in metres.
    pub mesh: Tet10Mesh,
    /// Its boundary faces.
    pub boundary: BoundarySurface,
    /// The touchable skin; index in `skin.nodes` = surface node.
    pub skin: SkinRegion,
    /// Direction of a contact's force at each surface node, unit length.
    pub directions: Vec<Vector3<f64>>,
    /// Nodes held fast.
    pub clamped: Vec<FeNodeId>,
    /// Material.
    pub material: IsotropicMaterial,
    /// Gauge sites in channel order.
    pub sites: Vec<GaugeSite>,
    /// How much of a gauge may miss the wall.
    pub gauge_params: GaugeParams,
    /// Gauges as functionals of the displacement.
    pub gauges: Vec<GaugeStrain>,
    /// Patch of virtual gauges of each gauge.
    pub patches: Vec<GaugePatch>,
    /// Hash of the bytes of the deck and of what it includes.
    pub deck_hash: String,
    /// What of the deck was passed over, and what was made of it, a sentence each.
    pub deck_notes: Vec<String>,
}

/// A deck's solid with what the scene finds on it.
pub(crate) struct Solid {
    /// In metres, refined.
    pub(crate) mesh: Tet10Mesh,
    pub(crate) boundary: BoundarySurface,
    pub(crate) skin: SkinRegion,
    /// Nodes held fast.
    pub(crate) clamped: Vec<FeNodeId>,
    /// The deck in metres as it was read.
    deck: SolidDeck,
    /// Hash of the file's bytes.
    pub(crate) hash: String,
}

impl Limb {
    /// Reads the deck that `scene` names (relative to `scene_dir`) and finds everything on it.
    ///
    /// # Errors
    /// [`HapdefError`] naming the scene's field when the deck, mount, material, skin or a gauge is
    /// not usable.
    pub fn load(scene: &Scene, scene_dir: &Path) -> Result<Self, HapdefError> {
        let path = scene_dir.join(&scene.geometry.solid_deck);
        let Solid { mesh, boundary, skin, clamped, deck, hash: deck_hash } =
            Solid::load(scene, &path, scene.geometry.refinements)?;
        let directions = load_directions(scene, &mesh, &skin);
        let material = find_material(scene.material.as_ref(), &deck, &path)?;
        let sites: Vec<_> = scene.gauges.sites.iter().map(|entry| site(entry, scene)).collect();
        let (gauges, patches) = place_gauges(scene, &sites, &mesh, &boundary)?;
        Ok(Self {
            mesh,
            boundary,
            skin,
            directions,
            clamped,
            material,
            sites,
            gauge_params: gauge_params(scene),
            gauges,
            patches,
            deck_hash,
            deck_notes: deck.notes,
        })
    }

    /// Whether every body of the limb is held by the mount; for the first that isn't, where it is.
    ///
    /// # Errors
    /// [`HapdefError::Floating`].
    pub fn check_held(&self) -> Result<(), HapdefError> {
        let bodies = self.mesh.bodies();
        let is_held = |elements: &[usize]| {
            let nodes = elements.iter().flat_map(|element| self.mesh.elements()[*element]);
            nodes.into_iter().any(|node| self.clamped.binary_search(&node).is_ok())
        };
        match bodies.iter().find(|body| !is_held(&body.elements)) {
            None => Ok(()),
            Some(body) => Err(HapdefError::Floating {
                n_bodies: bodies.len(),
                n_elements: body.elements.len(),
                centre_m: body.bounding_box.centre().into(),
                size_m: body.bounding_box.size_m().into(),
            }),
        }
    }

    /// Number of surface nodes.
    #[must_use]
    pub fn n_surface_nodes(&self) -> usize {
        self.skin.nodes.len()
    }

    /// Positions of the surface nodes `[n_surface_nodes]`, m.
    #[must_use]
    pub fn surface_points(&self) -> Vec<Point3<f64>> {
        self.skin.nodes.iter().map(|n| self.mesh.nodes()[n.index()]).collect()
    }

    /// A unit force of the scene's tip and direction at every surface node, N.
    ///
    /// # Errors
    /// [`HapdefError::Sim`] when a tip does not touch the skin.
    pub fn unit_loads(&self, tip_radius_m: f64) -> Result<Vec<NodalLoad>, HapdefError> {
        let skin = PressedSkin::new(&self.mesh, &self.skin)?;
        let points = self.surface_points();
        let pressed = points.par_iter().zip(&self.directions);
        let loads = pressed.map(|(point, direction)| skin.load(point, tip_radius_m, direction));
        Ok(loads.collect::<Result<_, _>>()?)
    }

    /// FE nodes whose displacement the pipeline wants: the surface nodes, then the virtual gauges
    /// patch by patch.
    #[must_use]
    pub fn wanted_nodes(&self) -> Vec<FeNodeId> {
        let virtual_gauges = self.patches.iter().flat_map(|patch| patch.nodes.iter());
        self.skin.nodes.iter().chain(virtual_gauges).copied().collect()
    }
}

impl Solid {
    /// Reads the deck at `path` in the scene's unit, refines it, and finds the scene's mount and
    /// contact region on it.
    ///
    /// # Errors
    /// [`HapdefError`] when the deck, the mount or the skin is not usable.
    pub(crate) fn load(scene: &Scene, path: &Path, refinements: u32) -> Result<Self, HapdefError> {
        let hash = deck_hash(path)?;
        let reading = match scene.mount {
            Mount::Deck {} => DeckReading::Supports,
            Mount::NodeSet { .. } | Mount::Box { .. } => DeckReading::Mesh,
        };
        let params = DeckParams { reading, ..DeckParams::default() };
        let deck = in_metres(read_deck_with(path, &params)?, &scene.geometry)?;
        let mut clamped = find_mount(&scene.mount, &deck)?;
        let mut mesh = deck.mesh.clone();
        for _ in 0..refinements {
            let refined = refine_unfolded(&mesh)?;
            clamped = refined.node_set(&clamped);
            mesh = refined.mesh;
        }
        let boundary = mesh.boundary();
        let region = &scene.contact.region;
        let skin = find_skin(region, &scene.geometry.axis, &mesh, &boundary)?;
        Ok(Self { mesh, boundary, skin, clamped, deck, hash })
    }
}

/// Hash of the bytes of a deck file and of the files it includes.
///
/// # Errors
/// [`HapdefError::NoDeck`] when it can't be read.
pub(crate) fn deck_hash(path: &Path) -> Result<String, HapdefError> {
    let mut hasher = blake3::Hasher::new();
    let mut add = |path: &Path| -> Result<(), HapdefError> {
        hasher.update(&std::fs::read(path).map_err(|source| HapdefError::NoDeck {
            field: "geometry.solid_deck",
            path: path.to_path_buf(),
            source,
        })?);
        Ok(())
    };
    add(path)?;
    // a deck that can't be read at all says so when it is read
    let included = deck_includes(path, DeckParams::default().max_bytes).unwrap_or_default();
    included.iter().try_for_each(|file| add(file))?;
    Ok(hasher.finalize().to_hex().to_string())
}

/// The boundary faces that the scene's contact region names.
fn find_skin(
    region: &ContactRegion,
    axis: &Axis,
    mesh: &Tet10Mesh,
    boundary: &BoundarySurface,
) -> Result<SkinRegion, MeshError> {
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
        ContactRegion::OuterSkin {} => outer_skin(mesh, boundary, &OuterSkinParams::default()),
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

fn find_material(
    spec: Option<&MaterialSpec>,
    deck: &SolidDeck,
    path: &Path,
) -> Result<IsotropicMaterial, HapdefError> {
    let from_deck = || {
        let m = deck.material.as_ref()?;
        Some((m.youngs_modulus_pa, m.poissons_ratio, m.density_kg_m3?))
    };
    let from_scene = spec.map(|m| (m.youngs_modulus_pa, m.poissons_ratio, m.density_kg_m3));
    let (e, nu, rho) = from_scene
        .or_else(from_deck)
        .ok_or_else(|| HapdefError::NoMaterial { deck: path.display().to_string() })?;
    Ok(IsotropicMaterial::new(e, nu, rho)?)
}

fn find_mount(mount: &Mount, deck: &SolidDeck) -> Result<Vec<FeNodeId>, HapdefError> {
    let no_mount = |what: String, advice: String| HapdefError::NoMount { what, advice };
    let nodes = match mount {
        Mount::Deck {} => deck.fixed_nodes.clone(),
        Mount::NodeSet { name } => deck.node_sets.get(name).cloned().ok_or_else(|| {
            let known: Vec<&str> = deck.node_sets.keys().map(String::as_str).collect();
            no_mount(
                format!("the deck has no node set {name:?}"),
                format!("it has: {}", known.join(", ")),
            )
        })?,
        Mount::Box { min_m, max_m } => {
            let inside = |x: &Point3<f64>| (0..3).all(|i| (min_m[i]..=max_m[i]).contains(&x[i]));
            deck.mesh.nodes_where(inside)
        }
    };
    if nodes.is_empty() {
        let what = match mount {
            Mount::Deck {} => "the deck fixes no node",
            Mount::NodeSet { .. } => "the node set is empty",
            Mount::Box { .. } => "no node lies in the box",
        };
        let advice = "without a mount the limb floats: name a node set, a box, or fix nodes in \
                      the deck";
        return Err(no_mount(what.into(), advice.into()));
    }
    Ok(nodes)
}

fn load_directions(scene: &Scene, mesh: &Tet10Mesh, skin: &SkinRegion) -> Vec<Vector3<f64>> {
    let axis = &scene.geometry.axis;
    let origin = Point3::from(axis.point_m);
    let along = Unit::new_normalize(Vector3::from(axis.direction));
    let inward = |(i, node): (usize, &FeNodeId)| {
        let normal: Vector3<f64> = skin.normals[i];
        let offset = mesh.nodes()[node.index()] - origin;
        let radial = offset - along.into_inner() * offset.dot(&along);
        match scene.contact.direction {
            LoadDirection::Normal => -normal,
            LoadDirection::Radial => radial.try_normalize(0.0).map_or(-normal, |r| -r),
        }
    };
    skin.nodes.iter().enumerate().map(inward).collect()
}

impl GaugeSpec {
    /// A gauge of the scene's size at `position`, measuring along `axis`.
    pub fn site(&self, position: Point3<f64>, axis: Vector3<f64>) -> GaugeSite {
        GaugeSite { position, axis, length_m: self.length_m, width_m: self.width_m }
    }
}

fn site(entry: &GaugeEntry, scene: &Scene) -> GaugeSite {
    let (position, axis) = (Point3::from(entry.position_m), Vector3::from(entry.axis));
    scene.gauges.site(position, axis)
}

fn gauge_params(scene: &Scene) -> GaugeParams {
    let max_lost_share = scene.gauges.max_lost_share;
    GaugeParams { max_lost_share, max_distance_m: MAX_GAUGE_OFFSET_M, ..GaugeParams::default() }
}

/// The scene's gauges on a mesh, with their patches of virtual gauges.
///
/// # Errors
/// [`HapdefError::Gauge`] for the first that can't be placed.
pub(crate) fn place_gauges(
    scene: &Scene,
    sites: &[GaugeSite],
    mesh: &Tet10Mesh,
    boundary: &BoundarySurface,
) -> Result<(Vec<GaugeStrain>, Vec<GaugePatch>), HapdefError> {
    let place = |site: &GaugeSite| -> Result<_, HapdefError> {
        let n = scene.gauges.patch_nodes;
        let patch = gauge_patch(mesh, &boundary.faces, &site.position, n, MAX_GAUGE_OFFSET_M)?;
        Ok((GaugeStrain::with_params(mesh, &boundary.faces, site, &gauge_params(scene))?, patch))
    };
    let placed = sites.iter().zip(&scene.gauges.sites).enumerate().map(|(index, (site, entry))| {
        place(site).map_err(|source| HapdefError::Gauge {
            index,
            name: entry.name.clone(),
            source: Box::new(source),
        })
    });
    Ok(placed.collect::<Result<Vec<_>, _>>()?.into_iter().unzip())
}
