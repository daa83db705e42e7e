//! The paper's baselines, tables and figures.
