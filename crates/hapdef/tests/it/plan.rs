//! The plan of a scene: what runs, what is left out, and that the run follows it.

use std::fs;
use std::path::{Path, PathBuf};

use hapdef::plan::{Plan, PlanStep, Rates, StepState, When, pipeline_parts_s, plan};
use hapdef::stages::compliance;
use hapdef::touch::{Calibration, touch_estimator};
use hapdef::{Limb, Profile, Progress, Run};
use serde_json::{Value, json};

fn shin() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/shin")
}

/// A bundled scene, changed, with the run's results beside it.
fn prepared(folder: &Path, scene: &str, change: impl FnOnce(&mut Value)) -> (Run, Limb) {
    let mut scene: Value = serde_json::from_slice(&fs::read(shin().join(scene)).unwrap()).unwrap();
    change(&mut scene);
    let path = folder.join("scene.json");
    fs::write(&path, scene.to_string()).unwrap();
    fs::copy(shin().join("shin.inp.gz"), folder.join("shin.inp.gz")).unwrap();
    let out = folder.join("out");
    let run = Run::new(&path, Profile::quick(), &out, 2, Progress::silent()).unwrap();
    let limb = Limb::load(&run.scene, &run.scene_dir).unwrap();
    (run, limb)
}

fn names(plan: &Plan, state: StepState) -> Vec<&str> {
    let steps = plan.steps.iter().filter(|step| step.state == state);
    steps.map(|step| step.name.as_str()).collect()
}

/// Every step that runs has an expected time.
fn assert_times(plan: &Plan) {
    let runs = plan.steps.iter().filter(|s| s.state == StepState::Runs);
    for step in runs {
        assert!(step.predicted_s.unwrap() > 0.0, "{step:?}");
    }
}

#[test]
fn the_papers_chain_is_planned_in_full_and_nothing_is_made() {
    let folder = tempfile::tempdir().unwrap();
    let (run, limb) = prepared(folder.path(), "scene.json", |_| {});
    let parts_s = pipeline_parts_s(&run, &limb, &Rates::default()).unwrap();
    let plan = plan(&run, &limb, &Rates::default()).unwrap();
    let elastic = ["compliance", "rig"].map(|name| plan.step(name).unwrap().predicted_s.unwrap());
    for (part_s, step_s) in parts_s.iter().zip(elastic) {
        assert!((part_s / step_s - 1.0).abs() < 0.5, "{parts_s:?} {elastic:?}");
    }
    // The pipeline trains more nets than the chain needs.
    assert!(parts_s.iter().sum::<f64>() > plan.predicted_s(), "{parts_s:?}");
    assert_eq!(
        names(&plan, StepState::Runs),
        [
            "compliance",
            "rig",
            "set I",
            "set II",
            "set III",
            "set IV",
            "rig's single presses",
            "rig's double presses",
            "transfer",
            "reconstruction-4",
            "sensitivity",
            "pass of transfer",
            "pass of reconstruction-4",
            "pass of sensitivity",
            "k-Max",
        ]
    );
    assert_eq!(
        names(&plan, StepState::Skipped),
        [
            "loads on nodes that nothing touches",
            "tangential loads",
            "reconstruction-1",
            "reconstruction-2",
            "reconstruction-3",
            "direct",
            "eval",
            "scan and pair search",
        ]
    );
    let design = |step: &&PlanStep| step.when == When::Design;
    let runs = plan.steps.iter().filter(design);
    let runs = runs.filter(|step| step.state == StepState::Runs);
    for step in runs {
        assert!(step.flops > 0.0 && step.bytes > 0.0, "{step:?}");
    }
    assert_times(&plan);
    assert!(!folder.path().join("out").exists());
}

/// The sizes are those that the stage then has, and a finished stage is found.
#[test]
fn the_plan_has_the_sizes_of_the_run_and_finds_it_in_the_cache() {
    let folder = tempfile::tempdir().unwrap();
    let (run, limb) = prepared(folder.path(), "scene.json", |scene| {
        scene["contact"]["region"]["axial_range_m"] = json!([0.1, 0.12]);
    });
    let before = plan(&run, &limb, &Rates::default()).unwrap();
    let stage = compliance(&run, &limb).unwrap();
    let sizes = &before.step("compliance").unwrap().sizes;
    for (planned, made) in [
        ("FE nodes", "n_fe_nodes"),
        ("equations", "n_equations"),
        ("non-zeros of L", "nnz_l"),
        ("wanted nodes", "n_wanted_nodes"),
    ] {
        assert_eq!(Some(sizes[planned]), stage.record.info[made].as_u64(), "{planned}");
    }
    let after = plan(&run, &limb, &Rates::default()).unwrap();
    assert_eq!(names(&after, StepState::Cached), ["compliance"]);
    let step = after.step("compliance").unwrap();
    assert_eq!((step.recorded_s, step.flops), (Some(stage.record.elapsed_s), 0.0));
}

#[test]
fn a_single_contact_leaves_out_the_sets_of_several() {
    let folder = tempfile::tempdir().unwrap();
    let (run, limb) = prepared(folder.path(), "scene.json", |scene| {
        scene["contact"]["max_contacts"] = json!(1);
    });
    let plan = plan(&run, &limb, &Rates::default()).unwrap();
    let skipped = names(&plan, StepState::Skipped);
    for name in ["set II", "set III", "set IV", "rig's double presses"] {
        assert!(skipped.contains(&name), "{name} is not in {skipped:?}");
        assert_eq!(plan.step(name).unwrap().why, "contact.max_contacts is 1");
    }
    assert!(names(&plan, StepState::Runs).contains(&"reconstruction-1"));
}

#[test]
fn superposition_solves_an_adjoint_for_each_gauge_and_no_more() {
    let folder = tempfile::tempdir().unwrap();
    let (run, limb) = prepared(folder.path(), "placed.json", |_| {});
    let plan = plan(&run, &limb, &Rates::default()).unwrap();
    assert_eq!(
        names(&plan, StepState::Runs),
        ["response", "χ² test", "scan for one contact", "pair search", "a contact followed"]
    );
    assert_times(&plan);
    assert_eq!(plan.step("response").unwrap().sizes["right-hand sides"], 10);
    let skipped = names(&plan, StepState::Skipped);
    for name in [
        "a load at every node",
        "compliance",
        "rig",
        "datasets",
        "nets",
        "search while nothing touches",
    ] {
        assert!(skipped.contains(&name), "{name} is not in {skipped:?}");
    }
    touch_estimator(&run, &limb).unwrap();
    assert!(!folder.path().join("out").exists(), "a stage ran that the plan leaves out");
}

/// A calibration of the right form at seven sites.
fn calibration(run: &Run, limb: &Limb) -> Calibration {
    let (n_gauges, n_sites) = (limb.gauges.len(), 7);
    Calibration {
        version: 1,
        scene: run.scene.name.clone(),
        deck_hash: limb.deck_hash.clone(),
        presses_hash: String::new(),
        n_presses: 0,
        n_used: 0,
        relative_error: 0.01,
        relative_error_before: 0.1,
        noise_ue: 1.0,
        n_gauges,
        n_sites,
        adjoint_ue_per_n: vec![[1.0; 3]; n_gauges * limb.n_surface_nodes()],
        site_error: vec![0.0; n_sites * n_gauges * n_gauges],
        place_factor: 1.0,
        since: None,
    }
}

/// Without a comparison the deck's ribs speak, with one its figures; the plan says which.
#[test]
fn a_map_that_is_wanted_is_solved_and_one_that_is_not_says_why() {
    let folder = tempfile::tempdir().unwrap();
    let planned = |outputs: &str| {
        let (run, limb) = prepared(folder.path(), "placed.json", |scene| {
            scene["outputs"] = outputs.into();
        });
        let plan = plan(&run, &limb, &Rates::default()).unwrap();
        plan.step("compliance").unwrap().clone()
    };
    let (of_map, of_contacts) = (planned("map"), planned("contacts"));
    assert_eq!(of_map.state, StepState::Runs);
    assert!(of_map.sizes["right-hand sides"] > 3000, "{of_map:?}");
    assert!(of_map.predicted_s.unwrap() > 0.0 && of_map.flops > 0.0);
    assert_eq!(of_contacts.state, StepState::Skipped);
    assert_eq!((of_contacts.predicted_s, of_contacts.flops), (None, 0.0));
    assert!(of_contacts.why.contains("outputs is contacts"), "{of_contacts:?}");
}

#[test]
fn the_plan_says_whether_a_shell_would_do_and_how_it_knows() {
    let folder = tempfile::tempdir().unwrap();
    let (run, limb) = prepared(folder.path(), "placed.json", |_| {});
    let results = folder.path().join("results");
    let why = || {
        let made = plan(&run, &limb, &Rates::default()).unwrap();
        let advised = made.with_shell_advice(&limb, limb.max_wall_m, &results);
        let advised = advised.unwrap();
        let step = advised.step("shell model instead").unwrap();
        assert_eq!((step.state, step.when), (StepState::Alternative, When::Design));
        step.why.clone()
    };
    let by_wall = why();
    assert!(by_wall.starts_with("use the solid"), "{by_wall}");
    assert!(by_wall.contains("not compared"), "{by_wall}");
    let report = |name: &str, deck: &str, readings: f64| {
        let median = |m: f64| json!({ "median": m });
        let report = json!({
            "source": { "file": name, "file_hash": "", "scene": null },
            "parameters": { "wall": "1.00 mm" },
            "comparisons": [{
                "deck_hash": deck,
                "shell": { "readings": median(readings), "tip": median(0.05) },
            }],
        });
        let path = results.join(name);
        fs::create_dir_all(&path).unwrap();
        fs::write(path.join("shell-report.json"), report.to_string()).unwrap();
    };
    report("other-deck", "0", 0.01);
    assert_eq!(why(), by_wall);
    report("poor", &limb.deck_hash, 4.486);
    let poor = why();
    assert!(poor.starts_with("use the solid"), "{poor}");
    assert!(poor.contains("448.6 %") && poor.contains("poor"), "{poor}");
    report("good", &limb.deck_hash, 0.02);
    let good = why();
    assert!(good.starts_with("a shell would do"), "{good}");
    assert!(good.contains("5.0 %") && good.contains("good"), "{good}");
}

#[test]
fn one_contact_needs_no_pair_search_and_a_calibration_no_solve() {
    let folder = tempfile::tempdir().unwrap();
    let (run, limb) = prepared(folder.path(), "placed.json", |scene| {
        scene["contact"]["max_contacts"] = json!(1);
        scene["estimator"]["calibration"] = json!("calibration.json");
    });
    let missing = plan(&run, &limb, &Rates::default()).unwrap_err();
    assert!(missing.to_string().contains("calibration.json"), "{missing}");
    let calibration = calibration(&run, &limb);
    calibration.write(&folder.path().join("calibration.json")).unwrap();
    let plan = plan(&run, &limb, &Rates::default()).unwrap();
    assert_eq!(plan.step("scan for one contact").unwrap().sizes["sites"], 7);
    let pairs = plan.step("pair search").unwrap();
    assert_eq!((pairs.state, pairs.flops), (StepState::Skipped, 0.0));
    assert_eq!(pairs.why, "contact.max_contacts is 1");
    let runs = names(&plan, StepState::Runs);
    assert_eq!(runs, ["calibration", "χ² test", "scan for one contact", "a contact followed"]);
    assert!(names(&plan, StepState::Skipped).contains(&"response"));
}

/// A calibration is planned with its presses: more of them take longer, and it is measured against the
/// plan where a person asks.
#[test]
fn a_calibration_is_planned_with_its_presses() {
    let folder = tempfile::tempdir().unwrap();
    let (run, limb) = prepared(folder.path(), "placed.json", |scene| {
        scene["estimator"]["map_refinements"] = json!(0);
    });
    let bare = plan(&run, &limb, &Rates::default()).unwrap();
    let planned = |n_presses| {
        let with = bare.clone();
        let with = with.with_calibration(&run, &limb, &Rates::default(), n_presses);
        with.unwrap().step("hapdef calibrate").unwrap().clone()
    };
    let (few, many) = (planned(300), planned(3000));
    assert_eq!((few.when, few.sizes["presses"]), (When::Design, 300));
    let times = [few, many].map(|step| step.predicted_s.unwrap());
    let response_s = bare.step("response").unwrap().predicted_s.unwrap();
    assert!(response_s < times[0] && times[0] < times[1], "{times:?}");
}
