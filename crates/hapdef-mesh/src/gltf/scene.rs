//! Which meshes the scene shows, and where.

use gltf::json::scene::Node;
use gltf::json::{Index, Root};
use nalgebra::{Matrix4, Quaternion, UnitQuaternion, Vector3};

use super::GltfFault;
use super::source::found;
use crate::surface::triangles::linear_part;

/// How far a rotation's norm may be from 1; exporters store it in 32 bits or less.
const QUATERNION_SLACK: f64 = 1e-3;

/// One mesh placed in the world.
pub(super) struct Instance {
    pub node: Option<usize>,
    pub mesh: usize,
    pub world_from_mesh: Matrix4<f64>,
    pub is_skinned: bool,
}

/// The meshes of the default scene, or of all root nodes where no scene is the default, or of the
/// whole file where there are no nodes; depth first in file order.
pub(super) fn instances(root: &Root) -> Result<Vec<Instance>, GltfFault> {
    if root.nodes.is_empty() && root.scenes.is_empty() {
        return Ok((0..root.meshes.len()).map(alone).collect());
    }
    let mut visited = vec![false; root.nodes.len()];
    let mut instances = Vec::new();
    let mut pending: Vec<_> =
        top_nodes(root)?.into_iter().rev().map(|n| (n, Matrix4::identity())).collect();
    while let Some((index, world_from_parent)) = pending.pop() {
        if std::mem::replace(&mut visited[index], true) {
            return Err(GltfFault::NodeTwice { node: index });
        }
        let node = &root.nodes[index];
        let world_from_node = world_from_parent * parent_from_node(node, index)?;
        check_affine(&world_from_node, index)?;
        if let Some(mesh) = node.mesh {
            let mesh = mesh.value();
            found(&root.meshes, mesh, &format!("nodes[{index}].mesh"), "mesh")?;
            instances.push(Instance {
                node: Some(index),
                mesh,
                world_from_mesh: world_from_node,
                is_skinned: node.skin.is_some(),
            });
        }
        let children = checked_nodes(root, children(node), &format!("nodes[{index}].children"))?;
        pending.extend(children.into_iter().rev().map(|child| (child, world_from_node)));
    }
    Ok(instances)
}

fn alone(mesh: usize) -> Instance {
    Instance { node: None, mesh, world_from_mesh: Matrix4::identity(), is_skinned: false }
}

/// The nodes to begin at: none may be the child of another.
fn top_nodes(root: &Root) -> Result<Vec<usize>, GltfFault> {
    let is_child = is_child(root)?;
    if let Some(scene) = root.scene {
        let scene_idx = scene.value();
        let scene = found(&root.scenes, scene_idx, "scene", "scene")?;
        let place = format!("scenes[{scene_idx}].nodes");
        let tops = checked_nodes(root, &scene.nodes, &place)?;
        return match tops.iter().find(|&&n| is_child[n]) {
            None => Ok(tops),
            Some(&node) => Err(GltfFault::SceneNotRoot { scene: scene_idx, node }),
        };
    }
    let tops: Vec<_> = (0..root.nodes.len()).filter(|&n| !is_child[n]).collect();
    // Nodes that are all children of one another have no root.
    if tops.is_empty() && !root.nodes.is_empty() {
        return Err(GltfFault::NodeTwice { node: 0 });
    }
    Ok(tops)
}

fn is_child(root: &Root) -> Result<Vec<bool>, GltfFault> {
    let mut is_child = vec![false; root.nodes.len()];
    for (index, node) in root.nodes.iter().enumerate() {
        for child in checked_nodes(root, children(node), &format!("nodes[{index}].children"))? {
            is_child[child] = true;
        }
    }
    Ok(is_child)
}

fn children(node: &Node) -> &[Index<Node>] {
    node.children.as_deref().unwrap_or_default()
}

fn checked_nodes(root: &Root, nodes: &[Index<Node>], place: &str) -> Result<Vec<usize>, GltfFault> {
    let checked =
        |node: &Index<Node>| found(&root.nodes, node.value(), place, "node").map(|_| node.value());
    nodes.iter().map(checked).collect()
}

/// A node's own transform, T·R·S or its matrix: specification, section 3.5.2.
fn parent_from_node(node: &Node, index: usize) -> Result<Matrix4<f64>, GltfFault> {
    let fault = |why| GltfFault::NodeTransform { node: index, why };
    let has_trs = node.translation.is_some() || node.rotation.is_some() || node.scale.is_some();
    match node.matrix {
        Some(_) if has_trs => Err(fault("has a matrix beside translation, rotation or scale")),
        Some(matrix) => Ok(Matrix4::from_iterator(matrix.map(f64::from))),
        None => {
            let translation = Vector3::from(node.translation.unwrap_or_default().map(f64::from));
            let scale = Vector3::from(node.scale.unwrap_or([1.0; 3]).map(f64::from));
            let rotation = rotation(node).ok_or(fault("its rotation is not a unit quaternion"))?;
            Ok(Matrix4::new_translation(&translation)
                * rotation.to_homogeneous()
                * Matrix4::new_nonuniform_scaling(&scale))
        }
    }
}

fn rotation(node: &Node) -> Option<UnitQuaternion<f64>> {
    let [x, y, z, w] = node.rotation.unwrap_or_default().0.map(f64::from);
    let quaternion = Quaternion::new(w, x, y, z);
    let is_unit = (quaternion.norm() - 1.0).abs() <= QUATERNION_SLACK;
    is_unit.then(|| UnitQuaternion::from_quaternion(quaternion))
}

fn check_affine(map: &Matrix4<f64>, node: usize) -> Result<(), GltfFault> {
    let fault = |why| Err(GltfFault::NodeTransform { node, why });
    if !map.iter().all(|x| x.is_finite()) {
        return fault("its transform is not finite");
    }
    if map.row(3) != Matrix4::identity().row(3) {
        return fault("the last row of its matrix is not 0 0 0 1");
    }
    let linear = linear_part(map);
    // Relative to the product of the columns' lengths, so that small scales are no fault.
    let scale: f64 = linear.column_iter().map(|c| c.norm()).product();
    if linear.determinant().abs() <= 1e-9 * scale {
        return fault("its transform flattens the mesh (determinant 0)");
    }
    Ok(())
}
