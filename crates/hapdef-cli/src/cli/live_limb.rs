//! A limb that `hapdef live` follows, from its start to its last words.

use std::io::{BufWriter, Write};

use anyhow::Result;
use hapdef_cli::{JsonLines, StandardLines, StandardOutput};
use hapdef_contact::printable;
use hapdef_live::sinks::{AlertSink, CsvSink, JsonServer, JsonSink, TextSink};
use hapdef_live::{Health, Live, LiveBuilder, LiveError};

use super::files::new_file;
use super::live_args::LiveArgs;
use super::live_end::{goes_on, report};
use super::live_model::Model;
use super::live_record::{LiveRecorder, LiveRecorderState};
use super::view::{FirstPaint, PageSession, Reach};

/// A limb with its runtime.
pub(super) struct RunningLimb {
    /// What its lines begin with.
    begin: String,
    live: Live,
    recorder: Option<LiveRecorder>,
    page: Option<PageSession>,
    is_failure_told: bool,
}

/// A limb whose runtime has ended.
pub(super) struct StoppedLimb {
    begin: String,
    health: Result<Health, LiveError>,
    recorder: Option<LiveRecorder>,
}

/// What a limb is given beside its arguments.
#[derive(Default)]
pub(super) struct Beside {
    /// Where JSON lines are sent, too.
    pub(super) server: Option<JsonServer>,
    /// Who is told to stop.
    pub(super) alert: Option<AlertSink<Box<dyn Write + Send>>>,
    /// What measures the page.
    pub(super) first: Option<FirstPaint>,
}

impl RunningLimb {
    /// Starts the runtime, the recording and the page.
    pub(super) fn start(args: &LiveArgs, mut model: Model, beside: Beside) -> Result<Self> {
        let view = model.view.take();
        let (sim, player) = (model.source.sim.take(), model.source.player.take());
        let (builder, recorder) = model.builder(args)?;
        let mut builder = with_sinks(builder, args, beside.server)?;
        if let Some(view) = &view {
            builder = builder.sink(view.sink(args.is_recorded()));
        }
        if let Some(alert) = beside.alert {
            builder = builder.sink(alert);
        }
        let live = builder.start()?;
        let reach = Reach { sim, recorder: recorder.clone(), player };
        let page = view.map(|view| view.attend(live.control(), reach, beside.first));
        Ok(Self { begin: args.begin(), live, recorder, page, is_failure_told: false })
    }

    /// Whether there is something to wait for.
    pub(super) fn goes_on(&self) -> bool {
        goes_on(&self.live)
    }

    /// Tells of a recording that stopped; a page tells by itself.
    pub(super) fn look(&mut self) {
        if self.is_failure_told || self.page.is_some() {
            return;
        }
        let state = self.recorder.as_ref().map(LiveRecorder::state);
        if let Some(LiveRecorderState::Failed { why }) = state {
            // Nobody may read it any more: what becomes of the recording is said in the end, too.
            eprintln!("{}the recording stopped: {}", self.begin, printable(&why));
            self.is_failure_told = true;
        }
    }

    /// Ends the runtime; what was recorded is still to be written.
    pub(super) fn stop(self) -> StoppedLimb {
        drop(self.page);
        StoppedLimb { begin: self.begin, health: self.live.stop(), recorder: self.recorder }
    }
}

impl StoppedLimb {
    /// Ends the recording and says how it was.
    pub(super) fn end(self) -> Result<()> {
        let health = self.health?;
        let recorded = self.recorder.map_or(Ok(None), |recorder| recorder.finish())?;
        if let Some(recorded) = recorded {
            eprintln!("{}{}", self.begin, printable(&recorded));
        }
        report(&self.begin, &health)
    }
}

fn with_sinks(
    mut builder: LiveBuilder,
    args: &LiveArgs,
    server: Option<JsonServer>,
) -> Result<LiveBuilder> {
    if let Some(server) = server {
        builder = match &args.limb {
            Some(name) => builder.sink(server.of_limb(name)),
            None => builder.sink(server),
        };
    }
    if let Some(path) = &args.csv {
        let file = new_file(path, "--csv")?;
        builder = builder.sink(CsvSink::new(BufWriter::new(file)));
    }
    let is_terminal = StandardOutput.is_terminal();
    Ok(match (&args.limb, args.json) {
        (None, true) => builder.sink(JsonSink::new(JsonLines(StandardLines::default()))),
        (Some(name), true) => {
            builder.sink(JsonSink::new(JsonLines(StandardLines::default())).of_limb(name))
        }
        (None, false) if is_terminal => builder.sink(TextSink::refreshed(StandardOutput)),
        (None, false) => builder.sink(TextSink::lines(StandardLines::default())),
        (Some(name), false) if is_terminal => {
            builder.sink(TextSink::refreshed(StandardLines::default()).of_limb(name))
        }
        (Some(name), false) => {
            builder.sink(TextSink::lines(StandardLines::default()).of_limb(name))
        }
    })
}
