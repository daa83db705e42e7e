//! One pass through the paper's four networks, prepared in every precision and on every level of
//! vector instructions that the processor has.
//!
//! ```text
//! cargo bench --bench infer
//! ```
#![expect(missing_docs, reason = "criterion's macros make undocumented items")]

use criterion::{Criterion, criterion_group, criterion_main};
use hapdef_nets::infer::{InferParams, LowRank, Precision, PreparedNet, SimdLevel};
use hapdef_nets::{Mlp, MlpSpec, Net, Scale, Scratch};

fn random(spec: &MlpSpec) -> Net {
    let mlp = Mlp::random(spec, 1).expect("widths above 0");
    let [input, output] = [spec.inputs, spec.outputs].map(Scale::identity);
    Net::new(mlp, input, output).expect("scales of the same widths")
}

fn nets(c: &mut Criterion) {
    for (name, spec) in [
        ("F_T", MlpSpec::transfer(10, 240)),
        ("F_R", MlpSpec::reconstruction(240, 3211)),
        ("F_S", MlpSpec::sensitivity()),
        ("direct", MlpSpec::direct(10)),
    ] {
        let net = random(&spec);
        let mut group = c.benchmark_group(name);
        let x: Vec<f32> = (0..spec.inputs).map(|i| (i as f32).sin()).collect();
        let mut out = vec![0.0; spec.outputs];
        let mut scratch = Scratch::default();
        group.bench_function("plain", |b| {
            b.iter(|| net.forward(&x, &mut scratch, &mut out));
        });
        for precision in Precision::ALL {
            for level in SimdLevel::available() {
                let params = InferParams { simd: Some(level), ..InferParams::of(precision) };
                let prepared = PreparedNet::new(&net, &params).expect("an available level");
                let mut scratch = prepared.scratch();
                group.bench_function(format!("{} {level:?}", precision.name()), |b| {
                    b.iter(|| prepared.forward(&x, &mut scratch, &mut out));
                });
            }
        }
    }
}

fn reductions(c: &mut Criterion) {
    let net = random(&MlpSpec::reconstruction(240, 3211));
    let (low_rank, _) = LowRank::of_weights(&net, 3, 64).expect("a rank below the widths");
    let mut group = c.benchmark_group("F_R reduced");
    let x = [0.5; 240];
    for precision in Precision::ALL {
        let whole = InferParams::of(precision);
        let rank = InferParams { low_rank: vec![low_rank.clone()], ..whole.clone() };
        let part = InferParams { wanted: Some((0..800).collect()), ..whole };
        for (name, params) in [("rank 64", rank), ("800 outputs", part)] {
            let prepared = PreparedNet::new(&net, &params).expect("outputs that are there");
            let (mut scratch, mut out) = (prepared.scratch(), vec![0.0; prepared.n_outputs()]);
            group.bench_function(format!("{} {name}", precision.name()), |b| {
                b.iter(|| prepared.forward(&x, &mut scratch, &mut out));
            });
        }
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = nets, reductions
}
criterion_main!(benches);
