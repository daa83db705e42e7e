//! Laws of the preconditioner.
