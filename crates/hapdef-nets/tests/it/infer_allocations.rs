//! A pass through a prepared net allocates nothing, from the first one on.

#![allow(
    unsafe_code,
    clippy::unwrap_used,
    reason = "counting allocations takes an allocator; each call is handed on as it came"
)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use hapdef_nets::infer::{InferParams, LowRank, Precision, PreparedNet};
use hapdef_nets::{Mlp, MlpSpec, Net, Scale};

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: every call goes to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let _ = ALLOCATIONS.try_with(|n| n.set(n.get() + 1));
        // SAFETY: the caller's promises are handed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller's promises are handed on.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn a_pass_allocates_nothing() {
    let spec = MlpSpec::reconstruction(24, 301);
    let net = Net::new(Mlp::random(&spec, 1).unwrap(), Scale::identity(24), Scale::identity(301))
        .unwrap();
    let (low_rank, _) = LowRank::of_weights(&net, 3, 8).unwrap();
    for precision in Precision::ALL {
        for low_rank in [vec![], vec![low_rank.clone()]] {
            let params = InferParams { low_rank, ..InferParams::of(precision) };
            let prepared = PreparedNet::new(&net, &params).unwrap();
            let (mut scratch, mut out) = (prepared.scratch(), vec![0.0; 301]);
            let before = ALLOCATIONS.get();
            prepared.forward(&[0.5; 24], &mut scratch, &mut out).unwrap();
            assert_eq!(ALLOCATIONS.get(), before, "{precision:?}");
        }
    }
}
