//! A limb's response solved on a finer mesh than its own, and given on its own skin.

use hapdef_inverse::{ResponseMap, ResponseParams, Skin, SkinFaces, SkinParams};
use hapdef_mesh::{FeNodeId, HeldSolid};
use hapdef_sim::{ElasticModel, ElasticParams, GaugeParams, GaugeSite, GaugeStrain, Supports};
use nalgebra::Vector3;
use rstar::RTree;
use rstar::primitives::GeomWithData;

use super::response::{node_values, touchable_skin};
use crate::error::HapdefError;
use crate::limb::Limb;

/// A limb's solid refined, its drawing unchanged.
pub(super) struct FineLimb<'a> {
    limb: &'a Limb,
    solid: HeldSolid,
}

impl<'a> FineLimb<'a> {
    /// Cuts every element into eight, `times` over.
    ///
    /// # Errors
    /// [`HapdefError::Mesh`] when parts turn inside out.
    pub(super) fn new(limb: &'a Limb, times: u32) -> Result<Self, HapdefError> {
        let solid = (0..times).try_fold(limb.held_solid(), |solid, _| solid.refined())?;
        Ok(Self { limb, solid })
    }

    /// The map of gauges at `sites` on the subdivided faces of the limb's own skin: the tip is averaged over the finer one. A gauge
    /// that fits the limb's own wall is read here where it lies on the finer one.
    ///
    /// # Errors
    /// [`HapdefError::Sim`] when a gauge finds no place or the mesh can't be solved.
    pub(super) fn map(
        &self,
        sites: &[GaugeSite],
        tip_radius_m: f64,
        n_threads: usize,
    ) -> Result<ResponseMap, HapdefError> {
        let faces = self.solid.mesh.boundary().faces;
        let anywhere = GaugeParams { max_lost_share: 1.0, ..self.limb.gauge_params };
        let place = |site| GaugeStrain::with_params(&self.solid.mesh, &faces, site, &anywhere);
        let gauges: Vec<GaugeStrain> = sites.iter().map(place).collect::<Result<_, _>>()?;
        let elastic = ElasticParams {
            supports: Supports::of_rigid_body(&self.solid.flange),
            n_threads,
            ..ElasticParams::new(self.limb.material, self.solid.clamped.clone())
        };
        let (response, _) = ElasticModel::build(&self.solid.mesh, &elastic)?.response(&gauges)?;
        let under_point = node_values(&self.solid.skin.nodes, &response);
        let tip = ResponseParams { tip_radius_m };
        let under_tip =
            ResponseMap::from_nodal(self.as_skin()?, gauges.len(), &under_point, &tip)?.nodal();
        let skin = touchable_skin(self.limb)?;
        let own = self.rows_at(&skin, &under_tip, gauges.len());
        Ok(ResponseMap::from_subdivided(skin, gauges.len(), &own)?)
    }

    fn as_skin(&self) -> Result<Skin, HapdefError> {
        let place = |node| self.solid.skin.nodes.partition_point(|other| *other < node) as u32;
        let faces: Vec<[u32; 6]> =
            self.solid.skin.faces.iter().map(|f| f.nodes.map(place)).collect();
        let nodes = self.solid.skin.nodes.iter();
        Ok(Skin::new(
            nodes.map(|node| self.solid.mesh.position(*node)).collect(),
            SkinFaces::Quadratic(&faces),
            Some(&self.solid.skin.normals),
            &SkinParams::default(),
        )?)
    }

    /// The rows of the finer skin's nodes at the subdivided faces' points of the limb's own skin, which are nodes of
    /// every refined one.
    fn rows_at(&self, skin: &Skin, rows: &[Vector3<f64>], n_gauges: usize) -> Vec<Vector3<f64>> {
        let position = |node: &FeNodeId| self.solid.mesh.position(*node).coords.into();
        let nodes = self.solid.skin.nodes.iter().enumerate();
        let nodes = nodes.map(|(i, node)| GeomWithData::new(position(node), i));
        let nodes: RTree<GeomWithData<[f64; 3], usize>> = RTree::bulk_load(nodes.collect());
        let points = skin.subdivided_points();
        let mut found = Vec::with_capacity(points.len() * n_gauges);
        for point in points {
            let nearest = nodes.nearest_neighbor(skin.position(&point).coords.into());
            let row = nearest.map_or(0, |node| node.data);
            found.extend_from_slice(&rows[row * n_gauges..][..n_gauges]);
        }
        found
    }
}
