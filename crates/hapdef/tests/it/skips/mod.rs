//! What a scene leaves out changes nothing that it wants: each skip of the plan, with and without.

mod chain;
mod frames;

mod solves;

use std::collections::BTreeSet;
use std::path::Path;

use hapdef::plan::{Rates, Skip, StepState, plan};
use hapdef::scene::Scene;
use hapdef::{Limb, Profile, Progress, Run};

fn run_of(scene: &str, out: &Path) -> Run {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/shin");
    Run::new(&path.join(scene), Profile::quick(), out, 2, Progress::silent()).unwrap()
}

fn loaded(run: &Run) -> Limb {
    Limb::load(&run.scene, &run.scene_dir).unwrap()
}

/// The test that proves a skip; a new one without a proof does not compile.
fn proof(skip: Skip) -> fn() {
    match skip {
        Skip::UntouchedNodes => solves::nodes_that_nothing_touches_change_no_other,
        Skip::TangentialLoads => solves::loads_that_are_left_out_change_no_other,
        Skip::LoadsAtEveryNode => solves::adjoint_solves_read_what_a_load_at_every_node_reads,
        Skip::CalibratedResponse => {
            solves::a_calibration_leaves_out_the_response_and_changes_no_contact
        }
        Skip::LargerSets | Skip::OtherNets | Skip::Scores => {
            chain::sets_nets_and_scores_that_are_left_out_change_no_other
        }
        Skip::OtherEstimator | Skip::UnwantedMap => {
            chain::each_estimator_needs_nothing_of_the_other
        }
        Skip::Friction | Skip::UnwantedPairs => {
            frames::pair_search_and_friction_change_no_single_contact
        }
        Skip::UncarriedPairs => frames::gauges_that_carry_one_contact_find_it_without_pairs,
        Skip::UntouchedFrames => frames::the_test_for_a_touch_changes_no_contact,
    }
}

/// Every step that a plan leaves out says which skip it is, and no other step does; between them the
/// bundled scenes, with one contact and with few gauges, leave out all but what a calibration has,
/// which `tests/plan.rs` plans.
#[test]
fn every_step_left_out_is_a_skip_with_a_proof() {
    let out = tempfile::tempdir().unwrap();
    let skips_of = |scene: &str, change: fn(&mut Scene)| {
        let mut run = run_of(scene, out.path());
        change(&mut run.scene);
        let steps = plan(&run, &loaded(&run), &Rates::default()).unwrap().steps;
        for step in &steps {
            assert_eq!(step.skip.is_some(), step.state == StepState::Skipped, "{step:?}");
        }
        let skips: Vec<Skip> = steps.iter().filter_map(|step| step.skip).collect();
        skips
    };
    let all = [
        skips_of("scene.json", |scene| scene.contact.max_contacts = 1),
        skips_of("placed.json", |scene| scene.contact.max_contacts = 1),
        skips_of("placed.json", |scene| scene.gauges.sites.truncate(5)),
    ];
    let all = all.concat();
    for skip in &all {
        let _: fn() = proof(*skip);
    }
    let names: BTreeSet<String> = all.iter().map(|skip| format!("{skip:?}")).collect();
    assert_eq!(names.len(), 12, "{names:?}");
}
