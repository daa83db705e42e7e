//! The limbs of a robot, each as if it were alone, with names of its own.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use hapdef::{LimbSource, Robot, RobotLimb};
use hapdef_cli::shown;
use hapdef_ros::RobotBoard;

use super::live_args::LiveArgs;
use super::live_ros::LimbOfRobot;
use super::topic::TopicArgs;

/// What `hapdef live` does for each limb of a robot; its options are those of all. Makes the folder of recordings.
///
/// # Errors
/// An option that is one limb's, a folder that is a file or can't be made.
pub(super) fn limbs_of(args: &LiveArgs, robot: &Robot) -> Result<Vec<LiveArgs>> {
    if let Some(option) = of_the_file(args) {
        bail!("{option}: the robot file says that of each limb; leave the option out");
    }
    if let Some((option, instead)) = of_one_limb(args) {
        bail!("{option}: that is of one limb, here are all of {}; {instead}", robot.name);
    }
    if let Some(folder) = &args.ros.record {
        make_folder(folder)?;
    }
    let board = RobotBoard::default();
    let numbered = robot.limbs.iter().enumerate();
    let limb = |(number, limb): (usize, &RobotLimb)| {
        let names = LimbOfRobot {
            prefix: robot.prefix(limb),
            frame: limb.frame.clone(),
            robot: format!("/{}", robot.name),
            board: board.clone(),
            number,
        };
        limb_args(args, limb, names)
    };
    Ok(numbered.map(limb).collect())
}

/// The first of the options that a robot file has in their place.
fn of_the_file(args: &LiveArgs) -> Option<&'static str> {
    [
        ("--source", args.source.is_some()),
        ("--sim", args.sim),
        ("--topic", args.topic.topic.is_some()),
    ]
    .into_iter()
    .find_map(|(option, is_given)| is_given.then_some(option))
}

/// The first of the options that do nothing for several limbs, and what to do instead.
fn of_one_limb(args: &LiveArgs) -> Option<(&'static str, &'static str)> {
    let of_ros = args.ros.of_one_limb().map(|option| match option {
        "--prefix" | "--frame" => {
            (option, "topics begin with /ROBOT/LIMB, and the file names frames")
        }
        "--foxglove" => (option, "use --zenoh, or --record and look at the files"),
        _ => (option, "run that limb alone"),
    });
    let is_alert = args.alert.is_wanted();
    let other = [
        ("--csv", args.csv.is_some(), "use --json, or --record and hapdef export"),
        ("--loads", args.loads.is_some(), "name them in the limb's scene: loads.learned"),
        ("--alert", is_alert, "run a program for each limb, with a controller's address for each"),
        ("--view-first", args.view.is_first_measured(), "measure with one limb"),
    ];
    let mut other = other.into_iter();
    of_ros.or_else(|| other.find_map(|(option, is, instead)| is.then_some((option, instead))))
}

fn make_folder(folder: &Path) -> Result<()> {
    ensure!(
        !folder.is_file(),
        "--record {}: expected a folder, for a file for each limb, found a file; choose another name",
        shown(folder)
    );
    std::fs::create_dir_all(folder).with_context(|| format!("--record {}: making", shown(folder)))
}

fn limb_args(args: &LiveArgs, limb: &RobotLimb, names: LimbOfRobot) -> LiveArgs {
    let mut of_limb = args.clone();
    of_limb.limb = Some(limb.name.clone());
    of_limb.scene.scene = limb.scene.clone();
    of_limb.topic = TopicArgs::default();
    match &limb.source {
        LimbSource::Sim { seed } => (of_limb.sim, of_limb.sim_seed) = (true, *seed),
        LimbSource::Readings(source) => of_limb.source = Some(source.clone()),
    }
    let file = |folder: &PathBuf| folder.join(format!("{}.mcap", limb.name));
    let record = args.ros.record.as_ref().map(file);
    of_limb.ros = args.ros.of_limb(names, record);
    of_limb
}
