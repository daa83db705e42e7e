//! Samples per second in training, and microseconds per forward pass, of the paper's four networks
//! on random samples. Prints one METRIC line each.
//!
//! `cargo run --release --example train_speed [steps]`

#![allow(clippy::print_stdout, reason = "its output is its purpose")]

use std::error::Error;
use std::ops::ControlFlow;
use std::time::Instant;

use hapdef_nets::train::{MemorySource, Progress, train};
use hapdef_nets::{Mlp, MlpSpec, Net, Scale, Scratch, TrainParams};

fn main() -> Result<(), Box<dyn Error>> {
    let steps = match std::env::args().nth(1) {
        Some(text) => text.parse()?,
        None => 40,
    };
    measure("transfer", &MlpSpec::transfer(10, 240), 10 * steps)?;
    measure("reconstruction", &MlpSpec::reconstruction(240, 3211), steps)?;
    measure("sensitivity", &MlpSpec::sensitivity(), 20 * steps)?;
    measure("direct", &MlpSpec::direct(10), 10 * steps)?;
    Ok(())
}

fn measure(name: &str, spec: &MlpSpec, steps: u64) -> Result<(), Box<dyn Error>> {
    let mut net = Net::new(
        Mlp::random(spec, 1)?,
        Scale::identity(spec.inputs),
        Scale::identity(spec.outputs),
    )?;
    // One more than are taken: a training that is stopped need not have learned anything.
    let params = TrainParams { steps: steps + 1, ..TrainParams::paper(1) };
    let mut samples = samples(spec, 1000)?;
    let mut stop = |progress: &Progress| match progress.step < steps {
        true => ControlFlow::Continue(()),
        false => ControlFlow::Break(()),
    };
    let info = train(&mut net, &mut samples, None, &params, None, &mut stop)?;
    println!("METRIC:train_{name}:{:.0}:samples/s", info.samples_per_s);
    println!("METRIC:forward_{name}:{:.1}:us", forward_us(&net)?);
    Ok(())
}

fn samples(spec: &MlpSpec, n: usize) -> Result<MemorySource, hapdef_nets::NetsError> {
    let wave = |n: usize| (0..n).map(|i| (0.37 * i as f32).sin()).collect();
    let (x, y) = (wave(n * spec.inputs), wave(n * spec.outputs));
    MemorySource::new(spec.inputs, spec.outputs, x, y)
}

/// The median of 201 single forward passes, microseconds.
fn forward_us(net: &Net) -> Result<f64, hapdef_nets::NetsError> {
    let spec = net.mlp().spec();
    let x = vec![0.5; spec.inputs];
    let mut out = vec![0.0; spec.outputs];
    let mut scratch = Scratch::default();
    let mut times = vec![];
    for _ in 0..201 {
        let start = Instant::now();
        net.forward(&x, &mut scratch, &mut out)?;
        times.push(start.elapsed().as_secs_f64() * 1e6);
    }
    times.sort_by(f64::total_cmp);
    Ok(times[times.len() / 2])
}
