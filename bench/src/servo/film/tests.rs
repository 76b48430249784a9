//! Tests that decode films of drawn ropes.

use gif::{ColorOutput, DecodeOptions};
use lariat_capture::{RenderOptions, Source, open};
use lariat_wire::Centerlines;

use super::*;

/// Image size, and each picture's delay in hundredths of a second and pixels.
struct Decoded {
    size: [usize; 2],
    pictures: Vec<(u16, Vec<[u8; 3]>)>,
    repeats: gif::Repeat,
}

fn decoded(bytes: &[u8]) -> Decoded {
    let mut options = DecodeOptions::new();
    options.set_color_output(ColorOutput::RGBA);
    let mut decoder = options.read_info(bytes).unwrap();
    let size = [decoder.width(), decoder.height()].map(usize::from);
    let mut canvas = vec![[0; 3]; size[0] * size[1]];
    let mut pictures = Vec::new();
    while let Some(frame) = decoder.read_next_frame().unwrap() {
        let (left, top) = (usize::from(frame.left), usize::from(frame.top));
        for (i, pixel) in frame.buffer.chunks_exact(4).enumerate() {
            let (x, y) = (i % usize::from(frame.width), i / usize::from(frame.width));
            if pixel[3] > 0 {
                canvas[(top + y) * size[0] + left + x] = [pixel[0], pixel[1], pixel[2]];
            }
        }
        pictures.push((frame.delay, canvas.clone()));
    }
    let repeats = decoder.repeat();
    Decoded {
        size,
        pictures,
        repeats,
    }
}

/// Films a moving drawn rope for `count` pictures. `noise` replaces the default noise if given.
fn filmed(count: u64, noise: Option<f64>) -> (Film, Vec<Vec<u8>>) {
    let mut render = RenderOptions {
        seed: 4,
        frame_interval_s: STEP_S,
        frames: Some(count),
        ..RenderOptions::default()
    };
    render.noise = noise.unwrap_or(render.noise);
    let mut shots: Vec<(Vec<u8>, Vec<[f64; 2]>)> = Vec::new();
    let mut source = open(&Source::Rendered(render)).unwrap();
    let mut truth = Box::new(Centerlines::EMPTY);
    while let Some(frame) = source.next().unwrap() {
        let mut rgb = vec![0; frame.bytes()];
        source.write(&mut rgb);
        assert!(source.truth(&mut truth));
        let points = truth.curves[0].points[..120].iter();
        shots.push((rgb, points.map(|p| p.map(f64::from)).collect()));
    }
    let target = shots.last().unwrap().1.clone();
    let mut film = Film::new([640, 480], std::slice::from_ref(&target));
    for (i, (rgb, seen)) in shots.iter().enumerate() {
        let before = &shots[i.saturating_sub(1)].1;
        let gripper = |k: usize| {
            let [x, y] = [0, 1].map(|axis| (seen[k][axis] - before[k][axis]) / STEP_S);
            (seen[k], [x, y, 0.02 * x])
        };
        let off = seen
            .iter()
            .zip(&target)
            .map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]));
        let control_points: Vec<[f64; 2]> = seen.iter().step_by(17).copied().collect();
        let sketch = Sketch {
            // The rope is not seen in one shot.
            seen: (i != 2).then(|| seen.clone()).into_iter().collect(),
            control_points,
            grippers: vec![gripper(0), gripper(119)],
            ..Sketch::default()
        };
        film.add(&Shot {
            rgb,
            sketch: &sketch,
            at_s: STEP_S * i as f64,
            error_px: off.sum::<f64>() / 120.0,
        });
    }
    (film, shots.into_iter().map(|(rgb, _)| rgb).collect())
}

#[test]
fn the_film_shows_what_was_filmed() {
    let (film, _) = filmed(12, None);
    let drawn: Vec<Vec<[u8; 3]>> = (film.pictures.iter())
        .map(|picture| picture.picture.pixels().map(|pixel| pixel.0).collect())
        .collect();
    let bytes = film.finish().unwrap();
    let decoded = decoded(&bytes);
    assert_eq!(decoded.size, [320, 290]);
    assert_eq!(decoded.repeats, gif::Repeat::Infinite);
    let delays: Vec<u16> = decoded.pictures.iter().map(|(delay, _)| *delay).collect();
    assert_eq!(delays[..11], [10; 11]);
    assert_eq!(delays[11..], [200]);
    for ((_, pixels), drawn) in decoded.pictures.iter().zip(&drawn) {
        let apart = pixels.iter().zip(drawn).map(|(a, b)| {
            let apart = (0..3).map(|k| a[k].abs_diff(b[k])).max();
            usize::from(apart.unwrap_or(0))
        });
        let apart: Vec<usize> = apart.collect();
        let mean = apart.iter().sum::<usize>() as f64 / apart.len() as f64;
        let far = apart.iter().filter(|&&steps| steps > 40).count();
        assert!(mean < 4.0 && far < 60, "{mean} {far}");
    }
}

#[test]
fn noise_is_not_drawn_again() {
    let still = filmed(10, Some(0.0)).0.finish().unwrap().len();
    let noisy = filmed(10, None).0.finish().unwrap().len();
    let first = filmed(1, None).0.finish().unwrap().len();
    // Only the first picture contains the noise.
    assert!(noisy - first < 2 * still, "{still} {noisy} {first}");
}

#[test]
fn shots_between_its_pictures_give_their_error_only() {
    let mut film = Film::new([64, 48], &[]);
    let rgb = vec![90; 3 * 64 * 48];
    let sketch = Sketch {
        ellipses: vec![vec![[f64::NAN, f64::INFINITY]; 3]],
        grippers: vec![([f64::NAN, 0.0], [f64::INFINITY, 1.0, f64::NAN])],
        ..Sketch::default()
    };
    for i in 0..60 {
        // Thirty frames per second, like a camera.
        let at_s = f64::from(i) / 30.0 + if i % 2 == 0 { 2e-3 } else { -2e-3 };
        film.add(&Shot {
            rgb: if i == 30 { &[] } else { &rgb },
            sketch: &sketch,
            at_s,
            error_px: if i == 0 { f64::INFINITY } else { 40.0 },
        });
    }
    assert_eq!((film.pictures.len(), film.errors.len()), (20, 60));
    let decoded = decoded(&film.finish().unwrap());
    let sum: u32 = decoded
        .pictures
        .iter()
        .map(|(delay, _)| u32::from(*delay))
        .sum();
    assert!(sum.abs_diff(390) <= 4, "{sum}");
    assert_eq!(decoded.size, [64, 98]);
    assert_eq!(decoded.pictures[5].1[64 * 24 + 60], [90; 3]);
}

#[test]
fn a_film_of_nothing_is_refused_with_a_sentence() {
    let error = Film::new([640, 480], &[]).finish().unwrap_err();
    assert!(error.to_string().starts_with("there is no film"), "{error}");
}
