//! The page's files, embedded.

use std::borrow::Cow;

/// A file of the page.
pub(crate) struct Asset {
    /// Its path, from `/`.
    pub(crate) path: &'static str,
    /// Its media type.
    pub(crate) media_type: &'static str,
    text: &'static str,
}

pub(crate) const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const JS: &str = "text/javascript; charset=utf-8";
const SVG: &str = "image/svg+xml";

macro_rules! asset {
    ($path:literal, $file:literal, $media_type:expr) => {
        Asset {
            path: $path,
            media_type: $media_type,
            text: include_str!(concat!("../assets/", $file)),
        }
    };
}

/// Every file of a limb's page.
pub(crate) const ASSETS: &[Asset] = &[
    asset!("/", "index.html", HTML),
    asset!("/style.css", "style.css", CSS),
    asset!("/icon.svg", "icon.svg", SVG),
    asset!("/js/main.js", "js/main.js", JS),
    asset!("/js/link.js", "js/link.js", JS),
    asset!("/js/reading.js", "js/reading.js", JS),
    asset!("/js/wire.js", "js/wire.js", JS),
    asset!("/js/history.js", "js/history.js", JS),
    asset!("/js/colour.js", "js/colour.js", JS),
    asset!("/js/stage.js", "js/stage.js", JS),
    asset!("/js/blind.js", "js/blind.js", JS),
    asset!("/js/picture.js", "js/picture.js", JS),
    asset!("/js/limb.js", "js/limb.js", JS),
    asset!("/js/follow.js", "js/follow.js", JS),
    asset!("/js/nearest.js", "js/nearest.js", JS),
    asset!("/js/marks.js", "js/marks.js", JS),
    asset!("/js/sign.js", "js/sign.js", JS),
    asset!("/js/sites.js", "js/sites.js", JS),
    asset!("/js/axes.js", "js/axes.js", JS),
    asset!("/js/labels.js", "js/labels.js", JS),
    asset!("/js/legend.js", "js/legend.js", JS),
    asset!("/js/plot.js", "js/plot.js", JS),
    asset!("/js/panel.js", "js/panel.js", JS),
    asset!("/js/text.js", "js/text.js", JS),
    asset!("/js/press.js", "js/press.js", JS),
    asset!("/js/truth.js", "js/truth.js", JS),
    asset!("/js/zoom.js", "js/zoom.js", JS),
    asset!("/js/controls.js", "js/controls.js", JS),
    asset!("/vendor/three/LICENSE", "vendor/three/LICENSE", "text/plain; charset=utf-8"),
    asset!("/vendor/three/three.module.min.js", "vendor/three/three.module.min.js", JS),
    asset!("/vendor/three/OrbitControls.js", "vendor/three/OrbitControls.js", JS),
];

/// What the page of a robot has of its own.
const ROBOT_ASSETS: [Asset; 2] =
    [asset!("/js/robot.js", "js/robot.js", JS), asset!("/robot.css", "robot.css", CSS)];

/// The import by a bare name in the vendored controls, which browsers resolve only by an inline map.
const BARE_IMPORT: &str = "from 'three';";
const OWN_IMPORT: &str = "from './three.module.min.js';";

impl Asset {
    /// What is served: the file, with its bare import resolved.
    pub(crate) fn body(&self) -> Cow<'static, str> {
        if self.path.ends_with("/OrbitControls.js") {
            Cow::Owned(self.text.replace(BARE_IMPORT, OWN_IMPORT))
        } else {
            Cow::Borrowed(self.text)
        }
    }
}

/// The file at `path`.
pub(crate) fn find(path: &str) -> Option<&'static Asset> {
    ASSETS.iter().chain(&ROBOT_ASSETS).find(|asset| asset.path == path)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::path::Path;

    use sha2::{Digest, Sha256};

    use super::{ASSETS, Asset, find};

    #[test]
    fn vendored_files_are_what_was_taken() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/vendor/three");
        let sums = std::fs::read_to_string(folder.join("SHA256SUMS")).unwrap();
        let mut summed = BTreeSet::from(["SHA256SUMS".to_owned(), "README.md".to_owned()]);
        for line in sums.lines() {
            let (sum, name) = line.split_once("  ").unwrap();
            let digest = Sha256::digest(std::fs::read(folder.join(name)).unwrap());
            let found: String = digest.iter().map(|byte| format!("{byte:02x}")).collect();
            assert_eq!(found, sum, "{name}");
            summed.insert(name.to_owned());
        }
        let there: BTreeSet<String> = std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        assert_eq!(there, summed);
    }

    /// What a script imports, as paths from `/`.
    fn imports(asset: &Asset) -> Vec<String> {
        let folder = asset.path.rsplit_once('/').unwrap().0;
        let body = asset.body();
        let statements = body.split("import ").skip(1).filter_map(|rest| rest.split_once(';'));
        let sources = statements.filter_map(|(statement, _)| statement.split_once(" from "));
        sources
            .map(|(_, source)| source.trim_matches(['\'', '"']))
            .map(|source| match source.strip_prefix("../") {
                Some(rest) => format!("/{rest}"),
                None => source.replacen('.', folder, 1),
            })
            .collect()
    }

    #[test]
    fn every_import_is_served() {
        let mut n_imports = 0;
        for asset in ASSETS.iter().filter(|asset| asset.path.ends_with(".js")) {
            if asset.path.ends_with(".min.js") {
                continue;
            }
            for path in imports(asset) {
                assert!(find(&path).is_some(), "{} imports {path}", asset.path);
                n_imports += 1;
            }
        }
        assert!(n_imports > 20, "only {n_imports} imports found");
    }

    #[test]
    fn the_page_asks_nobody_else() {
        for asset in ASSETS.iter().filter(|asset| !asset.path.starts_with("/vendor")) {
            let own = asset.body().replace("http://www.w3.org/2000/svg", "");
            assert!(!own.contains("http://") && !own.contains("https://"), "{}", asset.path);
        }
    }

    #[test]
    fn nothing_is_inline() {
        let page = find("/").unwrap().body();
        let handlers = ["onclick=", "onload=", "oninput=", "onerror=", "javascript:"];
        for inline in ["style=", "<style"].into_iter().chain(handlers) {
            assert!(!page.contains(inline), "{inline}");
        }
        assert_eq!(
            page.matches("<script").count(),
            page.matches("<script type=\"module\" src=").count()
        );
    }
}
