//! `lariat-bench backgrounds`: drawn pictures in which more than the rope differs from the table,
//! or in which ropes are hard to tell apart.
//!
//! A picture is right if every rope has a right curve and no curve is left over. A right curve
//! covers 93 % of its rope, is on it for the same share of its own length, and follows it in order.
//! A wrong picture is silent if it lacks a notice and every curve has a confidence of at least 0.5.
//!
//! A curve that is off every rope for more than half of its length is a false rope. The exception
//! is a curve that is marked doubtful or has a confidence below 0.5. A picture with a curve that is
//! not right but has a confidence above 0.9 is confidently wrong.
//!
//! Each picture is also extracted with its true mask, which lacks the hidden parts. The remaining
//! errors are not caused by the mask.

use std::time::Instant;

use crate::Samples;
use anyhow::{Result, bail};
use lariat_drawn::scenes::{self, Class, Still};
use lariat_extract::{Curve, Extractor, Image, Options, PixelFormat, Scene};

use crate::mask::Mask;
use crate::reliability::Reliability;
use crate::right;

const SIZE: [usize; 2] = [640, 480];
/// Confidence above which a wrong curve is worse than none.
const TOO_SURE: f32 = 0.9;

/// Selection of pictures to draw.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Draw only this class (repeatable)
    #[arg(long, value_name = "NAME")]
    class: Vec<Class>,
    /// Method that segments the ropes' pixels
    #[arg(long, value_name = "NAME", value_enum, default_value_t = Mask::Auto)]
    mask: Mask,
    /// Number of pictures of each class [default: 24; 50 with objects that are not ropes]
    #[arg(long, value_name = "N")]
    seeds: Option<u64>,
    /// Seed of the first picture
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
    /// Name the pictures that are not right
    #[arg(long)]
    list: bool,
}

/// Draws the pictures, extracts them, and prints the table.
///
/// # Errors
/// No picture is requested, or an extraction fails.
pub(crate) fn run(args: &Args) -> Result<()> {
    if args.seeds == Some(0) {
        bail!("no pictures were asked for: give --seeds 1 or more");
    }
    let classes = match &args.class[..] {
        [] => [&Class::HARD[..], &Class::SHAPES].concat(),
        some => some.to_vec(),
    };
    let mut extractor = Extractor::new(Options::default().mask(args.mask.into()))?;
    extractor.prepare(SIZE[0], SIZE[1]);
    let mut masked = Extractor::new(Options::default().mask(lariat_extract::Mask::External))?;
    masked.prepare(SIZE[0], SIZE[1]);
    let (mut all, mut reliability) = (Sum::default(), Reliability::default());
    println!(
        "{:<12} pictures  right  by true mask  silent  false ropes  sure, wrong  by true mask   p50 µs",
        "class"
    )?;
    for class in classes {
        let count = args.seeds.unwrap_or(match class {
            Class::Things => 50,
            _ => 24,
        });
        let mut sum = Sum::default();
        for seed in args.seed..args.seed.saturating_add(count) {
            let still = scenes::draw(class, seed, SIZE[0], SIZE[1])?;
            extractor.reset();
            let image = Image::new(&still.rgb, SIZE[0], SIZE[1], 3 * SIZE[0], PixelFormat::Rgb8)?;
            let begin = Instant::now();
            let scene = extractor.extract(&image);
            sum.ns.push(begin.elapsed().as_secs_f64() * 1e9);
            let judged = Judged::of(&still, &scene);
            if args.list && !judged.is_right {
                println!("  {class}-{seed}: {}", said(&still, &scene))?;
            }
            for curve in scene.curves {
                reliability.add(
                    curve.confidence.into(),
                    right::is_right(&still.truth, curve),
                );
            }
            let mask = Image::new(&still.mask, SIZE[0], SIZE[1], SIZE[0], PixelFormat::Gray8)?;
            masked.reset();
            let scene = masked.extract_masked(&image, &mask)?;
            let by_mask = Judged::of(&still, &scene);
            if args.list && !by_mask.is_right {
                let said = said(&still, &scene);
                println!("  {class}-{seed} by its true mask: {said}")?;
            }
            sum.add(&judged, &by_mask);
        }
        println!("{}", sum.row(class.name()))?;
        all.merge(&sum);
    }
    println!("{}", all.row("all"))?;
    print!("\n{reliability}")?;
    Ok(())
}

/// The judgment of one picture.
struct Judged {
    is_right: bool,
    is_silent: bool,
    has_false: bool,
    is_too_sure: bool,
}

impl Judged {
    fn of(still: &Still, scene: &Scene) -> Self {
        let is_right = right::is_all_right(&still.truth, scene.curves);
        let is_said = scene.notice.is_some() || !scene.curves.iter().all(right::is_claimed);
        let false_rope =
            |curve: &Curve| right::is_claimed(curve) && right::is_false(&still.truth, curve);
        let too_sure =
            |curve: &Curve| curve.confidence > TOO_SURE && !right::is_right(&still.truth, curve);
        Self {
            is_right,
            is_too_sure: scene.curves.iter().any(too_sure),
            is_silent: !is_right && !is_said,
            has_false: scene.curves.iter().any(false_rope),
        }
    }
}

/// Describes the true ropes and the curves that were found.
fn said(still: &Still, scene: &Scene) -> String {
    let ropes = still.truth.ropes.len();
    let curves = scene.curves.iter().map(|curve| {
        let mark = match right::is_right(&still.truth, curve) {
            true => "+",
            false if right::is_false(&still.truth, curve) => "!",
            false => "-",
        };
        format!("{mark}{:.2}", curve.confidence)
    });
    let curves: Vec<_> = curves.collect();
    let notice = scene
        .notice
        .map_or("silent".to_owned(), |n| format!("{n:?}"));
    format!("{ropes} ropes, curves [{}], {notice}", curves.join(" "))
}

/// Totals over several pictures.
#[derive(Default)]
struct Sum {
    pictures: usize,
    right: usize,
    right_by_mask: usize,
    silent: usize,
    with_false: usize,
    too_sure: usize,
    too_sure_by_mask: usize,
    /// Time for each picture, on one core.
    ns: Vec<f64>,
}

impl Sum {
    fn add(&mut self, one: &Judged, by_mask: &Judged) {
        self.pictures += 1;
        self.right += usize::from(one.is_right);
        self.right_by_mask += usize::from(by_mask.is_right);
        self.too_sure += usize::from(one.is_too_sure);
        self.too_sure_by_mask += usize::from(by_mask.is_too_sure);
        self.silent += usize::from(one.is_silent);
        self.with_false += usize::from(one.has_false);
    }

    fn merge(&mut self, other: &Self) {
        self.pictures += other.pictures;
        self.right += other.right;
        self.right_by_mask += other.right_by_mask;
        self.too_sure += other.too_sure;
        self.too_sure_by_mask += other.too_sure_by_mask;
        self.silent += other.silent;
        self.with_false += other.with_false;
        self.ns.extend(&other.ns);
    }

    fn row(&self, name: &str) -> String {
        let Self {
            pictures,
            right,
            right_by_mask,
            silent,
            with_false,
            too_sure,
            too_sure_by_mask,
            ns,
        } = self;
        let p50_us = Samples::from_iter(ns.iter().copied()).median() / 1e3;
        format!(
            "{name:<12} {pictures:>8} {right:>6} {right_by_mask:>13} {silent:>7} {with_false:>12} \
             {too_sure:>12} {too_sure_by_mask:>13} {p50_us:>8.0}"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_seen_in_silence_is_wrong_and_silent() {
        let still = scenes::draw(Class::Gradient, 1, 320, 240).expect("it fits");
        let mut extractor = Extractor::new(Options::default()).expect("valid options");
        let table = vec![100; still.rgb.len()];
        let image = Image::new(&table, 320, 240, 960, PixelFormat::Rgb8).expect("whole");
        let judged = Judged::of(&still, &extractor.extract(&image));
        assert!(!judged.is_right && judged.is_silent && !judged.has_false);
    }
}
