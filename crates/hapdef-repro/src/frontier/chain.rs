//! Errors and times of the paper's chain, its nets in every precision.

use std::time::Instant;

use anyhow::{Context, Result};
use hapdef::stages::NetKind;
use hapdef::touch::{ChainStages, chain_stages};
use hapdef::{Hapdefx, HapdefxScratch, MapErrorSum, ScoredContact, scored};
use hapdef_nets::infer::{InferParams, Precision, PreparedNet};

use super::lab::{Design, Lab, Ready};
use super::point::{Family, Point};
use super::times::Rounds;
use crate::bench::{Method, Passes};
use crate::compare::score::{Errors, Score};
use crate::compare::world::Frame;

/// The chain in every precision, beside the usual configuration. Its amounts are the profile's, which stands in
/// every name.
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
    let mut passed = Passed::prepare(lab, stages, chain, precision)?;
    let prepare_s = start.elapsed().as_secs_f64();
    let mut rounds = Rounds::default();
    for frames in lab.frames.rounds() {
        rounds.beside(usual, frames)?;
        rounds.add(passed.score(lab, frames)?.2);
    }
    let mut errors = |frames: &[Frame]| -> Result<Errors> {
        let (score, map_um, _) = passed.score(lab, frames)?;
        Ok(Errors { map_um: Some(map_um), ..score.row("").errors })
    };
    Ok(Point {
        name: format!("the paper's chain, {}, {} nets", precision.name(), lab.run.profile.name),
        configuration: None,
        family: Family::Chain,
        single: errors(&lab.frames.singles)?,
        double: errors(lab.frames.doubles())?,
        design: design(stages, prepare_s)?,
        frame: rounds.times(),
    })
}

/// Times of the stages from the runs that made them.
fn design(stages: &ChainStages, prepare_s: f64) -> Result<Design> {
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
    nets: Passes,
    peaks: HapdefxScratch,
    map_um: Vec<f32>,
}

impl<'a> Passed<'a> {
    fn prepare(
        lab: &Lab<'_>,
        stages: &ChainStages,
        chain: &'a Hapdefx,
        precision: Precision,
    ) -> Result<Self> {
        let n_sets = stages.data.simulated.len();
        let net = |kind| -> Result<PreparedNet> {
            let net = stages.nets.load(kind)?;
            Ok(PreparedNet::new(&net, &InferParams::of(precision))?)
        };
        let to_map = Method::Net(net(NetKind::Reconstruction { n_sets })?);
        Ok(Self {
            chain,
            nets: Passes::new(Some(net(NetKind::Transfer)?), to_map),
            peaks: HapdefxScratch::default(),
            map_um: vec![0.0; lab.maps_of.n_surface()],
        })
    }

    /// Finds as many contacts as there are in every frame; mean error of the map, µm, and times, µs.
    fn score(&mut self, lab: &Lab<'_>, frames: &[Frame]) -> Result<(Score, f64, Vec<f64>)> {
        let n_gauges = lab.limb.gauges.len();
        let mut score = Score::default();
        let mut map_error = MapErrorSum::new(lab.maps_of.n_surface());
        let mut times_us = Vec::with_capacity(frames.len());
        for frame in frames {
            let readings = &frame.readings_ue[..n_gauges];
            let start = Instant::now();
            let found = self.contacts(readings, frame.contacts.len())?;
            let time_us = start.elapsed().as_secs_f64() * 1e6;
            times_us.push(time_us);
            score.add(lab.maps_of.skin(), frame, &found, time_us)?;
            map_error.add(&lab.maps_of.of_frame(frame)[0], &self.map_um);
        }
        Ok((score, map_error.finish().mean_abs_um, times_us))
    }

    fn contacts(&mut self, readings_ue: &[f64], n_contacts: usize) -> Result<Vec<ScoredContact>> {
        let readings: Vec<f32> = readings_ue.iter().map(|r| *r as f32).collect();
        self.nets.map(&readings, &mut self.map_um)?;
        let found = self.chain.candidates(&self.map_um, &mut self.peaks)?;
        let taken = self.chain.top(&found, n_contacts);
        Ok(scored(&taken))
    }
}
