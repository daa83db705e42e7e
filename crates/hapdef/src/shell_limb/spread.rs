//! Gauges spread over the inner side of a shell's wall.

use std::collections::BTreeMap;

use hapdef_mesh::{FeNodeId, PointIndex, clear_nodes, farthest_nodes, wall};
use hapdef_sim::{GaugeSite, GaugeStrain};
use nalgebra::Vector3;

use crate::error::HapdefError;
use crate::limb::{Limb, site};
use crate::scene::Scene;
use crate::touch::{PlacedGauge, gauge_entries};
use crate::wall_shell::WallShell;

/// Gives the scene `n` gauges on the inner side of the limb's wall that measure along `long_axis`, each as far
/// as possible from those before it, at least half a diagonal away from what is clamped and from rims, where
/// solid and shell carry all of its footprint. Says how many places were passed over.
///
/// # Errors
/// [`HapdefError::TooFewGaugeSites`]; [`HapdefError::Mesh`] where the skin has no wall behind it.
pub(super) fn spread_gauges(
    scene: &mut Scene,
    limb: &Limb,
    long_axis: Vector3<f64>,
    n: usize,
) -> Result<usize, HapdefError> {
    let keep_off_m = 0.5 * scene.gauges.length_m.hypot(scene.gauges.width_m);
    let behind = wall(&limb.mesh, &limb.boundary, &limb.skin, limb.max_wall_m)?;
    let held: Vec<_> = limb.clamped.iter().map(|node| limb.mesh.position(*node)).collect();
    let held = PointIndex::new(&held);
    let is_off_mount = |node: &FeNodeId| {
        held.nearest(&limb.mesh.position(*node)).is_none_or(|(_, d)| d >= keep_off_m)
    };
    let mut open = clear_nodes(&limb.mesh, &behind.inner_faces, keep_off_m);
    open.retain(is_off_mount);
    let n_candidates = open.len();
    let gauge_at = |node: FeNodeId| {
        let on_solid = |site: &GaugeSite| {
            let faces = &limb.boundary.faces;
            GaugeStrain::with_params(&limb.mesh, faces, site, &limb.gauge_params).ok()
        };
        let at_node = scene.gauges.site(limb.mesh.position(node), long_axis);
        let axis = on_solid(&at_node)?.axis();
        let placed = PlacedGauge { position_m: at_node.position, axis };
        // A footprint beside a rim may miss the wall once its place is rounded as the scene has it.
        let site = site(gauge_entries(&[placed]).first()?, scene);
        let on_shell = |shell: &WallShell| shell.gauge(&site, &limb.material, 0.0).is_ok();
        let is_whole = on_solid(&site)?.lost_share() == 0.0 && limb.shell.iter().all(on_shell);
        is_whole.then_some(placed)
    };
    let mut found = BTreeMap::new();
    loop {
        let chosen = farthest_nodes(&limb.mesh, &open, n);
        for node in &chosen {
            found.entry(*node).or_insert_with(|| gauge_at(*node));
        }
        let gauges: Vec<_> = chosen.iter().filter_map(|node| found[node]).collect();
        let n_passed_over = n_candidates - open.len();
        if gauges.len() == n {
            scene.gauges.sites = gauge_entries(&gauges);
            return Ok(n_passed_over);
        }
        if gauges.len() == chosen.len() {
            let (n_gauges, n_found) = (n, gauges.len());
            return Err(HapdefError::TooFewGaugeSites {
                n_gauges,
                n_found,
                n_candidates,
                n_passed_over,
            });
        }
        open.retain(|node| !matches!(found.get(node), Some(None)));
    }
}
