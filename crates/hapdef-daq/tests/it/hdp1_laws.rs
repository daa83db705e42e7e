//! HDP1: laws that hold for any device and any bytes.

use hapdef_daq::hdp1::{Decoder, Encoder, Event, FrameFlags, Header, Hello, SampleFormat};
use proptest::prelude::*;

fn hello_bytes(encoder: &mut Encoder, hello: &Hello) -> Vec<u8> {
    let mut out = Vec::new();
    assert!(encoder.hello(hello, 0, &mut out).is_ok());
    out
}

fn data_bytes(encoder: &mut Encoder, hello: &Hello, samples: &[i32]) -> Vec<u8> {
    let mut out = Vec::new();
    let t_us = u64::from(encoder.seq()) * 1000;
    let made = encoder.data(hello, t_us, FrameFlags::default(), samples, &mut out);
    assert!(made.is_ok(), "{made:?}");
    out
}

fn format() -> impl Strategy<Value = SampleFormat> {
    (0u8..5).prop_map(|code| SampleFormat::from_code(code).unwrap_or(SampleFormat::I16))
}

/// A HELLO and the samples of some packets that fit it.
fn device() -> impl Strategy<Value = (Hello, Vec<Vec<i32>>)> {
    (format(), 1usize..=64, 1u8..=4, 1usize..6).prop_flat_map(|(format, n, n_scans, n_packets)| {
        let mut hello = Hello::plain(n, format, 1000);
        hello.n_scans = n_scans;
        hello.seal();
        let sample = match format {
            SampleFormat::I16 => (-32768..32768).boxed(),
            SampleFormat::U16 => (0..65536).boxed(),
            SampleFormat::I24 => (-(1 << 23)..1 << 23).boxed(),
            SampleFormat::I32 | SampleFormat::F32 => any::<i32>().boxed(),
        };
        let packet = prop::collection::vec(sample, n * usize::from(n_scans));
        (Just(hello), prop::collection::vec(packet, n_packets))
    })
}

fn delivered(decoder: &mut Decoder, bytes: &[u8], into: &mut Vec<(u32, Vec<i32>)>) {
    decoder.push(bytes, &mut |event| {
        if let Event::Data(data) = event {
            let n = usize::from(data.hello.n_scans);
            into.push((data.header.seq, (0..n).flat_map(|s| data.bits(s)).collect()));
        }
    });
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn any_device_comes_back_in_pieces_of_any_size((hello, packets) in device(), piece in 1usize..97) {
        let (mut encoder, mut decoder) = (Encoder::new(), Decoder::new());
        let mut stream = hello_bytes(&mut encoder, &hello);
        for samples in &packets {
            stream.extend(data_bytes(&mut encoder, &hello, samples));
        }
        let mut got = Vec::new();
        for bytes in stream.chunks(piece) {
            delivered(&mut decoder, bytes, &mut got);
        }
        let expected: Vec<_> = (0u32..).zip(packets).collect();
        prop_assert_eq!(got, expected);
        prop_assert_eq!(decoder.hello(), Some(&hello));
    }

    #[test]
    fn any_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..4000)) {
        let hello = Hello::plain(3, SampleFormat::I24, 1000);
        let mut decoder = Decoder::new();
        decoder.push(&hello_bytes(&mut Encoder::new(), &hello), &mut |_| {});
        let mut n_data = 0;
        decoder.push(&bytes, &mut |event| n_data += u32::from(matches!(event, Event::Data(_))));
        prop_assert_eq!(n_data, 0);
    }

    #[test]
    fn any_body_with_a_good_crc_never_panics(
        kind in prop_oneof![1u8..6, 0x10u8..0x14],
        payload in prop::collection::vec(any::<u8>(), 0..300),
        minor in 0u8..2,
        n in 0u8..70,
    ) {
        let header = Header { kind, major: 1, flags: FrameFlags::default(), schema: 0, n_channels: 1, seq: 0, t_us: 0 };
        let mut payload = payload;
        if let [first, second, third, ..] = &mut payload[..] {
            (*first, *second, *third) = (minor, n, *third % 6);
        }
        let (mut decoder, mut out) = (Decoder::new(), Vec::new());
        prop_assert!(Encoder::new().packet(header, &payload, &mut out).is_ok());
        let mut n_events = 0;
        decoder.push(&out, &mut |_| n_events += 1);
        prop_assert_eq!(n_events, 1);
    }

    #[test]
    fn one_damaged_byte_never_makes_a_wrong_frame((hello, packets) in device(), at in any::<prop::sample::Index>(), by in 1u8..=255, what in 0..3) {
        let (mut encoder, mut decoder) = (Encoder::new(), Decoder::new());
        let mut stream = Vec::new();
        delivered(&mut decoder, &hello_bytes(&mut encoder, &hello), &mut Vec::new());
        for samples in &packets {
            stream.extend(data_bytes(&mut encoder, &hello, samples));
        }
        let at = at.index(stream.len());
        match what {
            0 => stream[at] ^= by,
            1 => { stream.remove(at); }
            _ => stream.insert(at, by),
        }
        let mut got = Vec::new();
        delivered(&mut decoder, &stream, &mut got);
        for (seq, samples) in &got {
            prop_assert_eq!(samples, &packets[*seq as usize]);
        }
        prop_assert!(got.len() + 1 >= packets.len(), "{} of {}", got.len(), packets.len());
    }
}
