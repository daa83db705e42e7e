//! The limb's wall as a body to print, with a pocket for each gauge.

use hapdef_inverse::{AtWall, Skin, SkinFaces, SkinParams, SkinPoint, WalkEnd};
use hapdef_mesh::{Pocket, QualityReport, SurfaceMesh, trimmed, with_pockets};
use nalgebra::{Point3, Vector3};

use crate::error::HapdefError;
use crate::limb::Limb;
use crate::scene::Scene;

/// How a limb is printed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrintParams {
    /// Depth of the pockets, m.
    pub pocket_m: f64,
    /// How much longer and wider than its gauge a pocket is, m.
    pub clearance_m: f64,
    /// How much is cut off at the mount's end, m; by default half the mount if the limb is closed there,
    /// so that its inside can be reached, else nothing.
    pub trim_m: Option<f64>,
}

impl Default for PrintParams {
    /// Two layers of 0.1 mm deep, 0.5 mm longer and wider.
    fn default() -> Self {
        Self { pocket_m: 2e-4, clearance_m: 5e-4, trim_m: None }
    }
}

/// A limb to print.
#[derive(Clone, Debug)]
pub struct PrintedLimb {
    /// One closed body.
    pub body: SurfaceMesh,
    /// What was cut off at the mount's end along the axis, m.
    pub trim_m: f64,
    /// What the pockets take, m³.
    pub pockets_m3: f64,
    /// Where the gauges go, in channel order.
    pub places: Vec<GaugePlace>,
}

/// Where a gauge goes.
#[derive(Clone, Debug)]
pub struct GaugePlace {
    /// The gauge's name.
    pub name: String,
    /// Its length and width, m.
    pub size_m: [f64; 2],
    /// From the limb's axis to the gauge's, counter-clockwise seen from where the gauge is glued, rad.
    pub turn_rad: f64,
    /// Along the wall from the gauge's middle to the nearest rim: away from the mount and back along the
    /// limb, then left and right of it seen from where the gauge is glued, m; `None` where there is none.
    pub rims_m: [Option<f64>; 4],
}

/// The limb's wall as one body: its solid, cut at the mount, with a pocket at each gauge.
///
/// # Errors
/// [`HapdefError::Print`]: no single body is left, or a pocket is as deep as the wall;
/// [`HapdefError::Mesh`] for a solid that can't be cut.
pub fn print_limb(
    scene: &Scene,
    limb: &Limb,
    params: &PrintParams,
) -> Result<PrintedLimb, HapdefError> {
    let whole = boundary_of(limb)?;
    let cut = Cut::new(limb, &whole, params)?;
    let body = match cut.trim_m > 0.0 {
        true => trimmed(&whole, &cut.plane, &cut.upward)?,
        false => whole.clone(),
    };
    let pockets: Vec<Pocket> = limb
        .sites
        .iter()
        .zip(&limb.gauges)
        .map(|(site, gauge)| {
            let size_m = [site.length_m, site.width_m].map(|x| x + params.clearance_m);
            Pocket {
                centre: site.position,
                outward: gauge.normal(),
                along: gauge.axis(),
                size_m: [size_m[0], size_m[1], params.pocket_m],
            }
        })
        .collect();
    let carved = with_pockets(&body, &pockets)?;
    let (before, after) = (QualityReport::of(&body), QualityReport::of(&carved));
    let refused = |what: String| HapdefError::Print { what };
    if after.n_bodies != 1 || !after.is_closed() {
        let n = after.n_bodies;
        return Err(refused(format!("{n} bodies are left where one is wanted: trim less or more")));
    }
    if after.genus != before.genus {
        let mm = params.pocket_m * 1e3;
        return Err(refused(format!(
            "pockets of {mm} mm go through the wall: make them shallower"
        )));
    }
    let skin = skin_of(&whole)?;
    let place = |(pocket, entry): (&Pocket, _)| cut.place(&skin, pocket, params, entry);
    let entries = scene.gauges.sites.iter().map(|entry| entry.name.as_str());
    Ok(PrintedLimb {
        trim_m: cut.trim_m,
        pockets_m3: before.signed_volume_m3 - after.signed_volume_m3,
        places: pockets.iter().zip(entries).map(place).collect::<Result<_, _>>()?,
        body: carved,
    })
}

/// The solid's boundary with flat faces.
fn boundary_of(limb: &Limb) -> Result<SurfaceMesh, HapdefError> {
    let faces = &limb.boundary.faces;
    let mut number = vec![u32::MAX; limb.mesh.nodes().len()];
    let mut vertices = Vec::new();
    let mut corner = |node: hapdef_mesh::FeNodeId| {
        let slot = &mut number[node.index()];
        if *slot == u32::MAX {
            *slot = vertices.len() as u32;
            vertices.push(limb.mesh.nodes()[node.index()]);
        }
        *slot
    };
    let triangles = faces.iter().map(|face| [0, 1, 2].map(|i| corner(face.nodes[i]))).collect();
    Ok(SurfaceMesh::new(vertices, triangles)?)
}

fn skin_of(surface: &SurfaceMesh) -> Result<Skin, HapdefError> {
    let (nodes, faces) = (surface.vertices().to_vec(), SkinFaces::Linear(surface.triangles()));
    Ok(Skin::new(nodes, faces, None, &SkinParams::default())?)
}

/// The plane that the limb is cut at.
struct Cut {
    plane: Point3<f64>,
    /// Along the axis, away from the mount.
    upward: Vector3<f64>,
    trim_m: f64,
    length_m: f64,
}

impl Cut {
    fn new(limb: &Limb, whole: &SurfaceMesh, params: &PrintParams) -> Result<Self, HapdefError> {
        let along =
            Vector3::from(limb.axis.direction).try_normalize(0.0).unwrap_or_else(Vector3::z);
        let origin = Point3::from(limb.axis.point_m);
        let range = |points: &mut dyn Iterator<Item = Point3<f64>>| {
            points
                .map(|p| (p - origin).dot(&along))
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| {
                    [low.min(x), high.max(x)]
                })
        };
        let limb_m = range(&mut whole.vertices().iter().copied());
        let mount_m = range(&mut limb.clamped.iter().map(|n| limb.mesh.nodes()[n.index()]));
        let is_low = mount_m[0] + mount_m[1] < limb_m[0] + limb_m[1];
        let (end_m, sign) = if is_low { (limb_m[0], 1.0) } else { (limb_m[1], -1.0) };
        let is_closed = QualityReport::of(whole).n_bodies > 1;
        let half_m = 0.5 * (if is_low { mount_m[1] - end_m } else { end_m - mount_m[0] });
        let trim_m = params.trim_m.unwrap_or(if is_closed { half_m } else { 0.0 });
        let length_m = limb_m[1] - limb_m[0];
        if !(0.0..length_m).contains(&trim_m) {
            let what = format!("a trim of {trim_m} m: expected 0 to the limb's {length_m:.4} m");
            return Err(HapdefError::Print { what });
        }
        let plane = origin + along * (end_m + sign * trim_m);
        Ok(Self { plane, upward: along * sign, trim_m, length_m })
    }

    fn place(
        &self,
        skin: &Skin,
        pocket: &Pocket,
        params: &PrintParams,
        name: &str,
    ) -> Result<GaugePlace, HapdefError> {
        let normal = pocket.outward;
        let level = self.upward - normal * normal.dot(&self.upward);
        // Where the wall lies across the axis the gauge's own axis stands for it.
        let up = level.try_normalize(1e-3).unwrap_or(pocket.along);
        let left = normal.cross(&up);
        let (start, _) = skin.nearest(&pocket.centre)?;
        Ok(GaugePlace {
            name: name.to_owned(),
            size_m: [0, 1].map(|i| pocket.size_m[i] - params.clearance_m),
            turn_rad: pocket.along.dot(&left).atan2(pocket.along.dot(&up)),
            rims_m: [up, -up, left, -left].map(|way| self.rim_m(skin, &start, &way)),
        })
    }

    /// The distance to a fold of the wall or to the cut, straight along the wall.
    fn rim_m(&self, skin: &Skin, start: &SkinPoint, way: &Vector3<f64>) -> Option<f64> {
        let walk = |length_m: f64| skin.walk(start, &(way * length_m), AtWall::Stop);
        let is_left = |point: &SkinPoint| {
            (skin.position(point) - self.plane).dot(&self.upward) >= 0.0 || self.trim_m == 0.0
        };
        let end = walk(self.length_m);
        if is_left(&end.point) {
            return (end.end != WalkEnd::Done).then_some(end.walked_m);
        }
        let (mut low_m, mut high_m) = (0.0, end.walked_m);
        while high_m - low_m > 1e-6 {
            let middle_m = 0.5 * (low_m + high_m);
            if is_left(&walk(middle_m).point) { low_m = middle_m } else { high_m = middle_m }
        }
        Some(low_m)
    }
}
