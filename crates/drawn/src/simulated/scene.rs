//! The picture: table, rope, grippers and hand. In each frame, only their previous and their new
//! positions are redrawn.

use lariat_message::{Centerlines, PixelFormat};
use lariat_simulation::Simulation;

use super::gripper::Drawing;
use super::hand::{Hand, HandOptions};
use crate::rendered::RenderOptions;
use crate::rendered::draw::{Area, Brush, Canvas};
use crate::rendered::table::{SensorNoise, lit_table};
use crate::rendered::truth;

/// Width of the rope in pixels.
const ROPE_PX: f64 = 12.0;
/// Number of points of the drawn line per segment between nodes.
const FINER: usize = 2;
/// Number of drawn objects: the rope, two grippers, a hand.
const THINGS: usize = 4;

/// A simulated rope, seen by a camera above the table.
#[derive(Debug)]
pub struct Scene {
    width: usize,
    height: usize,
    brush: Brush,
    noise: SensorNoise,
    /// The table without anything on it.
    table: Vec<u8>,
    /// The picture without noise.
    pixels: Vec<u8>,
    /// Regions where the picture differs from the table.
    drawn: [Area; THINGS],
    hand: Option<Hand>,
    /// Drawn line from end to end, and the indices where the part between the jaws begins and ends.
    line: Vec<[f64; 2]>,
    visible: [usize; 2],
}

impl Scene {
    /// Makes the scene of a simulation, with a camera's noise (standard deviation in steps of a
    /// byte) and optionally a hand.
    pub fn new(simulation: &Simulation, noise: f64, hand: Option<HandOptions>) -> Self {
        let seen = simulation.options();
        let [width, height] = seen.picture_px.map(|size| size as u32);
        let looks = RenderOptions {
            seed: seen.seed,
            width,
            height,
            rope_px: ROPE_PX,
            noise,
            ..RenderOptions::default()
        };
        let table = lit_table(&looks);
        Self {
            width: width as usize,
            height: height as usize,
            brush: Brush::new(&looks, seen.length_px),
            noise: SensorNoise::new(seen.seed, noise, 3 * width as usize),
            pixels: table.clone(),
            table,
            drawn: [Area::default(); THINGS],
            hand: hand.map(Hand::new),
            line: Vec::with_capacity(FINER * simulation.nodes().len()),
            visible: [0; 2],
        }
    }

    /// Returns width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        [self.width as u32, self.height as u32]
    }

    /// Last drawn centerline between the jaws, at equal steps.
    fn visible(&self) -> &[[f64; 2]] {
        &self.line[self.visible[0]..self.visible[1]]
    }

    /// Draws the current state of the simulation, this long after the first frame.
    pub fn draw(&mut self, simulation: &Simulation, time_s: f64) {
        self.wipe();
        self.trace(simulation);
        let (width, height) = (self.width, self.height);
        let canvas = &mut Canvas {
            pixels: &mut self.pixels,
            width,
            height,
        };
        self.drawn[0] = self.brush.area(&self.line, width, height);
        self.brush.draw(&self.line, canvas);
        for (i, pose) in simulation.grippers().iter().enumerate() {
            let drawing = Drawing::new(pose, simulation.jaw_px(), ROPE_PX);
            self.drawn[1 + i] = drawing.area(width, height);
            drawing.draw(canvas);
        }
        if let Some(hand) = &mut self.hand {
            let middle = self.line[self.line.len() / 2];
            self.drawn[3] = hand.draw(time_s, middle, canvas);
        }
    }

    /// Writes the picture with this frame's noise.
    pub fn write(&self, sequence: u64, pixels: &mut [u8]) {
        let row_bytes = PixelFormat::Rgb8.row_bytes(self.width as u32);
        self.noise.add(sequence, row_bytes, &self.pixels, pixels);
    }

    /// Fills in the position of the rope between the jaws, with this many points. Returns `false`
    /// before the first frame.
    pub fn truth(&self, simulation: &Simulation, points: usize, message: &mut Centerlines) -> bool {
        let line = self.visible();
        if line.len() < 2 {
            return false;
        }
        [message.width, message.height] = self.size();
        let nodes = simulation.visible().len() - 1;
        let options = simulation.options();
        let length_px = options.length_px * nodes as f64 / (options.nodes - 1) as f64;
        truth::fill(line, length_px, ROPE_PX, points, message);
        true
    }

    fn wipe(&mut self) {
        for Area { x, y } in std::mem::take(&mut self.drawn) {
            for row in y[0]..y[1] {
                let bytes = 3 * (row * self.width + x[0])..3 * (row * self.width + x[1]);
                self.pixels[bytes.clone()].copy_from_slice(&self.table[bytes]);
            }
        }
    }

    /// Computes a smooth line through the nodes (Catmull-Rom spline, at its middles).
    fn trace(&mut self, simulation: &Simulation) {
        let nodes = simulation.nodes();
        self.line.clear();
        for (i, pair) in nodes.windows(2).enumerate() {
            let before = nodes[i.saturating_sub(1)];
            let after = nodes[(i + 2).min(nodes.len() - 1)];
            self.line.push(pair[0]);
            self.line.push([0, 1].map(|axis| {
                let inner = pair[0][axis] + pair[1][axis];
                (9.0 * inner - before[axis] - after[axis]) / 16.0
            }));
        }
        self.line.push(nodes[nodes.len() - 1]);
        let first = (nodes.len() - simulation.visible().len()) / simulation.grippers().len();
        let count = simulation.visible().len();
        self.visible = [FINER * first, FINER * (first + count - 1) + 1];
    }
}
