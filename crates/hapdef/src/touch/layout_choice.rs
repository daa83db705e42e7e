//! Layouts of gauges chosen by several methods, scored alike.

use std::time::Instant;

use hapdef_bench::stats;
use hapdef_inverse::{
    Candidates, CoverParams, InverseError, OtherLoads, PlacementParams, PlacementScore, cover,
    exchange, place_entropy, place_greedy, place_mutual_information, place_nearest_neighbours,
    place_pca_qr, place_random, placement_score, smallest_seen_n,
};
use nalgebra::Point3;

use super::layout::{CountedLayout, LayoutParams, LayoutStudy, PlacedGauge, Places, ScoredLayout};
use super::model::LimbModel;
use super::other_loads::of_response;
use super::response::TouchedSkin;
use crate::error::HapdefError;
use crate::limb::Limb;
use crate::run::Run;

/// Chooses gauges among candidates.
type Method = fn(&Candidates, &PlacementParams) -> Result<Vec<usize>, InverseError>;

/// What is shown beside greedy log-det.
const COMPARED: [(&str, Method); 4] = [
    ("entropy", place_entropy),
    ("mutual information", place_mutual_information),
    ("nearest neighbours", place_nearest_neighbours),
    ("PCA-QR", place_pca_qr),
];

const GREEDY: (&str, Method) = ("greedy log-det", place_greedy);

/// Places on the inner wall with their responses, solved once: layouts of any number of gauges are chosen among
/// them.
pub struct LayoutCandidates {
    places: Places,
    candidates: Candidates,
    params: LayoutParams,
    solve_s: f64,
}

impl LayoutCandidates {
    /// Looks at places on the inner wall and solves for the gauges that fit there, and for what they read of the
    /// scene's loads that are no contacts where these count.
    ///
    /// # Errors
    /// [`HapdefError::TooFewGaugeSites`] when the wall has too few places; [`HapdefError::Sim`];
    /// [`HapdefError::ShellTemperature`].
    pub fn solve(run: &Run, limb: &Limb, params: &LayoutParams) -> Result<Self, HapdefError> {
        let start = Instant::now();
        let model = LimbModel::build(limb, run.threads)?;
        let places = Places::find(run, &model, params)?;
        run.say(&format!("solving {} candidate gauges", places.gauges.len()));
        let (response, _) = model.response(&places.gauges)?;
        let fields = model.fields_of(&places.gauges, &response);
        let skin = TouchedSkin::new(limb, run.scene.contact.tip_radius_m)?;
        let mut candidates = places.candidates(&skin.map(places.gauges.len(), &fields)?, params)?;
        if let Some(spec) = run.scene.loads.as_ref().filter(|_| params.beside_loads) {
            let loads = of_response(&model, &places.gauges, &response, spec, 0.0)?;
            candidates.loads = by_candidate(&loads, places.gauges.len());
        }
        let solve_s = start.elapsed().as_secs_f64();
        Ok(Self { places, candidates, params: params.clone(), solve_s })
    }

    /// The layout of `n_gauges` that is recommended: greedy log-det, improved by exchange.
    ///
    /// # Errors
    /// [`HapdefError::Inverse`] when spacing and keep-out leave too few places.
    pub fn recommended(&self, n_gauges: usize) -> Result<Vec<PlacedGauge>, HapdefError> {
        let asked = placement_params(&self.places, &self.params, n_gauges);
        Ok(self.placed(&self.chosen(&asked)?))
    }

    /// That layout, its gauges moved until what is wanted is seen wherever it presses, as far as that can be had
    /// by moving them.
    ///
    /// # Errors
    /// As [`Self::recommended`].
    pub fn seeing(
        &self,
        n_gauges: usize,
        wanted: &CoverParams,
    ) -> Result<SeeingLayout, HapdefError> {
        let asked = placement_params(&self.places, &self.params, n_gauges);
        let covered = cover(&self.candidates, &self.chosen(&asked)?, &asked, wanted)?;
        let (smallest_seen_n, site) = smallest_seen_n(&self.candidates, &covered, wanted.noise_sd)?;
        Ok(SeeingLayout {
            gauges: self.placed(&covered),
            smallest_seen_n,
            faintest_m: self.candidates.sites_m[site],
            largest_change: covered.iter().map(|c| self.places.changes[*c]).fold(0.0, f64::max),
        })
    }

    fn chosen(&self, asked: &PlacementParams) -> Result<Vec<usize>, HapdefError> {
        let greedy = place_greedy(&self.candidates, asked)?;
        Ok(exchange(&self.candidates, &greedy, asked)?)
    }

    fn placed(&self, chosen: &[usize]) -> Vec<PlacedGauge> {
        chosen.iter().map(|c| self.places.placed[*c]).collect()
    }
}

/// What each candidate reads for one standard deviation of each load `[n_candidates, n_loads]`.
fn by_candidate(loads: &OtherLoads, n_candidates: usize) -> Vec<f64> {
    let of = |c: usize| (0..loads.len()).map(move |k| (k, k * n_candidates + c));
    (0..n_candidates).flat_map(of).map(|(k, i)| loads.sd[k] * loads.response[i]).collect()
}

/// A layout and the smallest force that is seen wherever it presses.
#[derive(Clone, Debug, PartialEq)]
pub struct SeeingLayout {
    /// Its gauges.
    pub gauges: Vec<PlacedGauge>,
    /// That force, N.
    pub smallest_seen_n: f64,
    /// Where no smaller one is seen, m.
    pub faintest_m: Point3<f64>,
    /// The largest part by which a gauge glued off reads something else; 0 where [`LayoutParams::max_change`] asks
    /// for nothing.
    pub largest_change: f64,
}

/// Looks at places on the inner wall and chooses layouts.
///
/// # Errors
/// Those of [`LayoutCandidates::solve`] and [`LayoutCandidates::recommended`].
pub fn study_layouts(
    run: &Run,
    limb: &Limb,
    params: &LayoutParams,
) -> Result<LayoutStudy, HapdefError> {
    let LayoutCandidates { places, candidates, solve_s, .. } =
        LayoutCandidates::solve(run, limb, params)?;
    let mut study = LayoutStudy {
        n_candidates: places.gauges.len() - places.n_own,
        n_refused: places.n_refused,
        n_loads: candidates.n_loads(),
        solve_s,
        layouts: Vec::new(),
        by_count: Vec::new(),
    };
    choose_layouts(&places, &candidates, params, &mut study)?;
    Ok(study)
}

/// Chooses and scores into `study`, the recommended layout last.
///
/// # Errors
/// [`HapdefError::Inverse`] when spacing and keep-out leave too few places.
fn choose_layouts(
    places: &Places,
    candidates: &Candidates,
    params: &LayoutParams,
    study: &mut LayoutStudy,
) -> Result<(), HapdefError> {
    let asked = placement_params(places, params, params.n_gauges);
    let mut add = |name: &str, chosen: &[usize], start: Instant| -> Result<_, HapdefError> {
        let elapsed_s = start.elapsed().as_secs_f64();
        let score = placement_score(candidates, chosen, &asked)?;
        let gauges = chosen.iter().map(|c| places.placed[*c]).collect();
        let name = name.to_owned();
        study.layouts.push(ScoredLayout { name, gauges, score, elapsed_s });
        Ok(())
    };
    let own: Vec<usize> = places.own().collect();
    add("the scene's own", &own, Instant::now())?;
    for (name, method) in compared(params) {
        let start = Instant::now();
        add(name, &method(candidates, &asked)?, start)?;
    }
    let start = Instant::now();
    let greedy = place_greedy(candidates, &asked)?;
    add(GREEDY.0, &greedy, start)?;
    let exchanged = exchange(candidates, &greedy, &asked)?;
    add("greedy log-det, exchange", &exchanged, start)?;
    let random = random_median(candidates, &asked, params)?;
    study.layouts.insert(0, random);
    study.by_count = by_count(places, candidates, params)?;
    Ok(())
}

fn compared(params: &LayoutParams) -> &'static [(&'static str, Method)] {
    if params.compares { &COMPARED } else { &[] }
}

fn by_count(
    places: &Places,
    candidates: &Candidates,
    params: &LayoutParams,
) -> Result<Vec<CountedLayout>, HapdefError> {
    let mut counts = params.other_counts.clone();
    counts.push(params.n_gauges);
    counts.sort_unstable();
    counts.dedup();
    counts.retain(|n| *n >= params.n_mounted.max(1));
    let mut all = Vec::new();
    for &(name, method) in compared(params).iter().chain([&GREEDY]) {
        for &n_gauges in &counts {
            let asked = placement_params(places, params, n_gauges);
            let chosen = method(candidates, &asked)?;
            let score = placement_score(candidates, &chosen, &asked)?;
            all.push(CountedLayout { name, n_gauges, score });
        }
    }
    Ok(all)
}

/// Medians over the random layouts, figure by figure.
fn random_median(
    candidates: &Candidates,
    asked: &PlacementParams,
    params: &LayoutParams,
) -> Result<ScoredLayout, HapdefError> {
    let start = Instant::now();
    let mut scores = Vec::with_capacity(params.n_random);
    for i in 0..params.n_random.max(1) as u64 {
        let drawn = PlacementParams { seed: params.seed.wrapping_add(i), ..asked.clone() };
        let chosen = place_random(candidates, &drawn)?;
        scores.push(placement_score(candidates, &chosen, asked)?);
    }
    let median = |of: fn(&PlacementScore) -> f64| stats::median(scores.iter().map(of));
    Ok(ScoredLayout {
        name: format!("random, median of {}", scores.len()),
        gauges: Vec::new(),
        score: PlacementScore {
            single_mean_m: median(|s| s.single_mean_m),
            single_p95_m: median(|s| s.single_p95_m),
            pair_median_m: median(|s| s.pair_median_m),
            pair_p95_m: median(|s| s.pair_p95_m),
        },
        elapsed_s: start.elapsed().as_secs_f64(),
    })
}

fn placement_params(places: &Places, params: &LayoutParams, n_gauges: usize) -> PlacementParams {
    PlacementParams {
        mounted: places.own().take(params.n_mounted).collect(),
        min_spacing_m: params.min_spacing_m,
        force_n: params.force_n,
        seed: params.seed,
        ..PlacementParams::new(n_gauges, params.noise_ue)
    }
}
