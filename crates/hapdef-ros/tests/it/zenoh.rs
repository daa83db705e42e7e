//! Publishing as rmw_zenoh does: what another session on the loopback receives.

use crate::support;

use std::time::{Duration, Instant};

use hapdef_ros::{
    RosEncoder, RosParams, Sinks, TopicKind, ZenohParams, ZenohSink, dds_name, type_hash,
};
use zenoh::Wait;

use support::zenoh_session::{free_address, session};
use support::{Kept, say};

#[test]
fn messages_arrive_under_the_keys_of_rmw_zenoh() {
    let address = free_address();
    let listener = session(&address);
    let name = dds_name("hapdef_msgs/Contacts");
    let hash = type_hash("hapdef_msgs/Contacts").unwrap();
    let key = format!("7/hapdef/contacts/{name}/{hash}");
    let subscriber = listener.declare_subscriber(&key).wait().unwrap();

    let params = RosParams::default();
    let zenoh_params = ZenohParams {
        domain_id: 7,
        node: "limb".into(),
        connect: vec![address],
        ..ZenohParams::default()
    };
    let sink = ZenohSink::open(&params, &zenoh_params).unwrap();
    let zid = sink.session_id();

    // The node and its publishers are in the graph.
    let deadline = Instant::now() + Duration::from_secs(10);
    let mut tokens = Vec::new();
    while tokens.len() < 1 + TopicKind::all(&params).count() && Instant::now() < deadline {
        let replies = listener.liveliness().get("@ros2_lv/7/**").wait().unwrap();
        tokens = replies
            .iter()
            .filter_map(|reply| Some(reply.result().ok()?.key_expr().to_string()))
            .collect();
        std::thread::sleep(Duration::from_millis(50));
    }
    assert!(tokens.contains(&format!("@ros2_lv/7/{zid}/0/0/NN/%/%/limb")), "{tokens:?}");
    let publisher = format!("MP/%/%/limb/%hapdef%contacts/{name}/{hash}/::,10:,:,:,,");
    assert!(tokens.iter().any(|token| token.ends_with(&publisher)), "{tokens:?}");

    let kept = Kept::default();
    let sinks = Sinks(vec![Box::new(sink), Box::new(kept.clone())]);
    let mut encoder = RosEncoder::new(params, sinks).unwrap();
    for i in 0..20 {
        say(&mut encoder, i, 1_700_000_000_000_000_000 + u64::from(i));
    }
    let kept = kept.0.lock().unwrap();
    let sent = kept.iter().filter(|(topic, ..)| *topic == TopicKind::Contacts);
    let mut n_received = 0i64;
    for (_, stamp_ns, bytes) in sent {
        let sample = subscriber.recv_timeout(Duration::from_secs(10)).unwrap();
        let sample = sample.expect("a message within ten seconds");
        n_received += 1;
        assert_eq!(sample.payload().to_bytes(), bytes.as_slice());
        let attachment = sample.attachment().unwrap().to_bytes();
        assert_eq!(attachment.len(), 33);
        assert_eq!(attachment[..8], n_received.to_le_bytes());
        assert_eq!(attachment[8..16], stamp_ns.to_le_bytes());
    }
    assert_eq!(n_received, 20);
}
