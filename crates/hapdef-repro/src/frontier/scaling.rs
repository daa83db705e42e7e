//! How times grow with nodes, gauges, contacts and frames.

use std::sync::Arc;
use std::time::Instant;

use anyhow::Result;
use hapdef::Run;
use hapdef_bench::stats::median;
use hapdef_inverse::{EstimatorParams, ResponseMap, ResponseParams, TrackerParams};
use hapdef_mesh::GaugeId;
use hapdef_nets::{MlpSpec, Scratch};
use hapdef_sim::{ElasticModel, ElasticParams, IsotropicMaterial};
use nalgebra::Vector3;

use super::figures::{ADJOINT, FACTOR, FRAME_GAUGES, FRAME_NODES};
use super::growth::Growth;
use super::tube::Tube;
use crate::bench::random;
use crate::compare::bench::{Presses, estimator, track};
use crate::compare::sequence::Script;
use crate::compare::world::Draw;

/// Cells around of tubes of about 1, 3, 10, 30, 100 and 300 thousand nodes.
const CELLS: [usize; 6] = [9, 16, 29, 50, 91, 158];

/// The tube on which gauges and contacts are counted.
const USUAL_CELLS: usize = 29;
const USUAL_GAUGES: usize = 10;

const GAUGES: [usize; 5] = [4, 8, 16, 32, 64];

/// Gauges that six contacts need, and then some.
const GAUGES_OF_CONTACTS: usize = 24;

const BATCHES: [usize; 5] = [1, 4, 16, 64, 256];

/// Standard deviation of a reading's noise, µε, tip, m.
const NOISE_UE: f64 = 1.0;
const TIP_M: f64 = 0.002;

/// Scripts that are followed, their strongest force, N, and gap, m.
const N_SCRIPTS: usize = 12;
const STRONGEST_N: f64 = 34.0;
const GAP_M: f64 = 0.015;

/// Measures every growth, tubes up to `most_nodes` nodes.
pub(super) fn measure(run: &Run, most_nodes: usize, seed: u64) -> Result<Vec<Growth>> {
    let mut all = nodes(run, most_nodes, seed)?;
    all.extend(gauges(run, seed)?);
    all.push(contacts(run, seed)?);
    all.push(batches(run)?);
    Ok(all)
}

fn nodes(run: &Run, most_nodes: usize, seed: u64) -> Result<Vec<Growth>> {
    let (mut factor, mut adjoint, mut memory, mut frame) = (vec![], vec![], vec![], vec![]);
    for n_cells in CELLS {
        if 12 * n_cells * n_cells > most_nodes {
            break;
        }
        run.check_stop("the scaling")?;
        run.say(&format!("a tube of {} nodes", 12 * n_cells * n_cells));
        let solved = Solved::new(run, n_cells, USUAL_GAUGES)?;
        let n = solved.n_nodes as f64;
        factor.push((n, solved.build_s));
        adjoint.push((n, solved.adjoint_s));
        memory.push((n, 1e-6 * (solved.factor_bytes + solved.response_bytes) as f64));
        frame.push((n, solved.tracking_us(2, seed)?));
    }
    let of = |what, metric, theory, points| Growth::new(what, "nodes", metric, theory, points);
    Ok(vec![
        of("ordering and factor, s", FACTOR, "1.5", factor),
        of("10 adjoint solves, s", ADJOINT, "1, times log n", adjoint),
        of("factor and response, MB", "memory_nodes_exponent", "1, times log n", memory),
        of("a frame while two contacts are followed, µs", FRAME_NODES, "0", frame),
    ])
}

fn gauges(run: &Run, seed: u64) -> Result<[Growth; 2]> {
    let (mut frame, mut memory) = (vec![], vec![]);
    for n_gauges in GAUGES {
        run.check_stop("the scaling")?;
        let solved = Solved::new(run, USUAL_CELLS, n_gauges)?;
        frame.push((n_gauges as f64, solved.tracking_us(1, seed)?));
        memory.push((n_gauges as f64, 1e-6 * solved.response_bytes as f64));
    }
    let of = |what, metric, points| Growth::new(what, "gauges", metric, "1", points);
    Ok([
        of("a frame while one contact is followed, µs", FRAME_GAUGES, frame),
        of("response, MB", "memory_gauges_exponent", memory),
    ])
}

fn contacts(run: &Run, seed: u64) -> Result<Growth> {
    let solved = Solved::new(run, USUAL_CELLS, GAUGES_OF_CONTACTS)?;
    let of = |k: usize| Ok((k as f64, solved.tracking_us(k, seed)?));
    let points: Result<Vec<_>> = (1..=6).map(of).collect();
    Ok(Growth::new(
        "a frame while contacts are followed, 24 gauges, µs",
        "contacts",
        "frame_contacts_exponent",
        "1 to 2, beside a fixed cost",
        points?,
    ))
}

/// Frames that pass nets of the paper's widths together, on one thread.
fn batches(run: &Run) -> Result<Growth> {
    run.say("batches of frames through nets of the paper's widths");
    let spec = MlpSpec::reconstruction(240, 3200);
    let net = random(&spec, 1)?;
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let mut points = Vec::new();
    for batch in BATCHES {
        let x: Vec<f32> = (0..batch * spec.inputs).map(|i| (i % 17) as f32).collect();
        let mut y = vec![0.0; batch * spec.outputs];
        let mut scratch = Scratch::default();
        let mut times = Vec::new();
        for _ in 0..8 {
            let start = Instant::now();
            alone.install(|| net.forward_batch(&x, &mut scratch, &mut y))?;
            times.push(start.elapsed().as_secs_f64() * 1e6);
        }
        points.push((batch as f64, median(times)));
    }
    Ok(Growth::new("frames through F_R together, f32, µs", "frames", "batch_exponent", "1", points))
}

/// A tube, solved for its gauges.
struct Solved {
    n_nodes: usize,
    /// Assembly, ordering and factor.
    build_s: f64,
    adjoint_s: f64,
    /// The factor's entries as stored.
    factor_bytes: usize,
    /// The gauges' fields at every node, and the map of them on the outer side.
    response_bytes: usize,
    map: Arc<ResponseMap>,
}

impl Solved {
    fn new(run: &Run, n_cells: usize, n_gauges: usize) -> Result<Self> {
        let tube = Tube::new(n_cells)?;
        let gauges = tube.gauges(n_gauges)?;
        let material = IsotropicMaterial::new(2e9, 0.35, 1000.0)?;
        let params = ElasticParams {
            n_threads: run.threads,
            ..ElasticParams::new(material, tube.clamped.clone())
        };
        let start = Instant::now();
        let model = ElasticModel::build(&tube.mesh, &params)?;
        let build_s = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let (response, _) = model.response(&gauges)?;
        let adjoint_s = start.elapsed().as_secs_f64();
        let at_node = |node: &hapdef_mesh::FeNodeId| {
            let fields = (0..n_gauges).map(GaugeId::from_index);
            let values = fields.map(|gauge| response.field(gauge)[node.index()] * 1e6);
            values.collect::<Vec<Vector3<f64>>>()
        };
        let adjoint: Vec<Vector3<f64>> = tube.outside.iter().flat_map(at_node).collect();
        let tip = ResponseParams { tip_radius_m: TIP_M };
        let map = ResponseMap::from_nodal(tube.skin()?, n_gauges, &adjoint, &tip)?;
        let n_nodes = tube.mesh.nodes().len();
        let of_a_node = n_gauges * size_of::<Vector3<f64>>();
        Ok(Self {
            n_nodes,
            build_s,
            adjoint_s,
            factor_bytes: model.info().nnz_l_stored * size_of::<f64>(),
            response_bytes: (n_nodes + tube.outside.len()) * of_a_node,
            map: Arc::new(map),
        })
    }

    /// Median time of a frame once `n_contacts` are there, searches on a second thread.
    fn tracking_us(&self, n_contacts: usize, seed: u64) -> Result<f64> {
        let params = EstimatorParams { max_contacts: n_contacts, ..EstimatorParams::default() };
        let estimator = estimator(&self.map, NOISE_UE, params)?;
        let presses = Presses { map: &self.map, noise_ue: NOISE_UE };
        let mut draw = Draw::new(self.map.skin(), seed);
        let mut frames = Vec::new();
        for _ in 0..N_SCRIPTS {
            let script = Script::draw(&mut draw, n_contacts, GAP_M, STRONGEST_N);
            frames.push(presses.frames(&script, &mut draw));
        }
        let params = TrackerParams { max_contacts: n_contacts, ..TrackerParams::default() };
        let tracked = track(&estimator, &params, &frames)?;
        let n_last = frames.first().map_or(0, Vec::len) / (2 * n_contacts + 2);
        let of_scripts = tracked.times_us.chunks(tracked.times_us.len() / N_SCRIPTS);
        let last = of_scripts.flat_map(|times| &times[times.len() - n_last..]);
        Ok(median(last.copied()))
    }
}
