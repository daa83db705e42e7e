//! Another board at the same port.

use crate::support;

use std::time::Duration;

use hapdef_daq::hdp1::SampleFormat;
use hapdef_daq::source::{FrameSource, StreamParams, StreamSource, memory_link};
use hapdef_daq::{Frame, Message};
use support::Device;

/// The same boot id, and a clock of its own: reported as a restart, and nothing counts as lost.
#[test]
fn it_is_reported_and_nothing_counts_as_lost() {
    let (link, device) = memory_link();
    let mut source = StreamSource::new(link, StreamParams::default());
    source.poll(Duration::ZERO, &mut |_| {});
    let mut sim = Device::new(1, SampleFormat::I16);
    let mut other = Device::new(1, SampleFormat::I16);
    other.hello.uid = *b"another board...";
    let mut bytes = Vec::new();
    (0..50).for_each(|_| sim.tick(&mut bytes));
    (0..10).for_each(|_| other.tick(&mut Vec::new()));
    other.say_hello(&mut bytes);
    (0..5).for_each(|_| other.tick(&mut bytes));
    device.send(&bytes);
    let (mut n_restarts, mut frames) = (0, Vec::<Frame>::new());
    source.poll(Duration::ZERO, &mut |message| match message {
        Message::Frame(frame) => frames.push(frame),
        Message::Restarted => n_restarts += 1,
        _ => {}
    });
    let n_lost: u32 = frames.iter().map(|f| f.n_lost_before).sum();
    assert_eq!((frames.len(), n_lost, n_restarts), (55, 0, 1));
    assert!(frames.is_sorted_by(|a, b| a.t_host_ns <= b.t_host_ns));
}
