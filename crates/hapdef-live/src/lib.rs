//! From frames to contacts at 1 kHz: the part of hapdef that runs on a robot.
//!
//! A [`Bundle`] is one file with everything about a limb. A [`Live`] runtime reads a
//! [`hapdef_daq::source::FrameSource`] on a thread of its own, takes tare and drift off the readings,
//! finds contacts with a [`estimator::TouchEstimator`] and hands [`LiveFrame`]s to [`Sink`]s, each at its
//! own pace. What no sink wants is not computed; what is lost, dropped or skipped is counted.
//!
//! ```no_run
//! use hapdef_daq::source::{StreamParams, StreamSource, TcpLink};
//! use hapdef_live::estimator::SearchPlace;
//! use hapdef_live::{Bundle, FnSink, Live, Wants};
//!
//! let bundle = Bundle::read("shin.hapdef".as_ref())?;
//! let source = StreamSource::new(TcpLink::new("10.0.0.7:7320"), StreamParams::default());
//! let live = Live::builder(source)
//!     .bundle(&bundle)
//!     .boxed_estimator(bundle.estimator(None, SearchPlace::Background)?)
//!     .sink(FnSink::new("robot", Wants::CONTACTS, |frame| println!("{:?}", frame.touch.contacts)))
//!     .start()?;
//! println!("{}", live.wait()?);
//! # Ok::<(), hapdef_live::LiveError>(())
//! ```
//!
//! The same with frames from memory, and readings instead of contacts:
//!
//! ```
//! use std::sync::{Arc, mpsc::channel};
//! use hapdef_daq::hdp1::{Hello, SampleFormat};
//! use hapdef_daq::source::ReplaySource;
//! use hapdef_daq::{Frame, Message};
//! use hapdef_live::{Delivery, FnSink, Live, LiveParams, Wants};
//!
//! let hello = Message::Hello(Arc::new(Hello::plain(3, SampleFormat::I16, 1000)));
//! let frame = |seq| Message::Frame(Frame::new(seq, SampleFormat::I16, [1, 2, seq as i32]));
//! let source = ReplaySource::new("memory", std::iter::once(hello).chain((0..9).map(frame)), 0.0);
//! let (sender, received) = channel();
//! let sink = FnSink::new("test", Wants::RAW, move |frame| sender.send(frame.raw_ue[2]).unwrap());
//! let live = Live::builder(source)
//!     .params(LiveParams { is_recorded: true, is_lossless: true, tare_s: 0.0, ..LiveParams::default() })
//!     .sink(sink.with_delivery(Delivery::Queue(4)))
//!     .start()?;
//! assert_eq!(live.wait()?.n_frames, 9);
//! assert_eq!(received.iter().sum::<f64>(), 36.0);
//! # Ok::<(), hapdef_live::LiveError>(())
//! ```
//!
//! Where there are no threads, as in a browser, [`LiveBuilder::in_steps`] gives the same in [`LiveSteps`].
//!
//! With the feature `nets` the paper's chain ([`estimator::Hapdefx`]) is among the estimators; a scene that
//! chooses it has its trained nets in the bundle.
//!
//! This crate knows nothing of meshes, finite elements, training or web pages.

mod alert;
mod bundle;
mod error;
pub mod estimator;
mod frame;
mod health;
mod histogram;
mod runtime;
mod signals;
mod sink;
pub mod sinks;
mod tare_fault;

pub use alert::{Alert, AlertLevel, AlertParams, Threshold};
pub use bundle::{BUNDLE_VERSION, Bundle, BundleGauge, BundleInfo, BundleMode};
pub use error::{AnyError, LiveError};
pub use frame::LiveFrame;
pub use hapdef_contact::{
    Alternative, Contact, GaugeHealth, Phase, Quality, Touch, TouchPhase, Uncertainty,
    UnknownReason, Verdict, WhyNot, Wrench,
};
pub use health::{ClientHealth, Health, Latency, SinkHealth, StageTimes};
pub use runtime::channels::gauge_channels;
pub use runtime::{BLIND_SHARE, Live, LiveBuilder, LiveControl, LiveGauge, LiveParams, LiveSteps};
pub use signals::{GivenLoads, LoadSignal, UnknownSignal};
pub use sink::{Delivery, FnSink, LiveEvent, PhaseStatus, Sink, Wants};
pub use tare_fault::{Retare, TareFault, TareFaultKind, TareOutcome};
