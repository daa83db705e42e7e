//! A deck's own load, solved, and the results another program printed for it.

use std::path::Path;

use hapdef_mesh::{LabelledDisplacements, SolidDeck, read_deck};
use hapdef_report::ReportError;
use hapdef_sim::{ElasticModel, ElasticParams, IsotropicMaterial, MassProperties, NodalLoad};
use nalgebra::Vector3;

use crate::VerifyError;
use crate::problem::{largest, n_threads};

/// Metrics of a deck's own problem; none where they are not known or make no sense.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DeckMetrics {
    /// Largest element-stiffness coefficient, N/m.
    pub ke_max_n_m: Option<f64>,
    /// Smallest of the elements' largest coefficients, N/m; see
    /// [`hapdef_sim::StiffnessExtremes`].
    pub ke_min_n_m: Option<f64>,
    /// Mass, kg; none where the deck states no density.
    pub mass_kg: Option<f64>,
    /// Largest displacement, m; 0 where the deck has no load.
    pub largest_u_m: Option<f64>,
    /// Strain energy, J; 0 where the deck has no load.
    pub energy_j: Option<f64>,
}

/// What a deck's own problem gives.
#[derive(Clone, Debug, PartialEq)]
pub struct DeckResults {
    /// All of them but for a mass without density.
    pub metrics: DeckMetrics,
    /// Displacement per node, by the deck's node label, m.
    pub displacement_m: LabelledDisplacements,
    /// Equations solved.
    pub n_equations: usize,
}

/// ANSYS 18.2's printout of element stiffness and mass of the paper authors' skin deck, CalculiX
/// 2.20's displacement and energy of the same deck.
pub(crate) const SKIN: DeckMetrics = DeckMetrics {
    ke_max_n_m: Some(3.856521697e9),
    ke_min_n_m: Some(149_749.234),
    mass_kg: Some(0.0261236),
    largest_u_m: Some(1.224494e-3),
    energy_j: Some(1.071613e-2),
};

/// CalculiX's displacement and energy of their weight deck.
pub(crate) const WEIGHT: DeckMetrics = DeckMetrics {
    ke_max_n_m: None,
    ke_min_n_m: None,
    mass_kg: None,
    largest_u_m: Some(6.046101e-3),
    energy_j: Some(0.2653024),
};

/// Decks by the BLAKE3 hash of their file.
const KNOWN: [(&str, DeckMetrics); 2] = [
    ("9f845fc5b8d60a0c3a040a6ab19a09f3c06e82d70aeaa6d71d054051f1b07b6f", SKIN),
    ("a724a3e0ab3af7029cff097453a8bfa448991392c4cd022352f56e6c9dd7cf70", WEIGHT),
];

impl DeckResults {
    /// Solves the deck in `path`.
    pub fn of(path: &Path) -> Result<(SolidDeck, Self), VerifyError> {
        let deck = read_deck(path)?;
        let model = build(&deck, n_threads())?;
        let (u, _) = model.solve(&NodalLoad::of_deck(&deck)?)?;
        let extremes = model.stiffness_extremes();
        let density = deck.material.and_then(|material| material.density_kg_m3);
        let results = Self {
            metrics: DeckMetrics {
                ke_max_n_m: Some(extremes.largest_n_m),
                ke_min_n_m: Some(extremes.smallest_n_m),
                mass_kg: density.map(|density| MassProperties::of(&deck.mesh, density).mass_kg),
                largest_u_m: Some(largest(&u)),
                energy_j: Some(model.strain_energy_j(&u)?),
            },
            displacement_m: deck.node_labels.iter().copied().zip(u).collect(),
            n_equations: model.info().n_equations,
        };
        Ok((deck, results))
    }
}

impl DeckMetrics {
    /// What is known of the deck in `path`, by its content; nothing of a deck that was changed.
    pub fn known(path: &Path) -> Result<Self, VerifyError> {
        let bytes = std::fs::read(path).map_err(ReportError::io("reading", path))?;
        let hash = blake3::hash(&bytes).to_hex();
        let entry = KNOWN.iter().find(|(known, _)| *known == hash.as_str());
        Ok(entry.map_or_else(Self::default, |(_, metrics)| *metrics))
    }
}

/// The factored model of a deck's material and fixed nodes.
pub(crate) fn build(deck: &SolidDeck, n_threads: usize) -> Result<ElasticModel, VerifyError> {
    let stated = deck.material.ok_or_else(|| no_material("none"))?;
    // statics does not read the density
    let density = stated.density_kg_m3.unwrap_or(1.0);
    let material =
        IsotropicMaterial::new(stated.youngs_modulus_pa, stated.poissons_ratio, density)?;
    let params = ElasticParams::new(material, deck.fixed_nodes.clone());
    Ok(ElasticModel::build(&deck.mesh, &ElasticParams { n_threads, ..params })?)
}

/// A deck that states no material.
pub(crate) fn no_material(found: &str) -> VerifyError {
    VerifyError::setup("the deck", "an elastic material", found)
}

/// The largest difference of displacements to `reference` over the nodes it names, over the largest
/// displacement.
pub fn largest_difference(
    found: impl IntoIterator<Item = (u32, Vector3<f64>)>,
    reference: &[(u32, Vector3<f64>)],
) -> Result<f64, VerifyError> {
    let compared = hapdef_mesh::largest_difference(found, reference);
    compared.map(|(_, share)| share).ok_or_else(|| {
        let expected = "rows `node vx vy vz` for nodes of the deck";
        VerifyError::setup("the reference displacements", expected, "none")
    })
}
