//! A limb's response solved on a shell of its skin, and given on its own skin.

use hapdef_mesh::{
    FeNodeId, OuterSkinParams, PointIndex, ShellSurface, SkinRegion, SkinSide, outer_skin, wall,
};
use hapdef_sim::{
    ElasticModel, GaugeParams, GaugeSite, ShellGaugeStrain, ShellKind, ShellMesh, ShellMeshParams,
    ShellParams,
};
use nalgebra::Vector3;

use super::glued::Glued;
use super::response::node_values;
use crate::error::HapdefError;
use crate::limb::Limb;
use crate::shell_limb::on_wall;

/// A limb's outer skin as a shell of one thickness, without ribs and rings.
pub(super) struct SkinShell<'a> {
    limb: &'a Limb,
    mesh: ShellMesh,
    thickness_m: f64,
    model: ElasticModel,
    /// The shell's node under each surface node.
    places: Vec<FeNodeId>,
}

impl<'a> SkinShell<'a> {
    /// The shell of the median wall behind the touchable skin, of material up to `max_wall_m`
    /// thick, held where the solid's skin is held.
    ///
    /// # Errors
    /// [`HapdefError::Mesh`] where the skin has no wall behind it or the wall folds;
    /// [`HapdefError::Sim`] for a skin that the solid's mount does not touch.
    pub(super) fn new(
        limb: &'a Limb,
        max_wall_m: f64,
        n_threads: usize,
    ) -> Result<Self, HapdefError> {
        let behind = wall(&limb.mesh, &limb.boundary, &limb.skin, max_wall_m)?;
        let thickness_m = behind.thickness_quantile_m(0.5).unwrap_or(0.0);
        let outer = sides(limb)?;
        let surface = outer.surface(&limb.mesh)?;
        let all_m = vec![thickness_m; outer.nodes.len()];
        let shell = ShellSurface::from_skin(&surface, &all_m, SkinSide::Outer)?;
        let ids = |triangle: &[u32; 3]| triangle.map(|v| FeNodeId::from_index(v as usize));
        let mesh = ShellMesh::with_params(
            shell.nodes().to_vec(),
            shell.triangles().iter().map(ids).collect(),
            all_m,
            &ShellMeshParams::default(),
        )?;
        let held = (0..outer.nodes.len()).filter(|i| limb.clamped.contains(&outer.nodes[*i]));
        let params = ShellParams {
            n_threads,
            ..ShellParams::new(limb.material, held.map(FeNodeId::from_index).collect())
        };
        let index = PointIndex::new(surface.vertices());
        let points = limb.surface_points();
        let under = points.iter().filter_map(|point| index.nearest(point));
        Ok(Self {
            limb,
            thickness_m,
            places: under.map(|(node, _)| FeNodeId::from_index(node)).collect(),
            model: ElasticModel::build_shell(&mesh, &params)?,
            mesh,
        })
    }

    /// The gauge at a site on the solid's wall; nothing where that lies on no wall of the shell's,
    /// as on a rib.
    ///
    /// # Errors
    /// [`HapdefError::Sim`] for a site without a size or an axis.
    pub(super) fn gauge(&self, site: &GaugeSite) -> Result<Option<ShellGaugeStrain>, HapdefError> {
        on_wall(ShellGaugeStrain::new(
            &self.mesh,
            ShellKind::default(),
            &self.limb.material,
            site,
            -0.5 * self.thickness_m,
            &GaugeParams::default(),
        ))
    }
}

/// The outer skin without end faces: behind those lies more material than half the limb's width.
fn sides(limb: &Limb) -> Result<SkinRegion, HapdefError> {
    let (mesh, boundary) = (&limb.mesh, &limb.boundary);
    let outer = outer_skin(mesh, boundary, &OuterSkinParams::default())?;
    let half_width_m = 0.5 * outer.surface(mesh)?.bounding_box().size_m().min();
    let behind = wall(mesh, boundary, &outer, half_width_m)?;
    let faces = outer.faces.iter().zip(&behind.skin_thickness_m);
    let sides = faces.filter(|(_, thickness_m)| **thickness_m < half_width_m);
    let sides = sides.map(|(face, _)| *face).collect();
    Ok(SkinRegion::new(mesh, sides)?)
}

impl Glued for SkinShell<'_> {
    type Gauge = Option<ShellGaugeStrain>;

    fn glued(&self, site: &GaugeSite) -> Option<Self::Gauge> {
        self.gauge(site).ok().flatten().map(Some)
    }

    /// A gauge that is not there reads nothing.
    fn fields(&self, gauges: &[Self::Gauge]) -> Result<Vec<Vector3<f64>>, HapdefError> {
        let there: Vec<ShellGaugeStrain> = gauges.iter().flatten().cloned().collect();
        let (response, _) = self.model.response(&there)?;
        let mut solved = node_values(&self.places, &response).into_iter();
        let mut fields = Vec::with_capacity(self.places.len() * gauges.len());
        for _ in &self.places {
            let row = gauges.iter().map(|gauge| match gauge {
                Some(_) => solved.next().unwrap_or_default(),
                None => Vector3::zeros(),
            });
            fields.extend(row);
        }
        Ok(fields)
    }
}
