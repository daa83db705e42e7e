//! Frames to pages, fast and slow, and what happens when one goes away.

use crate::support::page;
use crate::support::synthetic;

use std::time::Duration;

use hapdef_view::{DeviceState, ViewCommand, ViewError, ViewFrame, ViewParams};
use page::{
    Socket, TOKEN, connect, greet, greet_with_device, next_binary, next_text, params, say, seq_of,
    serve,
};

const SOON: Duration = Duration::from_secs(5);

fn a_frame() -> ViewFrame {
    let mut frame = ViewFrame::default();
    synthetic::show(&synthetic::picture(), &synthetic::wandering(1.0), 1.0, &mut frame);
    frame
}

/// Draws frames until number `seq` came; how many there were.
fn draw_until(socket: &mut Socket, seq: u32) -> u32 {
    for n in 1.. {
        let found = seq_of(&next_binary(socket));
        say(socket, r#"{"cmd":"got"}"#);
        if found == seq {
            return n;
        }
        assert!(found < seq, "frame {found} after {seq}");
    }
    0
}

/// Resident memory of this process, bytes.
#[cfg(target_os = "linux")]
fn resident() -> i64 {
    let statm = std::fs::read_to_string("/proc/self/statm").unwrap();
    4096 * statm.split(' ').nth(1).unwrap().parse::<i64>().unwrap()
}

#[test]
fn a_frame_comes_as_it_was_pushed() {
    let view = serve(params());
    let mut socket = connect(view.address().port());
    let hello = greet(&mut socket, Some(TOKEN));
    assert_eq!(hello["gauges"].as_array().unwrap().len(), 10);
    let frame = a_frame();
    view.push(&frame).unwrap();
    let bytes = next_binary(&mut socket);
    let reading = f32::from_le_bytes(bytes[76..80].try_into().unwrap());
    assert_eq!(reading, frame.readings_ue[0] as f32);
    assert_eq!(bytes.len(), 76 + 120 + 12 + 80 * frame.contacts.len() + 12 * 3216);
}

#[test]
fn a_page_that_comes_later_sees_the_last_frame() {
    let view = serve(params());
    let frame = a_frame();
    let numbers: Vec<u64> = (0..5).map(|_| view.push(&frame).unwrap()).collect();
    assert_eq!(numbers, [1, 2, 3, 4, 5]);
    let mut socket = connect(view.address().port());
    greet(&mut socket, None);
    assert_eq!(seq_of(&next_binary(&mut socket)), 5);
}

/// One page never reads, one draws: pushing a minute of frames comes to its end, memory stays, the drawing
/// page ends with the newest frame, and what the other missed is counted.
#[cfg(target_os = "linux")]
#[test]
fn a_stalled_page_costs_nothing() {
    let view = serve(params());
    let port = view.address().port();
    let mut stalled = connect(port);
    greet(&mut stalled, None);
    let mut drawing = connect(port);
    greet(&mut drawing, None);
    let frame = a_frame();
    for _ in 0..200 {
        view.push(&frame).unwrap();
    }
    let before = resident();
    let reader = std::thread::spawn(move || (draw_until(&mut drawing, 60_200), drawing));
    for _ in 0..60_000 {
        view.push(&frame).unwrap();
    }
    let grown = resident() - before;
    let (drawn, _drawing) = reader.join().unwrap();
    println!("memory {} KiB more, {drawn} frames drawn", grown >> 10);
    assert!(grown < 16 << 20, "{grown} bytes more");
    let clients = view.clients();
    assert_eq!(clients[0].n_sent, 3, "{clients:?}");
    assert_eq!(clients[0].n_skipped, 60_200 - 3, "{clients:?}");
    assert_eq!(clients[1].n_sent, u64::from(drawn), "{clients:?}");
}

#[test]
fn a_press_ends_with_its_page() {
    let view = serve(params());
    let mut socket = connect(view.address().port());
    greet(&mut socket, Some(TOKEN));
    say(&mut socket, r#"{"cmd":"press","point_m":[0,0,0.1],"normal":[0,1,0],"force_n":2.5}"#);
    let pressed = view.commands().recv_timeout(SOON).unwrap();
    assert!(matches!(pressed, ViewCommand::Press { force_n: 2.5, .. }), "{pressed:?}");
    drop(socket);
    assert_eq!(view.commands().recv_timeout(SOON), Ok(ViewCommand::Release));
}

const PRESS: &str = r#"{"cmd":"press","point_m":[0,0,0.1],"normal":[0,1,0],"force_n":2.5}"#;

/// Waits until a page has said so much that everything before it was read.
fn is_heard(socket: &mut Socket) {
    say(socket, "nonsense");
    while next_text(socket)["type"] != "refused" {}
}

#[test]
fn a_press_ends_though_too_many_commands_wait() {
    let view = serve(params());
    let mut socket = connect(view.address().port());
    greet(&mut socket, Some(TOKEN));
    (0..256).for_each(|_| say(&mut socket, PRESS));
    say(&mut socket, r#"{"cmd":"tare"}"#);
    assert_eq!(next_text(&mut socket)["text"], "too many commands at a time");
    say(&mut socket, r#"{"cmd":"release"}"#);
    is_heard(&mut socket);
    for n in 0..256 {
        let command = view.commands().recv_timeout(SOON).unwrap();
        assert!(matches!(command, ViewCommand::Press { .. }), "{n} {command:?}");
    }
    assert_eq!(view.commands().recv_timeout(SOON), Ok(ViewCommand::Release));
}

#[test]
fn a_press_does_not_end_with_another_page() {
    let view = serve(params());
    let mut pressing = connect(view.address().port());
    greet(&mut pressing, Some(TOKEN));
    let mut other = connect(view.address().port());
    greet(&mut other, Some(TOKEN));
    say(&mut other, PRESS);
    is_heard(&mut other);
    say(&mut pressing, PRESS);
    is_heard(&mut pressing);
    say(&mut other, r#"{"cmd":"release"}"#);
    is_heard(&mut other);
    drop(other);
    while view.clients().len() > 1 {
        std::thread::sleep(Duration::from_millis(5));
    }
    drop(pressing);
    let commands: Vec<_> = (0..3).map(|_| view.commands().recv_timeout(SOON)).collect();
    assert!(matches!(
        commands[..2],
        [Ok(ViewCommand::Press { .. }), Ok(ViewCommand::Press { .. })]
    ));
    assert_eq!(commands[2], Ok(ViewCommand::Release));
    assert!(view.commands().try_recv().is_err());
}

#[test]
fn what_a_page_drew_is_reported_by_its_number() {
    let view = serve(params());
    let mut socket = connect(view.address().port());
    greet(&mut socket, None);
    let number = view.push(&a_frame()).unwrap();
    assert_eq!(u64::from(seq_of(&next_binary(&mut socket))), number);
    say(&mut socket, r#"{"cmd":"got"}"#);
    is_heard(&mut socket);
    let client = view.clients()[0];
    assert_eq!((client.n_taken, client.last_drawn), (1, 0));
    view.push(&a_frame()).unwrap();
    next_binary(&mut socket);
    say(&mut socket, r#"{"cmd":"got","drawn":2}"#);
    is_heard(&mut socket);
    let client = view.clients()[0];
    assert_eq!((client.n_taken, client.last_drawn), (2, 2));
}

#[test]
fn what_is_said_reaches_the_page() {
    let view = serve(params());
    let mut socket = connect(view.address().port());
    greet(&mut socket, None);
    view.pusher().say("recorded to a.mcap");
    let notice = next_text(&mut socket);
    assert_eq!(
        (notice["type"].as_str(), notice["text"].as_str()),
        (Some("notice"), Some("recorded to a.mcap"))
    );
}

#[test]
fn a_page_learns_of_the_device_however_late_it_comes() {
    let view = serve(params());
    let port = view.address().port();
    let mut early = connect(port);
    let (_, device) = greet_with_device(&mut early, None);
    assert_eq!(device["simulated"], false);
    assert_eq!(device["fault"], serde_json::Value::Null);
    let mut state = DeviceState { is_simulated: true, fault: Some("unplugged".to_owned()) };
    view.set_device(&state);
    let first = next_text(&mut early);
    let (_, late) = greet_with_device(&mut connect(port), None);
    for text in [first, late] {
        assert_eq!(text["type"], "device");
        assert_eq!(text["simulated"], true);
        assert_eq!(text["fault"], "unplugged");
    }
    // What is known already is not sent again.
    view.set_device(&state);
    state.fault = None;
    view.set_device(&state);
    assert_eq!(next_text(&mut early)["fault"], serde_json::Value::Null);
}

#[test]
fn frames_of_another_shape_are_refused() {
    let view = serve(params());
    let refused = view.push(&ViewFrame::default());
    assert!(matches!(refused, Err(ViewError::FrameShape { expected: 10, found: 0, .. })));
}

#[test]
fn the_port_is_free_again() {
    let view = serve(params());
    let bind = view.address();
    let mut socket = connect(bind.port());
    greet(&mut socket, None);
    let taken =
        hapdef_view::ViewServer::start(ViewParams { bind, ..params() }, synthetic::picture());
    assert!(matches!(taken.err(), Some(ViewError::Bind { .. })));
    drop(view);
    greet(&mut connect(serve(ViewParams { bind, ..params() }).address().port()), None);
}
