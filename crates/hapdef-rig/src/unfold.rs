//! Uniform refinement of meshes whose curved elements fold near a corner.

use hapdef_mesh::{MeshError, TET10_EDGES, Tet10Mesh, tet10};
use nalgebra::Point3;

/// Times neighbours of straightened elements are looked at again.
const MAX_ROUNDS: usize = 8;

/// A refined mesh and what had to be straightened for it.
pub(crate) struct Refined {
    /// The mesh, every element cut into eight.
    pub(crate) mesh: Tet10Mesh,
    /// Parent elements whose edges were straightened.
    pub(crate) n_straightened: usize,
}

/// Refines a mesh. A curved element may be usable as a whole and still fold over between its Gauss
/// points, so that one of its eight parts is inside out; such an element's mid-side nodes are put
/// on the middle of their edges first.
///
/// # Errors
/// [`MeshError`] when parts stay inside out with straight edges, too.
pub(crate) fn refine_unfolded(mesh: &Tet10Mesh) -> Result<Refined, MeshError> {
    let mut nodes = mesh.nodes().to_vec();
    let mut straightened = vec![false; mesh.elements().len()];
    for _ in 0..MAX_ROUNDS {
        let parent = Tet10Mesh::new(nodes.clone(), mesh.elements().to_vec())?;
        let refined = parent.refine();
        let folded: Vec<usize> = (0..mesh.elements().len())
            .filter(|&element| {
                (8 * element..8 * element + 8)
                    .any(|part| is_folded(&refined.element_positions(part)))
            })
            .collect();
        if folded.is_empty() {
            let n_straightened = straightened.iter().filter(|s| **s).count();
            return Ok(Refined {
                mesh: refined,
                n_straightened,
            });
        }
        for element in folded {
            straightened[element] = true;
            let ids = mesh.elements()[element];
            for (mid, [a, b]) in (4..).zip(TET10_EDGES) {
                let ends = nodes[ids[a].index()].coords + nodes[ids[b].index()].coords;
                nodes[ids[mid].index()] = (ends / 2.0).into();
            }
        }
    }
    let parent = Tet10Mesh::new(nodes, mesh.elements().to_vec())?;
    let refined = parent.refine();
    let mesh = Tet10Mesh::new(refined.nodes().to_vec(), refined.elements().to_vec())?;
    Ok(Refined {
        mesh,
        n_straightened: straightened.iter().filter(|s| **s).count(),
    })
}

/// Whether an element is inside out at a Gauss point or in its corner tetrahedron.
pub(crate) fn is_folded(p: &[Point3<f64>; 10]) -> bool {
    let corner_volume = (p[1] - p[0]).cross(&(p[2] - p[0])).dot(&(p[3] - p[0]));
    corner_volume <= 0.0 || tet10::min_gauss_jacobian(p) <= 0.0
}

#[cfg(test)]
mod tests {
    use hapdef_mesh::FeNodeId;

    use super::*;

    /// One tetrahedron; `shift` moves the middle of edge 0–1 along it towards corner 0.
    fn bent(shift: f64) -> Tet10Mesh {
        let corners = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
        ];
        let mut nodes: Vec<Point3<f64>> = corners.map(Point3::from).to_vec();
        for [a, b] in TET10_EDGES {
            nodes.push(nalgebra::center(&nodes[a], &nodes[b]));
        }
        nodes[4].x -= shift;
        Tet10Mesh::new(nodes, vec![std::array::from_fn(FeNodeId::from_index)]).unwrap()
    }

    #[test]
    fn a_mild_bend_is_kept() {
        let refined = refine_unfolded(&bent(0.1)).unwrap();
        assert_eq!(refined.n_straightened, 0);
        assert_eq!(refined.mesh, bent(0.1).refine());
    }

    #[test]
    fn a_fold_is_straightened_and_counted() {
        let folded = bent(0.45);
        assert!(tet10::min_gauss_jacobian(&folded.element_positions(0)) > 0.0);
        assert!(
            (0..8).any(|part| is_folded(&folded.refine().element_positions(part))),
            "the example does not fold"
        );
        let refined = refine_unfolded(&folded).unwrap();
        assert_eq!(refined.n_straightened, 1);
        assert_eq!(refined.mesh, bent(0.0).refine());
    }
}
