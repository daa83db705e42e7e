//! Serial ports: which there are, who may open them, how soon they hand bytes on.

use std::path::Path;

use hapdef::SourceArg;
use hapdef_cli::shown;
use hapdef_daq::source::{permission_remedy, serial_ports};
use rustix::fs::{Access, access};

use super::check::Check;

pub(super) fn checks(source: Option<&SourceArg>) -> Vec<Check> {
    let ports = serial_ports();
    let mut checks: Vec<Check> = ports.iter().map(|port| permission(&port.stable)).collect();
    if let Some(SourceArg::Serial { device, .. } | SourceArg::Csv { device, .. }) = source {
        let path = Path::new(device);
        let is_listed = ports.iter().any(|port| port.stable == path || port.device == path);
        if !is_listed {
            checks.push(permission(path));
        }
    } else if ports.is_empty() && source.is_none() {
        checks.push(Check::warn(
            "ports",
            "no USB serial port",
            "plug the board in; dmesg | tail shows whether the system sees it",
        ));
    }
    checks
}

fn permission(path: &Path) -> Check {
    let name = format!("port {}", shown(path));
    match access(path, Access::READ_OK | Access::WRITE_OK) {
        Ok(()) => Check::ok(&name, "may be opened"),
        Err(rustix::io::Errno::NOENT) => Check::bad(
            &name,
            "not there",
            "plug it in; hapdef doctor without --source lists the ports",
        ),
        Err(error) => {
            let remedy = permission_remedy(&path.to_string_lossy());
            Check::bad(&name, error.to_string(), remedy)
        }
    }
}

/// How long the driver of an FTDI chip collects bytes.
pub(super) fn latency_check(device: &str) -> Check {
    timer_of(device).map_or_else(
        || Check::ok("latency timer", "this port's driver has none"),
        |(ms, timer)| latency(ms, &timer),
    )
}

/// What the driver's timer says, ms, and its file; none where the port has no such timer.
fn timer_of(device: &str) -> Option<(u32, String)> {
    let path = std::fs::canonicalize(device).ok()?;
    let port = path.file_name()?.to_str()?;
    let timer = format!("/sys/bus/usb-serial/devices/{port}/latency_timer");
    let ms = std::fs::read_to_string(&timer).ok()?.trim().parse().ok()?;
    Some((ms, timer))
}

fn latency(ms: u32, timer: &str) -> Check {
    let found = format!("the driver hands bytes on after {ms} ms");
    match ms {
        0 | 1 => Check::ok("latency timer", found),
        _ => Check::warn(
            "latency timer",
            found,
            format!("echo 1 | sudo tee {timer}, or a udev rule that does"),
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::super::check::State;
    use super::*;

    #[test]
    fn a_port_that_is_not_there_is_bad() {
        let source: SourceArg = "serial:/dev/nowhere".parse().unwrap();
        let checks = checks(Some(&source));
        let last = checks.last().unwrap();
        assert_eq!((last.state, last.found.as_str()), (State::Bad, "not there"));
    }

    #[test]
    fn a_slow_timer_is_named_with_its_file() {
        assert_eq!(latency(1, "/x").state, State::Ok);
        let slow = latency(16, "/sys/x/latency_timer");
        assert!(slow.fix.unwrap().contains("/sys/x/latency_timer"));
        let none = latency_check("/dev/null");
        assert_eq!(none.state, State::Ok);
        assert!(none.found.contains("none"), "{}", none.found);
    }
}
