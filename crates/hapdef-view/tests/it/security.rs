//! The rules of who may see the page and command it, one test each.

use crate::support::page;

use std::net::SocketAddr;
use std::time::{Duration, Instant};

use hapdef_view::{ViewCommand, ViewParams};
use page::{TOKEN, connect, connect_as, greet, next_text, params, request, say, serve};
use tungstenite::{Error, Message};

const SOON: Duration = Duration::from_secs(5);

#[track_caller]
fn check_page(host: &str, origin: Option<&str>, expected: u16) {
    let view = serve(params());
    let port = view.address().port();
    let mut headers = vec![format!("Host: {}", host.replace("PORT", &port.to_string()))];
    headers.extend(
        origin.map(|origin| format!("Origin: {}", origin.replace("PORT", &port.to_string()))),
    );
    let lines: Vec<&str> = headers.iter().map(String::as_str).collect();
    for path in ["/", "/js/main.js", "/live", "/nothing"] {
        let (status, _, body) = request(port, "GET", path, &lines);
        if expected == 403 {
            assert_eq!(status, 403, "{path} {lines:?}");
            assert!(body.len() < 100, "{path}: {} bytes", body.len());
        } else {
            assert_ne!(status, 403, "{path} {lines:?}");
        }
    }
}

#[test]
fn a_name_rebound_to_loopback_gets_403() {
    check_page("evil.example", None, 403);
    check_page("evil.example:PORT", None, 403);
    check_page("evil.example:PORT", Some("http://evil.example:PORT"), 403);
}

#[test]
fn own_hosts_are_served() {
    check_page("127.0.0.1:PORT", None, 200);
    check_page("localhost:PORT", Some("http://localhost:PORT"), 200);
}

#[test]
fn another_port_is_another_host() {
    check_page("127.0.0.1", None, 403);
    check_page("127.0.0.1:1", None, 403);
}

#[test]
fn pages_of_other_origins_cannot_connect() {
    let view = serve(params());
    let port = view.address().port();
    let own = format!("127.0.0.1:{port}");
    for origin in ["http://evil.example", "null", "https://127.0.0.1", "http://127.0.0.1:1"] {
        assert_eq!(connect_as(port, &own, Some(origin)).err(), Some(403), "{origin}");
    }
    assert_eq!(connect_as(port, "evil.example", None).err(), Some(403));
    assert!(connect_as(port, &own, Some(&format!("http://{own}"))).is_ok());
}

#[test]
fn every_answer_has_the_policy_and_no_cors() {
    let view = serve(params());
    let port = view.address().port();
    let own = format!("Host: 127.0.0.1:{port}");
    let policy = "content-security-policy: default-src 'none'; script-src 'self'; style-src 'self'; \
         connect-src 'self'; img-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'\r\n";
    for (path, host) in [("/", own.as_str()), ("/nothing", &own), ("/", "Host: evil.example")] {
        let (_, head, _) = request(port, "GET", path, &[host, "Accept: */*"]);
        let head = head + "\r\n";
        assert!(head.contains(policy), "{path} {host}: {head}");
        assert!(head.contains("x-content-type-options: nosniff"), "{head}");
        assert!(!head.contains("access-control"), "{head}");
    }
}

#[test]
fn nothing_is_written_by_requests() {
    let view = serve(params());
    let port = view.address().port();
    let own = format!("Host: 127.0.0.1:{port}");
    for method in ["POST", "PUT", "DELETE", "OPTIONS"] {
        let (status, head, _) = request(port, method, "/", &[&own, "Content-Length: 0"]);
        assert_eq!(status, 405, "{method}: {head}");
    }
}

#[test]
fn commands_need_the_token() {
    let view = serve(params());
    let wrong = "10112233445566778899aabbccddeeff";
    for token in [None, Some(""), Some(wrong)] {
        let mut socket = connect(view.address().port());
        let hello = greet(&mut socket, token);
        assert_eq!(hello["offers"]["commands"], false);
        assert_eq!(hello["offers"]["press"], serde_json::Value::Null);
        say(&mut socket, r#"{"cmd":"tare"}"#);
        assert_eq!(next_text(&mut socket)["type"], "refused");
    }
    assert!(view.commands().try_recv().is_err());
}

#[test]
fn the_token_commands() {
    let view = serve(params());
    assert!(view.url().ends_with(&format!("/#token={TOKEN}")), "{}", view.url());
    let mut socket = connect(view.address().port());
    assert_eq!(greet(&mut socket, Some(TOKEN))["offers"]["commands"], true);
    say(&mut socket, r#"{"cmd":"record","on":true}"#);
    let command = view.commands().recv_timeout(SOON).unwrap();
    assert_eq!(command, ViewCommand::Record(true));
    say(&mut socket, r#"{"cmd":"press","point_m":[0,0,0],"normal":[0,0,1],"force_n":99}"#);
    let refused = next_text(&mut socket);
    assert!(refused["text"].as_str().unwrap().contains("up to 10 N"), "{refused}");
}

#[test]
fn beyond_loopback_nothing_without_the_token() {
    let view = serve(ViewParams {
        bind: SocketAddr::from(([0, 0, 0, 0], 0)),
        allowed_hosts: vec!["limb.example".to_owned()],
        ..params()
    });
    let port = view.address().port();
    assert!(view.url().starts_with("http://limb.example:"), "{}", view.url());
    assert_eq!(connect_as(port, &format!("127.0.0.1:{port}"), None).err(), Some(403));
    let host = format!("limb.example:{port}");
    let mut without = connect_as(port, &host, None).unwrap();
    say(&mut without, r#"{"cmd":"hello","token":null}"#);
    match without.read().unwrap() {
        Message::Close(Some(close)) => assert_eq!(u16::from(close.code), 4401),
        other => panic!("{other:?}"),
    }
    let mut with = connect_as(port, &host, None).unwrap();
    greet(&mut with, Some(TOKEN));
}

#[test]
fn a_ninth_page_waits_for_a_place() {
    let view = serve(params());
    let port = view.address().port();
    let own = format!("127.0.0.1:{port}");
    let mut pages: Vec<_> = (0..8).map(|_| connect(port)).collect();
    pages.iter_mut().for_each(|socket| {
        greet(socket, None);
    });
    assert_eq!(connect_as(port, &own, None).err(), Some(503));
    assert_eq!(view.clients().len(), 8);
    drop(pages.pop());
    let start = Instant::now();
    while connect_as(port, &own, None).is_err() {
        assert!(start.elapsed() < SOON, "no place was given back");
        std::thread::sleep(Duration::from_millis(10));
    }
}

#[test]
fn a_page_that_answers_no_ping_gives_its_place_back() {
    let view = serve(ViewParams { patience: Duration::from_secs(2), ..params() });
    let port = view.address().port();
    let mut silent = connect(port);
    let mut answering = connect(port);
    for socket in [&mut silent, &mut answering] {
        greet(socket, None);
    }
    let answers = std::thread::spawn(move || {
        let mut n_pings = 0;
        while n_pings < 8 {
            n_pings += u32::from(matches!(answering.read().unwrap(), Message::Ping(_)));
        }
        answering
    });
    let answering = answers.join().unwrap();
    // Eight pings are twice the patience.
    assert_eq!(view.clients().len(), 1);
    drop((silent, answering));
}

#[test]
fn more_than_64_kib_end_the_connection() {
    let view = serve(params());
    let port = view.address().port();
    let mut socket = connect(port);
    greet(&mut socket, Some(TOKEN));
    let fits = format!("{{\"cmd\":\"{}\"}}", "x".repeat((64 << 10) - 10));
    say(&mut socket, &fits);
    assert_eq!(next_text(&mut socket)["type"], "refused");
    let _ = socket.send(Message::text(format!("{fits}  ")));
    let end = loop {
        match socket.read() {
            Ok(Message::Close(_)) | Err(_) => break true,
            Ok(Message::Text(text)) => panic!("answered {text}"),
            Ok(_) => {}
        }
    };
    assert!(end && connect_as(port, &format!("127.0.0.1:{port}"), None).is_ok());
}

#[test]
fn a_page_that_does_not_greet_is_let_go() {
    let view = serve(params());
    let mut silent = connect(view.address().port());
    let mut rude = connect(view.address().port());
    say(&mut rude, r#"{"cmd":"tare"}"#);
    assert!(matches!(rude.read(), Err(Error::Protocol(_) | Error::Io(_)) | Ok(Message::Close(_))));
    assert!(matches!(
        silent.read(),
        Err(Error::Protocol(_) | Error::Io(_)) | Ok(Message::Close(_))
    ));
    assert!(view.commands().try_recv().is_err());
}

/// Connections that send half a request, or nothing, keep no page out and are closed after 5 s.
#[test]
fn half_open_connections_end_and_keep_nobody_out() {
    use std::io::{Read, Write};
    let view = serve(params());
    let port = view.address().port();
    let opened = Instant::now();
    let mut half: Vec<std::net::TcpStream> = (0..300)
        .map(|i| {
            let mut stream = std::net::TcpStream::connect(view.address()).unwrap();
            let begin = &b"GET / HTTP/1.1\r\nHost: 127.0.0.1"[..[0, 3, 31][i % 3]];
            stream.write_all(begin).unwrap();
            stream
        })
        .collect();
    let asked = Instant::now();
    let host = format!("Host: 127.0.0.1:{port}");
    let (status, _, _) = request(port, "GET", "/", &[&host]);
    assert_eq!(status, 200);
    assert!(asked.elapsed() < SOON, "{:?}", asked.elapsed());
    // A page that is open stays so.
    let mut socket = connect(port);
    greet(&mut socket, Some(TOKEN));
    let is_closed = |stream: &mut std::net::TcpStream| {
        stream.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
        let mut rest = Vec::new();
        !matches!(stream.read_to_end(&mut rest), Err(error)
            if matches!(error.kind(), std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut))
    };
    for (i, stream) in half.iter_mut().enumerate() {
        assert!(is_closed(stream), "connection {i} after {:?}", opened.elapsed());
    }
    assert!(opened.elapsed() < Duration::from_secs(9), "{:?}", opened.elapsed());
    view.say("still here");
    next_text(&mut socket);
}
