//! Frames added up into one with unit noise.

/// Σ w z / √(Σ w²): noise as in one frame, forces Σ w A / √(Σ w²). Readings are linear in the forces,
/// so this holds while forces change; weights that follow a contact's force lose nothing of what
/// white noise leaves of its place.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Gathered {
    sum: Vec<f64>,
    w: f64,
    w_2: f64,
    pub(super) n_frames: usize,
}

impl Gathered {
    pub(super) fn new(width: usize) -> Self {
        Self { sum: vec![0.0; width], w: 0.0, w_2: 0.0, n_frames: 0 }
    }

    pub(super) fn clear(&mut self) {
        self.sum.fill(0.0);
        (self.w, self.w_2, self.n_frames) = (0.0, 0.0, 0);
    }

    pub(super) fn copy_from(&mut self, other: &Self) {
        self.sum.copy_from_slice(&other.sum);
        (self.w, self.w_2, self.n_frames) = (other.w, other.w_2, other.n_frames);
    }

    pub(super) fn add(&mut self, z: &[f64], weight: f64) {
        crate::dense::add_scaled(&mut self.sum, weight, z);
        self.w += weight;
        self.w_2 += weight * weight;
        self.n_frames += 1;
    }

    /// Lets what was gathered count less.
    pub(super) fn fade(&mut self, keep: f64) {
        self.sum.iter_mut().for_each(|v| *v *= keep);
        self.w *= keep;
        self.w_2 *= keep * keep;
    }

    /// The frame into `z`, and how many times larger its forces are than those of one frame.
    pub(super) fn frame(&self, z: &mut [f64]) -> f64 {
        let length = self.w_2.sqrt();
        let scale = if length > 0.0 { 1.0 / length } else { 0.0 };
        for (z, sum) in z.iter_mut().zip(&self.sum) {
            *z = sum * scale;
        }
        self.w * scale
    }
}
