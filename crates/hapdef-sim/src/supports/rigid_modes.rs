//! Which rigid motions the supports leave free.
//!
//! Elements that can't move against each other without deforming form a rigid part, and so does a
//! rigid body. Each part has six unknowns (a translation and a rotation); a held direction fixes
//! its part there, a shared node ties two parts. What is left in the null space is a free motion.
//! The check is about rigid parts, so it costs nothing beside a factorisation.

use hapdef_mesh::FeNodeId;
use nalgebra::{DMatrix, Point3, Vector3};

use super::floating_body::{FloatingBody, RigidMotion};
use crate::SimError;
use crate::elements::element_set::Elements;
use crate::elements::parts::DisjointSets;
use crate::supports::conditions::{Held, RigidBody};
use crate::supports::null_space::{null_space, readable_basis};

/// Bodies with more hinged parts than this are left to the factorisation's pivot check.
const MAX_PARTS: usize = 100;

/// What holds and ties the rigid parts.
pub(crate) struct Restraints<'a> {
    /// Held directions of every motion.
    pub(crate) held: &'a Held,
    /// Nodes and directions, m, that a Winkler foundation holds.
    pub(crate) on_foundations: Vec<(FeNodeId, Vector3<f64>)>,
    /// Nodes that move as one body.
    pub(crate) rigid_bodies: &'a [RigidBody],
}

/// Checks that every connected body is held.
///
/// # Errors
/// [`SimError::FreeRigidModes`] naming each body that can move, and how.
pub(crate) fn check_supports(
    elements: &dyn Elements,
    restraints: &Restraints<'_>,
) -> Result<(), SimError> {
    let (parts, n) = (elements.rigid_parts(), elements.n_elements());
    let members = sorted_members(elements, &parts, restraints.rigid_bodies);
    let bodies = bodies(&members, n + restraints.rigid_bodies.len());
    let distinct = distinct_bodies(&bodies, &parts);
    let n_bodies = distinct.len();
    let limb = Limb {
        positions: elements.positions(),
        has_rotations: elements.has_rotations(),
        conditions: Conditions::new(elements, restraints),
    };
    let mut floating = Vec::new();
    for body in distinct {
        floating.extend(Body::new(body, &bodies, &parts, n, &members).floating(&limb));
    }
    if floating.is_empty() {
        Ok(())
    } else {
        Err(SimError::FreeRigidModes { n_bodies, bodies: floating })
    }
}

/// Directions that are held at each node: t · u + w · ω = 0.
struct Conditions {
    /// `(node, t, w)`, sorted by node.
    rows: Vec<(FeNodeId, Vector3<f64>, Vector3<f64>)>,
}

impl Conditions {
    fn new(elements: &dyn Elements, restraints: &Restraints<'_>) -> Self {
        let per_node = elements.motions_per_node();
        let mut rows = Vec::new();
        for (motion, directions) in restraints.held.directions.iter().enumerate() {
            let node = FeNodeId::from_index(motion / per_node);
            rows.extend(directions.iter().map(|&d| match motion % per_node {
                0 => (node, d, Vector3::zeros()),
                _ => (node, Vector3::zeros(), d),
            }));
        }
        let on_foundations = restraints.on_foundations.iter();
        rows.extend(on_foundations.map(|&(node, d)| (node, d, Vector3::zeros())));
        rows.sort_by_key(|row| row.0);
        Self { rows }
    }

    fn at(&self, node: FeNodeId) -> &[(FeNodeId, Vector3<f64>, Vector3<f64>)] {
        let begin = self.rows.partition_point(|row| row.0 < node);
        let end = self.rows.partition_point(|row| row.0 <= node);
        &self.rows[begin..end]
    }
}

/// What a body's check needs of the limb.
struct Limb<'a> {
    positions: &'a [Point3<f64>],
    has_rotations: bool,
    conditions: Conditions,
}

/// `(node, part)` of every node of every part, sorted, each once; the parts of rigid bodies come after
/// those of elements.
fn sorted_members(
    elements: &dyn Elements,
    parts: &[usize],
    rigid_bodies: &[RigidBody],
) -> Vec<(FeNodeId, usize)> {
    let of_elements = parts.iter().enumerate().flat_map(|(element, &part)| {
        let nodes = elements.nodes(element).iter();
        nodes.map(move |&node| (node, part))
    });
    let of_rigid_bodies = rigid_bodies.iter().enumerate().flat_map(|(rigid_body, body)| {
        let nodes = body.nodes.iter();
        nodes.map(move |&node| (node, parts.len() + rigid_body))
    });
    let mut members: Vec<(FeNodeId, usize)> = of_elements.chain(of_rigid_bodies).collect();
    members.sort_unstable();
    members.dedup();
    members
}

/// For each part (named by its first element), the first part of its node-connected body.
fn bodies(members: &[(FeNodeId, usize)], n_parts: usize) -> Vec<usize> {
    let mut sets = DisjointSets::new(n_parts);
    for pair in members.windows(2) {
        if pair[0].0 == pair[1].0 {
            sets.join(pair[0].1, pair[1].1);
        }
    }
    sets.roots()
}

fn distinct_bodies(bodies: &[usize], parts: &[usize]) -> Vec<usize> {
    let mut distinct: Vec<usize> = parts.iter().map(|&part| bodies[part]).collect();
    distinct.sort_unstable();
    distinct.dedup();
    distinct
}

/// One node-connected body: its rigid parts and the nodes of each.
struct Body {
    first_element: usize,
    n_elements: usize,
    parts: Vec<usize>,
    /// `(node, place in parts)`, sorted.
    members: Vec<(FeNodeId, usize)>,
}

impl Body {
    fn new(
        body: usize,
        bodies: &[usize],
        part_of_element: &[usize],
        n_elements_in_all: usize,
        members: &[(FeNodeId, usize)],
    ) -> Self {
        let mine = |part: usize| bodies[part] == body;
        let mut parts: Vec<usize> = part_of_element.iter().copied().filter(|&p| mine(p)).collect();
        let n_elements = parts.len();
        parts.extend((n_elements_in_all..bodies.len()).filter(|&rigid_body| mine(rigid_body)));
        parts.sort_unstable();
        parts.dedup();
        let members = members
            .iter()
            .filter(|(_, part)| mine(*part))
            .map(|&(node, part)| (node, parts.partition_point(|&p| p < part)))
            .collect();
        Self { first_element: body, n_elements, parts, members }
    }

    fn floating(&self, limb: &Limb<'_>) -> Option<FloatingBody> {
        if self.parts.len() > MAX_PARTS {
            return None;
        }
        let (centre_m, radius_m) = self.extent(limb.positions);
        let gram = self.constraints(limb, &centre_m, radius_m);
        let modes = null_space(gram);
        if modes.ncols() == 0 {
            return None;
        }
        let part = self.most_moving_part(&modes);
        let free = readable_basis(&modes.rows(6 * part, 6).into_owned())
            .into_iter()
            .map(|m| RigidMotion { centre_m, translation: m.0 * radius_m, rotation: m.1 })
            .collect();
        let held = |node: &FeNodeId| !limb.conditions.at(*node).is_empty();
        let n_held = self.nodes().filter(held).count();
        let (first_element, n_elements) = (self.first_element, self.n_elements);
        Some(FloatingBody { first_element, n_elements, centre_m, n_held, free })
    }

    fn nodes(&self) -> impl Iterator<Item = FeNodeId> {
        self.members.chunk_by(|a, b| a.0 == b.0).map(|group| group[0].0)
    }

    fn extent(&self, positions: &[Point3<f64>]) -> (Point3<f64>, f64) {
        let n = self.nodes().count() as f64;
        let sum: Vector3<f64> = self.nodes().map(|node| positions[node.index()].coords).sum();
        let centre = Point3::from(sum / n);
        let radius =
            self.nodes().map(|node| (positions[node.index()] - centre).norm()).fold(0.0, f64::max);
        (centre, radius)
    }

    /// Σ CᵀC over all constraints on the parts' motions, in units of the body's radius.
    fn constraints(&self, limb: &Limb<'_>, centre: &Point3<f64>, radius_m: f64) -> DMatrix<f64> {
        let mut gram = DMatrix::zeros(6 * self.parts.len(), 6 * self.parts.len());
        for group in self.members.chunk_by(|a, b| a.0 == b.0) {
            let node = group[0].0;
            let x = (limb.positions[node.index()] - centre) / radius_m;
            for (_, t, w) in limb.conditions.at(node) {
                for &(_, part) in group {
                    add_constraint(&mut gram, &[(part, *t, x.cross(t) + w)]);
                }
            }
            for pair in group.windows(2) {
                tie(&mut gram, &x, [pair[0].1, pair[1].1], limb.has_rotations);
            }
        }
        gram
    }

    fn most_moving_part(&self, modes: &DMatrix<f64>) -> usize {
        let motion = |part: usize| modes.rows(6 * part, 6).norm_squared();
        (0..self.parts.len()).fold(0, |best, p| if motion(p) > motion(best) { p } else { best })
    }
}

/// Ties two parts where they share the node at `x`: the same displacement t + ω × x, and the same
/// rotation where the node has one.
fn tie(gram: &mut DMatrix<f64>, x: &Vector3<f64>, parts: [usize; 2], has_rotations: bool) {
    let [a, b] = parts;
    let zero = Vector3::zeros();
    for axis in 0..3 {
        let e = Vector3::ith(axis, 1.0);
        // e · (ω × x) = ω · (x × e)
        let turn = x.cross(&e);
        add_constraint(gram, &[(a, e, turn), (b, -e, -turn)]);
        if has_rotations {
            add_constraint(gram, &[(a, zero, e), (b, zero, -e)]);
        }
    }
}

/// Adds (Σ t · t_part + w · ω_part)².
fn add_constraint(gram: &mut DMatrix<f64>, terms: &[(usize, Vector3<f64>, Vector3<f64>)]) {
    let row = || {
        terms.iter().flat_map(|&(part, t, w)| {
            (0..3).flat_map(move |c| [(6 * part + c, t[c]), (6 * part + 3 + c, w[c])])
        })
    };
    for (i, a) in row() {
        for (j, b) in row() {
            gram[(i, j)] += a * b;
        }
    }
}
