//! Messages of a topic of ROS 2 as they come: frames, their times, and what is missing.

use hapdef_daq::record::{Arrived, Numbered, TopicReader};
use hapdef_daq::source::{LinkState, TopicFault};
use hapdef_daq::{Frame, Message};

const STRAIN: &str = "\
std_msgs/Header header
float64[] strain
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
";

/// A second, ns.
const SECOND: u64 = 1_000_000_000;
/// When the first message is sent, by its publisher's clock.
const SENT: u64 = 1_700_000_000 * SECOND;

/// A message with a time in its header, ns.
fn message(stamp_ns: u64, values: &[f64]) -> Vec<u8> {
    let mut bytes = vec![0, 1, 0, 0];
    bytes.extend(((stamp_ns / SECOND) as u32).to_le_bytes());
    bytes.extend(((stamp_ns % SECOND) as u32).to_le_bytes());
    // an empty frame; what follows is aligned by four bytes, and by eight
    bytes.extend([1, 0, 0, 0, 0, 0, 0, 0]);
    bytes.extend((values.len() as u32).to_le_bytes());
    bytes.extend([0; 4]);
    bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    bytes
}

fn reader(n_gauges: Option<usize>) -> TopicReader {
    TopicReader::new("/strain", "x_msgs/Strain", STRAIN, n_gauges).unwrap()
}

/// What comes of messages of publisher, number and arrival in ms.
fn read(
    reader: &mut TopicReader,
    messages: &[(u8, i64, u64)],
    bytes: impl Fn(i64) -> Vec<u8>,
) -> Vec<Message> {
    let mut said = Vec::new();
    for &(publisher, number, arrival_ms) in messages {
        let sent_ns = SENT + arrival_ms * 1_000_000;
        let numbered = Some(Numbered { publisher: [publisher; 16], number, sent_ns });
        let arrival_ns = arrival_ms * 1_000_000 + 7;
        let arrived = Arrived { numbered, arrival_ns, bytes: &bytes(number) };
        reader.take(&arrived, &mut |message| said.push(message)).unwrap();
    }
    said
}

fn frames(said: &[Message]) -> Vec<&Frame> {
    let mut frames = Vec::new();
    for message in said {
        if let Message::Frame(frame) = message {
            frames.push(frame);
        }
    }
    frames
}

fn faults(said: &[Message]) -> Vec<&TopicFault> {
    let mut faults = Vec::new();
    for message in said {
        if let Message::Link(LinkState::Topic(fault)) = message {
            faults.push(fault);
        }
    }
    faults
}

#[test]
fn gaps_in_the_numbers_are_lost_frames() {
    let mut reader = reader(Some(2));
    let numbers = [(1, 5, 0), (1, 6, 1), (1, 9, 4), (1, 9, 5), (1, 8, 6), (1, 10, 7)];
    let said = read(&mut reader, &numbers, |n| message(0, &[n as f64, 0.5]));
    assert!(matches!(&said[0], Message::Hello(hello) if hello.channels.len() == 2));
    let found: Vec<_> = frames(&said)
        .into_iter()
        .map(|f| (f.seq, f.n_lost_before, f.values().collect::<Vec<_>>()))
        .collect();
    let of = |seq: u32, n_lost| (seq, n_lost, vec![f64::from(seq), 0.5]);
    assert_eq!(found, [of(5, 0), of(6, 0), of(9, 2), of(10, 0)]);
    let stats = reader.stats();
    assert_eq!((stats.n_frames, stats.losses.n_lost, stats.losses.n_delivered), (4, 2, 4));
    assert_eq!((stats.rejected.n_repeats, stats.rejected.n_backwards), (1, 1));
}

/// The publisher's clock is years off and its messages arrive up to 3 ms late.
#[test]
fn times_are_those_of_the_headers_on_this_machines_clock() {
    let mut reader = reader(None);
    let mut said = Vec::new();
    for i in 0..5000_u64 {
        let arrival_ns = SECOND + i * 1_000_000 + i * 7919 % 3_000_000;
        let bytes = message(SENT + i * 1_000_000, &[1.0]);
        let numbered = Numbered { publisher: [1; 16], number: i as i64, sent_ns: 0 };
        let arrived = Arrived { numbered: Some(numbered), arrival_ns, bytes: &bytes };
        reader.take(&arrived, &mut |message| said.push(message)).unwrap();
    }
    let frames = frames(&said);
    assert_eq!(frames[0].t_device_us, SENT / 1000);
    for (i, frame) in frames.iter().enumerate().skip(4000) {
        let off_ns = frame.t_host_ns.abs_diff(SECOND + i as u64 * 1_000_000);
        assert!(off_ns < 20_000, "{i}: {off_ns} ns");
    }
    assert_eq!(reader.stats().n_host_time, 0);
}

/// Without a time in the message that of its sending counts, and without that the arrival.
#[test]
fn a_message_without_a_time_has_that_of_its_sending_or_arrival() {
    let mut reader = reader(None);
    let said = read(&mut reader, &[(1, 1, 10), (1, 2, 20)], |_| message(0, &[1.0]));
    let sent: Vec<u64> = frames(&said).iter().map(|frame| frame.t_device_us).collect();
    assert_eq!(sent, [SENT / 1000 + 10_000, SENT / 1000 + 20_000]);

    let mut alone = self::reader(None);
    let mut said = Vec::new();
    for arrival_ns in [5_000, 9_000] {
        let arrived = Arrived { numbered: None, arrival_ns, bytes: &message(0, &[1.0]) };
        alone.take(&arrived, &mut |message| said.push(message)).unwrap();
    }
    let found: Vec<_> = frames(&said).iter().map(|f| (f.seq, f.t_host_ns)).collect();
    assert_eq!(found, [(0, 5_000), (1, 9_000)]);
}

#[test]
fn another_publisher_is_left_out_and_follows_when_the_first_is_gone() {
    let mut reader = reader(None);
    let both = [(1, 1, 0), (2, 70, 1), (1, 2, 2), (2, 71, 3), (1, 3, 4)];
    let said = read(&mut reader, &both, |n| message(0, &[n as f64]));
    assert_eq!(frames(&said).iter().map(|f| f.seq).collect::<Vec<_>>(), [1, 2, 3]);
    assert!(matches!(faults(&said)[..], [TopicFault::Several { .. }]), "{said:?}");
    assert_eq!(reader.stats().rejected.n_schema, 2);

    let said = read(&mut reader, &[(2, 90, 1100), (2, 91, 1101)], |n| message(0, &[n as f64]));
    assert!(matches!(said[0], Message::Restarted));
    let found: Vec<_> = frames(&said).iter().map(|f| (f.seq, f.n_lost_before)).collect();
    assert_eq!(found, [(90, 0), (91, 0)]);
    assert_eq!(reader.stats().losses.n_restarts, 1);
}

#[test]
fn a_message_unlike_the_first_counts_as_lost() {
    let mut reader = reader(None);
    let bytes = |n| match n {
        2 | 3 => message(0, &[1.0]),
        _ => message(0, &[1.0, 2.0]),
    };
    let said = read(&mut reader, &[(1, 1, 0), (1, 2, 1), (1, 3, 2), (1, 4, 3)], bytes);
    let found: Vec<_> = frames(&said).iter().map(|f| (f.seq, f.n_lost_before)).collect();
    assert_eq!(found, [(1, 0), (4, 2)]);
    let [fault] = faults(&said)[..] else { panic!("{said:?}") };
    assert!(fault.to_string().contains("1 numbers, the first message has 2"), "{fault}");
}

#[test]
fn messages_without_numbers_for_these_gauges_are_refused_for_good() {
    let refused = |n_gauges, bytes: &[u8]| {
        let arrived = Arrived { numbered: None, arrival_ns: 1, bytes };
        let fault = reader(n_gauges).take(&arrived, &mut |_| ()).unwrap_err();
        assert!(fault.is_lasting());
        fault.to_string()
    };
    let other = refused(Some(3), &message(0, &[1.0, 2.0]));
    assert!(other.contains("topic /strain: a message has 2 numbers, expected 3"), "{other}");
    let many = refused(None, &message(0, &[0.0; 65]));
    assert!(many.contains("65 numbers a message: a device has at most 64"), "{many}");
    let none = refused(None, &message(0, &[]));
    assert!(none.contains("no numbers: it has header, strain"), "{none}");
    let short = refused(None, &[0, 1, 0, 0, 9]);
    assert!(short.contains("shorter than its definition"), "{short}");
}
