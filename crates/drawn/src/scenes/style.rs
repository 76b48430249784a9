//! Appearance of a picture's ropes, table, light and camera.

use super::Class;
use super::line::Vec2;
use crate::rendered::portable::{cos_turns, sin_turns};
use lariat_portable::SplitMix64;

pub(super) type Rgb = [f32; 3];

/// Appearance of one rope.
#[derive(Debug, Clone, Copy)]
pub(super) struct Coat {
    pub(super) rgb: Rgb,
    /// Color of every second strand, if it is different; and the pitch of a strand, in widths.
    pub(super) second: Option<Rgb>,
    pub(super) pitch_widths: f32,
    /// Share of the light that the grooves between the strands take.
    pub(super) twist: f32,
    /// Share of the light that dashes along the rope take, and their period in widths.
    pub(super) dashes: f32,
    pub(super) dash_widths: f32,
    /// White light that is reflected toward the lamp, in levels, and the sharpness of the
    /// highlight.
    pub(super) shine: f32,
    pub(super) shine_power: i32,
}

/// Appearance of a picture.
#[derive(Debug, Clone)]
pub(super) struct Style {
    pub(super) coats: Vec<Coat>,
    pub(super) table: Rgb,
    /// Color at the end of the table's gradient, if it has one.
    pub(super) table_to: Rgb,
    /// Variation of the table's light with its pattern.
    pub(super) mottling: f32,
    /// Share of the light that the rope's shadow takes, its offset, and its softness.
    pub(super) shadow: f32,
    pub(super) shadow_px: [f32; 2],
    pub(super) shadow_blur_px: f32,
    /// Falloff of the light over the picture, as a vector: 1 + fall · (x, y) / size from the
    /// center.
    pub(super) fall: [f32; 2],
    /// A brighter spot: its position as shares of the image's sides, and the additional light.
    pub(super) spot: Vec2,
    pub(super) spot_light: f32,
    pub(super) exposure: f32,
    pub(super) blur_px: f32,
    pub(super) motion_px: [f32; 2],
    pub(super) noise: f32,
    /// Noise that is blurred with the picture, in levels.
    pub(super) grain: f32,
}

impl Style {
    pub(super) fn of(
        class: Class,
        seed: u64,
        ropes: usize,
        width_px: f64,
        random: &mut SplitMix64,
    ) -> Self {
        let mut draw = |low: f64, high: f64| random.uniform(low, high) as f32;
        let mut look = Self {
            coats: Vec::new(),
            table: [0.0; 3],
            table_to: [0.0; 3],
            mottling: 0.01,
            shadow: 0.0,
            shadow_px: [0.0; 2],
            shadow_blur_px: 0.0,
            fall: [draw(-0.15, 0.15), draw(-0.15, 0.15)],
            spot: [0.0; 2],
            spot_light: 0.0,
            exposure: 1.0,
            blur_px: draw(0.5, 0.7),
            motion_px: [0.0; 2],
            noise: 2.0,
            grain: 0.0,
        };
        let width = width_px as f32;
        match class {
            Class::Noise => look.noise = draw(6.0, 14.0),
            Class::Blur => look.blur_px = draw(1.2, 3.0).min(width / 3.0),
            Class::MotionBlur => {
                let (turns, length) = (random.uniform(0.0, 1.0), random.uniform(3.0, 10.0));
                let length = (length as f32).min(0.75 * width);
                look.motion_px = [cos_turns(turns), sin_turns(turns)].map(|c| length * c as f32);
            }
            Class::UnevenLight => {
                // The darker side has (1 − f) / (1 + f) of the light on the lighter one.
                let (turns, fall) = (random.uniform(0.0, 1.0), random.uniform(0.25, 0.48));
                look.fall = [cos_turns(turns), sin_turns(turns)].map(|c| (2.0 * fall * c) as f32);
                look.spot = [random.uniform(0.2, 0.8), random.uniform(0.2, 0.8)];
                look.spot_light = random.uniform(0.0, 0.25) as f32;
                // The lightest point is not overexposed.
                look.exposure = 1.1 / (1.0 + fall as f32 + look.spot_light);
            }
            Class::Texture => look.mottling = draw(0.04, 0.09),
            Class::Shadow => {
                look.shadow = draw(0.15, 0.35);
                // The shadow is on the side away from the lamp, and as soft as the rope is high.
                let shift = 0.3 * width;
                (look.shadow_px, look.shadow_blur_px) = ([shift, 1.3 * shift], shift);
            }
            Class::HardShadow | Class::SoftShadow => {
                look.shadow = [0.15, 0.3, 0.45, 0.6][seed as usize % 4];
                let (turns, widths) = (random.uniform(0.0, 1.0), random.uniform(0.5, 4.0));
                let away = [cos_turns(turns), sin_turns(turns)];
                look.shadow_px = away.map(|c| width * (widths * c) as f32);
                if class == Class::SoftShadow {
                    look.shadow_blur_px = random.uniform(0.2, 0.6) as f32 * width;
                }
            }
            composed if composed.is_composed() => {
                look.shadow = draw(0.1, 0.4);
                let (turns, widths) = (random.uniform(0.0, 1.0), random.uniform(0.2, 0.6));
                let away = [cos_turns(turns), sin_turns(turns)];
                look.shadow_px = away.map(|c| width * (widths * c) as f32);
                look.shadow_blur_px = random.uniform(0.05, 0.5) as f32 * width;
                match (class, seed % 4) {
                    (Class::OnNoise, 1) => look.noise = random.uniform(8.0, 14.0) as f32,
                    (Class::OnNoise, 2) => look.noise = random.uniform(14.0, 20.0) as f32,
                    (Class::OnNoise, 3) => look.grain = random.uniform(8.0, 20.0) as f32,
                    _ => {}
                }
            }
            Class::LightChange if seed % 2 == 1 => look.exposure = 0.5,
            _ => {}
        }
        match class {
            Class::WhiteShine => look.paint_white(ropes, random),
            composed if composed.is_composed() => look.paint_as_found(ropes, random),
            _ => look.paint(class, ropes, random),
        }
        look
    }

    /// White, shining ropes on a light gray table.
    fn paint_white(&mut self, ropes: usize, random: &mut SplitMix64) {
        let value = random.uniform(160.0, 205.0);
        self.table = [(); 3].map(|()| (value * random.uniform(0.97, 1.03)) as f32);
        for _ in 0..ropes {
            let white = from_hsv(
                random.uniform(0.0, 1.0),
                random.uniform(0.0, 0.06),
                random.uniform(225.0, 245.0),
            );
            self.coats.push(Coat {
                shine: random.uniform(60.0, 140.0) as f32,
                shine_power: 24,
                ..Coat::plain(white)
            });
        }
    }

    /// Typical cables on a surface of any color: three of four ropes are colored, the others black
    /// or white.
    fn paint_as_found(&mut self, ropes: usize, random: &mut SplitMix64) {
        let (hue, tint) = (random.uniform(0.0, 1.0), random.uniform(0.0, 0.35));
        self.table = from_hsv(hue, tint, random.uniform(60.0, 210.0));
        while self.coats.len() < ropes {
            let rgb = if random.uniform(0.0, 1.0) < 0.75 {
                let hue = random.uniform(0.0, 1.0);
                from_hsv(hue, random.uniform(0.35, 0.95), random.uniform(60.0, 230.0))
            } else {
                let value = [random.uniform(25.0, 50.0), random.uniform(215.0, 240.0)];
                from_hsv(0.0, 0.0, value[usize::from(random.sign() > 0.0)])
            };
            let off = |other: &Rgb| {
                (0..3)
                    .map(|k| (other[k] - rgb[k]).abs())
                    .fold(0.0, f32::max)
            };
            if off(&self.table) < 65.0 || self.coats.iter().any(|coat| off(&coat.rgb) < 60.0) {
                continue;
            }
            self.coats.push(Coat {
                twist: random.uniform(0.0, 0.15) as f32,
                shine: random.uniform(10.0, 90.0) as f32,
                ..Coat::plain(rgb)
            });
        }
    }

    /// Draws colors until every rope differs from the table and from the other ropes.
    fn paint(&mut self, class: Class, ropes: usize, random: &mut SplitMix64) {
        let is_dark_rope = match class {
            Class::DarkOnLight | Class::Shine | Class::HardShadow | Class::SoftShadow => true,
            Class::LightOnDark => false,
            _ => random.uniform(0.0, 1.0) < 0.6,
        };
        let value = if is_dark_rope {
            random.uniform(175.0, 215.0)
        } else {
            random.uniform(22.0, 55.0)
        };
        self.table = [(); 3].map(|()| (value * random.uniform(0.93, 1.05)) as f32);
        self.table_to = self.table;
        if class == Class::Gradient {
            let share = random.uniform(0.3, 0.6);
            let darker = self.table.map(|c| f64::from(c) * share);
            self.table_to = darker.map(|c| (c * random.uniform(0.85, 1.15)) as f32);
        }
        // Two touching ropes have one color half of the time.
        let is_alike =
            class == Class::OneColor || class != Class::SeveralColors && random.sign() > 0.0;
        let mut hues: Vec<f64> = Vec::new();
        while self.coats.len() < ropes {
            if let Some(&coat) = self.coats.first().filter(|_| is_alike) {
                self.coats.push(coat);
                continue;
            }
            let hue = random.uniform(0.0, 1.0);
            let apart = |other: &f64| {
                let d = (hue - other).abs();
                d.min(1.0 - d) > 0.16
            };
            let (saturation, value) = if is_dark_rope {
                (random.uniform(0.3, 0.95), random.uniform(50.0, 150.0))
            } else {
                (random.uniform(0.2, 0.8), random.uniform(170.0, 235.0))
            };
            let rgb = from_hsv(hue, saturation, value);
            let differs = (0..3).any(|k| {
                if is_dark_rope {
                    self.table[k] - rgb[k] > 95.0
                } else {
                    // This also holds where the rope turns away from the light.
                    0.7 * rgb[k] - self.table[k] > 70.0
                }
            });
            let differs = differs
                && (class != Class::Gradient
                    || (0..3).any(|k| (self.table_to[k] - rgb[k]).abs() > 50.0));
            if !differs || !hues.iter().all(apart) {
                continue;
            }
            hues.push(hue);
            let is_textured = class == Class::Texture;
            let shines = class == Class::Shine;
            let second = (class == Class::Twisted).then(|| {
                let other = hue + random.uniform(0.25, 0.75);
                // The second color need not contrast with the table.
                let value = random.uniform(50.0, 230.0);
                from_hsv(other % 1.0, random.uniform(0.1, 0.95), value)
            });
            self.coats.push(Coat {
                rgb,
                second,
                pitch_widths: second.map_or(0.55, |_| random.uniform(0.6, 1.3) as f32),
                twist: if is_textured {
                    random.uniform(0.25, 0.4)
                } else {
                    0.12
                } as f32,
                dashes: if is_textured {
                    random.uniform(0.2, 0.4)
                } else {
                    0.0
                } as f32,
                dash_widths: random.uniform(1.5, 4.0) as f32,
                shine: if shines {
                    random.uniform(90.0, 180.0)
                } else {
                    12.0
                } as f32,
                shine_power: if shines { 24 } else { 8 },
            });
        }
    }
}

impl Coat {
    /// A coat of one color, with barely visible strands.
    fn plain(rgb: Rgb) -> Self {
        Self {
            rgb,
            second: None,
            pitch_widths: 0.55,
            twist: 0.05,
            dashes: 0.0,
            dash_widths: 1.0,
            shine: 12.0,
            shine_power: 8,
        }
    }
}

/// Color from hue (turns), saturation (0 to 1) and value (levels).
pub(super) fn from_hsv(hue: f64, saturation: f64, value: f64) -> Rgb {
    [5.0, 3.0, 1.0].map(|shift| {
        let k = (shift + 6.0 * hue) % 6.0;
        let dip = k.min(4.0 - k).clamp(0.0, 1.0);
        (value * (1.0 - saturation * dip)) as f32
    })
}
