//! The response map of a scene's limb.

use anyhow::Result;
use hapdef::Limb;
use hapdef_inverse::{ResponseMap, ResponseParams, Skin, SkinFaces, SkinParams};
use hapdef_mesh::GaugeId;
use hapdef_sim::{ElasticModel, ElasticParams};
use nalgebra::Vector3;

/// Gauge readings per newton on the training mesh, µε/N.
pub(crate) fn response_map(limb: &Limb, tip_radius_m: f64) -> Result<ResponseMap> {
    let params = ElasticParams::new(limb.material, limb.clamped.clone());
    let model = ElasticModel::build(&limb.mesh, &params)?;
    let (response, _) = model.gauge_response(&limb.gauges)?;
    let n_gauges = limb.gauges.len();
    let mut adjoint = Vec::with_capacity(limb.skin.nodes.len() * n_gauges);
    for node in &limb.skin.nodes {
        for gauge in 0..n_gauges {
            adjoint.push(response.field(GaugeId::from_index(gauge))[node.index()] * 1e6);
        }
    }
    let place = |node| limb.skin.nodes.partition_point(|other| *other < node) as u32;
    let faces: Vec<[u32; 6]> = limb.skin.faces.iter().map(|f| f.nodes.map(place)).collect();
    let outward: Vec<Vector3<f64>> = limb.directions.iter().map(|d| -d).collect();
    let skin = Skin::new(
        limb.surface_points(),
        SkinFaces::Quadratic(&faces),
        Some(&outward),
        &SkinParams::default(),
    )?;
    let params = ResponseParams { tip_radius_m };
    Ok(ResponseMap::from_nodal(skin, n_gauges, &adjoint, &params)?)
}
