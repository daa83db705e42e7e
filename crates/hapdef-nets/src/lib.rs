//! The four networks of HapDefX: architecture, training, checkpoints, and a lean forward pass.
