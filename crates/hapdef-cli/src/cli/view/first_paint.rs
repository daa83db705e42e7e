//! When the page first showed what it is for, as figures.

use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

use anyhow::Result;
use hapdef_report::{MetricContext, MetricLog};
use hapdef_view::ClientInfo;

/// Where figures of the page's first pictures go, and from when they are counted.
pub(crate) struct FirstPaintParams {
    /// The program's start.
    pub(crate) start: Instant,
    /// Where people see them.
    pub(crate) out: fn() -> Box<dyn Write>,
    /// The file of figures.
    pub(crate) metrics: PathBuf,
    /// Seed of what is shown.
    pub(crate) seed: u64,
}

/// The page's first pictures; what never came is reported when it is dropped, however the program ends.
pub(crate) struct FirstPaint {
    params: FirstPaintParams,
    steps: [Step; 2],
}

/// A picture that is waited for.
struct Step {
    name: &'static str,
    what: &'static str,
    /// Number of the first frame that has it.
    frame: Option<u64>,
    is_told: bool,
}

impl FirstPaint {
    pub(crate) fn new(params: FirstPaintParams) -> Self {
        let step = |name, what| Step { name, what, frame: None, is_told: false };
        Self {
            params,
            steps: [
                step("view.first_picture_s", "no contact was drawn"),
                step("view.first_colours_s", "no contact was drawn with colours"),
            ],
        }
    }

    /// A frame with that number was handed to the page.
    pub(super) fn shown(&mut self, number: u64, has_contact: bool, has_colours: bool) {
        let has = [has_contact, has_contact && has_colours];
        for (step, _) in self.steps.iter_mut().zip(has).filter(|(_, has)| *has) {
            step.frame.get_or_insert(number);
        }
    }

    /// Tells what a page has drawn by now for the first time.
    pub(super) fn look(&mut self, pages: &[ClientInfo]) -> Result<()> {
        let Some(drawn) = pages.iter().map(|page| page.last_drawn).max() else {
            return Ok(());
        };
        let is_new = |step: &&mut Step| !step.is_told && step.frame.is_some_and(|it| it <= drawn);
        for step in self.steps.iter_mut().filter(is_new) {
            step.is_told = true;
            let elapsed_s = self.params.start.elapsed().as_secs_f64();
            let rounded_s = (100.0 * elapsed_s).round() / 100.0;
            self.params.tell(|log| Ok(log.value(step.name, rounded_s, "s")?))?;
        }
        Ok(())
    }
}

impl Drop for FirstPaint {
    fn drop(&mut self) {
        for step in self.steps.iter().filter(|step| !step.is_told) {
            let reported = self.params.tell(|log| Ok(log.skipped(step.name, step.what)?));
            if let Err(error) = reported {
                eprintln!("{}: {error:#}", step.name);
            }
        }
    }
}

impl FirstPaintParams {
    /// A line of its own among whatever else is printed, and a record in the file.
    fn tell(
        &self,
        figure: impl FnOnce(&mut MetricLog<Box<dyn Write>>) -> Result<()>,
    ) -> Result<()> {
        let mut out = (self.out)();
        writeln!(out)?;
        let mut log = MetricLog::new(out, MetricContext::here(self.seed));
        figure(&mut log)?;
        Ok(log.append_to(&self.metrics)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hapdef_report::MetricRecord;

    fn page(last_drawn: u64) -> ClientInfo {
        ClientInfo { n_sent: 9, n_taken: 9, last_drawn, n_skipped: 0 }
    }

    #[test]
    fn the_clock_stops_when_a_contact_is_drawn_not_when_it_is_sent() {
        let folder = tempfile::tempdir().unwrap();
        let metrics = folder.path().join("metrics.json");
        let lines = || -> Vec<String> {
            let bytes = std::fs::read(&metrics).unwrap_or_else(|_| b"[]".to_vec());
            let records: Vec<MetricRecord> = serde_json::from_slice(&bytes).unwrap();
            records.into_iter().map(|record| record.line()).collect()
        };
        let mut first = FirstPaint::new(FirstPaintParams {
            start: Instant::now(),
            out: || Box::new(std::io::sink()),
            metrics: metrics.clone(),
            seed: 1,
        });
        first.shown(1, false, false);
        first.look(&[page(1)]).unwrap();
        first.shown(2, false, true);
        first.shown(3, true, false);
        first.look(&[page(2), page(0)]).unwrap();
        assert_eq!(lines(), Vec::<String>::new());
        first.look(&[page(2), page(3)]).unwrap();
        first.look(&[page(4)]).unwrap();
        assert_eq!(lines().len(), 1);
        assert!(lines()[0].starts_with("METRIC:view.first_picture_s:"));
        drop(first);
        assert_eq!(
            lines()[1],
            "METRIC:view.first_colours_s:skipped:no contact was drawn with colours"
        );
    }
}
