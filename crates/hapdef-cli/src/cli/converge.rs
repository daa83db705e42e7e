//! `hapdef converge`: whether a scene's mesh is fine enough.

use anyhow::Result;
use clap::Args;
use hapdef::convergence::{Convergence, ConvergenceParams, Quantity, QuantityEstimate};
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
        show(&study);
    }
    Ok(())
}

fn show(study: &Convergence) {
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
    for estimate in &study.estimates {
        println!("{}", line(estimate));
    }
    println!("{study}");
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
