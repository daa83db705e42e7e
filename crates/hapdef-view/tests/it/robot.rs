//! The page of a robot: one port, one token, each limb its own frames and commands.

use crate::support::{chrome, page, synthetic};

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use chrome::Chrome;
use hapdef_view::{
    LimbPicture, Offers, PressOffer, RobotView, ViewCommand, ViewError, ViewFrame, ViewHandle,
    ViewServer,
};
use page::{
    Socket, TOKEN, connect_as, connect_at, greet, next_binary, next_text, params, request, say,
    seq_of, serve,
};

const SOON: Duration = Duration::from_secs(5);
const LIMBS: [&str; 2] = ["fore_arm", "hand"];

fn robot() -> RobotView {
    let limbs = LIMBS.map(str::to_owned);
    ViewServer::start_robot(params(), "arm", &limbs).unwrap()
}

/// Begins the page of a limb, whose title is its name.
fn begin(robot: &RobotView, name: &str) -> ViewHandle {
    let picture = LimbPicture { title: name.to_owned(), ..synthetic::picture() };
    let press = Some(PressOffer { default_n: 4.0, max_n: 10.0 });
    robot.limb(name, Offers { tare: true, record: true, press }, picture).unwrap()
}

fn get(port: u16, path: &str) -> (u16, String, String) {
    let (status, head, body) =
        request(port, "GET", path, &[&format!("Host: 127.0.0.1:{port}"), "Accept: */*"]);
    (status, head + "\r\n", String::from_utf8_lossy(&body).into_owned())
}

fn connect(port: u16, limb: &str) -> Result<Socket, u16> {
    connect_at(port, &format!("/limb/{limb}/live"), &format!("127.0.0.1:{port}"), None)
}

#[test]
fn all_limbs_are_at_the_root_and_each_has_a_page() {
    let view = robot();
    let port = view.address().port();
    assert_eq!(view.url(), format!("http://127.0.0.1:{port}/#token={TOKEN}"));
    let (status, head, body) = get(port, "/");
    assert!(status == 200 && head.contains("text/html"), "{head}");
    assert!(body.contains("<title>arm</title>"), "{body}");
    for name in LIMBS {
        assert_eq!(body.matches(&format!("<iframe data-limb=\"{name}\"")).count(), 1, "{body}");
        let (status, _, page) = get(port, &format!("/limb/{name}/"));
        assert!(status == 200 && page.contains("js/main.js"), "{page}");
        let (status, head, _) = get(port, &format!("/limb/{name}"));
        assert!(status == 303 && head.contains(&format!("location: /limb/{name}/\r\n")), "{head}");
        for file in ["js/main.js", "style.css", "vendor/three/OrbitControls.js"] {
            assert_eq!(get(port, &format!("/limb/{name}/{file}")).0, 200, "{name} {file}");
        }
    }
    for path in
        ["/limb/foot/", "/limb/foot/js/main.js", "/limb/foot", "/limb/hand/nothing", "/limb/"]
    {
        assert_eq!(get(port, path).0, 404, "{path}");
    }
    assert_eq!(connect(port, "foot").err(), Some(404));
}

#[test]
fn frames_are_for_the_robots_page_alone() {
    let view = robot();
    let port = view.address().port();
    let strict = "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; \
         img-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'\r\n";
    let framed = strict.replace("frame-ancestors 'none'", "frame-ancestors 'self'");
    let with_frames = strict.replace("connect-src", "frame-src");
    let files = ["/js/robot.js", "/limb/hand/js/main.js", "/limb/foot/", "/nothing"];
    let answers = [("/", with_frames.as_str()), ("/limb/hand/", framed.as_str())];
    for (path, policy) in answers.into_iter().chain(files.map(|file| (file, strict))) {
        let (_, head, _) = get(port, path);
        assert!(head.contains(&format!("content-security-policy: {policy}")), "{path}: {head}");
    }
    let evil = ["Host: evil.example", "Accept: */*"];
    for path in ["/", "/limb/hand/", "/limb/hand/live"] {
        let (status, head, _) = request(port, "GET", path, &evil);
        assert!(status == 403 && (head + "\r\n").contains(strict), "{path}");
    }
    let origin = Some("http://evil.example");
    let own = format!("127.0.0.1:{port}");
    assert_eq!(connect_at(port, "/limb/hand/live", &own, origin).err(), Some(403));
}

#[test]
fn each_page_has_its_own_limb() {
    let view = robot();
    let port = view.address().port();
    assert_eq!(connect(port, LIMBS[0]).err(), Some(503), "it has not begun");
    let handles = LIMBS.map(|name| begin(&view, name));
    let mut sockets = LIMBS.map(|name| connect(port, name).unwrap());
    for (socket, name) in sockets.iter_mut().zip(LIMBS) {
        assert_eq!(greet(socket, Some(TOKEN))["title"], name);
    }
    let mut frame = ViewFrame::default();
    synthetic::show(&synthetic::picture(), &[], 1.0, &mut frame);
    for _ in 0..3 {
        handles[1].push(&frame).unwrap();
    }
    handles[0].push(&frame).unwrap();
    let seqs = sockets.each_mut().map(|socket| seq_of(&next_binary(socket)));
    assert!(seqs[0] == 1 && seqs[1] <= 3, "{seqs:?}");
    say(&mut sockets[1], r#"{"cmd":"tare"}"#);
    assert_eq!(handles[1].commands().recv_timeout(SOON).unwrap(), ViewCommand::Tare);
    assert!(handles[0].commands().try_recv().is_err());
    assert_eq!(handles.each_ref().map(|handle| handle.clients().len()), [1, 1]);
}

#[test]
fn a_wrong_token_commands_no_limb() {
    let view = robot();
    let port = view.address().port();
    for name in LIMBS {
        let handle = begin(&view, name);
        for token in [None, Some("10112233445566778899aabbccddeeff")] {
            let mut socket = connect(port, name).unwrap();
            assert_eq!(greet(&mut socket, token)["offers"]["commands"], false);
            say(&mut socket, r#"{"cmd":"tare"}"#);
            assert_eq!(next_text(&mut socket)["type"], "refused");
        }
        assert!(handle.commands().try_recv().is_err(), "{name}");
    }
}

#[test]
fn one_limb_alone_is_at_the_root() {
    let view = serve(params());
    let port = view.address().port();
    for path in ["/limb/hand/", "/limb/hand/live", "/limb/hand"] {
        assert_eq!(get(port, path).0, 404, "{path}");
    }
    assert!(get(port, "/").2.contains("js/main.js"));
    assert!(connect_as(port, &format!("127.0.0.1:{port}"), None).is_ok());
}

#[test]
fn limbs_that_cannot_be_are_refused() {
    for names in [&["a", "a"][..], &["a/b"], &[""], &["a b"], &["\"a"]] {
        let names: Vec<String> = names.iter().map(|&name| name.to_owned()).collect();
        let refused = ViewServer::start_robot(params(), "arm", &names).map(|_| ());
        assert!(matches!(refused, Err(ViewError::LimbName { .. })), "{names:?}");
    }
    let view = robot();
    let _hand = begin(&view, "hand");
    for name in ["hand", "foot", ""] {
        let refused = view.limb(name, Offers::default(), synthetic::picture()).map(|_| ());
        assert!(matches!(refused, Err(ViewError::NoSuchLimb { .. })), "{name}");
    }
}

#[test]
fn it_is_served_as_long_as_a_limb_is() {
    let view = robot();
    let port = view.address().port();
    let hand = begin(&view, "hand");
    drop(view);
    assert_eq!(get(port, "/").0, 200);
    drop(hand);
    assert!(std::net::TcpStream::connect(("127.0.0.1", port)).is_err());
}

/// Both limbs are drawn, side by side or below each other, and obey the token of the address.
#[test]
fn a_browser_draws_both() {
    let Some(browser) = chrome::wanted() else {
        return;
    };
    for (size, is_stacked) in [((1400, 800), false), ((390, 844), true)] {
        let view = robot();
        let handles = LIMBS.map(|name| begin(&view, name));
        let pushers = handles.each_ref().map(ViewHandle::pusher);
        let mut chrome = Chrome::start(&browser, size, false).unwrap();
        let is_over = AtomicBool::new(false);
        std::thread::scope(|scope| {
            scope.spawn(|| {
                let mut frame = ViewFrame::default();
                for n in 0.. {
                    let touches = synthetic::wandering(0.01 * f64::from(n));
                    synthetic::show(
                        &synthetic::picture(),
                        &touches,
                        0.01 * f64::from(n),
                        &mut frame,
                    );
                    for pusher in &pushers {
                        pusher.push(&frame).unwrap();
                    }
                    if is_over.load(Ordering::Relaxed) {
                        break;
                    }
                    std::thread::sleep(Duration::from_millis(20));
                }
            });
            let seen = shows_both(&mut chrome, view.url(), is_stacked);
            is_over.store(true, Ordering::Relaxed);
            seen.unwrap();
        });
        let command = |handle: &ViewHandle| handle.commands().recv_timeout(SOON);
        assert_eq!(command(&handles[1]).unwrap(), ViewCommand::Tare);
        assert!(handles[0].commands().try_recv().is_err());
    }
}

fn shows_both(chrome: &mut Chrome, url: &str, is_stacked: bool) -> Result<(), chrome::Fault> {
    chrome.open(url)?;
    for i in 0..LIMBS.len() {
        chrome.wait_for(&format!("globalThis.frames[{i}]?.hapdefView?.drawn > 1"))?;
        let title = format!("frames[{i}].document.getElementById('title').textContent");
        assert_eq!(chrome.eval(&title)?, LIMBS[i]);
    }
    assert_eq!(chrome.eval("document.title")?, "arm");
    let headings = "[...document.querySelectorAll('h2')].map((part) => part.textContent).join()";
    assert_eq!(chrome.eval(headings)?, LIMBS.join(","));
    let below = "(() => { const [a, b] = [...document.querySelectorAll('iframe')].map((part) => part.getBoundingClientRect());
        return b.top >= a.bottom; })()";
    assert_eq!(chrome.eval(below)?, is_stacked);
    let wide = "document.documentElement.scrollWidth <= innerWidth";
    assert_eq!(chrome.eval(wide)?, true);
    chrome.eval("frames[1].document.getElementById('tare').click()")?;
    assert_eq!(chrome.complaints()?, Vec::<String>::new());
    Ok(())
}
