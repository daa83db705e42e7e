//! The device's end of a link: a pseudo-terminal or a TCP port.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use hapdef_cli::shown;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

/// A link on which a host may be.
pub(super) trait Wire {
    /// Bytes that the host has sent; none while there is none or it says nothing.
    fn read(&mut self) -> Vec<u8>;

    /// Sends as much as the host takes now.
    fn write(&mut self, bytes: &[u8]) -> usize;

    /// Whether a new host came since the last call, where the link can tell.
    fn is_new_host(&mut self) -> bool {
        false
    }

    /// What hosts open.
    fn name(&self) -> String;
}

/// A pseudo-terminal.
pub(super) struct PtyWire {
    master: OwnedFd,
    path: String,
    link: Option<PathBuf>,
}

/// A TCP port; the last host that connects is the one that is served.
pub(super) struct TcpWire {
    listener: TcpListener,
    host: Option<TcpStream>,
    is_new: bool,
}

impl PtyWire {
    /// A pseudo-terminal, with a link to it at `link`; an old link there is replaced.
    pub(super) fn new(link: Option<PathBuf>) -> Result<Self> {
        let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC;
        let master = openpt(flags).context("opening a pseudo-terminal")?;
        grantpt(&master)?;
        unlockpt(&master)?;
        rustix::io::ioctl_fionbio(&master, true)?;
        let path = ptsname(&master, Vec::new())?.to_string_lossy().into_owned();
        if let Some(link) = &link {
            point(link, Path::new(&path))
                .with_context(|| format!("{}: linking to {path}", shown(link)))?;
        }
        Ok(Self { master, path, link })
    }
}

/// Makes `link` a link to `path`; a file that is no link stays and is an error.
fn point(link: &Path, path: &Path) -> io::Result<()> {
    match std::fs::symlink_metadata(link) {
        Ok(data) if data.is_symlink() => std::fs::remove_file(link)?,
        Ok(_) => return Err(ErrorKind::AlreadyExists.into()),
        Err(_) => {}
    }
    std::os::unix::fs::symlink(path, link)
}

impl Wire for PtyWire {
    fn read(&mut self) -> Vec<u8> {
        let mut bytes = vec![0; 4096];
        // Without a host it is an I/O error, which passes.
        let n = rustix::io::read(&self.master, &mut bytes).unwrap_or(0);
        bytes.truncate(n);
        bytes
    }

    fn write(&mut self, bytes: &[u8]) -> usize {
        rustix::io::write(&self.master, bytes).unwrap_or(0)
    }

    fn name(&self) -> String {
        let link = self.link.as_deref();
        format!("serial:{}", link.unwrap_or(Path::new(&self.path)).display())
    }
}

impl Drop for PtyWire {
    fn drop(&mut self) {
        if let Some(link) = &self.link {
            let _ = std::fs::remove_file(link);
        }
    }
}

impl TcpWire {
    pub(super) fn bind(address: &str) -> Result<Self> {
        let listener = TcpListener::bind(address)
            .with_context(|| format!("{address}: listening; is the port taken?"))?;
        listener.set_nonblocking(true)?;
        Ok(Self { listener, host: None, is_new: false })
    }

    fn accept(&mut self) {
        if let Ok((host, _)) = self.listener.accept()
            && host.set_nonblocking(true).is_ok()
            && host.set_nodelay(true).is_ok()
        {
            self.host = Some(host);
            self.is_new = true;
        }
    }

    /// What a use of the connection came to; a connection that is gone is forgotten.
    fn outcome(&mut self, result: io::Result<usize>, is_end: bool) -> usize {
        match result {
            Ok(0) if is_end => self.host = None,
            Ok(n) => return n,
            Err(e) if matches!(e.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => {}
            Err(_) => self.host = None,
        }
        0
    }
}

impl Wire for TcpWire {
    fn read(&mut self) -> Vec<u8> {
        self.accept();
        let mut bytes = vec![0; 4096];
        let result = self.host.as_mut().map(|host| host.read(&mut bytes));
        let n = result.map_or(0, |result| self.outcome(result, true));
        bytes.truncate(n);
        bytes
    }

    fn write(&mut self, bytes: &[u8]) -> usize {
        let result = self.host.as_mut().map(|host| host.write(bytes));
        result.map_or(0, |result| self.outcome(result, false))
    }

    fn is_new_host(&mut self) -> bool {
        std::mem::take(&mut self.is_new)
    }

    fn name(&self) -> String {
        let address = self.listener.local_addr();
        address.map_or_else(|_| "tcp:".to_owned(), |address| format!("tcp:{address}"))
    }
}
