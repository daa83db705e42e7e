//! The page as files that any web server shows, for a program that is a module in the browser.

use std::borrow::Cow;

use crate::assets::ASSETS;

/// A file of the page without a server.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StaticFile {
    /// Its path below the page's folder.
    pub path: &'static str,
    /// What is in it.
    pub text: Cow<'static, str>,
}

/// The file that speaks to the program, and what stands in its place here.
const LINK: (&str, &str) = ("js/link.js", include_str!("../assets/js/local/link.js"));
const WORKER: (&str, &str) = ("js/worker.js", include_str!("../assets/js/local/worker.js"));

/// Where the page looks for the program's module, below its folder.
pub const STATIC_MODULE: &str = "hapdef.wasm";
/// Where it looks for the limb's model.
pub const STATIC_MODEL: &str = "limb.model";

/// The page's files but the program's module and model.
#[must_use]
pub fn static_files() -> Vec<StaticFile> {
    let served = ASSETS.iter().map(|asset| {
        let path = match asset.path {
            "/" => "index.html",
            path => path.trim_start_matches('/'),
        };
        let text = if path == LINK.0 { Cow::Borrowed(LINK.1) } else { asset.body() };
        StaticFile { path, text }
    });
    let worker = StaticFile { path: WORKER.0, text: Cow::Borrowed(WORKER.1) };
    served.chain([worker]).collect()
}

#[cfg(test)]
mod tests {
    use super::{STATIC_MODEL, STATIC_MODULE, static_files};

    /// It is shown below any path, and asks for nothing but its own files.
    #[test]
    fn nothing_is_asked_from_the_root_of_a_server() {
        let files = static_files();
        let page = files.iter().find(|file| file.path == "index.html").unwrap();
        for quoted in ["href=\"/", "src=\"/"] {
            assert!(!page.text.contains(quoted), "{quoted}");
        }
        for file in files.iter().filter(|file| !file.path.starts_with("vendor")) {
            assert!(!file.text.contains("WebSocket("), "{}", file.path);
        }
    }

    #[test]
    fn the_worker_asks_for_the_module_and_the_model() {
        let files = static_files();
        let worker = files.iter().find(|file| file.path == "js/worker.js").unwrap();
        for name in [STATIC_MODULE, STATIC_MODEL] {
            assert!(worker.text.contains(&format!("\"../{name}\"")), "{name}");
        }
        let link = files.iter().find(|file| file.path == "js/link.js").unwrap();
        assert!(link.text.contains("\"./worker.js\""));
    }
}
