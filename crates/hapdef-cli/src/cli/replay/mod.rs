//! `hapdef replay`: a recording once more, as a device or as lines.

mod device;
mod packets;
mod wire;

use std::io::Write;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use anyhow::Result;
use clap::Args;
use hapdef_cli::{JsonLines, StandardOutput};
use hapdef_daq::Message;
use hapdef_daq::record::{Content, Recording};

use super::export::tell_damage;
use super::network::{IS_READ, check_reach};
use super::signals::stop_flag;

#[derive(Args)]
#[command(after_help = "Examples:\n  \
    hapdef replay press.mcap --pty /tmp/limb\n  \
    hapdef replay press.mcap --tcp 127.0.0.1:7000 --speed 2\n  \
    hapdef replay press.mcap --json --speed max\n\n\
    A device plays when a host opens it, from the beginning, loses nothing on the way, and is \
    unplugged at the end. Numbers, times and gaps are those of the recording.")]
pub(crate) struct ReplayArgs {
    /// The recording.
    file: PathBuf,
    /// Times the original pace, or `max`.
    #[arg(long, default_value = "1", value_parser = hapdef::parse_speed)]
    speed: f64,
    #[command(flatten)]
    form: Form,
    /// Let --tcp listen beyond this machine: whoever reaches the port reads everything.
    #[arg(long, requires = "tcp")]
    insecure_bind: bool,
}

#[derive(Args)]
#[group(required = true, multiple = false)]
struct Form {
    /// An HDP1 device on a pseudo-terminal; its path is printed, and linked to if one is named.
    #[arg(long, value_name = "LINK", num_args = 0..=1)]
    pty: Option<Option<PathBuf>>,
    /// An HDP1 device on a TCP port; port 0 is any that is free, and printed.
    #[arg(long, value_name = "ADDR")]
    tcp: Option<String>,
    /// Every record as a line of JSON on standard output.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &ReplayArgs) -> Result<()> {
    let stop = stop_flag()?;
    if let Some(link) = &args.form.pty {
        let wire = wire::PtyWire::new(link.clone())?;
        return device::play(&args.file, args.speed, wire, &stop);
    }
    if let Some(address) = &args.form.tcp {
        check_reach("--tcp", address, IS_READ, args.insecure_bind)?;
        let wire = wire::TcpWire::bind(address)?;
        return device::play(&args.file, args.speed, wire, &stop);
    }
    lines(args, &stop)
}

/// The records as lines, frames at their times.
fn lines(args: &ReplayArgs, stop: &AtomicBool) -> Result<()> {
    let mut recording = Recording::open(&args.file)?.with_first_chunk()?;
    let mut out = JsonLines(StandardOutput);
    let mut start = None;
    while let Some(record) = recording.next_record()? {
        if stop.load(Ordering::Relaxed) {
            break;
        }
        if let Content::Message(Message::Frame(_)) = record.content {
            let time_ns = record.log_time_ns;
            let (since, first_ns) = *start.get_or_insert((Instant::now(), time_ns));
            let after_s = time_ns.saturating_sub(first_ns) as f64 * 1e-9 / args.speed;
            let due = Duration::try_from_secs_f64(after_s).unwrap_or_default();
            let wait = due.saturating_sub(since.elapsed());
            if wait > Duration::from_millis(1) {
                out.flush()?;
                std::thread::sleep(wait);
            }
        }
        writeln!(out, "{}", record.json_line())?;
    }
    out.flush()?;
    tell_damage(recording.damage());
    Ok(())
}
