//! The solver's parts on a ribbed box: build, one load, many loads, adjoints, shell elements.
//!
//! ```text
//! cargo bench --bench solver
//! ```
#![expect(missing_docs, reason = "criterion's macros make undocumented items")]

use criterion::{Criterion, criterion_group, criterion_main};
use hapdef_mesh::{FeNodeId, Shin, ShinParams, shin};
use hapdef_sim::{
    ComplianceParams, ElasticModel, ElasticParams, IsotropicMaterial, NodalLoad, ShellKind,
    shell_stiffness,
};
use nalgebra::{Point3, Vector3};

fn limb() -> (Shin, ElasticParams) {
    let limb = shin(&ShinParams::default()).expect("the bundled limb");
    let material = IsotropicMaterial::new(1.7e9, 0.394, 930.0).expect("PA2200");
    let params = ElasticParams {
        n_threads: 2,
        ..ElasticParams::new(material, limb.deck.fixed_nodes.clone())
    };
    (limb, params)
}

fn unit_loads(nodes: &[FeNodeId]) -> Vec<NodalLoad> {
    let load = |node: &FeNodeId| NodalLoad::nodal(*node, Vector3::y());
    nodes.iter().map(load).collect()
}

fn solids(c: &mut Criterion) {
    let (limb, params) = limb();
    let mesh = &limb.deck.mesh;
    let mut group = c.benchmark_group("shin, 61,839 equations");
    group.sample_size(10);
    group.bench_function("build", |b| b.iter(|| ElasticModel::build(mesh, &params)));
    let model = ElasticModel::build(mesh, &params).expect("supported");
    let all = unit_loads(&limb.skin.nodes);
    group.bench_function("one load", |b| b.iter(|| model.solve(&all[0])));
    let wanted = &limb.skin.nodes;
    let limits = ComplianceParams::default();
    for n in [10, 240] {
        group.bench_function(format!("{n} loads"), |b| {
            b.iter(|| model.compliance(&all[..n], wanted, &limits));
        });
    }
    group.finish();
}

fn shells(c: &mut Criterion) {
    let material = IsotropicMaterial::new(1.7e9, 0.394, 930.0).expect("PA2200");
    let corners =
        [Point3::new(0.0, 0.0, 0.0), Point3::new(4e-3, 1e-3, 0.0), Point3::new(1e-3, 3e-3, 1e-3)];
    for kind in [ShellKind::Thin, ShellKind::Thick] {
        c.bench_function(&format!("{kind:?} shell element"), |b| {
            b.iter(|| shell_stiffness(kind, &corners, None, &[1e-3; 3], &material));
        });
    }
}

criterion_group!(benches, solids, shells);
criterion_main!(benches);
