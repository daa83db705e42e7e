//! Two triangles of a surface that cross.

use nalgebra::Point3;

/// Pairs after which the search ends: a tangle of n triangles can have n² / 2.
pub(super) const MOST_CROSSINGS: usize = 1_000_000;

/// Crossings whose places are listed.
const N_LISTED: usize = 3;

/// Two triangles without a common vertex that cross, or lie in one plane and overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// The triangles, the first with the smaller number, counted from 0.
    pub triangles: [usize; 2],
    /// The middle of what they share, m.
    pub place: Point3<f64>,
    /// How long the line is that they share, m; of an overlap in one plane the shorter of the two
    /// triangles' longest edges.
    pub length_m: f64,
}

/// How many pairs there are, in words.
pub(super) fn number(crossings: &[Crossing]) -> String {
    match crossings.len() {
        MOST_CROSSINGS => format!("at least {MOST_CROSSINGS}"),
        n => n.to_string(),
    }
}

/// The first places in words, mm.
pub(super) fn places(crossings: &[Crossing]) -> String {
    let place = |c: &Crossing| {
        let [x, y, z] = c.place.coords.map(|x| 1e3 * x).into();
        format!("({x:.2}, {y:.2}, {z:.2})")
    };
    let listed: Vec<String> = crossings.iter().take(N_LISTED).map(place).collect();
    let more = if crossings.len() > N_LISTED { " … mm" } else { " mm" };
    listed.join(", ") + more
}
