//! Real limbs, one after the other: which become one skin, which not and why.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};
use serde_json::Value;

use crate::metrics;
use crate::tool::{release_binary, results, root};

/// Arguments of `limbs`.
#[derive(clap::Args)]
pub(crate) struct LimbsArgs {
    /// A folder whose surfaces are taken, too, with those of its folders.
    #[arg(long)]
    folder: Option<PathBuf>,
    /// Nothing but that folder.
    #[arg(long, requires = "folder")]
    only: bool,
    /// The seed that the metrics carry; nothing is drawn.
    #[arg(long, default_value_t = 0)]
    seed: u64,
}

/// Endings of surfaces.
const SURFACES: [&str; 5] = ["glb", "gltf", "stl", "obj", "dae"];

/// `cargo xtask limbs`.
pub(crate) fn run(args: &LimbsArgs) -> Result<()> {
    let program = release_binary("hapdef")?;
    let mut files = Vec::new();
    if !args.only {
        let shared =
            std::env::var_os("HAPDEF_SHARED").map_or(root().join("../shared"), PathBuf::from);
        let limbs = shared.join("inputs/limbs");
        if !limbs.exists() {
            println!("skipped: {} is not there; set HAPDEF_SHARED", limbs.display());
        }
        add_surfaces(&limbs, &mut files)?;
        add_surfaces(&root().join("fixtures"), &mut files)?;
    }
    if let Some(folder) = &args.folder {
        add_surfaces(folder, &mut files)?;
    }
    println!("{HEADER}");
    let mut limbs = Vec::new();
    for (number, file) in files.iter().enumerate() {
        let limb = wrapped(&program, file, number)?;
        println!("{}", limb.row());
        limbs.push(limb);
    }
    println!("pages: {}", results().join("limbs").display());
    metrics::report(&figures(&limbs), args.seed, Some(&results().join("metrics.json")));
    Ok(())
}

/// The surfaces in a folder and those in it, by name.
fn add_surfaces(folder: &Path, files: &mut Vec<PathBuf>) -> Result<()> {
    if !folder.exists() {
        return Ok(());
    }
    let entries = fs::read_dir(folder).with_context(|| format!("reading {}", folder.display()))?;
    let mut paths: Vec<PathBuf> = entries.map(|entry| Ok(entry?.path())).collect::<Result<_>>()?;
    paths.sort();
    for path in paths {
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        if path.is_dir() {
            add_surfaces(&path, files)?;
        } else if SURFACES.contains(&ending.as_str()) {
            files.push(path);
        }
    }
    Ok(())
}

/// What became of a limb.
struct Limb {
    name: String,
    /// What `hapdef wrap --json` printed, or why it printed nothing: the file can't be read.
    said: Result<Value, String>,
}

fn wrapped(program: &Path, file: &Path, number: usize) -> Result<Limb> {
    let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let out = results().join("limbs").join(format!("{number:02}-{name}"));
    let mut command = Command::new(program);
    command.arg("wrap").arg(file).arg("--json").arg("--out").arg(&out);
    let output = command.output().with_context(|| format!("starting {}", program.display()))?;
    let said = serde_json::from_slice(&output.stdout)
        .map_err(|_| String::from_utf8_lossy(&output.stderr).trim().to_owned());
    Ok(Limb { name, said })
}

const HEADER: &str = "| limb | mm | wall, mm | s | faithful | triangles | lost, % | bridged, % | to skin, mm: median, 95 % \
                      | to surface, mm: 95 % | angle, ° | thinned |\n|---|---|---|---|---|---|---|---|---|---|---|---|";

impl Limb {
    fn seconds(&self) -> Option<f64> {
        self.said.as_ref().ok()?["seconds"].as_f64()
    }

    /// The skin, if there is one.
    fn skin(&self) -> Option<&Value> {
        self.said.as_ref().ok()?.get("skin")
    }

    fn row(&self) -> String {
        let name = &self.name;
        let said = match &self.said {
            Ok(said) => said,
            Err(error) => return format!("| {name} | – | – | – | not read: {error} |"),
        };
        let number = |value: &Value, factor: f64| value.as_f64().unwrap_or(f64::NAN) * factor;
        let head = format!(
            "| {name} | {:.0} | {:.2} | {:.1} ",
            number(&said["length_m"], 1e3),
            number(&said["wall_m"], 1e3),
            number(&said["seconds"], 1.0)
        );
        let Some(skin) = self.skin() else {
            return format!("{head}| no: {} |", said["refused"].as_str().unwrap_or_default());
        };
        let to_skin = &skin["input_to_skin_m"];
        format!(
            "{head}| yes | {} | {:.2} | {:.1} | {:.2}, {:.2} | {:.2} | {:.0} | {} |",
            skin["n_triangles"],
            number(&skin["share_lost"], 100.0),
            number(&skin["share_bridged"], 100.0),
            number(&to_skin[0], 1e3),
            number(&to_skin[1], 1e3),
            number(&skin["skin_to_input_m"], 1e3),
            number(&skin["smallest_angle_deg"], 1.0),
            skin["n_thinned"]
        )
    }
}

fn figures(limbs: &[Limb]) -> [(&'static str, f64, &'static str); 5] {
    let count = |is: fn(&Limb) -> bool| limbs.iter().filter(|limb| is(limb)).count() as f64;
    let n_read = count(|limb| limb.said.is_ok());
    let n_faithful = count(|limb| limb.skin().is_some());
    let refused = count(|limb| limb.said.as_ref().is_ok_and(|said| said["refused"].is_string()));
    let seconds = limbs.iter().filter_map(Limb::seconds).fold(0.0, f64::max);
    [
        ("limbs.read_pct", 100.0 * n_read / limbs.len().max(1) as f64, "%"),
        ("limbs.n", limbs.len() as f64, "1"),
        ("limbs.faithful", n_faithful, "1"),
        ("limbs.refused_with_reason", refused, "1"),
        ("limbs.seconds_worst", seconds, "s"),
    ]
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn limb(said: Result<Value, String>) -> Limb {
        Limb { name: "shin.stl".into(), said }
    }

    #[test]
    fn limbs_are_counted_by_what_became_of_them() {
        let skin = json!({"seconds": 3.0, "length_m": 0.2, "wall_m": 0.002, "skin": {
            "n_triangles": 1000, "share_lost": 0.01, "share_bridged": 0.0, "n_thinned": 3,
            "input_to_skin_m": [1e-4, 5e-4], "skin_to_input_m": 4e-4, "smallest_angle_deg": 38.2}});
        let limbs = [
            limb(Ok(skin)),
            limb(Ok(json!({"seconds": 7.0, "length_m": 0.2, "wall_m": 0.002, "refused": "open"}))),
            limb(Err("no triangle".into())),
        ];
        let values = figures(&limbs).map(|(_, value, _)| value);
        assert_eq!(values, [200.0 / 3.0, 3.0, 1.0, 1.0, 7.0]);
        assert_eq!(
            limbs[0].row(),
            "| shin.stl | 200 | 2.00 | 3.0 | yes | 1000 | 1.00 | 0.0 | 0.10, 0.50 | 0.40 | 38 | 3 |"
        );
        assert!(limbs[1].row().ends_with("| no: open |"));
        assert!(limbs[2].row().ends_with("not read: no triangle |"));
    }
}
