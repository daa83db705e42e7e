//! How many gauges a new limb gets, and where.

use hapdef_inverse::CoverParams;
use hapdef_live::BLIND_SHARE;

use crate::error::HapdefError;
use crate::limb::Limb;
use crate::run::Run;
use crate::touch::{LayoutCandidates, LayoutParams, PlacedGauge, SeeingLayout};

/// Gauges where no number is stated: as many as the demonstration limb has, and more, two at a time, where that many
/// leave a place blind; where 16 do so, too, the place is at the mount, and no gauge feels what it takes.
const USUAL: usize = 10;
const MOST: usize = 16;

/// Places that are looked at for gauges, half as many as `hapdef place` does.
const N_POSITIONS: usize = 80;

/// A layout must see a force this much smaller than the one that `live` asks for: noise has the steps of the
/// converter on top, and the limb is not quite as drawn.
const MARGIN: f64 = 0.8;

/// What a gauge may read wrong when it is glued a millimetre or 3° off, as a part of what it should: of ten gauges
/// on a lower leg of 27 mm one with 0.94 read with the wrong sign, so that no calibration took it; those with up to
/// 0.26 calibrate well.
const MAX_CHANGE: f64 = 0.4;

/// The gauges of a new limb, `n_stated` of them if that is stated, and what is said of them.
///
/// # Errors
/// As [`LayoutCandidates::solve`].
pub(super) fn placed(
    run: &Run,
    limb: &Limb,
    n_stated: Option<usize>,
) -> Result<(Vec<PlacedGauge>, String), HapdefError> {
    let estimator = run.scene.estimator.superposition();
    let params = LayoutParams {
        n_gauges: n_stated.unwrap_or(USUAL),
        n_positions: N_POSITIONS,
        n_sites: estimator.n_sites,
        max_change: MAX_CHANGE,
        ..LayoutParams::default()
    };
    let asked_n = BLIND_SHARE * run.scene.contact.force_range_n[1];
    let wanted = CoverParams { noise_sd: estimator.noise_ue, force_n: MARGIN * asked_n };
    let candidates = LayoutCandidates::solve(run, limb, &params)?;
    let counts: Vec<usize> = match n_stated {
        Some(n_gauges) => vec![n_gauges],
        None => (USUAL..=MOST).step_by(2).collect(),
    };
    let mut layouts = Vec::new();
    for n_gauges in counts {
        let layout = candidates.seeing(n_gauges, &wanted)?;
        let is_enough = layout.smallest_seen_n <= wanted.force_n;
        layouts.push(layout);
        if is_enough {
            break;
        }
    }
    let layout = fewest(layouts, &[wanted.force_n, asked_n]);
    let said = said(&layout, asked_n, n_stated.is_some());
    Ok((layout.gauges, said))
}

/// The layout of fewest gauges that sees one of `forces_n`, the first of them that any layout sees; the first
/// layout where more gauges don't help.
fn fewest(mut layouts: Vec<SeeingLayout>, forces_n: &[f64]) -> SeeingLayout {
    let sees = |force_n: &f64| layouts.iter().position(|l| l.smallest_seen_n <= *force_n);
    let chosen = forces_n.iter().find_map(sees).unwrap_or(0);
    layouts.swap_remove(chosen)
}

fn said(layout: &SeeingLayout, asked_n: f64, is_stated: bool) -> String {
    let (n, seen_n) = (layout.gauges.len(), layout.smallest_seen_n);
    if seen_n <= asked_n {
        let why = if n > USUAL && !is_stated { ", so many that no place is blind" } else { "" };
        return format!(
            "{n} gauges on the inner wall, where they tell most{why}: {seen_n:.1} N shows anywhere"
        );
    }
    let [x, y, z] = (layout.faintest_m.coords * 1e3).into();
    format!(
        "{n} gauges on the inner wall, where they tell most; less than {seen_n:.1} N at ({x:.0}, {y:.0}, {z:.0}) mm \
         may go unseen, and where {asked_n:.1} N may, live never says that nothing touches: give more by --gauges, \
         or leave such places out by contact.region"
    )
}
