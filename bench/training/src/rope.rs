//! Appearance of ropes, and the drawing of a rope on a picture.

use std::f32::consts::{PI, TAU};

use crate::canvas::{
    Canvas, Field, Paint, Rgb, Vec2, color, covered, direction, dot, happens, minus, mix, normal,
    shadow,
};
use crate::path::Path;
use lariat_portable::SplitMix64;

/// The lamp of a picture.
pub(crate) struct Lamp {
    /// Direction to the lamp as a unit vector: x, y, and height.
    from: [f32; 3],
    /// Share of the light that a shadow removes.
    shade: f32,
    /// Softness of shadows, in widths.
    softness: f32,
}

impl Lamp {
    pub(crate) fn draw(random: &mut SplitMix64) -> Self {
        let height = random.uniform_f32(0.3, 1.0);
        let side = (1.0 - height * height).sqrt();
        let [x, y] = direction(random.uniform_f32(0.0, TAU)).map(|c| side * c);
        Self {
            from: [x, y, height],
            shade: random.uniform_f32(0.0, 0.65),
            softness: random.uniform_f32(0.1, 1.2),
        }
    }
}

#[derive(Clone, Copy)]
enum Pattern {
    Plain,
    /// A band of the second color along one side.
    Halves {
        from: f32,
    },
    /// Strands of two colors, or of one with grooves between them.
    Twisted {
        pitch: f32,
        lean: f32,
    },
    /// Crossing threads.
    Braided {
        pitch: f32,
    },
    /// Rings of the second color.
    Ringed {
        pitch: f32,
        share: f32,
    },
}

/// Appearance of a rope. Lengths are in rope widths.
#[derive(Clone)]
pub(crate) struct RopeStyle {
    rgb: Rgb,
    second: Rgb,
    pattern: Pattern,
    groove: f32,
    /// Brightness of the side that faces away from the lamp.
    ambient: f32,
    shine: f32,
    shine_power: f32,
    /// Sleeve or plug at each end, if any.
    tips: [Option<Tip>; 2],
    speckle: f32,
    height: f32,
}

/// Color of a ferrule's pin.
const TIN: Rgb = [185.0, 185.0, 190.0];

#[derive(Clone, Copy)]
struct Tip {
    length: f32,
    width: f32,
    rgb: Rgb,
    /// Length and width of the bare pin at its end, if any.
    pin: Option<[f32; 2]>,
}

impl RopeStyle {
    pub(crate) fn draw(random: &mut SplitMix64) -> Self {
        let paints = [
            Paint::Bright,
            Paint::Bright,
            Paint::Bright,
            Paint::Bright,
            Paint::Any,
            Paint::Gray,
            Paint::Light,
            Paint::Dark,
            Paint::Dark,
        ];
        let pattern = match random.below(20) {
            0..13 => Pattern::Plain,
            13 | 14 => Pattern::Halves {
                from: random.uniform_f32(-0.5, 0.5),
            },
            15 | 16 => Pattern::Twisted {
                pitch: random.uniform_f32(0.4, 1.6),
                lean: random.uniform_f32(0.3, 1.2),
            },
            17 | 18 => Pattern::Braided {
                pitch: random.uniform_f32(0.4, 1.2),
            },
            _ => Pattern::Ringed {
                pitch: random.uniform_f32(1.0, 6.0),
                share: random.uniform_f32(0.1, 0.6),
            },
        };
        let rgb = paints[random.below(paints.len())].draw(random);
        let alike = mix(rgb, [0.0; 3], random.uniform_f32(0.1, 0.5));
        let tip = |random: &mut SplitMix64| {
            happens(random, 0.35).then(|| Tip {
                length: random.uniform_f32(0.6, 5.0),
                width: random.uniform_f32(0.5, 1.25),
                rgb: if happens(random, 0.4) {
                    [190.0, 140.0, 95.0].map(|c| c * random.uniform_f32(0.6, 1.2))
                } else {
                    color(random)
                },
                pin: None,
            })
        };
        // A ferrule: a wide sleeve with a tin pin at its end.
        let ferrule = |tip: Tip, random: &mut SplitMix64| {
            let pin = random.uniform_f32(0.8, 4.0);
            match happens(random, 0.5) {
                true => Tip {
                    length: pin + random.uniform_f32(0.8, 3.0),
                    width: random.uniform_f32(1.0, 1.7),
                    pin: Some([pin, random.uniform_f32(0.35, 0.85)]),
                    ..tip
                },
                false => tip,
            }
        };
        Self {
            rgb,
            second: if happens(random, 0.6) {
                color(random)
            } else {
                alike
            },
            pattern,
            groove: random.uniform_f32(0.0, 0.5),
            // A few ropes lack shading, as in even light.
            ambient: match happens(random, 0.12) {
                true => 1.0,
                false => random.uniform_f32(0.2, 0.85),
            },
            shine: (random.uniform_f32(-60.0, 190.0)).max(0.0),
            shine_power: random.uniform_f32(4.0, 40.0),
            tips: [(); 2].map(|()| tip(random).map(|tip| ferrule(tip, random))),
            speckle: random.uniform_f32(-6.0, 9.0).max(0.0),
            height: random.uniform_f32(0.0, 1.2) * random.uniform_f32(0.2, 2.0),
        }
    }

    /// Returns the same look in another color.
    pub(crate) fn of_color(self, rgb: Rgb) -> Self {
        Self { rgb, ..self }
    }

    /// Returns the width at an arc length, as a share of the rope's width.
    fn width(&self, along: f32, length: f32) -> f32 {
        match self.tip(along, length) {
            Some(tip) => tip.width,
            None => 1.0,
        }
    }

    fn tip(&self, along: f32, length: f32) -> Option<Tip> {
        let [first, last] = self.tips;
        let ends = [(first, along), (last, length - along)];
        let (tip, beyond) = ends
            .into_iter()
            .find_map(|(tip, beyond)| Some((tip.filter(|tip| beyond < tip.length)?, beyond)))?;
        Some(match tip.pin {
            Some([pin, width]) if beyond < pin => Tip {
                width,
                rgb: TIN,
                ..tip
            },
            _ => tip,
        })
    }

    /// Returns the light from a position: `along` in widths, `across` from −1 to 1. `normal` points
    /// to the rope's left.
    fn light(&self, [along, length, across]: [f32; 3], normal: Vec2, lamp: &Lamp) -> Rgb {
        let up = (1.0 - across * across).max(0.0).sqrt();
        let facing =
            (dot(normal, [lamp.from[0], lamp.from[1]]) * across + lamp.from[2] * up).max(0.0);
        let glint = self.shine * libm::powf(facing, self.shine_power);
        let (mut rgb, mut light) = (self.rgb, self.ambient + (1.0 - self.ambient) * facing);
        if let Some(tip) = self.tip(along, length) {
            rgb = tip.rgb;
        } else {
            match self.pattern {
                Pattern::Plain => {}
                Pattern::Halves { from } => {
                    if across > from {
                        rgb = self.second;
                    }
                }
                Pattern::Twisted { pitch, lean } => {
                    let turn = along / pitch + lean * across;
                    if turn.rem_euclid(2.0) < 1.0 {
                        rgb = self.second;
                    }
                    let strand = turn.rem_euclid(1.0);
                    light *= 1.0 - self.groove * (1.0 - 4.0 * strand * (1.0 - strand));
                }
                Pattern::Braided { pitch } => {
                    let turn = TAU * along / pitch;
                    let woven = libm::sinf(turn + 3.0 * across) * libm::sinf(turn - 3.0 * across);
                    rgb = mix(rgb, self.second, (0.5 - 2.0 * woven).clamp(0.0, 1.0));
                    light *= 1.0 - 0.3 * self.groove * woven.abs();
                }
                Pattern::Ringed { pitch, share } => {
                    if (along / pitch).rem_euclid(1.0) < share {
                        rgb = self.second;
                    }
                }
            }
        }
        rgb.map(|value| value * light + glint)
    }
}

/// The top rope at a pixel.
#[derive(Clone, Copy)]
struct Strand {
    rope: u16,
    /// Number of the visible part. A rope that leaves the picture and comes back has two.
    part: u16,
    along_px: f32,
    tangent: Vec2,
}

/// A picture with ropes on it, and their positions.
pub(crate) struct Laid {
    pub(crate) canvas: Canvas,
    /// Share of each pixel that ropes cover.
    pub(crate) cover: Field<f32>,
    strands: Field<Strand>,
    ropes: u16,
    parts: u16,
}

/// Returns, for each point of a path, the number of visible parts that ended before it.
fn parts(path: &Path, side: f32, half_px: f32) -> Vec<u16> {
    let (mut part, mut was_inside, mut was_ever) = (0, true, false);
    let parts = path.points.iter().map(|at| {
        let is_inside = at.iter().all(|&c| c > -half_px && c < side + half_px);
        part += u16::from(is_inside && !was_inside && was_ever);
        was_ever |= is_inside;
        was_inside = is_inside;
        part
    });
    parts.collect()
}

/// A position on the current layer, in coordinates of the rope: across and along.
#[derive(Clone, Copy)]
struct Place {
    across_px: f32,
    along_px: f32,
    segment: u32,
}

const NOWHERE: Place = Place {
    across_px: f32::MAX,
    along_px: 0.0,
    segment: u32::MAX,
};

impl Laid {
    pub(crate) fn on(canvas: Canvas) -> Self {
        let side = canvas.side;
        let nothing = Strand {
            rope: u16::MAX,
            part: u16::MAX,
            along_px: 0.0,
            tangent: [0.0; 2],
        };
        Self {
            canvas,
            cover: Field::of(side, 0.0),
            strands: Field::of(side, nothing),
            ropes: 0,
            parts: 0,
        }
    }

    /// Draws a rope over the existing picture: first its shadow, then the rope itself, with later
    /// parts over earlier ones.
    pub(crate) fn lay(
        &mut self,
        path: &Path,
        width_px: f32,
        look: &RopeStyle,
        lamp: &Lamp,
        random: &mut SplitMix64,
    ) {
        let side = self.canvas.side;
        let mut whole = Field::of(side, 0.0);
        self.in_layers(path, width_px, look, |_, i, place, half_px| {
            let cover = covered(place.across_px.abs() - half_px);
            whole.values[i] = f32::max(whole.values[i], cover);
        });
        let away_px = look.height * width_px;
        let low = away_px / lamp.from[2].max(0.3);
        let fall = shadow(
            &whole,
            [-lamp.from[0] * low, -lamp.from[1] * low],
            0.5 + 0.5 * lamp.softness * away_px,
        );
        self.canvas.darken(&fall, lamp.shade);
        let length = path.points.len() as f32 / width_px;
        let rope = self.ropes;
        let parts = parts(path, side as f32, 0.5 * width_px);
        let before = self.parts;
        let speckle = Field {
            side,
            values: (0..side * side)
                .map(|_| look.speckle * normal(random))
                .collect(),
        };
        self.in_layers(path, width_px, look, |laid, i, place, half_px| {
            let cover = covered(place.across_px.abs() - half_px);
            if cover <= 0.0 {
                return;
            }
            let tangent = path.tangents[place.segment as usize];
            let across = (place.across_px / half_px).clamp(-1.0, 1.0);
            let at = [place.along_px / width_px, length, across];
            let light = look.light(at, [-tangent[1], tangent[0]], lamp);
            let light = light.map(|value| value + speckle.values[i]);
            let pixel = &mut laid.canvas.values[i];
            *pixel = mix(*pixel, light, cover);
            if look.tip(at[0], length).is_some() {
                // A plug does not bend like a rope, so it is not labeled as one.
                laid.hide(i, cover);
                return;
            }
            laid.cover.values[i] = cover + (1.0 - cover) * laid.cover.values[i];
            if cover >= 0.5 {
                laid.strands.values[i] = Strand {
                    rope,
                    part: before + parts[place.segment as usize],
                    along_px: place.along_px,
                    tangent,
                };
            }
        });
        self.ropes += 1;
        self.parts += parts.last().map_or(0, |last| last + 1);
    }

    /// Calls `paint` with every pixel near a rope, the nearest position on the rope, and half the
    /// width there. At a self-crossing it is called once for each layer, starting with the lowest.
    fn in_layers(
        &mut self,
        path: &Path,
        width_px: f32,
        look: &RopeStyle,
        mut paint: impl FnMut(&mut Self, usize, Place, f32),
    ) {
        let side = self.canvas.side as isize;
        let mut layer = Field::of(self.canvas.side, NOWHERE);
        let mut touched: Vec<u32> = Vec::new();
        let length = path.points.len() as f32 / width_px;
        let last = path.points.len().saturating_sub(1);
        let mut from = 0;
        for i in 0..last {
            let half_px = 0.5 * width_px * look.width(i as f32 / width_px, length);
            let (at, along) = (path.points[i], path.tangents[i]);
            let reach = half_px + 1.5;
            let bounds = |c: f32| {
                [
                    (c - reach).floor().max(0.0) as isize,
                    (c + reach).ceil().min(side as f32 - 1.0) as isize,
                ]
            };
            let ([left, right], [top, bottom]) = (bounds(at[0]), bounds(at[1]));
            // At a self-crossing, the layer already drawn is the lower one.
            let centre = at.map(|c| c.round() as isize);
            let inside = centre.iter().all(|&c| (0..side).contains(&c));
            let mut over = false;
            if inside {
                let there = layer.values[(centre[1] * side + centre[0]) as usize];
                over =
                    there.segment != u32::MAX && i as f32 - there.along_px > 2.0 * width_px + 3.0;
            }
            if over && i > from + 4 {
                self.flush(&mut layer, &mut touched, width_px, look, length, &mut paint);
                from = i;
            }
            for y in top..=bottom {
                for x in left..=right {
                    let off = minus([x as f32, y as f32], at);
                    let (forth, across_px) =
                        (dot(off, along), off[1] * along[0] - off[0] * along[1]);
                    let ends = (i == 0 && forth < 0.0) || (i + 1 == last && forth > 1.0);
                    if !(-0.75..1.75).contains(&forth) && !ends || across_px.abs() > reach {
                        continue;
                    }
                    // A rope's end is cut off flat.
                    let beyond = if ends { (-forth).max(forth - 1.0) } else { 0.0 };
                    let across_px = if beyond > 0.0 {
                        across_px.abs().max(half_px + beyond - 0.5)
                    } else {
                        across_px
                    };
                    let index = (y * side + x) as usize;
                    let old = &mut layer.values[index];
                    if old.segment == u32::MAX {
                        touched.push(index as u32);
                    }
                    if across_px.abs() < old.across_px.abs() {
                        *old = Place {
                            across_px,
                            along_px: i as f32 + forth,
                            segment: i as u32,
                        };
                    }
                }
            }
        }
        self.flush(&mut layer, &mut touched, width_px, look, length, &mut paint);
    }

    fn flush(
        &mut self,
        layer: &mut Field<Place>,
        touched: &mut Vec<u32>,
        width_px: f32,
        look: &RopeStyle,
        length: f32,
        paint: &mut impl FnMut(&mut Self, usize, Place, f32),
    ) {
        for index in touched.drain(..) {
            let place = std::mem::replace(&mut layer.values[index as usize], NOWHERE);
            let half_px = 0.5 * width_px * look.width(place.along_px / width_px, length);
            paint(self, index as usize, place, half_px);
        }
    }

    /// Returns the seams between strands that lie side by side: the pixels on both sides of each
    /// seam.
    pub(crate) fn seams(&self, width_px: f32) -> Field<bool> {
        let side = self.canvas.side;
        let mut seams = Field::of(side, false);
        // Cosine of 30 degrees.
        let alike = (PI / 6.0).cos();
        for i in 0..side * side {
            let here = self.strands.values[i];
            let right = (i % side + 1 < side).then_some(i + 1);
            let below = (i + side < side * side).then_some(i + side);
            for next in [right, below].into_iter().flatten() {
                let there = self.strands.values[next];
                let both = here.rope != u16::MAX && there.rope != u16::MAX;
                let apart = here.rope != there.rope
                    || (here.along_px - there.along_px).abs() > 3.0 * width_px + 4.0;
                if both && apart && dot(here.tangent, there.tangent).abs() > alike {
                    seams.values[i] = true;
                    seams.values[next] = true;
                }
            }
        }
        seams
    }

    /// Returns the number of the visible part of a rope at each pixel, from 1 on. 0 on the
    /// background.
    pub(crate) fn labels(&self) -> Vec<u8> {
        let number = |(strand, &cover): (&Strand, &f32)| match cover >= 0.5 {
            true => strand.part.wrapping_add(1) as u8,
            false => 0,
        };
        let pixels = self.strands.values.iter().zip(&self.cover.values);
        pixels.map(number).collect()
    }

    /// Marks a share of a pixel as hidden, so that no rope is visible there.
    pub(crate) fn hide(&mut self, i: usize, share: f32) {
        self.cover.values[i] *= 1.0 - share;
        if share > 0.5 {
            (self.strands.values[i].rope, self.strands.values[i].part) = (u16::MAX, u16::MAX);
        }
    }
}
