//! Progress on the terminal: bars with the time left, plain lines where there is no terminal, nothing where
//! that is wanted.

use std::sync::atomic::{AtomicBool, Ordering};

use hapdef::{Bar, Display, Progress};
use hapdef_contact::printable_lines;
use indicatif::{MultiProgress, ProgressBar, ProgressStyle};

/// Whether results, warnings and errors are all that is printed.
static IS_QUIET: AtomicBool = AtomicBool::new(false);

/// From here on no progress is shown.
pub fn be_quiet() {
    IS_QUIET.store(true, Ordering::Relaxed);
}

/// Whether no progress is shown.
#[must_use]
pub fn is_quiet() -> bool {
    IS_QUIET.load(Ordering::Relaxed)
}

/// Progress on standard error; none where quiet is wanted.
#[must_use]
pub fn on_stderr() -> Progress {
    if is_quiet() {
        return Progress::silent();
    }
    Progress::on(Terminal { bars: MultiProgress::new() })
}

#[derive(Debug)]
struct Terminal {
    bars: MultiProgress,
}

#[derive(Debug)]
struct TerminalBar(ProgressBar);

impl Display for Terminal {
    fn say(&self, text: &str) {
        if self.bars.is_hidden() {
            crate::note_line(format_args!("{text}"));
        } else {
            drop(self.bars.println(printable_lines(text)));
        }
    }

    fn bar(&self, name: &str, n_steps: u64) -> Option<Box<dyn Bar>> {
        let style = "{prefix:18} {wide_bar} {pos}/{len} {eta} left  {msg}";
        let bar = self.bars.add(ProgressBar::new(n_steps));
        if let Ok(style) = ProgressStyle::with_template(style) {
            bar.set_style(style);
        }
        Some(Box::new(TerminalBar(bar.with_prefix(name.to_owned()))))
    }
}

impl Bar for TerminalBar {
    fn set(&self, step: u64, text: String) {
        self.0.set_position(step);
        self.0.set_message(text);
    }
}

impl Drop for TerminalBar {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
