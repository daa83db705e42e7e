//! A wall of ten-node tetrahedra from a skin and its thickness: the solid partner of a shell.

use nalgebra::{Point3, Vector3};

use super::surface::{check_thickness, steps};
#[cfg(feature = "wrap")]
use crate::self_intersections;
use crate::surface::curve::EdgeMiddles;
use crate::surface::find_defects::check_manifold;
use crate::surface::self_intersection::check_uncrossed;
use crate::{
    FaceCurve, FeNodeId, MeshError, SkinSide, SurfaceFault, SurfaceMesh, TET10_EDGES, Tet10Mesh,
    tet10,
};

/// How a skin is extruded.
#[derive(Clone, Copy, Debug)]
pub struct ExtrudeParams<'a> {
    /// Where in the wall the skin lies.
    pub side: SkinSide,
    /// Layers of wedges through the wall, three tetrahedra each.
    pub n_layers: usize,
    /// The surface that the skin stands for: where the mid-side nodes lie.
    pub curve: FaceCurve<'a>,
}

/// An extruded wall.
#[derive(Clone, Debug, PartialEq)]
pub struct Extrusion {
    /// The wall.
    pub mesh: Tet10Mesh,
    /// Layers through the wall.
    pub n_layers: usize,
    /// The volume of all elements on their curved geometry, m³.
    pub volume_m3: f64,
    /// The smallest Jacobian determinant at a Gauss point, m³.
    pub least_jacobian_m3: f64,
}

impl Extrusion {
    /// The corner node under a vertex of the skin: level 0 is the outside, level `n_layers` the
    /// inside of the wall.
    #[must_use]
    pub fn node(&self, vertex: u32, level: usize) -> FeNodeId {
        FeNodeId::from_index(vertex as usize * (self.n_layers + 1) + level)
    }
}

/// Extrudes `skin` to a wall `thickness_m` `[n_vertices]` thick, along the mean normals at its
/// vertices: with flat faces, and at sharp edges, so far that the planes of the triangles move by
/// the thickness; with curved faces, by just the thickness.
///
/// Every wedge becomes three tetrahedra; each of its sides is cut from the vertex with the smaller
/// number, outside, to the other, inside, so that neighbours agree (Dompierre, Labbé, Vallet and
/// Camarero, 8th International Meshing Roundtable, 1999). Mid-side nodes lie on the curved skin or
/// at its depth; edges through the wall are straight.
///
/// # Errors
/// [`MeshError::Surface`]: a skin that is no oriented manifold; a bad thickness or number of
/// layers; a vertex without a normal; a wedge that folds, with its triangle, layer and node; a wall
/// whose outer and inner side, taken flat, cross.
pub fn extrude(
    skin: &SurfaceMesh,
    thickness_m: &[f64],
    params: &ExtrudeParams<'_>,
) -> Result<Extrusion, MeshError> {
    if params.n_layers == 0 {
        let (name, wanted) = ("n_layers", "at least 1");
        let found = 0.0;
        return Err(SurfaceFault::Parameter { name, found, wanted }.into());
    }
    check_manifold(skin)?;
    check_thickness(skin.vertices().len(), thickness_m)?;
    let columns = Columns::new(skin, thickness_m, params)?;
    let (nodes, elements) = columns.nodes_and_elements(&wedges(skin, params.n_layers));
    let (volume_m3, least_jacobian_m3) = check_folds(skin, thickness_m, params, &nodes, &elements)?;
    let advice = "there is no room for the wall there: thin it, or give the skin as the side that \
                  leaves room";
    check_uncrossed(&columns.sides()?, "the extruded wall", advice)?;
    Ok(Extrusion {
        mesh: Tet10Mesh::new(nodes, elements)?,
        n_layers: params.n_layers,
        volume_m3,
        least_jacobian_m3,
    })
}

/// The triangles under which the wall of [`extrude`] folds or, where none does, at which its sides
/// cross; ascending, none where it fits. The skin is an oriented manifold.
#[cfg(feature = "wrap")]
pub(crate) fn unfit_triangles(
    skin: &SurfaceMesh,
    thickness_m: &[f64],
    params: &ExtrudeParams<'_>,
) -> Result<Vec<usize>, MeshError> {
    let columns = Columns::new(skin, thickness_m, params)?;
    let (nodes, elements) = columns.nodes_and_elements(&wedges(skin, params.n_layers));
    let folds =
        |(_, ids): &(usize, &[FeNodeId; 10])| least_jacobian_m3(&places(&nodes, ids)) <= 0.0;
    let folded = elements.iter().enumerate().filter(folds);
    let mut unfit: Vec<usize> =
        folded.map(|(element, _)| element / (3 * params.n_layers)).collect();
    if unfit.is_empty() {
        let crossings = self_intersections(&columns.sides()?);
        unfit = crossings.iter().flat_map(|crossing| crossing.triangles).collect();
        unfit.iter_mut().for_each(|triangle| *triangle %= skin.triangles().len());
    }
    unfit.sort_unstable();
    unfit.dedup();
    Ok(unfit)
}

/// A vertex of the skin and a level below the outside.
type Corner = (u32, usize);

/// The tetrahedra of all wedges, triangle by triangle, then layer by layer.
fn wedges(skin: &SurfaceMesh, n_layers: usize) -> Vec<[Corner; 4]> {
    let layers = |triangle| (0..n_layers).flat_map(move |layer| wedge(triangle, layer));
    skin.triangles().iter().flat_map(layers).collect()
}

/// The wedge under a triangle between level `layer` and the next, as three tetrahedra of positive
/// volume where the triangle runs counter-clockwise seen from outside.
fn wedge(triangle: &[u32; 3], layer: usize) -> [[Corner; 4]; 3] {
    let [mut p, mut q, mut r] = *triangle;
    let mut is_even = true;
    for (first, second) in [(0, 1), (1, 2), (0, 1)] {
        let mut sorted = [p, q, r];
        if sorted[first] > sorted[second] {
            sorted.swap(first, second);
            is_even = !is_even;
        }
        [p, q, r] = sorted;
    }
    let (above, below) = (layer, layer + 1);
    let mut tets = [
        [(p, above), (r, above), (q, above), (r, below)],
        [(p, above), (q, above), (q, below), (r, below)],
        [(p, above), (q, below), (p, below), (r, below)],
    ];
    if !is_even {
        tets.iter_mut().for_each(|tet| tet.swap(1, 2));
    }
    tets
}

/// The lines through the wall, one at each vertex of the skin and one at the middle of each edge.
struct Columns<'a> {
    skin: &'a SurfaceMesh,
    middles: EdgeMiddles,
    /// The whole way from the outside to the inside of the wall, at vertices.
    ways: Vec<Vector3<f64>>,
    n_layers: usize,
    share_outside: f64,
}

impl<'a> Columns<'a> {
    fn new(
        skin: &'a SurfaceMesh,
        thickness_m: &[f64],
        params: &ExtrudeParams<'_>,
    ) -> Result<Self, SurfaceFault> {
        let middles = EdgeMiddles::of(skin, &params.curve);
        let steps = steps(skin, &skin.vertex_normals())?;
        let way = |v: usize| {
            let step = if middles.is_sharp[v] { steps[v] } else { middles.normals[v] };
            -step * thickness_m[v]
        };
        Ok(Self {
            skin,
            ways: (0..thickness_m.len()).map(way).collect(),
            middles,
            n_layers: params.n_layers,
            share_outside: params.side.share_outside(),
        })
    }

    /// The part of the way from the skin to a level, which may lie half-way between two.
    fn depth(&self, level: f64) -> f64 {
        level / self.n_layers as f64 - self.share_outside
    }

    fn corner(&self, (v, level): Corner) -> Point3<f64> {
        let v = v as usize;
        self.skin.vertices()[v] + self.ways[v] * self.depth(level as f64)
    }

    /// The outer side of the wall and then its inner side, turned over.
    fn sides(&self) -> Result<SurfaceMesh, MeshError> {
        let n = self.ways.len() as u32;
        let level = |level| (0..n).map(move |v| self.corner((v, level)));
        let vertices = level(0).chain(level(self.n_layers)).collect();
        let outer = self.skin.triangles().iter().copied();
        let inner = outer.clone().map(|[a, b, c]| [a + n, c + n, b + n]);
        SurfaceMesh::new(vertices, outer.chain(inner).collect())
    }

    fn middle(&self, [a, b]: [Corner; 2]) -> Point3<f64> {
        let [u, v] = [a.0 as usize, b.0 as usize];
        let level = 0.5 * (a.1 + b.1) as f64;
        if u == v {
            return nalgebra::center(&self.corner(a), &self.corner(b));
        }
        let mean = 0.5 * (self.ways[u] + self.ways[v]);
        let base = self.middles.middles[self.middles.number(a.0, b.0)];
        if self.middles.is_sharp[u] || self.middles.is_sharp[v] {
            // Flat or next to a sharp edge: the chord's middle, and what the skin bulges beyond it.
            let [p, q] = [u, v].map(|v| self.skin.vertices()[v]);
            let bulge = base - nalgebra::center(&p, &q);
            return nalgebra::center(&self.corner(a), &self.corner(b)) + bulge;
        }
        // Between two unit normals the mean is too short by the curvature.
        let length = 0.5 * (self.ways[u].norm() + self.ways[v].norm());
        let way = mean.try_normalize(0.0).map_or(mean, |unit| unit * length);
        base + way * self.depth(level)
    }

    fn nodes_and_elements(&self, tets: &[[Corner; 4]]) -> (Vec<Point3<f64>>, Vec<[FeNodeId; 10]>) {
        let n_levels = self.n_layers + 1;
        let n_corners = self.ways.len() * n_levels;
        let mut edges: Vec<[Corner; 2]> =
            tets.iter().flat_map(|tet| TET10_EDGES.map(|[a, b]| sorted(tet[a], tet[b]))).collect();
        edges.sort_unstable();
        edges.dedup();
        let corners = (0..n_corners).map(|i| self.corner(((i / n_levels) as u32, i % n_levels)));
        let nodes = corners.chain(edges.iter().map(|edge| self.middle(*edge))).collect();
        let element = |tet: &[Corner; 4]| {
            std::array::from_fn(|i| match i {
                0..4 => FeNodeId::from_index(tet[i].0 as usize * n_levels + tet[i].1),
                _ => {
                    let [a, b] = TET10_EDGES[i - 4];
                    let edge = sorted(tet[a], tet[b]);
                    FeNodeId::from_index(n_corners + edges.partition_point(|e| *e < edge))
                }
            })
        };
        (nodes, tets.iter().map(element).collect())
    }
}

fn sorted(a: Corner, b: Corner) -> [Corner; 2] {
    if a < b { [a, b] } else { [b, a] }
}

/// The volume of all elements and their smallest Jacobian at a corner tetrahedron or Gauss point;
/// refuses one that is not positive. Elements come triangle by triangle, then layer by layer.
fn check_folds(
    skin: &SurfaceMesh,
    thickness_m: &[f64],
    params: &ExtrudeParams<'_>,
    nodes: &[Point3<f64>],
    elements: &[[FeNodeId; 10]],
) -> Result<(f64, f64), SurfaceFault> {
    let (mut volume_m3, mut least) = (0.0, f64::INFINITY);
    for (element, ids) in elements.iter().enumerate() {
        let places = places(nodes, ids);
        let jacobian_m3 = least_jacobian_m3(&places);
        if jacobian_m3 <= 0.0 {
            let triangle = element / (3 * params.n_layers);
            let corners = skin.triangles()[triangle].map(|v| v as usize);
            let thicker = |a: usize, b: usize| {
                if thickness_m[b] > thickness_m[a] { b } else { a }
            };
            let node = thicker(thicker(corners[0], corners[1]), corners[2]);
            return Err(SurfaceFault::ExtrusionFolds {
                triangle,
                layer: element / 3 % params.n_layers,
                node,
                thickness_m: thickness_m[node],
                jacobian_m3,
            });
        }
        volume_m3 += tet10::volume(&places);
        least = least.min(jacobian_m3);
    }
    Ok((volume_m3, least))
}

fn places(nodes: &[Point3<f64>], ids: &[FeNodeId; 10]) -> [Point3<f64>; 10] {
    ids.map(|id| nodes[id.index()])
}

/// The smallest Jacobian determinant at a Gauss point or of the straight tetrahedron; -∞ where it is not
/// a number.
fn least_jacobian_m3(places: &[Point3<f64>; 10]) -> f64 {
    let [a, b, c, d] = [0, 1, 2, 3].map(|i| places[i]);
    let straight = (b - a).cross(&(c - a)).dot(&(d - a));
    let least = tet10::min_gauss_jacobian(places).min(straight);
    if least.is_nan() { f64::NEG_INFINITY } else { least }
}
