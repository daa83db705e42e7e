//! Progress on the terminal: bars with the time left, plain lines where there is no terminal.

use hapdef::{Bar, Display, Progress};
use hapdef_contact::printable_lines;
use indicatif::{MultiProgress, ProgressBar, ProgressStyle};

/// Progress on standard error.
#[must_use]
pub fn on_stderr() -> Progress {
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
