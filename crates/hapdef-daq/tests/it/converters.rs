//! The firmware's drivers of converters and the Pico's program, compiled for the host and run against fakes of
//! the chips, which are written from the data sheets.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use hapdef_daq::hdp1::{Command, Decoder, Encoder, Event, FrameFlags, Hello, Status};

use crate::host_c::{Program, Said};

const FAKES: [&str; 4] =
    ["host/fake/fake.c", "host/fake/ads131m08.c", "host/fake/ads1256.c", "host/fake/hx711.c"];
const CHIPS: [&str; 3] = ["ads131m08", "ads1256", "hx711"];

/// The drivers and their fakes alone; `None` without a compiler.
fn bench() -> Option<&'static Program> {
    static BENCH: OnceLock<Option<Program>> = OnceLock::new();
    let drivers = ["host/bench.c", "converter.c", "ads131m08.c", "ads1256.c", "hx711.c"];
    BENCH.get_or_init(|| Program::of("bench", &[&drivers[..], &FAKES].concat())).as_ref()
}

/// The Pico's program with a chip.
fn pico(chip: &str) -> Option<&'static Program> {
    static PICOS: [OnceLock<Option<Program>>; 3] = [const { OnceLock::new() }; 3];
    let (driver, settings) = (format!("{chip}.c"), format!("hapdef_pico/with_{chip}.c"));
    let board = ["hapdef_pico/main.c", "host/pico/sdk.c", "hdp1.c", "converter.c", "board.c"];
    let files = [&board[..], &FAKES, &[&driver, &settings]].concat();
    let place = CHIPS.iter().position(|known| *known == chip).unwrap();
    PICOS[place].get_or_init(|| Program::of(&format!("pico_{chip}"), &files)).as_ref()
}

/// The first word of each line of a name, and what follows: `begin works 546`.
fn said<'a>(said: &'a str, name: &'a str) -> impl Iterator<Item = (&'a str, u64)> {
    let lines = said.lines().filter_map(move |line| line.strip_prefix(name)?.strip_prefix(' '));
    lines.map(|line| {
        let (words, number) = line.rsplit_once(' ').unwrap();
        (words, number.parse().unwrap())
    })
}

/// What `begin` and the polls of a chip end in with a fault, and after how many µs.
fn outcome(bench: &Program, chip: &str, fault: &str) -> (String, u64) {
    let text = String::from_utf8(bench.run(&[chip, fault], &[], b"").stdout).unwrap();
    let begun = said(&text, "begin").next().unwrap();
    let (words, us) = said(&text, "poll").next().unwrap_or(begun);
    (words.to_owned(), us)
}

/// Exchanges by SPI up to the first scan: what was sent, what came.
fn exchanges(text: &str) -> Vec<(&str, &str)> {
    let lines = text.lines().filter_map(|line| line.strip_prefix("spi "));
    lines.map(|line| line.split_once(' ').unwrap()).collect()
}

/// What the Pico's program says in 5 s with a chip, and what the fake converted.
struct Run {
    hello: Hello,
    frames: Vec<Frame>,
    statuses: Vec<Status>,
    logs: Vec<String>,
    pongs: Vec<u64>,
    n_hellos: usize,
    n_lost: u64,
    converted: BTreeMap<usize, Vec<(f64, i32)>>,
}

struct Frame {
    flags: FrameFlags,
    t_us: u64,
    codes: Vec<i32>,
}

impl Run {
    fn new(chip: &str, fault: &str) -> Option<Self> {
        let mut input = Vec::new();
        Encoder::new().command(Command::Ping { host_ns: 77 }, &mut input);
        let variables = [("FAKE_CHIP", chip), ("FAKE_FAULT", fault)];
        Some(Self::of(&pico(chip)?.run(&[], &variables, &input)))
    }

    fn of(output: &Said) -> Self {
        let mut decoder = Decoder::new();
        let (mut frames, mut statuses, mut logs, mut pongs) =
            (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut n_hellos = 0;
        decoder.push(&output.stdout, &mut |event| match event {
            Event::Data(data) => frames.push(Frame {
                flags: data.header.flags,
                t_us: data.t_us(0),
                codes: data.bits(0).collect(),
            }),
            Event::Hello { .. } => n_hellos += 1,
            Event::Status(status) => statuses.push(status),
            Event::Log(text) => logs.push(String::from_utf8(text.to_vec()).unwrap()),
            Event::Pong(pong) => pongs.push(pong.host_ns),
            Event::Rejected(reason) => panic!("{reason}"),
            Event::Restarted | Event::Command(_) => {}
        });
        Self {
            hello: decoder.hello().unwrap().clone(),
            frames,
            statuses,
            logs,
            pongs,
            n_hellos,
            n_lost: decoder.losses().n_lost,
            converted: converted(&output.stderr),
        }
    }

    /// Each reading is one that the fake converted, in its order, and its strain is right within a count.
    /// Channels in `but` have frames that are not held against anything.
    fn check(&self, but: impl Fn(&Frame, usize) -> bool) {
        for (channel, said) in self.hello.channels.iter().enumerate() {
            let mut converted = self.converted.get(&channel).into_iter().flatten();
            let scale = f64::from(said.scale);
            for frame in self.frames.iter().filter(|frame| !but(frame, channel)) {
                let code = frame.codes[channel];
                let &(strain_ue, _) =
                    converted.find(|(_, c)| *c == code).expect("a code of the fake");
                let is_end = code == 0x7f_ffff || code == -0x80_0000;
                let error_ue = (f64::from(code) * scale - strain_ue).abs();
                assert!(is_end || error_ue <= scale, "{channel}: {strain_ue} is off by {error_ue}");
                assert!(!is_end || frame.flags.contains(FrameFlags::SATURATED));
            }
        }
    }

    fn n_with(&self, flag: FrameFlags) -> usize {
        self.frames.iter().filter(|frame| frame.flags.contains(flag)).count()
    }

    /// Scans a second, of the frames from 3 s on, where no fault is played.
    fn rate_hz(&self) -> f64 {
        let late: Vec<u64> =
            self.frames.iter().map(|f| f.t_us).filter(|t| *t > 3_000_000).collect();
        1e6 * (late.len() - 1) as f64 / (late[late.len() - 1] - late[0]) as f64
    }
}

/// Strain and code of each conversion that the fake told, by channel.
fn converted(text: &str) -> BTreeMap<usize, Vec<(f64, i32)>> {
    let mut all: BTreeMap<usize, Vec<(f64, i32)>> = BTreeMap::new();
    for line in text.lines().filter_map(|line| line.strip_prefix("conversion ")) {
        let words: Vec<&str> = line.split(' ').collect();
        let conversion = (words[1].parse().unwrap(), words[2].parse().unwrap());
        all.entry(words[0].parse().unwrap()).or_default().push(conversion);
    }
    all
}

#[test]
fn readings_on_the_wire_are_what_the_chip_converted() {
    // Scans a second; the ADS1256's 1438 inputs of table 14 at eight of them.
    for (chip, n_channels, rate_hz) in
        [("ads131m08", 8, 1000.0), ("ads1256", 8, 179.75), ("hx711", 10, 79.0)]
    {
        let Some(run) = Run::new(chip, "") else { return };
        assert_eq!((run.hello.channels.len(), run.hello.boot_id), (n_channels, 4711), "{chip}");
        assert!(run.hello.uid[..8].iter().copied().eq(0xa0..=0xa7));
        assert!((run.rate_hz() / rate_hz - 1.0).abs() < 0.02, "{chip}: {}", run.rate_hz());
        let promised_hz = f64::from(run.hello.rate_mhz) / 1000.0;
        assert!((run.rate_hz() / promised_hz - 1.0).abs() < 0.03, "{chip}: {promised_hz}");
        assert_eq!((run.n_lost, run.logs.len(), run.pongs.as_slice()), (0, 0, &[77][..]), "{chip}");
        assert!((5..=6).contains(&run.n_hellos) && run.statuses.len() == 4, "{chip}");
        assert_eq!(run.n_with(FrameFlags::FIRST_AFTER_BOOT), 1, "{chip}");
        for flag in [FrameFlags::OVERRUN, FrameFlags::SATURATED, FrameFlags::BRIDGE_FAULT] {
            assert_eq!(run.n_with(flag), 0, "{chip}: {flag:?}");
        }
        run.check(|_, _| false);
    }
}

#[test]
fn stamps_are_of_the_sample_instants() {
    let Some(run) = Run::new("ads131m08", "") else { return };
    // 1000 µs apart, give or take a turn of the loop.
    let gaps = run.frames.windows(2).map(|w| (w[1].t_us - w[0].t_us).abs_diff(1000));
    assert!(gaps.max().unwrap() <= 60);
    let Some(run) = Run::new("ads1256", "") else { return };
    let skews: Vec<u16> = run.hello.channels.iter().map(|c| c.skew_16ns).collect();
    // 1/1438 s; 16 bits of 16 ns end at 1.05 ms.
    assert_eq!(skews, [0, 43463, 65535, 65535, 65535, 65535, 65535, 65535]);
}

#[test]
fn frames_of_the_ads131m08_are_those_of_its_data_sheet() {
    let Some(bench) = bench() else { return };
    let text = String::from_utf8(bench.run(&["ads131m08", ""], &[], b"").stdout).unwrap();
    let got = exchanges(&text);
    let word = |hex: &str| hex.to_owned() + &"0".repeat(60 - hex.len());
    // Table 8-11: RESET, then ID, then MODE to CFG in one command, then each of them read again. The CRC (CCITT,
    // from FFFF, over 27 bytes) was computed with another program.
    let sent =
        ["001100", "", "a00000", "", "610400011000ff5600555500555500060000", "", "a10000", ""];
    for (i, hex) in sent.iter().enumerate() {
        assert_eq!(got[i].0, word(hex), "frame {i}");
    }
    let answers =
        [(1, "ff2800"), (3, "284700"), (5, "410400"), (7, "011000"), (9, "ff5600"), (15, "060000")];
    for (i, hex) in answers {
        assert!(got[i].1.starts_with(hex), "answer {i}: {}", got[i].1);
    }
    assert_eq!(&got[5].1[54..], "f5d600");
    let data = got.last().unwrap();
    let golden = "01ff00f8191ffc6bdd00be9a051157f851ecfca4a900f766054a23005100";
    assert_eq!(*data, (word("").as_str(), golden));
    let scan = text.lines().last().unwrap();
    let codes = "scan -517857 -234531 48794 332119 -503316 -219991 63334 346659";
    assert!(scan.starts_with(codes), "{scan}");
}

#[test]
fn frames_of_the_ads1256_are_those_of_its_data_sheet() {
    let Some(bench) = bench() else { return };
    let text = String::from_utf8(bench.run(&["ads1256", ""], &[], b"").stdout).unwrap();
    let sent: Vec<&str> = exchanges(&text).iter().map(|(out, _)| *out).collect();
    let read = ["1003", "00000000"];
    // STATUS with the buffer, MUX, ADCON with gain 64, DRATE of 1000.
    let set_up = ["5003020106a1", "1003", "00000000", "f0"];
    // Figure 19: the next input, SYNC, WAKEUP, then the data of the one before.
    let cycle = |mux| [mux, "fc", "00", "01", "000000"];
    let cycles = [cycle("510001"), cycle("510023"), cycle("510001")];
    let expected: Vec<&str> =
        read.iter().chain(&set_up).chain(cycles.iter().flatten()).copied().collect();
    assert_eq!(sent, expected);
}

#[test]
fn a_chip_that_fails_ends_in_an_error_in_bounded_time() {
    let Some(bench) = bench() else { return };
    let no_chip = "no chip answers: power, SCLK, DIN, DOUT, CS";
    let other = "another chip answers, or nonsense";
    let register = "a register does not keep its value";
    let no_data = "no data: DRDY, clock of the chip";
    let settings = "settings out of range";
    let was_reset = "was reset, or is out of step: power, wires";
    // Faults, what they end in, and the longest time, µs.
    let cases = [
        ("ads131m08", "absent", no_chip, 1_000),
        ("ads131m08", "other", other, 1_000),
        ("ads131m08", "sticky", register, 1_000),
        ("ads131m08", "settings", settings, 1),
        ("ads1256", "absent", no_chip, 61_000),
        ("ads1256", "other", other, 61_000),
        ("ads1256", "sticky", register, 61_000),
        ("ads1256", "settings", settings, 1),
        ("ads1256", "dead", no_data, 20_000),
        ("ads1256", "stuck", no_data, 20_000),
        ("hx711", "absent", no_data, 76_000),
        ("hx711", "settings", settings, 1),
        ("hx711", "interrupt", was_reset, 60_000),
    ];
    for (chip, fault, words, longest_us) in cases {
        let (got, us) = outcome(bench, chip, fault);
        assert_eq!(got, words, "{chip}, {fault}");
        assert!(us <= longest_us, "{chip}, {fault}: {us} µs");
    }
}

#[test]
fn other_gains_and_global_chop_give_the_same_strain() {
    let Some(bench) = bench() else { return };
    // Counts per µε: half of gauge factor 2 is 0.5 V/V, over the range, by 2^23. 96 % of REFIN, which is half
    // the bridge's supply, at gain 32; half the supply at gain 64.
    let cases = [("ads131m08", "chop", 0.48 / 32.0), ("hx711", "gain 64", 0.5 / 64.0)];
    for (chip, fault, range) in cases {
        let run = bench.run(&[chip, fault], &[], b"");
        let text = String::from_utf8(run.stdout).unwrap();
        let scan = text.lines().last().unwrap().strip_prefix("scan ").unwrap();
        let counts_per_ue = 0.5e-6 / range * 8_388_608.0;
        let converted = converted(&run.stderr);
        for (channel, code) in scan.split(' ').take(8).enumerate() {
            let code: i32 = code.parse().unwrap();
            let (strain_ue, _) = *converted[&channel].iter().rfind(|(_, c)| *c == code).unwrap();
            assert!((f64::from(code) - strain_ue * counts_per_ue).abs() <= 1.0, "{chip}");
        }
    }
}

#[test]
fn the_fakes_refuse_what_the_data_sheets_forbid() {
    let Some(bench) = bench() else { return };
    let cases = [
        ("ads131m08", "mode 0"),
        ("ads131m08", "too fast"),
        ("ads1256", "mode 0"),
        ("ads1256", "too fast"),
    ];
    for (chip, fault) in cases {
        let said = bench.try_run(&[chip, fault], &[], b"");
        assert_eq!(said.code, Some(3), "{chip}, {fault}");
        assert!(said.stderr.contains("forbids"), "{}", said.stderr);
    }
}

#[test]
fn damaged_frames_are_dropped_and_announced() {
    let Some(run) = Run::new("ads131m08", "crc") else { return };
    run.check(|_, _| false);
    // One in four of 200 ms.
    let n_overruns = run.n_with(FrameFlags::OVERRUN);
    assert!((45..=55).contains(&n_overruns), "{n_overruns}");
    let n_told: u32 = run.statuses.iter().map(|status| status.n_adc_overruns).max().unwrap();
    assert_eq!((n_told as usize, run.n_lost), (n_overruns, 0));
    assert!(run.logs.is_empty(), "{:?}", run.logs);
    // Ten in a row are a fault: the chip is begun again, in vain until the noise ends.
    let Some(run) = Run::new("ads131m08", "noise") else { return };
    run.check(|_, _| false);
    assert_eq!(run.logs[0], "ads131m08: frames are damaged: wires, SCLK too fast");
    assert!((run.rate_hz() - 1000.0).abs() < 1.0 && run.n_with(FrameFlags::OVERRUN) == 1);
}

#[test]
fn a_chip_that_stops_is_begun_again_and_goes_on() {
    for (chip, fault, words) in [
        ("ads131m08", "silent", "ads131m08: no data: DRDY, clock of the chip"),
        ("ads131m08", "brownout", "ads131m08: was reset, or is out of step: power, wires"),
        ("ads1256", "silent", "ads1256: no data: DRDY, clock of the chip"),
        ("ads1256", "brownout", "ads1256: "),
    ] {
        let Some(run) = Run::new(chip, fault) else { return };
        assert!(run.logs[0].starts_with(words), "{chip}, {fault}: {:?}", run.logs);
        assert_eq!(run.n_with(FrameFlags::OVERRUN), 1, "{chip}, {fault}");
        let is_first_second = |t: u64| t < 2_000_000;
        assert!(run.frames.iter().any(|f| is_first_second(f.t_us)) && run.rate_hz() > 170.0);
    }
}

#[test]
fn a_silent_chip_of_ten_leaves_the_others_going() {
    let lowest = |frame: &Frame, channel: usize| frame.codes[channel] == -0x80_0000;
    // Chip 7 never answers; chip 4 is away for 200 ms, 75 of which the others wait for it.
    for (fault, channel, expected) in [("dead", 7, 350..=400), ("silent", 4, 8..=13)] {
        let Some(run) = Run::new("hx711", fault) else { return };
        run.check(|frame, c| c == channel && lowest(frame, c));
        let n_faulty = run.n_with(FrameFlags::BRIDGE_FAULT);
        assert!(expected.contains(&n_faulty), "{fault}: {n_faulty}");
        let n = run.frames.iter().filter(|frame| lowest(frame, channel)).count();
        assert_eq!((n_faulty, run.n_with(FrameFlags::SATURATED)), (n, n), "{fault}");
        assert!(run.statuses.iter().any(|status| status.saturated >> channel & 1 == 1));
        assert!((run.rate_hz() / 79.0 - 1.0).abs() < 0.02, "{fault}: {}", run.rate_hz());
        // Back again, it may be out of step: all begin anew, once.
        let words: &[&str] = if fault == "dead" {
            &[]
        } else {
            &["hx711: was reset, or is out of step: power, wires"]
        };
        assert_eq!(run.logs, words, "{fault}");
    }
}

#[test]
fn a_channel_at_the_end_of_its_range_says_so() {
    for chip in CHIPS {
        let Some(run) = Run::new(chip, "full") else { return };
        run.check(|_, _| false);
        let ends = |frame: &Frame| (frame.codes[2] == 0x7f_ffff, frame.codes[3] == -0x80_0000);
        assert!(run.frames.iter().any(|frame| ends(frame) == (true, true)), "{chip}");
        let n_ends = run.frames.iter().filter(|frame| ends(frame) != (false, false)).count();
        assert_eq!(run.n_with(FrameFlags::SATURATED), n_ends, "{chip}");
        let seen = run.statuses.iter().fold(0, |all, status| all | status.saturated);
        assert_eq!(seen, 0b1100, "{chip}");
    }
}

#[test]
fn a_pico_without_a_host_drops_and_counts() {
    let Some(run) = Run::new("ads131m08", "away") else { return };
    run.check(|_, _| false);
    // 200 ms fit into the queue.
    assert_eq!((run.n_lost, run.n_with(FrameFlags::OVERRUN)), (0, 0));
    let Some(run) = Run::new("ads131m08", "closed") else { return };
    run.check(|_, _| false);
    // What was queued while the port was closed is old.
    assert!((195..=205).contains(&run.n_lost), "{}", run.n_lost);
}

#[test]
fn a_board_that_is_held_up_says_that_scans_are_missing() {
    for chip in ["ads131m08", "ads1256"] {
        let Some(run) = Run::new(chip, "held up") else { return };
        run.check(|_, _| false);
        assert!(run.n_with(FrameFlags::OVERRUN) > 10, "{chip}");
        let before = run.frames.iter().filter(|f| f.t_us < 1_990_000);
        assert!(before.clone().all(|f| !f.flags.contains(FrameFlags::OVERRUN)), "{chip}");
    }
}
