//! The examples, each with the number it has to come to.

#[path = "../../examples/capture.rs"]
mod capture;

#[test]
fn capture_comes_to_its_mean() {
    let (n_frames, n_lost, mean_ue) = capture::capture().unwrap();
    assert_eq!((n_frames, n_lost), (997, 3));
    // Half of the mean of 0 to 999 without 200, 201 and 700.
    let expected = 0.5 * (499_500.0 - 1101.0) / 997.0;
    assert!((mean_ue - expected).abs() < 1e-9, "{mean_ue}");
}
