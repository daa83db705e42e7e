//! Scene section about the limb's shape.

use std::path::{Path, PathBuf};

use hapdef_mesh::{LengthUnit, SkinSide};
use nalgebra::Point3;
use serde::{Deserialize, Serialize};

/// Where the limb's shape comes from.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(try_from = "Fields", into = "Fields")]
pub struct Geometry {
    /// The solid, or the skin that it is made of.
    pub shape: Shape,
    /// Unit of the file's lengths; a deck's is metres or millimetres. Its stresses and densities go
    /// along: Pa and kg/m³ with metres, MPa and t/mm³ with millimetres.
    pub unit: LengthUnit,
    /// The limb's long axis, for unrolling, for radial rules and for its ends; if absent, the longest
    /// principal axis of its surface, through the middle of its bounding box.
    pub axis: Option<Axis>,
    /// How many times every tetrahedron is cut into eight before anything else;
    /// `hapdef converge` says how many it takes.
    pub refinements: u32,
    /// Surface (`.glb`, `.gltf`) in metres and in the limb's frame that the live page draws instead
    /// of the limb's skin, relative to the scene file.
    pub skin_gltf: Option<PathBuf>,
}

/// A limb's shape, by a file relative to the scene file.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Deck or volume mesh of tetrahedra (`.inp`, `.dat`, `.cdb`, `.msh`, each also `.gz`).
    Deck(PathBuf),
    /// A surface that becomes a solid by its wall's thickness.
    Skin(SkinShape),
}

/// One side of a wall and how thick it is.
#[derive(Clone, Debug, PartialEq)]
pub struct SkinShape {
    /// The surface (`.glb`, `.gltf`, `.stl`, `.obj`, `.dae`).
    pub file: PathBuf,
    /// The wall.
    pub wall: WallThickness,
    /// Which side of it the surface is.
    pub side: WallSide,
    /// What it is solved as.
    pub solver: WallSolver,
}

/// What the wall of a skin is solved as.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum WallSolver {
    /// As that of the two from which the smaller error is expected.
    #[default]
    Auto,
    /// As triangles with rotations on the middle of the wall.
    Shell,
    /// As ten-node tetrahedra through the wall.
    Solid,
}

/// How thick a wall is.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(
    untagged,
    expecting = "expected a thickness in m, the name of a file of them, or `elsewhere_m` and `boxes`, \
                 each with `min_m`, `max_m` and `wall_m`"
)]
pub enum WallThickness {
    /// The same everywhere, m.
    Constant(f64),
    /// By a text file with a line for each vertex of the skin, m, relative to the scene file.
    File(PathBuf),
    /// By region.
    Regions(WallRegions),
}

/// A wall whose thickness differs from region to region; between them it changes along one edge.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct WallRegions {
    /// Thickness outside all boxes, m.
    pub elsewhere_m: f64,
    /// Boxes of another thickness; of several that overlap the last counts.
    pub boxes: Vec<WallBox>,
}

/// Thickness of the wall behind the skin in an axis-aligned box.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct WallBox {
    /// Lower corner, m.
    pub min_m: [f64; 3],
    /// Upper corner, m.
    pub max_m: [f64; 3],
    /// Thickness, m.
    pub wall_m: f64,
}

/// A side of a wall.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum WallSide {
    /// The outside: the wall lies inward.
    #[default]
    Outer,
    /// The middle.
    Middle,
    /// The inside: the wall lies outward.
    Inner,
}

/// A line in space.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Axis {
    /// A point on it, m.
    pub point_m: [f64; 3],
    /// Its direction, any length above 0.
    pub direction: [f64; 3],
}

impl Shape {
    /// The file, relative to the scene file.
    #[must_use]
    pub fn file(&self) -> &Path {
        match self {
            Self::Deck(file) => file,
            Self::Skin(skin) => &skin.file,
        }
    }

    /// The scene's field that names the file.
    #[must_use]
    pub fn field(&self) -> &'static str {
        match self {
            Self::Deck(_) => "geometry.solid_deck",
            Self::Skin(_) => "geometry.skin",
        }
    }
}

impl WallBox {
    /// Whether a place is in it, faces included.
    #[must_use]
    pub fn has(&self, place: &Point3<f64>) -> bool {
        (0..3).all(|i| (self.min_m[i]..=self.max_m[i]).contains(&place[i]))
    }
}

impl From<WallSide> for SkinSide {
    fn from(side: WallSide) -> Self {
        match side {
            WallSide::Outer => Self::Outer,
            WallSide::Middle => Self::Middle,
            WallSide::Inner => Self::Inner,
        }
    }
}

/// The section as it stands in the file.
#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct Fields {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    solid_deck: Option<PathBuf>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    skin: Option<PathBuf>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    wall_m: Option<WallThickness>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    side: Option<WallSide>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    solver: Option<WallSolver>,
    #[serde(with = "unit_sign")]
    unit: LengthUnit,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    axis: Option<Axis>,
    #[serde(default)]
    refinements: u32,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    skin_gltf: Option<PathBuf>,
}

/// What a geometry section can't be, in words.
#[derive(Debug, thiserror::Error)]
enum Contradiction {
    #[error("expected one of `solid_deck` and `skin`, found {found}")]
    Shape { found: &'static str },
    #[error("a skin needs `wall_m`, the thickness of its wall in metres (or a file of them)")]
    NoWall,
    #[error(
        "`wall_m`, `side` and `solver` are of a `skin`; a deck has its wall already: leave them out"
    )]
    WallOfDeck,
    #[error("`unit`: a deck's is m or mm, found {0}")]
    DeckUnit(LengthUnit),
}

impl TryFrom<Fields> for Geometry {
    type Error = Contradiction;

    fn try_from(fields: Fields) -> Result<Self, Contradiction> {
        let Fields { solid_deck, skin, wall_m, side, solver, .. } = fields;
        let Fields { unit, axis, refinements, skin_gltf, .. } = fields;
        let shape = match (solid_deck, skin) {
            (Some(_), Some(_)) => return Err(Contradiction::Shape { found: "both" }),
            (None, None) => return Err(Contradiction::Shape { found: "neither" }),
            (Some(_), None) if wall_m.is_some() || side.is_some() || solver.is_some() => {
                return Err(Contradiction::WallOfDeck);
            }
            (Some(_), None) if !matches!(unit, LengthUnit::Metre | LengthUnit::Millimetre) => {
                return Err(Contradiction::DeckUnit(unit));
            }
            (Some(deck), None) => Shape::Deck(deck),
            (None, Some(file)) => {
                let wall = wall_m.ok_or(Contradiction::NoWall)?;
                let (side, solver) = (side.unwrap_or_default(), solver.unwrap_or_default());
                Shape::Skin(SkinShape { file, wall, side, solver })
            }
        };
        Ok(Self { shape, unit, axis, refinements, skin_gltf })
    }
}

impl From<Geometry> for Fields {
    fn from(geometry: Geometry) -> Self {
        let Geometry { shape, unit, axis, refinements, skin_gltf } = geometry;
        let (solid_deck, skin) = match shape {
            Shape::Deck(deck) => (Some(deck), None),
            Shape::Skin(skin) => (None, Some(skin)),
        };
        let (skin, wall_m, side, solver) = match skin {
            Some(SkinShape { file, wall, side, solver }) => {
                (Some(file), Some(wall), Some(side), Some(solver))
            }
            None => (None, None, None, None),
        };
        Self { solid_deck, skin, wall_m, side, solver, unit, axis, refinements, skin_gltf }
    }
}

/// Units of length by their signs.
mod unit_sign {
    use hapdef_mesh::LengthUnit;
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serializer};

    #[expect(clippy::trivially_copy_pass_by_ref, reason = "serde calls it so")]
    pub(super) fn serialize<S: Serializer>(unit: &LengthUnit, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(unit.symbol())
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<LengthUnit, D::Error> {
        let sign = String::deserialize(from)?;
        let unit = LengthUnit::ALL.into_iter().find(|unit| unit.symbol() == sign);
        unit.ok_or_else(|| D::Error::unknown_variant(&sign, &["m", "mm", "cm", "in"]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn refused(text: &str, expected: &str) {
        let error = serde_json::from_str::<Geometry>(text).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }

    #[test]
    fn one_kind_of_shape_with_what_belongs_to_it() {
        refused(r#"{"unit": "m"}"#, "one of `solid_deck` and `skin`, found neither");
        let both = r#"{"solid_deck": "a.inp", "skin": "a.stl", "wall_m": 2e-3, "unit": "m"}"#;
        refused(both, "found both");
        refused(r#"{"skin": "a.stl", "unit": "mm"}"#, "needs `wall_m`");
        refused(r#"{"skin": "a.stl", "wall_m": [1], "unit": "mm"}"#, "a thickness in m");
        let thin = r#"{"elsewhere_m": 1e-3, "box": []}"#;
        let thin = format!(r#"{{"skin": "a.stl", "wall_m": {thin}, "unit": "mm"}}"#);
        refused(&thin, "`elsewhere_m` and `boxes`");
        refused(r#"{"solid_deck": "a.inp", "side": "outer", "unit": "m"}"#, "are of a `skin`");
        refused(r#"{"solid_deck": "a.inp", "solver": "shell", "unit": "m"}"#, "are of a `skin`");
        refused(r#"{"skin": "a", "wall_m": 1, "solver": "beam", "unit": "m"}"#, "`auto`, `shell`");
        refused(r#"{"solid_deck": "a.inp", "unit": "cm"}"#, "m or mm, found cm");
        refused(r#"{"solid_deck": "a.inp", "unit": "feet"}"#, "expected one of `m`, `mm`");
    }

    #[test]
    fn a_skin_is_written_as_it_was_read() {
        let text = r#"{"skin":"a.stl","wall_m":"wall.txt","side":"inner","solver":"shell","unit":"in","refinements":1}"#;
        let geometry: Geometry = serde_json::from_str(text).unwrap();
        assert_eq!(serde_json::to_string(&geometry).unwrap(), text);
    }
}
