//! How fast this machine is at what the stages do, measured once with their own code.

use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

use hapdef_data::{DatasetReader, DatasetWriter, TensorSpec};
use hapdef_kmax::{KMaxGraph, KMaxParams};
use hapdef_mesh::{FeNodeId, kuhn_block};
use hapdef_nets::train::{MemorySource, train};
use hapdef_nets::{Mlp, MlpSpec, Net, Scale, Scratch, TrainParams};
use hapdef_sim::{ComplianceParams, ElasticModel, ElasticParams, IsotropicMaterial, NodalLoad};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::FrameRates;
use super::cost::CONDITION_LOADS;
use crate::cache::write_json;
use crate::compliance::ComplianceTable;
use crate::error::HapdefError;
use crate::sampling::DrawnContact;
use crate::scene::HapdefxSpec;

/// Rates of the stages' inner loops. A machine that is busy with something else measures less.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Machine {
    /// Threads that it was measured with.
    pub threads: usize,
    /// Element matrices computed and assembled, 1/s.
    pub elements_per_s: f64,
    /// Operations of the factorisation, 1/s.
    pub factor_flops_per_s: f64,
    /// Operations of solves with many right-hand sides, refinement included, 1/s.
    pub solve_flops_per_s: f64,
    /// Operations of solves with a few right-hand sides, the condition number's among them, 1/s.
    pub few_solves_flops_per_s: f64,
    /// Operations of the training of a net of F_R's widths in 32 bits, 1/s.
    pub train_flops_per_s: f64,
    /// The same of a net of F_T's widths, whose units are hyperbolic tangents.
    pub train_narrow_tanh_flops_per_s: f64,
    /// The same of one of F_S's widths, whose units are rectified.
    pub train_narrow_relu_flops_per_s: f64,
    /// Operations of superposition, 1/s.
    pub superpose_flops_per_s: f64,
    /// Operations of a pass of a net of F_R's widths, one sample, 1/s.
    pub pass_flops_per_s: f64,
    /// Nodes among which k-Max looks for peaks, 1/s.
    pub kmax_nodes_per_s: f64,
    /// Bytes written to the results' folder, 1/s.
    pub write_bytes_per_s: f64,
    /// Bytes read from there, 1/s.
    pub read_bytes_per_s: f64,
    /// What a frame and a calibration do.
    pub frame: FrameRates,
}

/// Cubes along each side of the block that is solved.
const N_CUBES: usize = 10;

/// Their width, m.
const CUBE_M: f64 = 2e-3;

/// Right-hand sides that are few.
const N_FEW: usize = 10;

/// Steps of a training that are not timed.
const WARM_UP: u64 = 3;

/// Passes and searches for peaks that are timed.
const PASSES: usize = 20;

/// Gap of the nodes among which peaks are looked for, m.
const NODE_GAP_M: f64 = 2.5e-3;

/// Times that a file is written and read.
const FILE_ROUNDS: usize = 3;

/// The tensor of the file that is written and read.
const VALUES: &str = "values";

/// Nodes at which samples are superposed, and samples.
const SUPERPOSED: [usize; 2] = [3500, 2000];

impl Machine {
    /// Right-hand sides from which on solves count as many.
    pub const MANY_LOADS: usize = 64;

    /// What an earlier measurement left in `path`, or a new one, a few seconds, written there. One
    /// with another number of threads, or that can't be read, is made again.
    ///
    /// # Errors
    /// [`HapdefError::File`] when the folder can't be written.
    pub fn read_or_measure(path: &Path, threads: usize) -> Result<Self, HapdefError> {
        let kept = std::fs::read(path).ok();
        let kept: Option<Self> = kept.and_then(|text| serde_json::from_slice(&text).ok());
        if let Some(machine) = kept.filter(|machine| machine.threads == threads) {
            return Ok(machine);
        }
        let folder = path.parent().unwrap_or(Path::new("."));
        std::fs::create_dir_all(folder).map_err(HapdefError::file(folder))?;
        let machine = Self::measure(folder, threads)?;
        write_json(path, &machine)?;
        Ok(machine)
    }

    /// Measures; a file of 64 MB comes and goes in `folder`.
    ///
    /// # Errors
    /// [`HapdefError::File`] and [`HapdefError::Data`] when the folder can't be written.
    pub fn measure(folder: &Path, threads: usize) -> Result<Self, HapdefError> {
        let [elements_per_s, factor_flops_per_s, solve_flops_per_s, few_solves_flops_per_s] =
            solver_rates(threads)?;
        let [write_bytes_per_s, read_bytes_per_s] =
            file_rates(&folder.join("machine.safetensors"))?;
        let wide = MlpSpec::reconstruction(240, 3200);
        let narrow_rate = |spec| training_rate(spec, 400, 100);
        Ok(Self {
            threads,
            elements_per_s,
            factor_flops_per_s,
            solve_flops_per_s,
            few_solves_flops_per_s,
            train_flops_per_s: training_rate(&wide, 10, 100)?,
            train_narrow_tanh_flops_per_s: narrow_rate(&MlpSpec::transfer(10, 240))?,
            train_narrow_relu_flops_per_s: narrow_rate(&MlpSpec::sensitivity())?,
            superpose_flops_per_s: superposition_rate(threads),
            pass_flops_per_s: pass_rate(&wide)?,
            kmax_nodes_per_s: kmax_rate()?,
            write_bytes_per_s,
            read_bytes_per_s,
            frame: FrameRates::measure(threads)?,
        })
    }
}

/// Rates of assembly, factorisation, many solves and few.
fn solver_rates(threads: usize) -> Result<[f64; 4], HapdefError> {
    let mesh = kuhn_block([N_CUBES; 3], |p| p * (N_CUBES as f64 * CUBE_M))?;
    let clamped = |i: &usize| mesh.nodes()[*i].z < 1e-9;
    let clamped = (0..mesh.nodes().len()).filter(clamped);
    let material = IsotropicMaterial::new(2e9, 0.35, 1000.0)?;
    let params = ElasticParams {
        n_threads: threads,
        ..ElasticParams::new(material, clamped.map(FeNodeId::from_index).collect())
    };
    let estimate = ElasticModel::estimate(&mesh, &params)?;
    let model = ElasticModel::build(&mesh, &params)?;
    let info = model.info();
    let top = mesh.nodes().len() - 1;
    let load = |i: usize| NodalLoad::nodal(FeNodeId::from_index(top - i), Vector3::x());
    let solve_rate = |n: usize, n_counted: usize| -> Result<f64, HapdefError> {
        let loads: Vec<NodalLoad> = (0..n).map(load).collect();
        let wanted = [FeNodeId::from_index(top)];
        let start = Instant::now();
        model.compliance(&loads, &wanted, &ComplianceParams::default())?;
        let flops = 4.0 * estimate.nnz_l as f64 * n_counted as f64;
        Ok(flops / start.elapsed().as_secs_f64())
    };
    // the first ones on a model take its condition number, too
    let few = solve_rate(N_FEW, N_FEW + CONDITION_LOADS)?;
    let n_many = 4 * Machine::MANY_LOADS;
    Ok([
        estimate.n_elements as f64 / info.assemble_s,
        estimate.factor_flops / info.factor_s,
        solve_rate(n_many, n_many)?,
        few,
    ])
}

/// Operations per second of `steps` steps of `batch` samples, once a few have warmed up.
fn training_rate(spec: &MlpSpec, steps: u64, batch: usize) -> Result<f64, HapdefError> {
    let values = |n: usize| (0..n).map(|i| (i % 17) as f32 - 8.0).collect::<Vec<_>>();
    let (n_in, n_out) = (spec.inputs, spec.outputs);
    let mut samples = MemorySource::new(n_in, n_out, values(batch * n_in), values(batch * n_out))?;
    let mut net = Net::new(Mlp::random(spec, 1)?, Scale::identity(n_in), Scale::identity(n_out))?;
    let mut elapsed_s = |steps| {
        let params = TrainParams {
            steps,
            batch,
            validate_every: 0,
            checkpoint_every: 0,
            ..TrainParams::paper(1)
        };
        let go_on = &mut |_: &_| ControlFlow::Continue(());
        let start = Instant::now();
        train(&mut net, &mut samples, None, &params, None, go_on)?;
        Ok::<_, HapdefError>(start.elapsed().as_secs_f64())
    };
    let warm_up_s = elapsed_s(WARM_UP)?;
    let steps_s = elapsed_s(WARM_UP + steps)? - warm_up_s;
    let flops = 6.0 * spec.n_parameters() as f64 * (steps as usize * batch) as f64;
    Ok(flops / steps_s.max(f64::EPSILON))
}

/// Operations per second of superposition on all threads; one is timed.
fn superposition_rate(threads: usize) -> f64 {
    let [n_nodes, n] = SUPERPOSED;
    let n_rows = 64;
    let table = ComplianceTable::new(n_nodes, n_nodes, &vec![1e-6; n_rows * n_nodes * 3]);
    let (mut scratch, mut map) = (table.scratch(), vec![0.0; n_nodes]);
    let start = Instant::now();
    for i in 0..n {
        let contact =
            |k: usize| DrawnContact { node: (i * 7 + k * 13) % n_rows, force_n: 1.0 + i as f64 };
        table.superpose(&[contact(0), contact(1)], &mut scratch, &mut map, &mut []);
    }
    let flops = (n * n_nodes) as f64 * (6.0 * 2.0 + 7.0);
    threads as f64 * flops / start.elapsed().as_secs_f64()
}

/// Operations per second of single samples that pass a net.
fn pass_rate(spec: &MlpSpec) -> Result<f64, HapdefError> {
    let (n_in, n_out) = (spec.inputs, spec.outputs);
    let scales = [n_in, n_out].map(Scale::identity);
    let [input, output] = scales;
    let net = Net::new(Mlp::random(spec, 1)?, input, output)?;
    let (x, mut y, mut scratch) = (vec![1.0; n_in], vec![0.0; n_out], Scratch::default());
    net.forward(&x, &mut scratch, &mut y)?;
    let start = Instant::now();
    for _ in 0..PASSES {
        net.forward(&x, &mut scratch, &mut y)?;
    }
    let flops = 2.0 * (spec.n_parameters() * PASSES) as f64;
    Ok(flops / start.elapsed().as_secs_f64())
}

/// Nodes per second of k-Max on a square patch with the paper's radius.
fn kmax_rate() -> Result<f64, HapdefError> {
    let side = SUPERPOSED[0].isqrt();
    let place = |i: usize| [(i % side) as f64 * NODE_GAP_M, (i / side) as f64 * NODE_GAP_M, 0.0];
    let points: Vec<[f64; 3]> = (0..side * side).map(place).collect();
    let radius_m = HapdefxSpec::default().kmax_radius_m;
    let graph = KMaxGraph::new(&points, KMaxParams::spanning_radius(&points, radius_m)?)?;
    let wave = |p: &[f64; 3]| (90.0 * p[0]).sin() as f32 * (70.0 * p[1]).cos() as f32;
    let field: Vec<f32> = points.iter().map(wave).collect();
    let mut peaks = Vec::new();
    graph.peaks(&field, 0.0, &mut peaks)?;
    let start = Instant::now();
    for _ in 0..PASSES {
        graph.peaks(&field, 0.0, &mut peaks)?;
    }
    Ok((points.len() * PASSES) as f64 / start.elapsed().as_secs_f64())
}

/// Bytes per second of a dataset of 64 MB at `path`, written and read back; it is removed.
fn file_rates(path: &Path) -> Result<[f64; 2], HapdefError> {
    let mut rounds = [[0.0; 2]; FILE_ROUNDS];
    let mut held = Vec::new();
    for round in &mut rounds {
        // held until the end: a program that reads a table has not used its memory before
        let (rates, values) = one_file(path)?;
        *round = rates;
        held.push(values);
    }
    Ok(std::array::from_fn(|i| {
        let mut rates = rounds.map(|round| round[i]);
        rates.sort_unstable_by(f64::total_cmp);
        rates[FILE_ROUNDS / 2]
    }))
}

fn one_file(path: &Path) -> Result<([f64; 2], Vec<f32>), HapdefError> {
    let (width, n_blocks, n_rows) = (4000, 16, 250);
    let rows = vec![1.0_f32; n_rows * width];
    let start = Instant::now();
    let spec = TensorSpec::f32(VALUES, width, "1");
    let mut writer = DatasetWriter::create(path, n_blocks * n_rows, &[spec])?;
    for _ in 0..n_blocks {
        writer.append(VALUES, &rows)?;
    }
    writer.finish()?;
    let write_s = start.elapsed().as_secs_f64();
    drop(rows);
    let start = Instant::now();
    let mut all = vec![0.0_f32; n_blocks * n_rows * width];
    DatasetReader::open(path)?.read_rows(VALUES, 0..n_blocks * n_rows, &mut all)?;
    let read_s = start.elapsed().as_secs_f64();
    std::fs::remove_file(path).map_err(HapdefError::file(path))?;
    let rates = [write_s, read_s].map(|elapsed_s| (4 * all.len()) as f64 / elapsed_s);
    Ok((rates, all))
}
