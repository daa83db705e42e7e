//! Contacts exchanged: one or two are looked for anew beside the others that are believed.

use crate::tracker::frame::ContactId;
use crate::tracker::gathered::Gathered;
use crate::tracker::hypotheses::HypothesisRef;
use crate::tracker::hypothesis::{Hypothesis, Track};
use crate::tracker::locate::Fit;
use crate::tracker::pair_birth::N_FINALISTS;
use crate::tracker::proposals::{are_apart, propose_births, scan_beside};
use crate::tracker::workspace::Workspace;

/// Times at most that all contacts are gone round: what one exchange put right makes room for the next.
const MAX_ROUNDS: usize = 3;

/// Pairs that are refined of each scan, and of that beside what was trusted. The scan ranks pairs as if they were at
/// sites, so beside two strong contacts that are known the right pair stood hundreds of places down. 200 was chosen on
/// `compare`'s row of two at once beside two, test seeds 611 and 612: fewer lost scripts, 400 beside everything gained
/// hardly any and took several times as long.
const N_PAIRS: usize = 8;
const N_TRUSTED_PAIRS: usize = 200;

/// Trial steps of each contact at first, and of those that are refined to the end. With 4 for four contacts that all
/// move the right ones kept a χ² of a hundred and more.
const N_PROBE: usize = 8;
const N_TRIALS: usize = 24;

/// Force of a contact that comes, a share of the expected: with it the map's error where it may be is weighed.
const NEWCOMER_SHARE: f64 = 0.5;

/// What a tracker believes, and the frames that it doesn't explain.
#[derive(Clone, Debug, PartialEq)]
pub struct Belief {
    hypothesis: Hypothesis,
    /// The contacts that were all held when frames were last explained.
    trusted: Hypothesis,
    gathered: Gathered,
    next_id: u64,
    /// Gauges that were read, of those of the model.
    live: Vec<bool>,
    n_live: usize,
    /// −2 ln evidence of the frames, and their χ².
    cost: f64,
    chi2: f64,
}

impl Belief {
    /// No contact, no frame.
    pub(super) fn none(work: &Workspace) -> Self {
        Self {
            hypothesis: Hypothesis::new(&work.model),
            trusted: Hypothesis::new(&work.model),
            gathered: Gathered::new(work.model.width),
            next_id: 0,
            live: work.buffers.filter.live.clone(),
            n_live: work.n_live,
            cost: f64::INFINITY,
            chi2: f64::INFINITY,
        }
    }

    /// The best hypothesis of `work`, and the frames gathered in `gathered`.
    pub(super) fn take(&mut self, work: &Workspace, gathered: &Gathered) {
        self.hypothesis.copy_from(work.hypotheses.best());
        self.hypothesis.set_lag(0.0);
        self.trusted.copy_from(&work.trusted);
        self.gathered.copy_from(gathered);
        self.live.copy_from_slice(&work.buffers.filter.live);
        (self.next_id, self.n_live) = (work.next_id, work.n_live);
        (self.cost, self.chi2) = (f64::INFINITY, f64::INFINITY);
    }

    pub(super) fn copy_from(&mut self, other: &Self) {
        self.hypothesis.copy_from(&other.hypothesis);
        self.trusted.copy_from(&other.trusted);
        self.gathered.copy_from(&other.gathered);
        self.live.copy_from_slice(&other.live);
        (self.next_id, self.n_live) = (other.next_id, other.n_live);
        (self.cost, self.chi2) = (other.cost, other.chi2);
    }

    pub(super) fn hypothesis(&self) -> &Hypothesis {
        &self.hypothesis
    }

    /// Whether it explains its frames.
    pub(super) fn is_explained(&self, work: &Workspace) -> bool {
        !work.is_odd(self.chi2, self.hypothesis.n) && !work.is_beyond(&self.hypothesis)
    }

    /// Takes candidate `c` of `work` if it is better and its contacts are apart.
    fn improve(&mut self, work: &Workspace, c: usize) {
        let fit = work.hypotheses.fits[c];
        if fit.cost < self.cost && are_apart(work, c) {
            self.hypothesis.copy_from(&work.hypotheses.candidates[c]);
            (self.cost, self.chi2) = (fit.cost, fit.chi2);
        }
    }
}

/// Improves `belief` until it explains its frames: first none, one and two contacts are looked for beside what was
/// trusted, then one, two or none of the contacts are taken out, the others are held, and the best places of none, one
/// and two are looked for beside them. Whether it is better than it was. Contacts that have been held only since what
/// was trusted are searched as if they had just come, since they were learnt from frames that weren't explained.
pub(super) fn exchange(work: &mut Workspace, belief: &mut Belief) -> bool {
    work.gathered.copy_from(&belief.gathered);
    work.buffers.filter.live.copy_from_slice(&belief.live);
    (work.n_live, work.next_id) = (belief.n_live, belief.next_id);
    // nothing waits for it
    work.steps_left = usize::MAX;
    work.hypotheses.begin();
    let Some(stay) = work.hypotheses.add(&belief.hypothesis) else {
        return false;
    };
    work.hypotheses.candidates[stay].doubt(&work.model, &belief.trusted);
    let first = work.settle(HypothesisRef::Candidate(stay), N_TRIALS).cost;
    belief.improve(work, stay);
    let trusted = belief.trusted.clone();
    look_beside(work, &trusted, N_TRUSTED_PAIRS, belief);
    for _ in 0..MAX_ROUNDS {
        let before = belief.cost;
        go_round(work, belief);
        if belief.cost >= before || belief.is_explained(work) {
            break;
        }
    }
    belief.cost < first
}

/// Takes out none, every one and every two of the contacts.
fn go_round(work: &mut Workspace, belief: &mut Belief) {
    let from = belief.hypothesis.clone();
    look_beside(work, &from, N_PAIRS, belief);
    for i in 0..from.n {
        let mut one_less = from.clone();
        one_less.remove(i);
        look_beside(work, &one_less, N_PAIRS, belief);
        for j in i..one_less.n {
            let mut two_less = one_less.clone();
            two_less.remove(j);
            look_beside(work, &two_less, N_PAIRS, belief);
        }
    }
}

/// The contacts of `base`, with none, one and two more.
fn look_beside(work: &mut Workspace, base: &Hypothesis, n_pairs: usize, belief: &mut Belief) {
    let newcomer_n = NEWCOMER_SHARE * work.settings.force_scale_n;
    work.hypotheses.begin();
    let Some(alone) = work.hypotheses.add(base) else {
        return;
    };
    work.settle(HypothesisRef::Candidate(alone), N_TRIALS);
    let n_free = work.most_contacts().saturating_sub(base.n);
    if n_free >= 1 {
        let nowhere = work.model.sites.points()[0];
        let newcomer = Track::new(ContactId(work.next_id), nowhere, work.frame.index);
        propose_births(work, alone, Track { force_n: newcomer_n, ..newcomer });
    }
    if let Some(winner) = work.hypotheses.winner() {
        belief.improve(work, winner);
    }
    if n_free >= 2 {
        scan_beside(work, alone, newcomer_n);
        add_pairs(work, base, n_pairs, belief);
    }
}

/// The best pairs of the last scan, which was beside `base`.
fn add_pairs(work: &mut Workspace, base: &Hypothesis, n_pairs: usize, belief: &mut Belief) {
    let job = &mut work.pair_birth.job;
    job.prepare(&work.buffers.scan);
    job.start();
    job.go_on(job.n_left());
    job.rank(&work.model, n_pairs);
    job.is_active = false;
    work.pair_birth.fits = [Fit::NONE; N_FINALISTS];
    for k in 0..work.pair_birth.job.pairs.len() {
        let sites = work.pair_birth.job.pairs[k].sites;
        work.hypotheses.begin();
        let Some(c) = work.hypotheses.add(base) else {
            break;
        };
        for (id, site) in (work.next_id..).zip(sites) {
            let point = work.model.sites.points()[site];
            let track = Track::new(ContactId(id), point, work.frame.index);
            work.hypotheses.candidates[c].push(&work.model, track);
        }
        let fit = work.settle(HypothesisRef::Candidate(c), N_PROBE);
        work.pair_birth.trial.copy_from(&work.hypotheses.candidates[c]);
        work.pair_birth.rank(fit);
    }
    for k in 0..N_FINALISTS {
        if !work.pair_birth.fits[k].cost.is_finite() {
            break;
        }
        work.hypotheses.begin();
        let Some(c) = work.hypotheses.add(&work.pair_birth.finalists[k]) else {
            break;
        };
        work.settle(HypothesisRef::Candidate(c), N_TRIALS);
        belief.improve(work, c);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use hapdef_contact::Phase;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::estimator::{ContactEstimator, EstimatorParams};
    use crate::noise::NoiseParams;
    use crate::response::waves;
    use crate::sites::ScanSites;
    use crate::skin::plate;
    use crate::skin_point::SkinPoint;
    use crate::tracker::params::TrackerParams;

    const N_GAUGES: usize = 10;
    const FORCE_N: f64 = 15.0;

    /// Gauges on a plate that see waves of their own.
    fn workspace(rng: &mut ChaCha8Rng) -> Workspace {
        let map = Arc::new(waves(plate(20, 5e-3), N_GAUGES, 60.0, rng));
        let sites = Arc::new(ScanSites::farthest(map.skin(), 400).unwrap());
        let noise = NoiseParams::uniform(N_GAUGES, 0.02);
        let estimator = ContactEstimator::new(map, sites, noise, EstimatorParams::default());
        Workspace::new(&estimator.unwrap(), TrackerParams::default()).unwrap()
    }

    /// Sites that are 20 mm and more apart.
    fn draw(work: &Workspace, n: usize, rng: &mut ChaCha8Rng) -> Vec<SkinPoint> {
        let mut points: Vec<SkinPoint> = Vec::new();
        let place = |p: &SkinPoint| work.model.skin().position(p);
        while points.len() < n {
            let point = work.model.sites.points()[rng.random_range(0..work.model.n_sites())];
            if points.iter().all(|other| (place(other) - place(&point)).norm() > 0.02) {
                points.push(point);
            }
        }
        points
    }

    fn held(work: &Workspace, points: &[SkinPoint]) -> Hypothesis {
        let mut hypothesis = Hypothesis::new(&work.model);
        for (id, point) in (0..).zip(points) {
            let track = Track { force_n: FORCE_N, ..Track::new(ContactId(id), *point, 0) };
            hypothesis.push(&work.model, Track { phase: Phase::Held, ..track });
        }
        hypothesis
    }

    /// Of four contacts two are elsewhere than believed: ten gauges that locate three at once find the two.
    #[test]
    fn two_of_four_that_are_elsewhere_are_found() {
        assert_found(&[0, 1, 2, 3], &[0, 1, 2, 3]);
    }

    /// Two contacts were held while two more came, and were dragged elsewhere: they are where they were.
    #[test]
    fn contacts_that_were_dragged_away_are_found_where_they_were() {
        assert_found(&[2, 3], &[0, 1]);
    }

    /// Of six places contacts press at 0, 1, 4 and 5, are believed to be `held`, and were `trusted` to be.
    fn assert_found(held_at: &[usize], trusted_at: &[usize]) {
        let n_scenes = 10;
        let mut n_right = 0;
        for seed in 0..n_scenes {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let mut work = workspace(&mut rng);
            let points = draw(&work, 6, &mut rng);
            let truth = held(&work, &[points[0], points[1], points[4], points[5]]);
            let mut z = vec![0.0; work.model.width];
            for atom in truth.atoms.chunks_exact(truth.width).take(truth.n) {
                z.iter_mut().zip(atom).for_each(|(z, a)| *z += FORCE_N * a);
            }
            z[..N_GAUGES].iter_mut().for_each(|z| *z += rng.random_range(-1.0..1.0));
            let mut belief = Belief::none(&work);
            let those = |at: &[usize]| at.iter().map(|&i| points[i]).collect::<Vec<_>>();
            belief.hypothesis.copy_from(&held(&work, &those(held_at)));
            belief.trusted.copy_from(&held(&work, &those(trusted_at)));
            belief.gathered.add(&z, 1.0);
            belief.next_id = 4;
            let is_better = exchange(&mut work, &mut belief);
            let found = belief.hypothesis.tracks();
            let skin = work.model.skin();
            let is_found = |t: &Track| {
                let x = skin.position(&t.point);
                found.iter().any(|f| (skin.position(&f.point) - x).norm() < 2e-3)
            };
            let is_right = belief.is_explained(&work) && truth.tracks().iter().all(is_found);
            n_right += u64::from(is_better && is_right);
        }
        assert!(n_right + 1 >= n_scenes, "{n_right} of {n_scenes} scenes");
    }
}
