//! Tests of single curves.

use super::*;
use crate::settings::Family;

/// A straight rope of 120 points from (100, 200), 2 px apart along x.
fn rope() -> Curve {
    let mut curve = Curve {
        track: 7,
        status: Status::Ok as u32,
        count: 120,
        ..Curve::EMPTY
    };
    for (i, point) in curve.points[..120].iter_mut().enumerate() {
        *point = [100.0 + 2.0 * i as f32, 200.0];
    }
    curve
}

/// The paper's curve with 9 control points.
fn order_8() -> settings::Fit {
    settings::Fit {
        control_points: Some(settings::ControlPoints::Named(9)),
        ..settings::Fit::default()
    }
}

fn fitter(fit: &settings::Fit) -> CurveFitter {
    let settings = Settings {
        fit: fit.clone(),
        ..Settings::default()
    };
    CurveFitter::new(&settings).unwrap()
}

fn described(settings: &settings::Fit, curve: &Curve) -> Descriptor {
    let mut descriptor = Descriptor::EMPTY;
    let mut fitter = fitter(settings);
    fitter.describe(curve, 1, &mut descriptor).unwrap();
    descriptor
}

/// Returns the largest distance of a control point from the rope in y.
fn farthest(descriptor: &Descriptor) -> f64 {
    let offsets = descriptor
        .control_points()
        .iter()
        .map(|p| (p[1] - 200.0).abs());
    offsets.fold(0.0, f64::max)
}

#[test]
fn what_is_known_of_the_rope_goes_along() {
    let mut curve = rope();
    (curve.border, curve.age_ns, curve.length_px, curve.width_px) = (2, 5, 238.0, 12.5);
    let descriptor = described(&order_8(), &curve);
    assert_eq!(
        [descriptor.track, descriptor.degree, descriptor.count],
        [7, 8, 9]
    );
    assert_eq!(
        [descriptor.samples, descriptor.border, descriptor.filtered],
        [120, 2, 0]
    );
    assert_eq!(
        (descriptor.length, descriptor.width, descriptor.age_ns),
        (238.0, 12.5, 5)
    );
    assert_eq!(descriptor.basis(), Some(Basis::Bezier));
    assert!(farthest(&descriptor) < 1e-9);
    assert_eq!(descriptor.velocities[..9], [[0.0; 2]; 9]);
}

/// A rope 10 px wide with this many waves, each 30 px high.
fn winding(times: f32) -> Curve {
    let mut curve = rope();
    for (i, point) in curve.points[..120].iter_mut().enumerate() {
        let angle = std::f32::consts::TAU * times * i as f32 / 119.0;
        *point = [100.0 + 3.0 * i as f32, 200.0 + 15.0 * angle.sin()];
    }
    (curve.width_px, curve.length_px) = (10.0, 400.0);
    curve.widths_px[..120].fill(10.0);
    curve
}

#[test]
fn without_settings_a_curve_has_the_control_points_that_its_rope_needs() {
    let mut fitter = fitter(&settings::Fit::default());
    let mut descriptor = Descriptor::EMPTY;
    let mut describe = |track, times| {
        let curve = Curve {
            track,
            ..winding(times)
        };
        fitter.describe(&curve, 1, &mut descriptor).unwrap();
        assert!(descriptor.rms < 1.25 && descriptor.max < 5.0);
        assert_eq!(descriptor.fit(), Some(FitQuality::Good));
        (descriptor.basis(), descriptor.count)
    };
    assert_eq!(describe(1, 0.0), (Some(Basis::Bezier), 4));
    let (basis, twice) = describe(2, 2.0);
    assert_eq!(basis, Some(Basis::BSpline));
    let (_, four_times) = describe(3, 4.0);
    assert!(4 < twice && twice < four_times, "{twice} {four_times}");
    // Each rope keeps its size, whichever was fitted last.
    assert_eq!(describe(1, 0.0).1, 4);
    assert_eq!(describe(3, 3.0).1, four_times);
    assert_eq!(describe(2, 1.0).1, twice);
}

#[test]
fn a_curve_beside_its_points_is_coarse_whatever_its_basis() {
    let named = |basis, control_points| settings::Fit {
        basis,
        control_points: Some(settings::ControlPoints::Named(control_points)),
        ..settings::Fit::default()
    };
    for (fit, quality) in [
        (settings::Fit::default(), FitQuality::Good),
        (named(Family::Named(Basis::Bezier), 5), FitQuality::Coarse),
        (named(Family::Named(Basis::BSpline), 6), FitQuality::Coarse),
        (named(Family::Named(Basis::BSpline), 17), FitQuality::Good),
        (
            named(Family::Named(Basis::RationalBezier), 5),
            FitQuality::Coarse,
        ),
        (
            named(Family::Named(Basis::FeaturePoints), 32),
            FitQuality::Good,
        ),
        (
            named(Family::Named(Basis::CenterOfMass), 2),
            FitQuality::Coarse,
        ),
    ] {
        let descriptor = described(&fit, &winding(2.0));
        assert_eq!(descriptor.fit(), Some(quality), "{fit:?}");
    }
    // Bridged points do not make the rest of the curve doubtful.
    let mut covered = winding(0.0);
    covered.set_hidden((0..MAX_POINTS).map(|i| i == 60));
    covered.points[60][1] += 20.0;
    let descriptor = described(&named(Family::Named(Basis::Bezier), 4), &covered);
    assert_eq!(descriptor.fit(), Some(FitQuality::Good));
}

#[test]
fn a_rope_out_of_sight_keeps_its_size() {
    let mut fitter = fitter(&settings::Fit::default());
    let mut descriptor = Descriptor::EMPTY;
    fitter.describe(&winding(0.0), 1, &mut descriptor).unwrap();
    let mut at = |times, exposed_s: u64, age_s: u64| {
        let mut curve = winding(times);
        if age_s > 0 {
            (curve.status, curve.age_ns) = (Status::Lost as u32, age_s * 1_000_000_000);
        }
        let exposed_ns = exposed_s * 1_000_000_000;
        fitter
            .describe(&curve, exposed_ns, &mut descriptor)
            .unwrap();
        descriptor.count
    };
    // The rope was wound up and then hidden for two seconds. It has to be seen for a second before
    // its size changes.
    assert_eq!([at(3.0, 10, 0), at(3.0, 11, 1), at(3.0, 12, 2)], [4; 3]);
    assert!(at(3.0, 13, 0) > 4);
}

#[test]
fn what_size_a_rope_has_does_not_depend_on_its_unit() {
    let planes = [
        "homography = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]",
        "homography = [[0.1, 0, 0], [0, 0.1, 0], [0, 0, 1]]",
    ];
    let sizes = planes.map(|plane| {
        let mut fitter = on_the_plane(plane, None, settings::Fit::default());
        fitter.turn_to([640, 480]).unwrap();
        [0.0, 1.0, 2.0, 4.0].map(|times| {
            let mut descriptor = Descriptor::EMPTY;
            fitter.fitter.forget();
            fitter
                .describe(&winding(times), 1, &mut descriptor)
                .unwrap();
            descriptor.count
        })
    });
    assert_eq!(sizes[0], sizes[1]);
}

#[test]
fn the_filter_goes_on_with_a_curve_of_another_size() {
    let settings = settings::Fit {
        filter: true,
        ..settings::Fit::default()
    };
    let mut fitter = fitter(&settings);
    let mut descriptor = Descriptor::EMPTY;
    for frame in 0..90 {
        let curve = winding(if frame < 30 { 0.0 } else { 3.0 });
        let exposed_ns = 1_000_000_000 + frame * 33_333_333;
        fitter
            .describe(&curve, exposed_ns, &mut descriptor)
            .unwrap();
        assert_eq!(descriptor.filtered, 1, "frame {frame}");
    }
    assert!(descriptor.count > 4);
    let speed = descriptor.velocities[0];
    assert!(speed[0].abs() < 1.0 && speed[1].abs() < 1.0, "{speed:?}");
}

#[test]
fn a_closed_rope_is_a_fourier_series_whatever_the_basis() {
    let mut ring = rope();
    ring.closed = 1;
    for (i, point) in ring.points[..120].iter_mut().enumerate() {
        let (sin, cos) = (std::f32::consts::TAU * i as f32 / 120.0).sin_cos();
        *point = [300.0 + 80.0 * cos, 200.0 + 80.0 * sin];
    }
    for basis in [
        Family::Named(Basis::Bezier),
        Family::Named(Basis::RationalBezier),
        Family::Named(Basis::FeaturePoints),
    ] {
        let settings = settings::Fit { basis, ..order_8() };
        let descriptor = described(&settings, &ring);
        assert_eq!(descriptor.basis(), Some(Basis::Fourier));
        assert_eq!([descriptor.degree, descriptor.count], [4, 9]);
        let [center, cosine, sine] = [0, 1, 2].map(|j| descriptor.control_points[j]);
        for (found, expected) in [
            (center, [300.0, 200.0]),
            (cosine, [80.0, 0.0]),
            (sine, [0.0, 80.0]),
        ] {
            assert!((found[0] - expected[0]).abs() < 1e-4 && (found[1] - expected[1]).abs() < 1e-4);
        }
    }
}

#[test]
fn a_splines_inner_knots_go_along() {
    let settings = settings::Fit {
        basis: Family::Named(Basis::BSpline),
        ..order_8()
    };
    let descriptor = described(&settings, &rope());
    assert_eq!(descriptor.basis(), Some(Basis::BSpline));
    assert_eq!([descriptor.degree, descriptor.count], [3, 9]);
    let even = [1.0, 2.0, 3.0, 4.0, 5.0].map(|k| k / 6.0);
    assert_eq!(descriptor.knots[..5], even);
}

#[test]
fn with_the_robust_option_hidden_points_weigh_nothing() {
    let mut curve = rope();
    curve.status = Status::Partial as u32;
    curve.set_hidden((0..MAX_POINTS).map(|i| (40..70).contains(&i)));
    for point in &mut curve.points[40..70] {
        point[1] += 60.0;
    }
    let with = |robust| {
        let settings = settings::Fit {
            robust,
            ..order_8()
        };
        described(&settings, &curve)
    };
    assert!(farthest(&with(false)) > 10.0);
    let descriptor = with(true);
    assert!(farthest(&descriptor) < 1e-6, "{}", farthest(&descriptor));
    assert_eq!(descriptor.hidden, 30);
    // If too few points are visible, the bridged points determine the curve.
    curve.set_hidden((0..MAX_POINTS).map(|i| (5..115).contains(&i)));
    let settings = settings::Fit {
        robust: true,
        ..order_8()
    };
    assert!(described(&settings, &curve).count == 9);
}

#[test]
fn the_filter_knows_how_fast_a_rope_moves() {
    let settings = settings::Fit {
        filter: true,
        ..order_8()
    };
    let mut fitter = fitter(&settings);
    let mut descriptor = Descriptor::EMPTY;
    // 30 frames/s, 90 px/s along x; another rope does not move.
    for frame in 0..30 {
        let exposed_ns = 1_000_000_000 + frame * 33_333_333;
        let mut moved = rope();
        for point in &mut moved.points[..120] {
            point[0] += 3.0 * frame as f32;
        }
        let mut still = rope();
        still.track = 8;
        fitter
            .describe(&still, exposed_ns, &mut descriptor)
            .unwrap();
        fitter
            .describe(&moved, exposed_ns, &mut descriptor)
            .unwrap();
    }
    assert_eq!(descriptor.filtered, 1);
    for velocity in &descriptor.velocities[..9] {
        assert!(
            (velocity[0] - 90.0).abs() < 1.0 && velocity[1].abs() < 1.0,
            "{velocity:?}"
        );
    }
    assert!((descriptor.control_points[0][0] - 187.0).abs() < 0.1);
    assert!(
        descriptor.covariances[..9]
            .iter()
            .all(|&[xx, xy, yy]| xx == yy && xy == 0.0 && xx > 0.0 && xx < 1.0)
    );
}

/// A tilted plane, as in its file: a pixel at the bottom is three to four times as long as one at
/// the top.
const SLANT: &str = "homography = [[0.8, 0.05, -260.0], [-0.03, 1.1, -180.0], [1e-4, -1.3e-3, 1.0]]\nimage_size = [640, 480]\n";

fn on_the_plane(plane: &str, calibration: Option<&str>, fit: settings::Fit) -> CurveFitter {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    let settings = Settings {
        camera: settings::Camera {
            calibration: calibration.map(|text| file("camera.yaml", text)),
            plane: Some(file("plane.toml", plane)),
            ..settings::Camera::default()
        },
        fit,
        ..Settings::default()
    };
    CurveFitter::new(&settings).unwrap()
}

/// A rope that runs diagonally up the picture.
fn slanting_rope() -> Curve {
    let mut curve = rope();
    for (i, point) in curve.points[..120].iter_mut().enumerate() {
        *point = [80.0 + 4.0 * i as f32, 450.0 - 3.5 * i as f32];
    }
    curve.width_px = 10.0;
    curve.widths_px[..120].fill(10.0);
    curve
}

#[test]
fn a_straight_line_on_a_tilted_plane_has_even_points() {
    let mut fitter = on_the_plane(SLANT, None, order_8());
    assert_eq!(fitter.unit(), Unit::Millimeter);
    fitter.turn_to([640, 480]).unwrap();
    let mut descriptor = Descriptor::EMPTY;
    fitter
        .describe(&slanting_rope(), 1, &mut descriptor)
        .unwrap();
    let [first, last] = [0, 8].map(|j| descriptor.control_points[j]);
    let length = (last[0] - first[0]).hypot(last[1] - first[1]);
    assert!(
        (descriptor.length - length).abs() < 1e-3,
        "{length} {}",
        descriptor.length
    );
    // Points are sent as f32 with a step of 3·10⁻⁵ px at 500 px. A control point of order 8
    // amplifies noise by a factor of 25.
    for (j, point) in descriptor.control_points().iter().enumerate() {
        let even = [0, 1].map(|axis| first[axis] + (last[axis] - first[axis]) * j as f64 / 8.0);
        let off = (point[0] - even[0]).hypot(point[1] - even[1]);
        assert!(off < 2e-3, "control point {j} is {off} mm off");
    }
    // With equal steps in the picture, the middle of the line would be elsewhere.
    let [lower, upper] = [[80.0, 450.0], [556.0, 33.5]];
    let middle = [0, 1].map(|axis| 0.5 * (lower[axis] + upper[axis]));
    let plane = lariat_camera::Plane::from_homography([
        [0.8, 0.05, -260.0],
        [-0.03, 1.1, -180.0],
        [1e-4, -1.3e-3, 1.0],
    ]);
    let mapping = lariat_camera::Mapping::new(None, Some(&plane.unwrap()), [640, 480]).unwrap();
    let seen = mapping.place(middle).unwrap().point;
    let even = descriptor.control_points[4];
    assert!((seen[0] - even[0]).hypot(seen[1] - even[1]) > 20.0);
}

#[test]
fn sizes_and_noise_come_in_millimetres_too() {
    let mut fitter = on_the_plane(SLANT, None, order_8());
    fitter.turn_to([640, 480]).unwrap();
    let mut curve = slanting_rope();
    // Reproducible noise of a tenth of a pixel.
    for (i, point) in curve.points[..120].iter_mut().enumerate() {
        let noise = |k: usize| 0.1 * (((7919 * i + 104_729 * k) % 997) as f32 / 498.5 - 1.0);
        *point = [point[0] + noise(1), point[1] + noise(2)];
    }
    let mut descriptor = Descriptor::EMPTY;
    fitter.describe(&curve, 1, &mut descriptor).unwrap();
    // Ten pixels of 0.9 to 3.5 mm each.
    assert!(
        descriptor.width > 9.0 && descriptor.width < 24.0,
        "{}",
        descriptor.width
    );
    assert!(
        descriptor.rms > 0.01 && descriptor.rms < 0.5,
        "{}",
        descriptor.rms
    );
    let noise = |j: usize| descriptor.covariances[j][0] + descriptor.covariances[j][2];
    // A pixel at the rope's first end is three to four times as long as one at the last end.
    assert!(noise(0) > 5.0 * noise(8), "{} {}", noise(0), noise(8));
    assert!((0..9).all(|j| {
        let [xx, xy, yy] = descriptor.covariances[j];
        xx > 0.0 && yy > 0.0 && xy * xy <= xx * yy
    }));
}

#[test]
fn the_filter_too_works_in_millimetres() {
    // A pixel is half a millimeter everywhere.
    let half = "homography = [[0.5, 0, 0], [0, 0.5, 0], [0, 0, 1]]";
    let fit = settings::Fit {
        filter: true,
        ..order_8()
    };
    let (mut in_mm, mut in_px) = (on_the_plane(half, None, fit.clone()), fitter(&fit));
    in_mm.turn_to([640, 480]).unwrap();
    let (mut mm, mut px) = (Descriptor::EMPTY, Descriptor::EMPTY);
    for frame in 0..30 {
        let exposed_ns = 1_000_000_000 + frame * 33_333_333;
        let mut moved = rope();
        for point in &mut moved.points[..120] {
            point[0] += 3.0 * frame as f32;
        }
        in_mm.describe(&moved, exposed_ns, &mut mm).unwrap();
        in_px.describe(&moved, exposed_ns, &mut px).unwrap();
    }
    for j in 0..9 {
        let close = |a: f64, b: f64| (a - 0.5 * b).abs() < 0.05;
        assert!((0..2).all(|axis| close(mm.control_points[j][axis], px.control_points[j][axis])));
        assert!(
            (0..2).all(|axis| close(mm.velocities[j][axis], px.velocities[j][axis])),
            "{:?} {:?}",
            mm.velocities[j],
            px.velocities[j]
        );
    }
}

#[test]
fn hidden_points_stay_hidden_on_the_plane() {
    let fit = settings::Fit {
        robust: true,
        ..order_8()
    };
    let mut fitter = on_the_plane(SLANT, None, fit);
    fitter.turn_to([640, 480]).unwrap();
    let straight = slanting_rope();
    let mut covered = slanting_rope();
    covered.status = Status::Partial as u32;
    covered.set_hidden((0..MAX_POINTS).map(|i| (60..75).contains(&i)));
    let (mut expected, mut found) = (Descriptor::EMPTY, Descriptor::EMPTY);
    fitter.describe(&straight, 1, &mut expected).unwrap();
    fitter.describe(&covered, 1, &mut found).unwrap();
    assert_eq!(found.hidden, 15);
    for (a, b) in expected.control_points().iter().zip(found.control_points()) {
        assert!((a[0] - b[0]).hypot(a[1] - b[1]) < 0.05, "{a:?} {b:?}");
    }
}

#[test]
fn the_points_go_along_as_extract_sent_them() {
    let mut fitter = fitter(&settings::Fit::default());
    let mut curve = rope();
    curve.set_hidden((0..MAX_POINTS).map(|i| i % 7 == 3));
    for (i, width) in curve.widths_px[..120].iter_mut().enumerate() {
        *width = 10.0 + 0.01 * i as f32;
    }
    let (mut descriptor, mut points) = (Descriptor::EMPTY, CenterlinePoints::EMPTY);
    points.points[120] = [7.0; 2];
    fitter.describe(&curve, 1, &mut descriptor).unwrap();
    fitter.write_points(&curve, &mut points);
    assert_eq!(points.points(), curve.points());
    assert_eq!(points.widths(), curve.widths_px());
    assert_eq!(points.hidden, curve.hidden);
    assert_eq!(
        points.points[120], [7.0; 2],
        "what is not meant is not copied"
    );
}

#[test]
fn on_the_plane_the_points_are_those_that_were_fitted() {
    let mut fitter = on_the_plane(SLANT, None, settings::Fit::default());
    fitter.turn_to([640, 480]).unwrap();
    let mut curve = slanting_rope();
    curve.set_hidden((0..MAX_POINTS).map(|i| (60..75).contains(&i)));
    let (mut descriptor, mut line) = (Descriptor::EMPTY, CenterlinePoints::EMPTY);
    fitter.describe(&curve, 1, &mut descriptor).unwrap();
    fitter.write_points(&curve, &mut line);
    assert_eq!(line.count, 120);
    let step = descriptor.length / 119.0;
    for pair in line.points().windows(2) {
        let [a, b] = [pair[0], pair[1]].map(|p| p.map(f64::from));
        assert!(((b[0] - a[0]).hypot(b[1] - a[1]) - step).abs() < 1e-3);
    }
    // Far away, a pixel covers more of the table. The rope is ten pixels wide everywhere, so its
    // width on the table grows with the distance.
    let widths = line.widths();
    assert!(widths.is_sorted_by(|near, far| near > far) || widths.is_sorted());
    let [least, most] = [widths[0].min(widths[119]), widths[0].max(widths[119])].map(f64::from);
    assert!(least < descriptor.width && descriptor.width < most && most > 1.5 * least);
    // The fifteen hidden points of the picture become a few more or fewer on the table, still in
    // one run.
    let hidden: Vec<usize> = (0..120).filter(|&k| line.is_hidden(k)).collect();
    assert!(hidden.len() > 5 && hidden[hidden.len() - 1] - hidden[0] == hidden.len() - 1);
}

#[test]
fn a_rope_beyond_the_horizon_is_left_out_and_the_others_are_not() {
    // The horizon is at y = 400 px.
    let steep = "homography = [[1, 0, 0], [0, 1, 0], [0, -2.5e-3, 1]]";
    let mut curves = on_the_plane(steep, None, order_8());
    let mut seen = Box::new(Centerlines::EMPTY);
    (seen.width, seen.height, seen.count) = (640, 480, 2);
    (seen.curves[0], seen.curves[1]) = (slanting_rope(), rope());
    let mut message = Box::new(Descriptors::EMPTY);
    curves.answer(&seen, &mut message);
    assert_eq!((message.count, message.unit()), (1, Some(Unit::Millimeter)));
    assert!(message.curves[0].length > 238.0);
    assert_eq!(message.centerlines().len(), 1);
    assert_eq!(message.centerlines[0].count, 120);
}

#[test]
fn frames_of_another_shape_than_the_calibrations_have_no_curves() {
    let mut curves = on_the_plane(SLANT, None, order_8());
    let mut seen = Box::new(Centerlines::EMPTY);
    (seen.width, seen.height, seen.count) = (640, 360, 1);
    seen.curves[0] = rope();
    let mut message = Box::new(Descriptors::EMPTY);
    for (height, count) in [(360, 0), (480, 1), (360, 0)] {
        seen.height = height;
        curves.answer(&seen, &mut message);
        assert_eq!(message.count, count);
    }
}

#[test]
fn without_a_plane_a_calibration_makes_ideal_pixels() {
    let yaml = "image_width: 640\nimage_height: 480\nK: [600, 0, 320, 0, 600, 240, 0, 0, 1]\nD: [-0.3, 0.1, 0, 0]";
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("camera.yaml");
    std::fs::write(&path, yaml).unwrap();
    let settings = Settings {
        camera: settings::Camera {
            calibration: Some(path),
            ..settings::Camera::default()
        },
        ..Settings::default()
    };
    let mut fitter = CurveFitter::new(&settings).unwrap();
    assert_eq!(fitter.unit(), Unit::IdealPixel);
    fitter.turn_to([640, 480]).unwrap();
    let mut descriptor = Descriptor::EMPTY;
    fitter.describe(&rope(), 1, &mut descriptor).unwrap();
    let camera = lariat_camera::Camera::from_yaml(yaml).unwrap();
    let ideal = camera.undistort([100.0, 200.0]).unwrap().point;
    let first = descriptor.control_points[0];
    assert!(
        (first[0] - ideal[0]).hypot(first[1] - ideal[1]) < 0.01,
        "{first:?} {ideal:?}"
    );
}
