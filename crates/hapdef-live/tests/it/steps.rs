//! The runtime without threads.

use std::sync::{Arc, Mutex};

use hapdef_daq::source::ReplaySource;
use hapdef_live::estimator::SearchPlace;
use hapdef_live::{
    AnyError, Delivery, FnSink, Live, LiveBuilder, LiveEvent, LiveFrame, LiveParams, Sink, Wants,
};

use crate::support::world::World;
use crate::support::{Collected, N_GAUGES, bundle, messages, pressed, taken};

fn builder(world: &World, sink: impl Sink + 'static) -> LiveBuilder {
    let bundle = bundle(world);
    let source = ReplaySource::new("memory", messages(&pressed(world, 900, 3)).into_iter(), 0.0);
    Live::builder(source)
        .bundle(&bundle)
        .params(LiveParams {
            tare_s: 0.3,
            is_recorded: true,
            is_lossless: true,
            ..LiveParams::default()
        })
        .boxed_estimator(bundle.estimator(None, SearchPlace::Here).unwrap())
        .sink(sink)
}

fn keep(frames: &Collected<LiveFrame>) -> impl Sink + use<> {
    let frames = Arc::clone(frames);
    let keep = move |frame: &LiveFrame| frames.lock().unwrap().push(frame.clone());
    FnSink::new("test", Wants::ALL, keep).with_delivery(Delivery::Direct)
}

#[test]
fn steps_give_the_frames_of_threads() {
    let world = World::new(N_GAUGES, 400, 5);
    let frames = Collected::<LiveFrame>::default();
    builder(&world, keep(&frames)).start().unwrap().wait().unwrap();
    let expected = taken(&frames);
    let mut steps = builder(&world, keep(&frames)).in_steps().unwrap();
    while steps.step() {}
    let found = taken(&frames);
    assert_eq!(found.len(), 900);
    assert!(found.iter().any(|frame| !frame.touch.contacts.is_empty()));
    assert!(found == expected);
}

/// Fails at its third frame, and counts what it is given.
struct Failing(Arc<Mutex<(usize, usize)>>);

impl Sink for Failing {
    fn name(&self) -> String {
        "failing".to_owned()
    }

    fn wants(&self) -> Wants {
        Wants::RAW
    }

    fn frame(&mut self, _: &LiveFrame) -> Result<(), AnyError> {
        let mut counts = self.0.lock().unwrap();
        counts.0 += 1;
        if counts.0 == 3 { Err("no more".into()) } else { Ok(()) }
    }

    fn event(&mut self, event: &LiveEvent) -> Result<(), AnyError> {
        self.0.lock().unwrap().1 += usize::from(matches!(event, LiveEvent::Health(_)));
        Ok(())
    }
}

#[test]
fn a_sink_that_failed_is_not_called_again() {
    let world = World::new(N_GAUGES, 400, 5);
    let counts = Arc::<Mutex<(usize, usize)>>::default();
    let mut steps = builder(&world, Failing(Arc::clone(&counts))).in_steps().unwrap();
    while steps.step() {}
    drop(steps);
    assert_eq!(*counts.lock().unwrap(), (3, 0), "frames, and health that it does not want");
}
