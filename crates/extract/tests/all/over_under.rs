//! Tests which strand is on top where ropes of one color cross, and where crossings are reported.

use crate::drawing;
use crate::scored::scored;
use lariat_drawn::scenes::{self, Class, CrossingScore, SeenCrossing};
use lariat_portable::SplitMix64;

use drawing::shaded::{Canvas, Strand, Surface};
use drawing::{Vec2, distance, extractor};
use lariat_extract::{Crossing, Curve, Extractor, Image, Options, PixelFormat};

const SIDE: usize = 200;
const MIDDLE: Vec2 = [100.0, 100.0];

/// Two ropes that cross in the middle of the picture, the second on top, and their look.
struct Cross {
    below: Strand,
    above: Strand,
    table: [f32; 3],
    noise: f32,
    soften: usize,
}

impl Cross {
    /// Random ropes of one color and width that cross at 25° or more.
    fn random(random: &mut SplitMix64) -> Self {
        let width_px = random.uniform_f32(4.0, 16.0);
        let surface = Surface {
            color: [(); 3].map(|()| random.uniform_f32(90.0, 200.0)),
            shade: random.uniform_f32(0.0, 0.5),
            gloss: random.uniform_f32(-40.0, 60.0).max(0.0),
            gloss_at: random.uniform_f32(-0.6, 0.6),
            shadow: random.uniform_f32(-0.3, 0.4).max(0.0),
            speckles: random.uniform_f32(-10.0, 10.0).max(0.0),
            braid: random.uniform_f32(-30.0, 30.0).max(0.0),
        };
        let turn = random.uniform_f32(0.0, std::f32::consts::PI);
        let angle = random.uniform_f32(25.0, 155.0).to_radians();
        let bend = [(); 2].map(|()| random.uniform_f32(-0.15, 0.15) / 100.0);
        let strand = |turn: f32, bend: f32| {
            let axis = turn.sin_cos();
            let points = (-85..=85).map(|s| {
                let (s, aside) = (s as f32, bend * (s as f32).powi(2));
                [
                    MIDDLE[0] + s * axis.1 - aside * axis.0,
                    MIDDLE[1] + s * axis.0 + aside * axis.1,
                ]
            });
            Strand {
                points: points.collect(),
                width_px,
                surface,
            }
        };
        Self {
            below: strand(turn, bend[0]),
            above: strand(turn + angle, bend[1]),
            table: [20.0; 3],
            noise: random.uniform_f32(0.0, 8.0),
            soften: random.uniform_f32(0.0, 3.0) as usize,
        }
    }

    fn draw(&self, random: &mut SplitMix64) -> Vec<u8> {
        let mut canvas = Canvas::new(SIDE, SIDE, self.table);
        canvas.paint(&self.below, random);
        canvas.paint(&self.above, random);
        canvas.soften(self.soften);
        canvas.bytes(self.noise, random)
    }
}

/// The point of `curve` at normalized arc length `rho`.
fn at(curve: &Curve, rho: f32) -> Vec2 {
    let place = rho * (curve.points.len() - 1) as f32;
    let i = (place as usize).min(curve.points.len() - 2);
    let (a, b, t) = (curve.points[i], curve.points[i + 1], place - i as f32);
    [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]
}

/// Returns whether the strand at `rho` of `curve` runs along `strand` on its way to the crossing.
fn runs_along(curve: &Curve, rho: f32, strand: &Strand) -> bool {
    let away = 30.0 / curve.length_px;
    [rho - away, rho + away]
        .iter()
        .all(|&rho| drawing::distance_to(at(curve, rho), &strand.points) < 4.0)
}

/// The result for `cross`: the one crossing with its two curves. `None` if the ropes themselves
/// were confused.
fn see(cross: &Cross, random: &mut SplitMix64) -> Option<Found> {
    let bytes = cross.draw(random);
    let image = Image::new(&bytes, SIDE, SIDE, 3 * SIDE, PixelFormat::Rgb8).ok()?;
    let mut extractor = extractor();
    let scene = extractor.extract(&image);
    let [crossing] = scene.crossings else {
        return None;
    };
    let over = &scene.curves[crossing.over];
    let under = &scene.curves[crossing.under];
    let along = [
        runs_along(over, crossing.over_rho, &cross.above),
        runs_along(over, crossing.over_rho, &cross.below),
    ];
    (along[0] != along[1]).then(|| Found {
        right: along[0],
        crossing: *crossing,
        over_at: at(over, crossing.over_rho),
        under_at: at(under, crossing.under_rho),
    })
}

#[derive(Debug)]
struct Found {
    right: bool,
    crossing: Crossing,
    over_at: Vec2,
    under_at: Vec2,
}

#[test]
fn the_upper_of_two_ropes_of_one_color_is_told_by_its_shading() {
    let mut random = SplitMix64::new(401);
    let (mut seen, mut wrong) = (0, Vec::new());
    for i in 0..120 {
        let mut cross = Cross::random(&mut random);
        let surface = Surface {
            shade: 0.3,
            speckles: 0.0,
            braid: 0.0,
            ..cross.above.surface
        };
        (cross.above.surface, cross.below.surface) = (surface, surface);
        cross.noise = cross.noise.min(4.0);
        if let Some(found) = see(&cross, &mut random) {
            seen += 1;
            if !found.right {
                wrong.push((i, found));
            }
        }
    }
    assert!(seen >= 115, "{seen}");
    assert!(wrong.len() <= 1, "{wrong:?}");
}

#[test]
fn a_lens_out_of_focus_hides_the_order_seldom() {
    let mut random = SplitMix64::new(407);
    let (mut seen, mut right) = (0, 0);
    for _ in 0..80 {
        let mut cross = Cross::random(&mut random);
        for strand in [&mut cross.above, &mut cross.below] {
            strand.surface.shade = 0.3;
            strand.surface.braid = 0.0;
            strand.width_px = strand.width_px.max(8.0);
        }
        // A Gaussian of 1.6 px.
        (cross.soften, cross.noise) = (5, 2.0);
        if let Some(found) = see(&cross, &mut random) {
            seen += 1;
            right += usize::from(found.right);
        }
    }
    assert!(seen >= 75 && 100 * right >= 95 * seen, "{right} of {seen}");
}

#[test]
fn confidence_tells_how_often_it_is_right() {
    let mut random = SplitMix64::new(402);
    let mut bins = [(0.0f32, 0.0f32, 0.0f32); 3];
    for _ in 0..800 {
        let cross = Cross::random(&mut random);
        let Some(found) = see(&cross, &mut random) else {
            continue;
        };
        let confidence = found.crossing.confidence;
        assert!((0.0..=1.0).contains(&confidence));
        let bin = &mut bins[usize::from(confidence > 0.5) + usize::from(confidence > 0.9)];
        bin.0 += 1.0;
        bin.1 += 0.5 * (1.0 + confidence);
        bin.2 += f32::from(u8::from(found.right));
    }
    for (count, expected, right) in bins {
        assert!(count >= 20.0, "{bins:?}");
        let p = expected / count;
        // Three standard deviations of a binomial share, plus a margin of about 6 of the 700
        // crossings in the highest bin.
        let allowed = 3.0 * (p * (1.0 - p) / count).sqrt() + 0.01;
        assert!((right / count - p).abs() <= allowed, "{bins:?}");
    }
}

#[test]
fn a_crossing_lies_where_both_curves_are_at_their_rho() {
    let mut random = SplitMix64::new(403);
    for _ in 0..40 {
        let mut cross = Cross::random(&mut random);
        cross.noise = 2.0;
        let Some(found) = see(&cross, &mut random) else {
            continue;
        };
        let at = found.crossing.at;
        assert!(distance(at, found.over_at) < 0.1, "{found:?}");
        assert!(distance(at, found.under_at) < 0.1, "{found:?}");
        assert!(distance(at, MIDDLE) < 1.5, "{found:?}");
    }
}

#[test]
fn of_ropes_without_any_surface_neither_is_surely_on_top() {
    let mut random = SplitMix64::new(404);
    let mut confidences = Vec::new();
    for _ in 0..12 {
        let mut cross = Cross::random(&mut random);
        for strand in [&mut cross.above, &mut cross.below] {
            strand.surface = Surface {
                shade: 0.0,
                gloss: 0.0,
                shadow: 0.0,
                speckles: 0.0,
                braid: 0.0,
                ..strand.surface
            };
        }
        confidences.extend(see(&cross, &mut random).map(|found| found.crossing.confidence));
    }
    assert!(confidences.len() >= 10, "{confidences:?}");
    assert!(confidences.iter().all(|&c| c < 0.9), "{confidences:?}");
}

/// A rope that crosses itself once, and its part near one of the two passes.
fn noose(first_on_top: bool) -> (Strand, Strand) {
    let place = |t: f32| {
        let a = -4.4 + 8.8 * t;
        [
            100.0 + 12.0 * a - 50.0 * a.sin(),
            90.0 + 50.0 * a.cos() + 3.0 * a,
        ]
    };
    let surface = Surface {
        color: [190.0, 110.0, 60.0],
        shade: 0.35,
        gloss: 20.0,
        gloss_at: -0.3,
        shadow: 0.2,
        speckles: 1.0,
        braid: 0.0,
    };
    let strand = |from: usize, to: usize| Strand {
        points: (from..=to).map(|i| place(i as f32 / 400.0)).collect(),
        width_px: 11.0,
        surface,
    };
    let top = if first_on_top {
        strand(30, 140)
    } else {
        strand(260, 370)
    };
    (strand(0, 400), top)
}

/// The noose as RGB bytes.
fn draw_noose(first_on_top: bool) -> Vec<u8> {
    let mut random = SplitMix64::new(405);
    let (whole, top) = noose(first_on_top);
    let mut canvas = Canvas::new(SIDE, SIDE, [25.0, 28.0, 26.0]);
    canvas.paint(&whole, &mut random);
    canvas.paint(&top, &mut random);
    canvas.soften(1);
    canvas.bytes(3.0, &mut random)
}

#[test]
fn of_a_rope_over_itself_the_upper_pass_is_told_in_every_format() {
    for first_on_top in [true, false] {
        let rgb = draw_noose(first_on_top);
        let (_, top) = noose(first_on_top);
        for (format, bytes, stride) in formats(&rgb) {
            let image = Image::new(&bytes, SIDE, SIDE, stride, format).expect("a whole image");
            let mut extractor = extractor();
            let scene = extractor.extract(&image);
            assert_eq!(scene.curves.len(), 1, "{format:?}");
            assert_eq!(scene.crossings.len(), 1, "{format:?}");
            let crossing = scene.crossings[0];
            assert_eq!((crossing.over, crossing.under), (0, 0));
            let curve = &scene.curves[0];
            assert!(
                runs_along(curve, crossing.over_rho, &top),
                "{format:?} {crossing:?}"
            );
            assert!(
                !runs_along(curve, crossing.under_rho, &top),
                "{format:?} {crossing:?}"
            );
            assert!(crossing.confidence > 0.9, "{format:?} {crossing:?}");
        }
    }
}

/// RGB bytes in every pixel format, with the stride.
fn formats(rgb: &[u8]) -> Vec<(PixelFormat, Vec<u8>, usize)> {
    let yuv: Vec<[f32; 3]> = rgb
        .chunks_exact(3)
        .map(|p| {
            let [r, g, b] = [p[0], p[1], p[2]].map(f32::from);
            let y = 0.299 * r + 0.587 * g + 0.114 * b;
            [y, 128.0 + 0.564 * (b - y), 128.0 + 0.713 * (r - y)]
        })
        .collect();
    let gray: Vec<u8> = yuv.iter().map(|p| p[0] as u8).collect();
    let bgr = rgb.chunks_exact(3).flat_map(|p| [p[2], p[1], p[0]]);
    let yuyv = yuv.chunks_exact(2).flat_map(|p| {
        let mean = |c: usize| (0.5 * (p[0][c] + p[1][c])) as u8;
        [p[0][0] as u8, mean(1), p[1][0] as u8, mean(2)]
    });
    let yuyv: Vec<u8> = yuyv.collect();
    let uyvy = yuyv.chunks_exact(2).flat_map(|p| [p[1], p[0]]).collect();
    let mut nv12 = gray.clone();
    for y in (0..SIDE).step_by(2) {
        for x in (0..SIDE).step_by(2) {
            let at = y * SIDE + x;
            let four = [at, at + 1, at + SIDE, at + SIDE + 1].map(|i| yuv[i]);
            nv12.extend([1, 2].map(|c| (four.iter().map(|p| p[c]).sum::<f32>() / 4.0) as u8));
        }
    }
    vec![
        (PixelFormat::Rgb8, rgb.to_vec(), 3 * SIDE),
        (PixelFormat::Bgr8, bgr.collect(), 3 * SIDE),
        (PixelFormat::Yuyv, yuyv, 2 * SIDE),
        (PixelFormat::Uyvy, uyvy, 2 * SIDE),
        (PixelFormat::Nv12, nv12, SIDE),
        (PixelFormat::Gray8, gray, SIDE),
    ]
}

#[test]
fn ropes_that_touch_without_crossing_have_no_crossing() {
    let surface = Surface {
        color: [190.0, 110.0, 60.0],
        shade: 0.3,
        gloss: 0.0,
        gloss_at: 0.0,
        shadow: 0.0,
        speckles: 1.0,
        braid: 0.0,
    };
    for gap_px in [0.0, 0.5, 1.0, 2.0] {
        let strand = |side: f32| Strand {
            points: (-90..=90)
                .map(|s| {
                    let s = s as f32;
                    let aside = 0.5 * (12.0 + gap_px) + 0.004 * s * s;
                    [MIDDLE[0] + s, MIDDLE[1] + side * aside]
                })
                .collect(),
            width_px: 12.0,
            surface,
        };
        let mut random = SplitMix64::new(406);
        let mut canvas = Canvas::new(SIDE, SIDE, [20.0; 3]);
        canvas.paint(&strand(-1.0), &mut random);
        canvas.paint(&strand(1.0), &mut random);
        canvas.soften(1);
        let bytes = canvas.bytes(2.0, &mut random);
        let image = Image::new(&bytes, SIDE, SIDE, 3 * SIDE, PixelFormat::Rgb8);
        let mut extractor = extractor();
        let scene = extractor.extract(&image.expect("a whole image"));
        assert_eq!(scene.curves.len(), 2, "{gap_px}");
        assert_eq!(scene.crossings, [], "{gap_px}");
    }
}

#[test]
fn of_dashed_and_of_twisted_ropes_the_upper_is_told_by_its_cross_sections() {
    for class in [Class::Texture, Class::Twisted] {
        let crossings = (1001..1019).flat_map(|seed| crossings_of(class, seed));
        let [right, of] = crossings
            .filter(|crossing| crossing.angle_deg > 25.0 && crossing.connected)
            .fold([0, 0], |[right, of], crossing| {
                [right + usize::from(crossing.order_right), of + 1]
            });
        assert!(of >= 12, "{class}: {of}");
        assert!(10 * right >= 9 * of, "{class}: {right} of {of}");
    }
}

/// The scores of the crossings in a drawn picture.
fn crossings_of(class: Class, seed: u64) -> Vec<CrossingScore> {
    let (width, height) = (480, 360);
    let still = scenes::draw(class, seed, width, height).expect("every class fits into this size");
    let image = Image::new(&still.rgb, width, height, 3 * width, PixelFormat::Rgb8);
    let mut extractor = Extractor::new(Options::default()).expect("the defaults are valid");
    let scene = extractor.extract(&image.expect("the bytes are made for this size"));
    let seen = scene.crossings.iter().map(|seen| SeenCrossing {
        at: seen.at,
        over: (seen.over, seen.over_rho),
        under: (seen.under, seen.under_rho),
    });
    let seen: Vec<SeenCrossing> = seen.collect();
    scenes::score(&still.truth, &scored(scene.curves), &seen).crossings
}
