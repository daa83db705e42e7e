//! A page in a browser, with frames that say what is to be seen.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use hapdef_view::{LimbPicture, ViewCommand, ViewFrame, ViewHandle, ViewParams, ViewServer};
use serde_json::Value;

use super::chrome::{self, Chrome};
use super::page::params;
use super::synthetic;

/// One browser at a time.
static ONE: Mutex<()> = Mutex::new(());
const SOON: Duration = Duration::from_secs(20);

/// A browser, and a server whose frames are made from the number of the frame.
pub struct Look {
    pub chrome: Chrome,
    pub view: Served,
    pub _one: MutexGuard<'static, ()>,
}

/// A server with a thread that pushes.
pub struct Served {
    pub view: ViewHandle,
    stop: Arc<AtomicBool>,
}

impl Served {
    pub fn start(
        params: ViewParams,
        picture: LimbPicture,
        make: impl Fn(u32) -> ViewFrame + Send + 'static,
    ) -> Self {
        let view = ViewServer::start(params, picture).unwrap();
        let stop = Arc::new(AtomicBool::new(false));
        let (pusher, stopped) = (view.pusher(), Arc::clone(&stop));
        std::thread::spawn(move || {
            for n in 0.. {
                if stopped.load(Ordering::Relaxed) {
                    return;
                }
                pusher.push(&make(n)).unwrap();
                std::thread::sleep(Duration::from_millis(10));
            }
        });
        Self { view, stop }
    }

    #[track_caller]
    pub fn hears(&self, wanted: &ViewCommand) {
        let start = Instant::now();
        while start.elapsed() < SOON {
            let next = self.view.commands().recv_timeout(SOON);
            if next.as_ref() == Ok(wanted) {
                return;
            }
        }
        panic!("never heard {wanted:?}");
    }
}

impl Served {
    /// Where the next press is.
    pub fn hears_a_press(&self) -> [f64; 3] {
        loop {
            match self.view.commands().recv_timeout(SOON) {
                Ok(ViewCommand::Press { point_m, .. }) => return point_m,
                other => assert!(other.is_ok(), "never heard a press"),
            }
        }
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

/// The page on a dark or light system; a script runs before the page's own.
pub fn look(
    size: (u32, u32),
    dark: bool,
    script: &str,
    make: impl Fn(u32) -> ViewFrame + Send + 'static,
) -> Option<Look> {
    let program = chrome::wanted()?;
    let one = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    let view = Served::start(params(), synthetic::picture(), make);
    let mut chrome = Chrome::start(&program, size, dark).unwrap();
    chrome.before_pages(script).unwrap();
    chrome.open(view.view.url()).unwrap();
    chrome.wait_for("globalThis.hapdefView?.drawn > 1").unwrap();
    Some(Look { chrome, view, _one: one })
}

impl Look {
    #[track_caller]
    pub fn is(&mut self, expression: &str, expected: &Value) {
        assert_eq!(self.chrome.eval(expression).unwrap(), *expected, "{expression}");
    }

    pub fn number(&mut self, expression: &str) -> f64 {
        let value = self.chrome.eval(expression).unwrap();
        value.as_f64().unwrap_or_else(|| panic!("{expression} is {value}"))
    }

    pub fn until(&mut self, expression: &str) {
        self.chrome.wait_for(expression).unwrap();
    }

    pub fn do_it(&mut self, script: &str) {
        self.chrome.eval(script).unwrap();
    }

    /// RGBA of the saved picture at a share of its width and height.
    pub fn picture_at(&mut self, x: f64, y: f64) -> Vec<u8> {
        let pixel = format!(
            "(() => {{ const c = hapdefView.picture(); const pen = c.getContext('2d');
                return [...pen.getImageData({x} * c.width, {y} * c.height, 1, 1).data]; }})()"
        );
        serde_json::from_value(self.chrome.eval(&pixel).unwrap()).unwrap()
    }
}
