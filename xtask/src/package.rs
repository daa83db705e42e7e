//! Whether the crates can be published as they are.

use anyhow::{Context, Result, bail};
use serde_json::Value;

use crate::tool::{cargo, metadata, run_quietly};

/// Crates that nobody else builds upon.
const OWN: [&str; 5] = ["hapdef-py", "hapdef-repro", "hapdef-verify", "workspace-hack", "xtask"];

/// Most keywords that crates.io takes.
const MAX_KEYWORDS: usize = 5;

/// Checks what every manifest says of its crate, and packs all that are published, by what cargo has here.
pub(crate) fn check() -> Result<()> {
    let metadata = metadata()?;
    let packages = metadata["packages"].as_array().context("cargo metadata: packages")?;
    for package in packages {
        let faults = faults(package);
        if !faults.is_empty() {
            bail!("{}: {}", package["manifest_path"], faults.join(", "));
        }
    }
    let words = ["package", "--workspace", "--no-verify", "--allow-dirty", "--offline"];
    let mut command = cargo(&words);
    command.args(OWN.iter().flat_map(|name| ["--exclude", name]));
    run_quietly(&mut command)
}

/// What keeps a package from being published, or from staying here.
fn faults(package: &Value) -> Vec<String> {
    let name = package["name"].as_str().unwrap_or_default();
    let is_kept = package["publish"].as_array().is_some_and(Vec::is_empty);
    if OWN.contains(&name) {
        return if is_kept { vec![] } else { vec!["expected publish = false".into()] };
    }
    let texts = ["description", "license", "readme", "rust_version"];
    let missing = texts.into_iter().filter(|field| !package[*field].is_string());
    let mut faults: Vec<String> = missing.map(|field| format!("no {field}")).collect();
    for field in ["keywords", "categories"] {
        let n = package[field].as_array().map_or(0, Vec::len);
        if !(1..=MAX_KEYWORDS).contains(&n) {
            faults.push(format!("{n} {field}, expected 1 to {MAX_KEYWORDS}"));
        }
    }
    if is_kept {
        faults.push("publish = false".into());
    }
    faults
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::faults;

    #[test]
    fn what_a_manifest_lacks_is_named() {
        let mut package = json!({
            "name": "hapdef-mesh", "description": "d", "license": "l", "readme": "r",
            "rust_version": "1.90", "keywords": ["a"], "categories": ["science"], "publish": null,
        });
        assert_eq!(faults(&package), Vec::<String>::new());
        package["rust_version"] = json!(null);
        package["keywords"] = json!(["a", "b", "c", "d", "e", "f"]);
        assert_eq!(faults(&package), ["no rust_version", "6 keywords, expected 1 to 5"]);
        package = json!({"name": "xtask", "publish": null});
        assert_eq!(faults(&package), ["expected publish = false"]);
    }
}
