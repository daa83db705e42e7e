//! Steps over the skin: straight lines that unfold the faces they cross.

use nalgebra::Vector3;

use crate::skin::{Side, Skin};
use crate::skin_point::{Frame, SkinPoint};

/// Edges crossed at most in one walk; a walk around a corner of many faces crosses each once.
const MAX_CROSSINGS: usize = 512;

/// Walls met in one place that are slid along; at a third the step points into a corner.
const MAX_SLIDES: usize = 2;

/// What a walk does where it may not go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AtWall {
    /// Stop there.
    Stop,
    /// Follow the edge with the part of the step that is left along it.
    Slide,
}

/// How a walk ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WalkEnd {
    /// The whole step was walked.
    Done,
    /// At the rim of the skin.
    Rim,
    /// At a fold.
    Fold,
    /// At a face that no contact may enter.
    Forbidden,
}

/// Where a walk led.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Walk {
    /// The point reached.
    pub point: SkinPoint,
    /// Distance walked, m.
    pub walked_m: f64,
    /// Why it ended; with [`AtWall::Slide`] the first wall met.
    pub end: WalkEnd,
}

impl Skin {
    /// Walks from `start` along the tangential part of `step` (m): straight in each face, and at an
    /// edge the rest of the step is turned about the edge into the next face, as if both were
    /// unfolded into a plane. On flat faces this is the discrete geodesic (Polthier and Schmies,
    /// Straightest Geodesics on Polyhedral Surfaces, 1998); on curved ones it agrees with the
    /// geodesic to first order in the step.
    ///
    /// # Panics
    /// If `start` is of another, larger skin.
    #[must_use]
    pub fn walk(&self, start: &SkinPoint, step: &Vector3<f64>, at_wall: AtWall) -> Walk {
        self.walk_at_most(start, step, at_wall, MAX_CROSSINGS)
    }

    /// The same over at most `max_crossings` edges, for steps whose time is bounded.
    pub(crate) fn walk_at_most(
        &self,
        start: &SkinPoint,
        step: &Vector3<f64>,
        at_wall: AtWall,
        max_crossings: usize,
    ) -> Walk {
        self.walk_counting(start, step, at_wall, max_crossings).0
    }

    /// The same, and how many edges were met.
    fn walk_counting(
        &self,
        start: &SkinPoint,
        step: &Vector3<f64>,
        at_wall: AtWall,
        max_crossings: usize,
    ) -> (Walk, usize) {
        let frame = self.frame(start);
        let [t1, t2] = frame.tangents;
        let along = t1 * t1.dot(step) + t2 * t2.dot(step);
        let is_finite = along.iter().all(|c| c.is_finite());
        let mut walker = Walker {
            skin: self,
            point: *start,
            frame,
            left: if is_finite { along } else { Vector3::zeros() },
            held: None,
            n_slides: 0,
            walked_m: 0.0,
            end: WalkEnd::Done,
        };
        let mut n_met = 0;
        while n_met < max_crossings {
            let Some(edge) = walker.go_straight() else {
                break;
            };
            n_met += 1;
            if !walker.cross(edge, at_wall) {
                break;
            }
        }
        let Walker { point, walked_m, end, .. } = walker;
        let walk = Walk { point, walked_m, end };
        (walk, n_met)
    }
}

struct Walker<'a> {
    skin: &'a Skin,
    point: SkinPoint,
    /// At `point`.
    frame: Frame,
    left: Vector3<f64>,
    /// The edge that is followed, which bounds the walk no more.
    held: Option<usize>,
    /// Walls met since the walk last got on.
    n_slides: usize,
    walked_m: f64,
    end: WalkEnd,
}

impl Walker<'_> {
    /// Goes straight until the step is used up (`None`) or an edge is met.
    fn go_straight(&mut self) -> Option<usize> {
        let length = self.left.norm();
        if length == 0.0 {
            return None;
        }
        let [dxi, deta] = self.frame.parent_step(&self.left);
        let mut rate = [-dxi - deta, dxi, deta];
        let mut bary = self.point.bary();
        if let Some(edge) = self.held {
            // along the edge the opposite corner's coordinate stays 0
            rate[(edge + 2) % 3] = 0.0;
            rate[(edge + 1) % 3] = -rate[edge];
        }
        let mut share = 1.0;
        let mut met = None;
        for i in 0..3 {
            if rate[i] < 0.0 && bary[i] + rate[i] * share < 0.0 {
                share = (-bary[i] / rate[i]).clamp(0.0, 1.0);
                met = Some(i);
            }
        }
        for i in 0..3 {
            bary[i] = (bary[i] + share * rate[i]).max(0.0);
        }
        if let Some(i) = met {
            bary[i] = 0.0;
        }
        let sum: f64 = bary.iter().sum();
        self.point = SkinPoint::trusted(self.point.face_id(), bary.map(|b| b / sum));
        self.walked_m += share * length;
        if share > 0.0 {
            self.n_slides = 0;
        }
        let met = met?;
        self.frame = self.skin.frame(&self.point);
        let [a, b] = self.frame.by_parent;
        let ahead = a * rate[1] + b * rate[2];
        let unit = ahead.try_normalize(0.0)?;
        self.left = unit * (length * (1.0 - share));
        // the edge opposite corner i starts at corner i + 1
        Some((met + 1) % 3)
    }

    /// Steps over `edge`, or stops or slides there; whether the walk goes on.
    fn cross(&mut self, edge: usize, at_wall: AtWall) -> bool {
        let face = self.point.face_id();
        let wall = match self.skin.side(face, edge) {
            Side::Rim => WalkEnd::Rim,
            Side::Fold => WalkEnd::Fold,
            Side::Across { face: next, .. } if self.skin.is_forbidden(next as usize) => {
                WalkEnd::Forbidden
            }
            Side::Across { face: next, edge: its_edge } => {
                self.unfold(edge, next, its_edge as usize);
                return true;
            }
        };
        if self.end == WalkEnd::Done {
            self.end = wall;
        }
        self.n_slides += 1;
        let is_cornered = self.n_slides > MAX_SLIDES || self.held == Some(edge);
        if at_wall == AtWall::Stop || is_cornered {
            return false;
        }
        let along = self.frame.edge_direction(edge);
        let is_backwards = self.held.is_some();
        self.left = along * along.dot(&self.left);
        self.held = Some(edge);
        !is_backwards || self.left.norm() > 0.0
    }

    fn unfold(&mut self, edge: usize, next: u32, its_edge: usize) {
        let along = self.frame.edge_direction(edge);
        let outward = -self.frame.inward(edge);
        let (ahead, across) = (self.left.dot(&along), self.left.dot(&outward).max(0.0));
        let bary = self.point.bary();
        let mut turned = [0.0; 3];
        turned[its_edge] = bary[(edge + 1) % 3];
        turned[(its_edge + 1) % 3] = bary[edge];
        self.point = SkinPoint::trusted(next, turned);
        self.frame = self.skin.frame(&self.point);
        self.left = along * ahead + self.frame.inward(its_edge) * across;
        self.held = None;
    }
}

#[cfg(test)]
mod tests;
