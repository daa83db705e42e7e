//! What holds a limb beside clamped nodes, and what ties parts of it together.

use hapdef_mesh::{FeNodeId, Tri6Face, tri6};
use nalgebra::{Matrix3, Point3, SymmetricEigen, Vector3};

use crate::SimError;
use crate::loads::nodal::check_node;
use crate::loads::patch::unit;

/// Supports and ties beside clamped nodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Supports {
    /// Planes across which the limb and its loads go on as mirror images.
    pub symmetry: Vec<SymmetryPlane>,
    /// Winkler foundations.
    pub foundations: Vec<Foundation>,
    /// Rigid bodies (RBE2), each moving as one.
    pub rigid_bodies: Vec<RigidBody>,
    /// Single motions held at zero.
    pub holds: Vec<Hold>,
}

impl Supports {
    /// One rigid body of `nodes`, such as a flange that a stiff part is bolted to; nothing where there are none.
    #[must_use]
    pub fn of_rigid_body(nodes: &[FeNodeId]) -> Self {
        let body = (!nodes.is_empty()).then(|| RigidBody { nodes: nodes.to_vec() });
        Self { rigid_bodies: body.into_iter().collect(), ..Self::default() }
    }
}

/// Nodes that stay in a plane: they don't move along its normal and, where they have rotations,
/// turn only about it.
#[derive(Clone, Debug, PartialEq)]
pub struct SymmetryPlane {
    /// Nodes in the plane.
    pub nodes: Vec<FeNodeId>,
    /// The plane's normal, any length above 0.
    pub normal: Vector3<f64>,
}

/// Nodes whose motion along a direction is held at zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Hold {
    /// The nodes held.
    pub nodes: Vec<FeNodeId>,
    /// Whether their translation or their rotation is held.
    pub motion: HeldMotion,
    /// The direction that is held, any length above 0.
    pub direction: Vector3<f64>,
}

/// Which of a node's motions a [`Hold`] is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeldMotion {
    /// The displacement along the direction.
    Translation,
    /// The rotation about the direction; shells only.
    Rotation,
}

/// A Winkler foundation: a stress against the displacement, per metre, on some faces.
#[derive(Clone, Debug, PartialEq)]
pub struct Foundation {
    /// Where the foundation is.
    pub faces: FoundationFaces,
    /// Stress per displacement along the face's normal, N/m³.
    pub normal_n_m3: f64,
    /// Stress per displacement in the face's plane, N/m³.
    pub tangential_n_m3: f64,
}

/// Faces of a [`Foundation`].
#[derive(Clone, Debug, PartialEq)]
pub enum FoundationFaces {
    /// Boundary faces of ten-node tetrahedra.
    Solid(Vec<Tri6Face>),
    /// Triangles of a shell.
    Shell(Vec<[FeNodeId; 3]>),
}

/// Nodes tied to one rigid body, which moves freely (RBE2).
#[derive(Clone, Debug, PartialEq)]
pub struct RigidBody {
    /// Its nodes, at least three not on a line.
    pub nodes: Vec<FeNodeId>,
}

/// A spring between the translations of a face's nodes: fᵢ = Σ Kᵢⱼ uⱼ.
#[derive(Debug)]
pub(crate) struct FaceSpring {
    pub(crate) nodes: Vec<FeNodeId>,
    /// `[n_nodes, n_nodes]`, row-major, N/m.
    pub(crate) blocks: Vec<Matrix3<f64>>,
}

impl Foundation {
    /// Kᵢⱼ = ∫ Nᵢ Nⱼ (k_n n nᵀ + k_t (I − n nᵀ)) dA on each face (Cook, Malkus, Plesha and Witt,
    /// Concepts and Applications of Finite Element Analysis, 4th ed., section 8.7).
    pub(crate) fn springs(&self, positions: &[Point3<f64>]) -> Result<Vec<FaceSpring>, SimError> {
        for (what, value) in [
            ("a foundation's normal stiffness (N/m³)", self.normal_n_m3),
            ("a foundation's tangential stiffness (N/m³)", self.tangential_n_m3),
        ] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(SimError::Parameter {
                    what,
                    value,
                    expected: "finite and not negative",
                });
            }
        }
        let faces: Vec<Vec<FeNodeId>> = match &self.faces {
            FoundationFaces::Solid(faces) => faces.iter().map(|face| face.nodes.to_vec()).collect(),
            FoundationFaces::Shell(faces) => faces.iter().map(|face| face.to_vec()).collect(),
        };
        let spring = |nodes: Vec<FeNodeId>| {
            let points = six_points(&nodes, positions)?;
            Ok(self.spring(nodes, &points))
        };
        faces.into_iter().map(spring).collect()
    }

    fn spring(&self, nodes: Vec<FeNodeId>, points: &[Point3<f64>; 6]) -> FaceSpring {
        let n = nodes.len();
        let mut blocks = vec![Matrix3::zeros(); n * n];
        for q in tri6::QUADRATURE {
            let area = tri6::area_vector(points, q.xi, q.eta);
            let size = area.norm();
            if size == 0.0 {
                continue;
            }
            let along = area * area.transpose() / (size * size);
            let foundation =
                along * self.normal_n_m3 + (Matrix3::identity() - along) * self.tangential_n_m3;
            let six = tri6::shape(q.xi, q.eta);
            let three = [1.0 - q.xi - q.eta, q.xi, q.eta];
            let shape = if n == 3 { &three[..] } else { &six[..] };
            for i in 0..n {
                for j in 0..n {
                    blocks[n * i + j] += foundation * (shape[i] * shape[j] * size * q.weight);
                }
            }
        }
        FaceSpring { nodes, blocks }
    }
}

/// A face's six positions; mid-side points of a three-node face lie halfway.
fn six_points(nodes: &[FeNodeId], positions: &[Point3<f64>]) -> Result<[Point3<f64>; 6], SimError> {
    for &node in nodes {
        check_node("a foundation's face", node, positions.len())?;
    }
    let at = |i: usize| positions[nodes[i].index()];
    Ok(if nodes.len() == 6 {
        std::array::from_fn(at)
    } else {
        let middle = |a, b| nalgebra::center(&at(a), &at(b));
        [at(0), at(1), at(2), middle(0, 1), middle(1, 2), middle(2, 0)]
    })
}

/// What the supports forbid each motion: an orthonormal basis of its held directions.
pub(crate) struct Held {
    /// `[n_motions]`.
    pub(crate) directions: Vec<Vec<Vector3<f64>>>,
}

impl Held {
    /// Held directions of all motions; with rotations, motion 2i is node i's translation, 2i + 1
    /// its rotation.
    pub(crate) fn new(
        clamped: &[FeNodeId],
        supports: &Supports,
        n_nodes: usize,
        has_rotations: bool,
    ) -> Result<Self, SimError> {
        let per_node = 1 + usize::from(has_rotations);
        let mut held = Self { directions: vec![Vec::new(); per_node * n_nodes] };
        for &node in clamped {
            check_node("the list of clamped nodes", node, n_nodes)?;
            for motion in per_node * node.index()..per_node * (node.index() + 1) {
                for axis in 0..3 {
                    held.hold(motion, Vector3::ith(axis, 1.0));
                }
            }
        }
        for plane in &supports.symmetry {
            let normal = unit("the normal of a symmetry plane", &plane.normal)?;
            let tangents = tangents(&normal);
            for &node in &plane.nodes {
                check_node("a symmetry plane", node, n_nodes)?;
                let motion = per_node * node.index();
                held.hold(motion, normal);
                if has_rotations {
                    for tangent in tangents {
                        held.hold(motion + 1, tangent);
                    }
                }
            }
        }
        for hold in &supports.holds {
            let direction = unit("the direction of a hold", &hold.direction)?;
            let second = usize::from(hold.motion == HeldMotion::Rotation);
            for &node in &hold.nodes {
                check_node("a hold", node, n_nodes)?;
                if second >= per_node {
                    return Err(SimError::NoRotations { what: "a hold" });
                }
                held.hold(per_node * node.index() + second, direction);
            }
        }
        Ok(held)
    }

    /// Adds a direction to those held, by Gram and Schmidt.
    fn hold(&mut self, motion: usize, direction: Vector3<f64>) {
        let basis = &mut self.directions[motion];
        let new = basis.iter().fold(direction, |rest, b| rest - b * b.dot(&rest));
        if let Some(new) = new.try_normalize(1e-8) {
            basis.push(new);
        }
    }

    pub(crate) fn is_fixed(&self, motion: usize) -> bool {
        self.directions[motion].len() == 3
    }
}

/// Two unit vectors across `normal` and across each other.
pub(crate) fn tangents(normal: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let axis = Vector3::ith(normal.iamin(), 1.0);
    let first = axis - normal * axis.dot(normal);
    let first = first / first.norm();
    [first, normal.cross(&first)]
}

/// The directions in which a foundation holds each of its nodes.
pub(crate) fn foundation_directions(springs: &[FaceSpring]) -> Vec<(FeNodeId, Vector3<f64>)> {
    let mut on_foundations = Vec::new();
    for spring in springs {
        let sum: Matrix3<f64> = spring.blocks.iter().sum();
        let eigen = SymmetricEigen::new(sum);
        let largest = eigen.eigenvalues.amax();
        for (value, direction) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
            if *value > 1e-12 * largest {
                let direction = direction.into_owned();
                on_foundations.extend(spring.nodes.iter().map(|&node| (node, direction)));
            }
        }
    }
    on_foundations
}
