//! A limb of our own in the likeness of the HapDefX shin: a ribbed, perforated barrel.
//!
//! Sun and Martius (Frontiers in Neurorobotics 13:51, 2019) use a shell of about 1 mm with ribs,
//! rings and many holes, 72 mm across and 122 mm high, printed in PA2200. This generator makes such
//! a limb from a few numbers, so that everything can be tried without their geometry.

mod grid;
mod lines;
mod outline;
mod panel;
mod rim;
mod solid;

use std::collections::BTreeMap;

pub use outline::ShinOutline;
pub use panel::ShinHole;

use crate::{DeckMaterial, MeshError, SkinRegion, SolidDeck};

/// The measures of the limb. The y axis is the limb's axis.
#[derive(Clone, Debug, PartialEq)]
pub struct ShinParams {
    /// The outer surface.
    pub outline: ShinOutline,
    /// Thickness of the wall, m.
    pub wall_m: f64,
    /// How far ribs and end rings stand in from the wall, m.
    pub rib_depth_m: f64,
    /// Layers of elements below the wall in ribs and end rings; the wall itself has one.
    pub n_rib_layers: usize,
    /// Width of the ribs, m.
    pub rib_width_m: f64,
    /// Height of the thick rings at both ends, m.
    pub end_ring_m: f64,
    /// Axial ribs, and as many sectors between them.
    pub n_sectors: usize,
    /// Bands between ring ribs, of which there is one less.
    pub n_bands: usize,
    /// Cells across a panel (the wall between two axial and two ring ribs): around, along.
    pub panel_cells: (usize, usize),
    /// Cuts cells along their other diagonals where the shape leaves a choice.
    pub other_diagonals: bool,
    /// How much sectors and bands differ in size, relative; breaks the symmetry.
    pub unevenness: f64,
    /// The holes.
    pub holes: Vec<ShinHole>,
    /// What the limb is made of.
    pub material: DeckMaterial,
}

impl ShinParams {
    /// The same limb in a mesh of its own, of other divisions and diagonals: what the simulated rig is
    /// solved on.
    #[must_use]
    pub fn meshed_anew() -> Self {
        Self { panel_cells: (8, 8), other_diagonals: true, ..Self::default() }
    }
}

impl Default for ShinParams {
    /// The limb in `fixtures/shin`: PA2200 as in the authors' deck (E = 1.7 GPa, ν = 0.394,
    /// ρ = 930 kg/m³).
    fn default() -> Self {
        Self {
            outline: ShinOutline::default(),
            wall_m: 1.0e-3,
            rib_depth_m: 3.6e-3,
            n_rib_layers: 3,
            rib_width_m: 2.0e-3,
            end_ring_m: 6.0e-3,
            n_sectors: 7,
            n_bands: 3,
            panel_cells: panel::PANEL_CELLS,
            other_diagonals: false,
            unevenness: 0.12,
            holes: panel::default_holes(),
            material: DeckMaterial {
                youngs_modulus_pa: 1.7e9,
                poissons_ratio: 0.394,
                density_kg_m3: Some(930.0),
            },
        }
    }
}

/// The limb as a deck, and the part of it that can be touched.
#[derive(Clone, Debug, PartialEq)]
pub struct Shin {
    /// Mesh, material, the node sets `MOUNT` (the lower end's inner land, clamped) and `SKIN`
    /// (the nodes of [`Self::skin`]).
    pub deck: SolidDeck,
    /// The outer surface between the end rings, without the rims of holes.
    pub skin: SkinRegion,
}

/// Builds the limb.
///
/// A grid of cells in angle, height and depth, wrapped around the axis: wall cells except in holes,
/// deeper cells under ribs and end rings. The grid's nodes move onto the rims of the holes; each
/// cell becomes two prisms and each prism three tetrahedra, alike on both sides of every face.
/// Mid-side nodes lie on the curved outline. Coordinates are rounded to nanometres.
///
/// # Errors
/// [`MeshError::ShinParams`] if a measure is not positive or the parts don't fit;
/// [`MeshError::Solid`] if holes or unevenness distort the mesh until an element turns over.
pub fn shin(params: &ShinParams) -> Result<Shin, MeshError> {
    params.check()?;
    let grid = grid::Grid::new(params);
    let built = solid::build(params, &grid)?;
    let skin = SkinRegion::new(&built.mesh, built.skin_faces)?;
    let node_sets = BTreeMap::from([
        ("MOUNT".to_owned(), built.mount.clone()),
        ("SKIN".to_owned(), skin.nodes.clone()),
    ]);
    let deck = SolidDeck {
        node_labels: (1..).take(built.mesh.nodes().len()).collect(),
        element_labels: (1..).take(built.mesh.elements().len()).collect(),
        mesh: built.mesh,
        node_sets,
        material: Some(params.material),
        fixed_nodes: built.mount,
        nodal_forces: Vec::new(),
        face_tractions: Vec::new(),
        unused_node_labels: Vec::new(),
        unit: None,
        notes: Vec::new(),
    };
    Ok(Shin { deck, skin })
}

impl ShinParams {
    fn check(&self) -> Result<(), MeshError> {
        let refuse = |why| Err(MeshError::ShinParams { why });
        let measures = [
            self.wall_m,
            self.rib_depth_m,
            self.rib_width_m,
            self.end_ring_m,
            self.outline.height_m,
        ];
        if measures.iter().any(|m| m.is_nan() || *m <= 0.0) {
            return refuse("every length must be above 0");
        }
        if self.n_rib_layers < 1 {
            return refuse("ribs must have a layer of elements");
        }
        if self.n_sectors < 3
            || self.n_bands < 1
            || self.panel_cells.0 < 2
            || self.panel_cells.1 < 2
        {
            return refuse("there must be 3 sectors, 1 band and 2 × 2 cells a panel at least");
        }
        if !(0.0..0.5).contains(&self.unevenness) {
            return refuse("unevenness must lie in 0..0.5");
        }
        let radius_m = self.outline.least_radius_m();
        if radius_m.is_nan() || radius_m <= 0.0 || !self.outline.bottom_m.is_finite() {
            return refuse("the outline must be finite and its radius above 0 everywhere");
        }
        if self.wall_m + self.rib_depth_m >= 0.5 * radius_m {
            return refuse("wall and ribs must be thinner than half the limb's least radius");
        }
        let around_m = std::f64::consts::TAU * radius_m / self.n_sectors as f64;
        let ribs_m = 2.0 * self.end_ring_m + self.rib_width_m * (self.n_bands - 1) as f64;
        if around_m < 2.0 * self.rib_width_m || self.outline.height_m < 2.0 * ribs_m {
            return refuse("ribs and rings must leave room for the panels");
        }
        if self.holes.iter().any(|hole| hole.sector >= self.n_sectors || hole.band >= self.n_bands)
        {
            return refuse("every hole must name a sector and a band that exist");
        }
        Ok(())
    }
}
