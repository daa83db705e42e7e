//! A made-up finger that slides along a limb, as a recording that ROS tools, Foxglove and rerun open.
//!
//!     cargo run --release --example press -- press.mcap
#![expect(clippy::print_stdout, reason = "an example")]

use std::error::Error;
use std::path::PathBuf;
use std::time::Duration;

use hapdef_contact::{Contact, Touch, Uncertainty};
use hapdef_daq::clock::{HostClock, SystemClock};
use hapdef_daq::hdp1::SampleFormat;
use hapdef_daq::record::{RecordParams, record};
use hapdef_daq::source::ReplaySource;
use hapdef_daq::{AcquireParams, Frame, Message, acquire};
use hapdef_ros::{McapSink, Readings, RosEncoder, RosParams, topics};
use nalgebra::{Matrix3, Point3, Vector3};

const N_READINGS: u32 = 3000;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args_os().nth(1).map(PathBuf::from);
    let path = path.unwrap_or_else(|| "press.mcap".into());
    let start_ns = SystemClock.now_ns();
    let t_host_ns = move |i: u32| start_ns + u64::from(i) * 1_000_000;
    let frames = (0..N_READINGS).map(move |i| {
        let mut frame = Frame::new(i, SampleFormat::I16, [reading(i) as i32; 4]);
        frame.t_host_ns = t_host_ns(i);
        Message::Frame(frame)
    });
    let source = ReplaySource::new("made up", frames, f64::INFINITY);
    let (_acquisition, receivers) = acquire(source, AcquireParams::default())?;
    let receiver = receivers.into_iter().next().ok_or("no receiver")?;

    // One recording: the raw readings, and what is made of them on the topics of ROS.
    let params = RosParams::default();
    let record_params = RecordParams {
        topics: topics(&params)?,
        source: "made up".into(),
        ..RecordParams::default()
    };
    let recorder = record(receiver, &path, record_params)?;
    let writer = recorder.topics();
    let mut encoder = RosEncoder::new(params, McapSink::new(writer.clone()))?;
    for i in 0..N_READINGS {
        let stamp_ns = writer.wall_ns(t_host_ns(i));
        let microstrain = [reading(i); 4];
        encoder.readings(&Readings {
            stamp_ns,
            seq: i,
            n_lost_before: 0,
            microstrain: &microstrain,
        })?;
        let contacts = finger(i).into_iter().collect();
        encoder.contacts(stamp_ns, i, &Touch { contacts, ..Touch::default() })?;
        if i % 250 == 0 {
            // The recorder has a disk to write to; a limb would give it the time.
            std::thread::sleep(Duration::from_millis(90));
        }
    }
    let info = recorder.finish()?;
    println!(
        "{}: {} readings, {} messages, {} dropped",
        info.path.display(),
        info.n_frames,
        info.n_messages,
        info.n_messages_dropped
    );
    Ok(())
}

/// A reading in counts and in µε.
fn reading(i: u32) -> f64 {
    finger(i).map_or(0.0, |finger| (100.0 * finger.force_n).round())
}

/// The finger, while it touches.
fn finger(i: u32) -> Option<Contact> {
    let along = f64::from(i) / f64::from(N_READINGS);
    let force_n = 3.0 * (std::f64::consts::TAU * along).sin();
    (force_n > 0.1).then_some(Contact {
        id: Some(1),
        direction: Some(-Vector3::x()),
        uncertainty: Some(Uncertainty {
            tangents: [Vector3::y(), Vector3::z()],
            covariance: Matrix3::from_diagonal(&Vector3::new(1e-6, 4e-6, 0.01)),
        }),
        ..Contact::new(Point3::new(0.04, 0.0, 0.1 + 0.2 * along), force_n)
    })
}
