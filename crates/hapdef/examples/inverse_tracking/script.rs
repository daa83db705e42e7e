//! What happens in a scene: who presses where, when and how hard.

use hapdef_inverse::{AtWall, Skin, SkinPoint};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::shared::places_apart;

/// Contacts of a scene.
pub(crate) const N_CONTACTS: usize = 4;

/// Least distance between contacts, m.
const GAP_M: f64 = 0.02;

/// Speed of a slide, m/s, and how long it lasts, frames.
const SLIDE_M_PER_S: f64 = 0.04;
const SLIDE_FRAMES: usize = 500;

/// What a scene is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    OneByOne,
    Release,
    Slide,
    TwoAtOnce,
    TwoPairs,
}

impl Kind {
    pub(crate) const ALL: [Self; 5] =
        [Self::OneByOne, Self::Release, Self::Slide, Self::TwoAtOnce, Self::TwoPairs];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::OneByOne => "one by one",
            Self::Release => "then released",
            Self::Slide => "then one slides",
            Self::TwoAtOnce => "first two at once",
            Self::TwoPairs => "pair after pair",
        }
    }
}

/// Ramps of a contact's force: (first frame, last frame, force then), in order.
type Ramps = Vec<(usize, usize, f64)>;

/// A contact's path and force.
#[derive(Clone, Debug)]
pub(crate) struct Press {
    pub(crate) point: SkinPoint,
    pub(crate) start: usize,
    ramps: Ramps,
    /// First frame and direction of a slide.
    slide: Option<(usize, nalgebra::Vector3<f64>)>,
}

/// A scene, and the frames at which it is judged.
#[derive(Clone, Debug)]
pub(crate) struct Script {
    pub(crate) presses: Vec<Press>,
    /// All contacts are there and held.
    pub(crate) all_there: usize,
    pub(crate) n_frames: usize,
}

impl Press {
    pub(crate) fn force_n(&self, frame: usize) -> f64 {
        let mut force = 0.0;
        for &(first, last, to) in &self.ramps {
            if frame >= last {
                force = to;
            } else if frame > first {
                return force + (to - force) * (frame - first) as f64 / (last - first) as f64;
            }
        }
        force
    }

    pub(crate) fn point(&self, skin: &Skin, frame: usize) -> SkinPoint {
        let Some((first, direction)) = self.slide else {
            return self.point;
        };
        let n = frame.saturating_sub(first).min(SLIDE_FRAMES);
        let far = direction * (n as f64 * 1e-3 * SLIDE_M_PER_S);
        skin.walk(&self.point, &far, AtWall::Stop).point
    }

    fn last_change(&self, frame: usize) -> Option<usize> {
        let ends = self.ramps.iter().filter(|r| r.0 <= frame);
        ends.map(|r| r.1.min(frame)).max()
    }
}

impl Script {
    pub(crate) fn draw(kind: Kind, skin: &Skin, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut presses: Vec<Press> = Vec::new();
        let mut start = 100;
        for point in places_apart(skin, N_CONTACTS, GAP_M, &mut rng) {
            let place = (kind, presses.len());
            let with_last = matches!(place, (Kind::TwoAtOnce, 1) | (Kind::TwoPairs, 1 | 3));
            if !presses.is_empty() && !with_last {
                start += rng.random_range(150..250);
            }
            let ramps =
                vec![(start, start + rng.random_range(20..50), rng.random_range(5.0..34.0))];
            presses.push(Press { point, start, ramps, slide: None });
        }
        let all_there = start + 250;
        for press in &mut presses {
            change_forces(&mut press.ramps, all_there, &mut rng);
        }
        let mut script = Self { presses, all_there, n_frames: all_there };
        script.go_on(kind, skin, &mut rng);
        script
    }

    fn go_on(&mut self, kind: Kind, skin: &Skin, rng: &mut ChaCha8Rng) {
        match kind {
            Kind::Release => {
                for (i, press) in self.presses.iter_mut().enumerate() {
                    let first = self.all_there + 20 + 150 * i;
                    press.ramps.push((first, first + rng.random_range(20..50), 0.0));
                }
                self.n_frames += 150 * N_CONTACTS + 20;
            }
            Kind::Slide => {
                let first = self.all_there + 20;
                let press = &mut self.presses[rng.random_range(0..N_CONTACTS)];
                let (s, c) = rng.random_range(0.0..std::f64::consts::TAU).sin_cos();
                let [t1, t2] = skin.tangents(&press.point);
                press.slide = Some((first, t1 * c + t2 * s));
                self.n_frames += SLIDE_FRAMES + 220;
            }
            _ => {}
        }
    }

    /// Contacts that press at `frame`.
    pub(crate) fn pressing(&self, frame: usize) -> impl Iterator<Item = &Press> {
        self.presses.iter().filter(move |press| press.force_n(frame) > 0.0)
    }

    /// Whether no contact has come or gone in the last `n` frames.
    pub(crate) fn is_settled(&self, frame: usize, n: usize) -> bool {
        let changes = |press: &Press| {
            let begins = press.start <= frame && press.start + n + 50 > frame;
            let is_gone = press.start < frame && press.force_n(frame) < 1.0;
            let ends = is_gone && press.last_change(frame).is_some_and(|last| last + n > frame);
            begins || ends
        };
        !self.presses.iter().any(changes)
    }
}

/// Now and then a force goes to another value.
fn change_forces(ramps: &mut Ramps, end: usize, rng: &mut ChaCha8Rng) {
    let mut next = ramps[0].1 + rng.random_range(80..250);
    while next + 100 < end {
        let last = next + rng.random_range(20..50);
        ramps.push((next, last, rng.random_range(5.0..34.0)));
        next = last + rng.random_range(80..250);
    }
}
