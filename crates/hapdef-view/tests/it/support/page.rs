//! A page without a browser: requests over plain TCP, WebSockets with any header.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::Duration;

use hapdef_view::{Offers, PressOffer, Token, ViewHandle, ViewParams, ViewServer};
use serde_json::Value;
use tungstenite::client::IntoClientRequest;
use tungstenite::http::HeaderValue;
use tungstenite::{Message, WebSocket};

use super::synthetic;

pub const TOKEN: &str = "00112233445566778899aabbccddeeff";

/// A page's connection.
pub type Socket = WebSocket<TcpStream>;

/// Parameters with a known token, any free port of loopback, and everything offered.
pub fn params() -> ViewParams {
    ViewParams {
        bind: SocketAddr::from(([127, 0, 0, 1], 0)),
        token: Some(TOKEN.parse::<Token>().unwrap()),
        offers: Offers {
            tare: true,
            record: true,
            press: Some(PressOffer { default_n: 4.0, max_n: 10.0 }),
        },
        ..ViewParams::default()
    }
}

/// A server with the made-up limb.
pub fn serve(params: ViewParams) -> ViewHandle {
    ViewServer::start(params, synthetic::picture()).unwrap()
}

/// Status line and headers in lower case, and body, of a request with these header lines.
pub fn request(port: u16, method: &str, path: &str, headers: &[&str]) -> (u16, String, Vec<u8>) {
    let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(5))).unwrap();
    let lines = headers.join("\r\n");
    write!(stream, "{method} {path} HTTP/1.1\r\n{lines}\r\nConnection: close\r\n\r\n").unwrap();
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).unwrap();
    let end = answer.windows(4).position(|four| four == b"\r\n\r\n").unwrap();
    let head = String::from_utf8_lossy(&answer[..end]).to_ascii_lowercase();
    let status = head.split(' ').nth(1).unwrap().parse().unwrap();
    (status, head, answer[end + 4..].to_vec())
}

/// Asks for a WebSocket; the status where it is refused.
pub fn connect_as(port: u16, host: &str, origin: Option<&str>) -> Result<Socket, u16> {
    connect_at(port, "/live", host, origin)
}

/// The same at a path.
pub fn connect_at(port: u16, path: &str, host: &str, origin: Option<&str>) -> Result<Socket, u16> {
    let stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(5))).unwrap();
    let mut request = format!("ws://127.0.0.1:{port}{path}").into_client_request().unwrap();
    request.headers_mut().insert("Host", HeaderValue::from_str(host).unwrap());
    if let Some(origin) = origin {
        request.headers_mut().insert("Origin", HeaderValue::from_str(origin).unwrap());
    }
    match tungstenite::client(request, stream) {
        Ok((socket, _)) => Ok(socket),
        Err(tungstenite::HandshakeError::Failure(tungstenite::Error::Http(answer))) => {
            Err(answer.status().as_u16())
        }
        Err(error) => panic!("{error}"),
    }
}

/// A connection from the server's own page.
pub fn connect(port: u16) -> Socket {
    connect_as(port, &format!("127.0.0.1:{port}"), None).unwrap()
}

/// Greets and reads the server's greeting.
pub fn greet(socket: &mut Socket, token: Option<&str>) -> Value {
    greet_with_device(socket, token).0
}

/// The same with the device's state.
pub fn greet_with_device(socket: &mut Socket, token: Option<&str>) -> (Value, Value) {
    say(socket, &serde_json::json!({"cmd": "hello", "token": token}).to_string());
    let hello = next_text(socket);
    assert_eq!(hello["type"], "hello");
    let device = next_text(socket);
    assert_eq!(device["type"], "device");
    assert_eq!(next_binary(socket)[0], 1);
    (hello, device)
}

pub fn say(socket: &mut Socket, text: &str) {
    socket.send(Message::text(text)).unwrap();
}

/// The next message in JSON; frames and signs of life before it are passed over.
pub fn next_text(socket: &mut Socket) -> Value {
    loop {
        if let Message::Text(text) = socket.read().unwrap() {
            let value: Value = serde_json::from_str(&text).unwrap();
            if value["type"] != "alive" {
                return value;
            }
        }
    }
}

/// The next binary message.
pub fn next_binary(socket: &mut Socket) -> Vec<u8> {
    loop {
        if let Message::Binary(bytes) = socket.read().unwrap() {
            return bytes.to_vec();
        }
    }
}

/// Number of a frame.
pub fn seq_of(frame: &[u8]) -> u32 {
    assert_eq!(frame[0], 2);
    u32::from_le_bytes(frame[4..8].try_into().unwrap())
}
