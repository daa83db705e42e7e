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
    match configuration.knows {
        Knows::Nothing => searched(lab, configuration, &ready, &usual),
        Knows::Before => followed(lab, configuration, &ready, &usual),
    }
}

fn searched(
    lab: &Lab<'_>,
    configuration: &Configuration,
    ready: &Ready,
    usual: &Ready,
) -> Result<Point> {
    let errors = |frames: &[Frame]| -> Result<Errors> {
        let mut map_error = MapErrorSum::new(lab.maps_of.n_surface());
        let also = |_: &_, _: &[f64], frame: &Frame, estimate: &ContactEstimate| {
            let found_um = found_um(&lab.maps_of, &estimate.contacts);
            map_error.add(&lab.maps_of.of_frame(frame)[0], &found_um);
            Ok(())
        };
        let score = cells::score(&ready.estimator, ready.channels.clone(), frames, also)?;
        Ok(Errors { map_um: Some(map_error.finish().mean_abs_um), ..score.row("").errors })
    };
    let mut rounds = Rounds::default();
    for frames in lab.frames.rounds() {
        rounds.beside(usual, frames)?;
        rounds.add(search_times_us(ready, frames)?);
    }
    Ok(Point {
        name: configuration.name(),
        configuration: Some(*configuration),
        family: Family::Searched,
        single: errors(&lab.frames.singles)?,
        double: errors(lab.frames.doubles())?,
        design: ready.design,
        frame: rounds.times(),
    })
}

/// The contacts of the searched frames, those of a frame one after the other.
fn followed(
    lab: &Lab<'_>,
    configuration: &Configuration,
    ready: &Ready,
    usual: &Ready,
) -> Result<Point> {
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
    rounds.slowest(&singles.times_us);
    rounds.slowest(&doubles.times_us);
    Ok(Point {
        name: configuration.name(),
        configuration: Some(*configuration),
        family: Family::Followed,
        single: singles.score.row("").errors,
        double: doubles.score.row("").errors,
        design: ready.design,
        frame: rounds.times(),
    })
}

fn follow(ready: &Ready, scripted: &Scripted, followed: &mut Followed) -> Result<()> {
    let estimator = &ready.estimator;
    let mut searcher = Searcher::for_tracker(estimator.clone(), TrackerParams::default())?;
    let channels = |frame: &Vec<f64>| frame[ready.channels.clone()].to_vec();
    let own: Vec<Vec<f64>> = scripted.readings_ue.iter().map(channels).collect();
    followed.follow(estimator, &mut searcher, &scripted.script, &own)
}
