//! Nodes and faces by where they are.

use hapdef_mesh::{FeNodeId, Tet10Mesh, Tri6Face};
use nalgebra::Point3;

/// The nodes whose position satisfies `take`, ascending.
pub(crate) fn nodes_where(
    nodes: &[Point3<f64>],
    take: impl Fn(&Point3<f64>) -> bool,
) -> Vec<FeNodeId> {
    let nodes = nodes.iter().enumerate();
    nodes.filter(|(_, p)| take(p)).map(|(i, _)| FeNodeId::from_index(i)).collect()
}

/// The boundary faces all of whose six nodes satisfy `take`.
pub(crate) fn faces_where(mesh: &Tet10Mesh, take: impl Fn(&Point3<f64>) -> bool) -> Vec<Tri6Face> {
    let on = |face: &Tri6Face| face.nodes.iter().all(|&n| take(&mesh.position(n)));
    mesh.boundary().faces.into_iter().filter(on).collect()
}
