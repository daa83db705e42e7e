//! One sweep over all edges: splits, collapses or flips (Botsch and Kobbelt 2004, section 4).

use nalgebra::{Point3, Vector3};

use super::work::{Kind, Work, key, normal, shape};

/// No operation may turn a face by more than this: cos 45°.
const MIN_TURN_COS: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// No operation may make a face worse shaped than this, unless one was worse before.
const MIN_SHAPE: f64 = 0.2;

/// Vertices of creases nearer than this part of the longest edge allowed become one, creases or
/// not: a sliver's direction means nothing, so the creases along it may not either.
const TINY: f64 = 0.1;

/// Splits edges longer than `longest_m`, the longest first, until there is none; the number split.
pub(super) fn split_long(work: &mut Work, longest_m: f64) -> usize {
    let mut n_split = 0;
    loop {
        let long = by_length(work, |length| length > longest_m);
        if long.is_empty() {
            return n_split;
        }
        for &(_, edge) in long.iter().rev() {
            work.split(edge);
            n_split += 1;
        }
    }
}

/// Collapses edges shorter than `shortest_m`, the shortest first, where that makes no edge longer
/// than `longest_m`, turns no face and keeps creases; the number collapsed.
pub(super) fn collapse_short(work: &mut Work, shortest_m: f64, longest_m: f64) -> usize {
    let mut n_collapsed = 0;
    for (_, edge) in by_length(work, |length| length < shortest_m) {
        // An earlier collapse may have taken or lengthened the edge.
        if work.faces_at(edge).is_empty() || work.length(edge) >= shortest_m {
            continue;
        }
        let [a, b] = edge;
        let found = [(a, b), (b, a)]
            .into_iter()
            .find_map(|(gone, kept)| Some((gone, kept, collapse_to(work, gone, kept, longest_m)?)));
        if let Some((gone, kept, place)) = found {
            work.collapse(gone, kept, place);
            n_collapsed += 1;
        }
    }
    n_collapsed
}

/// Flips edges that are no crease where this brings the number of neighbours nearer to six (four
/// on a rim), or mends a badly shaped face; the number flipped.
pub(super) fn flip_edges(work: &mut Work) -> usize {
    let mut n_flipped = 0;
    for edge in work.edges() {
        if let Some((faces, new_faces)) = flip_of(work, edge) {
            work.flip(edge, faces, new_faces);
            n_flipped += 1;
        }
    }
    n_flipped
}

/// Edges whose length `is_wanted`, ascending by length, ties by ends.
fn by_length(work: &Work, is_wanted: impl Fn(f64) -> bool) -> Vec<(f64, [u32; 2])> {
    let mut edges: Vec<(f64, [u32; 2])> = work
        .edges()
        .into_iter()
        .map(|edge| (work.length(edge), edge))
        .filter(|(length, _)| is_wanted(*length))
        .collect();
    edges.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    edges
}

/// Where the vertex that two become shall be, if `gone` may be drawn onto `kept`.
fn collapse_to(work: &Work, gone: u32, kept: u32, longest_m: f64) -> Option<Point3<f64>> {
    let edge = key(gone, kept);
    let is_crease = work.creases.contains(&edge);
    let [kind, kept_kind] = [gone, kept].map(|v| work.kinds[v as usize]);
    let may_go = match kind {
        Kind::Free => true,
        Kind::Crease if is_crease && !closes_crease(work, gone, kept) => true,
        _ => kind <= kept_kind && work.length(edge) < TINY * longest_m && !cuts_across(work, edge),
    };
    if !may_go {
        return None;
    }
    let place = if kind == kept_kind && kind != Kind::Corner {
        nalgebra::center(&work.at(gone), &work.at(kept))
    } else {
        work.at(kept)
    };
    let fits = keeps_manifold(work, gone, kept)
        && keeps_lengths(work, gone, kept, place, longest_m)
        && keeps_shapes(work, gone, kept, place);
    fits.then_some(place)
}

/// Whether an edge runs through the surface from rim to rim.
fn cuts_across(work: &Work, edge: [u32; 2]) -> bool {
    edge.iter().all(|&v| work.is_rim[v as usize]) && work.faces_at(edge).len() == 2
}

/// Whether the crease beyond `gone` ends at `kept` too, or at one of its crease neighbours.
fn closes_crease(work: &Work, gone: u32, kept: u32) -> bool {
    let beyond = work.crease_neighbours(gone);
    beyond.iter().any(|v| *v != kept && work.creases.contains(&key(*v, kept)))
}

/// The link condition (Dey, Edelsbrunner, Guha and Nekhayev, Publ. Inst. Math. 66, 1999): the ends
/// share no neighbour but those opposite to the edge; and none of these loses its last faces.
fn keeps_manifold(work: &Work, gone: u32, kept: u32) -> bool {
    let faces = work.faces_at(key(gone, kept));
    let theirs = work.neighbours(kept);
    let shared = work.neighbours(gone).into_iter().filter(|v| theirs.contains(v));
    let shared: Vec<u32> = shared.collect();
    let stays = |v: &u32| {
        let least = if work.is_rim[*v as usize] { 2 } else { 4 };
        work.around[*v as usize].len() >= least
    };
    shared.len() == faces.len() && shared.iter().all(stays)
}

fn keeps_lengths(work: &Work, gone: u32, kept: u32, place: Point3<f64>, longest_m: f64) -> bool {
    let ends = [gone, kept].into_iter().flat_map(|v| work.neighbours(v));
    let mut others = ends.filter(|v| *v != gone && *v != kept);
    others.all(|v| (work.at(v) - place).norm() <= longest_m)
}

fn keeps_shapes(work: &Work, gone: u32, kept: u32, place: Point3<f64>) -> bool {
    let faces = |v: u32| work.around[v as usize].iter().copied();
    let all: Vec<[Point3<f64>; 3]> =
        faces(gone).chain(faces(kept)).map(|f| work.corners(f)).collect();
    let ring = Ring::of(&all);
    let moving = [(gone, kept), (kept, gone)].into_iter();
    let mut moved = moving.flat_map(|(v, other)| {
        let stays = faces(v).filter(move |f| !work.faces[*f as usize].contains(&other));
        stays.map(move |f| (work.corners(f), work.corners_with(f, v, place)))
    });
    moved.all(|(old, new)| ring.allows(&old, &new))
}

/// A face worse shaped than this has no direction of its own to keep.
const SLIVER_SHAPE: f64 = 0.1;

/// The faces that a change touches: what they may become is judged against them all.
pub(super) struct Ring {
    /// Sum of their area normals.
    normal: Vector3<f64>,
    /// The least shape that a changed face may have.
    least_shape: f64,
}

impl Ring {
    pub fn of(faces: &[[Point3<f64>; 3]]) -> Self {
        Self {
            normal: faces.iter().map(normal).sum(),
            least_shape: faces.iter().map(shape).fold(MIN_SHAPE, f64::min),
        }
    }

    /// Whether a face keeps its direction, or a sliver that of all faces together, and does not
    /// become worse than the worst of them was.
    pub fn allows(&self, old: &[Point3<f64>; 3], new: &[Point3<f64>; 3]) -> bool {
        self.turns_little(old, new) && shape(new) >= self.least_shape
    }

    fn turns_little(&self, old: &[Point3<f64>; 3], new: &[Point3<f64>; 3]) -> bool {
        let (n_old, n_new) = (normal(old), normal(new));
        let agrees = |n: &Vector3<f64>| n.dot(&n_new) > MIN_TURN_COS * n.norm() * n_new.norm();
        agrees(&n_old) || (shape(old) < SLIVER_SHAPE && agrees(&self.normal))
    }
}

/// The faces at an edge and what they become by flipping it, if that is worth while.
fn flip_of(work: &Work, edge: [u32; 2]) -> Option<([u32; 2], [[u32; 3]; 2])> {
    if work.creases.contains(&edge) {
        return None;
    }
    let [first, second] = work.faces_at(edge)[..] else {
        return None;
    };
    let old = [first, second].map(|f| work.faces[f as usize]);
    // The first face runs from a to b, the second from b to a.
    let i = (0..3).find(|&i| edge.contains(&old[0][i]) && edge.contains(&old[0][(i + 1) % 3]))?;
    let (a, b, c) = (old[0][i], old[0][(i + 1) % 3], old[0][(i + 2) % 3]);
    let d = old[1].into_iter().find(|v| !edge.contains(v))?;
    if c == d || !work.faces_at(key(c, d)).is_empty() {
        return None;
    }
    let new = [[a, d, c], [d, b, c]];
    let places = |face: &[u32; 3]| face.map(|v| work.at(v));
    let (old_places, new_places) = (old.map(|f| places(&f)), new.map(|f| places(&f)));
    let ring = Ring::of(&old_places);
    let keeps = |n: &[Point3<f64>; 3]| old_places.iter().all(|o| ring.turns_little(o, n));
    let worst = |faces: &[[Point3<f64>; 3]; 2]| shape(&faces[0]).min(shape(&faces[1]));
    let (before, after) = (worst(&old_places), worst(&new_places));
    let is_better = evens_out(work, [a, b], [c, d]) && after >= MIN_SHAPE.min(before);
    let mends = before < MIN_SHAPE && after > 2.0 * before;
    let wanted = (is_better || mends) && new_places.iter().all(keeps);
    wanted.then_some(([first, second], new))
}

/// Whether taking a neighbour from `less` and giving one to `more` lowers Σ (valence − ideal)².
fn evens_out(work: &Work, less: [u32; 2], more: [u32; 2]) -> bool {
    let excess = |v: u32| {
        let (n_faces, is_rim) = (work.around[v as usize].len() as i64, work.is_rim[v as usize]);
        if is_rim { n_faces + 1 - 4 } else { n_faces - 6 }
    };
    let change: i64 = less.map(|v| 1 - 2 * excess(v)).iter().sum::<i64>()
        + more.map(|v| 1 + 2 * excess(v)).iter().sum::<i64>();
    change < 0
}
