//! `lariat-bench learn-joins`: fits the weights of the assignment's features to drawn pictures whose
//! ropes are known.
//!
//! The extractor lists the cheapest assignments of each cluster of crossings. An assignment is right
//! if each of its joins continues along the true rope, and each of its ends is an end of one. The
//! weights make the right assignments as likely as possible among all.

mod fit;
mod truth;

use anyhow::Result;
use lariat_drawn::moving::{Film, Story};
use lariat_drawn::scenes::{self, Class};
use lariat_extract::{Extractor, FEATURES, Image, Mask, Options, PixelFormat};

use crate::parallel::in_parallel;
use fit::{Cluster, Weights};
use truth::Rope;

/// Classes with many crossings, and how many times as many pictures of them are drawn.
const MANY: ([Class; 4], u64) = (
    [
        Class::SeveralColors,
        Class::Coils,
        Class::Eights,
        Class::Parallel,
    ],
    6,
);
/// Number of a film's frames before the one that is looked at, if the ropes are known from them.
const FRAMES_BEFORE: usize = 5;
const FILM: [usize; 2] = [480, 360];
const STILL: [usize; 2] = [640, 480];

/// What to draw.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Number of pictures of each class
    #[arg(long, value_name = "N", default_value_t = 40)]
    seeds: u64,
    /// Number of pictures of tangled ropes
    #[arg(long, value_name = "N", default_value_t = 1000)]
    tangles: u64,
    /// First seed
    #[arg(long, value_name = "SEED", default_value_t = 500_000)]
    first_seed: u64,
}

enum Source {
    Film(Story),
    Still(Class),
}

/// A picture, the mask of its ropes, and the ropes.
struct Drawn {
    rgb: Vec<u8>,
    mask: Vec<u8>,
    size: [usize; 2],
    ropes: Vec<Rope>,
}

impl Drawn {
    fn extract(&self, extractor: &mut Extractor) -> Result<()> {
        let [width, height] = self.size;
        let image = Image::new(&self.rgb, width, height, 3 * width, PixelFormat::Rgb8)?;
        let mask = Image::new(&self.mask, width, height, width, PixelFormat::Gray8)?;
        extractor.extract_masked(&image, &mask)?;
        Ok(())
    }
}

fn frame(film: &mut Film) -> Drawn {
    let (mut rgb, mut mask) = (Vec::new(), Vec::new());
    let truth = film.next(&mut rgb);
    film.mask(&truth, &mut mask);
    Drawn {
        rgb,
        mask,
        size: FILM,
        ropes: truth.into_iter().map(Rope::from).collect(),
    }
}

/// Adds the clusters of a picture. Half of the films are looked at with a prior.
fn look((source, seed): &(Source, u64), clusters: &mut Vec<Cluster>) -> Result<()> {
    let mut extractor = Extractor::new(Options::default().mask(Mask::External))?;
    let drawn = match *source {
        Source::Film(story) => {
            let mut film = Film::new(story, *seed, FILM[0] as u32, FILM[1] as u32);
            if !seed.is_multiple_of(2) {
                for _ in 0..FRAMES_BEFORE {
                    frame(&mut film).extract(&mut extractor)?;
                }
            }
            frame(&mut film)
        }
        Source::Still(class) => {
            // A few drawings do not succeed.
            let Ok(still) = scenes::draw(class, *seed, STILL[0], STILL[1]) else {
                return Ok(());
            };
            Drawn {
                rgb: still.rgb,
                mask: still.mask,
                size: STILL,
                ropes: still.truth.ropes.into_iter().map(Rope::from).collect(),
            }
        }
    };
    extractor.keep_alternatives();
    drawn.extract(&mut extractor)?;
    let name = match *source {
        Source::Film(story) => story.name(),
        Source::Still(class) => class.name(),
    };
    for alternatives in extractor.alternatives() {
        let mut cluster = Cluster::new(name, *seed);
        for alternative in alternatives {
            cluster.push(
                alternative.features,
                truth::errors(&drawn.ropes, alternative),
            );
        }
        clusters.push(cluster);
    }
    Ok(())
}

/// Fits the weights, and prints them and how many clusters they resolve.
///
/// # Errors
/// An extraction fails.
pub(crate) fn run(args: &Args) -> Result<()> {
    let mut pictures = Vec::new();
    for seed in args.first_seed..args.first_seed + args.tangles {
        pictures.push((Source::Film(Story::Two), seed));
        if seed.is_multiple_of(4) {
            pictures.push((Source::Film(Story::Writhing), seed));
        }
    }
    for class in [&Class::ALL[..], &Class::SHAPES].concat() {
        let (classes, times) = &MANY;
        let seeds = args.seeds * if classes.contains(&class) { *times } else { 1 };
        let seeds = args.first_seed..args.first_seed + seeds;
        pictures.extend(seeds.map(|seed| (Source::Still(class), seed)));
    }
    let clusters = in_parallel(&pictures, look)?;
    let now = Weights::now();
    // Weights fitted to one half are tested on the other one.
    let [some, others] = [0, 1].map(|half| {
        let of_half = clusters.iter().filter(|of| of.seed / 4 % 2 == half);
        of_half.collect::<Vec<_>>()
    });
    let halved = now.fit(&some);
    let fitted = now.fit(&clusters.iter().collect::<Vec<_>>());
    println!(
        "clusters of the second half: all, never right, right by the weights in use, by those"
    )?;
    println!("fitted to the first half\n")?;
    let mut names: Vec<_> = others.iter().map(|cluster| cluster.name).collect();
    names.sort_unstable();
    names.dedup();
    let never = |of: &&Cluster| !of.is_solvable();
    for name in names {
        let of_class: Vec<_> = (others.iter().copied())
            .filter(|of| of.name == name)
            .collect();
        let is_right =
            |weights: &Weights| of_class.iter().filter(|of| weights.resolves(of)).count();
        println!(
            "{name:16} {:5} {:5} {:5} {:5}",
            of_class.len(),
            of_class.iter().copied().filter(|of| never(of)).count(),
            is_right(&now),
            is_right(&halved),
        )?;
    }
    println!("\nfeature           in use  fitted")?;
    for (k, (name, weight)) in FEATURES.iter().enumerate() {
        let held = if fit::is_held(k) { " (held)" } else { "" };
        println!("{name:16} {weight:7.2} {:7.2}{held}", fitted.0[k])?;
    }
    Ok(())
}
