//! `hapdef plan`: what a scene will take, before anything is solved.

use anyhow::Result;
use clap::Args;
use hapdef::plan::{Machine, Plan, PlanStep, StepState, When, plan};
use hapdef::{Limb, SceneArgs};

#[derive(Args)]
#[command(
    after_help = "Example:\n  hapdef plan fixtures/shin/scene.json --profile quick\n\n\
    The first plan measures the machine for a few seconds and keeps the figures beside the results \
    (machine.json); delete that file to measure again."
)]
pub(crate) struct PlanArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Print the plan as JSON.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &PlanArgs) -> Result<()> {
    let run = args.scene.prepare()?;
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    let machine = Machine::read_or_measure(&args.scene.out.join("machine.json"), run.threads)?;
    let max_wall_m = run.scene.rig.max_wall_m;
    let plan = plan(&run, &limb, &machine)?;
    let plan = plan.with_shell_advice(&limb, max_wall_m, &args.scene.out)?;
    if args.json {
        println!("{}", serde_json::to_string_pretty(&plan)?);
    } else {
        print(&plan);
    }
    Ok(())
}

fn print(plan: &Plan) {
    println!(
        "{}: {}, profile {}",
        plan.scene, plan.estimator, plan.profile
    );
    for (when, title) in [(When::Design, "once"), (When::Frame, "every frame")] {
        println!("\n{title:36} state       Mflop      MB  expected s  made in s  why");
        for step in plan.steps.iter().filter(|step| step.when == when) {
            println!("{}", line(step));
            let sizes: Vec<String> = step
                .sizes
                .iter()
                .map(|(name, n)| format!("{n} {name}"))
                .collect();
            if !sizes.is_empty() {
                println!("    {}", sizes.join(", "));
            }
        }
    }
    println!("\nexpected in all: {:.1} s", plan.predicted_s());
}

fn line(step: &PlanStep) -> String {
    let state = match step.state {
        StepState::Runs => "runs",
        StepState::Cached => "cached",
        StepState::Skipped => "skipped",
    };
    let seconds = |s: Option<f64>| s.map_or_else(|| "–".to_owned(), |s| format!("{s:.2}"));
    format!(
        "{:36} {state:7} {:9.1} {:7.1}  {:>10}  {:>9}  {}",
        step.name,
        step.flops * 1e-6,
        step.bytes * 1e-6,
        seconds(step.predicted_s),
        seconds(step.recorded_s),
        step.why
    )
}
