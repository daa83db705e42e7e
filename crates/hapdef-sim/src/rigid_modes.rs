//! Which rigid motions the supports leave free.
//!
//! Elements joined by faces form a rigid part; parts joined only by nodes or edges can still hinge.
//! Each part has six unknowns (a translation and a rotation); a clamped node fixes its part there,
//! a shared node ties two parts. What is left in the null space is a free motion. The check is
//! about rigid parts, so it costs nothing beside a factorisation.

use std::fmt;

use hapdef_mesh::{FeNodeId, Tet10Mesh};
use nalgebra::{DMatrix, Point3, SymmetricEigen, Vector3};

use crate::SimError;

/// A body that the supports do not hold.
#[derive(Clone, Debug, PartialEq)]
pub struct FloatingBody {
    /// The first of its elements, counted from 0.
    pub first_element: usize,
    /// How many elements it has.
    pub n_elements: usize,
    /// The mean of its nodes, m.
    pub centre_m: Point3<f64>,
    /// How many of its nodes are clamped.
    pub n_clamped: usize,
    /// A basis of its free motions; for a body with hinges, the motion of the part that moves most.
    pub free: Vec<RigidMotion>,
}

/// A small rigid motion u(x) = translation + rotation × (x − centre).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidMotion {
    /// The point the rotation is taken about, m.
    pub centre_m: Point3<f64>,
    /// Translation, m, at the scale where the rotation below moves the body by its own size.
    pub translation: Vector3<f64>,
    /// Rotation vector, rad.
    pub rotation: Vector3<f64>,
}

impl fmt::Display for RigidMotion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let angle_2 = self.rotation.norm_squared();
        if angle_2 == 0.0 {
            let [x, y, z] = (self.translation / self.translation.norm()).into();
            return write!(f, "translation along ({x:.3}, {y:.3}, {z:.3})");
        }
        let foot = self.centre_m + self.rotation.cross(&self.translation) / angle_2;
        let [x, y, z] = (self.rotation / angle_2.sqrt()).into();
        write!(
            f,
            "rotation about ({x:.3}, {y:.3}, {z:.3}) through ({:.4}, {:.4}, {:.4}) m",
            foot.x, foot.y, foot.z
        )
    }
}

impl fmt::Display for FloatingBody {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let c = &self.centre_m;
        write!(
            f,
            "the body of {} elements from element {} on, centred at ({:.4}, {:.4}, {:.4}) m with {} \
             clamped nodes, has {} free motions: ",
            self.n_elements,
            self.first_element,
            c.x,
            c.y,
            c.z,
            self.n_clamped,
            self.free.len()
        )?;
        let free: Vec<String> = self.free.iter().map(ToString::to_string).collect();
        f.write_str(&free.join(", "))
    }
}

/// Bodies with more hinged parts than this are left to the factorisation's pivot check.
const MAX_PARTS: usize = 100;

/// Singular values below this share of the largest count as free.
const FREE_BELOW: f64 = 1e-6;

/// Checks that `clamped` (per node) holds every connected body of `mesh`.
///
/// # Errors
/// [`SimError::FreeRigidModes`] naming each body that can move, and how.
pub(crate) fn check_supports(mesh: &Tet10Mesh, clamped: &[bool]) -> Result<(), SimError> {
    let parts = parts(mesh);
    let members = sorted_members(mesh, &parts);
    let bodies = bodies(&members, parts.len());
    let distinct = distinct_bodies(&bodies, &parts);
    let n_bodies = distinct.len();
    let mut floating = Vec::new();
    for body in distinct {
        floating.extend(Body::new(body, &bodies, &parts, &members).floating(mesh, clamped));
    }
    if floating.is_empty() {
        Ok(())
    } else {
        Err(SimError::FreeRigidModes {
            n_bodies,
            bodies: floating,
        })
    }
}

fn root(parent: &mut [usize], mut i: usize) -> usize {
    while parent[i] != i {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    i
}

fn join(parent: &mut [usize], a: usize, b: usize) {
    let (a, b) = (root(parent, a), root(parent, b));
    parent[a.max(b)] = a.min(b);
}

/// For each element, the first element of the face-connected part it belongs to.
fn parts(mesh: &Tet10Mesh) -> Vec<usize> {
    let elements = mesh.elements();
    let mut faces: Vec<([FeNodeId; 3], usize)> = elements
        .iter()
        .enumerate()
        .flat_map(|(element, n)| {
            [
                [n[0], n[1], n[2]],
                [n[0], n[1], n[3]],
                [n[1], n[2], n[3]],
                [n[0], n[2], n[3]],
            ]
            .map(|mut face| {
                face.sort_unstable();
                (face, element)
            })
        })
        .collect();
    faces.sort_unstable();
    let mut parent: Vec<usize> = (0..elements.len()).collect();
    for pair in faces.windows(2) {
        if pair[0].0 == pair[1].0 {
            join(&mut parent, pair[0].1, pair[1].1);
        }
    }
    (0..elements.len())
        .map(|element| root(&mut parent, element))
        .collect()
}

/// `(node, part)` of every node of every part, sorted, each once.
fn sorted_members(mesh: &Tet10Mesh, parts: &[usize]) -> Vec<(FeNodeId, usize)> {
    let mut members: Vec<(FeNodeId, usize)> = mesh
        .elements()
        .iter()
        .zip(parts)
        .flat_map(|(nodes, &part)| nodes.map(|node| (node, part)))
        .collect();
    members.sort_unstable();
    members.dedup();
    members
}

/// For each part (named by its first element), the first part of its node-connected body.
fn bodies(members: &[(FeNodeId, usize)], n_elements: usize) -> Vec<usize> {
    let mut parent: Vec<usize> = (0..n_elements).collect();
    for pair in members.windows(2) {
        if pair[0].0 == pair[1].0 {
            join(&mut parent, pair[0].1, pair[1].1);
        }
    }
    (0..n_elements)
        .map(|part| root(&mut parent, part))
        .collect()
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
        members: &[(FeNodeId, usize)],
    ) -> Self {
        let mine = |part: usize| bodies[part] == body;
        let mut parts: Vec<usize> = part_of_element
            .iter()
            .copied()
            .filter(|&p| mine(p))
            .collect();
        let n_elements = parts.len();
        parts.sort_unstable();
        parts.dedup();
        let members = members
            .iter()
            .filter(|(_, part)| mine(*part))
            .map(|&(node, part)| (node, parts.partition_point(|&p| p < part)))
            .collect();
        Self {
            first_element: body,
            n_elements,
            parts,
            members,
        }
    }

    fn floating(&self, mesh: &Tet10Mesh, clamped: &[bool]) -> Option<FloatingBody> {
        if self.parts.len() > MAX_PARTS {
            return None;
        }
        let (centre_m, radius_m) = self.extent(mesh);
        let gram = self.constraints(mesh, clamped, &centre_m, radius_m);
        let modes = null_space(gram);
        if modes.ncols() == 0 {
            return None;
        }
        let part = self.most_moving_part(&modes);
        let free = readable_basis(&modes.rows(6 * part, 6).into_owned())
            .into_iter()
            .map(|m| RigidMotion {
                centre_m,
                translation: m.0 * radius_m,
                rotation: m.1,
            })
            .collect();
        let n_clamped = self.nodes().filter(|node| clamped[node.index()]).count();
        let (first_element, n_elements) = (self.first_element, self.n_elements);
        Some(FloatingBody {
            first_element,
            n_elements,
            centre_m,
            n_clamped,
            free,
        })
    }

    fn nodes(&self) -> impl Iterator<Item = FeNodeId> {
        self.members
            .chunk_by(|a, b| a.0 == b.0)
            .map(|group| group[0].0)
    }

    fn extent(&self, mesh: &Tet10Mesh) -> (Point3<f64>, f64) {
        let n = self.nodes().count() as f64;
        let sum: Vector3<f64> = self
            .nodes()
            .map(|node| mesh.nodes()[node.index()].coords)
            .sum();
        let centre = Point3::from(sum / n);
        let radius = self
            .nodes()
            .map(|node| (mesh.nodes()[node.index()] - centre).norm())
            .fold(0.0, f64::max);
        (centre, radius)
    }

    /// Σ CᵀC over all constraints on the parts' motions, in units of the body's radius.
    fn constraints(
        &self,
        mesh: &Tet10Mesh,
        clamped: &[bool],
        centre: &Point3<f64>,
        radius_m: f64,
    ) -> DMatrix<f64> {
        let mut gram = DMatrix::zeros(6 * self.parts.len(), 6 * self.parts.len());
        for group in self.members.chunk_by(|a, b| a.0 == b.0) {
            let node = group[0].0;
            let x = (mesh.nodes()[node.index()] - centre) / radius_m;
            if clamped[node.index()] {
                for &(_, part) in group {
                    add_constraint(&mut gram, &x, &[(part, 1.0)]);
                }
            } else {
                for pair in group.windows(2) {
                    add_constraint(&mut gram, &x, &[(pair[0].1, 1.0), (pair[1].1, -1.0)]);
                }
            }
        }
        gram
    }

    fn most_moving_part(&self, modes: &DMatrix<f64>) -> usize {
        let motion = |part: usize| modes.rows(6 * part, 6).norm_squared();
        (0..self.parts.len()).fold(0, |best, p| if motion(p) > motion(best) { p } else { best })
    }
}

/// Adds (Σ sign · u_part(x))² for the three directions; u = t + ω × x.
fn add_constraint(gram: &mut DMatrix<f64>, x: &Vector3<f64>, terms: &[(usize, f64)]) {
    for direction in 0..3 {
        let e = Vector3::ith(direction, 1.0);
        // e · (ω × x) = ω · (x × e)
        let rotation = x.cross(&e);
        let row: Vec<(usize, f64)> = terms
            .iter()
            .flat_map(|&(part, sign)| {
                (0..3).flat_map(move |c| {
                    [
                        (6 * part + c, sign * e[c]),
                        (6 * part + 3 + c, sign * rotation[c]),
                    ]
                })
            })
            .collect();
        for &(i, a) in &row {
            for &(j, b) in &row {
                gram[(i, j)] += a * b;
            }
        }
    }
}

/// Columns spanning the null space of a Gram matrix.
fn null_space(gram: DMatrix<f64>) -> DMatrix<f64> {
    let eigen = SymmetricEigen::new(gram);
    let limit = FREE_BELOW * FREE_BELOW * eigen.eigenvalues.amax();
    let free: Vec<usize> = (0..eigen.eigenvalues.len())
        .filter(|&i| eigen.eigenvalues[i] <= limit)
        .collect();
    eigen.eigenvectors.select_columns(&free)
}

/// A basis (translation, rotation) of the span of `modes` `[6, n]` with single rotations and
/// translations where there are such: reduced row echelon form, rotations first.
fn readable_basis(modes: &DMatrix<f64>) -> Vec<(Vector3<f64>, Vector3<f64>)> {
    let mut rows: Vec<[f64; 6]> = modes
        .column_iter()
        .map(|m| [m[3], m[4], m[5], m[0], m[1], m[2]])
        .collect();
    let mut rank = 0;
    for column in 0..6 {
        let Some(pivot) = (rank..rows.len())
            .max_by(|&a, &b| rows[a][column].abs().total_cmp(&rows[b][column].abs()))
        else {
            break;
        };
        if rows[pivot][column].abs() < 1e-3 {
            continue;
        }
        rows.swap(rank, pivot);
        let scale = rows[rank][column];
        let lead = rows[rank].map(|v| v / scale);
        for row in &mut rows {
            let factor = row[column];
            for (v, l) in row.iter_mut().zip(lead) {
                *v -= factor * l;
            }
        }
        rows[rank] = lead;
        rank += 1;
    }
    let clean = |v: f64| if v.abs() < 1e-9 { 0.0 } else { v };
    rows[..rank]
        .iter()
        .map(|r| r.map(clean))
        .map(|r| {
            (
                Vector3::new(r[3], r[4], r[5]),
                Vector3::new(r[0], r[1], r[2]),
            )
        })
        .collect()
}
