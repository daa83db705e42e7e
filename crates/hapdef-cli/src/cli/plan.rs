//! `hapdef plan`: what a scene will take, before anything is solved.

use anyhow::Result;
use clap::Args;
use hapdef::Limb;
use hapdef::plan::{MeasuredStep, Plan, PlanStep, Rates, StepState, When, plan};
use hapdef_cli::{SceneArgs, StandardOutput, TrainingArgs, print_json};
use hapdef_report::{MetricContext, MetricLog};

#[derive(Args)]
#[command(after_help = "Example:\n  hapdef plan fixtures/shin/scene.json --profile quick\n  \
    hapdef plan fixtures/shin/placed.json --presses 300 --measure\n\n\
    Times are expected by what earlier runs in the same folder (--results) took, --measure included, and by \
    those of one machine where there are none.")]
pub(crate) struct PlanArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    training: TrainingArgs,
    /// Print the plan as JSON.
    #[arg(long)]
    json: bool,
    /// Plan a calibration with so many presses, too.
    #[arg(long)]
    presses: Option<usize>,
    /// Then solve, calibrate and search by superposition, and print what was expected beside it.
    #[arg(long)]
    measure: bool,
}

pub(crate) fn run(args: &PlanArgs) -> Result<()> {
    let run = args.training.prepare(&args.scene)?;
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    let rates = Rates::recorded(&run.cache, run.threads);
    let max_wall_m = limb.max_wall_m;
    let plan = plan(&run, &limb, &rates)?;
    let mut plan = plan.with_shell_advice(&limb, max_wall_m, &args.scene.results)?;
    if let Some(n_presses) = args.presses {
        plan = plan.with_calibration(&run, &limb, &rates, n_presses)?;
    }
    if args.json {
        print_json(&plan, true)?;
    } else {
        print(&plan);
    }
    if args.measure {
        let steps = plan.measured(&run, &limb, args.presses.unwrap_or(0))?;
        print_measured(&steps);
        let mut log = MetricLog::new(StandardOutput, MetricContext::here(run.scene.seed));
        for step in &steps {
            log.value(&format!("plan.{}_time_ratio", step.word), step.ratio(), "1")?;
        }
        log.append_to(&args.scene.results.join("metrics.json"))?;
    }
    Ok(())
}

fn print_measured(steps: &[MeasuredStep]) {
    println!("\n{:36} expected s  measured s  ratio", "by superposition");
    for step in steps {
        println!(
            "{:36} {:>10}  {:>10}  {:5.2}",
            step.step,
            seconds(step.predicted_s),
            seconds(step.measured_s),
            step.ratio()
        );
    }
}

/// Seconds with three digits, however few they are.
fn seconds(s: f64) -> String {
    if s >= 0.01 { format!("{s:.2}") } else { format!("{s:.2e}") }
}

fn print(plan: &Plan) {
    println!("{}: {}, profile {}", plan.scene, plan.estimator, plan.profile);
    for (when, title) in [(When::Design, "once"), (When::Frame, "every frame")] {
        println!("\n{title:36} state       Mflop      MB  expected s  made in s  why");
        for step in plan.steps.iter().filter(|step| step.when == when) {
            println!("{}", line(step));
            let sizes: Vec<String> =
                step.sizes.iter().map(|(name, n)| format!("{n} {name}")).collect();
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
        StepState::Alternative => "not so",
    };
    format!(
        "{:36} {state:7} {:9.1} {:7.1}  {:>10}  {:>9}  {}",
        step.name,
        step.flops * 1e-6,
        step.bytes * 1e-6,
        step.predicted_s.map_or_else(|| "–".into(), seconds),
        step.recorded_s.map_or_else(|| "–".into(), seconds),
        step.why
    )
}
