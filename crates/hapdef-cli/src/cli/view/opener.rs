//! The way from a program that opens addresses to the page, without the token among its arguments, which
//! others on this machine can read.

use std::fs::OpenOptions;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result};

/// A file that only its owner reads and that leads to the page; gone when dropped.
pub(super) struct PageOpener {
    path: PathBuf,
}

impl PageOpener {
    /// A page opener in `folder`, which is made when absent.
    pub(super) fn new(folder: &Path, url: &str) -> Result<Self> {
        let shown = || format!("--view-with: writing in {}", folder.display());
        std::fs::create_dir_all(folder).with_context(shown)?;
        let folder = folder.canonicalize().with_context(shown)?;
        let path = folder.join(format!("open-{}.html", std::process::id()));
        let _ = std::fs::remove_file(&path);
        let mut options = OpenOptions::new();
        options.write(true).create_new(true);
        #[cfg(unix)]
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
        let mut file = options.open(&path).with_context(shown)?;
        let opener = Self { path };
        write!(
            file,
            "<!doctype html>\n<meta charset=\"utf-8\">\n<title>hapdef</title>\n\
             <meta http-equiv=\"refresh\" content=\"0; url={url}\">\n\
             <p><a href=\"{url}\">The live page</a>\n"
        )
        .with_context(shown)?;
        Ok(opener)
    }

    /// Starts `program` with the file; it is not waited for.
    pub(super) fn open_with(&self, program: &Path) -> Result<()> {
        let mut command = Command::new(program);
        let child = command.arg(&self.path).stdin(Stdio::null()).spawn();
        child.map(drop).with_context(|| format!("--view-with: starting {}", program.display()))
    }
}

impl Drop for PageOpener {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.path);
    }
}

#[cfg(test)]
mod tests {
    use super::PageOpener;

    #[test]
    fn only_its_owner_reads_it_and_it_goes_with_the_page() {
        let root = tempfile::tempdir().unwrap();
        let folder = root.path().join("not/there yet");
        let opener = PageOpener::new(&folder, "http://127.0.0.1:1/#token=ab").unwrap();
        let text = std::fs::read_to_string(&opener.path).unwrap();
        assert!(text.contains("url=http://127.0.0.1:1/#token=ab\""), "{text}");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let mode = std::fs::metadata(&opener.path).unwrap().permissions().mode();
            assert_eq!(mode & 0o777, 0o600);
        }
        drop(opener);
        assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 0);
    }
}
