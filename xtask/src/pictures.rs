//! The pictures of the docs: each page as a headless Chromium draws it.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};

use crate::browser::{Served, found};
use crate::tool::{release_example, results, root, run};

/// Arguments of `pictures`.
#[derive(clap::Args)]
pub(crate) struct PicturesArgs {
    /// These only, by their names under docs/images/; all if nothing is said.
    names: Vec<String>,
    /// Write them into this folder instead of docs/images.
    #[arg(long)]
    into: Option<PathBuf>,
}

/// A page that a command has written.
struct Shot {
    /// Of the picture, without its ending.
    name: &'static str,
    /// Where results are.
    page: &'static str,
    made_by: &'static str,
    part: Part,
}

/// What of a page is in the picture; selectors are CSS.
enum Part {
    /// From this element on, in a window of this size.
    From(&'static str, &'static str),
    /// All of it, in a window of this size.
    Whole(&'static str),
}

/// Pictures of the live page: their names, windows and colours.
const LIVE: [(&str, &str, &str); 3] = [
    ("live", "1280x800", "dark"),
    ("live-light", "1280x800", "light"),
    ("live-phone", "390x844", "light"),
];

/// The moving picture of the live page: its window and its length, s.
const FILM: (&str, &str, &str) = ("live-moving", "960x620", "6");

/// Waits until what is shown has been so for a while.
const FILM_SCRIPT: &str = "new Promise((done) => setTimeout(() => done('seen enough'), 20000))";

/// Waits for plots that are full and a press on the side that is seen, and stops there.
const LIVE_SCRIPT: &str = "new Promise((done) => {
    const began = performance.now();
    const look = () => {
        const view = hapdefView, facing = view.facing(), seconds = (performance.now() - began) / 1000;
        const isNear = (c) => Math.hypot(...c.map((x, i) => x - view.node(facing)[i])) < 0.6 * view.radius;
        const isSeen = view.coloured > 0 && facing >= 0 && view.contacts.some(isNear);
        if (isSeen && seconds > 12) {
            document.getElementById('pause').click();
            done('pressed in front');
        } else if (seconds > 90) done('no press in front for a minute and a half');
        else setTimeout(look, 20);
    };
    look();
})";

const PAGE_SIZE: &str = "1100x760";
/// Holds a figure from end to end.
const FIGURE_SIZE: &str = "1100x1040";
const PAGE_S: &str = "1";

const SHOTS: [Shot; 15] = [
    Shot {
        name: "demo",
        page: "shin-demo/demo/contacts.svg",
        made_by: "cargo xtask demo",
        part: Part::Whole("1040x512"),
    },
    picture("shin-rigidity", "shin/report/rigidity-limb.svg", "cargo xtask repro --tables"),
    picture("shin-double", "shin/report/figure6b-limb.svg", "cargo xtask repro --tables"),
    figure("report", "shin/report/report.html", "cargo xtask repro --tables"),
    top("compare", "shin-placed/compare/report.html", "cargo xtask compare"),
    top("verify", "verify/report.html", "cargo xtask verify"),
    figure("frontier", "shin-placed-anew/frontier/report.html", "cargo xtask frontier"),
    top("stability", "stability/report.html", "cargo xtask robustness"),
    top("stability-fe", "stability-fe/report.html", "cargo xtask robustness fe"),
    top("stability-nets", "stability-nets/report.html", "cargo xtask robustness nets"),
    top("stability-inverse", "stability-inverse/report.html", "cargo xtask robustness inverse"),
    top("stability-parts", "stability-parts/report.html", "cargo xtask robustness parts"),
    figure("limits", "shin/limits.html", "cargo hapdef limits fixtures/shin/scene.json"),
    figure("place", "shin/placement.html", "cargo hapdef place fixtures/shin/scene.json"),
    figure(
        "shell",
        "shin_skin/shell-report.html",
        "cargo hapdef shell fixtures/shin/shin_skin.glb --unit m --wall 1 --solid",
    ),
];

/// A page from its top.
const fn top(name: &'static str, page: &'static str, made_by: &'static str) -> Shot {
    Shot { name, page, made_by, part: Part::From("body", PAGE_SIZE) }
}

/// A page from its first figure.
const fn figure(name: &'static str, page: &'static str, made_by: &'static str) -> Shot {
    Shot { name, page, made_by, part: Part::From("figure", FIGURE_SIZE) }
}

/// A picture that stands alone.
const fn picture(name: &'static str, page: &'static str, made_by: &'static str) -> Shot {
    Shot { name, page, made_by, part: Part::Whole("1040x682") }
}

/// `cargo xtask pictures`.
pub(crate) fn run_some(args: &PicturesArgs) -> Result<()> {
    if found().is_none() {
        bail!(
            "no Chromium: `cargo xtask browser` installs one as root, or name one in HAPDEF_CHROMIUM"
        );
    }
    let live = LIVE.iter().map(|(name, ..)| *name).chain([FILM.0]);
    let known: Vec<&str> = SHOTS.iter().map(|shot| shot.name).chain(live).collect();
    if let Some(other) = args.names.iter().find(|name| !known.contains(&name.as_str())) {
        bail!("{other}: expected one of {}", known.join(", "));
    }
    let folder = args.into.clone();
    let folder = folder.unwrap_or_else(|| root().join("docs/images"));
    std::fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    let is_wanted = |name: &str| args.names.is_empty() || args.names.iter().any(|n| n == name);
    let camera = release_example("view_shot")?;
    for shot in SHOTS.iter().filter(|shot| is_wanted(shot.name)) {
        let page = results().join(shot.page);
        if !page.exists() {
            bail!("{}: made by `{}`", page.display(), shot.made_by);
        }
        let (size, script) = shot.part.shown();
        let url = format!("file://{}", page.display());
        let file = image(&folder, shot.name);
        take(&camera, &url, &file, &[size, "light", PAGE_S, &script])?;
    }
    let live: Vec<_> = LIVE.iter().filter(|(name, ..)| is_wanted(name)).collect();
    if live.is_empty() && !is_wanted(FILM.0) {
        return Ok(());
    }
    let served = Served::start(None)?;
    for (name, size, colours) in live {
        let file = image(&folder, name);
        take(&camera, &served.url, &file, &[size, colours, "0", LIVE_SCRIPT])?;
    }
    let (name, size, seconds) = FILM;
    if is_wanted(name) {
        let camera = release_example("view_film")?;
        take(&camera, &served.url, &image(&folder, name), &[size, seconds, FILM_SCRIPT])?;
    }
    Ok(())
}

impl Part {
    /// The window's size, and what the page does before its picture is taken.
    fn shown(&self) -> (&'static str, String) {
        match self {
            Self::From(selector, size) => {
                (size, format!("document.querySelector(\"{selector}\").scrollIntoView(); scrollY"))
            }
            Self::Whole(size) => (size, "0".to_owned()),
        }
    }
}

fn take(camera: &Path, url: &str, file: &Path, words: &[&str]) -> Result<()> {
    run(Command::new(camera).arg(url).arg(file).args(words))?;
    let bytes = std::fs::metadata(file).with_context(|| file.display().to_string())?.len();
    println!("{} kB  {}", bytes.div_ceil(1000), file.display());
    Ok(())
}

fn image(folder: &Path, name: &str) -> PathBuf {
    folder.join(name).with_extension("webp")
}
