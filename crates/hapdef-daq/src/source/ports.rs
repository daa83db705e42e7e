//! Which serial ports there are, under names that stay, and who may open them.

use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

/// A serial port.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PortInfo {
    /// A name that stays when the device is unplugged and comes back; the device's own path where
    /// there is none.
    pub stable: PathBuf,
    /// Path of the device at present.
    pub device: PathBuf,
}

/// The serial ports of USB devices, by name.
#[must_use]
pub fn serial_ports() -> Vec<PortInfo> {
    ports_in(Path::new("/dev"))
}

fn ports_in(dev: &Path) -> Vec<PortInfo> {
    let mut ports: Vec<PortInfo> = entries(&dev.join("serial/by-id"))
        .filter_map(|stable| {
            let device = std::fs::canonicalize(&stable).ok()?;
            Some(PortInfo { stable, device })
        })
        .collect();
    let is_usb = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name.starts_with("ttyACM") || name.starts_with("ttyUSB")
    };
    for device in entries(dev).filter(is_usb) {
        let device = std::fs::canonicalize(&device).unwrap_or(device);
        if !ports.iter().any(|port| port.device == device) {
            ports.push(PortInfo { stable: device.clone(), device });
        }
    }
    ports.sort_by(|a, b| a.stable.cmp(&b.stable));
    ports
}

/// What to do when a port may not be opened: the group that owns it, and the udev rule.
#[must_use]
pub fn permission_remedy(path: &str) -> String {
    let gid = std::fs::metadata(path).map(|data| data.gid());
    let group = gid.ok().and_then(|gid| {
        let groups = std::fs::read_to_string("/etc/group").unwrap_or_default();
        group_name(&groups, gid)
    });
    let rule = "KERNEL==\"ttyACM[0-9]*|ttyUSB[0-9]*\", TAG+=\"uaccess\"";
    match group.filter(|name| name != "root") {
        Some(group) => {
            format!("join the group that owns it: sudo usermod -aG {group} $USER, and log in again")
        }
        None => format!("put {rule} into /etc/udev/rules.d/60-hapdef.rules and plug it in again"),
    }
}

fn group_name(groups: &str, gid: u32) -> Option<String> {
    let fields = groups.lines().map(|line| line.split(':'));
    fields
        .filter_map(|mut line| {
            let name = line.next()?;
            (line.nth(1)?.parse() == Ok(gid)).then(|| name.to_owned())
        })
        .next()
}

fn entries(folder: &Path) -> impl Iterator<Item = PathBuf> {
    let read = std::fs::read_dir(folder).into_iter().flatten();
    read.filter_map(|entry| Some(entry.ok()?.path()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_are_found_by_number() {
        let groups = "root:x:0:\ndialout:x:20:ann,bob\nbroken\n";
        assert_eq!(group_name(groups, 20).as_deref(), Some("dialout"));
        assert_eq!(group_name(groups, 21), None);
        assert!(permission_remedy("/nowhere").contains("udev"));
    }

    #[test]
    fn ports_go_by_their_stable_name() {
        let dev = tempfile::tempdir().unwrap();
        let by_id = dev.path().join("serial/by-id");
        std::fs::create_dir_all(&by_id).unwrap();
        for name in ["ttyACM0", "ttyUSB3", "tty7"] {
            std::fs::write(dev.path().join(name), "").unwrap();
        }
        std::os::unix::fs::symlink("../../ttyACM0", by_id.join("usb-Arduino_Due")).unwrap();
        let ports = ports_in(dev.path());
        let names: Vec<_> = ports.iter().map(|p| p.stable.file_name().unwrap()).collect();
        assert_eq!(names, ["usb-Arduino_Due", "ttyUSB3"]);
        assert_eq!(ports[0].device.file_name().unwrap(), "ttyACM0");
    }
}
