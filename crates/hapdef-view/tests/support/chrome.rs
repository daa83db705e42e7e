//! A headless Chromium over its DevTools protocol: load a page, ask it, click, take its picture.

use std::io::{BufRead, BufReader};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
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

/// Why something of the browser failed.
pub type Fault = Box<dyn std::error::Error>;

/// A browser with one page.
pub struct Chrome {
    child: Child,
    socket: WebSocket<TcpStream>,
    session: String,
    next_id: u64,
    events: Vec<Value>,
    _profile: TempDir,
}

/// Where a Chromium is: `HAPDEF_CHROMIUM`, else the usual places.
pub fn find() -> Option<PathBuf> {
    if let Some(path) = std::env::var_os("HAPDEF_CHROMIUM") {
        return Some(PathBuf::from(path));
    }
    let places = [
        "/usr/bin/chromium",
        "/usr/bin/chromium-browser",
        "/usr/bin/google-chrome",
    ];
    places
        .map(PathBuf::from)
        .into_iter()
        .find(|path| path.exists())
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
        let mut child = Command::new(program)
            .args([
                "--headless=new",
                "--remote-debugging-port=0",
                "--no-sandbox",
                "--no-first-run",
            ])
            .args([
                "--use-gl=angle",
                "--use-angle=swiftshader",
                "--enable-unsafe-swiftshader",
            ])
            .args([
                "--hide-scrollbars",
                "--mute-audio",
                "--disable-dev-shm-usage",
            ])
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .arg("about:blank")
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()?;
        let url = devtools_url(&mut child)?;
        let address = url
            .strip_prefix("ws://")
            .and_then(|rest| rest.split('/').next());
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
        self.session = attached["sessionId"]
            .as_str()
            .ok_or("no session")?
            .to_owned();
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
        self.call(
            "Page.addScriptToEvaluateOnNewDocument",
            json!({"source": script}),
        )?;
        Ok(())
    }

    /// Role and name of everything that a screen reader stops at.
    pub fn named(&mut self) -> Result<Vec<(String, String)>, Fault> {
        let tree = self.call("Accessibility.getFullAXTree", json!({}))?;
        let nodes = tree["nodes"].as_array().ok_or("no tree")?;
        let seen = nodes.iter().filter(|node| node["ignored"] == false);
        let word = |value: &Value| value["value"].as_str().unwrap_or_default().to_owned();
        Ok(seen
            .map(|node| (word(&node["role"]), word(&node["name"])))
            .collect())
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

    /// Starts an expression without waiting for its value.
    pub fn start_eval(&mut self, expression: &str) -> Result<(), Fault> {
        self.send("Runtime.evaluate", json!({"expression": expression}))?;
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
            self.call(
                "Input.dispatchKeyEvent",
                json!({"type": kind, "key": key, "code": code}),
            )?;
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

    /// Time for which the page's main thread was busy since the first call, s.
    pub fn busy_s(&mut self) -> Result<f64, Fault> {
        self.call("Performance.enable", json!({}))?;
        let answer = self.call("Performance.getMetrics", json!({}))?;
        let metrics = answer["metrics"].as_array().ok_or("no metrics")?;
        let task = metrics.iter().find(|m| m["name"] == "TaskDuration");
        Ok(task
            .and_then(|m| m["value"].as_f64())
            .ok_or("no TaskDuration")?)
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
        Ok(complaints
            .map(|event| event["params"].to_string())
            .collect())
    }

    fn call(&mut self, method: &str, params: Value) -> Result<Value, Fault> {
        let id = self.send(method, params)?;
        loop {
            let message = self.socket.read()?;
            let Message::Text(text) = message else {
                continue;
            };
            let answer: Value = serde_json::from_str(&text)?;
            if answer["id"] == json!(id) {
                return match answer.get("error") {
                    Some(error) => Err(format!("{method}: {error}").into()),
                    None => Ok(answer["result"].clone()),
                };
            }
            if answer.get("method").is_some() {
                self.events.push(answer);
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
            if matches!(self.child.try_wait(), Ok(Some(_))) {
                return;
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The address that the browser prints, and a thread that reads what else it says.
fn devtools_url(child: &mut Child) -> Result<String, Fault> {
    let stderr = child.stderr.take().ok_or("no stderr")?;
    let mut lines = BufReader::new(stderr).lines();
    for line in lines.by_ref() {
        if let Some(url) = line?.strip_prefix("DevTools listening on ") {
            let url = url.trim().to_owned();
            std::thread::spawn(move || lines.for_each(drop));
            return Ok(url);
        }
    }
    Err("the browser ended before it listened".into())
}
