//! Draws the README's picture: `readme_picture FILE.png`. It is one frame of a rendered rope that
//! crosses itself, small and without noise so that the file is small too.

use std::error::Error;

use image::RgbImage;
use lariat_capture::{RenderOptions, Source, open};

/// A rope, and a moment at which it crosses itself.
const SEED: u64 = 2;
const MOMENT_S: f64 = 7.0;

fn main() -> Result<(), Box<dyn Error>> {
    let file = std::env::args().nth(1).ok_or("say where to write it")?;
    let mut source = open(&Source::Rendered(RenderOptions {
        seed: SEED,
        width: 480,
        height: 360,
        noise: 0.0,
        // The first frame is at 0 s, the second at that moment.
        frame_interval_s: MOMENT_S,
        ..RenderOptions::default()
    }))?;
    source.next()?;
    let frame = source.next()?.ok_or("a rendered rope has no end")?;
    let mut picture = RgbImage::new(frame.width, frame.height);
    source.write(&mut picture);
    picture.save(file)?;
    Ok(())
}
