//! The background of a picture.

use std::f32::consts::{FRAC_PI_2, PI};

use crate::canvas::{
    Canvas, Field, Noise, Rgb, color, covered, direction, dot, happens, minus, mix, normal, scaled,
    spread,
};
use crate::photographs::Photographs;
use crate::stroke;
use lariat_portable::SplitMix64;

/// Draws a surface over the whole picture.
pub(crate) fn draw(side: usize, photographs: &Photographs, random: &mut SplitMix64) -> Canvas {
    if !photographs.is_empty() && happens(random, 0.42) {
        return photograph(side, photographs, random);
    }
    let mut canvas = Field::of(side, color(random));
    match random.below(37) {
        0..6 => plain(&mut canvas, random),
        6..9 => cloudy(&mut canvas, random),
        9..12 => wood(&mut canvas, random),
        12..14 => cloth(&mut canvas, random),
        14..16 => lattice(&mut canvas, random),
        16 => holes(&mut canvas, random),
        17 => gravel(&mut canvas, random),
        18 => metal(&mut canvas, random),
        19..22 => bands(&mut canvas, random),
        22..24 => patches(&mut canvas, random),
        24..31 => stroke::many(&mut canvas, random),
        31..33 => dots(&mut canvas, random),
        _ => tiles(&mut canvas, random),
    }
    canvas
}

fn photograph(side: usize, photographs: &Photographs, random: &mut SplitMix64) -> Canvas {
    let mut canvas = photographs.cut(side, random);
    if happens(random, 0.5) {
        let gain = [(); 3].map(|()| random.uniform_f32(0.5, 1.2));
        let lift = random.uniform_f32(-30.0, 40.0);
        for pixel in &mut canvas.values {
            *pixel = [0, 1, 2].map(|k| pixel[k] * gain[k] + lift);
        }
    }
    canvas
}

/// Adds noise of these octaves with this amplitude in levels, the same for each color.
fn mottle(canvas: &mut Canvas, noise: &Noise, levels: f32, random: &mut SplitMix64) {
    let tint = [(); 3].map(|()| random.uniform_f32(0.7, 1.1));
    let field = noise.draw(canvas.side, random);
    for (pixel, value) in canvas.values.iter_mut().zip(&field.values) {
        *pixel = [0, 1, 2].map(|k| pixel[k] + levels * tint[k] * value);
    }
}

fn plain(canvas: &mut Canvas, random: &mut SplitMix64) {
    let levels = random.uniform_f32(0.0, 12.0);
    mottle(canvas, &Noise::even(48.0, 256.0, 0.7), levels, random);
    let levels = random.uniform_f32(0.0, 4.0);
    mottle(canvas, &Noise::even(1.0, 4.0, 0.3), levels, random);
}

fn cloudy(canvas: &mut Canvas, random: &mut SplitMix64) {
    for _ in 0..2 {
        let slope = random.uniform_f32(0.0, 1.2);
        let finest_px = spread(random, 1.0, 8.0);
        let levels = random.uniform_f32(3.0, 28.0);
        mottle(
            canvas,
            &Noise::even(finest_px, 128.0, slope),
            levels,
            random,
        );
    }
}

fn wood(canvas: &mut Canvas, random: &mut SplitMix64) {
    let angle = random.uniform_f32(0.0, PI);
    let noise = Noise {
        aspect: random.uniform_f32(8.0, 30.0),
        angle,
        ..Noise::even(1.5, 64.0, random.uniform_f32(0.2, 0.9))
    };
    let levels = random.uniform_f32(4.0, 26.0);
    mottle(canvas, &noise, levels, random);
    if happens(random, 0.5) {
        // Planks with a dark gap between them.
        let across = direction(angle + 1.57);
        let width_px = random.uniform_f32(40.0, 140.0);
        let at_px = random.uniform_f32(0.0, width_px);
        let gap_px = random.uniform_f32(0.4, 2.5);
        let dark = random.uniform_f32(0.2, 0.9);
        let lights: [f32; 16] = std::array::from_fn(|_| 1.0 + 0.08 * normal(random));
        for (at, pixel) in canvas.places() {
            let place = dot(at, across) + at_px + 100.0 * width_px;
            let plank = (place / width_px) as usize;
            let from_px = place % width_px;
            let gap = covered(from_px.min(width_px - from_px) - gap_px);
            *pixel = scaled(*pixel, lights[plank % 16] * (1.0 - dark * gap));
        }
    }
    if happens(random, 0.3) {
        mottle(canvas, &Noise::even(1.0, 4.0, 0.2), 4.0, random);
    }
}

fn cloth(canvas: &mut Canvas, random: &mut SplitMix64) {
    let along = direction(random.uniform_f32(0.0, PI));
    let turns = random.uniform_f32(0.5, 2.4);
    let levels = random.uniform_f32(3.0, 18.0);
    let bend = Noise::even(30.0, 120.0, 0.8).draw(canvas.side, random);
    let bends = bend.values.clone();
    for ((at, pixel), bend) in canvas.places().zip(bends) {
        let [x, y] = [dot(at, along), at[1] * along[0] - at[0] * along[1]];
        let thread = libm::sinf(turns * (x + 2.0 * bend)) + libm::sinf(turns * (y + 2.0 * bend));
        *pixel = pixel.map(|value| value + levels * thread);
    }
    let levels = random.uniform_f32(1.0, 10.0);
    mottle(canvas, &Noise::even(1.0, 8.0, 0.3), levels, random);
    if happens(random, 0.5) {
        // Folds.
        let levels = random.uniform_f32(5.0, 25.0);
        mottle(
            canvas,
            &Noise {
                aspect: 4.0,
                angle: random.uniform_f32(0.0, PI),
                ..Noise::even(16.0, 64.0, 0.5)
            },
            levels,
            random,
        );
    }
}

/// Draws wavy parallel lines: marble, coarse grain, contours on a map, waves.
fn bands(canvas: &mut Canvas, random: &mut SplitMix64) {
    let across = direction(random.uniform_f32(0.0, PI));
    let period_px = spread(random, 4.0, 40.0);
    let bend_px = period_px * random.uniform_f32(0.3, 5.0);
    let coarsest_px = spread(random, 40.0, 250.0);
    let noise = Noise {
        aspect: random.uniform_f32(1.0, 6.0),
        angle: libm::atan2f(across[1], across[0]) + FRAC_PI_2,
        ..Noise::even(0.3 * coarsest_px, coarsest_px, 0.9)
    };
    let bends = noise.draw(canvas.side, random).values;
    let ink = if happens(random, 0.6) {
        scaled(canvas.values[0], random.uniform_f32(0.4, 1.5))
    } else {
        color(random)
    };
    let sharpness = random.uniform_f32(0.5, 4.0);
    let level = random.uniform_f32(-0.7, 0.7);
    for ((at, pixel), bend) in canvas.places().zip(bends) {
        let wave = libm::sinf(2.0 * PI * (dot(at, across) + bend_px * bend) / period_px);
        *pixel = mix(
            *pixel,
            ink,
            (0.5 + sharpness * (wave - level)).clamp(0.0, 1.0),
        );
    }
}

/// Draws patches of a few colors: camouflage, lichen, a map, printed cloth.
fn patches(canvas: &mut Canvas, random: &mut SplitMix64) {
    for _ in 0..1 + random.below(4) {
        let coarsest_px = spread(random, 10.0, 120.0);
        let noise = Noise::even(0.2 * coarsest_px, coarsest_px, random.uniform_f32(0.4, 1.2));
        let field = noise.draw(canvas.side, random).values;
        let ink = color(random);
        let level = random.uniform_f32(-0.3, 0.9);
        let sharpness = spread(random, 1.0, 12.0);
        for (pixel, value) in canvas.values.iter_mut().zip(field) {
            *pixel = mix(
                *pixel,
                ink,
                (0.5 + sharpness * (value - level)).clamp(0.0, 1.0),
            );
        }
    }
    if happens(random, 0.5) {
        let levels = random.uniform_f32(1.0, 10.0);
        mottle(canvas, &Noise::even(1.0, 8.0, 0.3), levels, random);
    }
}

/// Draws discs of a few colors or of many, like terrazzo or a painter's floor.
fn dots(canvas: &mut Canvas, random: &mut SplitMix64) {
    let largest_px = spread(random, 3.0, 22.0);
    let share = random.uniform_f32(0.1, 1.2) * (canvas.side * canvas.side) as f32;
    let count = (share / (largest_px * largest_px)) as usize;
    let palette: [Rgb; 4] = std::array::from_fn(|_| color(random));
    let is_many = happens(random, 0.6);
    for _ in 0..count {
        let middle = [(); 2].map(|()| random.uniform_f32(0.0, canvas.side as f32));
        let radius_px = largest_px * random.uniform_f32(0.2, 1.0);
        let ink = match is_many {
            true => color(random),
            false => palette[random.below(4)],
        };
        let around = |c: usize| {
            let (from, to) = (middle[c] - radius_px - 1.0, middle[c] + radius_px + 2.0);
            from.max(0.0) as usize..(to as usize).min(canvas.side)
        };
        for y in around(1) {
            for x in around(0) {
                let off = minus([x as f32, y as f32], middle);
                let pixel = &mut canvas.values[y * canvas.side + x];
                *pixel = mix(*pixel, ink, covered(dot(off, off).sqrt() - radius_px));
            }
        }
    }
}

/// Returns two directions, more often than not near the picture's axes.
fn axes(random: &mut SplitMix64) -> [[f32; 2]; 2] {
    let angle = if happens(random, 0.6) {
        0.05 * normal(random)
    } else {
        random.uniform_f32(0.0, PI)
    };
    [direction(angle), direction(angle + FRAC_PI_2)]
}

/// Draws a chess board, lines, or a grid of lines.
fn lattice(canvas: &mut Canvas, random: &mut SplitMix64) {
    let axes = axes(random);
    let ink = color(random);
    let period_px = spread(random, 8.0, 70.0);
    let share = random.uniform_f32(0.05, 0.5);
    let kind = random.below(3);
    canvas.lay(|at| {
        let lines = axes.map(|axis| {
            let place = (dot(at, axis) + 4000.0) % period_px;
            covered((place - 0.5 * share * period_px).abs() - 0.5 * share * period_px)
        });
        let cover = match kind {
            0 => lines[0] + lines[1] - 2.0 * lines[0] * lines[1],
            1 => lines[0],
            _ => lines[0].max(lines[1]),
        };
        (cover, ink)
    });
}

fn holes(canvas: &mut Canvas, random: &mut SplitMix64) {
    let axes = axes(random);
    let ink = if happens(random, 0.6) {
        scaled(canvas.values[0], random.uniform_f32(0.1, 0.6))
    } else {
        color(random)
    };
    let period_px = spread(random, 8.0, 45.0);
    let radius_px = period_px * random.uniform_f32(0.12, 0.42);
    canvas.lay(|at| {
        let [x, y] = axes.map(|axis| (dot(at, axis) + 4000.0) % period_px - 0.5 * period_px);
        (covered((x * x + y * y).sqrt() - radius_px), ink)
    });
}

/// Draws stones: each position belongs to the nearest of many points, and is darker near the border
/// to the next.
fn gravel(canvas: &mut Canvas, random: &mut SplitMix64) {
    let cell_px = spread(random, 5.0, 40.0);
    let count = (canvas.side as f32 / cell_px) as usize + 3;
    let stones: Vec<([f32; 2], Rgb)> = (0..count * count)
        .map(|i| {
            let cell = [i % count, i / count];
            let at = cell.map(|c| (c as f32 - 1.0 + random.unit_f32()) * cell_px);
            let light = 1.0 + 0.25 * normal(random);
            (at, [(); 3].map(|()| light * (1.0 + 0.06 * normal(random))))
        })
        .collect();
    let gap = random.uniform_f32(0.05, 0.5);
    for (at, pixel) in canvas.places() {
        let cell = at.map(|c| (c / cell_px) as usize + 1);
        let (mut nearest, mut second) = ((f32::MAX, 0), f32::MAX);
        for row in cell[1] - 1..=cell[1] + 1 {
            for column in cell[0] - 1..=cell[0] + 1 {
                let i = (row * count + column).min(stones.len() - 1);
                let off = [0, 1].map(|k| stones[i].0[k] - at[k]);
                let distance = dot(off, off).sqrt();
                if distance < nearest.0 {
                    second = nearest.0;
                    nearest = (distance, i);
                } else {
                    second = second.min(distance);
                }
            }
        }
        let edge = ((second - nearest.0) / (0.3 * cell_px)).min(1.0);
        let tint = stones[nearest.1].1;
        *pixel = [0, 1, 2].map(|k| pixel[k] * tint[k] * (1.0 - gap * (1.0 - edge)));
    }
}

/// Draws brushed metal with broad reflections.
fn metal(canvas: &mut Canvas, random: &mut SplitMix64) {
    let level = random.uniform_f32(60.0, 220.0);
    for pixel in &mut canvas.values {
        *pixel = mix(*pixel, [level; 3], 0.85);
    }
    let angle = random.uniform_f32(0.0, PI);
    let brushed = Noise {
        aspect: 40.0,
        angle,
        ..Noise::even(1.0, 4.0, 0.1)
    };
    let levels = random.uniform_f32(1.0, 9.0);
    mottle(canvas, &brushed, levels, random);
    let glare = Noise {
        aspect: 5.0,
        angle: angle + 1.57,
        ..Noise::even(50.0, 200.0, 0.6)
    };
    let levels = random.uniform_f32(5.0, 40.0);
    mottle(canvas, &glare, levels, random);
}

/// Draws tiles or bricks: shifted rows, a brightness for each piece, and joints between them.
fn tiles(canvas: &mut Canvas, random: &mut SplitMix64) {
    let axes = axes(random);
    let size_px = [0; 2].map(|_| spread(random, 14.0, 300.0));
    let joint_px = spread(random, 0.4, 4.0);
    let joint = color(random);
    let shift = if happens(random, 0.5) { 0.5 } else { 0.0 };
    let lights: [f32; 64] = std::array::from_fn(|_| 1.0 + 0.12 * normal(random));
    for (at, pixel) in canvas.places() {
        let y = (dot(at, axes[1]) + 50.0 * size_px[1]) / size_px[1];
        let row = y as usize;
        let x = (dot(at, axes[0]) + 50.0 * size_px[0]) / size_px[0] + shift * (row % 2) as f32;
        let place = [x - x.floor(), y - y.floor()];
        let edge_px = [0, 1].map(|k| place[k].min(1.0 - place[k]) * size_px[k]);
        *pixel = scaled(*pixel, lights[(x as usize * 7 + row * 13) % 64]);
        *pixel = mix(
            *pixel,
            joint,
            covered(edge_px[0].min(edge_px[1]) - joint_px),
        );
    }
    let levels = random.uniform_f32(1.0, 16.0);
    mottle(canvas, &Noise::even(1.0, 48.0, 0.5), levels, random);
}
