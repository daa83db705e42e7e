//! HDP1: golden vectors, round trips, and what is refused.

use hapdef_daq::hdp1::{
    Channel, Command, Decoder, Encoder, Event, FrameFlags, Header, Hello, Pong, Rejected,
    SampleFormat, Status,
};

/// DATA 10 × i16, seq 258, t 1 s, schema A5; made with two independent libraries.
const GOLDEN_DATA: &str = "070110a50a0201010440420f010101010101020103ffff020104ffff7f03\
                           8064049cff0705c313abe300";
/// PING seq 5, host_ns 123456789.
const GOLDEN_PING: &str = "031110010205010101010101010101010515cd5b07010101056b1d6dc700";
const GOLDEN_SAMPLES: [i32; 10] = [0, 1, -1, 256, -256, 32767, -32768, 100, -100, 7];

fn bytes_of(hex: &str) -> Vec<u8> {
    let digits: Vec<u32> = hex.chars().filter_map(|c| c.to_digit(16)).collect();
    let byte = |pair: &[u32]| u8::try_from(pair[0] * 16 + pair[1]).unwrap_or(0);
    digits.chunks_exact(2).map(byte).collect()
}

/// A HELLO of ten i16 channels with schema A5.
fn golden_hello() -> Hello {
    let mut hello = Hello::plain(10, SampleFormat::I16, 1000);
    hello.schema_crc = 0x12a5;
    hello
}

/// What the decoder says, as owned text and numbers.
fn said(decoder: &mut Decoder, bytes: &[u8]) -> Vec<String> {
    let mut lines = Vec::new();
    decoder.push(bytes, &mut |event| {
        lines.push(match event {
            Event::Data(data) => {
                let bits: Vec<i32> = data.bits(0).collect();
                format!("{} lost {} {bits:?}", data.header.seq, data.n_lost_before)
            }
            Event::Hello { is_new, restarted, .. } => format!("hello {is_new} {restarted}"),
            Event::Rejected(reason) => reason.to_string(),
            Event::Log(text) => String::from_utf8_lossy(text).into_owned(),
            other => format!("{other:?}"),
        });
    });
    lines
}

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

#[test]
fn golden_data_is_made_and_read() {
    let hello = golden_hello();
    let mut encoder = Encoder::new();
    let mut stream = hello_bytes(&mut encoder, &hello);
    encoder.set_seq(258);
    let mut data = Vec::new();
    encoder.data(&hello, 1_000_000, FrameFlags::default(), &GOLDEN_SAMPLES, &mut data).unwrap();
    assert_eq!(data, bytes_of(GOLDEN_DATA));
    stream.extend(bytes_of(GOLDEN_DATA));
    let mut seen = None;
    Decoder::new().push(&stream, &mut |event| {
        if let Event::Data(data) = event {
            let bits: Vec<i32> = data.bits(0).collect();
            seen = Some((data.header.seq, data.t_us(0), data.header.schema, bits));
        }
    });
    let expected = (258, 1_000_000, 0xa5, GOLDEN_SAMPLES.to_vec());
    assert_eq!(seen, Some(expected));
}

#[test]
fn golden_ping_is_made_and_read() {
    let mut encoder = Encoder::new();
    encoder.set_seq(5);
    let mut out = Vec::new();
    let host_ns = 123_456_789;
    encoder.command(Command::Ping { host_ns }, &mut out);
    assert_eq!(out, bytes_of(GOLDEN_PING));
    let expected = format!("{:?}", Event::Command(Command::Ping { host_ns }));
    assert_eq!(said(&mut Decoder::new(), &out), [expected]);
}

#[test]
fn small_packets_come_back() {
    let (mut encoder, mut decoder) = (Encoder::new(), Decoder::new());
    let status = Status {
        n_sent: 1,
        n_tx_dropped: 2,
        n_adc_overruns: 3,
        n_rx_crc_errors: 4,
        uptime_s: 5,
        temperature_centi_c: -612,
        supply_mv: 4987,
        saturated: 1 << 63 | 1,
        worst_loop_us: 640,
    };
    let pong = Pong { host_ns: u64::MAX, t_rx_us: 7, t_us: 8 };
    let mut out = Vec::new();
    encoder.status(status, 9, &mut out);
    encoder.pong(pong, &mut out);
    encoder.log(&"µ".repeat(800), 9, &mut out);
    for command in [Command::GetHello, Command::Start, Command::Stop] {
        encoder.command(command, &mut out);
    }
    let expected = [
        format!("{:?}", Event::Status(status)),
        format!("{:?}", Event::Pong(pong)),
        "µ".repeat(750),
        "Command(GetHello)".to_owned(),
        "Command(Start)".to_owned(),
        "Command(Stop)".to_owned(),
    ];
    assert_eq!(said(&mut decoder, &out), expected);
}

#[test]
fn gaps_repeats_and_late_packets_are_counted() {
    let hello = Hello::plain(2, SampleFormat::I16, 1000);
    let (mut encoder, mut decoder) = (Encoder::new(), Decoder::new());
    said(&mut decoder, &hello_bytes(&mut encoder, &hello));
    let packets: Vec<_> = (0..10).map(|i| data_bytes(&mut encoder, &hello, &[i, -i])).collect();
    let order = [0, 1, 4, 4, 2, 5, 9];
    let lines: Vec<_> = order.iter().flat_map(|&i| said(&mut decoder, &packets[i])).collect();
    assert_eq!(
        lines,
        [
            "0 lost 0 [0, 0]",
            "1 lost 0 [1, -1]",
            "4 lost 2 [4, -4]",
            "DATA 4 came twice",
            "DATA 2 came after its time, 5 was expected",
            "5 lost 0 [5, -5]",
            "9 lost 3 [9, -9]",
        ]
    );
    let (losses, rejected) = (decoder.losses(), decoder.rejected());
    assert_eq!((losses.n_delivered, losses.n_lost), (5, 5));
    assert_eq!((rejected.n_repeats, rejected.n_backwards), (1, 1));
}

#[test]
fn numbers_wrap() {
    let hello = Hello::plain(1, SampleFormat::U16, 1000);
    let (mut encoder, mut decoder) = (Encoder::new(), Decoder::new());
    said(&mut decoder, &hello_bytes(&mut encoder, &hello));
    encoder.set_seq(u32::MAX);
    for expected in ["4294967295 lost 0 [1]", "0 lost 0 [1]", "1 lost 0 [1]"] {
        let bytes = data_bytes(&mut encoder, &hello, &[1]);
        assert_eq!(said(&mut decoder, &bytes), [expected]);
    }
}

#[test]
fn a_restart_numbers_from_zero() {
    let mut hello = Hello::plain(1, SampleFormat::I32, 1000);
    let (mut encoder, mut decoder) = (Encoder::new(), Decoder::new());
    said(&mut decoder, &hello_bytes(&mut encoder, &hello));
    encoder.set_seq(700);
    said(&mut decoder, &data_bytes(&mut encoder, &hello, &[1]));
    hello.boot_id += 1;
    let mut encoder = Encoder::new();
    assert_eq!(said(&mut decoder, &hello_bytes(&mut encoder, &hello)), ["hello true true"]);
    encoder.set_seq(2);
    let bytes = data_bytes(&mut encoder, &hello, &[5]);
    assert_eq!(said(&mut decoder, &bytes), ["2 lost 2 [5]"]);
    assert_eq!(decoder.losses().n_restarts, 1);
}

#[test]
fn a_restart_without_its_hello_is_seen_by_the_flag() {
    let hello = Hello::plain(1, SampleFormat::I32, 1000);
    let (mut encoder, mut decoder) = (Encoder::new(), Decoder::new());
    said(&mut decoder, &hello_bytes(&mut encoder, &hello));
    encoder.set_seq(9);
    said(&mut decoder, &data_bytes(&mut encoder, &hello, &[1]));
    encoder.set_seq(0);
    let mut out = Vec::new();
    encoder.data(&hello, 0, FrameFlags::FIRST_AFTER_BOOT, &[1], &mut out).unwrap();
    assert_eq!(said(&mut decoder, &out), ["Restarted", "0 lost 0 [1]"]);
    let next_boot = Hello { boot_id: 2, ..hello.clone() };
    let bytes = hello_bytes(&mut encoder, &next_boot);
    assert_eq!(said(&mut decoder, &bytes), ["hello true false"]);
    assert_eq!(decoder.losses().n_restarts, 1);
}

#[test]
fn what_is_refused_says_what_to_do() {
    let hello = golden_hello();
    let (mut encoder, mut decoder) = (Encoder::new(), Decoder::new());
    let data = bytes_of(GOLDEN_DATA);
    assert!(said(&mut decoder, &data)[0].contains("HELLO is awaited"));
    let mut other = Vec::new();
    let header = Header {
        kind: 1,
        major: 2,
        flags: FrameFlags::default(),
        schema: 0xa5,
        n_channels: 10,
        seq: 0,
        t_us: 0,
    };
    encoder.packet(header, &[0; 20], &mut other).unwrap();
    let line = said(&mut decoder, &other).join("");
    assert!(line.contains("version 2") && line.contains("version 1"), "{line}");
    assert!(line.contains("flash"), "{line}");
    let unknown = Header { kind: 0x77, major: 1, ..header };
    other.clear();
    encoder.packet(unknown, &[1, 2, 3], &mut other).unwrap();
    assert!(said(&mut decoder, &other)[0].contains("unknown type 77"));
    let mut bad = hello_bytes(&mut encoder, &hello);
    bad[5] ^= 0x10;
    assert!(said(&mut decoder, &bad)[0].contains("damaged"));
    assert!(said(&mut decoder, &[vec![1; 5000], vec![0]].concat())[0].contains("baud"));
    let rejected = decoder.rejected();
    assert_eq!((rejected.n_schema, rejected.n_version, rejected.n_unknown), (1, 1, 1));
    assert_eq!(rejected.n_damaged, 2);
}

#[test]
fn a_later_minor_version_is_read() {
    let mut hello = golden_hello();
    hello.minor = 3;
    let header = Header {
        kind: 2,
        major: 1,
        flags: FrameFlags::default(),
        schema: 0xa5,
        n_channels: 0,
        seq: 0,
        t_us: 0,
    };
    let plain = hello_bytes(&mut Encoder::new(), &hello);
    let mut body = vec![0; plain.len()];
    let n = cobs::decode(&plain[..plain.len() - 1], &mut body).unwrap().frame_size();
    let mut longer = body[16..n - 4].to_vec();
    longer.extend([9, 9, 9]);
    let mut out = Vec::new();
    Encoder::new().packet(header, &longer, &mut out).unwrap();
    let mut decoder = Decoder::new();
    assert_eq!(said(&mut decoder, &out), ["hello true false"]);
    assert_eq!(decoder.hello(), Some(&hello));
    longer[0] = 0;
    out.clear();
    Encoder::new().packet(header, &longer, &mut out).unwrap();
    assert!(said(&mut decoder, &out)[0].contains("length"));
}

#[test]
fn bad_descriptions_and_samples_are_refused() {
    let mut out = Vec::new();
    for n in [0, 65] {
        let hello = Hello::plain(n, SampleFormat::I16, 1000);
        assert!(Encoder::new().hello(&hello, 0, &mut out).is_err(), "{n}");
    }
    let mut nan = golden_hello();
    nan.channels[3] = Channel { scale: f32::NAN, ..nan.channels[3] };
    assert!(Encoder::new().hello(&nan, 0, &mut out).is_err());
    let flags = FrameFlags::default();
    for samples in [vec![0; 9], vec![40_000; 10]] {
        let mut encoder = Encoder::new();
        let made = encoder.data(&golden_hello(), 0, flags, &samples, &mut out);
        assert!(made.is_err() && encoder.seq() == 0);
    }
    assert!(out.is_empty());
}

#[test]
fn a_lost_zero_between_two_packets_loses_neither() {
    let hello = Hello::plain(64, SampleFormat::I32, 1000);
    let (mut encoder, mut decoder) = (Encoder::new(), Decoder::new());
    said(&mut decoder, &hello_bytes(&mut encoder, &hello));
    let samples: Vec<i32> = (1..65).map(|i| i * 0x0101_0101).collect();
    let mut stream = data_bytes(&mut encoder, &hello, &samples);
    stream.pop();
    stream.extend(data_bytes(&mut encoder, &hello, &samples));
    let lines = said(&mut decoder, &stream);
    assert_eq!(lines.len(), 3, "{lines:?}");
    assert_eq!(decoder.losses().n_delivered, 2);
    assert!(matches!(decoder.rejected().n_damaged, 1));
}

/// Readings are scaled by the HELLO that describes them or refused; refused ones count as lost.
#[test]
fn data_of_another_schema_or_number_of_channels_is_refused() {
    let hello = golden_hello();
    let (mut encoder, mut decoder) = (Encoder::new(), Decoder::new());
    said(&mut decoder, &hello_bytes(&mut encoder, &hello));
    let mut other = golden_hello();
    other.schema_crc = 0x12a6;
    let mut nine = Hello::plain(9, SampleFormat::I16, 1000);
    nine.schema_crc = hello.schema_crc;
    let mut stream = data_bytes(&mut encoder, &hello, &GOLDEN_SAMPLES);
    // a HELLO that does not come
    hello_bytes(&mut encoder, &other);
    stream.extend(data_bytes(&mut encoder, &other, &GOLDEN_SAMPLES));
    hello_bytes(&mut encoder, &hello);
    stream.extend(data_bytes(&mut encoder, &nine, &GOLDEN_SAMPLES[..9]));
    stream.extend(data_bytes(&mut encoder, &hello, &GOLDEN_SAMPLES));
    let lines = said(&mut decoder, &stream);
    assert_eq!(lines.len(), 4, "{lines:?}");
    assert!(lines[0].starts_with("0 lost 0"), "{lines:?}");
    assert!(lines[1].contains("a5") && lines[1].contains("a6"), "{lines:?}");
    assert!(lines[2].contains("9 channels") && lines[2].contains("10 channels"), "{lines:?}");
    assert!(lines[3].starts_with("3 lost 2"), "{lines:?}");
}

#[test]
fn rejections_carry_their_numbers() {
    let mut reasons = Vec::new();
    let mut bytes = bytes_of(GOLDEN_PING);
    // A payload byte, cd.
    bytes[18] ^= 1;
    Decoder::new().push(&bytes, &mut |event| {
        if let Event::Rejected(reason) = event {
            reasons.push(reason);
        }
    });
    assert!(matches!(reasons[..], [Rejected::Crc { found: 0xc76d_1d6b, .. }]), "{reasons:x?}");
}
