//! What is left out of the paper's chain: its datasets, nets and contacts are the same to the last bit,
//! each made in a cache of its own.

use std::fs;
use std::path::Path;

use hapdef::scene::{ContactRegion, EstimatorSpec, RigMesh};
use hapdef::stages::NetKind;
use hapdef::touch::{Touch, chain_stages, response_map, touch_estimator};
use hapdef::{Limb, Pipeline, Run, Stage, Until};
use hapdef_inverse::SkinPoint;

use super::{loaded, run_of};

/// A scene on a part of the skin, with a rig of the limb's own elements, few samples and short trainings.
fn small(scene: &str, out: &Path, max_contacts: usize) -> (Run, Limb) {
    let mut run = run_of(scene, out);
    run.scene.contact.max_contacts = max_contacts;
    if let ContactRegion::Radial { axial_range_m, .. } = &mut run.scene.contact.region {
        *axial_range_m = [0.09, 0.12];
    }
    let solid_deck = run.scene.geometry.shape.file().to_owned();
    run.scene.rig.mesh = RigMesh::Deck { solid_deck, refinements: 0 };
    let profile = &mut run.profile;
    (profile.n_single, profile.n_multi, profile.n_real_single) = (200, 100, 200);
    (profile.n_pairs, profile.n_amplitudes, profile.n_svr) = (10, 4, 50);
    for schedule in [
        &mut profile.transfer,
        &mut profile.reconstruction,
        &mut profile.sensitivity,
        &mut profile.direct,
    ] {
        (schedule.steps, schedule.batch) = (40, 20);
    }
    let limb = loaded(&run);
    (run, limb)
}

/// Files of two stages that must be the same, `stage.json` with its times left out.
fn assert_same(a: &Stage, b: &Stage) {
    assert!(!a.cached && !b.cached && a.dir != b.dir);
    let names = |stage: &Stage| {
        let entries = fs::read_dir(&stage.dir).unwrap();
        let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<String> = names.filter(|name| name != "stage.json").collect();
        names.sort();
        names
    };
    assert_eq!(names(a), names(b));
    assert!(!names(a).is_empty());
    for name in names(a) {
        let [x, y] = [a, b].map(|stage| fs::read(stage.dir.join(&name)).unwrap());
        assert!(x == y, "{name} of {} differs", a.record.stage);
    }
}

/// Two contacts at most, the nets of the chain alone; and four, with all nets and their scores: sets
/// and nets that both have are equal.
#[test]
pub(crate) fn sets_nets_and_scores_that_are_left_out_change_no_other() {
    let folders = [(); 2].map(|()| tempfile::tempdir().unwrap());
    let (run, limb) = small("scene.json", folders[0].path(), 2);
    let lean = chain_stages(&run, &limb).unwrap();
    let (run, limb) = small("scene.json", folders[1].path(), 4);
    let full = Pipeline::run(&run, &limb, Until::Eval).unwrap();
    assert!(full.eval.is_some());
    assert_same(&lean.compliance, &full.compliance);
    assert_same(&lean.rig, &full.rig);
    let (data, nets) = (full.data.unwrap(), full.nets.unwrap());
    assert_eq!((lean.data.simulated.len(), data.simulated.len()), (2, 4));
    for (of_two, of_four) in lean.data.simulated.iter().zip(&data.simulated) {
        assert_same(of_two, of_four);
    }
    assert_same(&lean.data.rig_single, &data.rig_single);
    assert!(nets.nets.len() > lean.nets.nets.len());
    let union = NetKind::Reconstruction { n_sets: 2 };
    assert!(lean.nets.nets.iter().any(|net| net.kind == union));
    for net in &lean.nets.nets {
        let same = nets.nets.iter().find(|other| other.kind == net.kind);
        assert_same(&net.stage, &same.unwrap().stage);
    }
}

/// Contacts by superposition are those of a run that has made the paper's chain as well, and the
/// chain's those of a run that has solved a response: neither needs anything of the other.
#[test]
pub(crate) fn each_estimator_needs_nothing_of_the_other() {
    let folders = [(); 3].map(|()| tempfile::tempdir().unwrap());
    let (mut run, limb) = small("placed.json", folders[0].path(), 4);
    let map = response_map(&limb, run.scene.contact.tip_radius_m, 2).unwrap();
    let superposed = run.scene.estimator.clone();
    let chain = EstimatorSpec::Hapdefx(superposed.hapdefx());
    let readings = |face: usize| -> Vec<f64> {
        let point = SkinPoint::new(map.skin(), face, [0.5, 0.3, 0.2]).unwrap();
        map.normal(&point).iter().map(|g| 20.0 * g).collect()
    };
    let mut found = |out: &Path, specs: &[&EstimatorSpec]| {
        run.cache = hapdef::Cache::new(out.join("cache"));
        let mut touch = Touch::default();
        let mut contacts = Vec::new();
        for spec in specs {
            run.scene.estimator = (*spec).clone();
            let mut estimator = touch_estimator(&run, &limb).unwrap();
            contacts.clear();
            for face in [50, 150, 250] {
                estimator.estimate(&readings(face), &mut touch).unwrap();
                let found = touch.contacts.iter().map(|c| (c.position_m, c.force_n));
                contacts.extend(found);
            }
        }
        contacts
    };
    let alone = found(folders[0].path(), &[&superposed]);
    assert!(alone.len() >= 3);
    assert!(!folders[0].path().join("cache").exists(), "a stage ran");
    assert_eq!(alone, found(folders[1].path(), &[&chain, &superposed]));
    let paper = found(folders[2].path(), &[&chain]);
    assert_eq!(paper, found(folders[1].path(), &[&superposed, &chain]));
}
