//! The configurations from readings to contacts that are compared, and the order in which they are measured.

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::compare::frontier::EFFORTS;
use crate::compare::rig::Layout;

/// Gauges of the largest layout that greedy log-det chooses; smaller ones are its beginnings.
const MOST_GAUGES: usize = 16;

/// Presses of the largest calibration.
pub(super) const MOST_PRESSES: usize = 3000;

const MESHES: [Mesh; 3] = [Mesh::Solid, Mesh::Refined, Mesh::Shell];
const PRESSES: [usize; 6] = [0, 30, 100, 300, 1000, MOST_PRESSES];
/// Every layout.
pub(super) const LAYOUTS: [Layout; 6] = [
    Layout::Scene,
    Layout::Greedy(6),
    Layout::Greedy(8),
    Layout::Greedy(10),
    Layout::Greedy(12),
    Layout::Greedy(MOST_GAUGES),
];

/// The mesh behind the response map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Mesh {
    /// The limb's own ten-node tetrahedra.
    Solid,
    /// Each of them cut into eight.
    Refined,
    /// Triangles of a shell of its skin.
    Shell,
}

impl Mesh {
    /// Refinements of the limb's own; none for a shell.
    pub(super) fn refinements(self) -> Option<u32> {
        match self {
            Self::Solid => Some(0),
            Self::Refined => Some(1),
            Self::Shell => None,
        }
    }
}

/// What of a frame is known before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Knows {
    /// Nothing: every frame is searched.
    Nothing,
    /// The frames before it: contacts are followed.
    Before,
}

/// A configuration by superposition.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Configuration {
    pub(super) mesh: Mesh,
    pub(super) layout: Layout,
    pub(super) presses: usize,
    /// Index in [`EFFORTS`].
    pub(super) effort: usize,
    pub(super) knows: Knows,
}

impl Configuration {
    /// The one that every other differs from, and whose time all others are measured beside.
    pub(super) const USUAL: Self = Self {
        mesh: Mesh::Refined,
        layout: Layout::Scene,
        presses: 300,
        effort: 3,
        knows: Knows::Nothing,
    };

    pub(super) fn name(&self) -> String {
        let [configuration, mesh, gauges, presses] = self.words();
        format!("{configuration}, {mesh} mesh, {gauges} gauges, {presses} presses")
    }

    /// Search, mesh, gauges, presses.
    pub(super) fn words(&self) -> [String; 4] {
        let configuration = match self.knows {
            Knows::Nothing => format!("search: {}", EFFORTS[self.effort].name),
            Knows::Before => "followed".to_owned(),
        };
        let mesh = match self.mesh {
            Mesh::Solid => "own",
            Mesh::Refined => "refined",
            Mesh::Shell => "shell",
        };
        let gauges = match self.layout {
            Layout::Scene => "the scene's".to_owned(),
            Layout::Greedy(n) => n.to_string(),
        };
        [configuration, mesh.to_owned(), gauges, self.presses.to_string()]
    }

    /// Configurations that differ from the usual one in one thing, then all others in an order drawn from
    /// `seed`: whenever the time is over, what was measured is spread over all of them.
    pub(super) fn in_order(seed: u64) -> Vec<Self> {
        let usual = Self::USUAL;
        let followed = Self { knows: Knows::Before, ..usual };
        let mut first = vec![usual, followed];
        first.extend((0..EFFORTS.len()).map(|effort| Self { effort, ..usual }));
        first.extend(PRESSES.map(|presses| Self { presses, ..usual }));
        first.extend(LAYOUTS.map(|layout| Self { layout, ..usual }));
        first.extend(MESHES.map(|mesh| Self { mesh, ..usual }));
        let mut rest = Self::all();
        rest.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
        let mut configurations: Vec<Self> = Vec::new();
        for configuration in first.into_iter().chain(rest) {
            if !configurations.contains(&configuration) {
                configurations.push(configuration);
            }
        }
        configurations
    }

    fn all() -> Vec<Self> {
        let mut all = Vec::new();
        for mesh in MESHES {
            for layout in LAYOUTS {
                for presses in PRESSES {
                    let of_effort =
                        |effort| Self { mesh, layout, presses, effort, knows: Knows::Nothing };
                    all.extend((0..EFFORTS.len()).map(of_effort));
                    all.push(Self { knows: Knows::Before, ..of_effort(Self::USUAL.effort) });
                }
            }
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_way_comes_once_and_single_changes_come_first() {
        let configurations = Configuration::in_order(1);
        assert_eq!(configurations[0], Configuration::USUAL);
        assert_eq!(configurations[1].knows, Knows::Before);
        assert_eq!(
            configurations.len(),
            MESHES.len() * LAYOUTS.len() * PRESSES.len() * (EFFORTS.len() + 1)
        );
        let changes = |w: &Configuration| {
            usize::from(w.mesh != Configuration::USUAL.mesh)
                + usize::from(w.layout != Configuration::USUAL.layout)
                + usize::from(w.presses != Configuration::USUAL.presses)
                + usize::from(w.effort != Configuration::USUAL.effort)
                + usize::from(w.knows != Configuration::USUAL.knows)
        };
        let n_first = configurations.iter().filter(|w| changes(w) <= 1).count();
        assert!(configurations[..n_first].iter().all(|w| changes(w) <= 1));
        assert_eq!(configurations, Configuration::in_order(1));
        assert_ne!(configurations, Configuration::in_order(2));
    }
}
