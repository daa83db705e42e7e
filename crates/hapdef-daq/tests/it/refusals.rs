//! Packets that are whole and of no use: what is said of them, whatever a device sends.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use hapdef_daq::Message;
use hapdef_daq::clock::HostClock;
use hapdef_daq::hdp1::{Encoder, FrameFlags, Header, Hello, SampleFormat};
use hapdef_daq::source::{
    FrameSource, LinkState, MemoryDevice, MemoryLink, Protocol, StreamParams, StreamSource,
    memory_link,
};
use proptest::prelude::*;

#[derive(Default)]
struct FakeClock(AtomicU64);

impl HostClock for FakeClock {
    fn now_ns(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }

    fn wall_ns(&self) -> u64 {
        self.now_ns()
    }
}

/// What a device may send.
#[derive(Clone, Copy, Debug)]
enum Sent {
    Hello { scale: f32, n_channels: usize },
    Data { n_samples: usize },
    Log,
}

/// A host, and a device on its memory link.
struct Pair {
    clock: Arc<FakeClock>,
    device: MemoryDevice,
    source: StreamSource<MemoryLink>,
    encoder: Encoder,
    seq: u32,
}

impl Pair {
    fn new(protocol: Protocol) -> Self {
        let (link, device) = memory_link();
        let clock = Arc::new(FakeClock::default());
        let params = StreamParams { protocol, clock: clock.clone() };
        let mut pair = Self {
            clock,
            device,
            source: StreamSource::new(link, params),
            encoder: Encoder::new(),
            seq: 0,
        };
        pair.poll();
        pair
    }

    fn poll(&mut self) -> Vec<Message> {
        let mut messages = Vec::new();
        self.source.poll(Duration::ZERO, &mut |message| messages.push(message));
        messages
    }

    fn send(&mut self, sent: Sent) {
        let mut bytes = vec![0];
        let t_us = self.clock.now_ns() / 1000;
        let header = |kind, schema, n_channels, seq| Header {
            kind,
            major: 1,
            flags: FrameFlags::default(),
            schema,
            n_channels,
            seq,
            t_us,
        };
        match sent {
            Sent::Hello { scale, n_channels } => {
                let payload = hello_payload(scale, n_channels);
                self.encoder.packet(header(2, 0, 0, 0), &payload, &mut bytes).unwrap();
            }
            Sent::Data { n_samples } => {
                let schema = plain(1.0, 4).schema_id();
                let header = header(1, schema, n_samples as u8, self.seq);
                let payload = vec![1; 2 * n_samples];
                self.encoder.packet(header, &payload, &mut bytes).unwrap();
                self.seq += 1;
            }
            Sent::Log => {
                self.encoder.packet(header(5, 0, 0, 0), b"still here", &mut bytes).unwrap();
            }
        }
        self.device.send(&bytes);
    }

    /// A millisecond later: what is there.
    fn tick(&mut self) -> Vec<Message> {
        self.clock.0.fetch_add(1_000_000, Ordering::Relaxed);
        self.poll()
    }
}

fn plain(scale: f32, n_channels: usize) -> Hello {
    let mut hello = Hello::plain(n_channels, SampleFormat::I16, 1000);
    hello.channels.iter_mut().for_each(|channel| channel.scale = scale);
    hello.seal();
    hello
}

/// As docs/formats.md has it, also where the scale is no number.
fn hello_payload(scale: f32, n_channels: usize) -> Vec<u8> {
    let hello = plain(scale, n_channels);
    let mut payload = vec![0, n_channels as u8, 0, 1];
    payload.extend(1_000_000u32.to_le_bytes());
    payload.extend(hello.uid);
    payload.extend(1u32.to_le_bytes());
    payload.extend([1, 0]);
    payload.extend(hello.schema_crc.to_le_bytes());
    for channel in &hello.channels {
        payload.extend([0; 4]);
        payload.extend(scale.to_le_bytes());
        payload.extend([0; 4]);
        payload.extend(channel.name);
    }
    payload
}

/// The first thing that is said of 3 s of packets, one each millisecond in turn.
fn said_of(packets: &[Sent]) -> String {
    let mut pair = Pair::new(Protocol::Hdp1);
    for i in 0..3000 {
        pair.send(packets[i % packets.len()]);
        for message in pair.tick() {
            match message {
                Message::Link(state) => return state.to_string(),
                Message::Frame(frame) => panic!("{frame:?}"),
                _ => {}
            }
        }
    }
    panic!("nothing was said of {packets:?}");
}

#[test]
fn no_hello_a_bad_hello_and_another_length_are_three_messages() {
    let (hello, bad) = (
        |n_channels| Sent::Hello { scale: 1.0, n_channels },
        Sent::Hello { scale: f32::NAN, n_channels: 4 },
    );
    let data = |n_samples| Sent::Data { n_samples };
    for (packets, words) in [
        (&[data(4)][..], &["without a HELLO"][..]),
        // What a device answers does not hide that no reading comes.
        (&[data(4), Sent::Log], &["without a HELLO"]),
        (&[bad, data(4)], &["not finite"]),
        (&[hello(4), data(3)], &["DATA of 3 channels in 6 bytes", "4 channels in 8 bytes"]),
        (&[hello(5), data(4)], &["of schema", "last HELLO's"]),
    ] {
        let said = said_of(packets);
        assert!(words.iter().all(|word| said.contains(word)), "{words:?}: {said}");
        assert!(!said.contains("baud") && said.contains("whole packets"), "{said}");
    }
}

#[test]
fn lines_of_another_number_of_integers_name_both() {
    let mut pair = Pair::new(Protocol::Csv { n_channels: 10 });
    let mut said = Vec::new();
    for _ in 0..2100 {
        pair.device.send(b"1,2,3,4,5,6,7,8,9\r\n");
        said.extend(pair.tick());
    }
    let [Message::Link(state @ LinkState::OtherChannels { expected: 10, found: 9 })] = &said[..]
    else {
        panic!("{said:?}");
    };
    assert!(state.to_string().contains("lines of 9 numbers come, 10 are expected"), "{state}");
}

fn sent() -> impl Strategy<Value = Sent> {
    prop_oneof![
        3 => Just(Sent::Data { n_samples: 4 }),
        1 => Just(Sent::Data { n_samples: 3 }),
        1 => Just(Sent::Log),
        2 => (prop_oneof![Just(1.0), Just(f32::NAN), Just(f32::INFINITY)], 3..6usize)
            .prop_map(|(scale, n_channels)| Sent::Hello { scale, n_channels }),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    /// Seconds of whatever HELLO and DATA in any order: a reading comes only of DATA that the last good
    /// HELLO describes, and where none comes of whole DATA for 2 s that is said, and never as a baud rate.
    #[test]
    fn whole_packets_are_never_called_a_wrong_baud_rate(
        stretches in prop::collection::vec(prop::collection::vec(sent(), 1..5), 1..5)
    ) {
        let mut pair = Pair::new(Protocol::Hdp1);
        let mut known = None;
        for stretch in stretches {
            let (mut n_frames, mut is_refused, mut has_data) = (0, false, false);
            for i in 0..4100 {
                let sent = stretch[i % stretch.len()];
                let is_good = match sent {
                    Sent::Hello { scale, n_channels } if scale.is_finite() => {
                        known = Some(n_channels);
                        false
                    }
                    Sent::Data { n_samples } => {
                        has_data = true;
                        n_samples == 4 && known == Some(4)
                    }
                    _ => false,
                };
                pair.send(sent);
                for message in pair.tick() {
                    match message {
                        Message::Frame(frame) => {
                            prop_assert!(is_good, "{sent:?} after {known:?}");
                            prop_assert_eq!(frame.bits().len(), 4);
                            n_frames += 1;
                        }
                        Message::Link(LinkState::Refused { .. }) => is_refused = true,
                        Message::Link(state) => prop_assert!(false, "{}", state),
                        _ => {}
                    }
                }
            }
            prop_assert_eq!(is_refused, has_data && n_frames == 0 || is_refused && n_frames < 2100);
        }
    }
}
