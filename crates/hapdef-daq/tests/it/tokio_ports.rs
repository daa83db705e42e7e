//! Several boards on one tokio runtime: every lost frame is counted there, too.

use crate::support;

use std::io::Write;
use std::net::TcpListener;
use std::os::fd::OwnedFd;
use std::os::unix::fs::symlink;
use std::time::{Duration, Instant};

use hapdef_daq::hdp1::SampleFormat;
use hapdef_daq::source::{
    AsyncLink, AsyncSerial, AsyncSource, AsyncTcp, LinkFault, LinkState, SerialParams, StreamParams,
};
use hapdef_daq::{Frame, Message};
use support::{Device, is_right, pty};
use tokio::io::{DuplexStream, duplex};
use tokio::time::{sleep, timeout};

const SECOND: Duration = Duration::from_secs(1);

/// A link that takes longer to open than anybody waits for a message.
struct SlowLink;

impl AsyncLink for SlowLink {
    type Stream = DuplexStream;

    fn open(&self) -> impl Future<Output = Result<DuplexStream, LinkFault>> + Send + 'static {
        let opened = sleep(Duration::from_millis(20));
        async move {
            opened.await;
            Ok(duplex(64).0)
        }
    }

    fn name(&self) -> String {
        "slow".to_owned()
    }
}

fn serial(path: &str) -> AsyncSource<AsyncSerial> {
    let link = AsyncSerial::new(path, SerialParams::default());
    AsyncSource::new(link, StreamParams::default())
}

/// The first message that `wanted` takes. Waiting is given up and begun again a thousand times a second.
async fn until<L: AsyncLink, T>(
    source: &mut AsyncSource<L>,
    mut wanted: impl FnMut(&Message) -> Option<T>,
) -> T {
    let start = Instant::now();
    loop {
        assert!(start.elapsed() < SECOND, "{}: it has not come", source.name());
        let Ok(message) = timeout(Duration::from_millis(1), source.next()).await else {
            continue;
        };
        if let Some(found) = wanted(&message) {
            return found;
        }
    }
}

fn frame(message: &Message) -> Option<Frame> {
    match message {
        Message::Frame(frame) => Some(*frame),
        _ => None,
    }
}

fn open(message: &Message) -> Option<()> {
    matches!(message, Message::Link(LinkState::Open)).then_some(())
}

/// Sends a thousand packets at 1 kHz but for every `nth`: how many it left out.
async fn play(master: &OwnedFd, nth: u32) -> u32 {
    let mut device = Device::new(10, SampleFormat::I16);
    let mut n_left_out = 0;
    for n in 0..1000 {
        let mut bytes = Vec::new();
        device.tick(&mut bytes);
        // The last one shows that those before it are missing.
        if n > 0 && n % nth == 0 && n < 999 {
            n_left_out += 1;
        } else {
            rustix::io::write(master, &bytes).unwrap();
        }
        sleep(Duration::from_millis(1)).await;
    }
    n_left_out
}

/// Reads to packet 999, whatever is given up in between.
async fn read(source: &mut AsyncSource<AsyncSerial>) {
    loop {
        let Ok(message) = timeout(Duration::from_millis(1), source.next()).await else {
            continue;
        };
        let Some(frame) = frame(&message) else {
            continue;
        };
        assert!(is_right(&frame), "{frame:?}");
        if frame.seq == 999 {
            return;
        }
    }
}

#[tokio::test]
async fn one_thread_reads_two_boards_and_counts_what_each_lost() {
    let (ours, theirs) = (pty(), pty());
    let (mut left, mut right) = (serial(&ours.1), serial(&theirs.1));
    until(&mut left, open).await;
    until(&mut right, open).await;
    let reading = async { tokio::join!(read(&mut left), read(&mut right)) };
    let (lost_left, lost_right, _) =
        tokio::join!(play(&ours.0, 7), play(&theirs.0, 11), timeout(10 * SECOND, reading));
    for (source, n_lost) in [(&left, lost_left), (&right, lost_right)] {
        let losses = source.stats().losses;
        assert_eq!(losses.n_lost, u64::from(n_lost), "{losses:?}");
        assert_eq!(losses.n_delivered, 1000 - u64::from(n_lost));
    }
    assert_eq!((lost_left, lost_right), (142, 90));
}

#[tokio::test]
async fn unplug_and_replug() {
    let folder = tempfile::tempdir().unwrap();
    let stable = folder.path().join("usb-device");
    let (master, path) = pty();
    symlink(&path, &stable).unwrap();
    let mut source = serial(stable.to_str().unwrap());
    until(&mut source, open).await;
    let pulled = Instant::now();
    drop(master);
    let fault = until(&mut source, |message| match message {
        Message::Link(LinkState::Away(fault)) => Some(fault.clone()),
        _ => None,
    });
    let fault = fault.await;
    assert!(matches!(fault, LinkFault::Disconnected { .. }), "{fault}");
    assert!(pulled.elapsed() <= Duration::from_millis(50));

    let (master, path) = pty();
    std::fs::remove_file(&stable).unwrap();
    symlink(&path, &stable).unwrap();
    until(&mut source, open).await;
    let mut bytes = Vec::new();
    Device::new(4, SampleFormat::I32).tick(&mut bytes);
    rustix::io::write(&master, &bytes).unwrap();
    let frame = until(&mut source, frame).await;
    assert!(is_right(&frame));
    assert_eq!(source.stats().n_opened, 2);
}

#[tokio::test]
async fn what_cannot_be_opened_says_why() {
    let away = |message: &Message| match message {
        Message::Link(LinkState::Away(fault)) => Some(fault.clone()),
        _ => None,
    };
    let fault = until(&mut serial("/dev/ttyNONE7"), away).await;
    assert!(matches!(fault, LinkFault::NotFound { .. }), "{fault}");
    let (_master, path) = pty();
    let mut first = serial(&path);
    until(&mut first, open).await;
    let fault = until(&mut serial(&path), away).await;
    assert!(matches!(fault, LinkFault::Busy { .. }), "{fault}");
    let closed = TcpListener::bind("127.0.0.1:0").unwrap().local_addr();
    let link = AsyncTcp::new(&closed.unwrap().to_string());
    let fault = until(&mut AsyncSource::new(link, StreamParams::default()), away).await;
    assert!(matches!(fault, LinkFault::Refused { .. }), "{fault}");
}

#[tokio::test]
async fn boards_on_the_network_are_read_and_their_end_is_noticed() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let link = AsyncTcp::new(&listener.local_addr().unwrap().to_string());
    let mut source = AsyncSource::new(link, StreamParams::default());
    until(&mut source, open).await;
    let (mut board, _) = listener.accept().unwrap();
    let mut bytes = Vec::new();
    let mut device = Device::new(10, SampleFormat::I24);
    (0..3).for_each(|_| device.tick(&mut bytes));
    board.write_all(&bytes).unwrap();
    let last = until(&mut source, |m| frame(m).filter(|frame| frame.seq == 2)).await;
    assert!(is_right(&last));
    drop(board);
    let fault = until(&mut source, |message| match message {
        Message::Link(LinkState::Away(fault)) => Some(fault.clone()),
        _ => None,
    });
    assert!(matches!(fault.await, LinkFault::Disconnected { .. }));
}

#[tokio::test]
async fn opening_goes_on_where_waiting_for_it_was_given_up() {
    let mut source = AsyncSource::new(SlowLink, StreamParams::default());
    until(&mut source, open).await;
    assert_eq!(source.stats().n_opened, 1);
}
