//! The simulated hardware against the elastic model it is a perturbation of.

use hapdef_mesh::{FeNodeId, SkinRegion, Tet10Mesh, kuhn_block};
use hapdef_rig::{
    GainParams, MisplacementParams, NominalLimb, NominalLoads, RealLimb, RigError, RigParams,
    VariationParams,
};
use hapdef_sim::{
    ElasticModel, ElasticParams, GaugeParams, GaugeSite, GaugeStrain, IsotropicMaterial, NodalLoad,
};
use nalgebra::{Point3, Vector3};

/// Cells of the plate in x, y and z, and its size, m.
const CELLS: [usize; 3] = [10, 6, 1];
const SIZE_M: [f64; 3] = [0.04, 0.024, 0.001];

/// A plate of 40 × 24 × 1 mm in `cells` cells.
fn plate(cells: [usize; 3]) -> Tet10Mesh {
    let size_m = Vector3::from(SIZE_M);
    kuhn_block(cells, |p| p.coords.component_mul(&size_m).into()).unwrap()
}

struct Bench {
    mesh: Tet10Mesh,
    clamped: Vec<FeNodeId>,
    skin: SkinRegion,
    gauges: Vec<GaugeSite>,
}

impl Bench {
    /// Held at x = 0, touched on top, one gauge below.
    fn new() -> Self {
        Self::meshed(CELLS)
    }

    fn meshed(cells: [usize; 3]) -> Self {
        let mesh = plate(cells);
        let at = |keep: &dyn Fn(&Point3<f64>) -> bool| {
            let nodes = mesh.nodes().iter().enumerate().filter(|(_, x)| keep(x));
            nodes.map(|(i, _)| FeNodeId::from_index(i)).collect::<Vec<_>>()
        };
        let clamped = at(&|x| x.x < 1e-9);
        let top = at(&|x| x.z > SIZE_M[2] - 1e-9);
        let faces = mesh.boundary().faces;
        let faces = faces.into_iter().filter(|f| f.nodes.iter().all(|n| top.contains(n))).collect();
        let skin = SkinRegion::new(&mesh, faces).unwrap();
        let gauge = GaugeSite {
            position: Point3::new(0.014, 0.012, 0.0),
            axis: Vector3::x(),
            length_m: 8e-3,
            width_m: 5e-3,
        };
        Self { mesh, clamped, skin, gauges: vec![gauge] }
    }

    fn nominal(&self) -> NominalLimb<'_> {
        NominalLimb {
            mesh: &self.mesh,
            clamped: &self.clamped,
            material: IsotropicMaterial::new(1.7e9, 0.394, 930.0).unwrap(),
            gauges: &self.gauges,
            gauge_params: GaugeParams::default(),
            skin: &self.skin,
            tip_radius_m: 0.002,
            loads: NominalLoads::default(),
        }
    }

    fn readings(&self, params: &RigParams) -> Vec<f64> {
        let real = RealLimb::build(&self.nominal(), params, 1).unwrap();
        presses()
            .iter()
            .map(|point| real.response_ue_per_n(point, &-Vector3::z()).unwrap()[0])
            .collect()
    }
}

fn presses() -> [Point3<f64>; 3] {
    [[0.03, 0.012], [0.024, 0.006], [0.036, 0.018]].map(|[x, y]| Point3::new(x, y, SIZE_M[2]))
}

fn unperturbed() -> RigParams {
    let none = |seed| VariationParams { fraction: 0.0, correlation_length_m: 0.02, seed };
    RigParams {
        refinements: 1,
        max_off_skin_m: None,
        stiffness: none(1),
        thickness: none(2),
        max_wall_m: 0.003,
        misplacement: MisplacementParams { shift_m: 0.0, turn_rad: 0.0, seed: 3 },
        gain: GainParams { fraction: 0.0, seed: 4 },
    }
}

/// Without perturbation the rig is the plain elastic model of the refined mesh.
#[test]
fn an_unperturbed_rig_is_the_refined_elastic_model() {
    let bench = Bench::new();
    let mesh = bench.mesh.refine();
    let at = |keep: &dyn Fn(&Point3<f64>) -> bool| {
        let nodes = mesh.nodes().iter().enumerate().filter(|(_, x)| keep(x));
        nodes.map(|(i, _)| FeNodeId::from_index(i)).collect::<Vec<_>>()
    };
    let params = ElasticParams::new(bench.nominal().material, at(&|x| x.x < 1e-9));
    let elastic_model = ElasticModel::build(&mesh, &params).unwrap();
    let boundary = mesh.boundary();
    let gauge = GaugeStrain::new(&mesh, &boundary.faces, &bench.gauges[0]).unwrap();
    let top = at(&|x| x.z > SIZE_M[2] - 1e-9);
    let faces = boundary.faces.iter().filter(|f| f.nodes.iter().all(|n| top.contains(n)));
    let skin = SkinRegion::new(&mesh, faces.copied().collect()).unwrap();
    for (point, reading) in presses().iter().zip(bench.readings(&unperturbed())) {
        let load = NodalLoad::patch(&mesh, &skin, point, 0.002, &-Vector3::z()).unwrap();
        let (displacement, _) = elastic_model.solve(&load).unwrap();
        let expected = gauge.strain(&displacement) * 1e6;
        let error = (reading / expected - 1.0).abs();
        assert!(error < 1e-8, "{reading} µε/N, forward solve {expected}");
    }
}

/// A cantilever's bending strain below, ε = 6 F l / (E b t²), within the width effects of a plate.
#[test]
fn the_strain_is_that_of_a_bent_plate() {
    let reading = Bench::new().readings(&unperturbed())[0];
    let beam = -6.0 * (0.030 - 0.014) / (1.7e9 * 0.024 * 1e-6) * 1e6;
    assert!((reading / beam - 1.0).abs() < 0.15, "{reading} µε/N, beam {beam}");
}

#[test]
fn each_perturbation_acts_by_about_its_size() {
    let bench = Bench::new();
    let plain = bench.readings(&unperturbed());
    let change = |params: &RigParams| {
        let perturbed = bench.readings(params);
        let changes = plain.iter().zip(&perturbed).map(|(a, b)| (b / a - 1.0).abs());
        changes.fold(0.0, f64::max)
    };
    let varied = |fraction| VariationParams { fraction, correlation_length_m: 0.02, seed: 5 };
    let soft = change(&RigParams { stiffness: varied(0.1), ..unperturbed() });
    assert!((0.001..0.13).contains(&soft), "stiffness ±10 % changed readings by {soft}");
    let thick = change(&RigParams { thickness: varied(0.05), ..unperturbed() });
    assert!((0.001..0.2).contains(&thick), "thickness ±5 % changed readings by {thick}");
    let misplacement = MisplacementParams { shift_m: 1e-3, turn_rad: 0.05, seed: 6 };
    let moved = change(&RigParams { misplacement, ..unperturbed() });
    assert!((0.001..0.3).contains(&moved), "1 mm and 3° changed readings by {moved}");
    let gain = change(&RigParams { gain: GainParams { fraction: 0.03, seed: 7 }, ..unperturbed() });
    assert!((1e-6..=0.03 + 1e-12).contains(&gain), "gain ±3 % changed readings by {gain}");
}

/// On a mesh of its own the plate answers as on the other's refined one, but for the meshes' errors;
/// places beside its skin go to it, those far from it are refused.
#[test]
fn a_mesh_of_its_own_answers_alike() {
    let params = RigParams { refinements: 0, max_off_skin_m: Some(5e-4), ..unperturbed() };
    let own = Bench::meshed([17, 11, 2]);
    let real = RealLimb::build(&own.nominal(), &params, 1).unwrap();
    let refined = Bench::new().readings(&unperturbed());
    let off = Vector3::new(0.0, 0.0, 3e-4);
    for (point, refined) in presses().iter().zip(refined) {
        let at = |p: &Point3<f64>| real.response_ue_per_n(p, &-Vector3::z()).map(|r| r[0]);
        let found = at(point).unwrap();
        assert!((found / refined - 1.0).abs() < 0.02, "{found} and {refined}");
        assert!(found != refined);
        assert!((at(&(point + off)).unwrap() / found - 1.0).abs() < 1e-12);
        let refused = at(&(point + 2.0 * off)).unwrap_err();
        assert!(matches!(refused, RigError::OffSkin { .. }), "{refused}");
    }
}

#[test]
fn seeds_decide_the_perturbation() {
    let bench = Bench::new();
    let with = |seed| {
        let stiffness = VariationParams { fraction: 0.1, correlation_length_m: 0.02, seed };
        bench.readings(&RigParams { stiffness, ..unperturbed() })
    };
    assert_eq!(with(1), with(1));
    assert_ne!(with(1), with(2));
}

/// At the plate's edge the nominal gauge lies below; where the real plate is thicker its side is
/// nearer, which has no room for a gauge. Glued a little inwards it fits all the same.
#[test]
fn a_gauge_at_an_edge_that_moved_is_glued_beside_it() {
    let mut bench = Bench::new();
    bench.gauges[0].position.y = 0.0;
    for seed in 0..8 {
        let params = RigParams {
            thickness: VariationParams { fraction: 0.1, correlation_length_m: 0.02, seed },
            misplacement: MisplacementParams { shift_m: 1e-3, turn_rad: 0.05, seed },
            ..unperturbed()
        };
        let nominal = NominalLimb {
            gauge_params: GaugeParams { max_lost_share: 0.5, ..GaugeParams::default() },
            ..bench.nominal()
        };
        let real = RealLimb::build(&nominal, &params, 1).unwrap();
        let reading = real.response_ue_per_n(&presses()[0], &-Vector3::z()).unwrap()[0];
        assert!(reading < -1.0, "seed {seed}: {reading} µε/N");
    }
}
