//! What is said of a frame.

use hapdef_contact::{Verdict, WhyNot};

use crate::chi_square::upper_tail;
use crate::estimator::{LocatedContact, spare_numbers};
use crate::tracker::frame::TrackedContact;
use crate::tracker::hypothesis::Track;
use crate::tracker::workspace::Workspace;

/// A place is open if its standard deviation exceeds this share of the skin's: the frames so far then
/// leave more than half of what was unknown.
const OPEN_SHARE: f64 = 0.5;

/// Unknowns of a place. Three live gauges and one followed contact leave nothing to check it by: it was
/// sure 75 mm off without this count.
const PLACE_UNKNOWNS: usize = 2;

/// A force is steady within so many standard deviations: noise alone starts the average anew in 0.3 % of
/// the frames.
const STEADY_SDS: f64 = 3.0;

pub(super) fn report(work: &mut Workspace, readings: &[f64], is_detecting: bool) {
    average(work);
    let best = work.hypotheses.best();
    let (frame, model) = (&mut work.frame, &work.model);
    let skin = model.skin();
    frame.contacts.clear();
    for track in best.tracks() {
        let mut covariance = track.covariance;
        model.scale_places(covariance.as_mut_slice(), 3);
        let contact = LocatedContact::new(skin, track.point, track.steady.0, covariance);
        frame.contacts.push(TrackedContact {
            id: track.id,
            phase: track.phase,
            age_frames: frame.index.saturating_sub(track.born),
            contact,
        });
    }
    frame.contacts.sort_unstable_by_key(|contact| contact.id);
    for (g, &gauge) in model.live.iter().enumerate() {
        let explained: f64 =
            (0..best.n).map(|i| best.tracks[i].force_n * best.atoms[i * best.width + g]).sum();
        let is_read = work.buffers.filter.live[g];
        let left = readings[gauge] - explained * model.l[g * model.m + g];
        frame.residual[gauge] = if is_read { left } else { 0.0 };
    }
    frame.p_value = upper_tail(frame.chi2, frame.n_dof);
    frame.n_runner_ups = work.hypotheses.n_alive() - 1;
    frame.info.is_detecting = is_detecting;
    work.frame.verdict = verdict(work);
}

/// Averages forces while all of them are steady.
fn average(work: &mut Workspace) {
    let most = work.params.force_frames;
    let best = work.hypotheses.best_mut();
    let tracks = &mut best.tracks[..best.n];
    let is_steady = tracks.iter().all(|track| {
        let (mean, n) = track.steady;
        let sd = track.force_noise_n * (1.0 + 1.0 / n.max(1) as f64).sqrt();
        n > 0 && (track.force_n - mean).abs() <= STEADY_SDS * sd
    });
    for track in tracks {
        let (mean, n) = if is_steady { track.steady } else { (0.0, 0) };
        let n = (n + 1).min(most);
        track.steady = (mean + (track.force_n - mean) / n as f64, n);
    }
}

fn verdict(work: &Workspace) -> Verdict {
    let contacts = &work.frame.contacts;
    let skin_sd_m = work.skin_sd_m();
    let open = |track: &Track| {
        let p = &track.covariance;
        let (a, b, d) = (p[(0, 0)], p[(0, 1)], p[(1, 1)]);
        let largest = 0.5 * (a + d) + (0.25 * (a - d).powi(2) + b * b).sqrt();
        largest.sqrt() > OPEN_SHARE * skin_sd_m
    };
    if work.frame.p_value < work.params.misfit_p {
        Verdict::NotIdentifiable(WhyNot::Misfit)
    } else if contacts.is_empty() {
        Verdict::Untouched
    } else if work.hypotheses.best().tracks().iter().any(open) {
        Verdict::NotIdentifiable(WhyNot::SingularInformation)
    } else if !is_checked(work) {
        Verdict::NotIdentifiable(WhyNot::Unchecked)
    } else if work.hypotheses.lead() <= work.settings.tie_delta || are_two_in_one_place(work) {
        Verdict::NotIdentifiable(WhyNot::TiedExplanations)
    } else {
        Verdict::Identified
    }
}

/// Whether two contacts are where the readings fit one as well as two: one that grows by kilonewtons a frame
/// is, before its place is exact, explained best by two beside it.
fn are_two_in_one_place(work: &Workspace) -> bool {
    let place = |c: &TrackedContact| c.contact.position_m;
    let (contacts, apart_m) = (&work.frame.contacts, work.settings.distinct_m);
    contacts.iter().enumerate().any(|(i, one)| {
        let others = &contacts[..i];
        let is_there = |c: &TrackedContact| (place(c) - place(one)).norm() < apart_m;
        others.iter().any(is_there)
    })
}

/// Whether live gauges measure enough to check the newest contact by, the places of the others known.
fn is_checked(work: &Workspace) -> bool {
    let n = work.frame.contacts.len();
    let is_last = n >= work.params.max_contacts;
    work.n_free() >= n + PLACE_UNKNOWNS + spare_numbers(is_last)
}
