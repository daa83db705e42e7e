//! exp
mod shell_common;
use hapdef_sim::ShellKind::{self, *};
use shell_common::beams::*;
use shell_common::shells::*;
use shell_common::*;

fn row(name: &str, kind: ShellKind, ns: &[usize], f: impl Fn(ShellKind, Mesh) -> CaseResult) {
    print!("{name:28} {kind:?}");
    for pattern in PATTERNS {
        print!(" |");
        for &n in ns {
            print!(" {:.4}", f(kind, Mesh { n, pattern }).ratio());
        }
    }
    println!();
}

#[test]
fn table() {
    let only = std::env::var("ONLY").unwrap_or_default();
    for kind in [Thin, Thick] {
        let r = |name: &str, ns: &[usize], f: &dyn Fn(ShellKind, Mesh) -> CaseResult| {
            if name.contains(&only) {
                row(name, kind, ns, f);
            }
        };
        let q = [1, 2, 4, 8];
        for (s, sl) in [
            ("rect", rectangle as fn(usize, usize) -> f64),
            ("trap", trapezoid),
            ("para", parallelogram),
        ] {
            r(
                &format!("straight {s} ext"),
                &q[..2],
                &straight(Tip::Extension, sl),
            );
            r(&format!("straight {s} in"), &q, &straight(Tip::InPlane, sl));
            r(
                &format!("straight {s} out"),
                &q,
                &straight(Tip::OutOfPlane, sl),
            );
            r(
                &format!("straight {s} twist"),
                &q,
                &straight(Tip::Twist, sl),
            );
        }
        r("curved in", &q, &curved(false));
        r("curved out", &q, &curved(true));
        r("twisted thick in", &[2, 4, 8], &twisted(false, false));
        r("twisted thick out", &[2, 4, 8], &twisted(false, true));
        r("twisted thin in", &[2, 4, 8], &twisted(true, false));
        r("twisted thin out", &[2, 4, 8], &twisted(true, true));
        r("raasch", &[1, 2, 4, 8], &raasch);
        let s = [4, 8, 16, 32];
        r("scordelis", &s, &scordelis_lo);
        r("cylinder", &s, &pinched_cylinder);
        r("hemisphere", &s, &hemisphere);
        r("le3", &s, &nafems_le3);
        if "hypar".contains(&only) {
            for t in [1e-2, 1e-3, 1e-4, 1e-5] {
                print!("hypar {t:e} {kind:?}");
                for n in [8, 16, 32, 64] {
                    let (w, e) = hypar(
                        kind,
                        Mesh {
                            n,
                            pattern: Pattern::Up,
                        },
                        t,
                    );
                    print!("  {w:.5e} {e:.5e}");
                }
                println!();
            }
        }
    }
}
