//! The solid partner of a shell: the same skin and wall as ten-node tetrahedra.

use hapdef_mesh::{
    ExtrudeParams, Extrusion, FaceCurve, FeNodeId, SkinRegion, SurfaceMesh, TET10_EDGES, Tri6Face,
    extrude,
};
use hapdef_sim::{GaugeParams, GaugeSite, GaugeStrain};

use super::ShellLimb;
use super::compare::ShellComparison;
use super::press::{Comparison, Solid};
use super::sites::on_wall;
use crate::error::HapdefError;

/// Thicker than this part of the edge length, a wall gets two layers of wedges.
const THIN: f64 = 0.5;

impl ShellLimb {
    /// Presses the shell and the solid extruded from the same skin, with flat faces as the shell's
    /// but edges halved as often as the params say, held and read at the same places.
    ///
    /// # Errors
    /// [`HapdefError::Mesh`] where the wall folds; [`HapdefError::NothingToPress`];
    /// [`HapdefError::Sim`].
    pub fn against_extruded(&self) -> Result<ShellComparison, HapdefError> {
        let finest = self.params.n_solid_halvings;
        let coarser = finest.checked_sub(1);
        let walls = coarser.into_iter().chain([finest]);
        let walls: Vec<ExtrudedWall> = walls
            .map(|n_halvings| self.extruded(n_halvings))
            .collect::<Result<_, _>>()?;
        let carried: Vec<usize> = (0..self.gauges.len())
            .filter(|&g| walls.iter().all(|wall| wall.gauges[g].is_some()))
            .collect();
        let Some(outer) = walls.last().map(|wall| &wall.extrusion) else {
            return Err(HapdefError::NothingToPress { n_places: 0 });
        };
        let outside = |v: usize| outer.mesh.position(outer.node(v as u32, 0));
        let nodes = self.mesh.nodes().iter().enumerate();
        let layers = match outer.n_layers {
            1 => "1 layer".to_owned(),
            n => format!("{n} layers"),
        };
        let edge_mm = 1e3 * self.info.wall.target_edge_m / f64::from(1_u32 << finest.min(31));
        self.compare(&Comparison {
            name: format!("its extruded solid ({layers}, edges of {edge_mm:.2} mm)"),
            solids: walls.iter().map(|wall| wall.solid(&carried)).collect(),
            n_gauges_left_out: self.gauges.len() - carried.len(),
            gauges: carried.iter().map(|&g| self.gauges[g].clone()).collect(),
            places: nodes.map(|(v, middle)| [outside(v), *middle]).collect(),
            directions: self.normals.iter().map(|n| -n).collect(),
            picture: self.skin.clone(),
        })
    }

    /// The wall of the skin with its edges halved `n_halvings` times; old vertices keep their
    /// numbers.
    fn extruded(&self, n_halvings: usize) -> Result<ExtrudedWall, HapdefError> {
        let mut skin = self.skin.clone();
        let mut thickness_m = self.mesh.thickness_m().to_vec();
        let mut held = vec![false; thickness_m.len()];
        for vertex in &self.clamped {
            held[vertex.index()] = true;
        }
        for _ in 0..n_halvings {
            let fine = skin.refined(&FaceCurve::Flat)?;
            for [a, b] in fine.halved_edges.iter().map(|e| e.map(|v| v as usize)) {
                thickness_m.push(0.5 * (thickness_m[a] + thickness_m[b]));
                held.push(held[a] && held[b]);
            }
            skin = fine.mesh;
        }
        let edge_m = self.info.wall.target_edge_m * 0.5_f64.powi(n_halvings as i32);
        self.wall(&skin, &thickness_m, &held, edge_m)
    }

    fn wall(
        &self,
        skin: &SurfaceMesh,
        thickness_m: &[f64],
        held: &[bool],
        edge_m: f64,
    ) -> Result<ExtrudedWall, HapdefError> {
        let thickest_m = thickness_m.iter().copied().fold(0.0, f64::max);
        let params = ExtrudeParams {
            side: self.side,
            n_layers: 1 + usize::from(thickest_m > THIN * edge_m),
            curve: FaceCurve::Flat,
        };
        let extrusion = extrude(skin, thickness_m, &params)?;
        let outer = SkinRegion::new(&extrusion.mesh, level_faces(&extrusion, 0))?;
        let inside = level_faces(&extrusion, extrusion.n_layers);
        let places = self.gauges.iter().zip(&self.sites).map(|(gauge, site)| {
            let axis = gauge.axis();
            let site = GaugeSite { axis, ..*site };
            let params = GaugeParams::default();
            on_wall(GaugeStrain::with_params(
                &extrusion.mesh,
                &inside,
                &site,
                &params,
            ))
        });
        Ok(ExtrudedWall {
            gauges: places.collect::<Result<_, _>>()?,
            clamped: clamped_columns(&extrusion, held),
            outer,
            extrusion,
        })
    }
}

/// A solid with what is on it; gauges that don't lie on its inside are missing.
struct ExtrudedWall {
    extrusion: Extrusion,
    outer: SkinRegion,
    clamped: Vec<FeNodeId>,
    gauges: Vec<Option<GaugeStrain>>,
}

impl ExtrudedWall {
    fn solid(&self, carried: &[usize]) -> Solid<'_> {
        Solid {
            mesh: &self.extrusion.mesh,
            skin: &self.outer,
            clamped: self.clamped.clone(),
            gauges: carried
                .iter()
                .filter_map(|&g| self.gauges[g].clone())
                .collect(),
        }
    }
}

/// Boundary faces of the wall whose corners are all on one level.
fn level_faces(wall: &Extrusion, level: usize) -> Vec<Tri6Face> {
    let is_level = |node: &FeNodeId| node.index() % (wall.n_layers + 1) == level;
    let faces = wall.mesh.boundary().faces.into_iter();
    faces
        .filter(|face| face.nodes[..3].iter().all(is_level))
        .collect()
}

/// All nodes of the columns under held vertices: corners, and middles between them.
fn clamped_columns(wall: &Extrusion, held: &[bool]) -> Vec<FeNodeId> {
    let n_levels = wall.n_layers + 1;
    let mut is_clamped = vec![false; wall.mesh.nodes().len()];
    for (vertex, _) in held.iter().enumerate().filter(|(_, held)| **held) {
        is_clamped[vertex * n_levels..(vertex + 1) * n_levels].fill(true);
    }
    for element in wall.mesh.elements() {
        for (edge, [a, b]) in TET10_EDGES.into_iter().enumerate() {
            if is_clamped[element[a].index()] && is_clamped[element[b].index()] {
                is_clamped[element[4 + edge].index()] = true;
            }
        }
    }
    let nodes = (0..is_clamped.len()).filter(|&i| is_clamped[i]);
    nodes.map(FeNodeId::from_index).collect()
}
