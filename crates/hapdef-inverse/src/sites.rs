//! Scan sites: points spread evenly over the skin.

use nalgebra::Point3;

use crate::basis::NODES;
use crate::error::InverseError;
use crate::skin::Skin;
use crate::skin_point::SkinPoint;

/// Neighbours of a site that a local maximum is compared with.
const N_NEAR: usize = 8;

/// Points spread over the skin by farthest-point sampling.
#[derive(Clone, Debug)]
pub struct ScanSites {
    points: Vec<SkinPoint>,
    positions: Vec<Point3<f64>>,
    near: Vec<[u32; N_NEAR]>,
    site_of_node: Vec<u32>,
    spacing_m: f64,
}

impl ScanSites {
    /// `n_sites` points of `skin`, each new one the farthest from those before (Gonzalez 1985),
    /// among nodes and points within the faces that may be entered; fewer if there are no more.
    ///
    /// # Errors
    /// [`InverseError::Parameter`] for no sites, [`InverseError::Length`] if every face is forbidden.
    pub fn farthest(skin: &Skin, n_sites: usize) -> Result<Self, InverseError> {
        if n_sites == 0 || n_sites > 20_000 {
            return Err(InverseError::Parameter {
                what: "n_sites",
                found: n_sites as f64,
                expected: "1 to 20000",
            });
        }
        let pool = pool(skin, n_sites);
        let Some(first) = pool.first() else {
            return Err(InverseError::Length {
                what: "the faces that are not forbidden",
                expected: 1,
                found: 0,
            });
        };
        let places: Vec<_> = pool.iter().map(|p| skin.position(p)).collect();
        let mut far: Vec<f64> =
            places.iter().map(|x| (x - skin.position(first)).norm_squared()).collect();
        let mut chosen = vec![0];
        while chosen.len() < n_sites.min(pool.len()) {
            let (next, &gap) = far
                .iter()
                .enumerate()
                .max_by(|a, b| a.1.total_cmp(b.1).then(b.0.cmp(&a.0)))
                .unwrap_or((0, &0.0));
            if gap <= 0.0 {
                break;
            }
            chosen.push(next);
            for (far, x) in far.iter_mut().zip(&places) {
                *far = far.min((x - places[next]).norm_squared());
            }
        }
        let points: Vec<_> = chosen.iter().map(|&i| pool[i]).collect();
        let positions: Vec<_> = chosen.iter().map(|&i| places[i]).collect();
        let near = (0..points.len()).map(|site| nearest_sites(&positions, site)).collect();
        let site_of_node = skin.nodes().iter().map(|x| nearest_site(&positions, x)).collect();
        let spacing_m = far.iter().fold(0.0, |a: f64, &b| a.max(b)).sqrt();
        Ok(Self { points, positions, near, site_of_node, spacing_m })
    }

    /// Number of sites.
    #[must_use]
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether there are none; there always are.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// The sites `[n_sites]`.
    #[must_use]
    pub fn points(&self) -> &[SkinPoint] {
        &self.points
    }

    /// Their positions `[n_sites]`, m.
    #[must_use]
    pub fn positions(&self) -> &[Point3<f64>] {
        &self.positions
    }

    /// The farthest that a point of the sampled skin is from its nearest site, m.
    #[must_use]
    pub fn spacing_m(&self) -> f64 {
        self.spacing_m
    }

    /// The sites nearest to a site; its own index where there are fewer.
    pub(crate) fn near(&self, site: usize) -> &[u32; N_NEAR] {
        &self.near[site]
    }

    /// A site near `point`: that of its face's nearest corner.
    pub(crate) fn of_point(&self, skin: &Skin, point: &SkinPoint) -> usize {
        let corner = skin.face(point.face_id())[point.nearest_corner()];
        self.site_of_node[corner as usize] as usize
    }
}

/// Nodes, then points within the faces, as many as `n_sites` needs.
fn pool(skin: &Skin, n_sites: usize) -> Vec<SkinPoint> {
    let mut pool: Vec<SkinPoint> = skin.node_points().into_iter().flatten().collect();
    let open = || (0..skin.n_faces()).filter(|&face| !skin.is_forbidden(face));
    let n_open = open().count().max(1);
    let n_cuts = ((4.0 * n_sites as f64 / n_open as f64).sqrt().ceil() as u32).clamp(1, 24);
    for face in open() {
        for inner in inner_points(n_cuts) {
            pool.push(SkinPoint::trusted(face as u32, inner));
        }
    }
    pool
}

/// The centroids of the n² equal parts of a face.
fn inner_points(n: u32) -> Vec<[f64; 3]> {
    let mut points = Vec::new();
    let size = f64::from(3 * n);
    for i in 0..n {
        for j in 0..n - i {
            let (a, b) = (f64::from(3 * i), f64::from(3 * j));
            let mut add = |a: f64, b: f64| {
                let (x, y) = (a / size, b / size);
                points.push([1.0 - x - y, x, y]);
            };
            add(a + 1.0, b + 1.0);
            if i + j + 1 < n {
                add(a + 2.0, b + 2.0);
            }
        }
    }
    points.retain(|p| !NODES.contains(p));
    points
}

fn nearest_site(positions: &[Point3<f64>], x: &Point3<f64>) -> u32 {
    let distance = |site: &usize| (positions[*site] - x).norm_squared();
    (0..positions.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0) as u32
}

fn nearest_sites(positions: &[Point3<f64>], site: usize) -> [u32; N_NEAR] {
    let mut near = [(f64::INFINITY, site as u32); N_NEAR];
    for (other, x) in positions.iter().enumerate().filter(|(o, _)| *o != site) {
        let distance = (x - positions[site]).norm_squared();
        if distance < near[N_NEAR - 1].0 {
            near[N_NEAR - 1] = (distance, other as u32);
            near.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
    }
    near.map(|(_, other)| other)
}
