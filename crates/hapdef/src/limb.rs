//! The limb of a scene: mesh, skin, supports, material, gauges, all checked.

use std::path::Path;

use hapdef_mesh::{
    BoundarySurface, DeckMaterial, FeNodeId, GaugePatch, HeldSolid, SkinRegion, Tet10Mesh,
    gauge_patch,
};
use hapdef_sim::{
    GaugeParams, GaugeSite, GaugeStrain, IsotropicMaterial, LoadedLimb, NodalLoad, PressedSkin,
};
use nalgebra::{Point3, Unit, Vector3};
use rayon::prelude::*;

use crate::error::HapdefError;
use crate::scene::{
    Axis, GaugeEntry, GaugeSpec, LoadDirection, LoadsSpec, MaterialSpec, Scene, Shape,
};
use crate::skin_wall::SkinWall;
use crate::solid::Solid;
use crate::wall_shell::WallShell;

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
    /// The wall, of a skin.
    pub wall: Option<SkinWall>,
    /// The wall as a shell, where that is solved in place of the solid.
    pub shell: Option<WallShell>,
    /// Nodes held fast.
    pub clamped: Vec<FeNodeId>,
    /// Nodes that the next joint is fixed to; none without one.
    pub flange: Vec<FeNodeId>,
    /// Its long axis.
    pub axis: Axis,
    /// Depth below the skin down to which material counts as wall, m.
    pub max_wall_m: f64,
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
    /// Hash of the bytes of the deck and of what it includes, or of the skin and its wall.
    pub deck_hash: String,
    /// What of the file was passed over, and what was made of it, a sentence each.
    pub deck_notes: Vec<String>,
}

impl Limb {
    /// Reads the deck or skin that `scene` names (relative to `scene_dir`) and finds everything on it.
    ///
    /// # Errors
    /// [`HapdefError`] naming the scene's field when the deck or skin, mount, material, skin or a gauge is
    /// not usable.
    pub fn load(scene: &Scene, scene_dir: &Path) -> Result<Self, HapdefError> {
        Self::of(scene, scene_dir, Solid::load(scene, scene_dir)?)
    }

    /// Everything that `scene` finds on a solid.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub(crate) fn of(scene: &Scene, scene_dir: &Path, solid: Solid) -> Result<Self, HapdefError> {
        let Solid { mesh, boundary, skin, outside, clamped, flange, axis, notes, .. } = solid;
        let wall = match (&scene.geometry.shape, &outside) {
            (Shape::Skin(skin), Some(outside)) => {
                Some(SkinWall::new(scene, scene_dir, skin, &mesh, outside)?)
            }
            _ => None,
        };
        let (wall, shell) = wall.map_or((None, None), |(wall, shell)| (Some(wall), shell));
        let directions = load_directions(scene, &axis, &mesh, &skin);
        let material = find_material(scene, solid.material)?;
        let sites: Vec<_> = scene.gauges.sites.iter().map(|entry| site(entry, scene)).collect();
        let (gauges, patches) = place_gauges(scene, &sites, &mesh, &boundary)?;
        if let Some(shell) = &shell {
            let lost = scene.gauges.max_lost_share;
            each_gauge(scene, &sites, |site| Ok(shell.gauge(site, &material, lost)?))?;
        }
        Ok(Self {
            mesh,
            boundary,
            skin,
            directions,
            wall,
            shell,
            clamped,
            flange,
            axis,
            max_wall_m: scene.rig.max_wall_m.unwrap_or(solid.max_wall_m),
            material,
            sites,
            gauge_params: gauge_params(scene),
            gauges,
            patches,
            deck_hash: solid.hash,
            deck_notes: notes,
        })
    }

    /// The scene of this limb with everything filled in that it leaves to the limb.
    #[must_use]
    pub fn filled(&self, scene: &Scene) -> Scene {
        let mut scene = scene.clone();
        scene.geometry.axis.get_or_insert(self.axis);
        scene.rig.max_wall_m.get_or_insert(self.max_wall_m);
        scene.material.get_or_insert(MaterialSpec {
            youngs_modulus_pa: self.material.youngs_modulus_pa(),
            poissons_ratio: self.material.poissons_ratio(),
            density_kg_m3: self.material.density_kg_m3(),
        });
        scene
    }

    /// The solid with what is done to it, to be refined.
    pub(crate) fn held_solid(&self) -> HeldSolid {
        HeldSolid {
            mesh: self.mesh.clone(),
            clamped: self.clamped.clone(),
            flange: self.flange.clone(),
            skin: self.skin.clone(),
            n_straightened: 0,
        }
    }

    /// The middle of the mount, m: the mean place of the nodes that are held.
    #[must_use]
    pub fn mount_m(&self) -> Point3<f64> {
        let held = self.clamped.iter().map(|node| self.mesh.position(*node).coords);
        Point3::from(held.sum::<Vector3<f64>>() / self.clamped.len() as f64)
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

    /// Whether some press on the touchable skin moves every gauge; for the first that none does, why.
    ///
    /// # Errors
    /// [`HapdefError::Unreached`].
    pub fn check_reached(&self) -> Result<(), HapdefError> {
        let mut is_pressed = vec![false; self.mesh.nodes().len()];
        for body in self.mesh.bodies() {
            let nodes = || body.elements.iter().flat_map(|e| self.mesh.elements()[*e]);
            if nodes().any(|node| self.skin.nodes.binary_search(&node).is_ok()) {
                nodes().for_each(|node| is_pressed[node.index()] = true);
            }
        }
        let unreached = |gauge: &GaugeStrain| {
            let nodes = || gauge.as_ref().weights().iter().map(|weight| weight.node);
            if !nodes().any(|node| is_pressed[node.index()]) {
                return Some("it is on a body without touchable skin");
            }
            let is_held = |node| self.clamped.binary_search(&node).is_ok();
            nodes().all(is_held).then_some("all of it is held by the mount")
        };
        let found = self.gauges.iter().enumerate().find_map(|(i, g)| Some((i, unreached(g)?)));
        found.map_or(Ok(()), |(index, why)| Err(HapdefError::Unreached { index, why }))
    }

    /// The limb as loads of `spec` act on it.
    #[must_use]
    pub fn loaded(&self, spec: &LoadsSpec) -> LoadedLimb<'_> {
        let nodes = self.flange.iter().map(|node| self.mesh.position(*node).coords);
        let middle: Vector3<f64> = nodes.sum::<Vector3<f64>>() / self.flange.len().max(1) as f64;
        LoadedLimb {
            mesh: &self.mesh,
            material: self.material,
            expansion_per_k: spec.expansion_per_k,
            flange: &self.flange,
            flange_point_m: middle.into(),
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

/// What the scene says, or else its deck; PA2200 for a skin.
fn find_material(
    scene: &Scene,
    of_deck: Option<DeckMaterial>,
) -> Result<IsotropicMaterial, HapdefError> {
    let from_deck = || {
        let m = of_deck?;
        Some((m.youngs_modulus_pa, m.poissons_ratio, m.density_kg_m3?))
    };
    let of = |m: MaterialSpec| (m.youngs_modulus_pa, m.poissons_ratio, m.density_kg_m3);
    let (e, nu, rho) = match &scene.geometry.shape {
        _ if scene.material.is_some() => scene.material.map(of),
        Shape::Deck(_) => from_deck(),
        Shape::Skin(_) => Some(of(MaterialSpec::PA2200)),
    }
    .ok_or_else(|| HapdefError::NoMaterial {
        deck: scene.geometry.shape.file().display().to_string(),
    })?;
    Ok(IsotropicMaterial::new(e, nu, rho)?)
}

fn load_directions(
    scene: &Scene,
    axis: &Axis,
    mesh: &Tet10Mesh,
    skin: &SkinRegion,
) -> Vec<Vector3<f64>> {
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

pub(crate) fn site(entry: &GaugeEntry, scene: &Scene) -> GaugeSite {
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
    Ok(each_gauge(scene, sites, place)?.into_iter().unzip())
}

/// What `place` makes of each of the scene's gauges.
///
/// # Errors
/// [`HapdefError::Gauge`] for the first that it refuses.
fn each_gauge<T>(
    scene: &Scene,
    sites: &[GaugeSite],
    place: impl Fn(&GaugeSite) -> Result<T, HapdefError>,
) -> Result<Vec<T>, HapdefError> {
    let each = sites.iter().zip(&scene.gauges.sites).enumerate();
    each.map(|(index, (site, entry))| {
        let name = entry.name.clone();
        place(site).map_err(|source| HapdefError::Gauge { index, name, source: Box::new(source) })
    })
    .collect()
}
