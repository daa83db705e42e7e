//! A deck's own load, solved, and the results another program printed for it.

use std::io::Read;
use std::path::Path;

use hapdef_mesh::{SolidDeck, read_deck};
use hapdef_sim::{ElasticModel, ElasticParams, IsotropicMaterial, MassProperties, NodalLoad};
use nalgebra::Vector3;

use crate::VerifyError;

/// What a deck's own problem gives.
#[derive(Clone, Debug, PartialEq)]
pub struct DeckResults {
    /// Largest element-stiffness coefficient, N/m.
    pub ke_max_n_m: f64,
    /// Smallest of the elements' largest coefficients, N/m; see
    /// [`hapdef_sim::StiffnessExtremes`].
    pub ke_min_n_m: f64,
    /// Mass, kg; none where the deck states no density.
    pub mass_kg: Option<f64>,
    /// Largest displacement, m; 0 where the deck has no load.
    pub largest_u_m: f64,
    /// Strain energy, J; 0 where the deck has no load.
    pub energy_j: f64,
    /// Displacement per node, by the deck's node label, m.
    pub displacement_m: Vec<(u32, Vector3<f64>)>,
    /// Equations solved.
    pub n_equations: usize,
}

/// Figures another program printed for a deck; none where it printed none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct KnownResults {
    /// Largest element-stiffness coefficient, N/m.
    pub ke_max_n_m: Option<f64>,
    /// Smallest element-stiffness coefficient, N/m.
    pub ke_min_n_m: Option<f64>,
    /// Mass, kg.
    pub mass_kg: Option<f64>,
    /// Largest displacement, m.
    pub largest_u_m: Option<f64>,
    /// Strain energy, J.
    pub energy_j: Option<f64>,
}

const SKIN_HASH: &str = "9f845fc5b8d60a0c3a040a6ab19a09f3c06e82d70aeaa6d71d054051f1b07b6f";
const WEIGHT_HASH: &str = "a724a3e0ab3af7029cff097453a8bfa448991392c4cd022352f56e6c9dd7cf70";

/// The decks of the paper's authors, by the BLAKE3 hash of their file.
///
/// ANSYS 18.2's printout of element stiffness and mass, CalculiX 2.20's displacement and energy of
/// the same decks.
const KNOWN: [(&str, KnownResults); 2] = [
    (
        SKIN_HASH,
        KnownResults {
            ke_max_n_m: Some(3.856521697e9),
            ke_min_n_m: Some(149_749.234),
            mass_kg: Some(0.0261236),
            largest_u_m: Some(1.224494e-3),
            energy_j: Some(1.071613e-2),
        },
    ),
    (
        WEIGHT_HASH,
        KnownResults {
            ke_max_n_m: None,
            ke_min_n_m: None,
            mass_kg: None,
            largest_u_m: Some(6.046101e-3),
            energy_j: Some(0.2653024),
        },
    ),
];

impl DeckResults {
    /// Solves the deck in `path`.
    ///
    /// # Errors
    /// [`VerifyError::Mesh`] and [`VerifyError::Sim`] on an unusable deck, [`VerifyError::Setup`]
    /// on one without material.
    pub fn of(path: &Path) -> Result<(SolidDeck, Self), VerifyError> {
        let deck = read_deck(path)?;
        let results = Self::of_deck(&deck)?;
        Ok((deck, results))
    }

    fn of_deck(deck: &SolidDeck) -> Result<Self, VerifyError> {
        let stated = deck.material.as_ref().ok_or_else(|| VerifyError::Setup {
            what: "the deck",
            expected: "an elastic material".to_owned(),
            found: "none".to_owned(),
        })?;
        let density = stated.density_kg_m3;
        // statics does not read the density
        let material = IsotropicMaterial::new(
            stated.youngs_modulus_pa,
            stated.poissons_ratio,
            density.unwrap_or(1.0),
        )?;
        let params = ElasticParams {
            n_threads: std::thread::available_parallelism().map_or(1, usize::from),
            ..ElasticParams::new(material, deck.fixed_nodes.clone())
        };
        let model = ElasticModel::build(&deck.mesh, &params)?;
        let (u, _) = model.solve(&own_load(deck)?)?;
        let extremes = model.stiffness_extremes();
        Ok(Self {
            ke_max_n_m: extremes.largest_n_m,
            ke_min_n_m: extremes.smallest_n_m,
            mass_kg: density.map(|density| MassProperties::of(&deck.mesh, density).mass_kg),
            largest_u_m: largest(&u),
            energy_j: model.strain_energy_j(&u)?,
            displacement_m: deck.node_labels.iter().copied().zip(u).collect(),
            n_equations: model.info().n_equations,
        })
    }

    /// The largest difference to `reference` over the nodes it names, over the largest displacement.
    ///
    /// # Errors
    /// [`VerifyError::Setup`] if no node is shared.
    pub fn difference(&self, reference: &[(u32, Vector3<f64>)]) -> Result<f64, VerifyError> {
        let mut worst: Option<f64> = None;
        for (label, u) in &self.displacement_m {
            if let Ok(place) = reference.binary_search_by_key(label, |entry| entry.0) {
                let apart = (u - reference[place].1).norm();
                worst = Some(worst.map_or(apart, |worst| worst.max(apart)));
            }
        }
        let worst = worst.ok_or_else(|| VerifyError::Setup {
            what: "the reference displacements",
            expected: "rows `node vx vy vz` for nodes of the deck".to_owned(),
            found: "none".to_owned(),
        })?;
        Ok(worst / self.largest_u_m)
    }
}

impl KnownResults {
    /// What is known of the deck in `path`, by its content; nothing of a deck that was changed.
    ///
    /// # Errors
    /// [`VerifyError::Io`].
    pub fn of(path: &Path) -> Result<Self, VerifyError> {
        let bytes = std::fs::read(path).map_err(|cause| VerifyError::Io {
            action: "reading",
            path: path.to_owned(),
            cause,
        })?;
        let hash = blake3::hash(&bytes).to_hex();
        let entry = KNOWN.iter().find(|(known, _)| *known == hash.as_str());
        Ok(entry.map_or_else(Self::default, |(_, results)| *results))
    }
}

/// Point forces and tractions of the deck.
pub(crate) fn own_load(deck: &SolidDeck) -> Result<NodalLoad, VerifyError> {
    let forces = NodalLoad { forces_n: deck.nodal_forces.clone(), ..NodalLoad::default() };
    Ok(forces.plus(&NodalLoad::traction(&deck.mesh, &deck.face_tractions)?))
}

/// The largest norm.
pub(crate) fn largest(displacement: &[Vector3<f64>]) -> f64 {
    displacement.iter().map(Vector3::norm).fold(0.0, f64::max)
}

/// Rows `node vx vy vz` of the first displacement block of a CalculiX `.dat`, plain or gzipped, by
/// rising node, m.
///
/// # Errors
/// [`VerifyError::Io`].
pub fn read_displacements(path: &Path) -> Result<Vec<(u32, Vector3<f64>)>, VerifyError> {
    let io = |cause| VerifyError::Io { action: "reading", path: path.to_owned(), cause };
    let bytes = std::fs::read(path).map_err(io)?;
    let mut text = String::new();
    if bytes.starts_with(&[0x1f, 0x8b]) {
        let mut decoder = flate2::read::GzDecoder::new(bytes.as_slice());
        decoder.read_to_string(&mut text).map_err(io)?;
    } else {
        text = String::from_utf8_lossy(&bytes).into_owned();
    }
    Ok(displacement_rows(&text))
}

fn displacement_rows(text: &str) -> Vec<(u32, Vector3<f64>)> {
    let row = |line: &str| {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [label, x, y, z] = words.as_slice() else {
            return None;
        };
        let number = |word: &str| word.parse::<f64>().ok();
        Some((label.parse().ok()?, Vector3::new(number(x)?, number(y)?, number(z)?)))
    };
    // a later block, such as forces, starts with a heading after rows have been read
    let mut rows: Vec<(u32, Vector3<f64>)> = Vec::new();
    for line in text.lines().filter(|line| !line.trim().is_empty()) {
        match row(line) {
            Some(found) => rows.push(found),
            None if rows.is_empty() => {}
            None => break,
        }
    }
    rows.sort_unstable_by_key(|entry| entry.0);
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_first_block_is_read() {
        let text = "\n S T E P 1\n\n displacements (vx,vy,vz) for set N and time 0.1E+01\n\n \
            2  1.0E-03 0.0E+00 2.0E-03\n 1  0.0E+00 0.0E+00 5.0E-01\n\n forces (fx,fy,fz)\n\n 1 9 9 9\n";
        let rows = displacement_rows(text);
        assert_eq!(rows.len(), 2);
        assert_eq!(rows[0], (1, Vector3::new(0.0, 0.0, 0.5)));
        assert_eq!(rows[1], (2, Vector3::new(1e-3, 0.0, 2e-3)));
    }
}
