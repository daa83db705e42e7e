//! Inference: F_T and F_R at the paper's sizes on random weights, one frame, one core.

use anyhow::{Context, Result};
use hapdef_bench::{Column, or_dash, table, terminal_table};
use hapdef_nets::infer::{InferParams, LowRank, Precision, PreparedNet};
use hapdef_nets::{Activation, Mlp, MlpSpec, Net, Scale, Scratch};
use hapdef_report::MetricLog;
use serde::Serialize;

use super::BenchNetsArgs;
use super::clock::{Quantiles, Stream, Times};
use super::methods::{Method, Passes};
use super::peers::Peers;

/// Gauges, virtual gauges and surface nodes of the paper's limb.
const WIDTHS: [usize; 3] = [10, 240, 3211];

/// Rank of the thin last layer, and outputs of a scene that wants one patch.
const RANK: usize = 64;
const N_WANTED: usize = 800;

/// A row of the table.
#[derive(Debug, Serialize)]
struct Row {
    path: String,
    #[serde(flatten)]
    times: Quantiles,
    /// Largest error over the largest output, against the plain f32 forward pass.
    relative_error: Option<f64>,
    weight_bytes: Option<usize>,
    floor_us: Option<f64>,
}

/// A method through both nets.
struct Chain {
    name: String,
    passes: Passes,
    out: Vec<f32>,
    times: Times,
    floor: Stream,
    weight_bytes: usize,
    relative_error: Option<f64>,
}

/// Times every path, prints the table, logs the metrics.
pub(super) fn run(args: &BenchNetsArgs, log: &mut MetricLog<std::io::Stdout>) -> Result<()> {
    let (rows, missing) = measure(args)?;
    println!("{}", terminal_table(&table(&COLUMNS, &rows)));
    hapdef::write_json(&args.results.join("bench-nets-inference.json"), &rows)?;
    log_metrics(log, &rows, &missing)
}

fn measure(args: &BenchNetsArgs) -> Result<(Vec<Row>, String)> {
    let [n_gauges, n_virtual, n_surface] = WIDTHS;
    let transfer = random(&MlpSpec::transfer(n_gauges, n_virtual), args.seed)?;
    let reconstruction = random(&MlpSpec::reconstruction(n_virtual, n_surface), args.seed)?;
    let x: Vec<f32> = (0..n_gauges).map(|i| (1.0 + i as f32).sin()).collect();
    let (mut scratch, mut s) = (Scratch::default(), vec![0.0; n_virtual]);
    let mut y = vec![0.0; n_surface];
    transfer.forward(&x, &mut scratch, &mut s)?;
    reconstruction.forward(&s, &mut scratch, &mut y)?;
    let mut paths = paths([&transfer, &reconstruction], args.seed, &x, &y)?;
    let folder = args.results.join("bench-nets-peers");
    let nets = [&transfer, &reconstruction];
    let (mut peers, missing) = Peers::if_there(&args.python, &folder, nets, &x, &y);
    let mut plain = Times::default();
    for _ in 0..args.rounds {
        plain.round(|| {
            transfer.forward(&x, &mut scratch, &mut s)?;
            Ok(reconstruction.forward(&s, &mut scratch, &mut y)?)
        })?;
        for path in &mut paths {
            path.round(&x)?;
        }
        if let Some(peers) = &mut peers {
            peers.round()?;
        }
    }
    let row = |path: String, times: &Times, relative_error| Row {
        path,
        times: times.quantiles(),
        relative_error: Some(relative_error),
        weight_bytes: None,
        floor_us: None,
    };
    let mut rows = vec![row("plain forward f32".into(), &plain, 0.0)];
    rows.extend(paths.iter().map(Chain::row));
    for (name, peer) in peers.iter().flat_map(|peers| &peers.rows) {
        let path = format!("{name} ({})", peer.program);
        rows.push(row(path, &peer.times, peer.relative_error));
    }
    Ok((rows, missing))
}

/// A net with random weights and scales that change nothing.
pub(crate) fn random(spec: &MlpSpec, seed: u64) -> Result<Net> {
    let [input, output] = [spec.inputs, spec.outputs].map(Scale::identity);
    Ok(Net::new(Mlp::random(spec, seed)?, input, output)?)
}

/// All methods through the nets that are timed.
fn paths(nets: [&Net; 2], seed: u64, x: &[f32], y: &[f32]) -> Result<Vec<Chain>> {
    let mut paths = Vec::new();
    for precision in Precision::ALL {
        let params = InferParams::of(precision);
        let name = precision.name().to_owned();
        paths.push(Chain::new(name, nets, &params, x, Some(y))?);
    }
    let last = nets[1].mlp().layers().len() - 1;
    let (low_rank, _) = LowRank::of_weights(nets[1], last, RANK)?;
    let narrow = MlpSpec {
        inputs: WIDTHS[1],
        hidden: vec![256, 256, 64],
        outputs: WIDTHS[2],
        activation: Activation::Relu,
    };
    let narrow = random(&narrow, seed)?;
    let whole = InferParams::of(Precision::Int8);
    let name = |what: &str| format!("{}, {what}", Precision::Int8.name());
    let params = InferParams { wanted: Some((0..N_WANTED).collect()), ..whole.clone() };
    let title = name(&format!("{N_WANTED} outputs"));
    paths.push(Chain::new(title, nets, &params, x, Some(&y[..N_WANTED]))?);
    let params = InferParams { low_rank: vec![low_rank.clone()], ..whole.clone() };
    let title = name(&format!("rank {RANK}"));
    paths.push(Chain::new(title, nets, &params, x, None)?);
    let title = name("240-256-256-64-3211");
    paths.push(Chain::new(title, [nets[0], &narrow], &whole, x, None)?);
    Ok(paths)
}

impl Chain {
    /// `params` are for the second net; the first is whole, in the same precision. `y` are the
    /// outputs to compare with; none for a net of other weights.
    fn new(
        name: String,
        nets: [&Net; 2],
        params: &InferParams,
        x: &[f32],
        y: Option<&[f32]>,
    ) -> Result<Self> {
        let first = PreparedNet::new(nets[0], &InferParams::of(params.precision))?;
        let second = PreparedNet::new(nets[1], params)?;
        let mut path = Self {
            name,
            out: vec![0.0; second.n_outputs()],
            passes: Passes::new(Some(first), Method::Net(second)),
            times: Times::default(),
            floor: Stream::new(0),
            weight_bytes: 0,
            relative_error: None,
        };
        path.weight_bytes = path.passes.map(x, &mut path.out)?;
        path.floor = Stream::new(path.weight_bytes);
        path.relative_error = y.map(|y| relative_error(&path.out, y));
        Ok(path)
    }

    fn round(&mut self, x: &[f32]) -> Result<()> {
        let Self { passes, out, times, .. } = self;
        times.round(|| passes.map(x, out).map(drop))?;
        self.floor.round()
    }

    fn row(&self) -> Row {
        Row {
            path: self.name.clone(),
            times: self.times.quantiles(),
            relative_error: self.relative_error,
            weight_bytes: Some(self.weight_bytes),
            floor_us: Some(self.floor.times.quantiles().p50_us),
        }
    }
}

fn relative_error(found: &[f32], expected: &[f32]) -> f64 {
    let largest = expected.iter().fold(0.0f32, |m, v| m.max(v.abs()));
    let pairs = found.iter().zip(expected);
    let worst = pairs.fold(0.0f32, |m, (f, e)| m.max((f - e).abs()));
    f64::from(worst) / f64::from(largest)
}

impl Row {
    fn floor_ratio(&self) -> Option<f64> {
        Some(self.times.p50_us / self.floor_us?)
    }
}

const COLUMNS: [Column<Row>; 7] = [
    Column::new("F_T + F_R, one frame, one core", |r| r.path.clone()),
    Column::new("p50, µs", |r| format!("{:.0}", r.times.p50_us)),
    Column::new("p99, µs", |r| format!("{:.0}", r.times.p99_us)),
    Column::new("error", |r| or_dash(r.relative_error.map(|e| format!("{e:.1e}")))),
    Column::new("MB read", |r| or_dash(r.weight_bytes.map(|b| format!("{:.2}", b as f64 * 1e-6)))),
    Column::new("floor, µs", |r| or_dash(r.floor_us.map(|f| format!("{f:.0}")))),
    Column::new("p50 / floor", |r| or_dash(r.floor_ratio().map(|r| format!("{r:.2}")))),
];

fn log_metrics(log: &mut MetricLog<std::io::Stdout>, rows: &[Row], missing: &str) -> Result<()> {
    let row = |start: &str| rows.iter().find(|row| row.path.starts_with(start));
    for (name, own, other) in [
        ("nets.infer_f32_vs_ort", "f32", "ort f32"),
        ("nets.infer_int8_vs_ort", "int8", "ort int8"),
    ] {
        let own = rows.iter().find(|row| row.path == own).context(own)?;
        match row(other) {
            Some(other) => log.value(name, own.times.p50_us / other.times.p50_us, "1")?,
            None if missing.is_empty() => log.skipped(name, "no row of ONNX Runtime")?,
            None => log.skipped(name, &missing.replace(char::is_control, " "))?,
        }
    }
    let int8 = rows.iter().find(|row| row.path == "int8").context("int8")?;
    log.value("nets.infer_int8_p99_us", int8.times.p99_us, "µs")?;
    let ratios = rows.iter().filter_map(Row::floor_ratio);
    log.value("nets.infer_floor_ratio", ratios.fold(0.0, f64::max), "1")?;
    Ok(())
}
