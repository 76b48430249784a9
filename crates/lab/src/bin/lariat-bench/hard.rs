//! `lariat-bench hard`: drawn pictures in which a rope is not just what differs from the table.
//!
//! A picture is right if every rope has a curve that covers 93 % of it, lies on it for as much of its length and runs along it in
//! order, and no curve is left over. One that is wrong is silent if it has no notice, and no curve of a confidence below 0.5. A curve that lies off every rope
//! for more than half of its length is a false rope, unless it is doubtful or such a confidence says so.

use anyhow::{Result, bail};
use lariat_drawn::scenes::{self, Class, Still};
use lariat_extract::{Curve, Extractor, Image, Options, PixelFormat, Scene, Status};

use crate::right;

const SIZE: [usize; 2] = [640, 480];
/// Below this confidence a curve is no claim.
const SURE: f32 = 0.5;
/// Steps of confidence in which what is said is held against what is right.
const BINS: usize = 10;

/// Which pictures are drawn.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// This class alone (may be given several times)
    #[arg(long, value_name = "NAME")]
    class: Vec<Class>,
    /// Pictures of each class [default: 24; 20 of ropes on noisy, textured and cluttered grounds, 50 with things that are no ropes]
    #[arg(long, value_name = "N")]
    seeds: Option<u64>,
    /// Seed of the first picture
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
    /// Name the pictures that are not right
    #[arg(long)]
    list: bool,
}

/// Draws, extracts, and prints the table.
///
/// # Errors
/// No picture is asked for, or an extraction fails.
pub(crate) fn run(args: &Args) -> Result<()> {
    if args.seeds == Some(0) {
        bail!("no pictures were asked for: give --seeds 1 or more");
    }
    let classes = match &args.class[..] {
        [] => Class::HARD.to_vec(),
        some => some.to_vec(),
    };
    let mut extractor = Extractor::new(Options::default())?;
    let (mut all, mut reliability) = (Sum::default(), Reliability::default());
    println!("{:<12} pictures  right  silent  false ropes", "class");
    for class in classes {
        let count = args.seeds.unwrap_or(match class {
            Class::Things => 50,
            composed if composed.is_composed() => 20,
            _ => 24,
        });
        let mut sum = Sum::default();
        for seed in args.seed..args.seed.saturating_add(count) {
            let still = scenes::draw(class, seed, SIZE[0], SIZE[1])?;
            extractor.reset();
            let image = Image::new(&still.rgb, SIZE[0], SIZE[1], 3 * SIZE[0], PixelFormat::Rgb8)?;
            let scene = extractor.extract(&image);
            let judged = Judged::of(&still, &scene);
            if args.list && !judged.is_right {
                println!("  {class}-{seed}: {}", judged.said(&still, &scene));
            }
            sum.add(&judged);
            for curve in scene.curves {
                reliability.add(curve.confidence, right::is_right(&still.truth, curve));
            }
        }
        println!("{}", sum.row(class.name()));
        all.merge(&sum);
    }
    println!("{}", all.row("all"));
    print!("{}", reliability.table());
    Ok(())
}

/// What became of one picture.
struct Judged {
    is_right: bool,
    is_silent: bool,
    has_false: bool,
}

impl Judged {
    fn of(still: &Still, scene: &Scene) -> Self {
        let is_right = right::is_all_right(&still.truth, scene.curves);
        let is_said = scene.notice.is_some() || !scene.curves.iter().all(is_claimed);
        let false_rope = |curve: &Curve| is_claimed(curve) && right::is_false(&still.truth, curve);
        Self {
            is_right,
            is_silent: !is_right && !is_said,
            has_false: scene.curves.iter().any(false_rope),
        }
    }

    fn said(&self, still: &Still, scene: &Scene) -> String {
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
}

/// Whether a curve is said to be a rope.
fn is_claimed(curve: &Curve) -> bool {
    curve.confidence >= SURE && curve.status != Status::Doubtful
}

/// Some pictures together.
#[derive(Default)]
struct Sum {
    pictures: usize,
    right: usize,
    silent: usize,
    with_false: usize,
}

impl Sum {
    fn add(&mut self, one: &Judged) {
        self.pictures += 1;
        self.right += usize::from(one.is_right);
        self.silent += usize::from(one.is_silent);
        self.with_false += usize::from(one.has_false);
    }

    fn merge(&mut self, other: &Self) {
        self.pictures += other.pictures;
        self.right += other.right;
        self.silent += other.silent;
        self.with_false += other.with_false;
    }

    fn row(&self, name: &str) -> String {
        let Self {
            pictures,
            right,
            silent,
            with_false,
        } = self;
        format!("{name:<12} {pictures:>8} {right:>6} {silent:>7} {with_false:>12}")
    }
}

/// How often curves of each confidence are right.
#[derive(Default)]
struct Reliability([(usize, f64, usize); BINS]);

impl Reliability {
    fn add(&mut self, confidence: f32, is_right: bool) {
        let bin = ((confidence * BINS as f32) as usize).min(BINS - 1);
        let (count, said, right) = &mut self.0[bin];
        *count += 1;
        *said += f64::from(confidence);
        *right += usize::from(is_right);
    }

    /// The expected calibration error: how far what is said is from what is right, in the mean of all curves.
    fn error(&self) -> f64 {
        let off = |(_, said, right): &(usize, f64, usize)| (said - *right as f64).abs();
        let count: usize = self.0.iter().map(|bin| bin.0).sum();
        self.0.iter().map(off).sum::<f64>() / count.max(1) as f64
    }

    fn table(&self) -> String {
        let mut text = format!("\nexpected calibration error {:.3}\n", self.error());
        for (count, said, right) in self.0.iter().filter(|bin| bin.0 > 0) {
            let n = *count as f64;
            let (said, right) = (said / n, *right as f64 / n);
            text += &format!("  said {said:.2}, right {right:.2} of {count} curves\n");
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nine_of_ten_at_nine_tenths_are_calibrated() {
        let mut seen = Reliability::default();
        (0..10).for_each(|i| seen.add(0.9, i > 0));
        assert!(seen.error() < 1e-6);
        seen.add(0.05, true);
        assert!((seen.error() - 0.95 / 11.0).abs() < 1e-6);
    }

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
