//! Outputs by their first modes: a wide last layer is trained as a narrow one, and unfolded after.

use rayon::prelude::*;

use crate::error::{NetsError, check_length};
use crate::mlp::{Layer, Mlp};
use crate::net::{Net, Scale};
use crate::rows::{Rows, dot};
use crate::train::gemm32::multiply;
use crate::train::source::{BatchSource, SourceError};
use crate::train::view::View;

/// Rounds of the subspace iteration.
const ROUNDS: usize = 4;

/// The modes in which samples' outputs vary most (proper orthogonal decomposition; L. Sirovich,
/// "Turbulence and the dynamics of coherent structures", Quart. Appl. Math. 45, 1987).
///
/// With standardised outputs y `[n_out]` and orthonormal modes B `[n_out, rank]` the coordinates are
/// z = √(rank / n_out) Bᵀ y. The mean square of an error in z is the mean square of the same error in
/// y, so a net that is trained to z has the loss, and by the chain rule the derivatives, of the net
/// that [`OutputModes::unfold`] makes of it, up to the share of y that the modes leave out. Its last
/// layer has rank instead of n_out rows.
#[derive(Debug, Clone, PartialEq)]
pub struct OutputModes {
    rank: usize,
    /// √(rank / n_out) B, `[n_out, rank]`.
    project: Vec<f32>,
    scale: Scale,
    left_out: f64,
}

/// Samples with their outputs as coordinates of [`OutputModes`].
pub struct InModes<'a> {
    modes: &'a OutputModes,
    samples: &'a mut dyn BatchSource,
    y: Vec<f32>,
}

impl OutputModes {
    /// The first `rank` modes of the outputs of the samples `rows`, standardised by `scale`, by
    /// subspace iteration (G. Golub and C. Van Loan, Matrix Computations, 4th ed., section 8.2.4).
    /// They depend on the samples alone, on any number of threads.
    ///
    /// # Errors
    /// A rank of 0 or above the number of outputs or of rows, a scale of another width, and a source
    /// that fails.
    pub fn of_samples(
        samples: &mut dyn BatchSource,
        rows: &[usize],
        scale: &Scale,
        rank: usize,
    ) -> Result<Self, NetsError> {
        let (n, n_out) = (rows.len(), samples.n_outputs());
        check_length("scale of the outputs", n_out, scale.width())?;
        let most = n.min(n_out);
        if !(1..=most).contains(&rank) {
            return Err(NetsError::Rank { rank, most });
        }
        let y = standardised(samples, rows, scale)?;
        let modes = subspace(&y, n, n_out, rank);
        let shrink = (rank as f64 / n_out as f64).sqrt();
        let cells = (0..n_out).flat_map(|o| (0..rank).map(move |r| (o, r)));
        let project: Vec<f32> = cells.map(|(o, r)| (shrink * modes.row(r)[o]) as f32).collect();
        let left_out = left_out(&y, &project, [n, n_out, rank]);
        Ok(Self { rank, project, scale: scale.clone(), left_out })
    }

    /// How many modes.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// Share of the standardised outputs' squares that the modes leave out, on the samples they were
    /// found with.
    pub fn left_out(&self) -> f64 {
        self.left_out
    }

    /// `samples` with their outputs as coordinates.
    pub fn source<'a>(&'a self, samples: &'a mut dyn BatchSource) -> InModes<'a> {
        InModes { modes: self, samples, y: Vec::new() }
    }

    /// The net of all outputs, raw units, that a net of coordinates stands for: its last layer is
    /// y = √(n_out / rank) B z.
    ///
    /// # Errors
    /// A net of another number of outputs, or one that scales them.
    pub fn unfold(&self, net: &Net) -> Result<Net, NetsError> {
        let (rank, n_out) = (self.rank, self.scale.width());
        let mlp = net.mlp();
        check_length("outputs of a net of coordinates", rank, mlp.spec().outputs)?;
        if *net.output_scale() != Scale::identity(rank) {
            return Err(NetsError::ScaledCoordinates);
        }
        let mut layers = mlp.layers().to_vec();
        if let Some(last) = layers.last_mut() {
            *last = self.unfolded(last, n_out);
        }
        let mut spec = mlp.spec().clone();
        spec.outputs = n_out;
        let mlp = Mlp::from_layers(&spec, layers)?;
        Net::new(mlp, net.input_scale().clone(), self.scale.clone())
    }

    fn unfolded(&self, layer: &Layer, n_out: usize) -> Layer {
        let (rank, n_in) = (self.rank, layer.weights.len() / self.rank);
        let stretch = n_out as f32 / rank as f32;
        let expand: Vec<f32> = self.project.iter().map(|p| p * stretch).collect();
        let expand = View::new(&expand, n_out, rank);
        let mut weights = vec![0.0; n_out * n_in];
        multiply(expand, View::new(&layer.weights, rank, n_in), &mut weights);
        let mut bias = vec![0.0; n_out];
        multiply(expand, View::new(&layer.bias, rank, 1), &mut bias);
        Layer { weights, bias }
    }
}

impl BatchSource for InModes<'_> {
    fn n_samples(&self) -> usize {
        self.samples.n_samples()
    }

    fn is_endless(&self) -> bool {
        self.samples.is_endless()
    }

    fn n_inputs(&self) -> usize {
        self.samples.n_inputs()
    }

    fn n_outputs(&self) -> usize {
        self.modes.rank
    }

    fn fill(&mut self, rows: &[usize], x: &mut [f32], y: &mut [f32]) -> Result<(), SourceError> {
        let n_out = self.modes.scale.width();
        self.y.resize(rows.len() * n_out, 0.0);
        self.samples.fill(rows, x, &mut self.y)?;
        let samples = self.y.par_chunks_mut(n_out);
        samples.for_each(|y| self.modes.scale.apply(y));
        let project = View::new(&self.modes.project, n_out, self.modes.rank);
        multiply(View::new(&self.y, rows.len(), n_out), project, y);
        Ok(())
    }
}

/// Standardised outputs of the samples `rows`, `[rows.len(), n_out]`.
fn standardised(
    samples: &mut dyn BatchSource,
    rows: &[usize],
    scale: &Scale,
) -> Result<Vec<f32>, NetsError> {
    let mut x = vec![0.0; rows.len() * samples.n_inputs()];
    let mut y = vec![0.0; rows.len() * samples.n_outputs()];
    let filled = samples.fill(rows, &mut x, &mut y);
    filled.map_err(|source| NetsError::Samples { step: 0, source })?;
    scale.apply(&mut y);
    Ok(y)
}

/// Orthonormal modes `[rank, width]` that span the first right singular vectors of `y` `[n, width]`.
fn subspace(y: &[f32], n: usize, width: usize, rank: usize) -> Rows {
    let y = View::new(y, n, width);
    let mut modes = Rows::random_orthonormal(rank, width);
    let (mut shares, mut next) = (vec![0.0; n * rank], vec![0.0; rank * width]);
    for _ in 0..ROUNDS {
        let present: Vec<f32> = modes.iter().flatten().map(|&v| v as f32).collect();
        multiply(y, View::new(&present, rank, width).t(), &mut shares);
        multiply(View::new(&shares, n, rank).t(), y, &mut next);
        modes = Rows::of(rank, width, &next);
        modes.orthonormalise();
    }
    modes
}

fn left_out(y: &[f32], project: &[f32], [n, n_out, rank]: [usize; 3]) -> f64 {
    let mut z = vec![0.0; n * rank];
    let y_view = View::new(y, n, n_out);
    multiply(y_view, View::new(project, n_out, rank), &mut z);
    let squares = |values: &[f32]| {
        let values: Vec<f64> = values.iter().map(|&v| f64::from(v)).collect();
        dot(&values, &values)
    };
    let (all, kept) = (squares(y), squares(&z) * n_out as f64 / rank as f64);
    if all > 0.0 { (1.0 - kept / all).max(0.0) } else { 0.0 }
}
