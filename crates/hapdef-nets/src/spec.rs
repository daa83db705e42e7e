//! What a network looks like.

use serde::{Deserialize, Serialize};

use crate::activation::Activation;
use crate::error::NetsError;

/// A fully connected network: `inputs → hidden[0] → … → outputs`, the activation after every
/// hidden layer, none after the last.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MlpSpec {
    /// Numbers in.
    pub inputs: usize,
    /// Neurons of every hidden layer.
    pub hidden: Vec<usize>,
    /// Numbers out.
    pub outputs: usize,
    /// What every hidden neuron does to its sum.
    pub activation: Activation,
}

impl MlpSpec {
    /// The transfer net F_T, gauge readings to virtual gauges: 6 × 250 tanh (section 3.4.1).
    pub fn transfer(n_gauges: usize, n_virtual_gauges: usize) -> Self {
        Self::uniform(n_gauges, 250, 6, n_virtual_gauges, Activation::Tanh)
    }

    /// The reconstruction net F_R, virtual gauges to displacement magnitude at every surface
    /// node: 600–1200–1800 ReLU (section 3.4.2).
    pub fn reconstruction(n_virtual_gauges: usize, n_surface_nodes: usize) -> Self {
        Self {
            inputs: n_virtual_gauges,
            hidden: vec![600, 1200, 1800],
            outputs: n_surface_nodes,
            activation: Activation::Relu,
        }
    }

    /// The sensitivity net F_S, displacement and position (D_i, P_i) of one peak to normal force:
    /// 4 × 250 ReLU (section 3.4.3).
    pub fn sensitivity() -> Self {
        Self::uniform(4, 250, 4, 1, Activation::Relu)
    }

    /// The direct net, gauge readings to position and normal force of a single contact:
    /// 5 × 500 ReLU (section 4.1).
    pub fn direct(n_gauges: usize) -> Self {
        Self::uniform(n_gauges, 500, 5, 4, Activation::Relu)
    }

    /// Widths of the layers as `(inputs, outputs)` pairs, first to last.
    pub fn layer_shapes(&self) -> Vec<(usize, usize)> {
        let widths = self.widths();
        widths.windows(2).map(|w| (w[0], w[1])).collect()
    }

    /// Number of weights and biases.
    pub fn n_parameters(&self) -> usize {
        let shapes = self.layer_shapes();
        shapes.iter().map(|(n_in, n_out)| (n_in + 1) * n_out).sum()
    }

    /// Fails if a width is 0.
    pub fn check(&self) -> Result<(), NetsError> {
        let widths = self.widths();
        if widths.contains(&0) {
            return Err(NetsError::Widths { widths });
        }
        Ok(())
    }

    fn uniform(
        inputs: usize,
        width: usize,
        n_hidden: usize,
        outputs: usize,
        activation: Activation,
    ) -> Self {
        Self { inputs, hidden: vec![width; n_hidden], outputs, activation }
    }

    fn widths(&self) -> Vec<usize> {
        let ends = (std::iter::once(self.inputs), std::iter::once(self.outputs));
        ends.0.chain(self.hidden.iter().copied()).chain(ends.1).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(spec: &MlpSpec, n_parameters: usize) {
        spec.check().unwrap();
        assert_eq!(spec.n_parameters(), n_parameters);
    }

    #[test]
    fn sizes_of_the_paper_s_networks() {
        let hidden = |width: usize, n: usize| (n - 1) * (width + 1) * width;
        check(&MlpSpec::transfer(10, 240), 11 * 250 + hidden(250, 6) + 251 * 240);
        check(
            &MlpSpec::reconstruction(240, 3211),
            241 * 600 + 601 * 1200 + 1201 * 1800 + 1801 * 3211,
        );
        check(&MlpSpec::sensitivity(), 5 * 250 + hidden(250, 4) + 251);
        check(&MlpSpec::direct(10), 11 * 500 + hidden(500, 5) + 501 * 4);
    }

    #[test]
    fn a_layer_without_neurons_is_refused() {
        let mut spec = MlpSpec::sensitivity();
        spec.hidden[2] = 0;
        assert!(matches!(spec.check(), Err(NetsError::Widths { .. })));
    }
}
