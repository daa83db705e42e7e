//! What the programs over a scene share: the arguments that name a scene and how to run it, what is
//! printed, progress on the terminal, the exit code.
//!
//! Knows nothing of what is computed: that is in `hapdef`, whose commands `main.rs` and `cli` are.

mod args;
mod error;
mod exit;
mod print;
mod progress;
mod signals;
mod training;

pub use args::{ProfileName, SceneArgs, scene_path};
pub use error::PrepareError;
pub use exit::{exit_code, shown};
pub use print::{
    JsonLines, StandardLines, StandardOutput, check_printed, is_end_of_reader, note_line,
    print_json, print_line,
};
pub use progress::{be_quiet, is_quiet, on_stderr};
pub use signals::stop_on_signals;
pub use training::{SampleArgs, TrainingArgs};
