//! The firmware's C core, compiled for the host and held against the decoder and the golden vectors.

use hapdef_daq::hdp1::{Command, Decoder, Encoder, Event, Hello, SampleFormat};

use crate::host_c::{CPP, Program};

const GOLDEN_DATA: &str = "070110a50a0201010440420f010101010101020103ffff020104ffff7f03\
                           8064049cff0705c313abe300";

/// What the compiled core prints when the host says `input`; `None` without a C compiler.
fn run(input: &[u8]) -> Option<String> {
    let program = Program::of("golden", &["hdp1.c", "host/golden.c"])?;
    Some(String::from_utf8(program.run(&[], &[], input).stdout).unwrap())
}

fn bytes_of(hex: &str) -> Vec<u8> {
    let pairs = hex.as_bytes().chunks(2).map(|p| std::str::from_utf8(p).unwrap());
    pairs.map(|p| u8::from_str_radix(p, 16).unwrap()).collect()
}

/// The packets or bytes that were printed under a name.
fn shown<'a>(text: &'a str, name: &'a str) -> impl Iterator<Item = &'a str> {
    let lines = text.lines().filter_map(|line| line.split_once(' '));
    lines.filter(move |(n, _)| *n == name).map(|(_, rest)| rest)
}

#[test]
fn packets_are_the_decoders() {
    let mut input = vec![0, 0];
    let mut encoder = Encoder::new();
    let commands = [
        Command::GetHello,
        Command::Ping { host_ns: 0x0102_0304_0506_0708 },
        Command::Start,
        Command::Stop,
    ];
    for command in commands {
        encoder.command(command, &mut input);
        input.extend([3, 9, 0]);
    }
    input.extend([7; 500]);
    input.push(0);
    encoder.command(Command::Start, &mut input);
    let Some(text) = run(&input) else { return };

    assert_eq!(shown(&text, "data").collect::<Vec<_>>(), [GOLDEN_DATA]);
    let expected = ["10 0", "11 72623859790382856", "12 72623859790382856", "13 72623859790382856"];
    let got: Vec<_> = shown(&text, "command").collect();
    assert_eq!((&got[..4], got.len()), (&expected[..], 5));
    assert_eq!(shown(&text, "bad").collect::<Vec<_>>(), ["5"]);

    let mut hello = Hello::plain(64, SampleFormat::I32, 1000);
    (hello.boot_id, hello.firmware) = (7, 3);
    let mut decoder = Decoder::new();
    let mut said = Vec::new();
    let mut push = |name| {
        for packet in shown(&text, name) {
            decoder.push(&bytes_of(packet), &mut |event| {
                said.push(format!("{event:?}"));
            });
        }
    };
    ["hello", "status", "log"].into_iter().for_each(&mut push);
    assert_eq!(decoder.hello(), Some(&hello));
    assert!(said[1].contains("n_sent: 1, n_tx_dropped: 2") && said[1].contains("-612"));
    assert_eq!(said.len(), 2 + 12, "{said:?}");
    assert!(said.iter().all(|line| !line.contains("Rejected")), "{said:?}");
    assert_eq!(shown(&text, "toolong").collect::<Vec<_>>(), ["0"]);
}

#[test]
fn a_full_queue_drops_whole_packets_and_counts() {
    let Some(text) = run(b"") else { return };
    let counts = shown(&text, "counts").next().unwrap();
    let counts: Vec<u64> = counts.split(' ').map(|n| n.parse().unwrap()).collect();
    assert_eq!((counts[0] + counts[1], counts[2]), (40, 40));
    assert!(counts[1] > 0, "{counts:?}");
    let mut hello = Hello::plain(10, SampleFormat::I16, 1000);
    hello.schema_crc = 0xa5;
    let mut stream = Vec::new();
    Encoder::new().hello(&hello, 0, &mut stream).unwrap();
    shown(&text, "port").for_each(|hex| stream.extend(bytes_of(hex)));
    let mut decoder = Decoder::new();
    let mut last = 0;
    decoder.push(&stream, &mut |event| match event {
        Event::Data(data) => last = u64::from(data.header.seq),
        Event::Hello { .. } => {}
        other => panic!("{other:?}"),
    });
    let losses = decoder.losses();
    assert_eq!(losses.n_delivered, counts[0]);
    assert_eq!(losses.n_lost, counts[1] - (39 - last));
}

/// What the sketch sends in 5 s, with a fake of the board, when the host says `commands`; a second of
/// them the host is away. `None` without a compiler.
fn sketch(commands: &[Command]) -> Option<Vec<u8>> {
    let program =
        Program::linked(&CPP, "due", &["hdp1.c", "converter.c", "board.c", "host/due/main.cpp"])?;
    let mut asked = vec![0];
    for &command in commands {
        Encoder::new().command(command, &mut asked);
    }
    Some(program.run(&[], &[], &asked).stdout)
}

#[test]
fn a_stopped_sketch_goes_on_to_say_what_it_is_once_a_second() {
    let Some(bytes) = sketch(&[Command::Stop]) else {
        return;
    };
    let mut decoder = Decoder::new();
    let (mut n_hellos, mut n_statuses) = (0, 0);
    decoder.push(&bytes, &mut |event| match event {
        Event::Hello { .. } => n_hellos += 1,
        Event::Status(_) => n_statuses += 1,
        Event::Data(data) => assert!(data.header.seq < 2, "{data:?}"),
        other => panic!("{other:?}"),
    });
    // When the port opens, twice, and every second; 16 KiB hold those of the second without a host.
    assert!((6..=7).contains(&n_hellos), "{n_hellos}");
    assert!((4..=5).contains(&n_statuses), "{n_statuses}");
}

#[test]
fn a_host_that_opens_the_port_hears_first_what_sends_and_nothing_old() {
    let Some(bytes) = sketch(&[]) else { return };
    let mut decoder = Decoder::new();
    let mut said = Vec::new();
    decoder.push(&bytes, &mut |event| match event {
        Event::Hello { .. } => said.push(None),
        Event::Data(data) => said.push(Some(data.header.seq)),
        Event::Rejected(reason) => panic!("{reason}"),
        _ => {}
    });
    assert_eq!((bytes[0], said[0]), (0, None));
    // Opened again at 4.3 s.
    let is_announced =
        |w: &[Option<u32>]| matches!(w, [Some(4098..=4101), None, Some(4299..=4301)]);
    let hellos: Vec<usize> = (0..said.len()).filter(|&i| said[i].is_none()).collect();
    assert!(said.windows(3).any(is_announced), "{hellos:?}");
    let n_ends = bytes.windows(2).filter(|pair| *pair == [0, 0]).count();
    assert_eq!(n_ends, 1, "a 0x00 of its own at 4.3 s");
}

/// The sketch, with a fake of the board: 5 s, a second of them with the host away.
#[test]
fn the_sketch_never_blocks_and_counts_what_it_drops() {
    let host_ns = 0x0807_0605_0403_0201;
    let Some(bytes) = sketch(&[Command::GetHello, Command::Ping { host_ns }]) else {
        return;
    };
    let mut decoder = Decoder::new();
    let (mut pongs, mut statuses, mut times) = (Vec::new(), Vec::new(), Vec::new());
    decoder.push(&bytes, &mut |event| match event {
        Event::Data(data) => {
            assert!(data.bits(0).eq((0..10).map(|i| 100 * i + 8)));
            times.push((data.header.seq, data.t_us(0)));
        }
        Event::Pong(pong) => pongs.push(pong.host_ns),
        Event::Status(status) => statuses.push(status),
        Event::Rejected(reason) => panic!("{reason}"),
        _ => {}
    });
    let hello = decoder.hello().unwrap();
    assert_eq!((hello.channels.len(), hello.boot_id), (10, 77));
    assert!(hello.uid.iter().copied().eq(1..=16), "{:?}", hello.uid);
    assert!((hello.channels[0].scale - 0.976).abs() < 0.01, "{}", hello.channels[0].scale);
    assert_eq!(pongs, [host_ns]);
    let losses = decoder.losses();
    // 16 KiB hold 380 ms of packets: the rest of the second is dropped and counted, and the 200 ms in which
    // the port is closed.
    assert!((750..900).contains(&losses.n_lost), "{losses:?}");
    // At 0, 1, … 5000 ms; the first is older than the host's opening the port.
    let n_before = u64::from(times[0].0);
    assert_eq!(n_before, 1);
    assert_eq!(n_before + losses.n_delivered + losses.n_lost, 5001);
    let last = statuses.last().unwrap();
    assert_eq!(u64::from(last.n_tx_dropped), n_before + losses.n_lost);
    assert_eq!(last.n_adc_overruns, 0);
    // A scan every millisecond, over the wrap of micros().
    let worst =
        times.windows(2).map(|w| (w[1].1 - w[0].1).abs_diff(1000 * u64::from(w[1].0 - w[0].0)));
    assert!(worst.max().unwrap() <= 70);
}
