//! Contacts that come one after another or at once, are released or slide, followed at 1 kHz.

use std::time::Instant;

use anyhow::Result;
use hapdef::ScoredContact;
use hapdef_inverse::{
    AtWall, ContactEstimator, ContactTracker, SearchOutcome, Searcher, SkinPoint, TrackerParams,
};
use rand::RngExt;

use super::score::Score;
use super::world::{Draw, Frame, TrueContact, World};

/// Frames from one arrival to the next, and of each rise and fall of the force.
const BETWEEN: usize = 200;
const RISE: usize = 40;

/// Frames that a full search is given before it is adopted.
const SEARCH_FRAMES: u64 = 30;

/// How far a contact slides, m, and the frames it takes: 100 mm/s.
const SLIDE_M: f64 = 0.02;
const SLIDE: usize = 200;

/// A sliding contact comes no nearer to the others than the paper's contacts do, m.
const SLIDE_GAP_M: f64 = 0.012;

/// While a contact slides every such frame is scored.
const SCORED_EVERY: usize = 20;

/// Contacts in the order in which they come, and what happens once all have come.
pub(crate) struct Script {
    pub(crate) contacts: Vec<TrueContact>,
    /// Contacts that come in one frame.
    at_once: usize,
    event: Option<Event>,
}

enum Event {
    /// A contact is released.
    Release(usize),
    /// A contact slides over these places, one a frame.
    Slide(usize, Vec<SkinPoint>),
}

/// What following many scripts gave.
#[derive(Default)]
pub(crate) struct Followed {
    /// The last frame of each script, and others while a contact slides.
    pub(crate) score: Score,
    /// Time of every frame, µs.
    pub(crate) times_us: Vec<f64>,
    /// Full searches that were wanted.
    pub(crate) n_searches: usize,
}

impl Script {
    /// `contacts` one after another, all kept.
    pub(crate) fn new(contacts: Vec<TrueContact>) -> Self {
        Self { contacts, at_once: 1, event: None }
    }

    /// `k` contacts of 5 N to the scene's strongest, at least `gap_m` apart.
    pub(crate) fn draw(draw: &mut Draw<'_>, k: usize, gap_m: f64, strongest_n: f64) -> Self {
        let places = draw.places(k, [gap_m, f64::MAX]);
        let contact = |place| {
            let force_n = draw.rng.random_range(5.0..=strongest_n);
            draw.contact(place, force_n, 0.0)
        };
        Self::new(places.into_iter().map(contact).collect())
    }

    /// The same contacts, two in a frame.
    pub(crate) fn two_at_once(self) -> Self {
        Self { at_once: 2, ..self }
    }

    /// The same contacts, one of which is released in the end.
    pub(crate) fn with_release(self, draw: &mut Draw<'_>) -> Self {
        let which = draw.rng.random_range(0..self.contacts.len());
        let event = Some(Event::Release(which));
        Self { event, ..self }
    }

    /// The same contacts, one of which slides in the end; none if that would bring it too near to
    /// another.
    pub(crate) fn with_slide(self, draw: &mut Draw<'_>) -> Option<Self> {
        let which = draw.rng.random_range(0..self.contacts.len());
        let turn = draw.rng.random_range(0.0..std::f64::consts::TAU);
        let start = self.contacts[which].point;
        let skin = draw.skin;
        let [a, b] = skin.tangents(&start);
        let whole = (a * turn.cos() + b * turn.sin()) * SLIDE_M;
        let place = |frame: usize| {
            let step = whole * (frame as f64 / SLIDE as f64);
            skin.walk(&start, &step, AtWall::Slide).point
        };
        let path: Vec<SkinPoint> = (1..=SLIDE).map(place).collect();
        let others = (0..self.contacts.len()).filter(|&i| i != which);
        let others: Vec<_> = others.map(|i| skin.position(&self.contacts[i].point)).collect();
        let is_clear = |p: &SkinPoint| {
            let here = skin.position(p);
            let gaps_m = others.iter().map(|other| (here - other).norm());
            gaps_m.fold(f64::MAX, f64::min) >= SLIDE_GAP_M
        };
        let is_clear = path.iter().all(is_clear);
        let event = Some(Event::Slide(which, path));
        is_clear.then_some(Self { event, ..self })
    }

    /// The script with its first `n` contacts, and its frames before the next arrives.
    pub(crate) fn first(&self, n: usize) -> (Self, usize) {
        let contacts = self.contacts[..n].to_vec();
        (Self::new(contacts), BETWEEN * n + BETWEEN / 2)
    }

    /// First frame in which `n` contacts that come one after another press.
    pub(crate) fn first_frame_of(n: usize) -> usize {
        BETWEEN / 2 + (n - 1) * BETWEEN + 1
    }

    pub(crate) fn n_frames(&self) -> usize {
        let event = match &self.event {
            None => 0,
            Some(Event::Release(_)) => RISE,
            Some(Event::Slide(_, path)) => path.len(),
        };
        self.event_frame() + event + BETWEEN / 2
    }

    /// Force of each contact in `frame`, N.
    pub(crate) fn forces_n(&self, frame: usize) -> Vec<f64> {
        let share = |from: usize| (frame.saturating_sub(from) as f64 / RISE as f64).min(1.0);
        let mut forces_n: Vec<f64> = self
            .contacts
            .iter()
            .enumerate()
            .map(|(i, contact)| contact.force_n * share(self.onset_frame(i)))
            .collect();
        if let Some(Event::Release(which)) = self.event {
            forces_n[which] *= 1.0 - share(self.event_frame());
        }
        forces_n
    }

    /// Readings of every frame `[n_frames][n_channels]`, µε.
    pub(crate) fn readings(&self, world: &World, stream: u64) -> Result<Vec<Vec<f64>>> {
        let units = |contacts: &[TrueContact]| -> Result<Vec<Vec<f64>>> {
            contacts.iter().map(|c| world.unit_strains(c)).collect()
        };
        let at_first = units(&self.contacts)?;
        let moved: Vec<TrueContact> = match &self.event {
            Some(Event::Slide(which, path)) => {
                let moved = |&point| TrueContact { point, ..self.contacts[*which] };
                path.iter().map(moved).collect()
            }
            _ => Vec::new(),
        };
        let moved = units(&moved)?;
        let mut electronics = world.electronics(stream)?;
        let frames = (0..self.n_frames()).map(|frame| {
            let mut sum = vec![0.0; at_first[0].len()];
            for (i, force_n) in self.forces_n(frame).into_iter().enumerate() {
                let unit = match self.moved_to(i, frame) {
                    Some(place) => &moved[place],
                    None => &at_first[i],
                };
                for (sum, unit) in sum.iter_mut().zip(unit) {
                    *sum += force_n * unit;
                }
            }
            electronics.measure(&mut sum);
            sum
        });
        Ok(frames.collect())
    }

    /// The contacts that press in `frame`.
    fn contacts_in(&self, frame: usize) -> Vec<TrueContact> {
        let forces_n = self.forces_n(frame).into_iter().enumerate();
        let pressing = forces_n.filter(|(_, force_n)| *force_n > 0.0);
        let contact = |(i, force_n): (usize, f64)| {
            let mut point = self.contacts[i].point;
            if let (Some(Event::Slide(_, path)), Some(place)) =
                (&self.event, self.moved_to(i, frame))
            {
                point = path[place];
            }
            TrueContact { point, force_n, ..self.contacts[i] }
        };
        pressing.map(contact).collect()
    }

    fn is_scored(&self, frame: usize) -> bool {
        let Some(Event::Slide(_, path)) = &self.event else {
            return false;
        };
        let since = (frame + 1).saturating_sub(self.event_frame());
        (1..=path.len()).contains(&since) && since.is_multiple_of(SCORED_EVERY)
    }

    fn onset_frame(&self, contact: usize) -> usize {
        BETWEEN / 2 + contact / self.at_once * BETWEEN
    }

    fn event_frame(&self) -> usize {
        self.onset_frame(self.contacts.len().saturating_sub(1)) + BETWEEN
    }

    /// Where on its path a contact that has begun to slide is in `frame`.
    fn moved_to(&self, contact: usize, frame: usize) -> Option<usize> {
        match &self.event {
            Some(Event::Slide(which, path)) if *which == contact => {
                let since = frame.checked_sub(self.event_frame())?;
                Some(since.min(path.len() - 1))
            }
            _ => None,
        }
    }
}

impl Followed {
    /// Follows one script; the readings' first channels are the estimator's gauges.
    pub(crate) fn follow(
        &mut self,
        estimator: &ContactEstimator,
        searcher: &mut Searcher,
        script: &Script,
        readings: &[Vec<f64>],
    ) -> Result<()> {
        let skin = estimator.map().skin();
        let n_gauges = estimator.map().n_gauges();
        let mut tracker = ContactTracker::new(estimator, TrackerParams::default())?;
        let mut pending: Option<SearchOutcome> = None;
        for (index, frame) in readings.iter().enumerate() {
            let due = |o: &mut SearchOutcome| index as u64 >= o.frame + SEARCH_FRAMES;
            let ready = pending.take_if(due);
            let start = Instant::now();
            if let Some(outcome) = &ready {
                tracker.adopt(outcome);
            }
            tracker.step(&frame[..n_gauges], None)?;
            self.times_us.push(start.elapsed().as_secs_f64() * 1e6);
            if let Some(request) = tracker.wanted_search() {
                let mut outcome = SearchOutcome::default();
                searcher.search(&request, &mut outcome)?;
                pending = Some(outcome);
                self.n_searches += 1;
            }
            if script.is_scored(index) || index + 1 == readings.len() {
                let truth = Frame { contacts: script.contacts_in(index), readings_ue: Vec::new() };
                let contacts = &tracker.last().contacts;
                let found: Vec<ScoredContact> = contacts
                    .iter()
                    .map(|c| (c.contact.position_m.coords.into(), c.contact.force_n))
                    .collect();
                let time_us = self.times_us.last().copied().unwrap_or(0.0);
                self.score.add(skin, &truth, &found, time_us)?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::world::tests::on_a_triangle;
    use super::*;

    fn n_pressing(script: &Script, frame: usize) -> usize {
        script.contacts_in(frame).len()
    }

    #[test]
    fn two_come_at_once_and_one_of_three_goes() {
        let (skin, contacts) = on_a_triangle(&[[0.02, 0.02], [0.05, 0.02], [0.02, 0.05]]);
        let mut draw = Draw::new(&skin, 1);
        let script = Script::new(contacts.clone()).two_at_once();
        let first = Script::first_frame_of(1);
        let counts = [first - 1, first, Script::first_frame_of(2)].map(|f| n_pressing(&script, f));
        assert_eq!(counts, [0, 2, 3]);
        let script = Script::new(contacts).with_release(&mut draw);
        let last = script.n_frames() - 1;
        let counts = [script.event_frame(), last].map(|f| n_pressing(&script, f));
        assert_eq!(counts, [3, 2]);
    }

    #[test]
    fn a_contact_slides_evenly_and_keeps_away_from_others() {
        let (skin, contacts) = on_a_triangle(&[[0.03, 0.03]]);
        let mut draw = Draw::new(&skin, 1);
        let script = Script::new(contacts.clone()).with_slide(&mut draw).unwrap();
        let at = |frame: usize| skin.position(&script.contacts_in(frame)[0].point);
        let from = script.event_frame();
        let gone = |frame| (at(frame) - at(from - 1)).norm();
        assert!((gone(from + SLIDE / 2 - 1) - SLIDE_M / 2.0).abs() < 1e-9);
        assert!((gone(script.n_frames() - 1) - SLIDE_M).abs() < 1e-9);
        let scored = (0..script.n_frames()).filter(|frame| script.is_scored(*frame));
        assert_eq!(scored.count(), SLIDE / SCORED_EVERY);
        let (_, beside) = on_a_triangle(&[[0.03, 0.03], [0.035, 0.03]]);
        assert!(Script::new(beside).with_slide(&mut draw).is_none());
    }

    #[test]
    fn so_many_contacts_press_from_the_stated_frame_to_the_end() {
        let (_, contacts) = on_a_triangle(&[[0.03, 0.03]; 3]);
        let whole = Script::new(contacts);
        for n in 1..=3 {
            let (script, n_frames) = whole.first(n);
            let first = Script::first_frame_of(n);
            let counts = [first - 1, first].map(|frame| n_pressing(&script, frame));
            assert_eq!(counts, [n - 1, n]);
            assert!((first..n_frames).all(|frame| n_pressing(&script, frame) == n));
        }
    }
}
