//! Who presses a limb that people see.

use hapdef_rig::live::{Hands, HandsParams, LiveLimb};

use crate::live_support::plate;

const HERE: [f64; 3] = [0.02, 0.02, 0.0];
const THERE: [f64; 3] = [0.06, 0.04, 0.0];

fn hands(limb: &LiveLimb) -> Hands {
    let params = HandsParams { max_contacts: 4, spacing_m: 0.012, largest_n: 30.0, seed: 1 };
    Hands::new(limb, &params).unwrap()
}

/// Forces of what presses at some time, N.
fn forces(hands: &mut Hands, limb: &LiveLimb, now_s: f64) -> Vec<f64> {
    hands.pressed(limb, true, now_s).iter().map(|pressed| pressed.force_n).collect()
}

#[test]
fn a_finger_waits_until_what_pressed_before_has_let_go() {
    let limb = plate();
    let mut hands = hands(&limb);
    hands.press(0, HERE, 5.0, 10.0);
    assert!(forces(&mut hands, &limb, 10.1).is_empty());
    assert_eq!(forces(&mut hands, &limb, 10.2), [5.0]);
    hands.press(1, THERE, 7.0, 10.3);
    assert_eq!(forces(&mut hands, &limb, 10.3), [5.0, 7.0], "the second one adds at once");
    hands.press(0, HERE, 6.0, 10.4);
    assert_eq!(forces(&mut hands, &limb, 10.4), [6.0, 7.0]);
    hands.lift(0, 10.5);
    assert_eq!(forces(&mut hands, &limb, 10.5), [7.0]);
    assert!(hands.pressed(&limb, false, 10.5).is_empty(), "nothing presses while it tares");
}

#[test]
fn it_presses_by_itself_some_time_after_the_last_finger() {
    let limb = plate();
    let mut hands = hands(&limb);
    let presses = |hands: &mut Hands, from_s: f64, to_s: f64| -> Vec<f64> {
        let n = ((to_s - from_s) * 100.0) as usize;
        (0..n).flat_map(|i| forces(hands, &limb, from_s + 0.01 * i as f64)).collect()
    };
    let by_itself = presses(&mut hands, 0.0, 20.0);
    assert!(by_itself.len() > 100);
    assert!(by_itself.iter().all(|force_n| *force_n <= 0.6 * 30.0), "{by_itself:?}");
    hands.press(0, HERE, 5.0, 20.0);
    hands.release(21.0);
    assert!(presses(&mut hands, 21.0, 25.0).is_empty());
    assert!(!presses(&mut hands, 25.0, 45.0).is_empty());
    hands.set_random(false);
    assert!(presses(&mut hands, 45.0, 65.0).is_empty());
}
