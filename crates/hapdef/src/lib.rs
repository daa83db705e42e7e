//! From a limb to contacts: the scene file, the stages of the pipeline, the estimator, scoring.
//!
//! From a scene to contacts:
//!
//! ```
//! # use std::sync::Arc;
//! # use hapdef_daq::hdp1::{Hello, SampleFormat};
//! # use hapdef_daq::source::{FrameSource, ReplaySource};
//! # use hapdef_daq::{Frame, Message};
//! # use hapdef_inverse::SkinPoint;
//! use hapdef::{Source, scene::Scene};
//!
//! let scene = Scene::open("../../fixtures/shin/placed.json")?;
//! let limb = scene.solve()?;
//! # // Nothing, then 15 N that come in 40 ms and stay; a count is 1/64 µε.
//! # fn pressed(limb: &hapdef::SolvedLimb) -> Result<impl FrameSource + use<>, hapdef::HapdefError> {
//! #     let map = limb.response();
//! #     let unit = map.normal(&SkinPoint::new(map.skin(), 700, [0.5, 0.3, 0.2])?);
//! #     let mut hello = Hello::plain(unit.len(), SampleFormat::I32, 1000);
//! #     hello.channels.iter_mut().for_each(|channel| channel.scale = 1.0 / 64.0);
//! #     hello.seal();
//! #     let frame = move |i: u32| {
//! #         let force_n = 15.0 * (f64::from(i.saturating_sub(300)) / 40.0).min(1.0);
//! #         let noise = |g: usize| ((12.9 * f64::from(i) + 78.2 * g as f64).sin() * 43_758.5).fract();
//! #         let ue = unit.iter().enumerate().map(|(g, unit)| unit * force_n + 0.5 * noise(g));
//! #         let counts = ue.map(|ue| (ue * 64.0).round() as i32);
//! #         let mut frame = Frame::new(i, SampleFormat::I32, counts);
//! #         frame.t_device_us = 1000 * u64::from(i);
//! #         frame.t_host_ns = 1_000_000 * u64::from(i);
//! #         Message::Frame(frame)
//! #     };
//! #     let hello = Message::Hello(Arc::new(hello));
//! #     let messages = std::iter::once(hello).chain((0..800).map(frame));
//! #     Ok(ReplaySource::new("memory", messages, f64::INFINITY))
//! # }
//! # let frames = pressed(&limb)?;
//! # let mut last_n = 0.0;
//! let mut source = Source::new(frames, scene.scene());
//! # (source.params.is_recorded, source.params.is_lossless) = (true, true);
//! source.params.tare_s = 0.2;
//! let tracker = limb.tracker(source.search_place())?;
//! for frame in source.contacts(tracker)? {
//!     for contact in &frame.touch.contacts {
//!         println!("{:.1} N at {:.4} m", contact.force_n, contact.position_m);
//! #         last_n = contact.force_n;
//!     }
//! }
//! # assert!((last_n - 15.0_f64).abs() < 0.5, "{last_n} N");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`OpenScene::source`] has the frames of a port, a TCP connection or a recording,
//! [`OpenScene::rig_source`] those of the simulated rig.
//!
//! A [`Run`] holds a scene, a [`Profile`] of how much to make, and the content-addressed
//! [`Cache`]; [`stages`] are functions on it, each from what it needs to a cached folder.
//! [`Hapdefx`] is the paper's chain from gauge readings to contacts.
//!
//! Knows nothing of command lines and web pages, which are in `hapdef-cli`, nor of the paper's tables
//! and baselines: those are in `hapdef-repro`.

mod cache;
mod compliance;
pub mod convergence;
mod drawn_skin;
mod error;
mod error_text;
mod hapdefx;
mod limb;
mod limb_axis;
mod map_error;
pub mod new_limb;
mod open;
mod pipeline;
pub mod plan;
mod print;
mod profile;
mod progress;
mod robot;
mod run;
mod sampling;
pub mod scene;
mod scoring;
pub mod session;
pub mod shell_limb;
mod skin_solid;
mod skin_wall;
mod solid;
mod source;
mod source_args;
mod source_open;
pub mod stages;
mod stats;
pub mod touch;
mod touch_sensor;
mod virtual_rig;
mod wall_shell;
mod work;

pub use cache::{Cache, Stage, StageRecord, write_json};
pub use compliance::{ComplianceTable, SuperpositionScratch};
pub use drawn_skin::DrawnSkin;
pub use error::{HapdefError, RobotError, SceneError};
pub use error_text::error_text;
pub use hapdef_contact::DrawnContact;
pub use hapdef_live::estimator::{ChainNets, FoundContact, Hapdefx, HapdefxScratch};
pub use hapdefx::{candidates, hapdefx, maps_of_readings, scored};
pub use limb::Limb;
pub use map_error::{MapError, MapErrorSum};
pub use open::{OpenParams, OpenScene, SolvedLimb};
pub use pipeline::{Pipeline, Until};
pub use print::{GaugePlace, PrintParams, PrintedLimb, print_limb};
pub use profile::{OutputScale, Profile, Samples, Schedule};
pub use progress::{Bar, Display, Progress, StepBar};
pub use robot::{LimbSource, Robot, RobotLimb, is_robot_file, read_robot};
pub use run::Run;
pub use sampling::{draw_contacts, draw_numbered};
pub use scoring::{
    ContactPair, Gospa, GospaParams, MAX_ONE_TO_ONE, OneToOne, ScoredContact, ScoringError, gospa,
    score_lenient, score_one_to_one,
};
pub use skin_wall::{SkinWall, WallMeasures};
pub use source::{Contacts, RawFrame, RigPlay, Source};
pub use source_args::{SOURCE_FORMS, SourceArg, SourceArgError, parse_speed};
pub use stats::{ContactStats, FAR_M, ForceBin, by_force};
pub use touch_sensor::{TouchSensor, TouchSensorParams};
pub use virtual_rig::{
    VirtualRigParams, live_limb, random_presses, virtual_chain, virtual_device, virtual_hands,
};
pub use wall_shell::WallShell;
