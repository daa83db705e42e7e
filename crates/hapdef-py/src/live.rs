//! Live contacts as an iterator.

use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use hapdef::touch::{LiveEstimator, live_estimator};
use hapdef::{Limb, Run, SourceArg, VirtualRigParams, live_limb, random_presses, virtual_device};
use hapdef_daq::source::{FrameSource, StreamParams, StreamSource};
use hapdef_live::{Delivery, FnSink, Live, LiveFrame, LiveGauge, LiveParams, Wants};
use hapdef_rig::live::{RigLink, RunParams};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::error::{Fault, HapdefError, raised};
use crate::live_frame::PyLiveFrame;
use crate::setup::Setup;

/// Frames that wait for Python at most.
const N_WAITING: usize = 4096;

/// How often Python is asked whether someone pressed Ctrl-C.
const LOOK: Duration = Duration::from_millis(50);

/// What is to be played or read.
pub(crate) struct LiveRequest {
    pub choice: LiveEstimator,
    /// Length of a play of the simulated rig, s; endless if `None`.
    pub seconds: Option<f64>,
    pub tare_s: f64,
    /// Seed of its presses.
    pub seed: u64,
}

/// A running stream of frames; an iterator that ends with its source. Leaving a `with` block, or
/// `close()`, ends it.
#[pyclass(frozen, module = "hapdef", name = "Live")]
pub struct PyLive {
    running: Mutex<Option<Running>>,
    source: String,
}

/// The frames come first: dropping them sets free what waits to hand on another.
struct Running {
    frames: Receiver<LiveFrame>,
    live: Live,
}

/// What is read, and how.
struct Opened {
    source: Box<dyn FrameSource>,
    params: LiveParams,
}

#[pymethods]
impl PyLive {
    /// Name of the source.
    #[getter]
    fn source(&self) -> &str {
        &self.source
    }

    /// Takes a new tare of the next frames, which must be untouched.
    fn tare(&self) {
        self.with(|running| running.live.control().tare());
    }

    /// Counts since the start: frames, lost, dropped, refused, and the 99th percentile of the
    /// computing time in µs; `None` when it is closed.
    fn health<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, pyo3::types::PyDict>>> {
        let Some(health) = self.with(|running| running.live.health()) else {
            return Ok(None);
        };
        let dict = pyo3::types::PyDict::new(py);
        dict.set_item("n_frames", health.n_frames)?;
        dict.set_item("n_lost", health.n_lost)?;
        dict.set_item("n_dropped", health.n_dropped)?;
        dict.set_item("n_refused", health.n_refused)?;
        dict.set_item("compute_p99_us", health.total.compute.p99_us)?;
        Ok(Some(dict))
    }

    /// Ends it.
    fn close(&self, py: Python<'_>) {
        let running = self.running().take();
        py.detach(|| drop(running));
    }

    fn __iter__(slf: Bound<'_, Self>) -> Bound<'_, Self> {
        slf
    }

    fn __next__(&self, py: Python<'_>) -> PyResult<Option<PyLiveFrame>> {
        loop {
            match py.detach(|| self.next()) {
                Some(Ok(frame)) => return Ok(Some(PyLiveFrame::new(frame))),
                Some(Err(RecvTimeoutError::Timeout)) => py.check_signals()?,
                Some(Err(RecvTimeoutError::Disconnected)) => return self.end().map(|()| None),
                None => return Ok(None),
            }
        }
    }

    fn __enter__(slf: Bound<'_, Self>) -> Bound<'_, Self> {
        slf
    }

    #[pyo3(signature = (*_raised))]
    fn __exit__(&self, py: Python<'_>, _raised: &Bound<'_, pyo3::types::PyTuple>) {
        self.close(py);
    }
}

impl PyLive {
    /// Starts a stream from `source`, or from the scene's simulated rig.
    pub(crate) fn start(
        py: Python<'_>,
        setup: &Setup,
        limb: &Arc<Limb>,
        source: Option<&str>,
        request: LiveRequest,
    ) -> PyResult<Self> {
        let arg: Option<SourceArg> = source
            .map(|text| text.parse().map_err(|e| PyValueError::new_err(format!("source: {e}"))))
            .transpose()?;
        let choice = request.choice;
        let (opened, estimator) = setup.work(py, limb, move |run, limb| {
            let opened = match arg {
                Some(arg) => of_source(&arg, limb, &request)?,
                None => of_rig(run, limb, &request)?,
            };
            Ok((opened, live_estimator(run, limb, choice)?))
        })?;
        let name = opened.source.name();
        let (sender, frames) = sync_channel(N_WAITING);
        let sink = FnSink::new("python", Wants::ALL, move |frame: &LiveFrame| {
            // Nobody listens any more when it was closed.
            let _ = sender.send(frame.clone());
        });
        let sites = setup.scene.gauges.sites.iter();
        let gauge = |name: &str| LiveGauge { name: name.to_owned(), scale: 1.0 };
        let params = LiveParams {
            noise_ue: Some(setup.scene.estimator.superposition().noise_ue),
            ..opened.params
        };
        let live = Live::boxed_builder(opened.source)
            .params(params)
            .gauges(sites.map(|site| gauge(&site.name)).collect())
            .boxed_estimator(estimator)
            .sink(sink.with_delivery(Delivery::Queue(N_WAITING)))
            .start()
            .map_err(raised)?;
        Ok(Self { running: Mutex::new(Some(Running { frames, live })), source: name })
    }

    fn running(&self) -> std::sync::MutexGuard<'_, Option<Running>> {
        self.running.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn with<T>(&self, work: impl FnOnce(&Running) -> T) -> Option<T> {
        self.running().as_ref().map(work)
    }

    /// How the source ended.
    ///
    /// # Errors
    /// `HapdefError` where frames came that could not be used, as `hapdef live` ends with.
    fn end(&self) -> PyResult<()> {
        let Some(health) = self.with(|running| running.live.health()) else {
            return Ok(());
        };
        match health.device_fault.as_ref().filter(|_| health.n_unusable > 0) {
            Some(fault) => {
                let text = format!("{}: {fault}", health.source_name);
                Err(HapdefError::new_err(text))
            }
            None => Ok(()),
        }
    }

    /// The next frame; `None` if it is closed.
    fn next(&self) -> Option<Result<LiveFrame, RecvTimeoutError>> {
        self.with(|running| running.frames.recv_timeout(LOOK))
    }
}

fn of_source(arg: &SourceArg, limb: &Limb, request: &LiveRequest) -> Result<Opened, Fault> {
    Ok(Opened {
        source: arg.open_for(limb.gauges.len())?,
        params: LiveParams {
            tare_s: request.tare_s,
            is_recorded: arg.is_recorded(),
            is_lossless: arg.is_unpaced(),
            ..LiveParams::default()
        },
    })
}

/// The simulated rig, pressed at random, as fast as frames are taken: the same frames every time.
fn of_rig(run: &Run, limb: &Limb, request: &LiveRequest) -> Result<Opened, Fault> {
    let real = Arc::new(live_limb(run, limb)?);
    let params = VirtualRigParams {
        script: Some(random_presses(&run.scene, &real, request.seed)),
        ..VirtualRigParams::default()
    };
    let device = virtual_device(&run.scene, real, &params)?;
    let play = RunParams { duration_s: request.seconds, ..RunParams::default() };
    let link = RigLink::new(device, &play, |_| ())?;
    let clock = link.clock();
    let stream = StreamParams { clock: Arc::clone(&clock), ..StreamParams::default() };
    Ok(Opened {
        source: Box::new(StreamSource::new(link, stream)),
        params: LiveParams {
            tare_s: request.tare_s,
            is_recorded: true,
            is_lossless: true,
            clock,
            ..LiveParams::default()
        },
    })
}
