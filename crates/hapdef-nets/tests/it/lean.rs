//! The forward pass, the beginning of the weights, and the files; all without training.

use std::fs;
use std::path::{Path, PathBuf};

use hapdef_nets::infer::{InferParams, Precision, PreparedNet};
use hapdef_nets::{
    Activation, Layer, Mlp, MlpSpec, Moments, Net, NetsError, Resumable, Scale, Scratch,
    TrainParams, TrainRecord, load, load_for_resume, save,
};
use proptest::prelude::*;
use safetensors::tensor::TensorView;

fn spec(inputs: usize, hidden: &[usize], outputs: usize, activation: Activation) -> MlpSpec {
    MlpSpec { inputs, hidden: hidden.to_vec(), outputs, activation }
}

fn net() -> Net {
    let mlp = Mlp::random(&spec(3, &[9, 5], 2, Activation::Tanh), 4).unwrap();
    let input = Scale::new(vec![1.0, 2.0, 3.0], vec![0.5, 0.25, 4.0]).unwrap();
    let output = Scale::new(vec![-1.0, 0.1], vec![10.0, 1e-3]).unwrap();
    Net::new(mlp, input, output).unwrap()
}

fn record(step: u64) -> TrainRecord {
    TrainRecord { step, train_loss: Some(0.1), ..TrainRecord::new(TrainParams::paper(3)) }
}

/// The formulas, in f64, one neuron at a time.
fn by_the_formula(mlp: &Mlp, x: &[f32]) -> Vec<f64> {
    let mut a: Vec<f64> = x.iter().map(|&v| f64::from(v)).collect();
    let last = mlp.layers().len() - 1;
    for (i, layer) in mlp.layers().iter().enumerate() {
        let rows = layer.weights.chunks(a.len()).zip(&layer.bias);
        a = rows
            .map(|(row, &b)| {
                let z =
                    row.iter().zip(&a).map(|(&w, a)| f64::from(w) * a).sum::<f64>() + f64::from(b);
                match mlp.spec().activation {
                    _ if i == last => z,
                    Activation::Tanh => z.tanh(),
                    Activation::Relu => z.max(0.0),
                }
            })
            .collect();
    }
    a
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn forward_is_the_formula_and_a_batch_has_the_same_bits(
        widths in prop::collection::vec(1..40usize, 2..6),
        n in 1..40usize,
        seed in any::<u64>(),
        relu in any::<bool>(),
    ) {
        let activation = if relu { Activation::Relu } else { Activation::Tanh };
        let (inputs, outputs) = (widths[0], widths[widths.len() - 1]);
        let mlp = Mlp::random(&spec(inputs, &widths[1..widths.len() - 1], outputs, activation), seed).unwrap();
        let x: Vec<f32> = (0..n * inputs).map(|i| (i as f32 * 1.3).sin()).collect();
        let mut scratch = Scratch::default();
        let mut batch = vec![0.0; n * outputs];
        mlp.forward_batch(&x, &mut scratch, &mut batch).unwrap();
        for (x, of_batch) in x.chunks(inputs).zip(batch.chunks(outputs)) {
            let mut out = vec![0.0; outputs];
            mlp.forward(x, &mut scratch, &mut out).unwrap();
            prop_assert_eq!(&out, of_batch);
            for (found, expected) in out.iter().zip(by_the_formula(&mlp, x)) {
                prop_assert!((f64::from(*found) - expected).abs() < 1e-5, "{found} against {expected}");
            }
        }
    }

    #[test]
    fn a_net_in_raw_units_is_the_network_between_its_scales(x in prop::array::uniform3(-5.0..5.0f32)) {
        let net = net();
        let standardised: Vec<f32> = (0..3)
            .map(|i| (x[i] - net.input_scale().mean()[i]) / net.input_scale().std()[i])
            .collect();
        let expected = by_the_formula(net.mlp(), &standardised);
        let mut out = [0.0; 2];
        net.forward(&x, &mut Scratch::default(), &mut out).unwrap();
        for i in 0..2 {
            let std = f64::from(net.output_scale().std()[i]);
            let raw = expected[i] * std + f64::from(net.output_scale().mean()[i]);
            prop_assert!((f64::from(out[i]) - raw).abs() < 1e-5 * std.max(0.1), "{out:?}");
        }
    }
}

#[test]
fn weights_begin_with_the_variance_of_he_and_glorot() {
    let variance = |layer: &Layer| {
        let sum: f64 = layer.weights.iter().map(|&w| f64::from(w).powi(2)).sum();
        sum / layer.weights.len() as f64
    };
    let relu = Mlp::random(&spec(200, &[300], 400, Activation::Relu), 1).unwrap();
    let tanh = Mlp::random(&spec(200, &[300], 400, Activation::Tanh), 1).unwrap();
    for (layer, expected) in [
        (&relu.layers()[0], 2.0 / 200.0),
        (&relu.layers()[1], 2.0 / 700.0),
        (&tanh.layers()[0], 2.0 / 500.0),
    ] {
        assert!((variance(layer) / expected - 1.0).abs() < 0.02, "{}", variance(layer));
        assert!(layer.bias.iter().all(|b| *b == 0.0));
    }
}

#[test]
fn weights_depend_on_the_seed_alone() {
    let spec = MlpSpec::sensitivity();
    assert_eq!(Mlp::random(&spec, 5).unwrap(), Mlp::random(&spec, 5).unwrap());
    assert_ne!(Mlp::random(&spec, 5).unwrap(), Mlp::random(&spec, 6).unwrap());
    let mlp = Mlp::random(&spec, 5).unwrap();
    // Another generator, or another order of drawing, would change every trained net.
    assert_eq!(mlp.layers()[0].weights[..3], [-0.7139805, -0.7317859, -0.5461127]);
}

#[test]
fn what_a_relu_would_hide_is_refused() {
    let (net, mut scratch, mut out) = (net(), Scratch::default(), [0.0; 2]);
    for bad in [f32::NAN, f32::INFINITY] {
        let error = net.forward(&[0.0, bad, 0.0], &mut scratch, &mut out).unwrap_err();
        assert!(matches!(error, NetsError::InputNotFinite { row: 0, column: 1, .. }), "{error}");
    }
    let rows = [0.0, 0.0, 0.0, 0.0, 0.0, f32::NAN];
    let error = net.forward_batch(&rows, &mut scratch, &mut [0.0; 4]);
    let words = error.unwrap_err().to_string();
    assert!(words.contains("row 1, column 2 is NaN"), "{words}");
    let error = net.forward(&[0.0; 2], &mut scratch, &mut out).unwrap_err();
    assert!(matches!(error, NetsError::Length { expected: 3, got: 2, .. }), "{error}");
    let error = net.forward_batch(&[0.0; 6], &mut scratch, &mut out).unwrap_err();
    assert!(matches!(error, NetsError::Length { expected: 4, got: 2, .. }), "{error}");
}

#[test]
fn deviations_that_are_negative_or_no_number_are_refused() {
    let bad = Scale::new(vec![0.0; 2], vec![1.0, -0.5]);
    assert!(matches!(bad, Err(NetsError::Deviation { column: 1, .. })));
    assert!(Scale::new(vec![0.0; 2], vec![1.0]).is_err());
    assert!(Scale::new(vec![f32::NAN], vec![1.0]).is_err());
}

#[test]
fn columns_that_never_varied_have_no_say() {
    let net = net();
    let input = Scale::new(vec![1.0, 2.0, 3.0], vec![0.5, 0.0, 4.0]).unwrap();
    let output = Scale::new(vec![-1.0, 0.1], vec![10.0, 0.0]).unwrap();
    let net = Net::new(net.mlp().clone(), input, output).unwrap();
    assert!(net.input_scale().constant_columns().eq([1]));
    let run = |x: [f32; 3]| {
        let mut out = [0.0; 2];
        net.forward(&x, &mut Scratch::default(), &mut out).unwrap();
        out
    };
    let still = run([1.5, 2.0, -1.0]);
    assert_eq!(still[1], 0.1, "an output that never varied stays");
    for moved in [2.5, -1e30, f32::MAX] {
        assert_eq!(run([1.5, moved, -1.0]), still);
    }
    assert_ne!(run([1.6, 2.0, -1.0]), still);
    for precision in Precision::ALL {
        let prepared = PreparedNet::new(&net, &InferParams::of(precision)).unwrap();
        let run = |x: [f32; 3]| {
            let mut out = [0.0; 2];
            let mut scratch = prepared.scratch();
            prepared.forward(&x, &mut scratch, &mut out).unwrap();
            out
        };
        assert_eq!(run([1.5, 1e30, -1.0]), run([1.5, 2.0, -1.0]));
        assert_eq!(run([1.5, 1e30, -1.0])[1], 0.1);
    }
}

fn folder_and_path() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("transfer.json");
    (folder, path)
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<_> =
        entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_checkpoint_comes_back_bit_for_bit() {
    let (folder, path) = folder_and_path();
    let net = net();
    let mut moments = Moments::zeros(net.mlp());
    moments[1].weights_v[3] = 1e-30;
    save(&path, &net, &record(7), Some(&moments)).unwrap();
    assert_eq!(load(&path).unwrap(), (net.clone(), record(7)));
    let expected = Resumable { net, record: record(7), moments, best: None };
    assert_eq!(load_for_resume(&path).unwrap(), expected);
    let expected = ["transfer-7.moments.safetensors", "transfer-7.safetensors", "transfer.json"];
    assert_eq!(names(folder.path()), expected);
}

#[test]
fn a_new_checkpoint_replaces_the_old_one_whole() {
    let (folder, path) = folder_and_path();
    let net = net();
    save(&path, &net, &record(7), Some(&Moments::zeros(net.mlp()))).unwrap();
    save(&path, &net, &record(8), None).unwrap();
    assert_eq!(names(folder.path()), ["transfer-8.safetensors", "transfer.json"]);
    assert!(matches!(load_for_resume(&path), Err(NetsError::NotResumable { .. })));
}

#[test]
fn a_cut_off_weights_file_is_refused() {
    let (folder, path) = folder_and_path();
    save(&path, &net(), &record(7), None).unwrap();
    let weights = folder.path().join("transfer-7.safetensors");
    let whole = fs::read(&weights).unwrap();
    for length in [0, 7, 100, whole.len() - 1] {
        fs::write(&weights, &whole[..length]).unwrap();
        assert!(matches!(load(&path), Err(NetsError::Safetensors { .. })), "{length}");
    }
    fs::remove_file(&weights).unwrap();
    assert!(matches!(load(&path), Err(NetsError::Io { .. })));
}

#[test]
fn a_weight_that_is_not_a_number_is_refused() {
    let (folder, path) = folder_and_path();
    save(&path, &net(), &record(7), None).unwrap();
    let weights = folder.path().join("transfer-7.safetensors");
    let mut bytes = fs::read(&weights).unwrap();
    let end = bytes.len();
    bytes[end - 4..].copy_from_slice(&f32::NAN.to_le_bytes());
    fs::write(&weights, bytes).unwrap();
    assert!(matches!(load(&path), Err(NetsError::Weight { .. })));
}

#[track_caller]
fn check_edited(from: &str, to: &str, is_expected: fn(&NetsError) -> bool) {
    let (_folder, path) = folder_and_path();
    save(&path, &net(), &record(7), None).unwrap();
    let json = fs::read_to_string(&path).unwrap();
    assert!(json.contains(from));
    fs::write(&path, json.replacen(from, to, 1)).unwrap();
    let error = load(&path).unwrap_err();
    assert!(is_expected(&error), "{error}");
}

#[test]
fn a_checkpoint_of_another_architecture_version_or_folder_is_refused() {
    check_edited("\"outputs\": 2", "\"outputs\": 3", |e| matches!(e, NetsError::Tensor { .. }));
    check_edited("\"inputs\": 3", "\"inputs\": 0", |e| matches!(e, NetsError::Widths { .. }));
    check_edited("\"tanh\"", "\"tanf\"", |e| matches!(e, NetsError::Json { .. }));
    check_edited("\"seed\"", "\"sead\"", |e| matches!(e, NetsError::Json { .. }));
    check_edited(
        "\"seed\"",
        "\"batches\": 3, \"seed\"",
        |e| matches!(e, NetsError::Json { source, .. } if source.to_string().contains("`batches`")),
    );
    check_edited("\"format_version\": 2", "\"format_version\": 9", |e| {
        matches!(e, NetsError::FormatVersion { found: 9, known: 2, .. })
    });
    check_edited("transfer-7", "../transfer-7", |e| matches!(e, NetsError::FileName { .. }));
    check_edited("0.25", "-0.25", |e| matches!(e, NetsError::Deviation { column: 1, .. }));
}

#[test]
fn a_net_comes_back_from_its_bytes_or_is_refused() {
    let net = net();
    let bytes = net.to_bytes().unwrap();
    assert_eq!(Net::from_bytes(&bytes, "net").unwrap(), net);
    assert_eq!(net.to_bytes().unwrap(), bytes);
    for len in 0..bytes.len() {
        assert!(Net::from_bytes(&bytes[..len], "net").is_err(), "{len} bytes");
    }
    let plain = safetensors::serialize(Vec::<(&str, TensorView<'_>)>::new(), None).unwrap();
    let error = Net::from_bytes(&plain, "some file").unwrap_err();
    assert!(matches!(error, NetsError::NotANet { .. }), "{error}");
    assert!(error.to_string().contains("some file"), "{error}");
}
