//! `hapdef doctor`: what is in the way of good readings, and what to do about it.

mod bundle;
mod channels;
mod check;
mod expected;
mod machine;
mod ports;
mod press;
mod seen;

use std::path::PathBuf;
use std::time::Duration;

use anyhow::Result;
use clap::Args;
use hapdef::scene::read_scene;
use hapdef::{SOURCE_FORMS, SourceArg};
use hapdef_cli::{print_json, scene_path};
use serde_json::Value;

use self::check::{Check, State};
use self::expected::Expected;
use self::press::Known;
use super::files::is_bundle;
use super::record::seconds;
use super::signals::stop_flag;
use super::topic::TopicArgs;

/// Exit code when something has to be mended.
const BAD: i32 = 1;

#[derive(Args)]
#[command(after_help = "Examples:\n  \
    hapdef doctor\n  \
    hapdef doctor --source serial:/dev/ttyACM0 fixtures/shin/scene.json\n  \
    hapdef doctor --source serial:/dev/ttyACM0 shin.hapdef\n  \
    hapdef doctor --source tcp:127.0.0.1:7000 --press-check\n\n\
    Each line is ok, warn or bad; what is not ok says what to do. Exit codes: 0 nothing is bad, \
    1 something is, 2 the command can't be done.")]
pub(crate) struct DoctorArgs {
    #[arg(long, help = format!("Where readings come from: {SOURCE_FORMS}"))]
    source: Option<SourceArg>,
    #[command(flatten)]
    topic: TopicArgs,
    /// Scene or bundle whose gauges the channels should be; a bundle is looked at, too.
    #[arg(value_parser = scene_path())]
    scene: Option<PathBuf>,
    /// How long readings are looked at, s.
    #[arg(long, default_value = "3", value_parser = seconds)]
    seconds: Duration,
    /// Ask for a press near each gauge and see which channel answers.
    #[arg(long, requires = "source")]
    press_check: bool,
    /// How long to wait for each press, s.
    #[arg(long, default_value = "20", value_parser = seconds)]
    patience: Duration,
    /// Folder in which recordings would be written.
    #[arg(long, default_value = ".")]
    folder: PathBuf,
    /// Print the checks as JSON.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &DoctorArgs) -> Result<()> {
    let stop = stop_flag()?;
    let (of_scene, gauges) = scene(args)?;
    let source = args.source.as_ref().map(|source| args.topic.of(source)).transpose()?;
    let mut checks = ports::checks(source.as_ref());
    checks.extend(of_scene);
    checks.extend(machine::checks(&args.folder));
    if let Some(source) = &source {
        let names = gauges.as_deref();
        checks.extend(channels::checks(source, args.seconds, names, &stop)?);
        if let SourceArg::Serial { device, .. } | SourceArg::Csv { device, .. } = source {
            // Opening the port has asked the driver for low latency.
            checks.push(ports::latency_check(device));
        }
        if args.press_check {
            let ask = |text: &str| eprintln!("{text}");
            let expected = args.scene.as_deref().filter(|_| gauges.is_some());
            let known =
                Known { expected: expected.map(Expected::read).transpose()?, names: gauges };
            checks.extend(press::checks(source, args.patience, &known, &stop, &ask)?);
        }
    }
    print(args, &checks)?;
    if checks.iter().any(|check| check.state == State::Bad) {
        std::process::exit(BAD);
    }
    Ok(())
}

/// Checks of the scene or bundle that was named, and its gauges' names where they are known.
fn scene(args: &DoctorArgs) -> Result<(Vec<Check>, Option<Vec<String>>)> {
    let Some(path) = &args.scene else {
        return Ok((Vec::new(), None));
    };
    if is_bundle(path)? {
        return Ok(bundle::checks(path));
    }
    let sites = read_scene(path)?.gauges.sites.into_iter();
    Ok((Vec::new(), Some(sites.map(|site| site.name).collect())))
}

fn print(args: &DoctorArgs, checks: &[Check]) -> Result<()> {
    if args.json {
        let all = Value::Array(checks.iter().map(Check::as_json).collect());
        return Ok(print_json(&all, false)?);
    }
    checks.iter().for_each(|check| println!("{check}"));
    Ok(())
}
