//! What a COLLADA file says of its lengths and axes.

use std::path::Path;

use hapdef_contact::printable;
use roxmltree::Document;

use super::Guess;
use crate::error::HapdefError;

/// The `asset` of a file, as far as it is of lengths and axes.
///
/// Source: COLLADA 1.4.1, chapter 5, `asset`: `<unit meter="0.01" name="centimeter"/>`, metres where it is left
/// out, and `<up_axis>Z_UP</up_axis>`.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Asset {
    /// A length of 1 in m, and what the file calls it.
    unit: Option<(f64, String)>,
    /// `X_UP`, `Y_UP` or `Z_UP`.
    up_axis: Option<String>,
}

impl Asset {
    /// That of a file; empty where it has none that can be read.
    ///
    /// # Errors
    /// [`HapdefError::NewLimb`] for a file that can't be read.
    pub(super) fn read(path: &Path) -> Result<Self, HapdefError> {
        let bytes = std::fs::read(path)
            .map_err(|error| HapdefError::NewLimb { path: path.into(), what: error.to_string() })?;
        Ok(Self::of_text(&String::from_utf8_lossy(&bytes)))
    }

    /// The first asset of a file is the file's own; what follows it is not looked at.
    fn of_text(text: &str) -> Self {
        let asset = || {
            let (_, rest) = text.split_once("<asset")?;
            let (inside, _) = rest.split_once("</asset>")?;
            Some(format!("<asset{inside}</asset>"))
        };
        let Some(asset) = asset() else { return Self::default() };
        let Ok(document) = Document::parse(&asset) else { return Self::default() };
        let child = |name| document.root_element().children().find(move |c| c.has_tag_name(name));
        let unit = child("unit").and_then(|unit| {
            let metres = unit.attribute("meter").unwrap_or("1").trim().parse().ok()?;
            Some((metres, printable(unit.attribute("name").unwrap_or("no name"))))
        });
        let up_axis = child("up_axis").and_then(|axis| axis.text());
        Self { unit, up_axis: up_axis.map(|axis| printable(axis.trim())) }
    }

    /// What was done with its unit, in words.
    pub(super) fn unit_in_words(&self) -> String {
        match &self.unit {
            Some((metres, name)) => {
                format!("the file states its unit, {metres} m ({name}), and is read in it")
            }
            None => "the file states no unit, which in COLLADA is the metre".to_owned(),
        }
    }

    /// What was done with its upward axis, where it states one.
    pub(super) fn up_axis(&self) -> Option<Guess> {
        let value = self.up_axis.clone()?;
        let why =
            "stated by the file and not applied, as in RViz and Gazebo: x, y and z stay the file's";
        Some(Guess { what: "up axis", value, why: why.to_owned() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::new_limb::{NewLimb, NewLimbParams};

    /// A box 20 long, 4 wide and 3 high, in a unit.
    fn file(asset: &str) -> String {
        let corners = (0..8).map(|i| {
            let [x, y, z] = [20 * (i & 1), 4 * (i >> 1 & 1), 3 * (i >> 2)];
            format!("{x} {y} {z}")
        });
        let faces = "0 2 1 1 2 3 4 5 6 5 7 6 0 1 4 1 5 4 2 6 3 3 6 7 0 4 2 2 4 6 1 3 5 3 7 5";
        format!(
            r##"<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
{asset}
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="24">{}</float_array><technique_common>
<accessor source="#a" count="8" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="12"><input semantic="VERTEX" source="#v" offset="0"/><p>{faces}</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node><instance_geometry url="#g"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>"##,
            corners.collect::<Vec<_>>().join(" ")
        )
    }

    fn guesses(asset: &str, params: &NewLimbParams) -> Vec<(&'static str, String, String)> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("limb.dae");
        std::fs::write(&path, file(asset)).unwrap();
        let limb = NewLimb::guess(&path, params).unwrap();
        let guesses = limb.guesses.into_iter();
        guesses.map(|guess| (guess.what, guess.value, guess.why)).collect()
    }

    #[test]
    fn unit_and_upward_axis_are_said_with_what_was_done() {
        let asset =
            "<asset>\n<unit meter=\"0.01\" name=\"centimeter\"/>\n<up_axis>Z_UP</up_axis></asset>";
        let all = guesses(asset, &NewLimbParams::default());
        let of = |what: &str| all.iter().find(|(found, ..)| *found == what).unwrap();
        let (_, value, why) = of("unit");
        assert_eq!(value, "m");
        assert_eq!(why, "the file states its unit, 0.01 m (centimeter), and is read in it");
        let (_, value, why) = of("up axis");
        assert_eq!(value, "Z_UP");
        assert!(why.contains("not applied"), "{why}");
        // 20 cm along x: the upward axis did not turn it
        assert_eq!(of("axis").1, "1.00,0.00,0.00");
    }

    #[test]
    fn a_file_that_states_nothing_is_in_metres() {
        assert_eq!(Asset::of_text("<COLLADA/>"), Asset::default());
        assert_eq!(Asset::of_text("<asset><unit</asset>"), Asset::default());
        assert_eq!(Asset::of_text("<asset><created>x</created></asset>"), Asset::default());
        assert!(Asset::default().unit_in_words().contains("metre"));
        assert_eq!(Asset::default().up_axis(), None);
        let odd = Asset::of_text("<asset><up_axis> Y\u{9b}UP </up_axis></asset>");
        assert!(!odd.up_axis().unwrap().value.contains('\u{9b}'));
    }
}
