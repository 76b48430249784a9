//! Objects that are not ropes but have similar edges, strokes and bars: print, boxes, tools,
//! panels, rails.

use std::f32::consts::{FRAC_PI_2, PI};

use crate::canvas::{
    Canvas, Field, Noise, Rgb, Vec2, color, covered, direction, dot, happens, minus, mix, normal,
    scaled, shadow, spread,
};
use crate::stroke as brush;
use crate::tool;
use lariat_portable::SplitMix64;

/// Position and orientation of an object.
#[derive(Clone, Copy)]
struct Frame {
    at: Vec2,
    along: Vec2,
}

impl Frame {
    /// Returns a frame in or near the picture. More often than not it is aligned with the picture's
    /// sides.
    fn draw(side: usize, random: &mut SplitMix64) -> Self {
        let side_px = side as f32;
        let angle = if happens(random, 0.55) {
            FRAC_PI_2 * random.below(4) as f32 + 0.04 * normal(random)
        } else {
            random.uniform_f32(0.0, 2.0 * PI)
        };
        Self {
            at: [(); 2].map(|()| random.uniform_f32(-0.1 * side_px, 1.1 * side_px)),
            along: direction(angle),
        }
    }

    fn own(&self, at: Vec2) -> Vec2 {
        let off = minus(at, self.at);
        [
            dot(off, self.along),
            off[1] * self.along[0] - off[0] * self.along[1],
        ]
    }
}

fn length(a: Vec2) -> f32 {
    dot(a, a).sqrt()
}

/// Returns the signed distance from a rectangle with rounded corners that is centered on the
/// origin.
fn slab(at: Vec2, half: Vec2, round: f32) -> f32 {
    let off = [0, 1].map(|k| at[k].abs() - half[k] + round);
    length(off.map(|d| d.max(0.0))) + off[0].max(off[1]).min(0.0) - round
}

/// Returns the distance from a stroke between two points.
fn stroke(at: Vec2, from: Vec2, to: Vec2) -> f32 {
    let (along, off) = (minus(to, from), minus(at, from));
    let share = (dot(off, along) / dot(along, along).max(1e-6)).clamp(0.0, 1.0);
    length(minus(off, along.map(|c| share * c)))
}

/// Draws one object of any kind.
pub(crate) fn lay(canvas: &mut Canvas, random: &mut SplitMix64) {
    match random.below(33) {
        0..3 => rectangle(canvas, random),
        3 => frame(canvas, random),
        4..6 => polygon(canvas, random),
        6 => disc(canvas, random),
        7..10 => ring(canvas, random),
        10..14 => text(canvas, random),
        14..16 => lines(canvas, random),
        16..18 => bar(canvas, random),
        18..20 => half(canvas, random),
        20 => arc(canvas, random),
        21 => keys(canvas, random),
        22 => slots(canvas, random),
        23..25 => rails(canvas, random),
        25..28 => brush::lay(canvas, random),
        28..32 => tool::lay(canvas, random),
        _ => blob(canvas, random),
    }
}

/// Draws the shape that a signed distance cuts out: with or without a shadow, in a flat, shaded or
/// mottled color.
fn cut(canvas: &mut Canvas, random: &mut SplitMix64, distance: impl Fn(Vec2) -> f32) {
    let rgb = color(random);
    cut_in(canvas, random, rgb, distance);
}

fn cut_in(canvas: &mut Canvas, random: &mut SplitMix64, rgb: Rgb, distance: impl Fn(Vec2) -> f32) {
    let side = canvas.side;
    let mut cover = Field::of(side, 0.0);
    for (at, value) in cover.places() {
        *value = covered(distance(at));
    }
    if happens(random, 0.35) {
        let by = [(); 2].map(|()| 4.0 * normal(random));
        let fall = shadow(&cover, by, random.uniform_f32(0.6, 6.0));
        canvas.darken(&fall, random.uniform_f32(0.1, 0.6));
    }
    let to = if happens(random, 0.4) {
        scaled(rgb, random.uniform_f32(0.5, 1.4))
    } else {
        rgb
    };
    let slope =
        direction(random.uniform_f32(0.0, 2.0 * PI)).map(|c| c / random.uniform_f32(40.0, 200.0));
    let middle = [(); 2].map(|()| random.uniform_f32(0.0, side as f32));
    let levels = if happens(random, 0.35) {
        random.uniform_f32(2.0, 22.0)
    } else {
        0.0
    };
    let mottling = if levels > 0.0 {
        Noise::even(spread(random, 1.0, 12.0), 64.0, 0.4).draw(side, random)
    } else {
        Field::of(side, 0.0)
    };
    let painted: Vec<_> = cover.values.iter().zip(&mottling.values).collect();
    let edge = happens(random, 0.35).then(|| Edge::draw(random));
    for ((at, pixel), (&cover, noise)) in canvas.places().zip(painted) {
        if cover > 0.0 {
            let share = (0.5 + dot(minus(at, middle), slope)).clamp(0.0, 1.0);
            let light = edge.as_ref().map_or(1.0, |edge| edge.light(at, &distance));
            let paint = mix(rgb, to, share).map(|value| light * value + levels * noise);
            *pixel = mix(*pixel, paint, cover);
        }
    }
}

/// A beveled or rounded edge: light where it faces the lamp, dark where it does not.
struct Edge {
    wide_px: f32,
    lamp: Vec2,
    is_round: bool,
}

impl Edge {
    fn draw(random: &mut SplitMix64) -> Self {
        let contrast = random.uniform_f32(0.15, 0.9);
        Self {
            wide_px: spread(random, 1.0, 9.0),
            lamp: direction(random.uniform_f32(0.0, 2.0 * PI)).map(|c| contrast * c),
            is_round: happens(random, 0.5),
        }
    }

    /// Returns the light at a position inside, relative to that of the middle.
    fn light(&self, at: Vec2, distance: impl Fn(Vec2) -> f32) -> f32 {
        let here = distance(at);
        if here < -self.wide_px {
            return 1.0;
        }
        let slope = [[1.0, 0.0], [0.0, 1.0]]
            .map(|step| distance([at[0] + step[0], at[1] + step[1]]) - here);
        let facing = dot(slope, self.lamp);
        if self.is_round {
            1.0 + facing * (1.0 + here / self.wide_px).clamp(0.0, 1.0)
        } else {
            1.0 + facing
        }
    }
}

fn rectangle(canvas: &mut Canvas, random: &mut SplitMix64) {
    let frame = Frame::draw(canvas.side, random);
    let half = [(); 2].map(|()| spread(random, 3.0, 90.0));
    let round = if happens(random, 0.5) {
        0.0
    } else {
        random.uniform_f32(0.0, 0.7) * half[0].min(half[1])
    };
    cut(canvas, random, |at| slab(frame.own(at), half, round));
}

/// Draws the outline of a rectangle, or of one inside another.
fn frame(canvas: &mut Canvas, random: &mut SplitMix64) {
    let frame = Frame::draw(canvas.side, random);
    let half = [(); 2].map(|()| spread(random, 12.0, 120.0));
    let round = random.uniform_f32(0.0, 0.5) * half[0].min(half[1]);
    let thick = spread(random, 0.6, 8.0);
    cut(canvas, random, |at| {
        slab(frame.own(at), half, round).abs() - 0.5 * thick
    });
}

fn polygon(canvas: &mut Canvas, random: &mut SplitMix64) {
    let frame = Frame::draw(canvas.side, random);
    let size = spread(random, 8.0, 130.0);
    let count = 3 + random.below(4);
    // Convex: the intersection of the half-planes of all sides.
    let sides: Vec<(Vec2, f32)> = (0..count)
        .map(|k| {
            let angle = 2.0 * PI * (k as f32 + random.uniform_f32(-0.35, 0.35)) / count as f32;
            (direction(angle), size * random.uniform_f32(0.25, 1.0))
        })
        .collect();
    cut(canvas, random, |at| {
        let own = frame.own(at);
        let beyond = |(normal, away): &(Vec2, f32)| dot(own, *normal) - away;
        sides.iter().map(beyond).fold(f32::MIN, f32::max)
    });
}

fn disc(canvas: &mut Canvas, random: &mut SplitMix64) {
    let frame = Frame::draw(canvas.side, random);
    let radius = spread(random, 2.0, 70.0);
    let flat = random.uniform_f32(0.4, 1.0);
    cut(canvas, random, |at| {
        let [x, y] = frame.own(at);
        (length([x, y / flat]) - radius) * flat
    });
    if happens(random, 0.4) {
        // A screw's slot or a knob's mark.
        let half = [0.7 * radius, (0.12 * radius).max(0.6)];
        cut(canvas, random, |at| slab(frame.own(at), half, 0.0));
    }
}

fn ring(canvas: &mut Canvas, random: &mut SplitMix64) {
    let frame = Frame::draw(canvas.side, random);
    let radius = spread(random, 4.0, 60.0);
    let thick = (radius * random.uniform_f32(0.05, 0.4)).max(0.8);
    cut(canvas, random, |at| {
        (length(frame.own(at)) - radius).abs() - 0.5 * thick
    });
}

/// Draws lines of letters, each made of strokes between the points of a 3 × 5 grid.
fn text(canvas: &mut Canvas, random: &mut SplitMix64) {
    let frame = Frame::draw(canvas.side, random);
    let height = spread(random, 5.0, 90.0);
    let rows = if height < 18.0 {
        1 + random.below(7)
    } else {
        1
    };
    let letters = 1 + random.below(if height < 30.0 { 16 } else { 5 });
    let weight = (height * random.uniform_f32(0.05, 0.24)).max(0.7);
    let advance = height * random.uniform_f32(0.6, 0.85);
    let leading = height * random.uniform_f32(1.3, 1.9);
    let width = 0.62 * advance;
    let glyphs: Vec<Vec<[Vec2; 2]>> = (0..rows * letters)
        .map(|_| {
            if happens(random, 0.14) {
                Vec::new()
            } else {
                glyph(random)
            }
        })
        .collect();
    let scale = [width, height];
    cut(canvas, random, |at| {
        let [x, y] = frame.own(at);
        let (column, row) = ((x / advance).floor(), (y / leading).floor());
        if column < 0.0 || row < 0.0 || column as usize >= letters || row as usize >= rows {
            return 9.0;
        }
        let place = [
            x - column * advance - 0.5 * weight,
            y - row * leading - 0.5 * weight,
        ];
        let strokes = &glyphs[row as usize * letters + column as usize];
        let away = strokes.iter().map(|stroke_| {
            let [from, to] = stroke_.map(|end| [end[0] * scale[0], end[1] * scale[1]]);
            stroke(place, from, to)
        });
        away.fold(9.0 + weight, f32::min) - 0.5 * weight
    });
}

/// Returns the strokes of a letter in a box of 1 × 1.
fn glyph(random: &mut SplitMix64) -> Vec<[Vec2; 2]> {
    let mut points =
        [[0.0; 2]; 6].map(|_: Vec2| [0.5 * random.below(3) as f32, 0.25 * random.below(5) as f32]);
    // Most letters have an upright.
    if happens(random, 0.7) {
        let x = if happens(random, 0.8) { 0.0 } else { 0.5 };
        points[0] = [x, 0.0];
        points[1] = [x, 1.0];
    }
    let count = 2 + random.below(4);
    let mut strokes: Vec<_> = points
        .windows(2)
        .take(count)
        .map(|pair| [pair[0], pair[1]])
        .collect();
    if happens(random, 0.4) {
        // A bowl of eight short strokes.
        let on = |k: usize| {
            let [c, s] = direction(k as f32 * PI / 4.0);
            [0.4 + 0.4 * c, 0.7 + 0.3 * s]
        };
        strokes.truncate(1);
        strokes.extend((0..8).map(|k| [on(k), on(k + 1)]));
    }
    strokes
}

/// Draws straight lines, alone or in parallel: rulings, joints, edges.
fn lines(canvas: &mut Canvas, random: &mut SplitMix64) {
    let frame = Frame::draw(canvas.side, random);
    let count = 1 + random.below(8);
    let apart = spread(random, 3.0, 40.0);
    let thick = spread(random, 0.5, 4.0);
    let half = spread(random, 15.0, 300.0);
    cut(canvas, random, |at| {
        let [x, y] = frame.own(at);
        let row = (y / apart).round().clamp(0.0, (count - 1) as f32);
        slab([x, y - row * apart], [half, 0.5 * thick], 0.0)
    });
}

/// Draws a pen, a handle or a tube: a straight round body with parts of other colors, short
/// relative to its width.
fn bar(canvas: &mut Canvas, random: &mut SplitMix64) {
    let frame = Frame::draw(canvas.side, random);
    let half_width = 0.5 * spread(random, 4.0, 40.0);
    let half_length = half_width * random.uniform_f32(2.5, 13.0);
    let rgb = color(random);
    let parts = [(); 3].map(|()| {
        (
            random.uniform_f32(-1.4, 1.4) * half_length,
            if happens(random, 0.4) {
                color(random)
            } else {
                rgb
            },
        )
    });
    let taper = if happens(random, 0.4) {
        random.uniform_f32(0.0, 0.6)
    } else {
        0.0
    };
    let (dark, shine) = (random.uniform_f32(0.3, 0.9), random.uniform_f32(0.0, 150.0));
    let lamp = random.uniform_f32(-0.6, 0.6);
    let body = |at: Vec2| {
        let [x, y] = frame.own(at);
        let width = half_width * (1.0 - taper * (x / half_length).clamp(0.0, 1.0));
        (
            slab([x, y], [half_length, width], 0.3 * width),
            x,
            y / width,
        )
    };
    let mut cover = Field::of(canvas.side, 0.0);
    for (at, value) in cover.places() {
        *value = covered(body(at).0);
    }
    let by = [(); 2].map(|()| 0.4 * half_width * normal(random));
    let fall = shadow(&cover, by, 0.4 * half_width + 0.5);
    canvas.darken(&fall, random.uniform_f32(0.0, 0.6));
    canvas.lay(|at| {
        let (distance, x, across) = body(at);
        let paint = parts
            .iter()
            .fold(rgb, |rgb, part| if x > part.0 { part.1 } else { rgb });
        let facing = (1.0 - (across - lamp) * (across - lamp)).max(0.0);
        let light = dark + (1.0 - dark) * facing;
        let glint = shine * libm::powf(facing, 12.0);
        (covered(distance), paint.map(|value| value * light + glint))
    });
}

/// Draws another surface on one side of a straight edge.
fn half(canvas: &mut Canvas, random: &mut SplitMix64) {
    let frame = Frame::draw(canvas.side, random);
    let strip = if happens(random, 0.4) {
        spread(random, 1.0, 10.0)
    } else {
        0.0
    };
    cut(canvas, random, |at| frame.own(at)[1]);
    if strip > 0.0 {
        // With a rim.
        cut(canvas, random, |at| frame.own(at)[1].abs() - 0.5 * strip);
    }
}

/// Draws another surface on one side of a wide arc.
fn arc(canvas: &mut Canvas, random: &mut SplitMix64) {
    let frame = Frame::draw(canvas.side, random);
    let radius = spread(random, 60.0, 700.0);
    let thick = if happens(random, 0.4) {
        spread(random, 1.0, 10.0)
    } else {
        0.0
    };
    cut(canvas, random, |at| {
        let [x, y] = frame.own(at);
        let away = length([x, y - radius]) - radius;
        if thick > 0.0 {
            away.abs() - 0.5 * thick
        } else {
            away
        }
    });
}

/// Draws an array of keys, buttons or sockets.
fn keys(canvas: &mut Canvas, random: &mut SplitMix64) {
    let frame = Frame::draw(canvas.side, random);
    let pitch = [(); 2].map(|()| spread(random, 9.0, 36.0));
    let half = pitch.map(|p| p * random.uniform_f32(0.28, 0.46));
    let count = [(); 2].map(|()| (2 + random.below(10)) as f32);
    let round = 0.3 * half[0].min(half[1]);
    let cell = |at: Vec2| {
        let own = frame.own(at);
        [0, 1].map(|k| {
            let index = (own[k] / pitch[k]).round().clamp(0.0, count[k] - 1.0);
            own[k] - index * pitch[k]
        })
    };
    if happens(random, 0.5) {
        let middle = [0, 1].map(|k| 0.5 * (count[k] - 1.0) * pitch[k]);
        let whole = [0, 1].map(|k| 0.56 * count[k] * pitch[k]);
        cut(canvas, random, |at| {
            slab(minus(frame.own(at), middle), whole, 4.0)
        });
    }
    cut(canvas, random, |at| slab(cell(at), half, round));
    if happens(random, 0.7) {
        let mark = half.map(|h| h * random.uniform_f32(0.1, 0.6));
        cut(canvas, random, |at| slab(cell(at), mark, 0.0));
    }
}

/// Draws a grille: parallel slots, usually dark.
fn slots(canvas: &mut Canvas, random: &mut SplitMix64) {
    let frame = Frame::draw(canvas.side, random);
    let pitch = spread(random, 5.0, 26.0);
    let half = [
        spread(random, 10.0, 90.0),
        pitch * random.uniform_f32(0.12, 0.36),
    ];
    let count = (3 + random.below(14)) as f32;
    let round = if happens(random, 0.6) { half[1] } else { 0.0 };
    let rgb = if happens(random, 0.6) {
        [random.uniform_f32(5.0, 50.0); 3]
    } else {
        color(random)
    };
    cut_in(canvas, random, rgb, |at| {
        let [x, y] = frame.own(at);
        let row = (y / pitch).round().clamp(0.0, count - 1.0);
        slab([x, y - row * pitch], half, round)
    });
}

/// Draws a profile of metal or plastic: parallel bands, each with its own brightness.
fn rails(canvas: &mut Canvas, random: &mut SplitMix64) {
    let frame = Frame::draw(canvas.side, random);
    let rgb = color(random);
    let mut at_px = 0.0;
    let bands: Vec<(f32, f32)> = (0..3 + random.below(6))
        .map(|_| {
            at_px += spread(random, 1.5, 14.0);
            (at_px, random.uniform_f32(0.35, 1.5))
        })
        .collect();
    let half = if happens(random, 0.5) {
        1e4
    } else {
        spread(random, 40.0, 300.0)
    };
    // Rounded, or with edges.
    let soft = if happens(random, 0.5) {
        random.unit_f32()
    } else {
        0.0
    };
    canvas.lay(|at| {
        let [x, y] = frame.own(at);
        let k = bands.iter().position(|band| y < band.0).unwrap_or(0);
        let (end, light) = bands[k];
        let begin = if k > 0 { bands[k - 1].0 } else { 0.0 };
        let share = ((y - begin) / (end - begin)).clamp(0.0, 1.0);
        let next = bands[(k + 1) % bands.len()].1;
        let light = light + soft * share * (next - light);
        let distance = slab([x, y - 0.5 * at_px], [half, 0.5 * at_px], 0.0);
        (covered(distance), scaled(rgb, light))
    });
}

/// Draws an object without straight sides: a stone, a stain, a leaf.
fn blob(canvas: &mut Canvas, random: &mut SplitMix64) {
    let frame = Frame::draw(canvas.side, random);
    let radius = spread(random, 5.0, 80.0);
    let waves = [(); 4].map(|()| (random.uniform_f32(0.0, 0.25), random.uniform_f32(0.0, 6.3)));
    cut(canvas, random, |at| {
        let [x, y] = frame.own(at);
        let angle = libm::atan2f(y, x);
        let bend: f32 = waves
            .iter()
            .zip(2..)
            .map(|((height, phase), k)| height * libm::sinf(k as f32 * angle + phase))
            .sum();
        0.7 * (length([x, y]) - radius * (1.0 + bend))
    });
}
