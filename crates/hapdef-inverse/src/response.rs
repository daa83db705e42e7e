//! The response map: what every gauge reads for a newton anywhere on the skin.

use nalgebra::{Point3, Vector3};

use crate::dense::padded;
use crate::error::{InverseError, check_finite, check_length};
use crate::interpolant::Interpolant;
use crate::patch::TipMeans;
use crate::skin::Skin;
use crate::skin_point::SkinPoint;
use crate::subdivided_faces::SubdividedFaces;

/// How nodal values become a map.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ResponseParams {
    /// Radius of the round tip whose pressure the response is averaged under, m; 0 is a point force.
    pub tip_radius_m: f64,
}

/// Gauge readings per newton, smooth over the skin, for forces against the outward normal and in
/// any direction. The unit of a reading is the caller's, the same throughout.
#[derive(Clone, Debug)]
pub struct ResponseMap {
    skin: Skin,
    n_gauges: usize,
    interpolant: Interpolant,
    /// `[n_rows, padded(n_gauges)]`: for a newton against the normal.
    normal: Vec<f64>,
    /// `[n_rows, 3, padded(n_gauges)]`: for a newton along x, y, z.
    vector: Vec<f64>,
}

/// How the gauges of a term of a sum are mixed.
#[derive(Clone, Debug)]
pub(crate) enum Mix {
    /// All with all, by a matrix `[n_gauges, n_gauges]`.
    All(Vec<f64>),
    /// Each by a factor of its own `[n_gauges]`.
    Each(Vec<f64>),
}

impl ResponseMap {
    /// The map from nodal values of the adjoint fields `[n_nodes, n_gauges]`: reading per newton in
    /// each direction at each node of the skin. A unit normal force at a node goes against the
    /// node's normal. On six-node faces values are interpolated quadratically, on three-node faces
    /// by cubics that follow fitted nodal gradients.
    ///
    /// # Errors
    /// [`InverseError`] for a wrong length, a value that is not finite, a negative tip radius.
    pub fn from_nodal(
        skin: Skin,
        n_gauges: usize,
        adjoint: &[Vector3<f64>],
        params: &ResponseParams,
    ) -> Result<Self, InverseError> {
        let tips = TipMeans::new(&skin, params.tip_radius_m)?;
        Self::under_tips(skin, n_gauges, adjoint, &tips)
    }

    /// The same under tips that are known: what takes longest, and is the same for every field of a skin.
    ///
    /// # Errors
    /// As [`ResponseMap::from_nodal`], and [`InverseError`] for tips of another skin.
    pub fn under_tips(
        skin: Skin,
        n_gauges: usize,
        adjoint: &[Vector3<f64>],
        tips: &TipMeans,
    ) -> Result<Self, InverseError> {
        check_length("the tips", skin.n_nodes(), tips.n_nodes())?;
        check_length("the adjoint fields", skin.n_nodes() * n_gauges, adjoint.len())?;
        check_gauges(n_gauges)?;
        let width = padded(n_gauges);
        let vector = tips.of(&as_rows(adjoint, n_gauges)?, 3 * width);
        let normal = against(skin.normals(), &vector, n_gauges);
        let interpolant = Interpolant::new(&skin);
        Ok(Self {
            n_gauges,
            normal: interpolant.control(&normal, width),
            vector: interpolant.control(&vector, 3 * width),
            interpolant,
            skin,
        })
    }

    /// The map from values on subdivided six-node faces: at [`Skin::subdivided_points`] readings per
    /// newton in each direction `[n_points, n_gauges]`, tips being in them. For a response that varies
    /// more than the faces' own nodes can represent, as it does within millimetres of a gauge.
    ///
    /// # Errors
    /// [`InverseError`] for a wrong length, a value that is not finite, a skin of three-node faces.
    pub fn from_subdivided(
        skin: Skin,
        n_gauges: usize,
        adjoint: &[Vector3<f64>],
    ) -> Result<Self, InverseError> {
        check_length("the nodes of a face", 6, skin.n_face_nodes())?;
        let faces = SubdividedFaces::new(&skin);
        let points = &faces.points;
        check_length("the adjoint fields", points.len() * n_gauges, adjoint.len())?;
        check_gauges(n_gauges)?;
        let vector = as_rows(adjoint, n_gauges)?;
        let normals: Vec<_> = points.iter().map(|point| skin.normal(point)).collect();
        Ok(Self {
            n_gauges,
            normal: against(&normals, &vector, n_gauges),
            vector,
            interpolant: Interpolant::subdivided(&faces),
            skin,
        })
    }

    /// The map that has these values as its [`ResponseMap::nodal`].
    ///
    /// # Errors
    /// As [`ResponseMap::from_nodal`] and [`ResponseMap::from_subdivided`].
    pub fn from_values(
        skin: Skin,
        n_gauges: usize,
        values: &[Vector3<f64>],
    ) -> Result<Self, InverseError> {
        if values.len() == skin.n_nodes() * n_gauges {
            return Self::from_nodal(skin, n_gauges, values, &ResponseParams::default());
        }
        Self::from_subdivided(skin, n_gauges, values)
    }

    /// Where [`ResponseMap::nodal`] has its values: the nodes of the skin, or the points of its subdivided faces.
    #[must_use]
    pub fn value_positions(&self) -> Vec<Point3<f64>> {
        if !self.interpolant.is_subdivided() {
            return self.skin.nodes().to_vec();
        }
        let points = self.skin.subdivided_points();
        points.iter().map(|point| self.skin.position(point)).collect()
    }

    /// Outward normals there.
    fn value_normals(&self) -> Vec<Vector3<f64>> {
        if !self.interpolant.is_subdivided() {
            return self.skin.normals().to_vec();
        }
        let points = self.skin.subdivided_points();
        points.iter().map(|point| self.skin.normal(point)).collect()
    }

    /// This map and Σ M h over `terms`, each a map h of the same skin with M that mixes its gauges, and `residual` `[n_values, n_gauges]` for a
    /// newton against the normal, which in forces of any direction counts along the normal. Terms with
    /// fewer values are interpolated, and of those with more the nodes' count.
    pub(crate) fn plus(&self, terms: &[(&Self, Mix)], residual: &[f64]) -> Self {
        let (m, width) = (self.n_gauges, padded(self.n_gauges));
        let mut map = self.clone();
        let mut coarser: Option<Self> = None;
        for (term, mix) in terms {
            let sum = match self.interpolant.is_subdivided() && !term.interpolant.is_subdivided() {
                true => coarser.get_or_insert_with(|| term.zero()),
                false => &mut map,
            };
            mix.add(&mut sum.normal, &term.normal, m);
            mix.add(&mut sum.vector, &term.vector, m);
        }
        if let Some(sum) = coarser {
            let [normal, vector] = sum.rows_of(self);
            add(&mut map.normal, normal);
            add(&mut map.vector, vector);
        }
        let normals = self.value_normals();
        let mut normal = vec![0.0; normals.len() * width];
        let mut vector = vec![0.0; normals.len() * 3 * width];
        for (node, direction) in normals.iter().enumerate() {
            for (gauge, r) in residual[node * m..(node + 1) * m].iter().enumerate() {
                normal[node * width + gauge] = *r;
                for axis in 0..3 {
                    vector[(3 * node + axis) * width + gauge] = -r * direction[axis];
                }
            }
        }
        add(&mut map.normal, self.interpolant.control(&normal, width));
        add(&mut map.vector, self.interpolant.control(&vector, 3 * width));
        map
    }

    /// Nothing, with as many values.
    fn zero(&self) -> Self {
        let (normal, vector) = (vec![0.0; self.normal.len()], vec![0.0; self.vector.len()]);
        Self {
            normal,
            vector,
            interpolant: self.interpolant.clone(),
            skin: self.skin.clone(),
            ..*self
        }
    }

    /// Rows for normal forces and for those along x, y, z where `other` has values, on the subdivided faces of the same skin.
    fn rows_of(&self, other: &Self) -> [Vec<f64>; 2] {
        let width = padded(self.n_gauges);
        let points = other.skin.subdivided_points();
        let at = |rows: &[f64], width: usize| -> Vec<f64> {
            let row = |point: &SkinPoint| {
                let weights = self.interpolant.value_weights(&point.bary());
                self.combined(rows, width, point, &weights)
            };
            points.iter().flat_map(row).collect()
        };
        [at(&self.normal, width), at(&self.vector, 3 * width)]
    }

    /// The skin that the map is on.
    #[must_use]
    pub fn skin(&self) -> &Skin {
        &self.skin
    }

    /// Number of gauges.
    #[must_use]
    pub fn n_gauges(&self) -> usize {
        self.n_gauges
    }

    /// g(p) `[n_gauges]`: readings for a newton against the normal at `point`.
    ///
    /// # Panics
    /// If `point` is of another, larger skin.
    #[must_use]
    pub fn normal(&self, point: &SkinPoint) -> Vec<f64> {
        self.value(&self.normal, padded(self.n_gauges), point)
    }

    /// `[n_gauges]`: readings for a newton along x, y and z at `point`.
    ///
    /// # Panics
    /// If `point` is of another, larger skin.
    #[must_use]
    pub fn vector(&self, point: &SkinPoint) -> Vec<Vector3<f64>> {
        let width = padded(self.n_gauges);
        let flat = self.combined(
            &self.vector,
            3 * width,
            point,
            &self.interpolant.value_weights(&point.bary()),
        );
        self.as_vectors(&flat)
    }

    /// ∂g/∂t₁ and ∂g/∂t₂ `[n_gauges]`, per metre along [`Skin::tangents`] of the skin at `point`.
    ///
    /// # Panics
    /// If `point` is of another, larger skin.
    #[must_use]
    pub fn normal_gradient(&self, point: &SkinPoint) -> [Vec<f64>; 2] {
        let weights = self.interpolant.weights(&point.bary(), &self.skin.frame(point));
        weights.slope.map(|slope| {
            let mut row = self.combined(&self.normal, padded(self.n_gauges), point, &slope);
            row.truncate(self.n_gauges);
            row
        })
    }

    /// ∂/∂t₁ and ∂/∂t₂ of [`ResponseMap::vector`] `[n_gauges]`, per metre.
    ///
    /// # Panics
    /// If `point` is of another, larger skin.
    #[must_use]
    pub fn vector_gradient(&self, point: &SkinPoint) -> [Vec<Vector3<f64>>; 2] {
        let width = padded(self.n_gauges);
        let weights = self.interpolant.weights(&point.bary(), &self.skin.frame(point));
        weights
            .slope
            .map(|slope| self.as_vectors(&self.combined(&self.vector, 3 * width, point, &slope)))
    }

    /// Readings per newton along x, y and z at every node of the skin `[n_nodes, n_gauges]`: what
    /// [`ResponseMap::from_nodal`] makes the same map of, with a tip of 0 as this one's is in it; of a
    /// map on subdivided faces, at [`Skin::subdivided_points`], for [`ResponseMap::from_subdivided`].
    #[must_use]
    pub fn nodal(&self) -> Vec<Vector3<f64>> {
        let width = 3 * padded(self.n_gauges);
        (0..self.n_values())
            .flat_map(|node| self.as_vectors(&self.vector[node * width..(node + 1) * width]))
            .collect()
    }

    /// Values of [`ResponseMap::nodal`] for a gauge.
    #[must_use]
    pub fn n_values(&self) -> usize {
        if self.interpolant.is_subdivided() {
            self.normal.len() / padded(self.n_gauges)
        } else {
            self.skin.n_nodes()
        }
    }

    /// g(p) of one gauge.
    pub(crate) fn normal_of(&self, point: &SkinPoint, gauge: usize) -> f64 {
        let weights = self.interpolant.value_weights(&point.bary());
        let width = padded(self.n_gauges);
        self.interpolant.combine_one(&self.normal, width, point, &weights, gauge)
    }

    pub(crate) fn interpolant(&self) -> &Interpolant {
        &self.interpolant
    }

    /// Control values for normal forces, `[n_rows, padded(n_gauges)]`.
    pub(crate) fn normal_rows(&self) -> &[f64] {
        &self.normal
    }

    /// Control values for forces along x, y, z, `[n_rows, 3, padded(n_gauges)]`.
    pub(crate) fn vector_rows(&self) -> &[f64] {
        &self.vector
    }

    fn value(&self, rows: &[f64], width: usize, point: &SkinPoint) -> Vec<f64> {
        let weights = self.interpolant.value_weights(&point.bary());
        let mut out = self.combined(rows, width, point, &weights);
        out.truncate(self.n_gauges);
        out
    }

    fn combined(
        &self,
        rows: &[f64],
        width: usize,
        point: &SkinPoint,
        weights: &[f64; crate::basis::N_CUBIC],
    ) -> Vec<f64> {
        let mut out = vec![0.0; width];
        self.interpolant.combine(rows, point, weights, &mut out);
        out
    }

    fn as_vectors(&self, flat: &[f64]) -> Vec<Vector3<f64>> {
        let width = padded(self.n_gauges);
        let at = |gauge: usize| std::array::from_fn::<f64, 3, _>(|axis| flat[axis * width + gauge]);
        (0..self.n_gauges).map(|g| Vector3::from(at(g))).collect()
    }
}

impl Mix {
    /// to ← to + M from, row by row; rows of the `m` gauges are padded.
    fn add(&self, to: &mut [f64], from: &[f64], m: usize) {
        let width = padded(m);
        for (to, from) in to.chunks_exact_mut(width).zip(from.chunks_exact(width)) {
            match self {
                Self::All(matrix) => {
                    for (to, row) in to.iter_mut().zip(matrix.chunks_exact(m)) {
                        *to += row.iter().zip(from).map(|(c, v)| c * v).sum::<f64>();
                    }
                }
                Self::Each(factors) => {
                    let terms = factors.iter().zip(from).map(|(c, v)| c * v);
                    to.iter_mut().zip(terms).for_each(|(to, term)| *to += term);
                }
            }
        }
    }
}

fn check_gauges(n_gauges: usize) -> Result<(), InverseError> {
    if n_gauges == 0 {
        let (needed, n_live) = (3, 0);
        return Err(InverseError::TooFewGauges { n_live, needed });
    }
    Ok(())
}

/// Forces `[n, n_gauges]` as rows `[n, 3, padded(n_gauges)]`.
fn as_rows(adjoint: &[Vector3<f64>], n_gauges: usize) -> Result<Vec<f64>, InverseError> {
    let width = padded(n_gauges);
    let mut rows = vec![0.0; adjoint.len() / n_gauges * 3 * width];
    for (i, force) in adjoint.iter().enumerate() {
        check_finite("the adjoint fields", force.as_slice())?;
        let (node, gauge) = (i / n_gauges, i % n_gauges);
        for axis in 0..3 {
            rows[(3 * node + axis) * width + gauge] = force[axis];
        }
    }
    Ok(rows)
}

/// Rows `[n, padded(n_gauges)]` for forces against `normals` of rows `[n, 3, padded(n_gauges)]`.
fn against(normals: &[Vector3<f64>], vector: &[f64], n_gauges: usize) -> Vec<f64> {
    let width = padded(n_gauges);
    let mut rows = vec![0.0; normals.len() * width];
    for (node, direction) in normals.iter().enumerate() {
        for gauge in 0..n_gauges {
            let along = |axis: usize| vector[(3 * node + axis) * width + gauge];
            rows[node * width + gauge] = -(0..3).map(|a| along(a) * direction[a]).sum::<f64>();
        }
    }
    rows
}

fn add(to: &mut [f64], more: Vec<f64>) {
    to.iter_mut().zip(more).for_each(|(to, more)| *to += more);
}

/// The map of gauges on `skin` that see waves of their own, of wave numbers up to `most_per_m`, rad/m.
#[cfg(test)]
pub(crate) fn waves(
    skin: Skin,
    n_gauges: usize,
    most_per_m: f64,
    rng: &mut rand_chacha::ChaCha8Rng,
) -> ResponseMap {
    use rand::RngExt;

    let draw = |_| std::array::from_fn(|_| rng.random_range(-most_per_m..most_per_m));
    let waves: Vec<[f64; 3]> = (0..n_gauges).map(draw).collect();
    let seen = |x: &Point3<f64>| {
        let of = |w: &[f64; 3]| Vector3::z() * (w[0] * x.x + w[1] * x.y + w[2]).sin();
        waves.iter().map(of).collect::<Vec<_>>()
    };
    let nodal: Vec<Vector3<f64>> = skin.nodes().iter().flat_map(seen).collect();
    ResponseMap::from_nodal(skin, n_gauges, &nodal, &ResponseParams::default()).unwrap()
}
