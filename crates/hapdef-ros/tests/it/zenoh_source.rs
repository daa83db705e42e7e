//! Reading what another session on the loopback publishes as rmw_zenoh's nodes do.

use crate::support;

use std::time::{Duration, Instant};

use hapdef_daq::source::{FrameSource, LinkFault, LinkState, SourceStatus, TopicFault};
use hapdef_daq::{Frame, Message};
use hapdef_ros::{RosError, ZenohSource, ZenohSourceParams, dds_name, msg, to_cdr, type_hash};
use serde::Serialize;
use zenoh::Wait;
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::Publisher;

use support::zenoh_session::{free_address, session};

const DOMAIN: u32 = 7;
/// What has to come within it.
const PATIENCE: Duration = Duration::from_secs(10);
const ARRAY: &str = "std_msgs/Float64MultiArray";

#[derive(Serialize)]
struct Array {
    layout: Layout,
    data: Vec<f64>,
}

#[derive(Default, Serialize)]
struct Layout {
    dim: Vec<u8>,
    data_offset: u32,
}

#[derive(Serialize)]
struct JointState {
    header: msg::Header,
    name: Vec<String>,
    position: Vec<f64>,
    velocity: Vec<f64>,
    effort: Vec<f64>,
}

/// A publisher in the graph of ROS.
struct Talker {
    publisher: Publisher<'static>,
    _token: LivelinessToken,
    n_sent: i64,
}

impl Talker {
    fn new(session: &zenoh::Session, topic: &str, message: &str) -> Self {
        let hash = type_hash(message).unwrap_or("RIHS01_0123");
        Self::with_hash(session, topic, message, hash)
    }

    fn with_hash(session: &zenoh::Session, topic: &str, message: &str, hash: &str) -> Self {
        let (name, zid) = (dds_name(message), session.zid());
        let mangled = topic.replace('/', "%");
        let token = format!(
            "@ros2_lv/{DOMAIN}/{zid}/0/10/MP/%/%/talker/{mangled}/{name}/{hash}/::,10:,:,:,,"
        );
        let key = format!("{DOMAIN}{topic}/{name}/{hash}");
        Self {
            publisher: session.declare_publisher(key).wait().unwrap(),
            _token: session.liveliness().declare_token(token).wait().unwrap(),
            n_sent: 0,
        }
    }

    fn say(&mut self, message: &impl Serialize) {
        self.n_sent += 1;
        let mut attachment = self.n_sent.to_le_bytes().to_vec();
        attachment.extend((1_700_000_000_000_000_000 + self.n_sent * 1_000_000).to_le_bytes());
        attachment.push(16);
        attachment.extend([9; 16]);
        let bytes = to_cdr(message).unwrap();
        self.publisher.put(bytes).attachment(attachment).wait().unwrap();
    }
}

fn array(data: &[f64]) -> Array {
    Array { layout: Layout::default(), data: data.to_vec() }
}

fn open(topic: &str, address: &str, n_gauges: Option<usize>) -> ZenohSource {
    let connect = vec![address.to_owned()];
    let params = ZenohSourceParams { connect, n_gauges, ..ZenohSourceParams::new(DOMAIN, topic) };
    ZenohSource::open(&params).unwrap()
}

/// What the source says until something is as wanted, `meanwhile` done between polls.
#[track_caller]
fn read_until(
    source: &mut ZenohSource,
    mut meanwhile: impl FnMut(),
    is_wanted: impl Fn(&Message) -> bool,
) -> Vec<Message> {
    let deadline = Instant::now() + PATIENCE;
    let mut said = Vec::new();
    while !said.iter().any(&is_wanted) {
        assert!(Instant::now() < deadline, "not within {PATIENCE:?}: {said:?}");
        meanwhile();
        source.poll(Duration::from_millis(20), &mut |message| said.push(message));
    }
    said
}

fn is_frame(message: &Message) -> bool {
    matches!(message, Message::Frame(_))
}

/// The fault that ends the source, and that it has ended.
#[track_caller]
fn refused(source: &mut ZenohSource, meanwhile: impl FnMut()) -> String {
    let is_topic = |message: &Message| matches!(message, Message::Link(LinkState::Topic(_)));
    let said = read_until(source, meanwhile, is_topic);
    let Some(Message::Link(LinkState::Topic(fault))) = said.last() else { panic!("{said:?}") };
    assert!(fault.is_lasting(), "{fault}");
    let status = source.poll(Duration::ZERO, &mut |_| ());
    assert_eq!(status, SourceStatus::Ended);
    fault.to_string()
}

#[test]
fn numbers_arrive_and_gaps_are_lost_frames() {
    let address = free_address();
    let session = session(&address);
    let mut talker = Talker::new(&session, "/arm/strain", ARRAY);
    let mut source = open("/arm/strain", &address, Some(2));
    let said = read_until(&mut source, || talker.say(&array(&[0.0, 0.0])), is_frame);
    assert!(matches!(said[0], Message::Link(LinkState::Open)), "{said:?}");
    assert!(matches!(&said[1], Message::Hello(hello) if hello.channels.len() == 2));

    let first = talker.n_sent + 1;
    for i in 0..300 {
        if i % 100 == 99 {
            talker.n_sent += 4;
        }
        talker.say(&array(&[f64::from(i) + 0.25, -f64::from(i)]));
    }
    let last = talker.n_sent as u32;
    let is_last = |m: &Message| matches!(m, Message::Frame(frame) if frame.seq == last);
    let said = read_until(&mut source, || (), is_last);
    let frames: Vec<&Frame> = said
        .iter()
        .filter_map(|message| match message {
            Message::Frame(frame) if i64::from(frame.seq) >= first => Some(frame),
            _ => None,
        })
        .collect();
    assert_eq!(frames.len(), 300);
    for (i, frame) in frames.iter().enumerate() {
        let x = i as f64;
        assert_eq!(frame.values().collect::<Vec<_>>(), [x + 0.25, -x]);
        assert_eq!(frame.n_lost_before, if i % 100 == 99 { 4 } else { 0 }, "{i}");
        let sent_us = 1_700_000_000_000_000 + u64::from(frame.seq) * 1000;
        assert_eq!(frame.t_device_us, sent_us);
    }
    let stats = source.stats();
    assert_eq!((stats.losses.n_lost, stats.n_opened), (12, 1));
}

#[test]
fn one_list_of_several_has_the_names_and_the_header_the_time() {
    let address = free_address();
    let session = session(&address);
    let mut talker = Talker::new(&session, "/joint_states", "sensor_msgs/JointState");
    let stamp = msg::Time { sec: 12, nanosec: 5_000_000 };
    let state = JointState {
        header: msg::Header { stamp, frame_id: "arm".into() },
        name: vec!["toe".into(), "tip".into(), "heel".into()],
        position: vec![1.0, 2.0, 3.0],
        velocity: Vec::new(),
        effort: vec![4.0, 5.0, 6.0],
    };
    // gauges have names, so that more numbers than gauges are no fault
    let mut source = open("/joint_states.effort", &address, Some(2));
    let said = read_until(&mut source, || talker.say(&state), is_frame);
    let hello = said.iter().find_map(|message| match message {
        Message::Hello(hello) => Some(hello),
        _ => None,
    });
    let names: Vec<String> = hello.unwrap().channels.iter().map(|c| c.name_text()).collect();
    assert_eq!(names, ["toe", "tip", "heel"]);
    let Some(Message::Frame(frame)) = said.iter().find(|m| is_frame(m)) else { panic!() };
    assert_eq!(frame.values().collect::<Vec<_>>(), [4.0, 5.0, 6.0]);
    assert_eq!(frame.t_device_us, 12_005_000);

    let mut unnamed = open("/joint_states", &address, None);
    let text = refused(&mut unnamed, || talker.say(&state));
    assert!(text.contains("\"position\" and \"effort\": name one as TOPIC.position"), "{text}");
}

/// A publisher says in the graph what it publishes, before its first message.
#[test]
fn another_type_is_refused_before_a_message_comes() {
    let address = free_address();
    let session = session(&address);
    let _talker = Talker::new(&session, "/strain", "std_msgs/String");
    let text = refused(&mut open("/strain", &address, None), || ());
    assert!(text.contains("topic /strain: its messages are std_msgs/String, expected"), "{text}");
    assert!(text.contains("std_msgs/Float32MultiArray, "), "{text}");

    let _other = Talker::with_hash(&session, "/other", ARRAY, "RIHS01_abc");
    let text = refused(&mut open("/other", &address, None), || ());
    assert!(text.contains(&format!("{ARRAY} by another definition (RIHS01_abc)")), "{text}");
}

/// A node that comes in its place with another type is reported, not read as if it were the same.
#[test]
fn another_type_later_is_left_out() {
    let address = free_address();
    let session = session(&address);
    let mut talker = Talker::new(&session, "/strain", ARRAY);
    let mut other = Talker::new(&session, "/strain", "std_msgs/Float32MultiArray");
    let mut source = open("/strain", &address, Some(2));
    read_until(&mut source, || talker.say(&array(&[1.0, 2.0])), is_frame);
    let is_unlike = |message: &Message| {
        matches!(message, Message::Link(LinkState::Topic(TopicFault::Unlike { .. })))
    };
    let said = read_until(&mut source, || other.say(&array(&[3.0, 4.0])), is_unlike);
    let Some(Message::Link(state)) = said.last() else { panic!("{said:?}") };
    let expected =
        "it is of std_msgs/Float32MultiArray, the first was of std_msgs/Float64MultiArray";
    assert!(state.to_string().contains(expected), "{state}");
    let said = read_until(&mut source, || talker.say(&array(&[1.0, 2.0])), is_frame);
    let Some(Message::Frame(frame)) = said.iter().find(|m| is_frame(m)) else { panic!() };
    assert_eq!(frame.values().collect::<Vec<_>>(), [1.0, 2.0]);
    assert!(frame.n_lost_before > 0);
}

#[test]
fn another_number_of_channels_is_refused() {
    let address = free_address();
    let session = session(&address);
    let mut talker = Talker::new(&session, "/strain", ARRAY);
    let mut source = open("/strain", &address, Some(10));
    let text = refused(&mut source, || talker.say(&array(&[1.0, 2.0, 3.0])));
    assert!(text.contains("topic /strain: a message has 3 numbers, expected 10"), "{text}");
}

/// No router, then one without the topic, then a silent publisher: each is reported within 3 s, and waited for.
#[test]
fn what_is_missing_is_told_and_waited_for() {
    let address = free_address();
    let mut source = open("/strain", &address, None);
    let start = Instant::now();
    let is_away = |message: &Message| matches!(message, Message::Link(LinkState::Away(_)));
    let said = read_until(&mut source, || (), is_away);
    assert!(start.elapsed() < Duration::from_secs(3));
    let [Message::Link(LinkState::Away(fault @ LinkFault::NoRouter { .. }))] = &said[..] else {
        panic!("{said:?}")
    };
    assert!(fault.to_string().contains(&format!("no router of zenoh at {address}")), "{fault}");

    let session = session(&address);
    let _other = Talker::new(&session, "/joint_states", "sensor_msgs/JointState");
    let said = read_until(&mut source, || (), is_away);
    let Some(Message::Link(LinkState::Away(fault))) = said.last() else { panic!("{said:?}") };
    let expected = "topic /strain: nobody publishes it; in ROS_DOMAIN_ID 7 there is /joint_states \
                    (sensor_msgs/JointState)";
    assert!(fault.to_string().starts_with(expected), "{fault}");

    let mut talker = Talker::new(&session, "/strain", ARRAY);
    let is_silent = |message: &Message| {
        matches!(message, Message::Link(LinkState::Topic(TopicFault::Silent { for_s: 2, .. })))
    };
    read_until(&mut source, || (), is_silent);
    let said = read_until(&mut source, || talker.say(&array(&[1.0])), is_frame);
    assert!(matches!(said[0], Message::Link(LinkState::Open)), "{said:?}");

    let start = Instant::now();
    read_until(&mut source, || (), is_silent);
    assert!(start.elapsed() < Duration::from_secs(3));
    let said = read_until(&mut source, || talker.say(&array(&[1.0])), is_frame);
    assert!(matches!(said[0], Message::Link(LinkState::Open)), "{said:?}");
    assert_eq!(source.stats().n_opened, 2);
}

#[test]
fn what_is_no_topic_is_refused() {
    for topic in ["strain", "/", "/a//b", "/a/*", "/str ain", "/strain/"] {
        let fault = ZenohSource::open(&ZenohSourceParams::new(0, topic)).err().unwrap();
        assert!(matches!(fault, RosError::Parameter { name: "topic", .. }), "{topic}: {fault}");
    }
}
