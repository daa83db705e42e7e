//! The Foxglove protocol, as a client that is not Foxglove's sees it.

use crate::support;

use std::net::TcpStream;
use std::time::{Duration, Instant};

use hapdef_ros::{
    FoxgloveServer, MessageSink, RosEncoder, RosParams, Sinks, TopicKind, definition, from_cdr, msg,
};
use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};

use support::{Kept, say};

const PROTOCOL: &str = "foxglove.sdk.v1";

fn connected(port: u16) -> WebSocket<TcpStream> {
    let mut request = format!("ws://127.0.0.1:{port}/").into_client_request().unwrap();
    let name = "Sec-WebSocket-Protocol";
    request.headers_mut().insert(name, PROTOCOL.parse().unwrap());
    let stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
    let (socket, response) = tungstenite::client(request, stream).unwrap();
    assert_eq!(response.headers()[name], PROTOCOL);
    socket
}

/// The next JSON message with that `op`.
fn next_text(socket: &mut WebSocket<TcpStream>, op: &str) -> Value {
    loop {
        if let Message::Text(text) = socket.read().unwrap() {
            let value: Value = serde_json::from_str(&text).unwrap();
            if value["op"] == op {
                return value;
            }
        }
    }
}

/// The next data message: subscription, time, payload.
fn next_data(socket: &mut WebSocket<TcpStream>) -> (u32, u64, Vec<u8>) {
    loop {
        if let Message::Binary(bytes) = socket.read().unwrap()
            && bytes[0] == 1
        {
            let subscription = u32::from_le_bytes(bytes[1..5].try_into().unwrap());
            let time = u64::from_le_bytes(bytes[5..13].try_into().unwrap());
            return (subscription, time, bytes[13..].to_vec());
        }
    }
}

#[test]
fn a_client_gets_what_it_subscribes_to() {
    let params = RosParams::default();
    let server = FoxgloveServer::start(&params, "127.0.0.1", 0).unwrap();
    let mut socket = connected(server.port());
    let info = next_text(&mut socket, "serverInfo");
    assert_eq!(info["name"], "hapdef");
    let channels = next_text(&mut socket, "advertise")["channels"].clone();
    let channel = |topic: &str| {
        let mut all = channels.as_array().unwrap().iter();
        all.find(|c| c["topic"] == topic).unwrap().clone()
    };
    assert_eq!(channels.as_array().unwrap().len(), TopicKind::all(&params).count());
    let contacts = channel("/hapdef/contacts");
    assert_eq!(contacts["encoding"], "cdr");
    assert_eq!(contacts["schemaName"], "hapdef_msgs/msg/Contacts");
    assert_eq!(contacts["schemaEncoding"], "ros2msg");
    assert_eq!(contacts["schema"], definition("hapdef_msgs/Contacts").unwrap());

    assert!(!server.wants(TopicKind::Contacts));
    let subscription = json!({"id": 77, "channelId": contacts["id"]});
    let subscribe = json!({"op": "subscribe", "subscriptions": [subscription]});
    socket.send(Message::text(subscribe.to_string())).unwrap();
    let deadline = Instant::now() + Duration::from_secs(10);
    while !server.wants(TopicKind::Contacts) && Instant::now() < deadline {
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(!server.wants(TopicKind::Markers));
    assert_eq!(server.n_clients(), 1);

    let kept = Kept::default();
    let sinks = Sinks(vec![Box::new(server), Box::new(kept.clone())]);
    let mut encoder = RosEncoder::new(params, sinks).unwrap();
    for i in 0..50 {
        say(&mut encoder, i, 1_700_000_000_000_000_000 + u64::from(i) * 1_000_000);
    }
    let kept = kept.0.lock().unwrap();
    let sent = kept.iter().filter(|(topic, ..)| *topic == TopicKind::Contacts);
    let mut n_messages = 0;
    for (_, stamp_ns, bytes) in sent {
        let (subscription, time, payload) = next_data(&mut socket);
        assert_eq!((subscription, time, &payload), (77, *stamp_ns, bytes));
        let message: msg::Contacts = from_cdr(&payload).unwrap();
        assert_eq!(message.seq, n_messages);
        n_messages += 1;
    }
    assert_eq!(n_messages, 50);
}

#[test]
fn an_address_that_is_taken_is_an_error_that_names_it() {
    let taken = std::net::TcpListener::bind(("127.0.0.1", 0)).unwrap();
    let port = taken.local_addr().unwrap().port();
    let fault = FoxgloveServer::start(&RosParams::default(), "127.0.0.1", port);
    let text = fault.err().unwrap().to_string();
    assert!(text.contains(&format!("127.0.0.1:{port}")), "{text}");
}
