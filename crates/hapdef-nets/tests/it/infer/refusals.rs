//! What is refused, and in which words.

use hapdef_nets::infer::{InferParams, LowRank, Precision, PreparedNet, SimdLevel};
use hapdef_nets::{Activation, MlpSpec, NetsError};

use super::support::{at, net_of, random_net};

#[test]
fn what_a_relu_would_hide_is_refused() {
    let mut layers = random_net(&[4, 8, 3], Activation::Relu, 2).mlp().layers().to_vec();
    layers[0].weights.iter_mut().for_each(|w| *w *= 100.0);
    let spec = MlpSpec { inputs: 4, hidden: vec![8], outputs: 3, activation: Activation::Relu };
    let net = net_of(&spec, layers);
    for precision in Precision::ALL {
        let prepared = PreparedNet::new(&net, &InferParams::of(precision)).unwrap();
        let (mut scratch, mut out) = (prepared.scratch(), [0.0; 3]);
        for bad in [f32::NAN, f32::INFINITY] {
            let error = prepared.forward(&[0.0, 0.0, bad, 0.0], &mut scratch, &mut out);
            assert!(matches!(error, Err(NetsError::InputNotFinite { row: 0, column: 2, .. })));
        }
        let error = prepared.forward(&[3e38, -3e38, 3e38, 3e38], &mut scratch, &mut out);
        assert!(matches!(error, Err(NetsError::Overflow { .. })), "{error:?}");
        assert!(prepared.forward(&[0.0; 3], &mut scratch, &mut out).is_err());
        assert!(prepared.forward(&[0.0; 4], &mut scratch, &mut out[..2]).is_err());
        prepared.forward(&[1.0; 4], &mut scratch, &mut out).unwrap();
    }
}

#[test]
fn what_the_net_lacks_is_refused() {
    let net = random_net(&[4, 8, 3], Activation::Relu, 2);
    let params = |wanted: &[usize]| InferParams {
        wanted: Some(wanted.to_vec()),
        ..InferParams::of(Precision::F32)
    };
    let refused = |params: &InferParams| PreparedNet::new(&net, params).unwrap_err();
    assert!(matches!(
        refused(&params(&[0, 3])),
        NetsError::NoSuchOutput { output: 3, n_outputs: 3 }
    ));
    assert!(matches!(refused(&params(&[])), NetsError::NoOutputs));
    assert!(matches!(
        LowRank::of_weights(&net, 2, 1),
        Err(NetsError::NoSuchLayer { layer: 2, n_layers: 2 })
    ));
    assert!(matches!(LowRank::of_weights(&net, 1, 4), Err(NetsError::Rank { rank: 4, most: 3 })));
    let mut layers = net.mlp().layers().to_vec();
    layers[1].weights[0] = f32::NAN;
    let broken = net_of(net.mlp().spec(), layers);
    assert!(PreparedNet::new(&broken, &InferParams::of(Precision::Int8)).is_err());
    if let Some(&missing) = [SimdLevel::Neon, SimdLevel::Avx2].iter().find(|l| !l.is_available()) {
        let params = at(Precision::F32, missing);
        assert!(matches!(refused(&params), NetsError::Simd { .. }));
    }
}
