//! The rendered rope is the same everywhere, and its truth matches the pixels.

use lariat_capture::{Frame, FrameSource, RenderOptions, Source, open};
use lariat_message::{Centerlines, PixelFormat, SourceKind};
use proptest::prelude::*;

/// One frame with its truth.
struct Shot {
    frame: Frame,
    pixels: Vec<u8>,
    truth: Box<Centerlines>,
}

fn source(options: RenderOptions) -> Box<dyn FrameSource> {
    open(&Source::Rendered(options)).expect("the options are in range")
}

fn shoot(source: &mut dyn FrameSource) -> Shot {
    let frame = source.next().unwrap().expect("the rope has no end");
    let mut pixels = vec![0; frame.bytes()];
    source.write(&mut pixels);
    let mut truth = Box::new(Centerlines::EMPTY);
    assert!(source.truth(&mut truth));
    Shot {
        frame,
        pixels,
        truth,
    }
}

/// The first frames, `interval_s` apart.
fn shots(options: RenderOptions, interval_s: f64, count: usize) -> Vec<Shot> {
    let mut source = source(RenderOptions {
        frame_interval_s: interval_s,
        ..options
    });
    (0..count).map(|_| shoot(&mut *source)).collect()
}

impl Shot {
    /// Difference between blue and red at a place, interpolated bilinearly: about −16 on the table
    /// and 50 to 150 on the rope.
    fn blueness(&self, [x, y]: [f32; 2]) -> f32 {
        let at = |x: f32, y: f32| {
            let start = y as usize * self.frame.stride as usize + 3 * x as usize;
            f32::from(self.pixels[start + 2]) - f32::from(self.pixels[start])
        };
        let (u, v) = (x.fract(), y.fract());
        let upper = at(x, y) * (1.0 - u) + at(x + 1.0, y) * u;
        let lower = at(x, y + 1.0) * (1.0 - u) + at(x + 1.0, y + 1.0) * u;
        upper * (1.0 - v) + lower * v
    }

    fn points(&self) -> &[[f32; 2]] {
        self.truth.curves()[0].points()
    }

    /// The unit tangent at each point except the first and the last, with the point.
    fn tangents(&self) -> impl Iterator<Item = ([f32; 2], [f32; 2])> {
        self.points().windows(3).map(|w| {
            let (dx, dy) = (w[2][0] - w[0][0], w[2][1] - w[0][1]);
            let length = dx.hypot(dy);
            (w[1], [dx / length, dy / length])
        })
    }

    fn distance_px(&self, [x, y]: [f32; 2]) -> f32 {
        let distances = self.points().iter().map(|p| (p[0] - x).hypot(p[1] - y));
        distances.fold(f32::MAX, f32::min)
    }
}

/// FNV-1a hash.
fn hash(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

#[test]
fn the_same_seed_makes_the_same_frames_on_every_machine() {
    let hashes: Vec<u64> = [(1, 640, 480), (2, 640, 480), (3, 101, 177)]
        .into_iter()
        .flat_map(|(seed, width, height)| {
            let options = RenderOptions {
                seed,
                width,
                height,
                rope_px: f64::from(width.min(height)) / 40.0 + 2.0,
                ..RenderOptions::default()
            };
            // At first the rope is open, then it forms a loop, then it crosses itself.
            shots(options, 5.0, 3)
        })
        .map(|shot| hash(&shot.pixels))
        .collect();
    let expected = [
        0xcdcbf6a7df36edcf,
        0x0f90e1b85d9e00de,
        0x09af04c51a3f4781,
        0x427e1b9a42c45d8d,
        0xc4a2765942306e1c,
        0xcdc2611d11f3d2f1,
        0x6e602d13bfc262c8,
        0xfde16517f16de489,
        0x591c40f52c307e1c,
    ];
    assert_eq!(hashes, expected);
}

#[test]
fn frame_k_depends_on_k_alone() {
    let mut hasty = source(RenderOptions::default());
    for _ in 0..20 {
        hasty.next().unwrap();
    }
    let late = shoot(&mut *hasty);
    let all = shots(RenderOptions::default(), 1.0 / 30.0, 21);
    assert_eq!(late.frame.sequence, 21);
    assert!(late.pixels == all[20].pixels);
    assert_eq!(late.points(), all[20].points());
    assert!(all[19].pixels != all[20].pixels);
}

#[test]
fn frames_are_numbered_from_1_and_end_where_they_are_told_to() {
    let mut source = source(RenderOptions {
        frames: Some(3),
        ..RenderOptions::default()
    });
    assert_eq!(source.kind(), SourceKind::Rendered);
    assert_eq!(source.largest_frame_bytes(), 640 * 480 * 3);
    assert_eq!(source.native_fps(), Some(30.0));
    assert!(source.has_truth());
    for sequence in 1..=3 {
        let frame = source.next().unwrap().unwrap();
        let expected = Frame {
            sequence,
            width: 640,
            height: 480,
            stride: 1920,
            format: PixelFormat::Rgb8,
            exposed_ns: None,
            slot: None,
        };
        assert_eq!(frame, expected);
    }
    assert_eq!(source.next().unwrap(), None);
    assert_eq!(source.next().unwrap(), None);
}

#[test]
fn the_truth_lies_on_the_rope_and_beside_it_is_table() {
    for shot in shots(RenderOptions::default(), 0.7, 40) {
        let width_px = shot.truth.curves()[0].width_px;
        for (at, [dx, dy]) in shot.tangents() {
            assert!(shot.blueness(at) > 30.0, "{at:?} is not on the rope");
            for side in [-1.5 * width_px, 1.5 * width_px] {
                let beside = [at[0] - side * dy, at[1] + side * dx];
                // Only where no other strand passes.
                if shot.distance_px(beside) > 1.4 * width_px {
                    assert!(shot.blueness(beside) < 10.0, "{beside:?} is not table");
                }
            }
        }
    }
}

#[test]
fn the_drawn_rope_is_centred_on_the_truth_and_as_wide_as_it_says() {
    let options = RenderOptions {
        noise: 0.0,
        ..RenderOptions::default()
    };
    for shot in shots(options, 2.3, 12) {
        let width_px = shot.truth.curves()[0].width_px;
        let tangents: Vec<_> = shot.tangents().skip(4).collect();
        let (mut offsets, mut widths) = (Vec::new(), Vec::new());
        for (at, [dx, dy]) in &tangents[..tangents.len() - 4] {
            let place = |side: f32| [at[0] - side * dy, at[1] + side * dx];
            let alone = |side| shot.distance_px(place(side)) > 0.9 * width_px;
            if !alone(width_px) || !alone(-width_px) {
                continue;
            }
            // Rope color is where blue exceeds red: the outermost places on either side.
            let outermost = |sign: f32| {
                let mut sides = (0..200).map(|i| sign * i as f32 * width_px / 200.0);
                sides.rfind(|&side| shot.blueness(place(side)) > 20.0)
            };
            let (left, right) = (outermost(-1.0).unwrap(), outermost(1.0).unwrap());
            offsets.push((left + right) / 2.0);
            widths.push(right - left);
        }
        assert!(offsets.len() > 30);
        let mean = |values: &[f32]| values.iter().sum::<f32>() / values.len() as f32;
        let squares: Vec<f32> = offsets.iter().map(|x| x * x).collect();
        let rms_px = mean(&squares).sqrt();
        assert!(rms_px < 0.3, "{rms_px}");
        assert!((mean(&widths) - width_px).abs() < 0.5, "{}", mean(&widths));
    }
}

#[test]
fn the_rope_ends_where_the_truth_ends() {
    for shot in shots(RenderOptions::default(), 2.3, 20) {
        let points = shot.points();
        let n = points.len();
        for (tip, inner) in [(points[0], points[1]), (points[n - 1], points[n - 2])] {
            let (dx, dy) = (tip[0] - inner[0], tip[1] - inner[1]);
            let length = dx.hypot(dy);
            let place = |out: f32| [tip[0] + out * dx / length, tip[1] + out * dy / length];
            assert!(shot.blueness(place(-1.5)) > 25.0);
            // Unless the rope ends on another strand.
            let others = points.iter().filter(|p| {
                let far = (p[0] - tip[0]).hypot(p[1] - tip[1]);
                far < 16.0
            });
            if others.count() <= 4 {
                assert!(shot.blueness(place(2.0)) < 15.0);
            }
        }
    }
}

#[test]
fn the_rope_crosses_itself_at_times_and_the_truth_says_where() {
    let shots = shots(RenderOptions::default(), 0.5, 120);
    let crossed = shots.iter().filter(|s| s.truth.crossing_count > 0).count();
    assert!((24..96).contains(&crossed), "{crossed} of 120");
    for shot in &shots {
        for crossing in shot.truth.crossings() {
            for rho in [crossing.over_rho, crossing.under_rho] {
                let points = shot.points();
                let near = points[(rho * (points.len() - 1) as f32).round() as usize];
                let off = (near[0] - crossing.at[0]).hypot(near[1] - crossing.at[1]);
                assert!(off < 4.0, "{off} px from the crossing");
            }
            assert!(crossing.over_rho > crossing.under_rho);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn every_rope_stays_inside_at_constant_length_and_equal_steps(
        seed: u64,
        width in 64u32..900,
        height in 64u32..700,
        truth_points in 2u32..=256,
    ) {
        let options = RenderOptions {
            seed,
            width,
            height,
            truth_points,
            rope_px: (f64::from(width.min(height)) / 40.0).max(3.0),
            ..RenderOptions::default()
        };
        let half_px = options.rope_px as f32 / 2.0;
        let mut lengths = Vec::new();
        for shot in shots(options, 4.37, 15) {
            let curve = &shot.truth.curves()[0];
            lengths.push(curve.length_px);
            prop_assert_eq!(curve.points().len(), truth_points as usize);
            prop_assert_eq!((shot.truth.width, shot.truth.height), (width, height));
            for p in curve.points() {
                prop_assert!(p[0] > half_px && p[0] < width as f32 - 1.0 - half_px);
                prop_assert!(p[1] > half_px && p[1] < height as f32 - 1.0 - half_px);
            }
            // Chords are slightly shorter than the arc, depending on the bend between two points.
            let step_px = curve.length_px / (truth_points - 1) as f32;
            for w in curve.points().windows(2) {
                let chord_px = (w[1][0] - w[0][0]).hypot(w[1][1] - w[0][1]);
                prop_assert!(chord_px < step_px * 1.0001 + 1e-3);
                if truth_points >= 60 {
                    prop_assert!(chord_px > step_px * 0.97, "{} of {}", chord_px, step_px);
                }
            }
        }
        prop_assert!(lengths.iter().all(|&length| length == lengths[0]));
    }
}

#[test]
fn options_that_make_no_picture_of_a_rope_are_refused_with_what_is_needed() {
    let usual = RenderOptions::default();
    let refused = [
        (RenderOptions { width: 63, ..usual }, "64×64"),
        (
            RenderOptions {
                rope_px: 2.0,
                ..usual
            },
            "from 3 to 24",
        ),
        (
            RenderOptions {
                rope_px: f64::NAN,
                ..usual
            },
            "from 3 to 24",
        ),
        (
            RenderOptions {
                noise: 9.0,
                ..usual
            },
            "0 to 4",
        ),
        (
            RenderOptions {
                truth_points: 257,
                ..usual
            },
            "2 to 256",
        ),
        (
            RenderOptions {
                frame_interval_s: -1.0,
                ..usual
            },
            "3600",
        ),
    ];
    for (options, part) in refused {
        let error = open(&Source::Rendered(options)).err().expect("refused");
        assert!(error.to_string().contains(part), "{error}");
    }
}
