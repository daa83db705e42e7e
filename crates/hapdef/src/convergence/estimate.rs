//! Errors of a sequence of meshes, by Richardson extrapolation.

use hapdef_bench::stats::{median, quantile, sorted};
use serde::{Deserialize, Serialize};

use super::MeshLevel;
use super::differences::{distance, largest, norm};

/// What is compared between meshes.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// All gauges' strains under a tip.
    GaugeReading,
    /// Displacement under a tip.
    TipDisplacement,
    /// Displacement under a point force.
    PointDisplacement,
}

/// How a quantity changes with refinement.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct QuantityEstimate {
    /// Which quantity.
    pub quantity: Quantity,
    /// Whether [`Self::order`] was observed on three meshes, not assumed.
    pub order_observed: bool,
    /// p of error ∝ hᵖ.
    pub order: f64,
    /// The finest mesh's size of the quantity over the scene's mesh's, per press: median.
    pub median_ratio: f64,
    /// The same, the smallest and the largest of all presses.
    pub ratio_range: [f64; 2],
    /// Estimated relative error of each mesh, median over the presses `[n_levels]`.
    pub median_error: Vec<f64>,
    /// Estimated relative error of each mesh at its worst press `[n_levels]`.
    pub worst_error: Vec<f64>,
}

/// Orders outside of this range are not what a mesh family shows before its asymptotic range.
const ORDER_RANGE: [f64; 2] = [0.5, 4.0];

/// Estimates the errors of all meshes from the differences between neighbours.
///
/// With x_l the quantity on mesh l and element sizes halved each time, x_l − x ≈ C 2^(−p l), so
/// x_l − x ≈ (x_l − x_(l+1)) / (1 − 2⁻ᵖ), and for the finest mesh 2⁻ᵖ times its predecessor's error
/// (P. J. Roache, J. Fluids Eng. 116, 1994). Differences are taken relative to the finest mesh.
pub(super) fn estimate(
    quantity: Quantity,
    levels: &[MeshLevel],
    assumed_order: f64,
) -> QuantityEstimate {
    let values: Vec<Vec<Vec<f64>>> = levels.iter().map(|level| of(quantity, level)).collect();
    let finest = &values[values.len() - 1];
    let step = |pair: &[Vec<Vec<f64>>]| {
        let presses = pair[0].iter().zip(&pair[1]).zip(finest);
        presses.map(|((coarse, fine), of)| distance(coarse, fine) / norm(of)).collect()
    };
    let steps: Vec<Vec<f64>> = values.windows(2).map(step).collect();
    let observed = observed_order(&steps);
    let order = observed.unwrap_or(assumed_order);
    let shrink = 0.5_f64.powf(order);
    let mut errors: Vec<Vec<f64>> =
        steps.iter().map(|step| step.iter().map(|d| d / (1.0 - shrink)).collect()).collect();
    let last = errors[errors.len() - 1].iter().map(|e| e * shrink).collect();
    errors.push(last);
    let ratios =
        sorted(values[0].iter().zip(finest).map(|(coarse, fine)| norm(fine) / norm(coarse)));
    QuantityEstimate {
        quantity,
        order_observed: observed.is_some(),
        order,
        median_ratio: quantile(&ratios, 0.5),
        ratio_range: [ratios[0], ratios[ratios.len() - 1]],
        median_error: errors.iter().map(|e| median(e.iter().copied())).collect(),
        worst_error: errors.iter().map(|e| largest(e.iter().copied())).collect(),
    }
}

fn of(quantity: Quantity, level: &MeshLevel) -> Vec<Vec<f64>> {
    let single = |values: &[f64]| values.iter().map(|&v| vec![v]).collect();
    match quantity {
        Quantity::GaugeReading => level.reading_ue_per_n.clone(),
        Quantity::TipDisplacement => single(&level.tip_um_per_n),
        Quantity::PointDisplacement => single(&level.point_um_per_n),
    }
}

/// log₂ of how much the median difference shrinks from step to step, on the last three meshes.
fn observed_order(steps: &[Vec<f64>]) -> Option<f64> {
    let [.., before, last] = steps else {
        return None;
    };
    let order = (median(before.iter().copied()) / median(last.iter().copied())).log2();
    order.is_finite().then(|| order.clamp(ORDER_RANGE[0], ORDER_RANGE[1]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Levels whose readings are 100 (1 + 0.3 · 2^(−p l)) and twice that at the second press.
    fn levels(order: f64, n: usize) -> Vec<MeshLevel> {
        (0..n)
            .map(|l| {
                let reading = 100.0 * (1.0 + 0.3 * 0.5_f64.powf(order * l as f64));
                MeshLevel {
                    n_fe_nodes: 0,
                    n_elements: 0,
                    n_equations: 0,
                    n_straightened: 0,
                    build_s: 0.0,
                    adjoint_s: 0.0,
                    reading_ue_per_n: vec![vec![reading, -reading], vec![2.0 * reading, 0.0]],
                    tip_um_per_n: vec![reading, reading],
                    point_um_per_n: vec![reading, reading],
                }
            })
            .collect()
    }

    #[test]
    fn the_order_of_three_meshes_is_observed() {
        for order in [1.0, 1.5, 2.0] {
            let estimate = estimate(Quantity::GaugeReading, &levels(order, 3), 9.0);
            assert!(estimate.order_observed);
            assert!((estimate.order - order).abs() < 1e-12, "{estimate:?}");
            let finest = 1.0 + 0.3 * 0.25_f64.powf(order);
            for (level, error) in estimate.median_error.iter().enumerate() {
                let true_error = 0.3 * 0.5_f64.powf(order * level as f64) / finest;
                assert!((error / true_error - 1.0).abs() < 1e-12, "{estimate:?}");
            }
        }
    }

    #[test]
    fn two_meshes_take_the_order_on_trust() {
        let estimate = estimate(Quantity::TipDisplacement, &levels(1.0, 2), 1.0);
        assert!(!estimate.order_observed);
        assert!((estimate.median_error[0] - 0.3 / 1.15).abs() < 1e-12);
        assert!((estimate.median_error[1] - 0.15 / 1.15).abs() < 1e-12);
        assert!((estimate.median_ratio - 1.15 / 1.3).abs() < 1e-12);
    }
}
