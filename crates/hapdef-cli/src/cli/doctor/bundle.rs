//! A model bundle: whether it is whole, and made by this version.

use std::path::Path;

use hapdef_live::Bundle;

use super::check::Check;

/// Reads a bundle with all its hashes; the names of its gauges where it can be read.
pub(super) fn checks(path: &Path) -> (Vec<Check>, Option<Vec<String>>) {
    let remake = format!("hapdef bundle SCENE.json -o {}", path.display());
    let bundle = match Bundle::read(path) {
        Ok(bundle) => bundle,
        Err(error) => return (vec![Check::bad("bundle", error.to_string(), remake)], None),
    };
    let info = &bundle.info;
    let found = format!(
        "{} of {} gauges and {} skin nodes, every hash is right",
        info.scene,
        info.gauges.len(),
        bundle.skin().n_nodes()
    );
    let checks = vec![
        Check::ok("bundle", found),
        version(&info.made_by, &remake),
        calibration(bundle.calibration_json.is_some()),
    ];
    let names = info.gauges.iter().map(|gauge| gauge.name.clone());
    (checks, Some(names.collect()))
}

fn version(made_by: &str, remake: &str) -> Check {
    let ours = env!("CARGO_PKG_VERSION");
    let found = format!("made by hapdef {made_by}, this is {ours}");
    if made_by == ours {
        Check::ok("version", found)
    } else {
        Check::warn("version", found, remake)
    }
}

fn calibration(is_calibrated: bool) -> Check {
    if is_calibrated {
        return Check::ok("calibration", "in the bundle");
    }
    Check::warn(
        "calibration",
        "none: contacts are those of the limb as it was drawn",
        "hapdef calibrate (docs/train-or-calibrate.md), name its result in the scene, make the bundle again",
    )
}

#[cfg(test)]
mod tests {
    use super::super::check::State;
    use super::*;

    #[test]
    fn another_version_is_told() {
        assert_eq!(version(env!("CARGO_PKG_VERSION"), "x").state, State::Ok);
        let other = version("0.0.0", "hapdef bundle");
        assert_eq!(other.state, State::Warn);
        assert!(other.to_string().contains("hapdef bundle"), "{other}");
    }

    #[test]
    fn what_is_no_bundle_is_bad() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("shin.hapdef");
        std::fs::write(&path, [7; 100]).unwrap();
        let (checks, names) = super::checks(&path);
        assert_eq!(checks.len(), 1);
        assert_eq!(checks[0].state, State::Bad);
        assert!(names.is_none());
    }
}
