//! The force of a round tip on the skin.

use std::collections::BTreeMap;

use hapdef_mesh::{FeNodeId, SkinRegion, Tet10Mesh, Tri6Face, face_positions, tri6};
use nalgebra::{Point3, Vector3};
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

use crate::loads::nodal::check_node;
use crate::{NodalLoad, SimError};

/// Faces are split until a piece is shorter than this share of the tip radius.
const PIECE_PER_RADIUS: f64 = 0.25;

/// Splits at most, a bound for tips far smaller than a face: 4⁻²⁰ of a face's area.
const MAX_SPLITS: u32 = 20;

/// Parent corners of a whole face.
const WHOLE: [[f64; 2]; 3] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];

/// A skin that round tips press: its faces, found by where they are.
#[derive(Clone, Debug)]
pub struct PressedSkin {
    nodes: Vec<(FeNodeId, Point3<f64>)>,
    faces: Vec<([FeNodeId; 6], [Point3<f64>; 6])>,
    boxes: RTree<FaceBox>,
}

/// A box around a face.
type FaceBox = GeomWithData<Rectangle<[f64; 3]>, usize>;

impl PressedSkin {
    /// The skin of a mesh.
    ///
    /// # Errors
    /// [`SimError::NodeOutOfRange`] if `skin` is not of `mesh`; [`SimError::Length`] if it has no nodes.
    pub fn new(mesh: &Tet10Mesh, skin: &SkinRegion) -> Result<Self, SimError> {
        for &node in &skin.nodes {
            check_node("the skin", node, mesh.nodes().len())?;
        }
        if skin.nodes.is_empty() {
            return Err(SimError::Length { what: "the skin's node list", expected: 1, found: 0 });
        }
        let nodes = skin.nodes.iter().map(|&node| (node, mesh.position(node)));
        let placed = |face: &Tri6Face| (face.nodes, face_positions(mesh, face));
        let faces: Vec<_> = skin.faces.iter().map(placed).collect();
        let boxes = faces.iter().enumerate();
        let boxes = boxes.map(|(i, (_, nodes))| GeomWithData::new(around(nodes), i));
        Ok(Self { nodes: nodes.collect(), boxes: RTree::bulk_load(boxes.collect()), faces })
    }

    /// The unit force of a tip of radius `tip_radius_m` (r) pressing at `centre` along
    /// `direction`, N.
    ///
    /// The pressure at distance d from `centre` goes with (1 − (d/r)²)² inside the radius, is
    /// integrated over the curved skin faces with their own shape functions, and is normalised, so
    /// that the total is one newton along `direction` (of any length). A radius of zero puts the
    /// force on the skin node nearest to `centre`, the first of equals.
    ///
    /// # Errors
    /// [`SimError::Direction`], [`SimError::Parameter`] for an unusable radius or centre,
    /// [`SimError::PatchOffSkin`] if no skin lies inside the radius.
    pub fn load(
        &self,
        centre: &Point3<f64>,
        tip_radius_m: f64,
        direction: &Vector3<f64>,
    ) -> Result<NodalLoad, SimError> {
        let direction = unit("the direction of the patch load", direction)?;
        check_tip(centre, tip_radius_m)?;
        if tip_radius_m == 0.0 {
            return Ok(NodalLoad::nodal(self.nearest(centre).0, direction));
        }
        let weights = self.kernel_weights(centre, tip_radius_m);
        let total: f64 = weights.values().sum();
        if total.is_nan() || total <= 0.0 {
            return Err(SimError::PatchOffSkin {
                centre_m: centre.coords.into(),
                tip_radius_m,
                nearest_node_m: self.nearest(centre).1,
            });
        }
        let forces_n =
            weights.into_iter().map(|(node, weight)| (node, direction * (weight / total)));
        Ok(NodalLoad { forces_n: forces_n.collect(), ..NodalLoad::default() })
    }

    /// The nearest node, the first of equals, and its distance, m.
    fn nearest(&self, centre: &Point3<f64>) -> (FeNodeId, f64) {
        let (mut nearest, mut least) = (self.nodes[0].0, f64::INFINITY);
        for &(node, position) in &self.nodes {
            let distance = (position - centre).norm();
            if distance < least {
                (nearest, least) = (node, distance);
            }
        }
        (nearest, least)
    }

    /// ∫ Nᵢ κ dA of each node near the tip.
    fn kernel_weights(&self, centre: &Point3<f64>, radius_m: f64) -> BTreeMap<FeNodeId, f64> {
        let corner = |sign: f64| [0, 1, 2].map(|k| centre[k] + sign * radius_m);
        let around = AABB::from_corners(corner(-1.0), corner(1.0));
        let near = self.boxes.locate_in_envelope_intersecting(around);
        let mut near: Vec<usize> = near.map(|found| found.data).collect();
        // Sums are the same whatever the order in which the tree has them.
        near.sort_unstable();
        let mut weights = BTreeMap::new();
        for face in near {
            let (nodes, positions) = &self.faces[face];
            let tip = Tip { nodes: *positions, centre, radius_m };
            let mut shares = [0.0; 6];
            tip.integrate(&WHOLE, 0, &mut shares);
            if shares.iter().any(|&share| share != 0.0) {
                for (node, share) in nodes.iter().zip(shares) {
                    *weights.entry(*node).or_insert(0.0) += share;
                }
            }
        }
        weights
    }
}

impl NodalLoad {
    /// One load of [`PressedSkin::load`]; many are found sooner by a [`PressedSkin`] that is kept.
    ///
    /// # Errors
    /// Those of [`PressedSkin::new`] and [`PressedSkin::load`].
    pub fn patch(
        mesh: &Tet10Mesh,
        skin: &SkinRegion,
        centre: &Point3<f64>,
        tip_radius_m: f64,
        direction: &Vector3<f64>,
    ) -> Result<Self, SimError> {
        PressedSkin::new(mesh, skin)?.load(centre, tip_radius_m, direction)
    }
}

pub(crate) fn unit(what: &'static str, direction: &Vector3<f64>) -> Result<Vector3<f64>, SimError> {
    direction
        .try_normalize(0.0)
        .filter(|d| d.iter().all(|c| c.is_finite()))
        .ok_or(SimError::Direction { what, value: (*direction).into() })
}

fn check_tip(centre: &Point3<f64>, tip_radius_m: f64) -> Result<(), SimError> {
    let refuse = |what, value, expected| Err(SimError::Parameter { what, value, expected });
    if !(tip_radius_m.is_finite() && tip_radius_m >= 0.0) {
        return refuse("the tip radius (m)", tip_radius_m, "finite and not negative");
    }
    match centre.iter().find(|c| !c.is_finite()) {
        Some(&value) => refuse("a coordinate of the tip's centre (m)", value, "finite"),
        None => Ok(()),
    }
}

/// A box that a curved face does not leave.
fn around(nodes: &[Point3<f64>; 6]) -> Rectangle<[f64; 3]> {
    let bezier = bezier_points(&[0, 1, 2].map(|i| nodes[i]), &[3, 4, 5].map(|i| nodes[i]));
    let end = |k: usize, pick: fn(f64, f64) -> f64| bezier.iter().map(|p| p[k]).reduce(pick);
    let corner = |pick| [0, 1, 2].map(|k| end(k, pick).unwrap_or_default());
    Rectangle::from_corners(corner(f64::min), corner(f64::max))
}

/// A quadratic map stays within the hull of its Bézier points: corners, and twice the mid-side nodes less
/// the mean of the corners beside them.
fn bezier_points(corners: &[Point3<f64>; 3], mids: &[Point3<f64>; 3]) -> [Vector3<f64>; 6] {
    std::array::from_fn(|i| {
        let (a, b) = (corners[i % 3].coords, corners[(i + 1) % 3].coords);
        match i {
            0..3 => a,
            _ => mids[i - 3].coords * 2.0 - (a + b) * 0.5,
        }
    })
}

/// A tip over one face.
struct Tip<'a> {
    nodes: [Point3<f64>; 6],
    centre: &'a Point3<f64>,
    radius_m: f64,
}

impl Tip<'_> {
    /// Adds ∫ Nᵢ κ dA over the piece of the face with parent corners `piece`.
    fn integrate(&self, piece: &[[f64; 2]; 3], splits: u32, shares: &mut [f64; 6]) {
        let (middle, reach_m) = self.extent(piece);
        if (middle - self.centre).norm() > self.radius_m + reach_m {
            return;
        }
        if reach_m > PIECE_PER_RADIUS * self.radius_m && splits < MAX_SPLITS {
            for part in quarters(piece) {
                self.integrate(&part, splits + 1, shares);
            }
            return;
        }
        let parent_area_2 = cross(piece);
        for q in tri6::QUADRATURE {
            let [xi, eta] = within(piece, q.xi, q.eta);
            let d_2 = (tri6::position(&self.nodes, xi, eta) - self.centre).norm_squared();
            let inside = 1.0 - d_2 / (self.radius_m * self.radius_m);
            if inside <= 0.0 {
                continue;
            }
            let area = tri6::area_vector(&self.nodes, xi, eta).norm() * q.weight * parent_area_2;
            for (share, shape) in shares.iter_mut().zip(tri6::shape(xi, eta)) {
                *share += shape * area * inside * inside;
            }
        }
    }

    /// A point of the piece and a distance from it that the piece does not exceed.
    fn extent(&self, piece: &[[f64; 2]; 3]) -> (Point3<f64>, f64) {
        let at = |xi, eta| {
            let [xi, eta] = within(piece, xi, eta);
            tri6::position(&self.nodes, xi, eta)
        };
        let corners = [at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0)];
        let mids = [at(0.5, 0.0), at(0.5, 0.5), at(0.0, 0.5)];
        let middle = at(1.0 / 3.0, 1.0 / 3.0);
        let reach = bezier_points(&corners, &mids)
            .iter()
            .map(|p| (p - middle.coords).norm())
            .fold(0.0, f64::max);
        (middle, reach)
    }
}

fn within(piece: &[[f64; 2]; 3], xi: f64, eta: f64) -> [f64; 2] {
    std::array::from_fn(|c| (1.0 - xi - eta) * piece[0][c] + xi * piece[1][c] + eta * piece[2][c])
}

/// Twice the parent area of the piece: the Jacobian of [`within`].
fn cross(piece: &[[f64; 2]; 3]) -> f64 {
    let side = |i: usize| [piece[i][0] - piece[0][0], piece[i][1] - piece[0][1]];
    let (a, b) = (side(1), side(2));
    a[0] * b[1] - a[1] * b[0]
}

fn quarters(piece: &[[f64; 2]; 3]) -> [[[f64; 2]; 3]; 4] {
    let [a, b, c] = *piece;
    let (ab, bc, ca) = (within(piece, 0.5, 0.0), within(piece, 0.5, 0.5), within(piece, 0.0, 0.5));
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [bc, ca, ab]]
}
