//! Errors and times of configurations by superposition.

use anyhow::Result;
use hapdef::MapErrorSum;
use hapdef_inverse::{ContactEstimate, Searcher, TrackerParams};

use super::configuration::{Configuration, Knows};
use super::frames::Scripted;
use super::lab::{Lab, Ready, found_um};
use super::point::{Family, Point};
use super::times::{Rounds, search_times_us};
use crate::compare::cells;
use crate::compare::score::Errors;
use crate::compare::sequence::{Followed, Script};
use crate::compare::world::Frame;

/// Measures a configuration by superposition beside the usual one.
pub(super) fn superposed(lab: &mut Lab<'_>, configuration: &Configuration) -> Result<Point> {
    let usual = lab.ready(&Configuration::USUAL)?;
    let ready = lab.ready(configuration)?;
    let (family, [single, double], rounds) = match configuration.knows {
        Knows::Nothing => {
            let errors = [
                searched(lab, &ready, &lab.frames.singles)?,
                searched(lab, &ready, lab.frames.doubles())?,
            ];
            (Family::Searched, errors, search_rounds(lab, &ready, &usual)?)
        }
        Knows::Before => {
            let (errors, rounds) = followed(lab, &ready, &usual)?;
            (Family::Followed, errors, rounds)
        }
    };
    Ok(Point {
        name: configuration.name(),
        configuration: Some(*configuration),
        family,
        single,
        double,
        design: ready.design,
        frame: rounds.times(),
    })
}

/// Errors of frames of which nothing is known before.
fn searched(lab: &Lab<'_>, ready: &Ready, frames: &[Frame]) -> Result<Errors> {
    let mut map_error = MapErrorSum::new(lab.maps_of.n_surface());
    let also = |_: &_, _: &[f64], frame: &Frame, estimate: &ContactEstimate| {
        let found_um = found_um(&lab.maps_of, &estimate.contacts);
        map_error.add(&lab.maps_of.of_frame(frame)[0], &found_um);
        Ok(())
    };
    let score = cells::score(&ready.estimator, ready.channels.clone(), frames, also)?;
    Ok(Errors { map_um: Some(map_error.finish().mean_abs_um), ..score.row("").errors })
}

fn search_rounds(lab: &Lab<'_>, ready: &Ready, usual: &Ready) -> Result<Rounds> {
    let mut rounds = Rounds::default();
    for frames in lab.frames.rounds() {
        rounds.beside(usual, frames)?;
        rounds.add(search_times_us(ready, frames)?);
    }
    Ok(rounds)
}

/// Errors and times of the contacts of the searched frames, those of a frame one after the other.
fn followed(lab: &Lab<'_>, ready: &Ready, usual: &Ready) -> Result<([Errors; 2], Rounds)> {
    let mut rounds = Rounds::default();
    let (mut singles, mut doubles) = (Followed::default(), Followed::default());
    for script in &lab.frames.single_scripts {
        follow(ready, script, &mut singles)?;
    }
    for (scripts, frames) in lab.frames.script_rounds().zip(lab.frames.rounds()) {
        rounds.beside(usual, frames)?;
        let mut of_two = Vec::new();
        for script in scripts {
            let before = doubles.times_us.len();
            follow(ready, script, &mut doubles)?;
            let of_script = &doubles.times_us[before..];
            of_two.extend_from_slice(&of_script[Script::first_frame_of(2)..]);
        }
        rounds.add(of_two);
    }
    for followed in [&singles, &doubles] {
        rounds.slowest(&followed.times_us);
    }
    Ok(([singles, doubles].map(|followed| followed.score.row("").errors), rounds))
}

fn follow(ready: &Ready, scripted: &Scripted, followed: &mut Followed) -> Result<()> {
    let estimator = &ready.estimator;
    let mut searcher = Searcher::for_tracker(estimator.clone(), TrackerParams::default())?;
    let channels = |frame: &Vec<f64>| frame[ready.channels.clone()].to_vec();
    let own: Vec<Vec<f64>> = scripted.readings_ue.iter().map(channels).collect();
    followed.follow(estimator, &mut searcher, &scripted.script, &own)
}
