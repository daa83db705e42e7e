//! What a file holds of a limb, in metres.

use std::path::{Path, PathBuf};

use hapdef_mesh::{
    DeckParams, DeckReading, GltfParams, LengthUnit, SolidDeck, SurfaceMesh, UnitGuess,
    read_deck_with, read_surface,
};
use nalgebra::{Point3, Vector3};

use super::collada::Asset;
use super::urdf::{self, Joints};
use super::{Guess, NewLimbParams};
use crate::error::HapdefError;

/// A limb as it is given.
#[derive(Clone, Debug)]
pub(super) struct Given {
    pub(super) path: PathBuf,
    pub(super) shape: GivenShape,
    /// Where a URDF joins it to others.
    pub(super) joints: Option<Joints>,
}

/// A surface or a solid.
#[derive(Clone, Debug)]
pub(super) enum GivenShape {
    /// A surface in metres, whatever its state.
    Surface(SurfaceMesh),
    /// A deck as it stands, and the unit of its lengths.
    Deck(Box<SolidDeck>, LengthUnit),
}

impl Given {
    /// The triangles of the surface, or the corners of the solid's boundary faces, m.
    pub(super) fn triangles(&self) -> Vec<[Point3<f64>; 3]> {
        match &self.shape {
            GivenShape::Surface(mesh) => {
                (0..mesh.triangles().len()).map(|t| mesh.corners(t)).collect()
            }
            GivenShape::Deck(deck, unit) => {
                // a deck that states its unit was read in it
                let scale = if deck.unit.is_some() { 1.0 } else { unit.metres() };
                let place = |node| deck.mesh.position(node) * scale;
                let faces = deck.mesh.boundary().faces;
                faces.iter().map(|face| [0, 1, 2].map(|i| place(face.nodes[i]))).collect()
            }
        }
    }

    pub(super) fn is_deck(&self) -> bool {
        matches!(self.shape, GivenShape::Deck(..))
    }
}

/// Reads a surface, a deck or a link of a URDF, and says its unit.
pub(super) fn read(
    path: &Path,
    params: &NewLimbParams,
    guesses: &mut Vec<Guess>,
) -> Result<Given, HapdefError> {
    let (shape, joints) = match ending(path).as_str() {
        "urdf" => {
            let link = urdf::read(path, params.link.as_deref())?;
            let asset = link.asset.as_ref();
            let of_mesh = asset.map(|asset| format!("; of its mesh {}", asset.unit_in_words()));
            let why = format!("a URDF's lengths; {}{}", link.said, of_mesh.unwrap_or_default());
            guesses.push(Guess { what: "unit", value: "m".into(), why });
            guesses.extend(asset.and_then(Asset::up_axis));
            (GivenShape::Surface(link.mesh), Some(link.joints))
        }
        "inp" | "dat" | "cdb" | "msh" => (deck(path, params, guesses)?, None),
        "glb" | "gltf" | "stl" | "obj" | "dae" => (surface(path, params, guesses)?, None),
        found => {
            let what = format!(
                "expected .glb, .gltf, .stl, .obj, .dae, .inp, .dat, .cdb, .msh or .urdf, found {found:?}"
            );
            return Err(HapdefError::NewLimb { path: path.into(), what });
        }
    };
    Ok(Given { path: path.to_owned(), shape, joints })
}

fn surface(
    path: &Path,
    params: &NewLimbParams,
    guesses: &mut Vec<Guess>,
) -> Result<GivenShape, HapdefError> {
    let mesh = read_surface(path, &GltfParams::default())?.mesh;
    let longest = mesh.bounding_box().longest_m();
    let asset = (ending(path) == "dae").then(|| Asset::read(path)).transpose()?;
    let (unit, why) = match (params.unit, &asset) {
        (Some(unit), None) => (unit, "as stated".into()),
        (Some(unit), Some(asset)) => {
            (unit, format!("as stated, on top of its own: {}", asset.unit_in_words()))
        }
        (None, Some(asset)) => (LengthUnit::Metre, asset.unit_in_words()),
        (None, None) => likely_unit(longest, &LengthUnit::ALL, params)?,
    };
    guesses.push(Guess { what: "unit", value: unit.to_string(), why });
    guesses.extend(asset.and_then(|asset| asset.up_axis()));
    Ok(GivenShape::Surface(mesh.scaled(unit.metres())?))
}

fn deck(
    path: &Path,
    params: &NewLimbParams,
    guesses: &mut Vec<Guess>,
) -> Result<GivenShape, HapdefError> {
    let read = |reading| read_deck_with(path, &DeckParams { reading, ..DeckParams::default() });
    // supports that a scene can't use are no reason to refuse the mesh
    let deck = read(DeckReading::Supports).or_else(|_| read(DeckReading::Mesh))?;
    let bounds = |x: &Point3<f64>| x.coords;
    let low = deck.mesh.nodes().iter().map(bounds).reduce(|a, b| a.inf(&b)).unwrap_or_default();
    let high = deck.mesh.nodes().iter().map(bounds).reduce(|a, b| a.sup(&b)).unwrap_or_default();
    let longest = (high - low).max();
    let (unit, why) = match (params.unit, deck.unit) {
        (Some(unit), _) => (unit, "as stated".into()),
        (None, Some(unit)) => (unit, "the deck states its unit".into()),
        (None, None) => likely_unit(longest, &[LengthUnit::Metre, LengthUnit::Millimetre], params)?,
    };
    guesses.push(Guess { what: "unit", value: unit.to_string(), why });
    Ok(GivenShape::Deck(Box::new(deck), unit))
}

/// The unit among `allowed` in which `longest` is a limb's length, with the reason.
fn likely_unit(
    longest: f64,
    allowed: &[LengthUnit],
    params: &NewLimbParams,
) -> Result<(LengthUnit, String), HapdefError> {
    let guess = UnitGuess::of_length(longest);
    let fits: Vec<LengthUnit> =
        guess.candidates.iter().copied().filter(|unit| allowed.contains(unit)).collect();
    let long = |unit: LengthUnit| format!("{:.0} mm", longest * unit.metres() * 1e3);
    match fits[..] {
        [unit] => Ok((unit, format!("{} long; in another unit no limb's length", long(unit)))),
        [unit, ..] if params.takes_likeliest => {
            Ok((unit, format!("{} long; {} fits, too, but is rarer", long(unit), fits[1])))
        }
        _ => Err(HapdefError::Unsure {
            what: "the unit of the file's lengths",
            why: guess.to_string(),
            flag: "--unit",
            choices: match fits[..] {
                [] => allowed.iter().map(ToString::to_string).collect(),
                _ => fits.iter().map(ToString::to_string).collect(),
            },
        }),
    }
}

/// Edges of a box around points, m.
pub(super) fn size_m(triangles: &[[Point3<f64>; 3]]) -> Vector3<f64> {
    let points = || triangles.iter().flatten().map(|x| x.coords);
    let low = points().reduce(|a, b| a.inf(&b)).unwrap_or_default();
    let high = points().reduce(|a, b| a.sup(&b)).unwrap_or_default();
    high - low
}

/// The ending of a file's name in lower case, that before `.gz`.
pub(super) fn ending(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let name = name.strip_suffix(".gz").unwrap_or(&name);
    name.rsplit_once('.').map_or_else(String::new, |(_, ending)| ending.to_owned())
}
