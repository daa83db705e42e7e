//! The page in a headless Chromium.
//!
//! `cargo xtask browser` gets one and runs these. `HAPDEF_BROWSER=require` fails without one, `skip` leaves
//! them out; by default they are left out where there is no Chromium, but not in CI (`CI=true`).
//! `HAPDEF_CHROMIUM` names another program.

use crate::support::chrome;
use crate::support::page;
use crate::support::pixels;
use crate::support::synthetic;

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use chrome::Chrome;
use hapdef_view::{LimbPicture, ViewCommand, ViewFrame, ViewHandle, ViewParams};
use page::{params, serve};
use pixels::{LimbRow, Pixels};
use synthetic::Touch;

/// Frames that are pushed while a page hangs.
const N_WHILE_IT_HANGS: u64 = 200;
/// Frames that are sent to a page before it takes one.
const ON_THE_WAY: u64 = 3;

/// Lets a page hear nothing of what its connection brings while it is `deaf`.
const DEAF: &str = "globalThis.WebSocket = class extends WebSocket {
    set onmessage(hear) { super.onmessage = (event) => { if (!globalThis.deaf) hear(event); }; }
};";

/// One browser at a time.
static ONE: Mutex<()> = Mutex::new(());

/// A server whose limb answers presses with a contact there, and a browser.
struct Scene {
    chrome: Chrome,
    feed: Feed,
    _one: MutexGuard<'static, ()>,
}

/// A thread that pushes frames and keeps the commands it receives.
struct Feed {
    url: String,
    commands: Arc<Mutex<Vec<ViewCommand>>>,
    n_pushed: Arc<AtomicU64>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<ViewHandle>>,
}

impl Feed {
    fn start(params: ViewParams) -> Self {
        let view = serve(params);
        let url = view.url().to_owned();
        let commands = Arc::new(Mutex::new(Vec::new()));
        let stop = Arc::new(AtomicBool::new(false));
        let n_pushed = Arc::new(AtomicU64::new(0));
        let (heard, ended) = (Arc::clone(&commands), Arc::clone(&stop));
        let counted = Arc::clone(&n_pushed);
        let thread = std::thread::spawn(move || {
            push_until(&view, &heard, &counted, &ended);
            view
        });
        Self { url, commands, n_pushed, stop, thread: Some(thread) }
    }

    fn commands(&self) -> Vec<ViewCommand> {
        self.commands.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Waits for a command.
    fn hears(&self, wanted: impl Fn(&ViewCommand) -> bool) -> ViewCommand {
        let start = Instant::now();
        loop {
            if let Some(command) = self.commands().into_iter().find(&wanted) {
                return command;
            }
            assert!(start.elapsed() < Duration::from_secs(20), "only heard {:?}", self.commands());
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    /// The server, which goes on without new frames, and how many there were.
    fn end(&mut self) -> (ViewHandle, u64) {
        self.stop.store(true, Ordering::Relaxed);
        let view = self.thread.take().unwrap().join().unwrap();
        (view, self.n_pushed())
    }

    fn n_pushed(&self) -> u64 {
        self.n_pushed.load(Ordering::Relaxed)
    }
}

impl Drop for Feed {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

fn push_until(
    view: &ViewHandle,
    commands: &Mutex<Vec<ViewCommand>>,
    n_pushed: &AtomicU64,
    stop: &AtomicBool,
) {
    let picture = synthetic::picture();
    let mut frame = ViewFrame::default();
    let mut touches = Vec::new();
    let start = Instant::now();
    while !stop.load(Ordering::Relaxed) {
        for command in view.commands().try_iter() {
            touches = after(touches, command);
            commands.lock().unwrap_or_else(PoisonError::into_inner).push(command);
        }
        synthetic::show(&picture, &touches, start.elapsed().as_secs_f64(), &mut frame);
        n_pushed.store(view.push(&frame).unwrap(), Ordering::Relaxed);
        std::thread::sleep(Duration::from_millis(10));
    }
}

fn after(touches: Vec<Touch>, command: ViewCommand) -> Vec<Touch> {
    match command {
        ViewCommand::Press { finger, point_m, normal, force_n } => {
            let mut others: Vec<Touch> = touches.into_iter().filter(|t| t.id != finger).collect();
            others.push(Touch { id: finger, point_m, normal, force_n });
            others
        }
        ViewCommand::Lift { finger } => touches.into_iter().filter(|t| t.id != finger).collect(),
        ViewCommand::Release => Vec::new(),
        _ => touches,
    }
}

/// The scene, or `None` and why where there is no browser.
fn scene(size: (u32, u32)) -> Option<Scene> {
    let program = chrome::wanted()?;
    let one = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    let feed = Feed::start(params());
    let mut chrome = Chrome::start(&program, size, true).unwrap();
    chrome.open(&feed.url).unwrap();
    chrome.wait_for("globalThis.hapdefView?.drawn > 1").unwrap();
    Some(Scene { chrome, feed, _one: one })
}

impl Scene {
    fn numbers(&mut self, expression: &str) -> Vec<f64> {
        let value = self.chrome.eval(expression).unwrap();
        let array = value.as_array().unwrap_or_else(|| panic!("{expression} is {value}"));
        array.iter().map(|x| x.as_f64().unwrap()).collect()
    }
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    let squares = a.iter().zip(b).map(|(x, y)| (x - y) * (x - y));
    squares.sum::<f64>().sqrt()
}

#[test]
fn a_click_on_the_limb_presses_it_there() {
    let Some(mut scene) = scene((1200, 800)) else {
        return;
    };
    let bare = Pixels::of_stage(&mut scene.chrome).unwrap();
    let node = scene.chrome.eval("hapdefView.facing()").unwrap();
    assert!(node.as_i64().unwrap() >= 0, "no node in the middle of the view");
    let at = scene.numbers(&format!("hapdefView.project({node})"));
    let (x, y) = (at[0], at[1]);
    let row = LimbRow::of_node(&mut scene.chrome, node.as_u64().unwrap(), 0.0).unwrap();
    bare.shows_limb_across(&row);
    let known = scene.numbers(&format!("hapdefView.node({node})"));
    scene.chrome.pointer("mouseMoved", (x, y)).unwrap();
    scene.chrome.pointer("mousePressed", (x, y)).unwrap();
    let ViewCommand::Press { point_m, force_n, normal, .. } =
        scene.feed.hears(|c| matches!(c, ViewCommand::Press { .. }))
    else {
        unreachable!()
    };
    assert!(distance(&point_m, &known) < 0.005, "{point_m:?} for {known:?}");
    assert_eq!(force_n, 4.0);
    let LimbPicture { vertices_m, normals, .. } = synthetic::picture();
    let outward = normals[node.as_u64().unwrap() as usize].map(f64::from);
    assert!(
        distance(&normal, &outward) < 0.2,
        "{normal:?} for {outward:?} of {}",
        vertices_m.len()
    );
    scene.chrome.wait_for("hapdefView.arrows.length === 1").unwrap();
    let arrow = scene.numbers("hapdefView.arrows[0]");
    assert!(distance(&arrow, &known) < 0.005, "{arrow:?} for {known:?}");
    assert_eq!(
        scene.chrome.eval("document.querySelector('#contacts b').textContent").unwrap(),
        "4.0 N"
    );
    // The arrow stands towards the viewer: it is looked at from the side.
    for _ in 0..8 {
        scene.chrome.key("ArrowLeft", "ArrowLeft").unwrap();
    }
    let drawn = scene.chrome.eval("hapdefView.drawn").unwrap();
    scene.chrome.wait_for(&format!("hapdefView.drawn > {drawn} + 1")).unwrap();
    let ends = scene.numbers("hapdefView.arrowEnds(0).flat()");
    let with_arrow = Pixels::of_stage(&mut scene.chrome).unwrap();
    scene.chrome.pointer("mouseReleased", (x, y)).unwrap();
    scene.feed.hears(|c| *c == ViewCommand::Release);
    scene.chrome.wait_for("hapdefView.arrows.length === 0").unwrap();
    let without = Pixels::of_stage(&mut scene.chrome).unwrap();
    has_an_arrow(ends.try_into().unwrap(), &with_arrow, &without);
    buttons_command(&mut scene);
    assert_eq!(scene.chrome.complaints().unwrap(), Vec::<String>::new());
}

/// The half of an arrow towards its tail, where neither its ellipse is nor its head, is drawn, and gone when
/// it is.
fn has_an_arrow([x0, y0, x1, y1]: [f64; 4], with_arrow: &Pixels, without: &Pixels) {
    let middle = [0.5 * (x0 + x1), 0.5 * (y0 + y1)];
    let tail = [0.05 * x0 + 0.95 * x1, 0.05 * y0 + 0.95 * y1];
    let [with_arrow, without] = [with_arrow, without].map(|p| p.orange_share(middle, tail));
    println!("orange: {with_arrow} of the arrow, {without} without it");
    assert!(with_arrow > 0.95 && without < 0.05, "{with_arrow} {without}");
}

fn buttons_command(scene: &mut Scene) {
    let click = |scene: &mut Scene, id: &str| {
        scene.chrome.eval(&format!("document.getElementById('{id}').click()")).unwrap()
    };
    click(scene, "tare");
    scene.feed.hears(|c| *c == ViewCommand::Tare);
    click(scene, "record");
    scene.feed.hears(|c| *c == ViewCommand::Record(true));
    click(scene, "snapshot");
    scene.feed.hears(|c| matches!(c, ViewCommand::Snapshot { t_s: Some(_) }));
    let n_tares =
        |scene: &Scene| scene.feed.commands().iter().filter(|c| **c == ViewCommand::Tare).count();
    assert_eq!(n_tares(scene), 1);
    scene.chrome.key("t", "KeyT").unwrap();
    let start = Instant::now();
    while n_tares(scene) < 2 {
        assert!(start.elapsed() < Duration::from_secs(20), "the key T does not tare");
        std::thread::sleep(Duration::from_millis(10));
    }
}

#[test]
fn the_page_comes_back_with_its_server() {
    let Some(mut scene) = scene((900, 700)) else {
        return;
    };
    let (view, _) = scene.feed.end();
    let bind = view.address();
    drop(view);
    scene.chrome.wait_for("document.getElementById('link').dataset.state === 'away'").unwrap();
    is_gone(&mut scene.chrome);
    scene.feed = Feed::start(ViewParams { bind, ..params() });
    scene.chrome.wait_for("document.getElementById('link').dataset.state === 'live'").unwrap();
    let drawn = scene.chrome.eval("hapdefView.drawn").unwrap();
    scene.chrome.wait_for(&format!("hapdefView.drawn > {drawn} + 2")).unwrap();
    scene.chrome.eval("document.getElementById('tare').click()").unwrap();
    scene.feed.hears(|c| *c == ViewCommand::Tare);
}

/// The page of a program that is gone: grey, the time of its last frame, no force, no button that works.
fn is_gone(chrome: &mut Chrome) {
    for seen in [
        "/last frame at \\d\\d:\\d\\d:\\d\\d/.test(document.getElementById('link').textContent)",
        "/^No connection, last frame at /.test(document.getElementById('no-contacts').textContent)",
        "document.querySelector('#contacts li') === null",
        "getComputedStyle(document.querySelector('main')).filter === 'grayscale(1)'",
        "[...document.querySelectorAll('button, input, select')].every((control) => control.disabled)",
    ] {
        assert_eq!(chrome.eval(seen).unwrap(), true, "{seen}");
    }
}

/// A program that is stopped in its tracks closes no connection: its page knows within two seconds all the same.
#[test]
fn a_program_that_does_not_answer_greys_its_page() {
    let Some(mut scene) = scene((900, 700)) else {
        return;
    };
    scene.chrome.before_pages(DEAF).unwrap();
    scene.chrome.open("about:blank").unwrap();
    scene.chrome.open(&scene.feed.url).unwrap();
    scene.chrome.wait_for("globalThis.hapdefView?.drawn > 1").unwrap();
    scene.chrome.eval("globalThis.deaf = true").unwrap();
    let start = Instant::now();
    scene.chrome.wait_for("document.getElementById('link').dataset.state === 'silent'").unwrap();
    let took = start.elapsed();
    println!("grey after {took:?}");
    assert!(took < Duration::from_secs(2), "{took:?}");
    is_gone(&mut scene.chrome);
    scene.chrome.eval("globalThis.deaf = false").unwrap();
    scene.chrome.wait_for("document.getElementById('link').dataset.state === 'live'").unwrap();
    scene.chrome.eval("document.getElementById('tare').click()").unwrap();
    scene.feed.hears(|c| *c == ViewCommand::Tare);
}

#[test]
fn a_page_that_hangs_skips_frames_and_catches_up() {
    let Some(mut scene) = scene((900, 700)) else {
        return;
    };
    scene.chrome.halt().unwrap();
    let n_before = scene.feed.n_pushed();
    while scene.feed.n_pushed() < n_before + N_WHILE_IT_HANGS {
        std::thread::sleep(Duration::from_millis(10));
    }
    let (view, n_pushed) = scene.feed.end();
    let hanging = view.clients()[0];
    scene.chrome.go_on().unwrap();
    scene.chrome.wait_for(&format!("hapdefView.seq === {n_pushed}")).unwrap();
    let client = view.clients()[0];
    println!("{n_before} of {n_pushed} before; {hanging:?}, {client:?}");
    assert!(hanging.n_sent <= n_before + ON_THE_WAY, "{hanging:?}");
    assert!(hanging.n_skipped + ON_THE_WAY >= N_WHILE_IT_HANGS, "{hanging:?}");
    assert_eq!(client.n_sent, client.n_taken);
}
