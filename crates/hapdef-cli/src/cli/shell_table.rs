//! What `hapdef shell` prints for people.

use hapdef::shell_limb::{
    Answered, GaugeInfo, MeasuredWall, ShellComparison, ShellLimb, SurfaceCounts, WallInfo,
};

/// Prints everything that was found.
pub(crate) fn show(limb: &ShellLimb, comparisons: &[ShellComparison]) {
    let info = &limb.info;
    show_wall(&info.wall);
    let mount = &info.mount;
    println!(
        "mount             {} end of {}, {:.2} mm: {} nodes clamped",
        mount.end,
        mount.axis,
        mount.length_m * 1e3,
        mount.n_clamped
    );
    let model = &info.model;
    println!(
        "shell model       {} nodes, {} triangles, {} equations, nnz(L) {}",
        model.n_nodes, model.n_triangles, model.n_equations, model.nnz_l
    );
    println!(
        "solved            relative residual {:.1e}, backward error {:.1e}",
        model.worst_relative_residual, model.worst_backward_error
    );
    println!(
        "gauges            {} on the inner side; {} sites passed over",
        info.gauges.len(),
        info.n_sites_passed_over
    );
    println!("       at, mm                  axis                strongest at, mm            µε/N");
    for (i, gauge) in info.gauges.iter().enumerate() {
        println!("{}", gauge_line(i, gauge));
    }
    println!("best gauge        {:.1} µε/N (median over free nodes)", info.median_best_ue_per_n);
    let times = info.stages.iter().map(|stage| format!("{} {:.2} s", stage.stage, stage.elapsed_s));
    println!("time              {}", times.collect::<Vec<_>>().join(", "));
    let thin_wall = limb.thin_wall();
    println!("thin wall         {thin_wall}");
    if let Some(text) = thin_wall.recommendation() {
        println!("{text}");
    }
    for comparison in comparisons {
        show_comparison(comparison);
    }
}

/// Presses that are printed; all are in the report.
const SHOWN_PRESSES: usize = 24;

fn show_wall(wall: &WallInfo) {
    println!("as read           {}", surface_line(&wall.given));
    let n_dropped: usize = wall.n_dropped_triangles.iter().sum();
    if wall.n_turned_triangles > 0 {
        println!("turned over       {} triangles", wall.n_turned_triangles);
    }
    if wall.n_welded_vertices + n_dropped > 0 {
        let [collapsed, degenerate, doubled, other] = wall.n_dropped_triangles;
        println!(
            "cleaned as asked  {} vertices joined; triangles dropped: {collapsed} collapsed, \
             {degenerate} without area, {doubled} doubled, {other} of other bodies",
            wall.n_welded_vertices
        );
        println!("                  {}", surface_line(&wall.cleaned));
    }
    if wall.body_volumes_m3.len() > 1 {
        let volumes = wall.body_volumes_m3.iter().map(|v| format!("{:.3}", v * 1e6));
        println!("bodies            {} cm³", volumes.collect::<Vec<_>>().join(", "));
    }
    if let Some(measured) = &wall.measured {
        show_measured(measured);
    }
    for refused in &wall.edges_refused {
        println!(
            "                  edges of {:.2} mm don't do: {}",
            refused.edge_m * 1e3,
            refused.cause
        );
    }
    println!(
        "remeshed          {}; edges {} mm, wanted {:.2}",
        surface_line(&wall.remeshed),
        millimetres(&wall.edge_quantiles_m),
        wall.target_edge_m * 1e3
    );
    let change = if wall.remeshed.is_closed {
        format!("volume changed by {:+.2} %", 100.0 * wall.volume_change)
    } else {
        let ratio = wall.remeshed.area_m2 / wall.area_before_remesh_m2;
        format!("area changed by {:+.2} %", 100.0 * (ratio - 1.0))
    };
    println!(
        "                  at most {:.3} mm from the surface before, {change}",
        wall.distance_m * 1e3
    );
    println!(
        "wall              {} mm (smallest, quartiles, largest), the skin is its {} side; {:.3} cm³",
        millimetres(&wall.thickness_quantiles_m),
        wall.side,
        wall.wall_volume_m3 * 1e6
    );
}

fn show_measured(measured: &MeasuredWall) {
    println!(
        "measured          {:.1} % of the outer skin is no shell: {:.1} % solid core, {:.1} % \
         without a parallel wall, {:.1} % too thick, {:.1} % in islands",
        100.0 * measured.not_shell_share,
        100.0 * measured.solid_core_share,
        100.0 * measured.no_wall_share,
        100.0 * measured.too_thick_share,
        100.0 * measured.island_share
    );
    println!(
        "                  solid {:.3} cm³, its shell {:.3} cm³",
        measured.solid_volume_m3 * 1e6,
        measured.shell_volume_m3 * 1e6
    );
}

fn surface_line(counts: &SurfaceCounts) -> String {
    let defects: Vec<String> = [
        (counts.n_open_edges, "open edges"),
        (counts.n_non_manifold_edges, "non-manifold edges"),
        (counts.n_misoriented_edges, "misoriented edges"),
        (counts.n_non_manifold_vertices, "non-manifold vertices"),
        (counts.n_degenerate_triangles, "triangles without area"),
        (counts.n_doubled_triangles, "doubled triangles"),
    ]
    .iter()
    .filter(|(n, _)| *n > 0)
    .map(|(n, what)| format!(", {n} {what}"))
    .collect();
    let volume = if counts.is_closed {
        format!("{:.3} cm³", counts.volume_m3 * 1e6)
    } else {
        format!("not closed (∮x·n/3 = {:.3} cm³)", counts.volume_m3 * 1e6)
    };
    format!(
        "{} triangles on {} vertices{}; {:.2} cm², {volume}",
        counts.n_triangles,
        counts.n_vertices,
        defects.concat(),
        counts.area_m2 * 1e4
    )
}

fn millimetres(values_m: &[f64; 5]) -> String {
    values_m.map(|v| format!("{:.2}", v * 1e3)).as_slice().join(" ")
}

fn gauge_line(number: usize, gauge: &GaugeInfo) -> String {
    let millimetres = |p: &[f64; 3]| {
        let [x, y, z] = p.map(|c| c * 1e3);
        format!("{x:7.1} {y:7.1} {z:7.1}")
    };
    let [x, y, z] = gauge.axis;
    format!(
        "g{number:<4} {}  {x:6.3} {y:6.3} {z:6.3}  {}  {:10.1}",
        millimetres(&gauge.position_m),
        millimetres(&gauge.strongest_position_m),
        gauge.strongest_ue_per_n
    )
}

fn show_comparison(comparison: &ShellComparison) {
    println!(
        "\nagainst {}: {} FE nodes, {} equations, {:.2} s",
        comparison.solid, comparison.n_fe_nodes, comparison.n_equations, comparison.elapsed_s
    );
    println!(
        "{} gauges ({} left out), {} places ({} passed over: held, or not wholly on the shell)",
        comparison.n_gauges,
        comparison.n_gauges_left_out,
        comparison.n_touches,
        comparison.n_touches_left_out
    );
    println!("                    median %    worst %  overall %  ratio (median)");
    show_answered(&comparison.shell);
    if let Some(coarser) = &comparison.coarser_solid {
        println!("the solid with edges twice as long instead of the shell:");
        show_answered(coarser);
    }
    println!(
        "above 10 %          readings on {:.1} % of the compared surface, displacement on {:.1} %",
        100.0 * comparison.above_good.readings_share,
        100.0 * comparison.above_good.tip_share
    );
    println!("press at, mm              shell µm/N  solid µm/N   displ. %  readings %");
    for press in comparison.presses.iter().take(SHOWN_PRESSES) {
        let [x, y, z] = press.position_m.map(|c| c * 1e3);
        let ratio = press.shell_tip_um_per_n / press.solid_tip_um_per_n;
        println!(
            "{x:7.1} {y:7.1} {z:7.1} {:12.2} {:11.2} {:+10.1} {:11.1}",
            press.shell_tip_um_per_n,
            press.solid_tip_um_per_n,
            100.0 * (ratio - 1.0),
            100.0 * press.reading_difference
        );
    }
    println!("{comparison}");
    if let Some(text) = comparison.recommendation() {
        println!("{text}");
    }
}

fn show_answered(answered: &Answered) {
    for (name, row) in [("gauge readings", &answered.readings), ("under the tip", &answered.tip)] {
        println!(
            "{name:16} {:11.1} {:10.1} {:10.1} {:15.2}",
            100.0 * row.median,
            100.0 * row.worst,
            100.0 * row.overall,
            row.median_ratio
        );
    }
}
