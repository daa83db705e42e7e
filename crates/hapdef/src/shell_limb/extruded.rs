//! The solid partner of a shell: the same skin and wall as ten-node tetrahedra.

use hapdef_mesh::{
    ExtrudeParams, Extrusion, FaceCurve, FeNodeId, SkinRegion, TET10_EDGES, Tet10Mesh, Tri6Face,
    extrude, refine_unfolded,
};
use hapdef_sim::{GaugeSite, GaugeStrain};

use super::ShellLimb;
use super::compare::ShellComparison;
use super::press::{Comparison, Solid};
use super::sites::on_wall;
use crate::error::HapdefError;
use crate::skin_solid::level_faces;

/// Walls thicker than an edge get two layers of wedges.
const MAX_LAYER_PER_EDGE: f64 = 1.0;

/// Where the number of halvings is free: one, if it makes no more nodes than this.
const MAX_FE_NODES: usize = 150_000;

/// Nodes after halving all edges over nodes before, at most.
const GROWTH: usize = 7;

impl ShellLimb {
    /// Presses the shell and the solid extruded from the same skin, with flat faces as the shell's
    /// but edges halved as often as the params say, held and read at the same places.
    ///
    /// # Errors
    /// [`HapdefError::Mesh`] where the wall folds; [`HapdefError::NothingToPress`];
    /// [`HapdefError::Sim`].
    pub fn against_extruded(&self) -> Result<ShellComparison, HapdefError> {
        let thickest_m = self.mesh.thickness_m().iter().copied().fold(0.0, f64::max);
        let edge_m = self.info.wall.target_edge_m;
        let params = ExtrudeParams {
            side: self.side,
            n_layers: 1 + usize::from(thickest_m > MAX_LAYER_PER_EDGE * edge_m),
            curve: FaceCurve::Flat,
        };
        let extrusion = extrude(&self.skin, self.mesh.thickness_m(), &params)?;
        let outside = |v: usize| extrusion.mesh.position(extrusion.node(v as u32, 0));
        let nodes = self.mesh.nodes().iter().enumerate();
        let places = nodes.map(|(v, middle)| [outside(v), *middle]).collect();
        let is_small = GROWTH * extrusion.mesh.nodes().len() <= MAX_FE_NODES;
        let halvings = self.params.n_solid_halvings.unwrap_or(usize::from(is_small));
        let walls = self.walls(&extrusion, halvings)?;
        let carried: Vec<usize> = (0..self.gauges.len())
            .filter(|&g| walls.iter().all(|wall| wall.gauges[g].is_some()))
            .collect();
        let edge_mm = 1e3 * edge_m * 0.5_f64.powi(halvings as i32);
        self.compare(&Comparison {
            name: format!("its extruded solid (edges of {edge_mm:.2} mm)"),
            deck_hash: None,
            sites: carried.iter().map(|&g| self.sites[g].position).collect(),
            solids: walls.iter().map(|wall| wall.solid(&carried)).collect(),
            n_gauges_left_out: self.gauges.len() - carried.len(),
            gauges: carried.iter().map(|&g| self.gauges[g].clone()).collect(),
            places,
            directions: self.normals.iter().map(|n| -n).collect(),
            picture: self.skin.clone(),
        })
    }

    /// The wall with its edges halved `halvings` times and, before it, once less.
    fn walls(&self, extrusion: &Extrusion, halvings: usize) -> Result<Vec<Wall>, HapdefError> {
        let outer = level_faces(extrusion, 0);
        let clamped = clamped_columns(extrusion, &self.clamped);
        let mut walls = vec![Wall {
            outer: SkinRegion::new(&extrusion.mesh, outer)?,
            inner: level_faces(extrusion, extrusion.n_layers),
            mesh: extrusion.mesh.clone(),
            clamped,
            gauges: Vec::new(),
        }];
        for _ in 0..halvings {
            let finer = walls[walls.len() - 1].finer()?;
            walls.push(finer);
            walls.drain(..walls.len() - 2);
        }
        for wall in &mut walls {
            let sites = self.gauges.iter().zip(&self.sites);
            let on_solid = sites.map(|(gauge, site)| {
                let axis = gauge.axis();
                let site = GaugeSite { axis, ..*site };
                on_wall(GaugeStrain::new(&wall.mesh, &wall.inner, &site))
            });
            wall.gauges = on_solid.collect::<Result<_, _>>()?;
        }
        Ok(walls)
    }
}

/// A solid with what is on it; gauges that don't lie on its inside are missing.
struct Wall {
    mesh: Tet10Mesh,
    outer: SkinRegion,
    inner: Vec<Tri6Face>,
    clamped: Vec<FeNodeId>,
    gauges: Vec<Option<GaugeStrain>>,
}

impl Wall {
    fn finer(&self) -> Result<Self, HapdefError> {
        let refined = refine_unfolded(&self.mesh)?;
        Ok(Self {
            outer: SkinRegion::new(&refined.mesh, refined.faces(&self.outer.faces))?,
            inner: refined.faces(&self.inner),
            clamped: refined.node_set(&self.clamped),
            mesh: refined.mesh,
            gauges: Vec::new(),
        })
    }

    fn solid(&self, carried: &[usize]) -> Solid<'_> {
        let gauges = carried.iter().filter_map(|&g| self.gauges[g].clone());
        Solid {
            mesh: &self.mesh,
            skin: &self.outer,
            clamped: self.clamped.clone(),
            gauges: gauges.collect(),
        }
    }
}

/// All nodes of the columns under clamped vertices: corners, and middles between them.
fn clamped_columns(wall: &Extrusion, clamped: &[FeNodeId]) -> Vec<FeNodeId> {
    let n_levels = wall.n_layers + 1;
    let mut is_clamped = vec![false; wall.mesh.nodes().len()];
    for vertex in clamped {
        let first = vertex.index() * n_levels;
        is_clamped[first..first + n_levels].fill(true);
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
