//! Films of moving ropes with known centerlines, by story: the reference for tests of tracking.
//!
//! A [`Story`], a seed and a size determine a film and reproduce its frames. The ropes writhe:
//! their loops open and close, and strands touch along each other and part again. [`Judge`] follows
//! an extractor's answers.

mod ground;
mod hand;
mod judge;
mod mask;
mod writhe;

use crate::RenderOptions;
use crate::rendered::draw::{Brush, Canvas};
use crate::rendered::portable::{sin_turns, smoothstep};
use crate::rendered::table::SensorNoise;
use ground::Ground;
use lariat_portable::SplitMix64;
use writhe::Writhe;

pub use hand::Hand;
pub use judge::{Judge, SeenCurve, SeenStatus, Verdict};

/// Frames per second.
const FPS: f64 = 30.0;
/// Number of points of a true centerline.
const TRUE_POINTS: usize = 240;

/// Course of events in a film.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Story {
    /// One rope writhes.
    Writhing,
    /// Two ropes of one color writhe over each other.
    Two,
    /// One rope writhes. Now and then it disappears for up to 25 frames.
    Vanishing,
    /// A gripper moves along the writhing rope.
    Gripper,
    /// A second rope comes in from the side and leaves again.
    Visitor,
    /// Every two seconds, the film cuts to another rope elsewhere.
    Cuts,
    /// Now and then, a frame is noise, black or white.
    BadFrames,
    /// The camera moves over the table.
    Panning,
    /// One rope writhes half outside the picture.
    Leaving,
    /// One rope writhes on a cluttered or patterned ground.
    Clutter,
    /// The same as [`Clutter`](Story::Clutter), filmed by a moving camera.
    Handheld,
    /// The same as [`Handheld`](Story::Handheld), but now and then a hand passes over the rope.
    Passing,
    /// Now and then, a hand comes over the writhing rope, rests, and leaves.
    Resting,
}

impl Story {
    /// All stories.
    pub const ALL: [Self; 13] = [
        Self::Writhing,
        Self::Two,
        Self::Vanishing,
        Self::Gripper,
        Self::Visitor,
        Self::Cuts,
        Self::BadFrames,
        Self::Panning,
        Self::Leaving,
        Self::Clutter,
        Self::Handheld,
        Self::Passing,
        Self::Resting,
    ];

    /// Returns whether the ground is more than a plain table. In that case, only prior knowledge of
    /// the ropes separates them from the ground.
    pub const fn is_cluttered(self) -> bool {
        matches!(self, Self::Clutter | Self::Handheld | Self::Passing)
    }

    const fn is_panned(self) -> bool {
        matches!(self, Self::Panning | Self::Handheld)
    }

    /// Returns the story's name, in lower case.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Writhing => "writhing",
            Self::Two => "two ropes",
            Self::Vanishing => "vanishing",
            Self::Gripper => "gripper",
            Self::Visitor => "visitor",
            Self::Cuts => "cuts",
            Self::BadFrames => "bad frames",
            Self::Panning => "panning",
            Self::Leaving => "leaving",
            Self::Clutter => "clutter",
            Self::Handheld => "handheld",
            Self::Passing => "passing",
            Self::Resting => "resting",
        }
    }
}

/// True position of one rope in a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct TrueRope {
    /// Identity of the rope, constant in the whole film.
    pub identity: u32,
    /// 240 points of its centerline at equal steps of arc length, [x, y] in pixels.
    pub points: Vec<[f64; 2]>,
    /// True for each point that is visible.
    pub seen: Vec<bool>,
    /// Width in pixels.
    pub width_px: f64,
}

/// A film of moving ropes.
#[derive(Debug)]
pub struct Film {
    story: Story,
    options: RenderOptions,
    ground: Ground,
    noise: SensorNoise,
    ropes: Vec<Writhe>,
    random: SplitMix64,
    line: Vec<[f64; 2]>,
    clean: Vec<u8>,
    frame: u64,
    /// Number of frames left in the current event, and number of frames until the next event
    /// begins.
    event: [u64; 2],
}

impl Film {
    /// Makes the film of a story, in pictures of `width` × `height` pixels (each at least 160).
    pub fn new(story: Story, seed: u64, width: u32, height: u32) -> Self {
        Self::of(story, seed, [width, height], Ground::of)
    }

    /// Makes a film on a picture of the size [`ground_size`](Self::ground_size): three bytes per
    /// pixel without padding.
    ///
    /// # Panics
    /// Panics if the picture has another size.
    pub fn on(story: Story, seed: u64, size: [u32; 2], ground: Vec<u8>) -> Self {
        let pixels = Self::ground_size(story, size).map(|side| side as usize);
        assert_eq!(
            ground.len(),
            3 * pixels[0] * pixels[1],
            "a ground of {pixels:?}"
        );
        Self::of(story, seed, size, |story, options| {
            Ground::pictured(story, options, ground)
        })
    }

    /// Returns width and height of the ground, which is larger than the picture if the camera
    /// moves.
    pub fn ground_size(story: Story, size: [u32; 2]) -> [u32; 2] {
        ground::sides(story, size.map(|side| side as usize)).map(|side| side as u32)
    }

    fn of(
        story: Story,
        seed: u64,
        [width, height]: [u32; 2],
        ground: impl FnOnce(Story, &mut RenderOptions) -> Ground,
    ) -> Self {
        let mut random = SplitMix64::of_stream(seed, 11);
        let rope_px = f64::from(width.min(height)) / 48.0;
        let mut options = RenderOptions {
            seed,
            width,
            height,
            rope_px: rope_px.max(5.0),
            ..RenderOptions::default()
        };
        let ground = ground(story, &mut options);
        let count = match story {
            Story::Two | Story::Visitor => 2,
            Story::Cuts => 8,
            _ => 1,
        };
        let size_px = [f64::from(width), f64::from(height)];
        let ropes = (0..count).map(|_| Writhe::new(&mut random, size_px, options.rope_px));
        Self {
            story,
            options,
            ground,
            noise: SensorNoise::new(seed, options.noise, 3 * width as usize),
            ropes: ropes.collect(),
            random,
            line: Vec::new(),
            clean: Vec::new(),
            frame: 0,
            event: [0, 40],
        }
    }

    /// Returns the film's story.
    pub fn story(&self) -> Story {
        self.story
    }

    /// Draws the next frame into `rgb`, three bytes per pixel without padding, and returns the
    /// ropes in it.
    pub fn next(&mut self, rgb: &mut Vec<u8>) -> Vec<TrueRope> {
        let time_s = self.frame as f64 / FPS;
        self.frame += 1;
        let camera_px = self.ground.film(time_s, &mut self.clean);
        let happens = self.happens();
        let mut truth = Vec::new();
        for index in 0..self.ropes.len() {
            let Some(offset) = self.place(index, time_s, happens) else {
                continue;
            };
            let offset = [0, 1].map(|axis| offset[axis] - camera_px[axis]);
            let rope = &self.ropes[index];
            rope.centerline(time_s, offset, &mut self.line);
            let mut canvas = Canvas {
                pixels: &mut self.clean,
                width: self.options.width as usize,
                height: self.options.height as usize,
            };
            Brush::new(&self.options, rope.length_px()).draw(&self.line, &mut canvas);
            truth.push(self.truth(index));
        }
        if self.story == Story::Gripper {
            self.grip(time_s, &mut truth);
        }
        let size_px = [self.options.width, self.options.height].map(f64::from);
        let hand = match self.story {
            Story::Passing => Hand::passing(time_s, size_px, self.options.rope_px),
            Story::Resting => Hand::resting(time_s, size_px, self.options.rope_px),
            _ => None,
        };
        if let Some(hand) = hand {
            hand.draw(&mut self.clean, self.options.width as usize, &mut truth);
        }
        rgb.resize(self.clean.len(), 0);
        let row_bytes = 3 * self.options.width as usize;
        self.noise.add(self.frame, row_bytes, &self.clean, rgb);
        if self.story == Story::BadFrames && happens {
            truth.clear();
            self.spoil(rgb);
        }
        truth
    }

    /// Fills `out` with the true mask of a frame with this truth: the share of each pixel that
    /// visible rope covers, one byte per pixel.
    pub fn mask(&self, truth: &[TrueRope], out: &mut Vec<u8>) {
        let size = [self.options.width, self.options.height].map(|side| side as usize);
        mask::draw(truth, size, out);
    }

    /// Returns whether the story's event takes place in this frame.
    fn happens(&mut self) -> bool {
        if self.event[0] > 0 {
            self.event[0] -= 1;
            return true;
        }
        if self.event[1] == 0 {
            let longest = match self.story {
                Story::Vanishing => 25.0,
                _ => 1.0,
            };
            self.event = [
                self.random.uniform(0.0, longest) as u64,
                self.random.uniform(15.0, 60.0) as u64,
            ];
            return true;
        }
        self.event[1] -= 1;
        false
    }

    /// Displacement of rope `index` at this time; `None` if the rope is absent.
    fn place(&self, index: usize, time_s: f64, happens: bool) -> Option<[f64; 2]> {
        match self.story {
            Story::Vanishing if happens => None,
            Story::Cuts => {
                let shown = (time_s / 2.0) as usize % self.ropes.len();
                (index == shown).then_some([0.0; 2])
            }
            // Its middle is slightly inside the picture's edge.
            Story::Leaving => Some([0.36 * f64::from(self.options.width), 0.0]),
            Story::Visitor if index == 1 => {
                // Every twelve seconds: absent, in the picture for four seconds, and absent again.
                let phase = time_s % 12.0;
                let aside = 1.0 - smoothstep((phase - 2.0) / 3.0) + smoothstep((phase - 8.0) / 3.0);
                (aside < 0.999).then_some([1.3 * f64::from(self.options.width) * aside, 0.0])
            }
            _ => Some([0.0; 2]),
        }
    }

    fn truth(&self, index: usize) -> TrueRope {
        let segments = self.line.len() - 1;
        let points: Vec<_> = (0..TRUE_POINTS)
            .map(|i| {
                let place = i as f64 * segments as f64 / (TRUE_POINTS - 1) as f64;
                let k = (place as usize).min(segments - 1);
                let (p, q) = (self.line[k], self.line[k + 1]);
                [0, 1].map(|axis| p[axis] + (q[axis] - p[axis]) * (place - k as f64))
            })
            .collect();
        let size = [self.options.width, self.options.height].map(|side| f64::from(side) - 1.0);
        let inside = |p: &[f64; 2]| (0..2).all(|axis| (0.0..=size[axis]).contains(&p[axis]));
        TrueRope {
            identity: index as u32,
            seen: points.iter().map(inside).collect(),
            points,
            width_px: self.options.rope_px,
        }
    }

    /// Draws a gripper over the rope: a dark plate that slides along it and turns.
    fn grip(&mut self, time_s: f64, truth: &mut [TrueRope]) {
        const RGB: [u8; 3] = [92, 88, 84];
        let Some(rope) = truth.first_mut() else {
            return;
        };
        let along = 0.5 + 0.34 * sin_turns(time_s / 17.0);
        let middle = rope.points[(along * (TRUE_POINTS - 1) as f64) as usize];
        let half = [3.2 * rope.width_px, 2.4 * rope.width_px];
        let axis = [sin_turns(time_s / 23.0 + 0.25), sin_turns(time_s / 23.0)];
        let inside = |x: f64, y: f64| {
            let d = [x - middle[0], y - middle[1]];
            let (u, v) = (
                d[0] * axis[0] + d[1] * axis[1],
                d[0] * axis[1] - d[1] * axis[0],
            );
            (half[0] - u.abs()).min(half[1] - v.abs())
        };
        let width = self.options.width as usize;
        // Nothing is drawn beyond the plate's corners.
        let reach_px = half[0] + half[1] + 1.0;
        let first = (middle[1] - reach_px).max(0.0) as usize;
        let last = (middle[1] + reach_px).max(0.0) as usize;
        let rows = self.clean.chunks_exact_mut(3 * width).enumerate();
        for (y, row) in rows.take(last + 1).skip(first) {
            for (x, pixel) in row.chunks_exact_mut(3).enumerate() {
                let share = (inside(x as f64, y as f64) + 0.5).clamp(0.0, 1.0);
                for (p, c) in pixel.iter_mut().zip(RGB) {
                    *p = (f64::from(*p) + share * (f64::from(c) - f64::from(*p))) as u8;
                }
            }
        }
        for (seen, p) in rope.seen.iter_mut().zip(&rope.points) {
            *seen &= inside(p[0], p[1]) < 0.0;
        }
    }

    /// Replaces a frame by a frame without a scene.
    fn spoil(&mut self, rgb: &mut [u8]) {
        match self.random.next_u64() % 3 {
            0 => rgb.fill(0),
            1 => rgb.fill(255),
            _ => rgb
                .iter_mut()
                .for_each(|byte| *byte = (self.random.next_u64() >> 56) as u8),
        }
    }
}
