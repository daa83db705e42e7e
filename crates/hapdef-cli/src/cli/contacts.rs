//! `hapdef contacts`: contacts behind a table of readings.

use std::io::Write;
use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use clap::Args;
use hapdef::Limb;
use hapdef::touch::{Touch, given_loads, touch_estimator};
use hapdef_cli::{SceneArgs, StandardOutput, TrainingArgs, shown};
use serde_json::{Value, json};

use super::contacts_truth::{self, TruthRequest};
use super::table::read_table;
use super::topic::TopicArgs;

#[derive(Args)]
#[command(after_help = "Example:\n  \
    hapdef contacts fixtures/shin/scene.json readings.csv --json\n  \
    hapdef contacts fixtures/shin/scene.json presses.csv --truth presses.csv\n\n\
    The scene's estimator is used: superposition needs one solve for each gauge, the paper's chain \
    its trained nets.")]
pub(crate) struct ContactsArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    training: TrainingArgs,
    /// Tared readings, µε: a frame a line, a column for each gauge by its name or in order; commas,
    /// semicolons or tabs between. Or an MCAP file, with --topic.
    readings: PathBuf,
    #[command(flatten)]
    topic: TopicArgs,
    /// Print only frames whose contacts are not those of this table, by cause: the search, a tie or the map's error.
    /// It has names in its first line as hapdef probe writes it, x_m, y_m, z_m, force_n, x2_m and so on, m and N, and
    /// a row for each frame; it may be the table of readings. A contact without force does not press.
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
    /// Print a frame a line as JSON; with --truth one object.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &ContactsArgs) -> Result<()> {
    let run = args.training.prepare(&args.scene)?;
    let given = given_loads(&run)?;
    ensure!(
        given.is_empty(),
        "{}: the scene takes loads off by what its device measures beside the gauges, which a table lacks; take \
         hapdef live with --source replay:FILE@max, or a scene whose loads were learned with --without-signals",
        shown(&args.readings)
    );
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    if let Some(truth) = &args.truth {
        let (readings, topic) = (&args.readings, &args.topic);
        let request = TruthRequest { readings, topic, truth, is_json: args.json };
        return contacts_truth::run(&request, &run, &limb);
    }
    let names: Vec<&str> = run.scene.gauges.sites.iter().map(|site| site.name.as_str()).collect();
    let frames = read_table(&args.readings, &args.topic, &[], &names)?;
    let mut estimator = touch_estimator(&run, &limb)?;
    let mut touch = Touch::default();
    let mut out = StandardOutput;
    for (i, frame) in frames.iter().enumerate() {
        estimator
            .estimate(&frame.values, &mut touch)
            .with_context(|| format!("{}: frame {}", shown(&args.readings), i + 1))?;
        if args.json {
            writeln!(out, "{}", as_json(i, &touch))?;
        } else {
            writeln!(out, "frame {}: {}", i + 1, in_words(&touch))?;
        }
    }
    Ok(())
}

fn in_words(touch: &Touch) -> String {
    if touch.contacts.is_empty() {
        return "nothing touches".into();
    }
    let contacts = touch.contacts.iter().map(|contact| {
        let [x, y, z] = (contact.position_m.coords * 1e3).into();
        let sure = contact.uncertainty.map_or(String::new(), |u| {
            format!(" (±{:.2} mm, ±{:.2} N)", u.position_sd_m() * 1e3, u.force_sd_n())
        });
        let wide = contact.radius.map_or(String::new(), |radius| {
            format!(", wide: a radius of {:.0} mm", radius.radius_m * 1e3)
        });
        format!("{:.2} N at ({x:.2}, {y:.2}, {z:.2}) mm{sure}{wide}", contact.force_n)
    });
    let doubt = match touch.quality {
        Some(quality) if !quality.is_identified() => "; the frame does not decide",
        _ => "",
    };
    contacts.collect::<Vec<_>>().join(", ") + doubt
}

fn as_json(frame: usize, touch: &Touch) -> Value {
    let contacts = touch.contacts.iter().map(|contact| {
        json!({
            "position_m": <[f64; 3]>::from(contact.position_m.coords),
            "force_n": contact.force_n,
            "radius_m": contact.radius.map(|radius| radius.radius_m),
            "radius_sd_m": contact.radius.and_then(|radius| radius.sd_m),
            "position_sd_m": contact.uncertainty.map(|u| u.position_sd_m()),
            "force_sd_n": contact.uncertainty.map(|u| u.force_sd_n()),
        })
    });
    let quality = touch.quality.map(|q| {
        json!({
            "is_identified": q.is_identified(),
            "chi2": q.chi2,
            "n_dof": q.n_dof,
            "p_value": q.p_value,
            "n_alternatives": q.n_alternatives,
        })
    });
    json!({"frame": frame, "contacts": contacts.collect::<Vec<_>>(), "quality": quality})
}
