//! The example that uses extraction and fit as libraries.

#[path = "../../examples/descriptor.rs"]
#[allow(dead_code, reason = "the example's main is run by hand")]
mod descriptor;

#[test]
fn fifteen_lines_give_the_curve_of_a_picture() {
    let picture = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/rope.png");
    let fits = descriptor::descriptors(picture).expect("a picture with a rope");
    let [fit] = &fits[..] else {
        panic!("{} ropes", fits.len());
    };
    assert!((5..=20).contains(&fit.control_points.len()));
    assert!(fit.rms_px < 1.0, "{}", fit.rms_px);
    assert!(descriptor::descriptors("/nowhere.png").is_err());
}
