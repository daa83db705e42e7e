//! `hapdef rig`: the virtual limb as a device on a port.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, Result, ensure};
use clap::Args;
use hapdef::{Limb, Run, VirtualRigParams, live_limb, random_presses, virtual_device};
use hapdef_cli::{SceneArgs, StandardOutput, print_json, shown};
use hapdef_daq::record::claim;
use hapdef_rig::live::{
    DevicePort, LiveLimb, PressScript, PtyPort, RigFault, RunInfo, RunParams, TcpPort, TruthFrame,
    run_rig,
};
use serde_json::{Value, json};

use super::network::{IS_READ, check_reach};

#[derive(Args)]
#[command(after_help = "Example, in two terminals:\n  \
    hapdef rig fixtures/shin/placed.json --link /tmp/limb --truth truth.jsonl\n  \
    hapdef live fixtures/shin/placed.json --source serial:/tmp/limb\n\n\
    Simulated: the scene's limb, perturbed, pressed by a script. It speaks HDP1 (docs/formats.md) on \
    a pseudo-terminal that looks like a serial port. docs/rig.md has the script's format.\n\n\
    Faults: bitflips=RATE, drops=RATE, dups=RATE, bursts=RATExBYTES, holes=RATExBYTES, \
    unplug=AT_S+FOR_S, reset=AT_S, drift=PPM, dead=CHANNEL, swap=A,B; may be given several times.")]
pub(crate) struct RigArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Speak on a pseudo-terminal; so it is without --tcp, too.
    #[arg(long, conflicts_with = "tcp")]
    pty: bool,
    /// A symbolic link to the pseudo-terminal, whose name stays when it is plugged in again.
    #[arg(long, conflicts_with = "tcp")]
    link: Option<PathBuf>,
    /// Listen on TCP, such as 127.0.0.1:7878; port 0 takes a free one.
    #[arg(long)]
    tcp: Option<String>,
    /// Let --tcp listen beyond this machine: whoever reaches the port reads everything.
    #[arg(long, requires = "tcp")]
    insecure_bind: bool,
    /// Play a script of presses.
    #[arg(long, conflicts_with = "random")]
    script: Option<PathBuf>,
    /// Draw a script of a minute from this seed and repeat it; so it is without --script, from seed 1.
    #[arg(long)]
    random: Option<u64>,
    /// Write the script that is played.
    #[arg(long)]
    write_script: Option<PathBuf>,
    /// End after that many seconds; with Ctrl-C otherwise.
    #[arg(long)]
    seconds: Option<f64>,
    /// Something that goes wrong, see below.
    #[arg(long = "fault")]
    faults: Vec<RigFault>,
    /// Seed of the damage on the wire.
    #[arg(long, default_value_t = 1)]
    fault_seed: u64,
    /// Write the ground truth, a JSON line for each frame.
    #[arg(long)]
    truth: Option<PathBuf>,
    /// Frames per second.
    #[arg(long, default_value_t = 1000.0)]
    rate_hz: f64,
    /// Lines of JSON: the port as soon as it is open, and what happened in the end.
    #[arg(long)]
    json: bool,
}

/// Runs the virtual rig until its time is over or Ctrl-C.
pub(crate) fn rig(args: &RigArgs) -> Result<()> {
    if let Some(seconds) = args.seconds {
        ensure!(seconds > 0.0, "--seconds: expected a time above 0, found {seconds}");
    }
    if let Some(address) = &args.tcp {
        check_reach("--tcp", address, IS_READ, args.insecure_bind)?;
    }
    let run = args.scene.prepare()?;
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    let limb = Arc::new(live_limb(&run, &limb)?);
    let script = script(args, &run, &limb)?;
    let params = VirtualRigParams {
        script: Some(script),
        rate_hz: args.rate_hz,
        faults: args.faults.clone(),
    };
    let device = virtual_device(&run.scene, Arc::clone(&limb), &params)?;
    if !args.json {
        let (name, n_gauges) = (&run.scene.name, limb.n_gauges());
        println!("simulated {name}: {n_gauges} gauges at {} Hz", args.rate_hz);
    }
    let run_params = RunParams {
        duration_s: args.seconds,
        faults: args.faults.clone(),
        fault_seed: args.fault_seed,
        ..RunParams::default()
    };
    let mut truth = args.truth.as_deref().map(TruthFile::create).transpose()?;
    let keep = |frame: &TruthFrame| {
        if let Some(file) = &mut truth {
            file.add(frame);
        }
    };
    let info = if let Some(address) = &args.tcp {
        let port = announced(TcpPort::listen(address)?, args.json)?;
        run_rig(device, port, &run_params, &run.stop, keep)
    } else {
        let port = announced(PtyPort::open(args.link.as_deref())?, args.json)?;
        run_rig(device, port, &run_params, &run.stop, keep)
    };
    if let Some(file) = truth {
        let path = file.finish()?;
        if !args.json {
            println!("truth {}", shown(&path));
        }
    }
    if args.json {
        return Ok(print_json(&as_json(&info, args.truth.as_deref()), false)?);
    }
    println!("{}", in_words(&info));
    Ok(())
}

fn announced<P: DevicePort>(port: P, is_json: bool) -> Result<P> {
    if is_json {
        print_json(&json!({ "port": port.name(), "is_simulated": true }), false)?;
    } else {
        println!("port {}", port.name());
    }
    StandardOutput.flush()?;
    Ok(port)
}

fn script(args: &RigArgs, run: &Run, limb: &LiveLimb) -> Result<PressScript> {
    let script = match &args.script {
        Some(path) => {
            let file = shown(path).to_string();
            let text = std::fs::read_to_string(path).with_context(|| format!("{file}: reading"))?;
            PressScript::from_json(&text).context(file)?
        }
        None => random_presses(&run.scene, limb, args.random.unwrap_or(1)),
    };
    if let Some(path) = &args.write_script {
        std::fs::write(path, script.to_json()?)
            .with_context(|| format!("writing {}", shown(path)))?;
    }
    Ok(script)
}

fn in_words(info: &RunInfo) -> String {
    format!(
        "{} frames, {} dropped as nobody took them, {} left out, {} damaged; {:.1} ms late at worst",
        info.n_frames,
        info.n_dropped,
        info.n_skipped,
        info.n_hit,
        info.worst_late_s * 1e3
    )
}

fn as_json(info: &RunInfo, truth: Option<&Path>) -> Value {
    json!({
        "n_frames": info.n_frames,
        "n_dropped": info.n_dropped,
        "n_skipped": info.n_skipped,
        "n_damaged": info.n_hit,
        "worst_late_s": info.worst_late_s,
        "truth": truth,
    })
}

/// The file of ground truth; it gets its name when it is complete.
struct TruthFile {
    path: PathBuf,
    partial: PathBuf,
    out: BufWriter<File>,
    fault: Option<std::io::Error>,
}

impl TruthFile {
    fn create(path: &Path) -> Result<Self> {
        let mut partial = path.as_os_str().to_owned();
        partial.push(".partial");
        let partial = PathBuf::from(partial);
        let file = claim(&partial, None)?;
        Ok(Self { path: path.to_path_buf(), partial, out: BufWriter::new(file), fault: None })
    }

    /// The first fault is kept for the end: the device goes on.
    fn add(&mut self, frame: &TruthFrame) {
        if self.fault.is_none() {
            self.fault = frame.write_json_line(&mut self.out).err();
        }
    }

    fn finish(mut self) -> Result<PathBuf> {
        let written = self.fault.take().map_or_else(|| self.out.flush(), Err);
        written.with_context(|| format!("writing {}", shown(&self.partial)))?;
        std::fs::rename(&self.partial, &self.path)
            .with_context(|| format!("naming {}", shown(&self.path)))?;
        Ok(self.path)
    }
}
