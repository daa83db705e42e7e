//! Errors and times of one way.

use std::time::Instant;

use anyhow::{Context, Result};
use hapdef::stages::NetKind;
use hapdef::touch::{ChainStages, chain_stages};
use hapdef::{Hapdefx, HapdefxScratch, ScoredContact};
use hapdef_inverse::{ContactEstimate, ContactEstimator};
use hapdef_nets::infer::{InferParams, InferScratch, Precision, PreparedNet};

use super::lab::{Design, Lab, Ready};
use super::map_error::MeanError;
use super::point::{Errors, Family, FrameTimes, Point};
use super::way::{Knows, Way};
use crate::compare::cells;
use crate::compare::score::Score;
use crate::compare::sequence::Followed;
use crate::compare::world::Frame;

/// Rounds in which times are measured, and frames of each.
const ROUNDS: usize = 3;
const N_TIMED: usize = 40;

/// Measures a way by superposition beside the usual one.
pub(super) fn superposed(lab: &mut Lab<'_>, way: &Way) -> Result<Point> {
    let usual = lab.ready(&Way::USUAL)?;
    let ready = lab.ready(way)?;
    match way.knows {
        Knows::Nothing => searched(lab, way, &ready, &usual),
        Knows::Before => followed(lab, way, &ready, &usual),
    }
}

fn searched(lab: &Lab<'_>, way: &Way, ready: &Ready, usual: &Ready) -> Result<Point> {
    let errors = |frames: &[Frame]| -> Result<Errors> {
        let mut map_error = MeanError::default();
        let score = cells::score(
            &ready.estimator,
            ready.channels.clone(),
            frames,
            |frame, estimate| {
                let found_um = lab.maps_of.found_um(&estimate.contacts);
                map_error.add(&found_um, &lab.maps_of.truth_um(frame));
                Ok(())
            },
        )?;
        Ok(Errors::of(&score.row(""), Some(map_error.mean_um())))
    };
    let frames = &lab.doubles[..N_TIMED.min(lab.doubles.len())];
    let mut rounds = Vec::new();
    let mut beside = Vec::new();
    for _ in 0..ROUNDS {
        beside.push(search_times_us(usual, frames)?);
        rounds.push(search_times_us(ready, frames)?);
    }
    Ok(Point {
        name: way.name(),
        way: Some(*way),
        family: Family::Searched,
        single: errors(&lab.singles)?,
        double: errors(&lab.doubles)?,
        design: ready.design,
        frame: FrameTimes::of(&rounds, &beside),
    })
}

fn search_times_us(ready: &Ready, frames: &[Frame]) -> Result<Vec<f64>> {
    let mut scratch = ready.estimator.scratch();
    let mut estimate = ContactEstimate::default();
    let mut times = Vec::with_capacity(frames.len());
    for frame in frames {
        let readings = &frame.readings_ue[ready.channels.clone()];
        let start = Instant::now();
        ready
            .estimator
            .estimate_into(readings, &mut scratch, &mut estimate)?;
        times.push(start.elapsed().as_secs_f64() * 1e6);
    }
    Ok(times)
}

/// Two contacts that come one after the other. Single ones are the same scripts' first.
fn followed(lab: &Lab<'_>, way: &Way, ready: &Ready, usual: &Ready) -> Result<Point> {
    let (mut rounds, mut beside) = (Vec::new(), Vec::new());
    let mut scores = [Score::default(), Score::default()];
    let frames = &lab.doubles[..N_TIMED.min(lab.doubles.len())];
    for round in 0..ROUNDS {
        beside.push(search_times_us(usual, frames)?);
        let mut times_us = Vec::new();
        for (n_contacts, score) in [1, 2].into_iter().zip(&mut scores) {
            let followed = follow(lab, &ready.estimator, &ready.channels, n_contacts)?;
            times_us.extend(&followed.times_us);
            if round == 0 {
                *score = followed.score;
            }
        }
        rounds.push(times_us);
    }
    let [single, double] = scores.map(|score| Errors::of(&score.row(""), None));
    Ok(Point {
        name: way.name(),
        way: Some(*way),
        family: Family::Followed,
        single,
        double,
        design: ready.design,
        frame: FrameTimes::of(&rounds, &beside),
    })
}

fn follow(
    lab: &Lab<'_>,
    estimator: &ContactEstimator,
    channels: &std::ops::Range<usize>,
    n_contacts: usize,
) -> Result<Followed> {
    let mut scratch = estimator.scratch();
    let mut followed = Followed::default();
    for (script, readings) in &lab.scripts {
        let (script, n_frames) = script.first(n_contacts);
        let own = readings[..n_frames].iter();
        let own: Vec<Vec<f64>> = own.map(|frame| frame[channels.clone()].to_vec()).collect();
        followed.follow(estimator, &mut scratch, &script, &own)?;
    }
    Ok(followed)
}

/// The paper's chain with its nets in every precision, beside the usual way.
pub(super) fn chain(lab: &mut Lab<'_>, usual: &Ready) -> Result<Vec<Point>> {
    let stages = chain_stages(lab.run, lab.limb)?;
    let made = hapdef::stages::trained_chain(lab.run, lab.limb, &stages.data, &stages.nets)?;
    let of = |precision| prepared(lab, &stages, &made, usual, precision);
    Precision::ALL.into_iter().map(of).collect()
}

fn prepared(
    lab: &Lab<'_>,
    stages: &ChainStages,
    chain: &Hapdefx,
    usual: &Ready,
    precision: Precision,
) -> Result<Point> {
    let start = Instant::now();
    let n_sets = stages.data.simulated.len();
    let net = |kind| -> Result<PreparedNet> {
        let net = stages.nets.load(kind)?;
        Ok(PreparedNet::new(&net, &InferParams::of(precision))?)
    };
    let mut passed = Passed {
        chain,
        nets: [
            net(NetKind::Transfer)?,
            net(NetKind::Reconstruction { n_sets })?,
        ],
        scratch: InferScratch::default(),
        peaks: HapdefxScratch::default(),
        virtual_um: Vec::new(),
        map_um: vec![0.0; lab.maps_of.n_surface()],
    };
    let prepare_s = start.elapsed().as_secs_f64();
    let frames = &lab.doubles[..N_TIMED.min(lab.doubles.len())];
    let (mut rounds, mut beside) = (Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        beside.push(search_times_us(usual, frames)?);
        rounds.push(passed.score(lab, frames)?.2);
    }
    let mut errors = |frames: &[Frame]| -> Result<Errors> {
        let (score, map_error, _) = passed.score(lab, frames)?;
        Ok(Errors::of(&score.row(""), Some(map_error.mean_um())))
    };
    Ok(Point {
        name: format!("the paper's chain, {}", precision.name()),
        way: None,
        family: Family::Chain,
        single: errors(&lab.singles)?,
        double: errors(&lab.doubles)?,
        design: chain_design(stages, prepare_s)?,
        frame: FrameTimes::of(&rounds, &beside),
    })
}

/// Times of the stages from the runs that made them.
fn chain_design(stages: &ChainStages, prepare_s: f64) -> Result<Design> {
    let nets = &stages.nets.nets;
    let data = &stages.data;
    let sets = data.simulated.iter().chain([&data.rig_single]);
    let sets = sets.chain(&data.rig_double).map(|s| s.record.elapsed_s);
    let trained = nets.iter().map(|net| net.stage.record.elapsed_s);
    nets.first().context("no nets")?;
    Ok(Design {
        solve_s: stages.compliance.record.elapsed_s + stages.rig.record.elapsed_s,
        learn_s: sets.sum::<f64>() + trained.sum::<f64>(),
        prepare_s,
    })
}

/// The chain with F_T and F_R prepared for run time.
struct Passed<'a> {
    chain: &'a Hapdefx,
    nets: [PreparedNet; 2],
    scratch: InferScratch,
    peaks: HapdefxScratch,
    virtual_um: Vec<f32>,
    map_um: Vec<f32>,
}

impl Passed<'_> {
    /// Finds as many contacts as there are in every frame; times, µs.
    fn score(&mut self, lab: &Lab<'_>, frames: &[Frame]) -> Result<(Score, MeanError, Vec<f64>)> {
        let n_gauges = lab.limb.gauges.len();
        let (mut score, mut map_error) = (Score::default(), MeanError::default());
        let mut times = Vec::with_capacity(frames.len());
        for frame in frames {
            let readings = &frame.readings_ue[..n_gauges];
            let start = Instant::now();
            let found = self.contacts(readings, frame.contacts.len())?;
            let time_us = start.elapsed().as_secs_f64() * 1e6;
            times.push(time_us);
            score.add(lab.maps_of.skin(), frame, &found, time_us)?;
            map_error.add(&self.map_um, &lab.maps_of.truth_um(frame));
        }
        Ok((score, map_error, times))
    }

    fn contacts(&mut self, readings_ue: &[f64], n_contacts: usize) -> Result<Vec<ScoredContact>> {
        let readings: Vec<f32> = readings_ue.iter().map(|r| *r as f32).collect();
        let [transfer, reconstruction] = &self.nets;
        self.virtual_um.resize(transfer.n_outputs(), 0.0);
        transfer.forward(&readings, &mut self.scratch, &mut self.virtual_um)?;
        reconstruction.forward(&self.virtual_um, &mut self.scratch, &mut self.map_um)?;
        let found = self.chain.candidates(&self.map_um, &mut self.peaks)?;
        let taken = self.chain.top(&found, n_contacts);
        Ok(taken.iter().map(|c| (c.position_m, c.force_n)).collect())
    }
}
