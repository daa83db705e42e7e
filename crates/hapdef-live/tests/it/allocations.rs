//! From a message to the sinks no frame allocates, once everything is warm.
#![allow(unsafe_code, reason = "an allocator that counts")]

use crate::support;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::{Arc, Mutex};

use hapdef_daq::source::ReplaySource;
use hapdef_live::estimator::SearchPlace;
use hapdef_live::{
    AnyError, Delivery, FnSink, Live, LiveEvent, LiveFrame, LiveParams, Sink, Wants,
};
use support::world::World;
use support::{N_GAUGES, bundle, messages, pressed};

struct Counting;

thread_local! {
    static N_ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: every call goes to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let _ = N_ALLOCATIONS.try_with(|n| n.set(n.get() + 1));
        // SAFETY: the caller's promises are passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        // SAFETY: the caller's promises are passed on.
        unsafe { System.dealloc(place, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Runs on the computing thread and notes its allocations at every frame; a health record, each
/// second, may allocate.
struct Watch {
    n_health: u64,
    /// (health records, allocations) so far, frame by frame.
    seen: Arc<Mutex<Vec<(u64, u64)>>>,
}

impl Sink for Watch {
    fn name(&self) -> String {
        "watch".to_owned()
    }

    fn wants(&self) -> Wants {
        Wants::ALL
    }

    fn delivery(&self) -> Delivery {
        Delivery::Direct
    }

    fn frame(&mut self, _: &LiveFrame) -> Result<(), AnyError> {
        let now = (self.n_health, N_ALLOCATIONS.get());
        self.seen.lock().unwrap().push(now);
        Ok(())
    }

    fn event(&mut self, event: &LiveEvent) -> Result<(), AnyError> {
        self.n_health += u64::from(matches!(event, LiveEvent::Health(_)));
        Ok(())
    }
}

#[test]
fn no_frame_allocates() {
    let world = World::new(N_GAUGES, 400, 5);
    let bundle = bundle(&world);
    let readings = pressed(&world, 3000, 3);
    let source = ReplaySource::new("memory", messages(&readings).into_iter(), 0.0);
    let seen = Arc::new(Mutex::new(Vec::with_capacity(4096)));
    let watch = Watch { n_health: 0, seen: Arc::clone(&seen) };
    let slow = FnSink::new("people", Wants::ALL, |_| ());
    let queued = FnSink::new("program", Wants::ALL, |_| ());
    let live = Live::builder(source)
        .bundle(&bundle)
        .params(LiveParams {
            tare_s: 0.2,
            is_recorded: true,
            is_lossless: true,
            ..LiveParams::default()
        })
        .estimator(bundle.tracking(SearchPlace::Never).unwrap())
        .sink(watch)
        .sink(slow)
        .sink(queued.with_delivery(Delivery::Queue(32)))
        .start()
        .unwrap();
    let health = live.wait().unwrap();
    assert_eq!((health.n_frames, health.n_contacts), (3000, 1));
    let seen = seen.lock().unwrap();
    let allocated = |pair: &&[(u64, u64)]| pair[0].0 == pair[1].0 && pair[1].1 > pair[0].1;
    // contacts come and the lists grow in the first 500 frames
    let late = seen.windows(2).skip(500);
    let n = late.clone().filter(allocated).count();
    assert_eq!(n, 0, "{n} of {} frames", late.len());
}
