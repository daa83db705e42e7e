//! What a run is doing, for whoever shows it.

use std::fmt::Debug;
use std::sync::Arc;

/// Shows what a run is doing, on a [`Display`] or nowhere.
#[derive(Clone, Debug)]
pub struct Progress {
    display: Option<Arc<dyn Display>>,
}

/// Where progress is shown: a terminal, a window, a log.
pub trait Display: Debug + Send + Sync {
    /// One line of text.
    fn say(&self, text: &str);

    /// A bar for work of `n_steps` steps, which goes away when it is dropped.
    fn bar(&self, name: &str, n_steps: u64) -> Option<Box<dyn Bar>>;
}

/// A bar that is shown.
pub trait Bar: Debug + Send + Sync {
    /// Moves the bar and shows a text, such as the losses, beside it.
    fn set(&self, step: u64, text: String);
}

/// Progress of work of known length.
#[derive(Debug)]
pub struct StepBar(Option<Box<dyn Bar>>);

/// Lines on standard error.
#[derive(Debug)]
struct Lines;

impl Progress {
    /// Shown on `display`.
    pub fn on(display: impl Display + 'static) -> Self {
        Self { display: Some(Arc::new(display)) }
    }

    /// Plain lines on standard error, without bars.
    #[must_use]
    pub fn lines() -> Self {
        Self::on(Lines)
    }

    /// Shows nothing.
    #[must_use]
    pub fn silent() -> Self {
        Self { display: None }
    }

    /// One line of text.
    pub fn say(&self, text: &str) {
        if let Some(display) = &self.display {
            display.say(text);
        }
    }

    /// A bar for work of `n_steps` steps.
    #[must_use]
    pub fn bar(&self, name: &str, n_steps: u64) -> StepBar {
        StepBar(self.display.as_ref().and_then(|display| display.bar(name, n_steps)))
    }
}

impl StepBar {
    /// Moves the bar and shows a text, such as the losses, beside it.
    pub fn set(&self, step: u64, text: String) {
        if let Some(bar) = &self.0 {
            bar.set(step, text);
        }
    }
}

impl Display for Lines {
    #[expect(clippy::print_stderr, reason = "standard error is where progress goes")]
    fn say(&self, text: &str) {
        eprintln!("{}", hapdef_contact::printable_lines(text));
    }

    fn bar(&self, _: &str, _: u64) -> Option<Box<dyn Bar>> {
        None
    }
}
