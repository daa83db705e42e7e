//! Serial ports by ptys: unplugging, coming back, what is refused.

use crate::support;

use std::os::unix::fs::symlink;
use std::path::Path;
use std::time::{Duration, Instant};

use hapdef_daq::hdp1::{RejectedCounts, SampleFormat};
use hapdef_daq::source::{
    FrameSource, Link, LinkFault, LinkState, SerialLink, SerialParams, StreamParams, StreamSource,
};
use hapdef_daq::{AcquireParams, Message, acquire};
use support::{Device, is_right, pty, wait_for};

const SECOND: Duration = Duration::from_secs(1);

fn source(path: &Path) -> StreamSource<SerialLink> {
    let link = SerialLink::new(path.to_str().unwrap_or(""), SerialParams::default());
    StreamSource::new(link, StreamParams::default())
}

fn is_open(message: &Message) -> Option<()> {
    matches!(message, Message::Link(LinkState::Open)).then_some(())
}

#[test]
fn unplug_and_replug() {
    let folder = tempfile::tempdir().unwrap();
    let stable = folder.path().join("usb-device");
    let (master, path) = pty();
    symlink(&path, &stable).unwrap();
    let (_acquisition, mut receivers) = acquire(source(&stable), AcquireParams::default()).unwrap();
    let receiver = &mut receivers[0];
    wait_for(receiver, SECOND, is_open);
    let mut sim = Device::new(10, SampleFormat::I16);
    let mut bytes = Vec::new();
    (0..20).for_each(|_| sim.tick(&mut bytes));
    rustix::io::write(&master, &bytes).unwrap();
    wait_for(receiver, SECOND, |m| match m {
        Message::Frame(frame) => is_right(frame).then_some(()).filter(|()| frame.seq == 19),
        _ => None,
    });

    let pulled = Instant::now();
    drop(master);
    wait_for(receiver, SECOND, |m| {
        matches!(m, Message::Link(LinkState::Away(LinkFault::Disconnected { .. }))).then_some(())
    });
    let noticed = pulled.elapsed();
    println!("disconnected after {noticed:?}");
    assert!(noticed <= Duration::from_millis(50), "{noticed:?}");

    std::thread::sleep(Duration::from_millis(300));
    let (master, path) = pty();
    std::fs::remove_file(&stable).unwrap();
    symlink(&path, &stable).unwrap();
    let back = Instant::now();
    wait_for(receiver, SECOND, is_open);
    bytes.clear();
    (0..5).for_each(|_| sim.tick(&mut Vec::new()));
    sim.tick(&mut bytes);
    rustix::io::write(&master, &bytes).unwrap();
    let frame = wait_for(receiver, SECOND, |m| match m {
        Message::Frame(frame) => Some(*frame),
        _ => None,
    });
    println!("back after {:?}", back.elapsed());
    assert!(back.elapsed() <= SECOND);
    assert_eq!((frame.seq, frame.n_lost_before), (25, 5));
}

#[test]
fn nothing_spins_while_the_port_is_away() {
    let (master, path) = pty();
    let mut source = source(Path::new(&path));
    source.poll(Duration::ZERO, &mut |_| {});
    drop(master);
    let (start, busy_before) = (Instant::now(), thread_cpu());
    while start.elapsed() < SECOND {
        source.poll(Duration::from_millis(20), &mut |_| {});
    }
    let share = (thread_cpu() - busy_before).as_secs_f64() / start.elapsed().as_secs_f64();
    println!("{:.2} % of a core while away", 100.0 * share);
    assert!(share < 0.05, "{share}");
}

/// Time of a core that this thread has taken, to 10 ms (proc_pid_stat(5): utime and stime, hundredths of a
/// second).
fn thread_cpu() -> Duration {
    let stat = std::fs::read_to_string("/proc/thread-self/stat").unwrap();
    let (_, after_name) = stat.rsplit_once(')').unwrap();
    let fields: Vec<&str> = after_name.split_whitespace().collect();
    let hundredths: u64 = fields[11..13].iter().map(|n| n.parse::<u64>().unwrap()).sum();
    Duration::from_millis(10 * hundredths)
}

#[test]
fn ports_that_cannot_be_opened_say_why() {
    let open = |path: &str| SerialLink::new(path, SerialParams::default()).open();
    assert!(matches!(open("/dev/ttyNONE7"), Err(LinkFault::NotFound { .. })));
    let (_master, path) = pty();
    let mut first = SerialLink::new(&path, SerialParams::default());
    first.open().unwrap();
    let second = open(&path).unwrap_err();
    assert!(matches!(second, LinkFault::Busy { .. }), "{second:?}");
    first.close();
    open(&path).unwrap();
    let file = tempfile::NamedTempFile::new().unwrap();
    let no_port = open(file.path().to_str().unwrap()).unwrap_err();
    assert!(matches!(no_port, LinkFault::Io { .. }), "{no_port:?}");
}

#[test]
fn all_bytes_pass_a_raw_port() {
    let (master, path) = pty();
    let mut link = SerialLink::new(&path, SerialParams::default());
    link.open().unwrap();
    let all: Vec<u8> = (0..=255).collect();
    rustix::io::write(&master, &all).unwrap();
    let (mut got, mut buffer) = (Vec::<u8>::new(), [0; 64]);
    while got.len() < 256 {
        let n = link.read(&mut buffer, SECOND).unwrap();
        assert!(n > 0, "{} bytes", got.len());
        got.extend(&buffer[..n]);
    }
    assert_eq!(got, all);
    link.write(&all).unwrap();
    std::thread::sleep(Duration::from_millis(20));
    let mut echoed = [0; 512];
    let n = rustix::io::read(&master, &mut echoed[..]).unwrap();
    assert_eq!(&echoed[..n], all);
}

/// What was sent to whoever had the port before, or to nobody, is neither delivered nor counted as lost.
#[test]
fn what_was_sent_before_the_port_was_opened_is_left_out() {
    let (master, path) = pty();
    let mut sim = Device::new(10, SampleFormat::I16);
    let mut bytes = Vec::new();
    for _ in 0..20 {
        let mut source = source(Path::new(&path));
        source.poll(Duration::ZERO, &mut |_| {});
        bytes.clear();
        (0..5).for_each(|_| sim.tick(&mut bytes));
        rustix::io::write(&master, &bytes).unwrap();
        drop(source);
        bytes.clear();
        (0..5).for_each(|_| sim.tick(&mut bytes));
        let _ = rustix::io::write(&master, &bytes);
        (0..5).for_each(|_| sim.tick(&mut Vec::new()));

        let mut source = self::source(Path::new(&path));
        source.poll(Duration::ZERO, &mut |_| {});
        bytes.clear();
        sim.say_hello(&mut bytes);
        let first = sim.encoder.seq();
        (0..10).for_each(|_| sim.tick(&mut bytes));
        rustix::io::write(&master, &bytes).unwrap();
        let mut seqs = Vec::new();
        while seqs.len() < 10 {
            source.poll(SECOND, &mut |message| {
                if let Message::Frame(frame) = message {
                    seqs.push(frame.seq);
                }
            });
        }
        assert!(seqs.iter().copied().eq(first..first + 10), "{seqs:?}");
        let stats = source.stats();
        assert_eq!(stats.losses.n_lost, 0);
        assert_eq!(stats.rejected, RejectedCounts::default());
    }
}
