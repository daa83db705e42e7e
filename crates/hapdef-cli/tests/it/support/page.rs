//! The live page without a browser: the program's own server, the page's messages.

use std::io::{BufRead, BufReader};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tungstenite::{Message, WebSocket};

/// Longest wait for anything; the first run solves the virtual rig.
const PATIENCE: Duration = Duration::from_secs(240);
/// Bytes of a contact.
const MARK_LEN: usize = 80;
/// Bytes of a frame before its readings.
const HEADER_LEN: usize = 76;

/// The page's token; its program says it in the page's address.
const TOKEN: &str = "00112233445566778899aabbccddeeff";

/// `hapdef live --view`, ended when dropped.
pub struct Program {
    child: Child,
    /// The page's address with its token.
    pub url: String,
}

/// A page's connection.
pub struct Page {
    socket: WebSocket<TcpStream>,
    /// The server's first message.
    pub hello: Value,
    /// What it said last of the device.
    pub device: Value,
    surface: Vec<u8>,
}

/// What a frame says; NaN where it does not say.
#[derive(Clone, Debug)]
pub struct Frame {
    pub t_s: f64,
    pub rate_hz: f64,
    pub n_lost: u32,
    /// What the device left out and what the reader's queue had no room for.
    pub n_dropped: u32,
    /// 0 off, 1 on, 2 failed.
    pub recording: u8,
    pub recorded_s: f64,
    pub clock_residual_us: f64,
    pub position_s: f64,
    pub duration_s: f64,
    /// Components of the displacement: 0 where none is shown.
    pub n_components: u8,
    /// Place, m, and force, N.
    pub contacts: Vec<([f64; 3], f64)>,
}

/// The bundled limb with a map on its own mesh, which is solved in a moment. Its virtual rig is the one
/// that the docs' commands solve and keep.
pub fn scene(folder: &Path) -> PathBuf {
    scene_with(folder, |_| {})
}

/// The same limb, drawn as its glTF surface.
pub fn scene_with_gltf(folder: &Path) -> PathBuf {
    std::fs::copy(shin().join("shin_skin.glb"), folder.join("skin.glb")).unwrap();
    scene_with(folder, |scene| {
        scene["geometry"]["skin_gltf"] = json!("skin.glb");
    })
}

/// Where the bundled limb is.
pub fn shin() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/shin")
}

pub fn scene_with(folder: &Path, change: impl FnOnce(&mut Value)) -> PathBuf {
    std::fs::copy(shin().join("shin.inp.gz"), folder.join("shin.inp.gz")).unwrap();
    let text = std::fs::read_to_string(shin().join("placed.json")).unwrap();
    let mut scene: Value = serde_json::from_str(&text).unwrap();
    scene["estimator"]["map_refinements"] = json!(0);
    change(&mut scene);
    let path = folder.join("scene.json");
    std::fs::write(&path, scene.to_string()).unwrap();
    path
}

impl Program {
    pub fn start(scene: &Path, words: &[&str], port: u16) -> Self {
        Self::start_by(Command::new(env!("CARGO_BIN_EXE_hapdef")), scene, words, port)
    }

    /// Its files end after so many bytes, as on a disk that is full.
    pub fn start_on_small_disk(scene: &Path, words: &[&str], most_bytes: usize) -> Self {
        let limit = format!("trap '' XFSZ; ulimit -f {}; exec \"$@\"", most_bytes / 512);
        let mut command = Command::new("sh");
        command.args(["-c", &limit, "sh", env!("CARGO_BIN_EXE_hapdef")]);
        Self::start_by(command, scene, words, 0)
    }

    fn start_by(mut command: Command, scene: &Path, words: &[&str], port: u16) -> Self {
        let out = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/hapdef");
        let mut child = command
            .arg("live")
            .arg(scene)
            .args(["--view", "--view-port", &port.to_string(), "--results"])
            .arg(out)
            .args(words)
            .env("HAPDEF_VIEW_TOKEN", TOKEN)
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
        let url = lines.find_map(|line| Some(line.ok()?.strip_prefix("live page: ")?.to_owned()));
        let url = url.expect("the page's address");
        std::thread::spawn(move || {
            lines.map_while(Result::ok).for_each(|line| println!("program: {line}"));
        });
        Self { child, url }
    }

    pub fn port(&self) -> u16 {
        let (address, token) = self.url.split_once("/#token=").unwrap();
        assert_eq!(token, TOKEN);
        address.rsplit(':').next().unwrap().parse().unwrap()
    }

    /// A page that was greeted.
    pub fn page(&self) -> Page {
        self.page_at("/live")
    }

    /// The same of one limb of several.
    pub fn page_of(&self, limb: &str) -> Page {
        self.page_at(&format!("/limb/{limb}/live"))
    }

    fn page_at(&self, path: &str) -> Page {
        let start = Instant::now();
        let socket = loop {
            match connect(self.port(), path) {
                Ok(socket) => break socket,
                // a limb of several whose scene is being solved
                Err(503) if start.elapsed() < PATIENCE => {
                    std::thread::sleep(Duration::from_millis(50));
                }
                Err(status) => panic!("{path}: {status}"),
            }
        };
        let mut page =
            Page { socket, hello: Value::Null, device: Value::Null, surface: Vec::new() };
        page.say(&json!({"cmd": "hello", "token": TOKEN}));
        while page.surface.is_empty() {
            match page.socket.read().unwrap() {
                Message::Text(text) => {
                    let value: Value = serde_json::from_str(&text).unwrap();
                    match value["type"].as_str() {
                        Some("hello") => page.hello = value,
                        _ => page.device = value,
                    }
                }
                Message::Binary(bytes) => page.surface = bytes.to_vec(),
                _ => {}
            }
        }
        assert_eq!(page.hello["type"], "hello");
        assert_eq!(page.device["type"], "device");
        page
    }
}

/// A page's connection; the status where it is refused.
fn connect(port: u16, path: &str) -> Result<WebSocket<TcpStream>, u16> {
    let address = format!("127.0.0.1:{port}");
    let stream = TcpStream::connect(&address).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    match tungstenite::client(format!("ws://{address}{path}"), stream) {
        Ok((socket, _)) => Ok(socket),
        Err(tungstenite::HandshakeError::Failure(tungstenite::Error::Http(answer))) => {
            Err(answer.status().as_u16())
        }
        Err(error) => panic!("{error}"),
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }
}

impl Page {
    pub fn say(&mut self, message: &Value) {
        self.socket.send(Message::text(message.to_string())).unwrap();
    }

    /// A node of the surface and the normal there.
    pub fn node(&self, node: usize) -> ([f64; 3], [f64; 3]) {
        let n = u32_at(&self.surface, 4) as usize;
        assert!(node < n);
        let vector = |i: usize| [0, 1, 2].map(|k| f32_at(&self.surface, 16 + 12 * i + 4 * k));
        (vector(node), vector(n + node))
    }

    /// The first notice that has `words` in it.
    pub fn hear(&mut self, words: &str) -> String {
        let start = Instant::now();
        loop {
            if let Next::Text(text) = self.next()
                && text.contains(words)
            {
                return text;
            }
            assert!(start.elapsed() < PATIENCE, "never heard {words:?}");
        }
    }

    /// The first frame that is as wanted.
    pub fn until(&mut self, what: &str, mut is_wanted: impl FnMut(&Frame) -> bool) -> Frame {
        let start = Instant::now();
        loop {
            if let Next::Frame(frame) = self.next() {
                if is_wanted(&frame) {
                    return frame;
                }
                assert!(start.elapsed() < PATIENCE / 4, "not {what}: {frame:?}");
            }
        }
    }

    fn next(&mut self) -> Next {
        match self.socket.read().unwrap() {
            Message::Binary(bytes) => {
                self.say(&json!({"cmd": "got"}));
                Next::Frame(Frame::read(&bytes))
            }
            Message::Text(text) => {
                let value: Value = serde_json::from_str(&text).unwrap();
                println!("page: {value}");
                match value["type"].as_str() {
                    Some("notice") => Next::Text(value["text"].as_str().unwrap().to_owned()),
                    Some("device") => {
                        self.device = value;
                        Next::Nothing
                    }
                    Some("alive") => Next::Nothing,
                    _ => panic!("{value}"),
                }
            }
            _ => Next::Nothing,
        }
    }
}

enum Next {
    Frame(Frame),
    Text(String),
    Nothing,
}

impl Frame {
    fn read(bytes: &[u8]) -> Self {
        assert_eq!(bytes[0], 2);
        let n_gauges = usize::from(bytes[16]) + 256 * usize::from(bytes[17]);
        // Readings, their ranges, states.
        let first = HEADER_LEN + 12 * n_gauges + n_gauges.next_multiple_of(4);
        let contact = |i: usize| {
            let at = first + MARK_LEN * i;
            let vector = |at: usize| [0, 1, 2].map(|k| f32_at(bytes, at + 4 * k));
            let force = vector(at + 32).map(|f| f * f).iter().sum::<f64>().sqrt();
            (vector(at + 8), force)
        };
        let f64_at = |at: usize| f64::from_le_bytes(bytes[at..][..8].try_into().unwrap());
        Self {
            t_s: f64_at(8),
            rate_hz: f32_at(bytes, 28),
            n_lost: u32_at(bytes, 32),
            n_dropped: u32_at(bytes, 64),
            recording: bytes[3],
            recorded_s: f32_at(bytes, 52),
            clock_residual_us: f32_at(bytes, 48),
            position_s: f32_at(bytes, 56),
            duration_s: f32_at(bytes, 60),
            n_components: bytes[2],
            contacts: (0..usize::from(bytes[18])).map(contact).collect(),
        }
    }
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..][..4].try_into().unwrap())
}

fn f32_at(bytes: &[u8], at: usize) -> f64 {
    f64::from(f32::from_le_bytes(bytes[at..][..4].try_into().unwrap()))
}
