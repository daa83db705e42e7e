//! The work of stages and frames, counted: what a plan expects, and what a stage records beside its time.

use hapdef_inverse::Calibrated;
use hapdef_nets::MlpSpec;
use hapdef_sim::FactorInfo;
use serde::{Deserialize, Serialize};

/// What is done at a rate of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum WorkKind {
    /// The compliance of the skin.
    Compliance,
    /// The rig's limb.
    Rig,
    /// The response of the gauges.
    Response,
    /// A dataset.
    Samples,
    /// Training of F_T.
    Transfer,
    /// Training of an F_R.
    Reconstruction,
    /// Training of F_S.
    Sensitivity,
    /// Training of the direct net.
    Direct,
    /// A net's pass of one sample.
    Pass,
    /// k-Max on one map.
    Kmax,
    /// The χ² test of a frame.
    Test,
    /// The search for one contact in a frame.
    Single,
    /// The search for two.
    Pair,
    /// A frame in which a contact is followed.
    Followed,
    /// A calibration.
    Calibration,
}

/// Work of one kind.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub struct Work {
    /// Its kind.
    pub kind: WorkKind,
    /// Floating-point operations.
    pub flops: f64,
    /// Bytes that are left, or read in each frame.
    pub bytes: f64,
    /// What its time is in proportion to: operations, each kind of them with its weight, or bytes; 0
    /// where no rule is known.
    pub amount: f64,
}

/// Work as it is recorded beside its time.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
pub(crate) struct DoneWork {
    #[serde(flatten)]
    pub(crate) work: Work,
    pub(crate) threads: usize,
}

/// Looks at the validation set during a training, and samples of each.
const VALIDATED: f64 = 20.0 * 1000.0;

/// Right-hand sides from which on solves count as many: they pass the factor in blocks.
const MANY_LOADS: usize = 64;

/// Right-hand sides that the first solve on a factor takes for itself, for its condition number.
const CONDITION_LOADS: usize = 24;

/// Time of an operation of a solve with many or few right-hand sides, in those of a factorisation.
const MANY_SOLVES: f64 = 0.25;
const FEW_SOLVES: f64 = 1.8;

/// Time of ordering and assembly for each FE node, in operations of a factorisation.
const NODE: f64 = 3e5;

/// The same for each node of a skin of which it is found what a tip there averages over.
const TIP: f64 = 2e6;

/// Time of a byte that is written or read, in operations of a factorisation.
const BYTE: f64 = 20.0;

/// Time of an operation of a calibration's fit, in those of a factorisation.
const FIT: f64 = 4.0;

/// Steps of refinement behind one contact, and behind two, those of the search for one included.
const STEPS: [f64; 2] = [90.0, 2400.0];

/// Time of an operation of a scan for one contact, and for two, in those of a step of refinement.
const SCAN: [f64; 2] = [6.0, 2.0];

/// Presses at most that a kernel is chosen on, and that are fitted.
const MOST_FOR_KERNEL: usize = 600;
const MOST_FITTED: usize = 4000;

/// Kernels tried for each gauge, over all rounds.
const N_KERNELS: f64 = 60.0;

impl Work {
    /// Order, assembly, factor and `n_loads` solves, given together or few at a time.
    pub(crate) fn elastic(kind: WorkKind, model: &FactorInfo, n_loads: usize) -> Self {
        let condition = Self::solves(kind, model, CONDITION_LOADS);
        let solved = condition.plus(Self::solves(kind, model, n_loads));
        let built = model.factor_flops + NODE * model.n_fe_nodes as f64;
        let is_known = f64::from(u8::from(model.nnz_l > 0));
        Self {
            flops: model.factor_flops + solved.flops,
            bytes: 8.0 * model.nnz_l as f64,
            amount: is_known * (built + solved.amount),
            ..solved
        }
    }

    /// The compliance of `n_surface` nodes at `n_wanted`, and the gauges' solves. The table is made in
    /// f64, twice the bytes, before it is written.
    pub(crate) fn compliance(
        model: &FactorInfo,
        n_surface: usize,
        n_gauges: usize,
        n_wanted: usize,
    ) -> Self {
        let elastic = Self::elastic(WorkKind::Compliance, model, n_surface + n_gauges);
        elastic.writing(3.0 * table_bytes(n_surface, n_wanted))
    }

    /// `n_loads` solves on a factor. A solve passes L twice with two operations an entry.
    pub(crate) fn solves(kind: WorkKind, model: &FactorInfo, n_loads: usize) -> Self {
        let flops = 4.0 * model.nnz_l as f64 * n_loads as f64;
        let weight = if n_loads < MANY_LOADS { FEW_SOLVES } else { MANY_SOLVES };
        Self { kind, flops, bytes: 0.0, amount: weight * flops }
    }

    /// With what a tip at each of `n_nodes` nodes of a skin averages over.
    pub(crate) fn with_tips(self, n_nodes: usize) -> Self {
        Self { amount: self.amount + TIP * n_nodes as f64, ..self }
    }

    /// With so many more bytes written.
    pub(crate) fn writing(self, bytes: f64) -> Self {
        Self { bytes: self.bytes + bytes, amount: self.amount + BYTE * bytes, ..self }
    }

    /// `n` samples of `n_contacts` at `n_nodes` nodes, written: three components of each contact's row
    /// are added, and a magnitude taken. The disk takes the time.
    pub(crate) fn samples(n: usize, n_contacts: usize, n_nodes: usize) -> Self {
        let bytes = 4.0 * (n * n_nodes) as f64;
        let flops = superposed_flops(n, n_contacts, n_nodes);
        Self { kind: WorkKind::Samples, flops, bytes, amount: bytes }
    }

    /// With a table of so many bytes read before.
    pub(crate) fn reading(self, bytes: f64) -> Self {
        Self { amount: self.amount + bytes, ..self }
    }

    /// Training of a net: two operations a parameter and sample forward, four backward, and the looks
    /// at the validation set.
    pub(crate) fn training(kind: WorkKind, net: &MlpSpec, n_samples: usize) -> Self {
        let p = net.n_parameters() as f64;
        let flops = p * (6.0 * n_samples as f64 + 2.0 * VALIDATED);
        Self { kind, flops, bytes: 4.0 * p, amount: flops }
    }

    /// With samples drawn, superposed and, where the net is trained in modes, projected on them.
    pub(crate) fn drawing(self, n: usize, n_contacts: usize, n_nodes: usize, modes: usize) -> Self {
        let projected = 2.0 * n as f64 * (n_nodes * modes) as f64;
        let flops = superposed_flops(n, n_contacts, n_nodes) + projected;
        Self { flops: self.flops + flops, amount: self.amount + flops, ..self }
    }

    /// A net's pass of one sample.
    pub(crate) fn pass(n_parameters: usize) -> Self {
        let p = n_parameters as f64;
        Self { kind: WorkKind::Pass, flops: 2.0 * p, bytes: 4.0 * p, amount: 2.0 * p }
    }

    /// k-Max on a map: as many nodes are looked at as it has.
    pub(crate) fn kmax(n_nodes: usize) -> Self {
        let n = n_nodes as f64;
        Self { kind: WorkKind::Kmax, flops: 0.0, bytes: 4.0 * n, amount: n }
    }

    /// The χ² test of a frame: whitening twice, and a sum of squares.
    pub(crate) fn test(n_gauges: usize) -> Self {
        let flops = (2 * n_gauges * n_gauges + 2 * n_gauges) as f64;
        let bytes = (8 * n_gauges * n_gauges) as f64;
        Self { kind: WorkKind::Test, flops, bytes, amount: flops }
    }

    /// A frame in which contacts are followed: one step for each of them.
    pub(crate) fn followed(n_gauges: usize) -> Self {
        let flops = step_flops(n_gauges, 1);
        Self { kind: WorkKind::Followed, flops, amount: flops, ..Self::test(n_gauges) }
    }

    /// The scan for one contact, a product of each site's row with the frame, and the refinement.
    pub(crate) fn single(n_gauges: usize, n_sites: usize) -> Self {
        let scan = (2 * n_gauges * n_sites) as f64;
        Self::search(WorkKind::Single, scan, 4 * n_gauges * n_sites, (n_gauges, 1))
    }

    /// The scan of all pairs of sites, ten operations for each, and the refinement.
    pub(crate) fn pair(n_gauges: usize, n_sites: usize) -> Self {
        let scan = (5 * n_sites * n_sites.saturating_sub(1)) as f64;
        Self::search(WorkKind::Pair, scan, 4 * n_sites * n_sites, (n_gauges, 2))
    }

    fn search(
        kind: WorkKind,
        scan: f64,
        bytes: usize,
        (n_gauges, n_contacts): (usize, usize),
    ) -> Self {
        let steps = STEPS[n_contacts - 1] * step_flops(n_gauges, n_contacts);
        let amount = SCAN[n_contacts - 1] * scan + steps;
        Self { kind, flops: scan + steps, bytes: bytes as f64, amount }
    }

    /// With a calibration's fit to `n_presses` with `n_columns` modes: for every gauge the kernels
    /// tried, each a factorisation; presses judged among some hundred others; the last solution with
    /// the inverse's diagonal and what is known at the scan sites, and once more for every part of the
    /// presses that is held out.
    pub(crate) fn fitting(
        self,
        n_presses: usize,
        n_gauges: usize,
        n_columns: usize,
        n_sites: usize,
    ) -> Self {
        let n_fitted = n_presses.min(MOST_FITTED);
        let (n, few) = (n_fitted as f64, n_fitted.min(MOST_FOR_KERNEL) as f64);
        let (columns, sites) = (n_columns as f64 + 1.0, n_sites as f64);
        let kernels = N_KERNELS * (few.powi(3) / 3.0 + few * few * columns);
        let judged = 2.0 * n * few * (few + columns);
        let solved = n.powi(3) + n * n * (columns + sites) + n * sites * sites;
        let n_solved = 1 + Calibrated::n_refits(n_fitted);
        let flops = n_gauges as f64 * (kernels + judged + n_solved as f64 * solved);
        Self { flops: self.flops + flops, amount: self.amount + FIT * flops, ..self }
    }

    /// As it is recorded.
    pub(crate) fn done(self, threads: usize) -> DoneWork {
        DoneWork { work: self, threads }
    }

    /// One after the other, as work of the first one's kind.
    pub(crate) fn plus(self, other: Self) -> Self {
        Self {
            kind: self.kind,
            flops: self.flops + other.flops,
            bytes: self.bytes + other.bytes,
            amount: self.amount + other.amount,
        }
    }
}

/// Bytes of the compliance of `n_surface` nodes at `n_wanted`.
pub(crate) fn table_bytes(n_surface: usize, n_wanted: usize) -> f64 {
    12.0 * (n_surface * n_wanted) as f64
}

fn superposed_flops(n: usize, n_contacts: usize, n_nodes: usize) -> f64 {
    n as f64 * n_nodes as f64 * (6.0 * n_contacts as f64 + 7.0)
}

/// Operations of a step of refinement: three rows of each contact, each put together from ten rows of
/// the map and whitened.
fn step_flops(n_gauges: usize, n_contacts: usize) -> f64 {
    (3 * n_contacts * (n_gauges * n_gauges + 20 * n_gauges)) as f64
}
