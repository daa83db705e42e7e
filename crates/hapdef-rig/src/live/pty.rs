//! A pseudo-terminal that looks like a serial port with the device behind it.

use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};

use rustix::fs::{Mode, OFlags, open};
use rustix::io::Errno;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

use super::port::{DevicePort, PortState, port_error};
use crate::error::RigError;

/// A pseudo-terminal; the host opens [`PtyPort::path`], or a link to it whose name stays.
#[derive(Debug)]
pub struct PtyPort {
    master: Option<OwnedFd>,
    path: PathBuf,
    link: Option<PathBuf>,
}

impl PtyPort {
    /// Opens a pseudo-terminal. A `link` is a symbolic link to it, made anew at every plugging in, as
    /// udev does under /dev/serial/by-id; another link in its place is replaced, another file is not.
    ///
    /// # Errors
    /// [`RigError::Port`] when there is no pseudo-terminal left, or the link can't be made.
    pub fn open(link: Option<&Path>) -> Result<Self, RigError> {
        let mut port =
            Self { master: None, path: PathBuf::new(), link: link.map(Path::to_path_buf) };
        port.replug()?;
        Ok(port)
    }

    /// The terminal's own path; another one after it was plugged in again.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    fn remove_link(&self) {
        if let Some(link) = &self.link
            && std::fs::read_link(link).is_ok_and(|target| target == self.path)
        {
            // It may be gone already; then that is what is wanted.
            let _ = std::fs::remove_file(link);
        }
    }
}

impl DevicePort for PtyPort {
    fn look(&mut self, from_host: &mut Vec<u8>) -> PortState {
        let Some(master) = &self.master else {
            return PortState::Closed;
        };
        let mut buffer = [0; 256];
        match rustix::io::read(master, &mut buffer) {
            Ok(n) => {
                from_host.extend_from_slice(&buffer[..n]);
                PortState::Open
            }
            Err(Errno::AGAIN | Errno::INTR) => PortState::Open,
            // EIO: nobody has the host's end open.
            Err(_) => PortState::Closed,
        }
    }

    fn send(&mut self, bytes: &[u8]) -> usize {
        let sent = self.master.as_ref().map(|m| rustix::io::write(m, bytes));
        sent.and_then(Result::ok).unwrap_or(0)
    }

    fn unplug(&mut self) {
        self.remove_link();
        self.master = None;
    }

    fn replug(&mut self) -> Result<(), RigError> {
        let (master, path) = pty().map_err(|e| port_error("pseudo-terminal", e.into()))?;
        if let Some(link) = &self.link {
            let is_link = std::fs::symlink_metadata(link).is_ok_and(|m| m.is_symlink());
            let removed = if is_link { std::fs::remove_file(link) } else { Ok(()) };
            removed
                .and_then(|()| std::os::unix::fs::symlink(&path, link))
                .map_err(|e| port_error(&link.display().to_string(), e))?;
        }
        (self.master, self.path) = (Some(master), path);
        Ok(())
    }

    fn name(&self) -> String {
        let path = self.link.as_ref().unwrap_or(&self.path);
        path.display().to_string()
    }
}

impl Drop for PtyPort {
    fn drop(&mut self) {
        self.remove_link();
    }
}

/// The device's end, which does not wait, and the path of the host's end, set to raw bytes.
fn pty() -> rustix::io::Result<(OwnedFd, PathBuf)> {
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)?;
    grantpt(&master)?;
    unlockpt(&master)?;
    let name = ptsname(&master, Vec::new())?;
    rustix::io::ioctl_fionbio(&master, true)?;
    // Opened and closed once: from then on a read says whether a host has it open.
    let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
    let host = open(name.as_c_str(), flags, Mode::empty())?;
    let mut settings = tcgetattr(&host)?;
    settings.make_raw();
    tcsetattr(&host, OptionalActions::Now, &settings)?;
    drop(host);
    let path = PathBuf::from(name.to_string_lossy().into_owned());
    Ok((master, path))
}
