//! The elastic model that a limb is solved by: of its solid, or of the shell of its wall.

use hapdef_mesh::{FeNodeId, GaugeId};
use hapdef_sim::{
    Compliance, ComplianceParams, ElasticModel, ElasticParams, FactorInfo, GaugeResponse,
    GaugeSite, GaugeStrain, LinearFunctional, Motion, NodalLoad, ShellParams, SimError, SolveInfo,
    Supports,
};
use nalgebra::{Point3, Vector3};

use crate::error::HapdefError;
use crate::limb::Limb;
use crate::wall_shell::WallShell;

/// A gauge as the model reads it; nothing of one that lies on no wall of the shell's, as on a rib.
pub(crate) type ModelGauge = Option<LinearFunctional>;

/// A limb, factored. Nodes, loads and sites are the solid's, whatever is solved.
pub(crate) struct LimbModel<'a> {
    pub(super) limb: &'a Limb,
    pub(super) shell: Option<&'a WallShell>,
    pub(crate) model: ElasticModel,
}

impl<'a> LimbModel<'a> {
    /// The model that the limb is solved by: the shell of its wall where it has one.
    ///
    /// # Errors
    /// [`HapdefError::Sim`] when the limb floats or can't be factored.
    pub(crate) fn build(limb: &'a Limb, n_threads: usize) -> Result<Self, HapdefError> {
        if let Some(shell) = &limb.shell {
            return Self::of_shell(limb, shell, n_threads);
        }
        let params = solid_params(limb, n_threads);
        Ok(Self { limb, shell: None, model: ElasticModel::build(&limb.mesh, &params)? })
    }

    /// The model of a shell under the limb's skin.
    ///
    /// # Errors
    /// As [`Self::build`].
    pub(crate) fn of_shell(
        limb: &'a Limb,
        shell: &'a WallShell,
        n_threads: usize,
    ) -> Result<Self, HapdefError> {
        let params = shell_params(limb, shell, n_threads);
        Ok(Self {
            limb,
            shell: Some(shell),
            model: ElasticModel::build_shell(&shell.mesh, &params)?,
        })
    }

    /// Gauges at `sites`, given as they lie on the solid.
    ///
    /// # Errors
    /// [`HapdefError::Sim`] for a site without a size.
    pub(crate) fn gauges(
        &self,
        sites: &[GaugeSite],
        on_solid: &[GaugeStrain],
    ) -> Result<Vec<ModelGauge>, HapdefError> {
        match self.shell {
            Some(_) => sites.iter().map(|site| self.gauge_at(site)).collect(),
            None => Ok(on_solid.iter().map(|gauge| Some(gauge.functional().clone())).collect()),
        }
    }

    /// The gauge at a site.
    ///
    /// # Errors
    /// [`HapdefError::Sim`] for a site without a size, on a solid for one that a gauge doesn't fit at.
    pub(super) fn gauge_at(&self, site: &GaugeSite) -> Result<ModelGauge, HapdefError> {
        let limb = self.limb;
        let functional = match self.shell {
            Some(shell) => {
                let lost = limb.gauge_params.max_lost_share;
                return match shell.gauge(site, &limb.material, lost) {
                    Ok(gauge) => Ok(Some(gauge.functional().clone())),
                    Err(
                        SimError::GaugeOverhang { .. }
                        | SimError::GaugeOffWall { .. }
                        | SimError::Direction { .. },
                    ) => Ok(None),
                    Err(error) => Err(error.into()),
                };
            }
            None => {
                let faces = &limb.boundary.faces;
                GaugeStrain::with_params(&limb.mesh, faces, site, &limb.gauge_params)?
            }
        };
        Ok(Some(functional.functional().clone()))
    }

    /// Adjoint fields on the limb's skin `[n_surface, n_gauges]`, µε/N. A force on the skin of a shell
    /// turns the wall's middle, too. A gauge that is not there reads nothing.
    ///
    /// # Errors
    /// [`HapdefError::Sim`].
    pub(crate) fn fields(
        &self,
        gauges: &[ModelGauge],
    ) -> Result<(Vec<Vector3<f64>>, SolveInfo), HapdefError> {
        let (response, solved) = self.response(gauges)?;
        Ok((self.fields_of(gauges, &response), solved))
    }

    /// Adjoint fields of the gauges that are there, at all nodes of the model.
    ///
    /// # Errors
    /// [`HapdefError::Sim`].
    pub(super) fn response(
        &self,
        gauges: &[ModelGauge],
    ) -> Result<(GaugeResponse, SolveInfo), HapdefError> {
        let there: Vec<&LinearFunctional> = gauges.iter().flatten().collect();
        Ok(self.model.response(&there)?)
    }

    /// [`Self::fields`] of solved gauges.
    pub(super) fn fields_of(
        &self,
        gauges: &[ModelGauge],
        response: &GaugeResponse,
    ) -> Vec<Vector3<f64>> {
        let mut fields = Vec::with_capacity(self.limb.skin.nodes.len() * gauges.len());
        for node in &self.limb.skin.nodes {
            let mut solved = (0..response.n_gauges()).map(GaugeId::from_index);
            let row = gauges.iter().map(|gauge| match gauge.as_ref().and_then(|_| solved.next()) {
                Some(gauge) => self.moved(response, gauge, *node) * 1e6,
                None => Vector3::zeros(),
            });
            fields.extend(row);
        }
        fields
    }

    /// Displacements at the solid's `nodes` under loads on its skin, m/N; on a shell those of the wall's
    /// middle at each.
    ///
    /// # Errors
    /// As [`ElasticModel::compliance`].
    pub(crate) fn compliance(
        &self,
        loads: &[NodalLoad],
        nodes: &[FeNodeId],
    ) -> Result<(Compliance, SolveInfo), SimError> {
        let loads: Vec<NodalLoad> = loads.iter().map(|load| self.load(load)).collect();
        self.displacements(&loads, nodes)
    }

    /// The same under loads on the model's own nodes.
    ///
    /// # Errors
    /// As [`ElasticModel::compliance`].
    pub(super) fn displacements(
        &self,
        loads: &[NodalLoad],
        nodes: &[FeNodeId],
    ) -> Result<(Compliance, SolveInfo), SimError> {
        let nodes: Vec<FeNodeId> = nodes.iter().map(|node| self.node(*node)).collect();
        self.model.compliance(loads, &nodes, &ComplianceParams::default())
    }

    /// How all nodes of the model move under loads on the skin `[n_loads]`.
    ///
    /// # Errors
    /// As [`ElasticModel::compliance`].
    pub(super) fn motions(&self, loads: &[NodalLoad]) -> Result<Vec<Motion>, SimError> {
        if self.shell.is_some() {
            let solved = loads.iter().map(|load| self.model.solve_motion(&self.load(load)));
            return solved.map(|solved| Ok(solved?.0)).collect();
        }
        let all: Vec<_> = (0..self.limb.mesh.nodes().len()).map(FeNodeId::from_index).collect();
        let (compliance, _) = self.model.compliance(loads, &all, &ComplianceParams::default())?;
        let field =
            |load: usize| compliance.row(load).chunks_exact(3).map(Vector3::from_column_slice);
        let motion = |load| Motion { displacement: field(load).collect(), ..Motion::default() };
        Ok((0..loads.len()).map(motion).collect())
    }

    /// A load on the solid's skin as the model takes it.
    pub(crate) fn load(&self, load: &NodalLoad) -> NodalLoad {
        let Some(shell) = self.shell else {
            return load.clone();
        };
        let turning = |(node, force): &(FeNodeId, Vector3<f64>)| {
            let under = self.node(*node);
            (under, self.arm(shell, *node, under).cross(force))
        };
        NodalLoad {
            forces_n: load
                .forces_n
                .iter()
                .map(|(node, force)| (self.node(*node), *force))
                .collect(),
            moments_nm: load.forces_n.iter().map(turning).collect(),
        }
    }

    /// The model's node that stands for one of the solid.
    fn node(&self, node: FeNodeId) -> FeNodeId {
        self.shell.map_or(node, |shell| shell.under(node, &self.place(node)))
    }

    fn place(&self, node: FeNodeId) -> Point3<f64> {
        self.limb.mesh.position(node)
    }

    /// From the wall's middle to a node of the solid.
    fn arm(&self, shell: &WallShell, node: FeNodeId, under: FeNodeId) -> Vector3<f64> {
        self.place(node) - shell.mesh.nodes()[under.index()]
    }

    /// The adjoint displacement of a node of the solid's skin.
    fn moved(&self, response: &GaugeResponse, gauge: GaugeId, node: FeNodeId) -> Vector3<f64> {
        let under = self.node(node);
        let moved = response.field(gauge)[under.index()];
        self.shell.map_or(moved, |shell| {
            let turned = response.moment_field(gauge)[under.index()];
            moved + turned.cross(&self.arm(shell, node, under))
        })
    }
}

/// What a factorisation of the limb's model would take.
///
/// # Errors
/// [`HapdefError::Sim`] when the limb floats.
pub(crate) fn model_estimate(limb: &Limb, n_threads: usize) -> Result<FactorInfo, HapdefError> {
    Ok(match &limb.shell {
        Some(shell) => {
            ElasticModel::estimate_shell(&shell.mesh, &shell_params(limb, shell, n_threads))?
        }
        None => ElasticModel::estimate(&limb.mesh, &solid_params(limb, n_threads))?,
    })
}

fn solid_params(limb: &Limb, n_threads: usize) -> ElasticParams {
    let supports = Supports::of_rigid_body(&limb.flange);
    ElasticParams { supports, n_threads, ..ElasticParams::new(limb.material, limb.clamped.clone()) }
}

fn shell_params(limb: &Limb, shell: &WallShell, n_threads: usize) -> ShellParams {
    let (clamped, flange) = (shell.under_all(&limb.clamped), shell.under_all(&limb.flange));
    let supports = Supports::of_rigid_body(&flange);
    ShellParams {
        kind: shell.kind,
        supports,
        n_threads,
        ..ShellParams::new(limb.material, clamped)
    }
}
