//! Curves compared with drawn ropes, whose centerlines are known: a table with a row for each class
//! of picture.
//!
//! Every picture is given to a reset extractor as a scene of its own, with default options apart
//! from the chosen method. A picture whose ropes are miscounted or wrongly connected still counts
//! in every column. Points of a missed rope are measured by their distance from the curves that
//! were found.

mod overlay;
mod table;

use std::path::Path;

use super::curve::{self, Curves};
use crate::right;
use anyhow::{Context, Result, bail};
use lariat_drawn::scenes::{self, Class, Score, SeenCrossing, SeenCurve, Still, score};
use lariat_extract::{Extractor, Image, Method, Options, PixelFormat, Scene};

/// Selection of pictures to draw.
#[derive(clap::Args)]
#[group(id = "drawn")]
pub(crate) struct Args {
    /// Draw ropes with known ground truth: one row per class of picture
    #[arg(long)]
    rendered: bool,
    /// Draw only this class (repeatable)
    #[arg(long, value_name = "NAME", requires = "rendered")]
    class: Vec<Class>,
    /// Number of pictures of each class
    #[arg(long, value_name = "N", default_value_t = 50, requires = "rendered")]
    seeds: u64,
    /// Seed of the first picture
    #[arg(long, value_name = "SEED", default_value_t = 1, requires = "rendered")]
    seed: u64,
    /// Size of the pictures in pixels
    #[arg(long, value_name = "WxH", default_value = "640x480", value_parser = crate::command::size, requires = "rendered")]
    size: [usize; 2],
}

/// Result of one picture.
struct Measured {
    class: Class,
    seed: u64,
    /// Median true width.
    width_px: f64,
    score: Score,
    /// Number of curves that the extraction itself marks as doubtful. They are not part of the
    /// score.
    doubtful: usize,
}

/// Draws the pictures, extracts and scores them, and prints the table.
///
/// # Errors
/// A picture does not fit the size, or a file cannot be written.
pub(crate) fn run(
    args: &Args,
    method: Method,
    control_points: Option<u16>,
    (csv, overlay): (Option<&Path>, Option<&Path>),
) -> Result<()> {
    if args.seeds == 0 {
        bail!("no pictures were asked for: give --seeds 1 or more");
    }
    if let Some(folder) = overlay {
        let unmade = || format!("cannot make the folder {}", folder.display());
        std::fs::create_dir_all(folder).with_context(unmade)?;
    }
    let classes = if args.class.is_empty() {
        Class::ALL.to_vec()
    } else {
        args.class.clone()
    };
    let mut extractor = Extractor::new(Options::default().method(method))?;
    let mut curves = Curves::new(control_points)?;
    let (mut measured, mut fitted) = (Vec::new(), Vec::new());
    println!("{}", table::head())?;
    for class in classes {
        let first = measured.len();
        let mut fits = Vec::new();
        for seed in args.seed..args.seed.saturating_add(args.seeds) {
            let still = scenes::draw(class, seed, args.size[0], args.size[1])?;
            extractor.reset();
            let image = image(&still)?;
            let scene = extractor.extract(&image);
            for curve in scene.curves {
                fits.push(curves.fit(curve)?);
            }
            if let Some(folder) = overlay {
                overlay::write(&folder.join(format!("{class}-{seed}.png")), &still, &scene)?;
            }
            measured.push(Measured {
                class,
                seed,
                width_px: still.truth.ropes[0].width_px,
                score: held_against(&still, &scene),
                doubtful: scene
                    .curves
                    .iter()
                    .filter(|curve| !right::is_claimed(curve))
                    .count(),
            });
        }
        println!("{}", table::row(class, &measured[first..]))?;
        fitted.push((class.to_string(), fits));
    }
    print!("{}", table::foot(&measured))?;
    let fitted = fitted.iter().map(|(name, fits)| (&name[..], fits.clone()));
    print!("\n{}", curve::table(fitted))?;
    if let Some(path) = csv {
        super::whole_file::write(path, table::csv(&measured).as_bytes())?;
    }
    Ok(())
}

fn image(still: &Still) -> Result<Image<'_>> {
    let stride = 3 * still.width;
    let image = Image::new(
        &still.rgb,
        still.width,
        still.height,
        stride,
        PixelFormat::Rgb8,
    );
    Ok(image?)
}

fn held_against(still: &Still, scene: &Scene) -> Score {
    let sure: Vec<usize> = (0..scene.curves.len())
        .filter(|&k| right::is_claimed(&scene.curves[k]))
        .collect();
    let number = |k: usize| sure.iter().position(|&other| other == k);
    let curves: Vec<SeenCurve> = sure
        .iter()
        .map(|&k| &scene.curves[k])
        .map(|curve| SeenCurve {
            points: &curve.points,
            width_px: curve.width_px,
            closed: curve.closed,
        })
        .collect();
    let crossings: Vec<SeenCrossing> = scene
        .crossings
        .iter()
        .filter_map(|crossing| {
            Some(SeenCrossing {
                at: crossing.at,
                over: (number(crossing.over)?, crossing.over_rho),
                under: (number(crossing.under)?, crossing.under_rho),
            })
        })
        .collect();
    score(&still.truth, &curves, &crossings)
}
