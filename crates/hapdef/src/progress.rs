//! Progress on the terminal; silent bars where there is none.

use indicatif::{MultiProgress, ProgressBar, ProgressStyle};

/// Shows what a run is doing. Bars with time left on a terminal; plain lines elsewhere.
#[derive(Clone, Debug)]
pub struct Progress {
    bars: Option<MultiProgress>,
}

/// Progress of one training.
#[derive(Debug)]
pub struct TrainingBar(Option<ProgressBar>);

impl Progress {
    /// Writes to standard error.
    #[must_use]
    pub fn on_stderr() -> Self {
        Self { bars: Some(MultiProgress::new()) }
    }

    /// Shows nothing.
    #[must_use]
    pub fn silent() -> Self {
        Self { bars: None }
    }

    /// One line of text.
    #[expect(clippy::print_stderr, reason = "standard error is where progress goes")]
    pub fn say(&self, text: &str) {
        match &self.bars {
            Some(bars) if bars.is_hidden() => eprintln!("{text}"),
            Some(bars) => drop(bars.println(text)),
            None => {}
        }
    }

    /// A bar for a training of `n_steps` steps.
    #[must_use]
    pub fn training(&self, name: &str, n_steps: u64) -> TrainingBar {
        let style = "{prefix:18} {wide_bar} {pos}/{len} {eta} left  {msg}";
        TrainingBar(self.bars.as_ref().map(|bars| {
            let bar = bars.add(ProgressBar::new(n_steps));
            if let Ok(style) = ProgressStyle::with_template(style) {
                bar.set_style(style);
            }
            bar.with_prefix(name.to_owned())
        }))
    }
}

impl TrainingBar {
    /// Moves the bar and shows a text, such as the losses, beside it.
    pub fn set(&self, step: u64, text: String) {
        if let Some(bar) = &self.0 {
            bar.set_position(step);
            bar.set_message(text);
        }
    }
}

impl Drop for TrainingBar {
    fn drop(&mut self) {
        if let Some(bar) = &self.0 {
            bar.finish_and_clear();
        }
    }
}
