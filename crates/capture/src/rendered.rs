//! A rope drawn by lariat, whose centerline is known.

/// What the rendered rope looks like. The same options make the same frames on every machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RenderOptions {
    /// Which of all ropes, motions and noises.
    pub seed: u64,
    /// Pixels in a row, at least 64.
    pub width: u32,
    /// Rows, at least 64.
    pub height: u32,
    /// Width of the rope in pixels, at least 3.
    pub rope_px: f64,
    /// Time between two frames, as the rope moves, in seconds.
    pub frame_interval_s: f64,
    /// How many frames there are; `None`: without end.
    pub frames: Option<u64>,
    /// How many points the true centerline has, 2 to 256.
    pub truth_points: u32,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self {
            seed: 1,
            width: 640,
            height: 480,
            rope_px: 12.0,
            frame_interval_s: 1.0 / 30.0,
            frames: None,
            truth_points: 120,
        }
    }
}
