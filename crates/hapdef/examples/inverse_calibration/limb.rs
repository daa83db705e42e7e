//! The training side's response map with its modes, and the simulated real limb.

use anyhow::Result;
use hapdef::Limb;
use hapdef_inverse::{ResponseMap, ResponseParams, Skin, SkinFaces, SkinParams};
use hapdef_mesh::GaugeId;
use hapdef_rig::{
    GainParams, MisplacementParams, NominalLimb, RealLimb, RigParams, VariationParams,
};
use hapdef_sim::{
    ComplianceParams, ElasticModel, ElasticParams, GaugeResponse, GaugeSite, GaugeStrain,
    NodalLoad, stiffness,
};
use nalgebra::{Point3, Rotation3, Unit, Vector3};
use rayon::prelude::*;

/// Shift and turn that derivatives are taken over.
const SHIFT_M: f64 = 5e-4;
const TURN_RAD: f64 = 0.026;

/// Width of a stiffness mode, m.
const MODE_WIDTH_M: f64 = 0.025;

/// µε.
const MICRO: f64 = 1e6;

/// The map of the nominal limb and what changes it.
pub(crate) struct Nominal {
    pub(crate) map: ResponseMap,
    /// Each gauge moved along its axis, across it (per metre) and turned (per radian).
    pub(crate) gauge_modes: Vec<ResponseMap>,
    /// Stiffness of a part of the limb, per unit of relative change.
    pub(crate) stiffness_modes: Vec<ResponseMap>,
}

impl Nominal {
    pub(crate) fn build(limb: &Limb, tip_radius_m: f64, n_stiffness: usize) -> Result<Self> {
        let params = ElasticParams::new(limb.material, limb.clamped.clone());
        let model = ElasticModel::build(&limb.mesh, &params)?;
        let (response, _) = model.gauge_response(&limb.gauges)?;
        let skin = skin(limb)?;
        let on_skin = |adjoint: &[Vector3<f64>]| {
            let params = ResponseParams { tip_radius_m };
            ResponseMap::from_nodal(skin.clone(), limb.gauges.len(), adjoint, &params)
        };
        let map = on_skin(&skin_values(limb, &response))?;
        let mut gauge_modes = Vec::new();
        for motion in 0..3 {
            gauge_modes.push(on_skin(&gauge_mode(limb, &model, motion)?)?);
        }
        let stiffness_modes = stiffness_modes(limb, &model, &response, n_stiffness)?
            .par_iter()
            .map(|adjoint| on_skin(adjoint))
            .collect::<Result<_, _>>()?;
        Ok(Self {
            map,
            gauge_modes,
            stiffness_modes,
        })
    }
}

fn skin(limb: &Limb) -> Result<Skin> {
    let place = |node| limb.skin.nodes.partition_point(|other| *other < node) as u32;
    let faces: Vec<[u32; 6]> = limb.skin.faces.iter().map(|f| f.nodes.map(place)).collect();
    let outward: Vec<Vector3<f64>> = limb.directions.iter().map(|d| -d).collect();
    let faces = SkinFaces::Quadratic(&faces);
    let params = SkinParams::default();
    Ok(Skin::new(
        limb.surface_points(),
        faces,
        Some(&outward),
        &params,
    )?)
}

/// `[n_nodes, n_gauges]`, µε/N.
fn skin_values(limb: &Limb, response: &GaugeResponse) -> Vec<Vector3<f64>> {
    let mut adjoint = Vec::with_capacity(limb.skin.nodes.len() * response.n_gauges());
    for node in &limb.skin.nodes {
        for gauge in 0..response.n_gauges() {
            adjoint.push(response.field(GaugeId::from_index(gauge))[node.index()] * MICRO);
        }
    }
    adjoint
}

/// Central differences of the response with every gauge moved; one-sided where it has no room.
fn gauge_mode(limb: &Limb, model: &ElasticModel, motion: usize) -> Result<Vec<Vector3<f64>>> {
    let step = if motion == 2 { TURN_RAD } else { SHIFT_M };
    let mut sides = Vec::new();
    let mut spans = vec![0.0; limb.gauges.len()];
    for sign in [1.0, -1.0] {
        let moved = |(i, site): (usize, &GaugeSite)| {
            let site = moved(site, &limb.gauges[i], motion, sign * step);
            GaugeStrain::with_params(&limb.mesh, &limb.boundary.faces, &site, &limb.gauge_params)
                .map_or_else(|_| (limb.gauges[i].clone(), 0.0), |gauge| (gauge, step))
        };
        let (gauges, steps): (Vec<_>, Vec<_>) = limb.sites.iter().enumerate().map(moved).unzip();
        spans.iter_mut().zip(steps).for_each(|(sum, s)| *sum += s);
        sides.push(skin_values(limb, &model.gauge_response(&gauges)?.0));
    }
    let n_gauges = limb.gauges.len();
    let slope = |(i, (up, down)): (usize, (&Vector3<f64>, &Vector3<f64>))| {
        (up - down) / spans[i % n_gauges].max(f64::MIN_POSITIVE)
    };
    Ok(sides[0]
        .iter()
        .zip(&sides[1])
        .enumerate()
        .map(slope)
        .collect())
}

fn moved(site: &GaugeSite, gauge: &GaugeStrain, motion: usize, step: f64) -> GaugeSite {
    let across = gauge.normal().cross(&gauge.axis());
    let turn = Rotation3::from_axis_angle(&Unit::new_normalize(gauge.normal()), step);
    match motion {
        0 => GaugeSite {
            position: site.position + gauge.axis() * step,
            ..*site
        },
        1 => GaugeSite {
            position: site.position + across * step,
            ..*site
        },
        _ => GaugeSite {
            axis: turn * site.axis,
            ..*site
        },
    }
}

/// ∂/∂s of the adjoint fields K⁻¹ c for bumps of stiffness 1 + s b(x): −K⁻¹ K_b K⁻¹ c, one solve per
/// bump and gauge.
fn stiffness_modes(
    limb: &Limb,
    model: &ElasticModel,
    response: &GaugeResponse,
    n_modes: usize,
) -> Result<Vec<Vec<Vector3<f64>>>> {
    let centres = centres(&limb.surface_points(), n_modes);
    let n_gauges = response.n_gauges();
    let forces = element_forces(limb, response)?;
    let mut loads = Vec::new();
    for centre in &centres {
        let weights: Vec<f64> = limb
            .mesh
            .elements()
            .iter()
            .map(|element| {
                let corners = element[..4].iter().map(|n| limb.mesh.position(*n).coords);
                let x = Point3::from(corners.sum::<Vector3<f64>>() / 4.0);
                (-0.5 * (x - centre).norm_squared() / MODE_WIDTH_M.powi(2)).exp()
            })
            .collect();
        for gauge in 0..n_gauges {
            let mut sums = vec![Vector3::zeros(); limb.mesh.nodes().len()];
            for (e, element) in limb.mesh.elements().iter().enumerate() {
                if weights[e] < 1e-4 {
                    continue;
                }
                for (i, node) in element.iter().enumerate() {
                    sums[node.index()] -= forces[gauge][10 * e + i] * weights[e];
                }
            }
            let nonzero = sums
                .into_iter()
                .enumerate()
                .filter(|(_, f)| f.norm_squared() > 0.0);
            loads.push(NodalLoad {
                forces_n: nonzero
                    .map(|(i, f)| (hapdef_mesh::FeNodeId::from_index(i), f))
                    .collect(),
                ..NodalLoad::default()
            });
        }
    }
    let (solved, _) = model.compliance(&loads, &limb.skin.nodes, &ComplianceParams::default())?;
    let mode = |k: usize| {
        let mut adjoint = Vec::new();
        for node in 0..limb.skin.nodes.len() {
            for gauge in 0..n_gauges {
                adjoint.push(solved.displacement(k * n_gauges + gauge, node) * MICRO);
            }
        }
        adjoint
    };
    Ok((0..centres.len()).map(mode).collect())
}

/// K_e λ of every element, `[n_gauges][n_elements × 10]`.
fn element_forces(limb: &Limb, response: &GaugeResponse) -> Result<Vec<Vec<Vector3<f64>>>> {
    let mut forces = vec![Vec::new(); response.n_gauges()];
    for element in limb.mesh.elements() {
        let nodes = element.map(|node| limb.mesh.position(node));
        let k = stiffness(&nodes, &limb.material)
            .map_err(|at| anyhow::anyhow!("an element is inside out: det J {}", at.det_j_m3))?;
        for (gauge, forces) in forces.iter_mut().enumerate() {
            let field = response.field(GaugeId::from_index(gauge));
            for i in 0..10 {
                forces.push(Vector3::from_fn(|c, _| {
                    (0..30)
                        .map(|j| k[3 * i + c][j] * field[element[j / 3].index()][j % 3])
                        .sum()
                }));
            }
        }
    }
    Ok(forces)
}

/// Points spread over the skin, each the farthest from those before.
fn centres(points: &[Point3<f64>], n: usize) -> Vec<Point3<f64>> {
    let mut chosen = vec![points[0]];
    while chosen.len() < n {
        let gap = |x: &Point3<f64>| {
            chosen
                .iter()
                .map(|c| (c - x).norm_squared())
                .fold(f64::INFINITY, f64::min)
        };
        let Some(next) = points.iter().max_by(|a, b| gap(a).total_cmp(&gap(b))) else {
            break;
        };
        chosen.push(*next);
    }
    chosen
}

/// A rig perturbed like the bundled scene's, with the seeds `seed`, `seed` + 1, ….
pub(crate) fn real_limb(limb: &Limb, tip_radius_m: f64, seed: u64) -> Result<RealLimb> {
    let nominal = NominalLimb {
        mesh: &limb.mesh,
        clamped: &limb.clamped,
        material: limb.material,
        gauges: &limb.sites,
        gauge_params: limb.gauge_params,
        skin: &limb.skin,
        tip_radius_m,
    };
    let variation = |fraction, seed| VariationParams {
        fraction,
        correlation_length_m: 0.03,
        seed,
    };
    let params = RigParams {
        refinements: 1,
        stiffness: variation(0.1, seed),
        thickness: variation(0.05, seed + 1),
        max_wall_m: 0.003,
        misplacement: MisplacementParams {
            shift_m: 1e-3,
            turn_rad: 3_f64.to_radians(),
            seed: seed + 2,
        },
        gain: GainParams {
            fraction: 0.03,
            seed: seed + 3,
        },
    };
    Ok(RealLimb::build(&nominal, &params, 2)?)
}
