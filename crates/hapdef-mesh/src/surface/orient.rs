//! Turning triangles over until neighbours agree on which side is outside.

use super::topology::{bodies, repeats, sorted_half_edges};
use crate::SurfaceMesh;

impl SurfaceMesh {
    /// The surface with triangles turned over so that neighbours agree, and how many were turned.
    ///
    /// A body whose triangles disagreed faces outward afterwards, by its volume (as if it were closed,
    /// where it is open), and so does a surface of one body. Other bodies that agree stay as they are:
    /// one may be a cavity. Edges of more than two triangles say nothing; a surface that has no two
    /// sides keeps edges that disagree.
    #[must_use]
    pub fn oriented(&self) -> (Self, usize) {
        let mut turned = self.disagreeing();
        let bodies = bodies(self.triangles());
        let origin = self.bounding_box().centre();
        for body in &bodies {
            let volume = |t: &usize| {
                let flux = (self.corners(*t)[0] - origin).dot(&self.area_normal_m2(*t));
                if turned[*t] { -flux } else { flux }
            };
            let faces_inward = body.iter().map(volume).sum::<f64>() < 0.0;
            let had_two_minds = body.iter().any(|t| turned[*t]);
            if faces_inward && (had_two_minds || bodies.len() == 1) {
                body.iter().for_each(|t| turned[*t] = !turned[*t]);
            }
        }
        let mut triangles = self.triangles().to_vec();
        for (corners, _) in triangles.iter_mut().zip(&turned).filter(|(_, turned)| **turned) {
            corners.swap(1, 2);
        }
        let n_turned = turned.iter().filter(|turned| **turned).count();
        (self.with_triangles(triangles), n_turned)
    }

    /// Which triangles disagree with the first of their body, over edges of two triangles.
    fn disagreeing(&self) -> Vec<bool> {
        let n = self.triangles().len();
        let mut across: Vec<Vec<(usize, bool)>> = vec![Vec::new(); n];
        for uses in sorted_half_edges(self.triangles()).chunk_by(|a, b| a.ends() == b.ends()) {
            if let [a, b] = uses {
                let disagree = a.is_forward == b.is_forward;
                across[a.triangle].push((b.triangle, disagree));
                across[b.triangle].push((a.triangle, disagree));
            }
        }
        let mut turned: Vec<Option<bool>> = vec![None; n];
        for first in (0..n).filter(|t| !repeats(&self.triangles()[*t])) {
            if turned[first].is_some() {
                continue;
            }
            turned[first] = Some(false);
            let mut open = vec![first];
            while let Some(triangle) = open.pop() {
                let is_turned = turned[triangle] == Some(true);
                for &(other, disagree) in &across[triangle] {
                    if turned[other].is_none() {
                        turned[other] = Some(is_turned != disagree);
                        open.push(other);
                    }
                }
            }
        }
        turned.into_iter().map(|turned| turned == Some(true)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::triangles::tests::{cuboid, sphere};

    fn turned_over(mesh: &SurfaceMesh, which: impl Fn(usize) -> bool) -> SurfaceMesh {
        let mut triangles = mesh.triangles().to_vec();
        for (_, corners) in triangles.iter_mut().enumerate().filter(|(t, _)| which(*t)) {
            corners.swap(1, 2);
        }
        mesh.with_triangles(triangles)
    }

    #[test]
    fn turned_triangles_are_turned_back() {
        let mesh = sphere(2);
        for which in
            [|t: usize| t.is_multiple_of(3), |t: usize| !t.is_multiple_of(3), |_| true, |_| false]
        {
            let given = turned_over(&mesh, which);
            let (oriented, n_turned) = given.oriented();
            let expected = (0..mesh.triangles().len()).filter(|t| which(*t)).count();
            assert_eq!(n_turned, expected);
            assert_eq!(oriented.signed_volume_m3(), mesh.signed_volume_m3());
        }
    }

    #[test]
    fn a_cavity_that_agrees_stays_one() {
        let outer = cuboid(3.0, 3.0, 3.0);
        let inner = turned_over(&cuboid(1.0, 1.0, 1.0), |_| true);
        let shift = |v: &nalgebra::Point3<f64>| v + nalgebra::Vector3::repeat(1.0);
        let vertices = outer.vertices().iter().copied().chain(inner.vertices().iter().map(shift));
        let more = inner.triangles().iter().map(|t| t.map(|v| v + 8));
        let triangles = outer.triangles().iter().copied().chain(more).collect();
        let hollow = SurfaceMesh::new(vertices.collect(), triangles).unwrap();
        let (oriented, n_turned) = turned_over(&hollow, |t| t == 5).oriented();
        assert_eq!(n_turned, 1);
        assert!((oriented.signed_volume_m3() - 26.0).abs() < 1e-12);
    }
}
