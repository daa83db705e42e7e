//! Real limbs, one after the other: which become one skin, which not and why, and what is felt with them.

mod touch;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};
use serde_json::Value;

use self::touch::Touch;
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
    /// Leave touch out: a minute a limb.
    #[arg(long)]
    skins: bool,
    /// The seed that the metrics carry; presses are the same every time.
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
        let out = out_folder(file, number);
        let mut limb = wrapped(&program, file, &out)?;
        if !args.skins && limb.skin().is_some() {
            let touch = Touch::of(&program, file, &out.join("touch"));
            limb.touch = Some(touch.map_err(|error| format!("{error:#}")));
        }
        println!("{}", limb.row());
        limbs.push(limb);
    }
    println!("pages: {}", results().join("limbs").display());
    if let Some(worst) = worst_touched(&limbs) {
        println!("limbs.touch_median_mm is that of {}", worst.name);
    }
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
    /// Its touch, or why it has none, where that was asked for.
    touch: Option<Result<Touch, String>>,
}

fn name(file: &Path) -> String {
    file.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

fn out_folder(file: &Path, number: usize) -> PathBuf {
    results().join("limbs").join(format!("{number:02}-{}", name(file)))
}

fn wrapped(program: &Path, file: &Path, out: &Path) -> Result<Limb> {
    let mut command = Command::new(program);
    command.arg("wrap").arg(file).arg("--json").arg("--out").arg(out);
    let output = command.output().with_context(|| format!("starting {}", program.display()))?;
    let said = serde_json::from_slice(&output.stdout)
        .map_err(|_| String::from_utf8_lossy(&output.stderr).trim().to_owned());
    Ok(Limb { name: name(file), said, touch: None })
}

const HEADER: &str = "| limb | mm | wall, mm | s | faithful | triangles | lost, % | bridged, % | to skin, mm: median, 95 % \
                      | to surface, mm: 95 % | angle, ° | thinned | new, s | one contact: mm, % beyond 10 mm | two contacts \
                      |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|";

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
            "{head}| yes | {} | {:.2} | {:.1} | {:.2}, {:.2} | {:.2} | {:.0} | {} | {} |",
            skin["n_triangles"],
            number(&skin["share_lost"], 100.0),
            number(&skin["share_bridged"], 100.0),
            number(&to_skin[0], 1e3),
            number(&to_skin[1], 1e3),
            number(&skin["skin_to_input_m"], 1e3),
            number(&skin["smallest_angle_deg"], 1.0),
            skin["n_thinned"],
            self.touch_cells()
        )
    }

    fn touch_cells(&self) -> String {
        match &self.touch {
            Some(Ok(touch)) => touch.cells(),
            Some(Err(why)) => format!("– | no touch: {why} | –"),
            None => "– | – | –".into(),
        }
    }

    fn touched(&self) -> Option<&Touch> {
        self.touch.as_ref()?.as_ref().ok()
    }
}

/// Counts of limbs, the worst of them all, and in words which limb that is.
fn figures(limbs: &[Limb]) -> Vec<(&'static str, f64, &'static str)> {
    let count = |is: fn(&Limb) -> bool| limbs.iter().filter(|limb| is(limb)).count() as f64;
    let n_read = count(|limb| limb.said.is_ok());
    let refused = count(|limb| limb.said.as_ref().is_ok_and(|said| said["refused"].is_string()));
    let most = |of: &dyn Fn(&Limb) -> Option<f64>| limbs.iter().filter_map(of).fold(0.0, f64::max);
    let mut figures = vec![
        ("limbs.read_pct", 100.0 * n_read / limbs.len().max(1) as f64, "%"),
        ("limbs.n", limbs.len() as f64, "1"),
        ("limbs.faithful", count(|limb| limb.skin().is_some()), "1"),
        ("limbs.refused_with_reason", refused, "1"),
        ("limbs.seconds_worst", most(&Limb::seconds), "s"),
    ];
    if limbs.iter().any(|limb| limb.touch.is_some()) {
        let median =
            |i: usize| move |limb: &Limb| limb.touched().map(|touch| touch.errors[i].median_mm);
        figures.extend([
            ("limbs.touched", count(|limb| limb.touched().is_some()), "1"),
            ("limbs.touch_failed", count(|limb| matches!(limb.touch, Some(Err(_)))), "1"),
            ("limbs.touch_median_mm", most(&median(0)), "mm"),
            ("limbs.touch_double_median_mm", most(&median(1)), "mm"),
            ("limbs.new_seconds_worst", most(&|limb| limb.touched().map(|t| t.new_s)), "s"),
        ]);
    }
    figures
}

/// The limb whose single contacts are found worst.
fn worst_touched(limbs: &[Limb]) -> Option<&Limb> {
    let error_mm = |limb: &&Limb| limb.touched().map_or(0.0, |touch| touch.errors[0].median_mm);
    let touched = limbs.iter().filter(|limb| limb.touched().is_some());
    touched.max_by(|a, b| error_mm(a).total_cmp(&error_mm(b)))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::touch::Errors;
    use super::*;

    fn limb(said: Result<Value, String>) -> Limb {
        Limb { name: "shin.stl".into(), said, touch: None }
    }

    #[test]
    fn limbs_are_counted_by_what_became_of_them() {
        let skin = json!({"seconds": 3.0, "length_m": 0.2, "wall_m": 0.002, "skin": {
            "n_triangles": 1000, "share_lost": 0.01, "share_bridged": 0.0, "n_thinned": 3,
            "input_to_skin_m": [1e-4, 5e-4], "skin_to_input_m": 4e-4, "smallest_angle_deg": 38.2}});
        let mut limbs = [
            limb(Ok(skin)),
            limb(Ok(json!({"seconds": 7.0, "length_m": 0.2, "wall_m": 0.002, "refused": "open"}))),
            limb(Err("no triangle".into())),
        ];
        let values = |limbs: &[Limb]| -> Vec<f64> {
            figures(limbs).into_iter().map(|(_, value, _)| value).collect()
        };
        assert_eq!(values(&limbs), [200.0 / 3.0, 3.0, 1.0, 1.0, 7.0]);
        assert!(worst_touched(&limbs).is_none());
        assert_eq!(
            limbs[0].row(),
            "| shin.stl | 200 | 2.00 | 3.0 | yes | 1000 | 1.00 | 0.0 | 0.10, 0.50 | 0.40 | 38 | 3 | – | – | – |"
        );
        assert!(limbs[1].row().ends_with("| no: open |"));
        assert!(limbs[2].row().ends_with("not read: no triangle |"));
        let errors = [(0.5, 0.0), (3.0, 0.06)]
            .map(|(median_mm, share_beyond)| Errors { median_mm, share_beyond });
        limbs[0].touch = Some(Ok(Touch { new_s: 41.0, errors }));
        assert!(limbs[0].row().ends_with("| 3 | 41 | 0.50, 0 | 3.00, 6 |"), "{}", limbs[0].row());
        assert_eq!(values(&limbs)[5..], [1.0, 0.0, 0.5, 3.0, 41.0]);
        assert_eq!(worst_touched(&limbs).unwrap().name, "shin.stl");
        limbs[0].touch = Some(Err("new: no place".into()));
        assert!(limbs[0].row().contains("no touch: new: no place"));
        assert_eq!(values(&limbs)[5..7], [0.0, 1.0]);
    }
}
