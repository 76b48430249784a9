//! The ropes in a picture and the control points of their curves:
//! `cargo run --release -p lariat-extract --example descriptor docs/rope.png`

use lariat_extract::{Extractor, Image, PixelFormat};
use lariat_fit::{Fit, Fitter, Options, Tolerance};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("give a picture")?;
    for fit in descriptors(&path)? {
        println!("{} {:?}", fit.basis, fit.control_points);
    }
    Ok(())
}

/// The curves of the ropes in a picture, starting with the longest rope.
pub(crate) fn descriptors(path: &str) -> Result<Vec<Fit>, Box<dyn std::error::Error>> {
    let picture = image::open(path)?.into_rgb8();
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    let image = Image::new(&picture, width, height, 3 * width, PixelFormat::Rgb8)?;
    let mut extractor = Extractor::new(Default::default())?;
    let mut fits = Vec::new();
    for rope in extractor.extract(&image).curves {
        let mut fitter = Fitter::new(Options::auto(rope.points.len(), rope.closed))?;
        let fit = fitter.fit_within(&rope.points, Tolerance::of_rope(rope.width_px))?;
        fits.push(fit.clone());
    }
    Ok(fits)
}
