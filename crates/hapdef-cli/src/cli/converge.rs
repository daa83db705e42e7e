//! `hapdef converge`: whether a scene's mesh is fine enough.

use anyhow::Result;
use clap::Args;
use hapdef::convergence::{
    Convergence, ConvergenceParams, Quantity, QuantityEstimate, ShellAgreement,
};
use hapdef::{Limb, stages};
use hapdef_cli::{SceneArgs, print_json};

#[derive(Args)]
#[command(after_help = "Example:\n  hapdef converge fixtures/shin/scene.json")]
pub(crate) struct ConvergeArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Refinements to solve beside the scene's mesh; each has eight times the elements. From 2 on
    /// the order of convergence is observed, not assumed.
    #[arg(long, default_value_t = 1)]
    levels: usize,
    /// Presses, spread over the skin.
    #[arg(long, default_value_t = 24)]
    presses: usize,
    /// Print the study as JSON.
    #[arg(long)]
    json: bool,
}

pub(crate) fn converge(args: &ConvergeArgs) -> Result<()> {
    let run = args.scene.prepare()?;
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    let params = ConvergenceParams {
        refinements: args.levels,
        n_presses: args.presses,
        ..ConvergenceParams::default()
    };
    let (_, study) = stages::mesh_check(&run, &limb, &params)?;
    if args.json {
        print_json(&study, true)?;
    } else {
        show(&study, &limb);
    }
    Ok(())
}

fn show(study: &Convergence, limb: &Limb) {
    println!("   FE nodes   equations  straightened    build s  adjoint s   tip µm/N  point µm/N");
    for level in &study.levels {
        println!(
            "{:11} {:11} {:13} {:10.2} {:10.2} {:>10} {:>11}",
            level.n_fe_nodes,
            level.n_equations,
            level.n_straightened,
            level.build_s,
            level.adjoint_s,
            range(&level.tip_um_per_n),
            range(&level.point_um_per_n),
        );
    }
    study.shell.iter().for_each(show_shell);
    for estimate in &study.estimates {
        println!("{}", line(estimate));
    }
    println!("{}", study.in_words(limb));
}

/// The shell and the scene's solid against the finest solid.
fn show_shell(shell: &ShellAgreement) {
    let percent = |x: f64| 100.0 * x;
    println!(
        "{:11} {:11} {:>13} {:10.2}",
        shell.n_fe_nodes, shell.n_equations, "shell", shell.build_s
    );
    println!("\ngauge readings off the finest solid   shell      solid on the scene's mesh");
    for (i, gauge) in shell.gauges.iter().enumerate() {
        println!(
            "gauge {i:3}, {:9.2} µε/N rms       {:6.1} %    {:6.1} %",
            gauge.finest_ue_per_n,
            percent(gauge.shell_difference),
            percent(gauge.solid_difference)
        );
    }
    println!(
        "all, by press: median               {:6.1} %    {:6.1} %",
        percent(shell.median_difference),
        percent(shell.solid_median_difference)
    );
    println!(
        "               worst                {:6.1} %    {:6.1} %\n",
        percent(shell.worst_difference),
        percent(shell.solid_worst_difference)
    );
}

fn line(estimate: &QuantityEstimate) -> String {
    let name = match estimate.quantity {
        Quantity::GaugeReading => "gauge readings under the tip",
        Quantity::TipDisplacement => "displacement under the tip",
        Quantity::PointDisplacement => "displacement under a point force (grows without end)",
    };
    let percent = |errors: &[f64]| {
        let all: Vec<String> = errors.iter().map(|e| format!("{:.1}", 100.0 * e)).collect();
        all.join(" → ")
    };
    format!(
        "{name}: finest / scene's mesh {:.2} (median; {:.2} to {:.2}); estimated error, % of the \
         finest: median {}, worst {}; order {:.1} ({})",
        estimate.median_ratio,
        estimate.ratio_range[0],
        estimate.ratio_range[1],
        percent(&estimate.median_error),
        percent(&estimate.worst_error),
        estimate.order,
        if estimate.order_observed { "observed" } else { "assumed" },
    )
}

fn range(values: &[f64]) -> String {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    format!("{:.0}–{:.0}", sorted[0], sorted[sorted.len() - 1])
}
