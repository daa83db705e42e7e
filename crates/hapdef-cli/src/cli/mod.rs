//! The command line.

mod backlog;
mod bundle;
mod calibrate;
mod calibrate_args;
mod calibrate_live;
mod calibrate_words;
mod check;
mod contacts;
mod contacts_truth;
mod converge;
mod deck;
mod demo;
mod doctor;
mod export;
mod figure;
mod files;
mod inspect;
mod lean;
mod limits;
mod live;
mod live_alert;
mod live_args;
mod live_end;
mod live_limb;
mod live_model;
mod live_record;
mod live_robot;
mod live_ros;
mod loads;
mod manual;
mod mesh;
mod network;
mod new;
mod pages;
mod place;
mod plan;
mod print;
mod probe;
mod recalibrate;
mod record;
mod recover;
mod replay;
mod rig;
mod scene;
mod shell;
mod signals;
mod sim;
mod stage;
mod static_page;
mod table;
mod topic;
mod truth;
mod unit;
mod view;
mod wrap;

use anyhow::Result;
use clap::{Args, Parser, Subcommand};
use hapdef::Until;
use hapdef_cli::{SampleArgs, SceneArgs, TrainingArgs};

/// A sense of touch for robot limbs from a few strain gauges.
#[derive(Parser)]
#[command(
    name = "hapdef",
    version,
    after_help = "Examples:\n  \
    hapdef demo fixtures/shin/demo.json\n  \
    hapdef new fixtures/shin/shin_skin.glb -o my-limb\n  \
    hapdef live my-limb --sim --view\n  \
    hapdef inspect fixtures/shin/shin_skin.glb\n  \
    hapdef eval fixtures/shin/scene.json --profile quick\n\n\
    Results go to target/hapdef/<scene>/; finished stages are kept and not run again."
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    command: Command,
    /// No progress: results, warnings and errors alone.
    #[arg(long, short, global = true)]
    quiet: bool,
}

#[derive(Subcommand)]
enum Command {
    /// Reads a surface (.glb, .gltf, .stl, .obj, .dae) or a solid (.inp, .dat, .cdb, .msh) and reports its
    /// quality.
    #[command(
        after_help = "Examples:\n  hapdef inspect fixtures/shin/shin_skin.glb\n  hapdef inspect fixtures/shin/shin.inp.gz --json"
    )]
    Inspect(inspect::InspectArgs),
    /// A limb from any mesh: reads it, says what it guesses, writes a folder with skin and scene.
    New(new::NewArgs),
    /// The whole job in a minute: calibrates a limb on its simulated rig, finds contacts, says how well.
    Demo(demo::DemoArgs),
    /// Solves a solid deck's own load and prints displacement, energy and mass.
    Deck(deck::DeckArgs),
    /// Reads a scene and its limb and checks both, without solving anything.
    Check(check::CheckArgs),
    /// Prints a scene with what it leaves out filled in.
    Scene(scene::SceneCommandArgs),
    /// Which stages the scene needs, which are left out and why, and what they will take; solves
    /// nothing.
    Plan(plan::PlanArgs),
    /// Whether the limb's mesh is fine enough: the same presses on finer and finer meshes.
    Converge(converge::ConvergeArgs),
    /// From a surface to gauge readings with a shell model, and how far it is from a solid.
    Shell(shell::ShellArgs),
    /// One clean skin of a dirty surface, faithful or refused, with what was lost and bridged.
    Wrap(wrap::WrapArgs),
    /// A volume mesh of a closed surface, by a gmsh that is installed here.
    Mesh(mesh::MeshArgs),
    /// What the scene's gauges can tell about contacts: bounds on the limb, blind spots.
    Limits(limits::LimitsArgs),
    /// Where on the inner wall to put gauges.
    Place(place::PlaceArgs),
    /// The limb's wall as an STL file with pockets for its gauges, and a drawing to glue them by.
    Print(print::PrintArgs),
    /// Presses the scene's simulated rig and writes a table of presses.
    Probe(probe::ProbeArgs),
    /// Corrects the response of the gauges by a table of presses.
    Calibrate(calibrate_args::CalibrateArgs),
    /// Known touches in use keep the calibration up to date: gains that drift, touch by touch; can be undone.
    Recalibrate(recalibrate::RecalibrateArgs),
    /// Learns from frames in which nothing touches what a robot's own motion does to the gauges.
    Loads(loads::LoadsArgs),
    /// The virtual limb as a device that speaks HDP1 on a pseudo-terminal or over TCP.
    Rig(rig::RigArgs),
    /// Contacts behind a table of readings, by the scene's estimator.
    Contacts(contacts::ContactsArgs),
    /// Records readings to a file that survives a crash.
    Record(record::RecordArgs),
    /// Plays a recording again, as a device or as lines of JSON.
    Replay(replay::ReplayArgs),
    /// Makes a whole file of a damaged or unfinished recording and says what was lost.
    Recover(recover::RecoverArgs),
    /// Writes a recording as a table or as lines of JSON.
    Export(export::ExportArgs),
    /// Looks for what is in the way of good readings: ports, rights, rate, channels, disk.
    Doctor(doctor::DoctorArgs),
    /// One file with everything that a robot needs to find contacts.
    Bundle(bundle::BundleArgs),
    /// The live page of the virtual limb as static files, with the whole program in the browser.
    Page(static_page::PageArgs),
    /// Contacts from a stream of frames: a device, a recording.
    Live(Box<live_args::LiveArgs>),
    /// The limb's compliance and the simulated rig's response.
    #[command(after_help = "Example:\n  hapdef simulate fixtures/shin/scene.json")]
    Simulate(RunArgs),
    /// Everything up to the datasets.
    #[command(after_help = "Example:\n  hapdef dataset fixtures/shin/scene.json --profile quick")]
    Dataset(DatasetArgs),
    /// Everything up to the trained nets.
    #[command(after_help = "Example:\n  hapdef train fixtures/shin/scene.json --profile quick")]
    Train(TrainArgs),
    /// Everything up to the scores of the trained nets.
    #[command(after_help = "Example:\n  hapdef eval fixtures/shin/scene.json --profile quick")]
    Eval(TrainArgs),
    /// Completions of commands and options for a shell.
    Completions(manual::CompletionsArgs),
    /// Manual pages of the program and of each of its commands.
    Man(manual::ManArgs),
}

/// A scene, and how its records are printed.
#[derive(Args)]
struct RunArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Print the stages' records as JSON, one a line.
    #[arg(long)]
    json: bool,
}

#[derive(Args)]
struct DatasetArgs {
    #[command(flatten)]
    run: RunArgs,
    #[command(flatten)]
    samples: SampleArgs,
}

#[derive(Args)]
struct TrainArgs {
    #[command(flatten)]
    run: RunArgs,
    #[command(flatten)]
    training: TrainingArgs,
}

/// Does what the arguments say.
pub(crate) fn run(cli: &Cli) -> Result<()> {
    if cli.quiet {
        hapdef_cli::be_quiet();
    }
    match &cli.command {
        Command::Inspect(args) => inspect::inspect(args),
        Command::New(args) => new::run(args),
        Command::Deck(args) => deck::run(args),
        Command::Demo(args) => demo::run(args),
        Command::Check(args) => check::run(args),
        Command::Scene(args) => scene::run(args),
        Command::Plan(args) => plan::run(args),
        Command::Converge(args) => converge::converge(args),
        Command::Shell(args) => shell::shell(args),
        Command::Wrap(args) => wrap::run(args),
        Command::Mesh(args) => mesh::run(args),
        Command::Limits(args) => limits::run(args),
        Command::Place(args) => place::run(args),
        Command::Print(args) => print::run(args),
        Command::Probe(args) => probe::run(args),
        Command::Calibrate(args) => calibrate::calibrate(args),
        Command::Recalibrate(args) => recalibrate::recalibrate(args),
        Command::Loads(args) => loads::run(args),
        Command::Rig(args) => rig::rig(args),
        Command::Contacts(args) => contacts::run(args),
        Command::Record(args) => record::run(args),
        Command::Replay(args) => replay::run(args),
        Command::Recover(args) => recover::run(args),
        Command::Export(args) => export::run(args),
        Command::Doctor(args) => doctor::run(args),
        Command::Bundle(args) => bundle::run(args),
        Command::Page(args) => static_page::run(args),
        Command::Live(args) => live::run(args),
        Command::Simulate(args) => {
            stage::run_until(&args.scene.prepare()?, Until::Simulate, args.json)
        }
        Command::Dataset(DatasetArgs { run, samples }) => {
            stage::run_until(&samples.prepare(&run.scene)?, Until::Dataset, run.json)
        }
        Command::Train(TrainArgs { run, training }) => {
            stage::run_until(&training.prepare(&run.scene)?, Until::Train, run.json)
        }
        Command::Eval(TrainArgs { run, training }) => {
            stage::run_until(&training.prepare(&run.scene)?, Until::Eval, run.json)
        }
        Command::Completions(args) => manual::completions(args),
        Command::Man(args) => manual::man(args),
    }
}

#[cfg(test)]
#[path = "../../tests/it/support/help.rs"]
mod help;

#[cfg(test)]
mod tests {
    use clap::{CommandFactory, Parser};

    use super::{Cli, help};

    #[test]
    fn every_help_has_an_example_that_is_understood() {
        help::every_help_has_an_example_that_is_understood::<Cli>("hapdef");
    }

    #[test]
    fn how_nets_are_trained_comes_after_what_a_command_has_of_its_own() {
        let mut command = Cli::command();
        for (name, own) in [("live", "--source"), ("contacts", "--json"), ("bundle", "--modes")] {
            let command = command.find_subcommand_mut(name).unwrap();
            let help = command.render_long_help().to_string();
            let at = |words: &str| help.find(words).unwrap();
            assert!(at("\nTraining:") < at("      --l2"), "{name}");
            assert!(at(&format!("      {own}")) < at("\nTraining:"), "{name}");
        }
    }

    /// Names of the commands that have an option.
    fn with_option(name: &str) -> Vec<String> {
        let command = Cli::command();
        let has = |c: &&clap::Command| c.get_arguments().any(|a| a.get_long() == Some(name));
        command.get_subcommands().filter(has).map(|c| c.get_name().to_owned()).collect()
    }

    #[test]
    fn out_is_what_a_command_makes_and_short_is_the_same() {
        let makers = [
            "new", "shell", "wrap", "mesh", "place", "loads", "record", "recover", "export",
            "bundle", "page", "man",
        ];
        assert_eq!(with_option("out"), makers);
        for command in Cli::command().get_subcommands() {
            let short = command.get_arguments().find(|arg| arg.get_short() == Some('o'));
            let is_maker = makers.contains(&command.get_name());
            assert_eq!(short.and_then(clap::Arg::get_long), is_maker.then_some("out"));
        }
        assert_eq!(with_option("results"), with_option("profile"));
    }

    #[test]
    fn every_command_prints_json_but_what_makes_text_for_programs() {
        let with = with_option("json");
        let command = Cli::command();
        let names = command.get_subcommands().map(|c| c.get_name());
        let without: Vec<&str> = names.filter(|name| !with.iter().any(|w| w == name)).collect();
        // a scene and an export are data as they are
        assert_eq!(without, ["scene", "export", "completions", "man"]);
    }

    #[test]
    fn names_of_before_are_understood() {
        for words in [
            ["new", "a.stl", "--folder", "a"],
            ["place", "scene.json", "--write", "b.json"],
            ["bundle", "scene.json", "--bundle", "c.hapdef"],
        ] {
            let parsed = Cli::try_parse_from(std::iter::once("hapdef").chain(words));
            assert!(parsed.is_ok(), "{words:?}: {:?}", parsed.err());
        }
    }

    #[test]
    fn only_what_may_train_nets_says_how() {
        let may_train = ["plan", "contacts", "bundle", "live", "train", "eval"];
        for name in [
            "steps",
            "l2",
            "batch",
            "output-modes",
            "output-scale",
            "loss",
            "samples",
            "backend",
            "other-steps",
        ] {
            assert_eq!(with_option(name), may_train, "--{name}");
        }
        let makes_samples = ["plan", "contacts", "bundle", "live", "dataset", "train", "eval"];
        assert_eq!(with_option("singles"), makes_samples);
        assert_eq!(with_option("multis"), makes_samples);
    }
}
