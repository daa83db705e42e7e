//! A headless Chromium over its DevTools protocol: load a page, ask it, click, take its picture.

use std::io::{BufRead, BufReader};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use tempfile::TempDir;
use tungstenite::{Message, WebSocket};

/// Longest that an answer or a condition may take; software WebGL on a busy machine is slow.
const PATIENCE: Duration = Duration::from_secs(40);

/// Of pictures that lose something, percent.
const WEBP_QUALITY: u32 = 85;

/// The event of a script that is halted.
const PAUSED: &str = "Debugger.paused";

/// Why something of the browser failed.
pub type Fault = Box<dyn std::error::Error>;

/// A browser with one page.
pub struct Chrome {
    child: Running,
    socket: WebSocket<TcpStream>,
    session: String,
    next_id: u64,
    events: Vec<Value>,
    _profile: TempDir,
}

/// A process that ends when this is dropped.
struct Running(Child);

/// Where a Chromium is: `HAPDEF_CHROMIUM`, else the usual places.
pub fn find() -> Option<PathBuf> {
    if let Some(path) = std::env::var_os("HAPDEF_CHROMIUM") {
        return Some(PathBuf::from(path));
    }
    let places = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"];
    places.map(PathBuf::from).into_iter().find(|path| path.exists())
}

/// A Chromium for a test, or `None` and why there is none; it is the test's fault where
/// `HAPDEF_BROWSER` or CI wants one.
pub fn wanted() -> Option<PathBuf> {
    let wish = std::env::var("HAPDEF_BROWSER").unwrap_or_default();
    let in_ci = std::env::var("CI").is_ok_and(|ci| ci == "true");
    let program = find();
    if wish == "skip" || (program.is_none() && wish != "require" && !in_ci) {
        println!("SKIPPED: no Chromium, or HAPDEF_BROWSER=skip");
        return None;
    }
    Some(program.expect("a Chromium: `cargo xtask browser`, or HAPDEF_CHROMIUM=path"))
}

impl Chrome {
    /// Starts a browser with a window of `size` CSS pixels, on a dark or a light system.
    pub fn start(program: &Path, size: (u32, u32), dark: bool) -> Result<Self, Fault> {
        let profile = tempfile::tempdir()?;
        let child = Command::new(program)
            .args(["--headless=new", "--remote-debugging-port=0", "--no-sandbox", "--no-first-run"])
            .args(["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"])
            .args(["--hide-scrollbars", "--mute-audio", "--disable-dev-shm-usage"])
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .arg("about:blank")
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()?;
        let mut child = Running(child);
        let url = devtools_url(&mut child.0)?;
        let address = url.strip_prefix("ws://").and_then(|rest| rest.split('/').next());
        let stream = TcpStream::connect(address.ok_or("no address of the browser")?)?;
        stream.set_read_timeout(Some(PATIENCE))?;
        let (socket, _) =
            tungstenite::client(url.as_str(), stream).map_err(|error| error.to_string())?;
        let mut chrome = Self {
            child,
            socket,
            session: String::new(),
            next_id: 0,
            events: Vec::new(),
            _profile: profile,
        };
        chrome.attach()?;
        chrome.dress(size, dark)?;
        Ok(chrome)
    }

    fn attach(&mut self) -> Result<(), Fault> {
        let target = self.call("Target.createTarget", json!({"url": "about:blank"}))?;
        let attach = json!({"targetId": target["targetId"], "flatten": true});
        let attached = self.call("Target.attachToTarget", attach)?;
        self.session = attached["sessionId"].as_str().ok_or("no session")?.to_owned();
        for domain in ["Page", "Runtime", "Log", "Network"] {
            self.call(&format!("{domain}.enable"), json!({}))?;
        }
        Ok(())
    }

    fn dress(&mut self, (width, height): (u32, u32), dark: bool) -> Result<(), Fault> {
        let is_phone = width < 600;
        let metrics = json!({"width": width, "height": height, "deviceScaleFactor": if is_phone { 2 } else { 1 },
            "mobile": is_phone});
        self.call("Emulation.setDeviceMetricsOverride", metrics)?;
        let scheme = if dark { "dark" } else { "light" };
        let features = json!({"features": [{"name": "prefers-color-scheme", "value": scheme}]});
        self.call("Emulation.setEmulatedMedia", features)?;
        Ok(())
    }

    /// Loads a page.
    pub fn open(&mut self, url: &str) -> Result<(), Fault> {
        self.call("Page.navigate", json!({"url": url}))?;
        Ok(())
    }

    /// A script that runs before those of every page that is loaded from now on.
    pub fn before_pages(&mut self, script: &str) -> Result<(), Fault> {
        self.call("Page.addScriptToEvaluateOnNewDocument", json!({"source": script}))?;
        Ok(())
    }

    /// What a screen reader says of an element, empty where it passes it over; an expression of the
    /// page gives the element.
    pub fn name_of(&mut self, element: &str) -> Result<String, Fault> {
        let found = self.call("Runtime.evaluate", json!({"expression": element}))?;
        let ask = json!({"objectId": found["result"]["objectId"], "fetchRelatives": false});
        let node = &self.call("Accessibility.getPartialAXTree", ask)?["nodes"][0];
        let name = node["name"]["value"].as_str().filter(|_| node["ignored"] == false);
        Ok(name.unwrap_or_default().trim().to_owned())
    }

    /// The value of an expression of the page.
    pub fn eval(&mut self, expression: &str) -> Result<Value, Fault> {
        let ask = json!({"expression": expression, "returnByValue": true, "awaitPromise": true});
        let answer = self.call("Runtime.evaluate", ask)?;
        if let Some(exception) = answer.get("exceptionDetails") {
            return Err(format!("{expression}: {exception}").into());
        }
        Ok(answer["result"]["value"].clone())
    }

    /// Halts the page's script until [`Self::go_on`]; the page hangs, and takes nothing.
    pub fn halt(&mut self) -> Result<(), Fault> {
        self.call("Debugger.enable", json!({}))?;
        self.events.retain(|event| event["method"] != PAUSED);
        self.call("Debugger.pause", json!({}))?;
        while !self.events.iter().any(|event| event["method"] == PAUSED) {
            self.take_message()?;
        }
        Ok(())
    }

    /// Lets the page go on.
    pub fn go_on(&mut self) -> Result<(), Fault> {
        self.call("Debugger.resume", json!({}))?;
        self.call("Debugger.disable", json!({}))?;
        Ok(())
    }

    /// Waits until an expression is true.
    pub fn wait_for(&mut self, expression: &str) -> Result<(), Fault> {
        self.wait_long_for(expression, PATIENCE)
    }

    /// The same with another patience.
    pub fn wait_long_for(&mut self, expression: &str, patience: Duration) -> Result<(), Fault> {
        let start = Instant::now();
        while self.eval(expression)? != json!(true) {
            if start.elapsed() > patience {
                return Err(format!("never true: {expression}").into());
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        Ok(())
    }

    /// `kind` of a pointer, "mousePressed", "mouseMoved" or "mouseReleased", at CSS pixels.
    pub fn pointer(&mut self, kind: &str, (x, y): (f64, f64)) -> Result<(), Fault> {
        let event =
            json!({"type": kind, "x": x, "y": y, "button": "left", "buttons": 1, "clickCount": 1});
        self.call("Input.dispatchMouseEvent", event)?;
        Ok(())
    }

    /// A key goes down and up; `code` as in "KeyT".
    pub fn key(&mut self, key: &str, code: &str) -> Result<(), Fault> {
        for kind in ["rawKeyDown", "keyUp"] {
            self.call("Input.dispatchKeyEvent", json!({"type": kind, "key": key, "code": code}))?;
        }
        Ok(())
    }

    /// The page as PNG.
    pub fn screenshot(&mut self) -> Result<Vec<u8>, Fault> {
        self.picture("png")
    }

    /// The page in a format, "png" or "webp".
    pub fn picture(&mut self, format: &str) -> Result<Vec<u8>, Fault> {
        let mut ask = json!({"format": format});
        if format == "webp" {
            ask["quality"] = json!(WEBP_QUALITY);
        }
        let answer = self.call("Page.captureScreenshot", ask)?;
        Ok(STANDARD.decode(answer["data"].as_str().ok_or("no picture")?)?)
    }

    /// What is seen of the page beside a window of that width.
    pub fn outside(&mut self, width: u32) -> Result<Value, Fault> {
        self.eval(&format!(
            "[...document.querySelectorAll('body *')]
                .filter((e) => e.getClientRects().length && !e.closest('#labels, .unseen'))
                .filter((e) => e.getBoundingClientRect().right > {width}.5 || e.getBoundingClientRect().left < -0.5)
                .map((e) => e.id || e.className)"
        ))
    }

    /// Errors on the console, exceptions, refused loads and violations of the policy so far.
    pub fn complaints(&mut self) -> Result<Vec<String>, Fault> {
        self.eval("1")?;
        let complains = |event: &&Value| match event["method"].as_str() {
            Some("Runtime.exceptionThrown" | "Network.loadingFailed") => true,
            Some("Runtime.consoleAPICalled") => event["params"]["type"] == "error",
            Some("Log.entryAdded") => event["params"]["entry"]["level"] == "error",
            _ => false,
        };
        let complaints = self.events.iter().filter(complains);
        Ok(complaints.map(|event| event["params"].to_string()).collect())
    }

    fn call(&mut self, method: &str, params: Value) -> Result<Value, Fault> {
        let id = self.send(method, params)?;
        loop {
            let answer = self.take_message()?;
            if answer["id"] == json!(id) {
                return match answer.get("error") {
                    Some(error) => Err(format!("{method}: {error}").into()),
                    None => Ok(answer["result"].clone()),
                };
            }
        }
    }

    /// The next message; an event is kept, too.
    fn take_message(&mut self) -> Result<Value, Fault> {
        loop {
            if let Message::Text(text) = self.socket.read()? {
                let message: Value = serde_json::from_str(&text)?;
                if message.get("method").is_some() {
                    self.events.push(message.clone());
                }
                return Ok(message);
            }
        }
    }

    fn send(&mut self, method: &str, params: Value) -> Result<u64, Fault> {
        self.next_id += 1;
        let mut message = json!({"id": self.next_id, "method": method, "params": params});
        if !self.session.is_empty() {
            message["sessionId"] = json!(self.session);
        }
        self.socket.send(Message::text(message.to_string()))?;
        Ok(self.next_id)
    }
}

impl Drop for Chrome {
    fn drop(&mut self) {
        self.session.clear();
        let closed = self.send("Browser.close", json!({})).is_ok();
        let start = Instant::now();
        while closed && start.elapsed() < Duration::from_secs(5) {
            if matches!(self.child.0.try_wait(), Ok(Some(_))) {
                return;
            }
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The address that the browser prints; a thread reads what else it says.
fn devtools_url(child: &mut Child) -> Result<String, Fault> {
    let stderr = child.stderr.take().ok_or("no stderr")?;
    let (sender, receiver) = channel();
    std::thread::spawn(move || {
        let lines = BufReader::new(stderr).lines().map_while(Result::ok);
        for line in lines {
            if let Some(url) = line.strip_prefix("DevTools listening on ") {
                let _ = sender.send(url.trim().to_owned());
            }
        }
    });
    receiver
        .recv_timeout(PATIENCE)
        .map_err(|_| "the browser ended, or said nothing, before it listened".into())
}
