use lariat_wire::{
    Basis, Centerlines, Crossing, Curve, Descriptor, Descriptors, FitQuality, FrameHeader,
    PixelFormat, SourceKind, Status, Trace, Unit,
};
use serde_json::{Value, json};

use super::*;

const TRACE: Trace = Trace {
    sequence: 12,
    captured: 11,
    extracted: 10,
    fitted: 9,
    exposed_ns: 5_000_000_000,
    captured_ns: 5_000_100_000,
    extract_started_ns: 5_000_150_000,
    extracted_ns: 5_000_350_000,
    fit_started_ns: 5_000_380_000,
    fitted_ns: 5_000_390_000,
    ..Trace::EMPTY
};

fn shape() -> Box<Descriptors> {
    let mut message = Box::new(Descriptors::EMPTY);
    message.trace = TRACE;
    (message.width, message.height) = (640, 480);
    (message.count, message.unit) = (1, Unit::Millimeter as u32);
    let rope = &mut message.curves[0];
    *rope = Descriptor::EMPTY;
    (rope.track, rope.status) = (3, Status::Lost as u32);
    (rope.basis, rope.degree, rope.count) = (Basis::BSpline as u32, 1, 3);
    (rope.samples, rope.rms, rope.max) = (120, 0.25, 0.1 + 0.2);
    (rope.border, rope.age_ns, rope.length) = (2, 1_500_000_000, 321.0);
    rope.confidence = 0.25;
    rope.control_points[..3].copy_from_slice(&[[1.0, 2.0], [3.0, 4.5], [5.0, 6.0]]);
    rope.covariances[1] = [0.04, 0.0, 0.09];
    rope.knots[0] = 0.5;
    rope.fit = FitQuality::Coarse as u32;
    let centerline = &mut message.centerlines[0];
    centerline.count = 2;
    centerline.points[..2].copy_from_slice(&[[1.0, 2.25], [5.0, 6.0]]);
    centerline.widths[..2].copy_from_slice(&[7.5, 8.0]);
    centerline.set_hidden([true, false]);
    message
}

#[test]
fn a_descriptor_is_told_with_all_its_fields_to_the_last_bit() {
    let line = json::line("descriptors", Any::Descriptors(&shape())).expect("JSON");
    assert_eq!(line.lines().count(), 1);
    let object: Value = serde_json::from_str(&line).expect("JSON");
    assert_eq!(object["trace"]["fit_started_ns"], 5_000_380_000_u64);
    assert_eq!(
        (&object["width"], &object["unit"]),
        (&json!(640), &json!("mm"))
    );
    let rope = &object["curves"][0];
    assert_eq!(rope["status"], "lost");
    assert_eq!(rope["basis"], "bspline");
    assert_eq!(rope["border"], json!([false, true]));
    assert_eq!(rope["max"].as_f64(), Some(0.1 + 0.2));
    assert_eq!(
        rope["control_points"],
        json!([[1.0, 2.0], [3.0, 4.5], [5.0, 6.0]])
    );
    assert_eq!(rope["covariances"][1], json!([0.04, 0.0, 0.09]));
    assert_eq!(rope["knots"], json!([0.5]));
    assert_eq!(rope["fit"], "coarse");
    let centerline =
        json!({"hidden": [0], "points": [[1.0, 2.25], [5.0, 6.0]], "widths": [7.5, 8.0]});
    assert_eq!(rope["centerline"], centerline);
    // All fields of the message, except those that other keys replace.
    let keys = rope.as_object().expect("an object").len();
    assert_eq!(keys, 24);
}

#[test]
fn a_frame_is_told_without_its_pixels() {
    let header = FrameHeader {
        trace: TRACE,
        width: 4,
        height: 2,
        stride: 12,
        pixel_format: PixelFormat::Rgb8 as u32,
        source: SourceKind::Camera as u32,
        ..FrameHeader::default()
    };
    let line = json::line("frames", Any::Image(&header, &[7; 24])).expect("JSON");
    let object: Value = serde_json::from_str(&line).expect("JSON");
    assert_eq!(
        (&object["bytes"], &object["source"]),
        (&json!(24), &json!("camera"))
    );
    assert_eq!(object["pixel_format"], "rgb8");
    assert!(!line.contains("7,7"), "{line}");
    let strange = FrameHeader {
        pixel_format: 99,
        ..header
    };
    let line = json::line("frames", Any::Image(&strange, &[])).expect("JSON");
    assert!(line.contains(r#""pixel_format":"99""#), "{line}");
}

#[test]
fn a_centerline_is_told_with_what_is_hidden_of_it_and_where_it_crosses() {
    let mut message = Box::new(Centerlines::EMPTY);
    message.trace = TRACE;
    (message.width, message.height) = (640, 480);
    (message.count, message.crossing_count) = (1, 1);
    let curve = &mut message.curves[0];
    *curve = Curve::EMPTY;
    (curve.count, curve.length_px) = (2, 5.0);
    curve.points[1] = [3.0, 4.0];
    curve.set_hidden([false, true]);
    message.crossings[0] = Crossing {
        at: [1.5, 2.0],
        confidence: 0.5,
        ..Crossing::EMPTY
    };
    let line = json::line("centerlines", Any::Centerlines(&message)).expect("JSON");
    let object: Value = serde_json::from_str(&line).expect("JSON");
    assert_eq!(object["curves"][0]["hidden"], json!([1]));
    assert_eq!(
        object["curves"][0]["points"],
        json!([[0.0, 0.0], [3.0, 4.0]])
    );
    assert_eq!(object["crossings"][0]["at"], json!([1.5, 2.0]));
    let text = text::paragraph("centerlines", Any::Centerlines(&message), false);
    assert!(
        text.contains("2 points, 1 hidden\n    (0.0, 0.0) (3.0, 4.0)\n"),
        "{text}"
    );
    assert!(text.contains("crossing at (1.5, 2.0)"), "{text}");
}

#[test]
fn as_text_a_rope_says_how_it_is_and_a_frame_without_one_that_it_has_none() {
    let mut message = shape();
    let text = text::paragraph("descriptors", Any::Descriptors(&message), false);
    let expected = "descriptors: frame 12, exposed 5.000000 s; sent: captured 11, extracted 10,\n  fitted 9\n  \
         µs: capture 100, wait for extract 50.0, extract 200, wait for fit 30.0, fit\n    10.0\n  \
         rope 3, confidence 0.25: lost for 1.50 s, its last end leaves the image;\n    bspline of degree 1, 3 control points, coarse, 321.0 mm long, 0.0 wide\n    \
         rms 0.250, max 0.300 mm of 120 points (0 hidden), condition 0, control\n      points known to 0.300 mm\n    \
         (1.0, 2.0) (3.0, 4.5) (5.0, 6.0)\n\n";
    assert_eq!(text, expected);
    message.count = 0;
    let text = text::paragraph("descriptors", Any::Descriptors(&message), false);
    assert!(text.ends_with("  no rope\n\n"), "{text}");
    (message.width, message.count) = (0, 1);
    let text = text::paragraph("descriptors", Any::Descriptors(&message), false);
    assert!(
        text.contains("no image") && text.contains("rope 3, confidence 0.25: lost"),
        "{text}"
    );
}

#[test]
fn low_confidence_is_yellow_where_colours_are_shown() {
    let mut message = shape();
    let shown = |message: &Descriptors, has_colours| {
        text::paragraph("descriptors", Any::Descriptors(message), has_colours)
    };
    let low = "\x1b[33mconfidence 0.25\x1b[0m: lost";
    assert!(shown(&message, true).contains(low));
    assert!(!shown(&message, false).contains('\x1b'));
    message.curves[0].confidence = 0.5;
    assert!(!shown(&message, true).contains('\x1b'));
}
