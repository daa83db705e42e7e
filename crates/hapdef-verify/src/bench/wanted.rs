//! What solving for wanted rows alone saves.

use std::io::Stdout;

use hapdef_bench::stats::median;
use hapdef_mesh::FeNodeId;
use hapdef_report::MetricLog;
use hapdef_sim::{ComplianceParams, ElasticModel, GaugeStrain, NodalLoad, Residuals, SolveInfo};

use super::clock::timed;
use crate::VerifyError;

/// Rounds; each takes every variant once.
const N_ROUNDS: usize = 3;

/// Loads of a round.
const N_LOADS: usize = 800;

/// Loads whose residual is taken.
const N_SAMPLED: usize = 64;

/// Times compliance with sampled residuals against all residuals, in one run, round after round:
/// for all nodes of the mesh, for those of `surface`, and for those that `gauges` read. Ratios are
/// medians of processor seconds.
pub(super) fn measure(
    model: &ElasticModel,
    loads: &[NodalLoad],
    surface: &[FeNodeId],
    gauges: &[GaugeStrain],
    log: &mut MetricLog<Stdout>,
) -> Result<(), VerifyError> {
    let n = N_LOADS.min(loads.len());
    let loads: Vec<NodalLoad> = (0..n).map(|i| loads[i * loads.len() / n].clone()).collect();
    let all: Vec<FeNodeId> = (0..model.info().n_fe_nodes).map(FeNodeId::from_index).collect();
    let mut read: Vec<FeNodeId> =
        gauges.iter().flat_map(|gauge| gauge.as_load().forces_n).map(|(node, _)| node).collect();
    read.sort_unstable();
    read.dedup();
    let wanted = [("all", &all[..]), ("wanted", surface), ("gauge", &read)];
    let mut ratios = [const { Vec::new() }; 3];
    let mut shares = [0.0; 3];
    for _ in 0..N_ROUNDS {
        let mut every = Vec::new();
        for (_, rows) in wanted {
            every.push(run(model, &loads, rows, Residuals::Every)?.1);
        }
        for (i, (_, rows)) in wanted.into_iter().enumerate() {
            let sampled = Residuals::Sampled { n_loads: N_SAMPLED };
            let (info, took) = run(model, &loads, rows, sampled)?;
            ratios[i].push(took / every[i]);
            shares[i] = partial_share(&info);
        }
    }
    for ((name, _), (ratios, share)) in wanted.into_iter().zip(ratios.into_iter().zip(shares)) {
        log.value(&format!("fe.{name}_rows_factor_share"), share, "1")?;
        log.value(&format!("fe.{name}_rows_time_ratio"), median(ratios), "1")?;
    }
    Ok(())
}

fn run(
    model: &ElasticModel,
    loads: &[NodalLoad],
    wanted: &[FeNodeId],
    residuals: Residuals,
) -> Result<(SolveInfo, f64), VerifyError> {
    let params = ComplianceParams { residuals, ..ComplianceParams::default() };
    let (solved, took) = timed(|| model.compliance(loads, wanted, &params));
    Ok((solved?.1, took.processor_s))
}

/// The share of L that backward substitution reads for loads that are solved in part; 1 if none is.
fn partial_share(info: &SolveInfo) -> f64 {
    let full = info.n_residuals as f64 / info.n_loads.max(1) as f64;
    if full < 1.0 { (info.backward_factor_share - full) / (1.0 - full) } else { 1.0 }
}
