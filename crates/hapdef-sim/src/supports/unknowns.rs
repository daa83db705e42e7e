//! How the motions of nodes follow from the unknowns of the linear system.
//!
//! An unknown is a three-vector at a *place* in elimination order. Most motions are an unknown of
//! their own; a clamped one is zero, one in a symmetry plane is the unknown without its part along
//! the normal, and a node of a rigid body follows the body's translation and rotation.

use hapdef_mesh::FeNodeId;
use nalgebra::{Matrix3, Point3, Vector3};

use crate::SimError;
use crate::loads::nodal::check_node;
use crate::supports::conditions::{Held, RigidBody};

/// The unknowns and what every motion takes from them: u_motion = Σ T u_place.
#[derive(Debug)]
pub(crate) struct Unknowns {
    n_fe_nodes: usize,
    motions_per_node: usize,
    /// `[n_motions]`; node i has motions from `i · motions_per_node` on.
    links: Vec<Link>,
    /// `[n_places]`.
    owners: Vec<Owner>,
}

/// What one motion takes from the unknowns.
#[derive(Clone, Debug)]
pub(crate) enum Link {
    /// Held at zero.
    Fixed,
    /// The unknown at a place.
    Free(u32),
    /// The unknown at a place, projected.
    Roller(u32, Box<Matrix3<f64>>),
    /// u = t + ω × arm with t and ω the unknowns at two places.
    Tied {
        /// Place of t.
        translation: u32,
        /// Place of ω.
        rotation: u32,
        /// From the body's centre to the node, m.
        arm: Vector3<f64>,
    },
}

/// Whose motion an unknown is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Owner {
    /// The node, or the first node of the body.
    pub(crate) node: FeNodeId,
    /// Whether it is a rotation.
    pub(crate) is_rotation: bool,
}

impl Unknowns {
    /// Unknowns in the order of nodes, those of rigid bodies last.
    ///
    /// # Errors
    /// [`SimError::AllClamped`], [`SimError::RigidBodyHeld`], [`SimError::RigidBodyTooSmall`],
    /// [`SimError::NodeOutOfRange`].
    pub(crate) fn natural(
        positions: &[Point3<f64>],
        motions_per_node: usize,
        held: &Held,
        rigid_bodies: &[RigidBody],
    ) -> Result<Self, SimError> {
        let mut unknowns = Self {
            n_fe_nodes: positions.len(),
            motions_per_node,
            links: vec![Link::Fixed; motions_per_node * positions.len()],
            owners: Vec::new(),
        };
        let rigid_body_of = rigid_body_of_node(positions, rigid_bodies)?;
        for node in 0..positions.len() {
            for second in 0..motions_per_node {
                let motion = motions_per_node * node + second;
                match rigid_body_of[node] {
                    Some(rigid_body) if !held.directions[motion].is_empty() => {
                        return Err(SimError::RigidBodyHeld { rigid_body, node });
                    }
                    Some(_) => {}
                    None => unknowns.add_own(motion, node, second == 1, held),
                }
            }
        }
        for (index, rigid_body) in rigid_bodies.iter().enumerate() {
            unknowns.add_rigid_body(index, rigid_body, positions)?;
        }
        if unknowns.owners.is_empty() {
            let n_nodes = positions.len();
            return Err(SimError::AllClamped { n_nodes });
        }
        Ok(unknowns)
    }

    fn add_own(&mut self, motion: usize, node: usize, is_rotation: bool, held: &Held) {
        if held.is_fixed(motion) {
            return;
        }
        let place = self.add_owner(FeNodeId::from_index(node), is_rotation);
        let directions = &held.directions[motion];
        self.links[motion] = if directions.is_empty() {
            Link::Free(place)
        } else {
            let along = directions.iter().map(|d| d * d.transpose());
            Link::Roller(place, Box::new(Matrix3::identity() - along.sum::<Matrix3<f64>>()))
        };
    }

    fn add_rigid_body(
        &mut self,
        index: usize,
        rigid_body: &RigidBody,
        positions: &[Point3<f64>],
    ) -> Result<(), SimError> {
        let mut nodes = rigid_body.nodes.clone();
        nodes.sort_unstable();
        nodes.dedup();
        let at = |node: &FeNodeId| positions[node.index()];
        if !spans_a_plane(&nodes.iter().map(at).collect::<Vec<_>>()) {
            let n_nodes = nodes.len();
            return Err(SimError::RigidBodyTooSmall { rigid_body: index, n_nodes });
        }
        let sum: Vector3<f64> = nodes.iter().map(|node| at(node).coords).sum();
        let centre = Point3::from(sum / nodes.len() as f64);
        let translation = self.add_owner(nodes[0], false);
        let rotation = self.add_owner(nodes[0], true);
        for node in &nodes {
            let motion = self.motions_per_node * node.index();
            self.links[motion] = Link::Tied { translation, rotation, arm: at(node) - centre };
            if self.motions_per_node == 2 {
                self.links[motion + 1] = Link::Free(rotation);
            }
        }
        Ok(())
    }

    fn add_owner(&mut self, node: FeNodeId, is_rotation: bool) -> u32 {
        self.owners.push(Owner { node, is_rotation });
        (self.owners.len() - 1) as u32
    }

    /// The same unknowns in another order: `sequence[new place] = old place`.
    pub(crate) fn reordered(mut self, sequence: &[u32]) -> Self {
        let mut new_place = vec![0; sequence.len()];
        for (new, &old) in sequence.iter().enumerate() {
            new_place[old as usize] = new as u32;
        }
        for link in &mut self.links {
            match link {
                Link::Fixed => {}
                Link::Free(place) | Link::Roller(place, _) => *place = new_place[*place as usize],
                Link::Tied { translation, rotation, .. } => {
                    *translation = new_place[*translation as usize];
                    *rotation = new_place[*rotation as usize];
                }
            }
        }
        self.owners = sequence.iter().map(|&old| self.owners[old as usize]).collect();
        self
    }

    /// Nodes of the mesh, clamped ones included.
    pub(crate) fn n_fe_nodes(&self) -> usize {
        self.n_fe_nodes
    }

    /// Motions of a node: 1 or 2.
    pub(crate) fn motions_per_node(&self) -> usize {
        self.motions_per_node
    }

    /// Unknown three-vectors.
    pub(crate) fn n_places(&self) -> usize {
        self.owners.len()
    }

    /// Whose unknown is at each place.
    pub(crate) fn owners(&self) -> &[Owner] {
        &self.owners
    }

    /// What a motion takes from the unknowns.
    pub(crate) fn link(&self, motion: usize) -> &Link {
        &self.links[motion]
    }

    /// The translation of a node.
    pub(crate) fn translation(&self, node: FeNodeId) -> &Link {
        &self.links[self.motions_per_node * node.index()]
    }

    /// The rotation of a node, where nodes have one.
    pub(crate) fn rotation(&self, node: FeNodeId) -> Option<&Link> {
        (self.motions_per_node == 2).then(|| &self.links[2 * node.index() + 1])
    }

    /// All links.
    pub(crate) fn links(&self) -> &[Link] {
        &self.links
    }
}

impl Link {
    /// The places this motion depends on.
    pub(crate) fn places(&self) -> impl Iterator<Item = usize> + use<> {
        let (first, second) = match *self {
            Self::Fixed => (None, None),
            Self::Free(place) | Self::Roller(place, _) => (Some(place), None),
            Self::Tied { translation, rotation, .. } => (Some(translation), Some(rotation)),
        };
        first.into_iter().chain(second).map(|place| place as usize)
    }

    /// Places and matrices T of u = Σ T u_place.
    pub(crate) fn terms(&self) -> impl Iterator<Item = (usize, Matrix3<f64>)> + use<> {
        let mut terms = [None, None];
        match self {
            Self::Fixed => {}
            Self::Free(place) => terms[0] = Some((*place as usize, Matrix3::identity())),
            Self::Roller(place, projector) => terms[0] = Some((*place as usize, **projector)),
            Self::Tied { translation, rotation, arm } => {
                terms[0] = Some((*translation as usize, Matrix3::identity()));
                terms[1] = Some((*rotation as usize, -arm.cross_matrix()));
            }
        }
        terms.into_iter().flatten()
    }

    /// The motion, from the unknowns by place.
    pub(crate) fn motion(&self, unknown: impl Fn(usize) -> Vector3<f64>) -> Vector3<f64> {
        match self {
            Self::Fixed => Vector3::zeros(),
            Self::Free(place) => unknown(*place as usize),
            Self::Roller(place, projector) => **projector * unknown(*place as usize),
            Self::Tied { translation, rotation, arm } => {
                unknown(*translation as usize) + unknown(*rotation as usize).cross(arm)
            }
        }
    }

    /// What a force on the motion is on the unknowns: (place, Tᵀ f).
    pub(crate) fn forces(&self, f: Vector3<f64>) -> impl Iterator<Item = (usize, Vector3<f64>)> {
        let mut terms = [None, None];
        match self {
            Self::Fixed => {}
            Self::Free(place) => terms[0] = Some((*place as usize, f)),
            Self::Roller(place, projector) => terms[0] = Some((*place as usize, **projector * f)),
            Self::Tied { translation, rotation, arm } => {
                terms[0] = Some((*translation as usize, f));
                terms[1] = Some((*rotation as usize, arm.cross(&f)));
            }
        }
        terms.into_iter().flatten()
    }
}

/// The rigid body that each node belongs to.
fn rigid_body_of_node(
    positions: &[Point3<f64>],
    rigid_bodies: &[RigidBody],
) -> Result<Vec<Option<usize>>, SimError> {
    let mut of = vec![None; positions.len()];
    for (rigid_body, body) in rigid_bodies.iter().enumerate() {
        for &node in &body.nodes {
            check_node("a rigid body", node, positions.len())?;
            match of[node.index()].replace(rigid_body) {
                Some(other) if other != rigid_body => {
                    return Err(SimError::RigidBodiesShareNode {
                        rigid_bodies: [other, rigid_body],
                        node: node.index(),
                    });
                }
                _ => {}
            }
        }
    }
    Ok(of)
}

/// Whether three of the points are not on a line: else the body could spin about it.
fn spans_a_plane(points: &[Point3<f64>]) -> bool {
    let Some(first) = points.first() else {
        return false;
    };
    let arms = || points.iter().map(|p| p - first);
    let Some(far) = arms().max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared())) else {
        return false;
    };
    let off_line = arms().map(|a| a.cross(&far).norm()).fold(0.0, f64::max);
    off_line > 1e-6 * far.norm_squared()
}
