//! The limb as the page draws it.

use anyhow::Result;
use hapdef::scene::{GaugeEntry, Scene};
use hapdef::{DrawnSkin, Limb, Run};
use hapdef_live::Bundle;
use hapdef_mesh::{FeNodeId, PointIndex, SkinRegion};
use hapdef_view::{GaugeSite, LimbPicture};
use nalgebra::{Point3, Vector3};
use std::sync::Arc;

/// The touchable skin.
#[derive(Clone)]
pub(super) struct Surface {
    index: Arc<PointIndex>,
    points: Arc<Vec<Point3<f64>>>,
    normals: Arc<Vec<Vector3<f64>>>,
    /// The surface that is drawn instead; its nodes are the picture's first where there is none.
    drawn: Option<Arc<DrawnSkin>>,
}

impl Surface {
    fn new(points: Vec<Point3<f64>>, normals: Vec<Vector3<f64>>) -> Self {
        Self {
            index: Arc::new(PointIndex::new(&points)),
            points: Arc::new(points),
            normals: Arc::new(normals),
            drawn: None,
        }
    }

    pub(super) fn n_nodes(&self) -> usize {
        self.points.len()
    }

    /// The outward normal near a point of the skin.
    pub(super) fn normal_at(&self, point: &Point3<f64>) -> Vector3<f64> {
        let nearest = self.index.nearest(point);
        nearest.map_or_else(Vector3::z, |(node, _)| self.normals[node])
    }

    /// What the picture's first vertices do when the skin's nodes do `of_nodes`.
    pub(super) fn shown(&self, of_nodes: &[[f32; 3]], shown: &mut Vec<[f32; 3]>) {
        shown.clear();
        let Some(drawn) = &self.drawn else {
            shown.extend_from_slice(of_nodes);
            return;
        };
        shown.extend(drawn.moves_with.iter().map(|around| {
            let part = |axis: usize| {
                let parts = around.iter().map(|&(i, w)| w * f64::from(of_nodes[i][axis]));
                parts.sum::<f64>() as f32
            };
            [part(0), part(1), part(2)]
        }));
    }

    /// The three nearest nodes with weights by inverse distance, whose sum is 1.
    pub(super) fn around(&self, point: &Point3<f64>) -> Vec<(usize, f64)> {
        let near = self.index.k_nearest(point, 3);
        let weight = |node: usize| 1.0 / ((self.points[node] - point).norm() + 1e-6);
        let sum: f64 = near.iter().map(|&node| weight(node)).sum();
        near.into_iter().map(|node| (node, weight(node) / sum)).collect()
    }
}

/// A scene's limb: the surface that it wants drawn, or the solid's boundary.
pub(super) fn of_scene(run: &Run, limb: &Limb) -> Result<(LimbPicture, Surface)> {
    let scene = &run.scene;
    let mut surface = Surface::new(limb.surface_points(), limb.skin.normals.clone());
    let drawn = DrawnSkin::load(scene, &run.scene_dir, limb)?;
    surface.drawn = drawn.map(Arc::new);
    let shape = match &surface.drawn {
        Some(skin) => LimbPicture {
            triangles: skin.triangles.clone(),
            ..drawn_points(&skin.vertices_m, &skin.normals)
        },
        None => boundary(limb),
    };
    let axis = Vector3::from(limb.axis.direction);
    let picture = LimbPicture {
        title: scene.name.clone(),
        gauges: sites(scene),
        up: Some(axis.into()),
        view_from: view_from(&limb.skin.normals, &axis),
        ..shape
    };
    Ok((picture, surface))
}

fn sites(scene: &Scene) -> Vec<GaugeSite> {
    let site = |site: &GaugeEntry| GaugeSite {
        name: site.name.clone(),
        position_m: site.position_m,
        axis: site.axis,
    };
    scene.gauges.sites.iter().map(site).collect()
}

/// The touchable skin, then the rest of the boundary.
fn boundary(limb: &Limb) -> LimbPicture {
    let skin = &limb.skin;
    let whole = SkinRegion::new(&limb.mesh, limb.boundary.faces.clone());
    let whole = whole.unwrap_or_else(|_| skin.clone());
    let mut place = vec![u32::MAX; limb.mesh.nodes().len()];
    let mut points = limb.surface_points();
    let mut normals = skin.normals.clone();
    for (i, node) in skin.nodes.iter().enumerate() {
        place[node.index()] = i as u32;
    }
    for (node, normal) in whole.nodes.iter().zip(&whole.normals) {
        if place[node.index()] == u32::MAX {
            place[node.index()] = points.len() as u32;
            points.push(limb.mesh.nodes()[node.index()]);
            normals.push(*normal);
        }
    }
    let faces = whole
        .faces
        .iter()
        .flat_map(|face| parts(face.nodes.map(|node: FeNodeId| place[node.index()])));
    LimbPicture { triangles: faces.collect(), ..drawn_points(&points, &normals) }
}

/// A bundle's skin.
pub(super) fn of_bundle(bundle: &Bundle) -> (LimbPicture, Surface) {
    let skin = bundle.skin();
    let faces = (0..skin.n_faces()).flat_map(|face| match *skin.face_nodes(face) {
        [a, b, c, ab, bc, ca] => parts([a, b, c, ab, bc, ca]).to_vec(),
        [a, b, c] => vec![[a, b, c]],
        _ => Vec::new(),
    });
    let sites = bundle.info.gauges.iter().map(|gauge| GaugeSite {
        name: gauge.name.clone(),
        position_m: gauge.position_m,
        axis: gauge.axis,
    });
    let picture = LimbPicture {
        title: bundle.info.scene.clone(),
        triangles: faces.collect(),
        gauges: sites.collect(),
        view_from: view_from(skin.normals(), &Vector3::zeros()),
        ..drawn_points(skin.nodes(), skin.normals())
    };
    let surface = Surface::new(skin.nodes().to_vec(), skin.normals().to_vec());
    (picture, surface)
}

fn drawn_points(points: &[Point3<f64>], normals: &[Vector3<f64>]) -> LimbPicture {
    LimbPicture {
        vertices_m: points.iter().map(|p| p.coords.map(|c| c as f32).into()).collect(),
        normals: normals.iter().map(|n| n.map(|c| c as f32).into()).collect(),
        ..LimbPicture::default()
    }
}

/// The four flat triangles of a six-node face.
fn parts([a, b, c, ab, bc, ca]: [u32; 6]) -> [[u32; 3]; 4] {
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
}

/// Where most of the skin looks, turned by 40° so that arrows are seen from the side.
fn view_from(normals: &[Vector3<f64>], axis: &Vector3<f64>) -> Option<[f64; 3]> {
    let sum: Vector3<f64> = normals.iter().sum();
    let across = axis.try_normalize(0.0).map_or(sum, |axis| sum - axis * axis.dot(&sum));
    let facing = across.try_normalize(1e-6 * normals.len() as f64)?;
    let side = axis.cross(&facing);
    let (sin, cos) = 40_f64.to_radians().sin_cos();
    Some((facing * cos + side.try_normalize(0.0).unwrap_or_default() * sin).into())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use hapdef::scene::read_scene;

    use super::*;

    /// A contact anywhere on the skin is on what the demo draws: it neither floats nor is inside.
    #[test]
    fn the_demo_draws_what_can_be_touched() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/shin");
        let scene = read_scene(&folder.join("demo.json")).unwrap();
        let limb = Limb::load(&scene, &folder).unwrap();
        assert!(DrawnSkin::load(&scene, &folder, &limb).unwrap().is_none());
        let picture = boundary(&limb);
        let touchable = limb.surface_points();
        let as_drawn = |p: &Point3<f64>| <[f32; 3]>::from(p.coords.map(|c| c as f32));
        let expected: Vec<[f32; 3]> = touchable.iter().map(as_drawn).collect();
        assert_eq!(picture.vertices_m[..touchable.len()], expected);
        let mut is_drawn = vec![false; touchable.len()];
        for node in picture.triangles.as_flattened() {
            if let Some(drawn) = is_drawn.get_mut(*node as usize) {
                *drawn = true;
            }
        }
        assert!(is_drawn.iter().all(|drawn| *drawn));
    }
}
