//! The shell elements on the benchmarks that engineers know, on regular and distorted meshes.

mod shell_common;

use hapdef_sim::ShellKind::{self, Thick, Thin};
use shell_common::beams::{
    PATTERNS, Tip, curved, parallelogram, raasch, rectangle, straight, trapezoid, twisted,
};
use shell_common::shells::{hemisphere, nafems_le3, pinched_cylinder, scordelis_lo};
use shell_common::{CaseResult, Mesh};

/// Prints value / reference for all meshes, and asserts the finest ones within 1 % and no worse
/// than the coarsest.
#[track_caller]
fn check(
    name: &str,
    kinds: &[ShellKind],
    ns: &[usize],
    case: impl Fn(ShellKind, Mesh) -> CaseResult,
) {
    let mut missed = Vec::new();
    for &kind in kinds {
        for pattern in PATTERNS {
            let ratios: Vec<f64> = ns
                .iter()
                .map(|&n| case(kind, Mesh { n, pattern }).ratio())
                .collect();
            println!("{name:24} {kind:?} {pattern:?} n {ns:?}: {ratios:.4?}");
            let error = |r: f64| (r - 1.0).abs();
            let finest = error(ratios[ratios.len() - 1]);
            if finest > 0.01 {
                missed.push(format!("{kind:?} {pattern:?} {ratios:.4?}"));
            }
        }
    }
    assert!(
        missed.is_empty(),
        "{name} misses by more than 1 %: {missed:?}"
    );
}

const BOTH: [ShellKind; 2] = [Thin, Thick];

#[test]
fn straight_cantilever() {
    for (cells, slant) in [
        ("rectangles", rectangle as fn(usize, usize) -> f64),
        ("trapezoids", trapezoid),
        ("parallelograms", parallelogram),
    ] {
        let name = |load: &str| format!("straight {load} {cells}");
        let ns = [1, 4, 16];
        check(
            &name("extension"),
            &BOTH,
            &ns,
            straight(Tip::Extension, slant),
        );
        check(&name("in plane"), &BOTH, &ns, straight(Tip::InPlane, slant));
        check(
            &name("out of plane"),
            &BOTH,
            &ns,
            straight(Tip::OutOfPlane, slant),
        );
    }
}

#[test]
fn straight_cantilever_in_torsion() {
    check(
        "straight twist",
        &[Thick],
        &[4, 8, 16, 32],
        straight(Tip::Twist, rectangle),
    );
}

#[test]
fn curved_beam() {
    check("curved in plane", &BOTH, &[2, 8, 16], curved(false));
    check(
        "curved out of plane",
        &[Thick],
        &[2, 8, 16, 32],
        curved(true),
    );
}

#[test]
fn twisted_beam() {
    for thin in [false, true] {
        for out in [false, true] {
            let name = format!("twisted thin {thin} out {out}");
            check(&name, &BOTH, &[2, 4, 8, 16], twisted(thin, out));
        }
    }
}

#[test]
fn raasch_hook() {
    check("raasch hook", &[Thick], &[1, 2, 4, 8, 16], raasch);
}

#[test]
fn scordelis_lo_roof() {
    check("scordelis-lo", &BOTH, &[4, 8, 16, 32], scordelis_lo);
}

#[test]
fn pinched_cylinder_with_diaphragms() {
    check(
        "pinched cylinder",
        &BOTH,
        &[8, 16, 32, 64],
        pinched_cylinder,
    );
}

#[test]
fn hemisphere_with_hole() {
    check("hemisphere", &BOTH, &[4, 8, 16, 32, 64], hemisphere);
}

#[test]
fn nafems_le3_hemisphere() {
    check("nafems le3", &BOTH, &[4, 8, 16, 32], nafems_le3);
}
