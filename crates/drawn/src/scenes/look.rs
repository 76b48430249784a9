//! What a picture's ropes, table, light and camera are like.

use super::Class;
use super::line::Vec2;
use crate::rendered::portable::{cos_turns, sin_turns};
use lariat_portable::SplitMix64;

pub(super) type Rgb = [f32; 3];

/// The looks of one rope.
#[derive(Debug, Clone, Copy)]
pub(super) struct Coat {
    pub(super) rgb: Rgb,
    /// How much the grooves between its strands take from the light.
    pub(super) twist: f32,
    /// How much dashes along it take, and their period in widths.
    pub(super) dashes: f32,
    pub(super) dash_widths: f32,
    /// White light thrown back where it faces the lamp, in levels, and how narrow that is.
    pub(super) shine: f32,
    pub(super) shine_power: i32,
}

/// The looks of a picture.
#[derive(Debug, Clone)]
pub(super) struct Look {
    pub(super) coats: Vec<Coat>,
    pub(super) table: Rgb,
    /// How much the table's light varies with its pattern.
    pub(super) mottling: f32,
    /// How much light the rope's shadow takes, where it falls, and how soft it is.
    pub(super) shadow: f32,
    pub(super) shadow_px: [f32; 2],
    pub(super) shadow_blur_px: f32,
    /// The light's fall over the picture, as a vector: 1 + fall · (x, y) / size from the centre.
    pub(super) fall: [f32; 2],
    /// A spot of more light: its place as shares of the image, and how much.
    pub(super) spot: Vec2,
    pub(super) spot_light: f32,
    pub(super) exposure: f32,
    pub(super) blur_px: f32,
    pub(super) motion_px: [f32; 2],
    pub(super) noise: f32,
}

impl Look {
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
                // The darker side has (1 − f) / (1 + f) of the lighter one's light.
                let (turns, fall) = (random.uniform(0.0, 1.0), random.uniform(0.25, 0.48));
                look.fall = [cos_turns(turns), sin_turns(turns)].map(|c| (2.0 * fall * c) as f32);
                look.spot = [random.uniform(0.2, 0.8), random.uniform(0.2, 0.8)];
                look.spot_light = random.uniform(0.0, 0.25) as f32;
                // The lightest place is not overexposed.
                look.exposure = 1.1 / (1.0 + fall as f32 + look.spot_light);
            }
            Class::Texture => look.mottling = draw(0.04, 0.09),
            Class::Shadow => {
                look.shadow = draw(0.15, 0.35);
                // Away from the lamp, and as soft as the rope is high.
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
            Class::LightChange if seed % 2 == 1 => look.exposure = 0.5,
            _ => {}
        }
        look.paint(class, ropes, random);
        look
    }

    /// Draws colours until every rope differs from the table, and from the other ropes.
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
        // Two ropes that touch are of one colour as often as not.
        let is_alike = class != Class::SeveralColors && random.sign() > 0.0;
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
                    // Also where it turns away from the light.
                    0.7 * rgb[k] - self.table[k] > 70.0
                }
            });
            if !differs || !hues.iter().all(apart) {
                continue;
            }
            hues.push(hue);
            let is_textured = class == Class::Texture;
            let shines = class == Class::Shine;
            self.coats.push(Coat {
                rgb,
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

/// A colour from hue (turns), saturation (0 to 1) and value (levels).
pub(super) fn from_hsv(hue: f64, saturation: f64, value: f64) -> Rgb {
    [5.0, 3.0, 1.0].map(|shift| {
        let k = (shift + 6.0 * hue) % 6.0;
        let dip = k.min(4.0 - k).clamp(0.0, 1.0);
        (value * (1.0 - saturation * dip)) as f32
    })
}
