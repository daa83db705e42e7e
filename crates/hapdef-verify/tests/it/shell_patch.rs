//! The shells' patch tests: constant membrane strain, shear, curvature and twist on a distorted patch.

use hapdef_verify::{Verdict, all_cases, run_case};

#[test]
fn constant_strains_are_met_on_a_distorted_patch() {
    let patches = all_cases().into_iter();
    let patches =
        patches.filter(|case| case.id().starts_with("shell.") && case.name.contains("patch."));
    let mut n = 0;
    for case in patches {
        let report = run_case(&case);
        assert_eq!(report.verdict, Verdict::Pass, "{}", case.id());
        n += 1;
    }
    assert_eq!(n, 8, "four patches, each thin and thick");
}
