//! `hapdef contacts --truth`: frames whose contacts are not those that pressed, by cause.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use hapdef::touch::{Causes, NotClean, by_superposition, why_not_clean};
use hapdef::{Limb, Run};
use hapdef_bench::{Column, table, terminal_table};
use hapdef_cli::{print_json, print_line, shown};
use hapdef_inverse::{ContactEstimate, Skin, SkinPoint};
use hapdef_live::estimator::EstimatorKind;
use nalgebra::Point3;
use serde::Serialize;

use super::table::{Row, contact_columns, n_contacts, read_table};
use super::topic::TopicArgs;

/// Farthest a true contact may lie from the skin, m; that of a press for `hapdef calibrate`, too.
const OFF_SKIN_M: f64 = 2e-3;

/// Contacts of a frame: places, m, and forces, N.
type Contacts = Vec<([f64; 3], f64)>;

/// A frame that is not clean.
#[derive(Serialize)]
struct Bad {
    /// From 0.
    frame: usize,
    #[serde(flatten)]
    why: NotClean,
    truth: Contacts,
    found: Contacts,
}

const COLUMNS: [Column<Bad>; 7] = [
    Column::new("frame", |bad| (bad.frame + 1).to_string()),
    Column::new("cause", |bad| bad.why.cause.name().to_owned()),
    Column::new("χ²", |bad| format!("{:.1}", bad.why.chi2)),
    Column::new("of the truth", |bad| format!("{:.1}", bad.why.chi2_of_truth)),
    Column::new("behind it", |bad| format!("{:.1}", bad.why.behind)),
    Column::new("true, N at mm", |bad| in_words(&bad.truth)),
    Column::new("found", |bad| in_words(&bad.found)),
];

/// What is asked for.
pub(super) struct TruthRequest<'a> {
    pub(super) readings: &'a Path,
    pub(super) topic: &'a TopicArgs,
    pub(super) truth: &'a Path,
    pub(super) is_json: bool,
}

/// Finds the contacts of each frame on its own, by superposition, and prints those frames that are not clean.
pub(super) fn run(request: &TruthRequest<'_>, run: &Run, limb: &Limb) -> Result<()> {
    ensure!(
        run.scene.estimator.kind() != EstimatorKind::Hapdefx,
        "--truth: causes are found by evidence, which the paper's chain has none of; expected a scene whose \
         estimator is superposition or tracking"
    );
    let frames = read(request, run)?;
    let estimator = by_superposition(run, limb)?;
    let skin = estimator.map().skin();
    let (mut scratch, mut found) = (estimator.scratch(), ContactEstimate::default());
    let (mut causes, mut all_bad) = (Causes::default(), Vec::new());
    for (frame, (row, contacts)) in frames.iter().enumerate() {
        let place = || format!("{}: {}", shown(request.truth), row.place);
        let truth = on_skin(skin, contacts).with_context(place)?;
        estimator.estimate_into(&row.values, &mut scratch, &mut found).with_context(place)?;
        let why = why_not_clean(&estimator, &row.values, &truth, &found).with_context(place)?;
        causes.add(why.as_ref());
        all_bad.extend(why.map(|why| Bad {
            frame,
            why,
            truth: contacts.clone(),
            found: found.contacts.iter().map(|c| (c.position_m.coords.into(), c.force_n)).collect(),
        }));
    }
    print(&all_bad, &causes, request.is_json)
}

fn print(all_bad: &[Bad], causes: &Causes, is_json: bool) -> Result<()> {
    if is_json {
        #[derive(Serialize)]
        struct Report<'a> {
            #[serde(flatten)]
            causes: &'a Causes,
            not_clean: &'a [Bad],
        }
        print_json(&Report { causes, not_clean: all_bad }, false)?;
        return Ok(());
    }
    if !all_bad.is_empty() {
        print_line(format_args!("{}\n", terminal_table(&table(&COLUMNS, all_bad))));
    }
    let n = causes.n_clean + causes.n_bad();
    print_line(format_args!(
        "{} of {n} frames are clean; not by search {}, tie {}, map {}",
        causes.n_clean, causes.n_search, causes.n_tie, causes.n_map
    ));
    Ok(())
}

/// The frames, each with its true contacts; those without force don't press.
fn read(request: &TruthRequest<'_>, run: &Run) -> Result<Vec<(Row, Contacts)>> {
    let TruthRequest { readings, topic, truth, .. } = *request;
    let names: Vec<&str> = run.scene.gauges.sites.iter().map(|site| site.name.as_str()).collect();
    let columns: Vec<String> = (0..n_contacts(truth)?).flat_map(contact_columns).collect();
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    let (truths, frames) = if truth == readings {
        let split = |row: Row| {
            let (truth, readings) = row.values.split_at(columns.len());
            (truth.to_vec(), Row { values: readings.to_vec(), place: row.place })
        };
        read_table(readings, topic, &columns, &names)?.into_iter().map(split).unzip()
    } else {
        let truths = read_table(truth, &TopicArgs::default(), &columns, &[])?;
        let truths: Vec<Vec<f64>> = truths.into_iter().map(|row| row.values).collect();
        (truths, read_table(readings, topic, &[], &names)?)
    };
    ensure!(
        truths.len() == frames.len(),
        "{}: expected as many rows as {} has frames, {}, found {}",
        shown(truth),
        shown(readings),
        frames.len(),
        truths.len()
    );
    let pressing = |truth: Vec<f64>| {
        let contacts = truth.as_chunks().0.iter().map(|&[x, y, z, force_n]| ([x, y, z], force_n));
        contacts.filter(|(_, force_n)| *force_n > 0.0).collect()
    };
    Ok(frames.into_iter().zip(truths.into_iter().map(pressing)).collect())
}

fn on_skin(skin: &Skin, contacts: &Contacts) -> Result<Vec<(SkinPoint, f64)>> {
    let on = |&(x, force_n): &([f64; 3], f64)| {
        let (point, off_m) = skin.nearest(&Point3::from(x))?;
        ensure!(
            off_m <= OFF_SKIN_M,
            "a true contact at {x:?} m: expected at most {} mm from the skin, found {:.1}",
            OFF_SKIN_M * 1e3,
            off_m * 1e3
        );
        Ok((point, force_n))
    };
    contacts.iter().map(on).collect()
}

fn in_words(contacts: &Contacts) -> String {
    let one = |(at, force_n): &([f64; 3], f64)| {
        let [x, y, z] = at.map(|x| x * 1e3);
        format!("{force_n:.1} at ({x:.0}, {y:.0}, {z:.0})")
    };
    match contacts[..] {
        [] => "none".to_owned(),
        _ => contacts.iter().map(one).collect::<Vec<_>>().join(", "),
    }
}
