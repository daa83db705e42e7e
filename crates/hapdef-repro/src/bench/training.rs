//! Training speed beside PyTorch's, in turns, so that both meet the same state of the machine.

use std::io::Write;
use std::ops::ControlFlow;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

use anyhow::{Result, bail};
use hapdef_bench::stats::median;
use hapdef_nets::train::{MemorySource, Progress, train};
use hapdef_nets::{MlpSpec, TrainParams};
use hapdef_report::MetricLog;

use super::python::Python;
use super::random;

/// The script, as it was when this program was built.
const SCRIPT: &str = include_str!("../../scripts/torch_training.py");

/// Threads of both.
const THREADS: usize = 2;

/// Samples of a turn, whatever the batch.
const SAMPLES: u64 = 4096;

/// Turns of each; the median ratio counts.
const ROUNDS: usize = 5;

/// Samples that batches are drawn from.
const N_SAMPLES: usize = 2048;

const BATCHES: [usize; 2] = [1024, 256];

/// Samples per second of F_R's training (240-600-1200-1800-3211; forward, backward, Adam) and the
/// ratio to PyTorch's in 32 bits on as many threads, where `python` has it.
pub(super) fn training<W: Write>(python: &Path, log: &mut MetricLog<W>) -> Result<()> {
    let spec = MlpSpec::reconstruction(240, 3211);
    let mut torch = match Torch::start(python, &spec) {
        Ok(torch) => torch,
        Err(error) => {
            log.skipped("nets.train_vs_torch", &format!("{error:#}"))?;
            return Ok(());
        }
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(THREADS).build()?;
    for batch in BATCHES {
        let rates = rates(&pool, &mut torch, &spec, batch)?;
        let [torch_f32, own_f32] = rates.each_ref().map(|r| median(r.iter().copied()));
        let [torch, own] = &rates;
        let name = |text: &str| match batch {
            1024 => format!("nets.{text}"),
            _ => format!("nets.{text}_b{batch}"),
        };
        log.value(&name("train_torch"), torch_f32, "samples/s")?;
        log.value(&name("train"), own_f32, "samples/s")?;
        log.value(&name("train_vs_torch"), median_ratio(own, torch), "1")?;
    }
    Ok(())
}

/// Samples per second of every turn: PyTorch and ours, in 32 bits.
fn rates(
    pool: &rayon::ThreadPool,
    torch: &mut Torch,
    spec: &MlpSpec,
    batch: usize,
) -> Result<[Vec<f64>; 2]> {
    let steps = SAMPLES / batch as u64;
    let mut rates = [const { Vec::new() }; 2];
    torch.seconds(batch, 2)?;
    for _ in 0..ROUNDS {
        let seconds =
            [torch.seconds(batch, steps)?, pool.install(|| own_seconds(spec, batch, steps))?];
        for (rates, seconds) in rates.iter_mut().zip(seconds) {
            rates.push(SAMPLES as f64 / seconds);
        }
    }
    Ok(rates)
}

/// Seconds that so many steps take, the first not counted: it makes the buffers.
fn own_seconds(spec: &MlpSpec, batch: usize, steps: u64) -> Result<f64> {
    let wave = |n: usize| (0..n).map(|i| (0.37 * i as f32).sin()).collect();
    let (x, y) = (wave(N_SAMPLES * spec.inputs), wave(N_SAMPLES * spec.outputs));
    let mut samples = MemorySource::new(spec.inputs, spec.outputs, x, y)?;
    let mut net = random(spec, 1)?;
    let params = TrainParams { steps: steps + 1, batch, ..TrainParams::paper(1) };
    let mut times = [None; 2];
    let mut note = |progress: &Progress| {
        let at = usize::from(progress.step > 1);
        times[at] = Some(Instant::now());
        ControlFlow::Continue(())
    };
    train(&mut net, &mut samples, None, &params, None, &mut note)?;
    match times {
        [Some(first), Some(last)] => Ok((last - first).as_secs_f64()),
        _ => bail!("a training of {steps} steps did not get past its first"),
    }
}

/// Median over the rounds of the ratio within a round.
fn median_ratio(own: &[f64], torch: &[f64]) -> f64 {
    median(own.iter().zip(torch).map(|(own, torch)| own / torch))
}

/// PyTorch in a Python that takes steps when asked to.
struct Torch(Python);

impl Torch {
    fn start(python: &Path, spec: &MlpSpec) -> Result<Self> {
        let widths = [&[spec.inputs], spec.hidden.as_slice(), &[spec.outputs]].concat();
        let mut command = Command::new(python);
        command.args(["-c", SCRIPT, &THREADS.to_string()]);
        let mut torch = Python::start(command.args(widths.iter().map(usize::to_string)))?;
        let line = torch.line()?;
        if !line.starts_with("ready") {
            bail!("no PyTorch: {}", line.trim());
        }
        Ok(Self(torch))
    }

    fn seconds(&mut self, batch: usize, steps: u64) -> Result<f64> {
        Ok(self.0.ask(&format!("{batch} {steps}"))?.trim().parse()?)
    }
}
