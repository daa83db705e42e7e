//! Whether two triangles cross.

use nalgebra::{Point3, Vector3};
use robust::{Coord, Coord3D, orient2d, orient3d};

type Triangle = [Point3<f64>; 3];

/// What two triangles share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Overlap {
    /// Its middle, m.
    pub(super) place: Point3<f64>,
    /// Its length, m.
    pub(super) length_m: f64,
}

/// What two triangles share if that is a line through both their insides, or an area of the one
/// plane they lie in (Guigue and Devillers, J. Graphics Tools 8(1), 2003; the signs are exact, the
/// place is rounded).
pub(super) fn overlap([one, two]: [Triangle; 2]) -> Option<Overlap> {
    let of_two = sides(&one, &two);
    if !straddles(&of_two) && of_two != [0; 3] {
        return None;
    }
    let of_one = sides(&two, &one);
    if of_one == [0; 3] && of_two == [0; 3] {
        return in_plane(&one, &two);
    }
    if !straddles(&of_one) || !straddles(&of_two) {
        return None;
    }
    let (mut p, p_side) = lone_first(&one, &of_one);
    let (mut q, q_side) = lone_first(&two, &of_two);
    if p_side < 0 {
        q.swap(1, 2);
    }
    if q_side < 0 {
        p.swap(1, 2);
    }
    let overlaps = side(&[p[0], p[1], q[0]], &q[1]) < 0 && side(&[p[0], p[2], q[2]], &q[0]) < 0;
    overlaps.then(|| shared_line(&p, &q))
}

/// On which side of the plane of `triangle` each corner of `other` lies.
fn sides(triangle: &Triangle, other: &Triangle) -> [i8; 3] {
    [0, 1, 2].map(|i| side(triangle, &other[i]))
}

/// 1 where `point` is on the side of the plane from which the triangle runs counter-clockwise, −1 on
/// the other, 0 on it.
fn side(triangle: &Triangle, point: &Point3<f64>) -> i8 {
    let coord = |p: &Point3<f64>| Coord3D { x: p.x, y: p.y, z: p.z };
    let [a, b, c] = triangle;
    sign(-orient3d(coord(a), coord(b), coord(c), coord(point)))
}

fn sign(value: f64) -> i8 {
    i8::from(value > 0.0) - i8::from(value < 0.0)
}

fn straddles(sides: &[i8; 3]) -> bool {
    sides.contains(&1) && sides.contains(&-1)
}

/// The triangle turned so that the corner comes first that is alone on its side, and its side.
fn lone_first(triangle: &Triangle, sides: &[i8; 3]) -> (Triangle, i8) {
    let is_lone =
        |&i: &usize| sides[i] != 0 && sides.iter().filter(|s| **s == sides[i]).count() == 1;
    let lone = (0..3).find(is_lone).unwrap_or(0);
    let turned = [0, 1, 2].map(|i| triangle[(lone + i) % 3]);
    (turned, sides[lone])
}

/// The line that two crossing triangles share, their lone corners first: of the four places where
/// their edges go through the other's plane the middle two.
fn shared_line(p: &Triangle, q: &Triangle) -> Overlap {
    let [normal_p, normal_q] = [normal(p), normal(q)];
    let along = normal_p.cross(&normal_q);
    let through = |from: &Point3<f64>, to: &Point3<f64>, on: &Point3<f64>, n: &Vector3<f64>| {
        let [a, b] = [from, to].map(|x| (x - on).dot(n));
        from + (to - from) * (a / (a - b))
    };
    let mut places = [
        through(&p[0], &p[1], &q[0], &normal_q),
        through(&p[0], &p[2], &q[0], &normal_q),
        through(&q[0], &q[1], &p[0], &normal_p),
        through(&q[0], &q[2], &p[0], &normal_p),
    ];
    places.sort_by(|a, b| along.dot(&a.coords).total_cmp(&along.dot(&b.coords)));
    Overlap {
        place: nalgebra::center(&places[1], &places[2]),
        length_m: (places[2] - places[1]).norm(),
    }
}

fn normal([a, b, c]: &Triangle) -> Vector3<f64> {
    (b - a).cross(&(c - a))
}

/// Two triangles of one plane overlap if no edge of either has the other wholly on its far side.
fn in_plane(one: &Triangle, two: &Triangle) -> Option<Overlap> {
    let across = normal(one).iamax();
    let flat = |triangle: &Triangle| {
        let [u, v] = [1, 2].map(|i| (across + i) % 3);
        let corners = triangle.map(|p| Coord { x: p[u], y: p[v] });
        let [a, b, c] = corners;
        match sign(orient2d(a, b, c)) {
            0 => None,
            1 => Some([a, b, c]),
            _ => Some([a, c, b]),
        }
    };
    let (p, q) = (flat(one)?, flat(two)?);
    if parted(&p, &q) || parted(&q, &p) {
        return None;
    }
    let longest = |t: &Triangle| (0..3).map(|i| (t[(i + 1) % 3] - t[i]).norm()).fold(0.0, f64::max);
    let corners = one.iter().chain(two).map(|p| p.coords / 6.0);
    Some(Overlap {
        place: Point3::from(corners.sum::<Vector3<f64>>()),
        length_m: longest(one).min(longest(two)),
    })
}

/// Whether an edge of `p`, counter-clockwise, has all of `q` on its far side or on itself.
fn parted(p: &[Coord<f64>; 3], q: &[Coord<f64>; 3]) -> bool {
    (0..3).any(|i| q.iter().all(|c| orient2d(p[i], p[(i + 1) % 3], *c) <= 0.0))
}
