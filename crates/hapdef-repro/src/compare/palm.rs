//! A palm: a contact as wide as a hand, which is to be one contact and not several.

use anyhow::Result;
use hapdef_bench::stats::{quantile, sorted};
use hapdef_inverse::{
    ContactEstimate, ContactEstimator, EstimatorParams, LocatedContact, Skin, WideParams,
};
use serde::Serialize;

use super::cells::score;
use super::rig::Layout;
use super::score::{Row, Score};
use super::setup::Bench;
use super::world::Frame;

/// Radius of the palm, between two of those that are tried, and its force.
const PALM_M: f64 = 0.02;
const PALM_N: f64 = 20.0;

/// A palm is clean that is found as one contact, so near and with so small an error of its force.
const CLEAN_M: f64 = 3e-3;
const CLEAN_SHARE: f64 = 0.1;

/// Palms, and contacts of the scene's tip, where a wide contact may be found.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Palms {
    /// Palms that are clean, %.
    pub(super) clean_pct: f64,
    /// The same where only narrow contacts are looked for.
    pub(super) narrow_clean_pct: f64,
    /// Median error of the radius of the palms that are found as wide, mm.
    pub(super) radius_error_mm: f64,
    /// Single contacts that are taken for wide ones, %, and pairs.
    pub(super) single_wide_pct: f64,
    pub(super) double_wide_pct: f64,
}

/// What is found in frames of one kind.
#[derive(Default)]
struct Found {
    score: Score,
    n_frames: usize,
    n_clean: usize,
    radii_m: Vec<f64>,
}

impl Bench<'_> {
    /// Rows of palms by narrow contacts alone and with a wide one, and of single contacts and pairs with a wide one.
    pub(super) fn palms(&mut self) -> Result<(Palms, [Row; 5])> {
        self.run.say("palm");
        let (drawn, n) = (self.drawn(), self.args.frames);
        let palms = drawn.alike(n, PALM_N, PALM_M)?;
        let fingertips = drawn.alike(n, PALM_N, 0.5 * PALM_M)?;
        let [singles, doubles] = [drawn.singles(n)?, drawn.doubles(n)?];
        let (params, presses) = (self.params(), self.args.presses);
        let wide = WideParams::up_to(PALM_M, self.run.scene.contact.tip_radius_m);
        let map = self.map(Layout::Scene, presses)?;
        let channels = map.channels.clone();
        let alone = map.estimator(params)?;
        let both = map.estimator(EstimatorParams { wide, ..params })?;
        let found = |frames: &[Frame], estimator: &ContactEstimator| {
            let mut found = Found::default();
            let also =
                |_: &ContactEstimator, _: &[f64], frame: &Frame, estimate: &ContactEstimate| {
                    found.add(frame, estimate, estimator.map().skin());
                    Ok(())
                };
            found.score = score(estimator, channels.clone(), frames, also)?;
            Ok::<_, anyhow::Error>(found)
        };
        let narrow = found(&palms, &alone)?;
        let [palms, fingertips] = [found(&palms, &both)?, found(&fingertips, &both)?];
        let [singles, doubles] = [found(&singles, &both)?, found(&doubles, &both)?];
        let off_mm = palms.radii_m.iter().map(|radius_m| (radius_m - PALM_M).abs() * 1e3);
        let measured = Palms {
            clean_pct: palms.share(palms.n_clean),
            narrow_clean_pct: narrow.share(narrow.n_clean),
            radius_error_mm: quantile(&sorted(off_mm), 0.5),
            single_wide_pct: singles.share(singles.radii_m.len()),
            double_wide_pct: doubles.share(doubles.radii_m.len()),
        };
        let rows = [
            narrow.score.row("palm, narrow contacts alone"),
            palms.score.row("palm"),
            fingertips.score.row("palm of half the radius"),
            singles.score.row("single, a wide one allowed"),
            doubles.score.row("double, a wide one allowed"),
        ];
        Ok((measured, rows))
    }
}

impl Found {
    fn add(&mut self, frame: &Frame, estimate: &ContactEstimate, skin: &Skin) {
        self.n_frames += 1;
        if let [found] = estimate.contacts[..] {
            self.radii_m.extend(found.radius.map(|radius| radius.radius_m));
            self.n_clean += usize::from(is_clean(frame, &found, skin));
        }
    }

    /// So many of the frames, %.
    fn share(&self, n: usize) -> f64 {
        100.0 * n as f64 / self.n_frames.max(1) as f64
    }
}

fn is_clean(frame: &Frame, found: &LocatedContact, skin: &Skin) -> bool {
    let [truth] = &frame.contacts[..] else { return false };
    (found.position_m - skin.position(&truth.point)).norm() <= CLEAN_M
        && (found.force_n - truth.force_n).abs() <= CLEAN_SHARE * truth.force_n
}
