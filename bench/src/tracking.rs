//! `lariat-bench tracking`: moving ropes with known truth. Measures how often they are lost,
//! reversed or exchanged over many frames.

mod recorded;
mod video;

use std::path::{Path, PathBuf};
use std::time::Instant;

use crate::Samples;
use crate::enlarged::Enlarged;
use anyhow::{Context, Result};
use image::imageops::FilterType;
use lariat_drawn::moving::{Film, Judge, SeenCurve, SeenStatus, Story, TrueRope, Verdict};
use lariat_extract::{Curve, Extractor, Image, Mask, Options, PixelFormat, Scene, Status};

use crate::reliability::Reliability;

/// What to measure.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Total number of frames, divided among the stories and seeds
    #[arg(long, default_value_t = 10_000)]
    frames: u64,
    /// Number of seeds of each story
    #[arg(long, default_value_t = 3)]
    seeds: u64,
    /// First seed
    #[arg(long, default_value_t = 1)]
    first_seed: u64,
    /// Only stories whose name contains this
    #[arg(long)]
    story: Option<String>,
    /// Mask of the stories clutter, handheld and passing, in frames that get a full extraction
    #[arg(long, value_enum, default_value = "true")]
    mask: MaskSource,
    /// Picture that the ropes of those stories lie on, instead of a drawn background
    #[arg(long, value_name = "PICTURE")]
    ground: Option<PathBuf>,
    /// Folder of PNG pictures in the order of their names: use the film that they make, forward and
    /// backward, with a hand over its ropes, instead of the stories. The extraction without the
    /// hand is the ground truth
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["story", "write", "ground"])]
    over: Option<PathBuf>,
    /// Size of the pictures in pixels
    #[arg(long, value_name = "WxH", default_value = "480x360", value_parser = crate::command::size)]
    size: [usize; 2],
    /// Write each film as a Y4M video to this folder, for instance for `lariat run VIDEO`, instead
    /// of measuring
    #[arg(long, value_name = "FOLDER")]
    write: Option<PathBuf>,
    /// Print the errors frame by frame
    #[arg(long)]
    verbose: bool,
    /// Write the frames with errors, with curve and truth drawn over them, to this folder
    #[arg(long)]
    overlay: Option<PathBuf>,
}

/// Source of the mask.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum MaskSource {
    /// The film itself
    True,
    Auto,
    Network,
}

/// Runs all stories and prints the errors of each.
pub(crate) fn run(args: &Args) -> Result<()> {
    if let Some(folder) = &args.over {
        return run_over(folder, args);
    }
    let stories: Vec<_> = Story::ALL
        .into_iter()
        .filter(|s| {
            args.story
                .as_ref()
                .is_none_or(|part| s.name().contains(part))
        })
        .collect();
    anyhow::ensure!(
        !stories.is_empty(),
        "no story has that in its name: leave --story out to see them all"
    );
    let ground = args
        .ground
        .as_ref()
        .map(|path| image::open(path).with_context(|| format!("cannot read {}", path.display())));
    let ground = ground.transpose()?.map(|picture| picture.to_rgb8());
    let films = stories.len() as u64 * args.seeds.max(1);
    let frames = args.frames.div_ceil(films);
    let seeds = || args.first_seed..args.first_seed + args.seeds.max(1);
    if let Some(folder) = &args.write {
        for &story in &stories {
            for seed in seeds() {
                let film = film(story, seed, args.size, ground.as_ref());
                let path = folder.join(format!("{}.y4m", name(story, seed)));
                video::write(film, args.size, frames, &path)?;
            }
        }
        return Ok(());
    }
    print_head()?;
    let mut totals = Vec::new();
    for story in stories {
        let mut total = Total::of(story.name());
        for seed in seeds() {
            let mut film = film(story, seed, args.size, ground.as_ref());
            let mask = match args.mask {
                MaskSource::True if story.is_cluttered() => Mask::External,
                MaskSource::Network if story.is_cluttered() => Mask::Network,
                _ => Mask::Auto,
            };
            let next = |rgb: &mut Vec<u8>, mask: &mut Vec<u8>| {
                let truth = film.next(rgb);
                film.mask(&truth, mask);
                truth
            };
            let show = Show {
                name: story.name(),
                seed,
                size: args.size,
                mask,
            };
            let (verdict, counts) = watch(&show, next, frames, args)?;
            print(&show, frames, &verdict, &counts)?;
            total.add(frames, &counts);
        }
        totals.push(total);
    }
    print_totals(&totals)?;
    print_foot(args.size)
}

/// Runs the film of a folder's pictures with a hand over it, and prints the errors.
fn run_over(folder: &Path, args: &Args) -> Result<()> {
    let film = recorded::Film::read(folder)?;
    let frames = args.frames.div_ceil(args.seeds.max(1));
    let mut total = Total::of("hand");
    print_head()?;
    for seed in args.first_seed..args.first_seed + args.seeds.max(1) {
        let show = Show {
            name: total.name,
            seed,
            size: film.size,
            mask: Mask::Auto,
        };
        let mut shown = 0;
        let next = |rgb: &mut Vec<u8>, _: &mut Vec<u8>| {
            shown += 1;
            film.frame(shown - 1, seed, rgb)
        };
        let (verdict, counts) = watch(&show, next, frames, args)?;
        print(&show, frames, &verdict, &counts)?;
        total.add(frames, &counts);
    }
    print_totals(&[total])?;
    print_foot(film.size)
}

fn print_head() -> Result<()> {
    println!(
        "{:<12} {:>4} {:>7} {:>8} {:>6} {:>7} {:>6} {:>6} {:>6} {:>6} {:>9} {:>8} {:>9} {:>9} {:>6} {:>6}",
        "story",
        "seed",
        "frames",
        "followed",
        "right",
        "shown",
        "missed",
        "count",
        "flips",
        "swaps",
        "exchanged",
        "invented",
        "misjudged",
        "mismarked",
        "µs",
        "whole"
    )
}

fn print_totals(totals: &[Total]) -> Result<()> {
    println!(
        "\n{:<12} {:>7} {:>8} {:>6} {:>6}",
        "story", "frames", "followed", "right", "off"
    )?;
    for total in totals {
        let share = |count: u64| 100.0 * count as f64 / total.frames as f64;
        println!(
            "{:<12} {:>7} {:>7.1}% {:>5.1}% {:>6.3}",
            total.name,
            total.frames,
            share(total.followed),
            share(total.right),
            total.confidence.error()
        )?;
    }
    Ok(())
}

fn print_foot(size: [usize; 2]) -> Result<()> {
    println!(
        "\nframes of {}×{} at 30/s; followed: frames, from the frame before; right: frames with nothing missed, miscounted, turned, renamed, \
         exchanged or invented;\nwith --mask true clutter, handheld and passing are given their true masks for the frames that are not followed; shown: ropes × frames; missed: no curve within a width of the rope; count: frames with \
         a wrong number of curves;\nexchanged: curves on their rope whose points are more than 2 widths from the true \
         ones of their number (95th percentile);\nmisjudged: Ok with a part hidden, or not Ok when whole; mismarked: share of points hidden and not marked, or marked \
         and seen;\nµs: a followed frame, the median; whole: one that is extracted whole;\noff: how far the least confidence of a frame's curves is from the share of frames that \
         are right, in the mean (expected calibration error)",
        size[0], size[1]
    )
}

/// Parameters of a film.
struct Show {
    name: &'static str,
    seed: u64,
    size: [usize; 2],
    mask: Mask,
}

impl Show {
    /// Returns the film's name as a file name.
    fn file(&self) -> String {
        format!("{}-{}", self.name.replace(' ', "-"), self.seed)
    }
}

fn print(show: &Show, frames: u64, v: &Verdict, counts: &Counts) -> Result<()> {
    let share = |count: u64| 100.0 * count as f64 / frames as f64;
    let us = |samples: &Samples| samples.median() / 1e3;
    let mismarked = 100.0 * v.mismarked as f64 / v.marked.max(1) as f64;
    println!(
        "{:<12} {:>4} {frames:>7} {:>7.1}% {:>5.1}% {:>7} {:>6} {:>6} {:>6} {:>6} {:>9} {:>8} {:>9} {mismarked:>8.2}% {:>6.0} {:>6.0}",
        show.name,
        show.seed,
        share(counts.followed.count() as u64),
        share(counts.right),
        v.shown,
        v.missed,
        v.miscounted,
        v.flips,
        v.swaps,
        v.exchanged,
        v.invented,
        v.misjudged,
        us(&counts.followed),
        us(&counts.whole)
    )
}

/// Returns the file name of a film.
fn name(story: Story, seed: u64) -> String {
    format!("{}-{seed}", story.name().replace(' ', "-"))
}

/// Returns the film of a story. It uses the given picture as background if the story's background
/// is cluttered.
fn film(story: Story, seed: u64, size: [usize; 2], ground: Option<&image::RgbImage>) -> Film {
    let size = size.map(|side| side as u32);
    let Some(ground) = ground.filter(|_| story.is_cluttered()) else {
        return Film::new(story, seed, size[0], size[1]);
    };
    let [width, height] = Film::ground_size(story, size);
    let ground = image::DynamicImage::from(ground.clone());
    let ground = ground.resize_to_fill(width, height, FilterType::Triangle);
    Film::on(story, seed, size, ground.into_rgb8().into_raw())
}

/// Times of a film's frames in nanoseconds, number of right frames, and reliability of the least
/// confidence in each frame.
#[derive(Default)]
struct Counts {
    followed: Samples,
    whole: Samples,
    right: u64,
    confidence: Reliability,
}

/// Totals over all films of a story.
struct Total {
    name: &'static str,
    frames: u64,
    followed: u64,
    right: u64,
    confidence: Reliability,
}

impl Total {
    fn of(name: &'static str) -> Self {
        Self {
            name,
            frames: 0,
            followed: 0,
            right: 0,
            confidence: Reliability::default(),
        }
    }

    fn add(&mut self, frames: u64, film: &Counts) {
        self.frames += frames;
        self.followed += film.followed.count() as u64;
        self.right += film.right;
        self.confidence.merge(&film.confidence);
    }
}

/// Processes a film and returns its errors. `next` draws a frame and its true mask, and returns the
/// true ropes in it.
fn watch(
    show: &Show,
    mut next: impl FnMut(&mut Vec<u8>, &mut Vec<u8>) -> Vec<TrueRope>,
    frames: u64,
    args: &Args,
) -> Result<(Verdict, Counts)> {
    let Show { seed, ref mask, .. } = *show;
    let [width, height] = show.size;
    let mask = mask.clone();
    let is_told = mask == Mask::External;
    let mut extractor = Extractor::new(Options::default().mask(mask))?;
    let mut judge = Judge::default();
    let (mut rgb, mut mask) = (Vec::new(), Vec::new());
    let mut counts = Counts::default();
    for frame in 0..frames {
        let truth = next(&mut rgb, &mut mask);
        let image = Image::new(&rgb, width, height, 3 * width, PixelFormat::Rgb8)?;
        let told = match is_told {
            true => Some(Image::new(&mask, width, height, width, PixelFormat::Gray8)?),
            false => None,
        };
        let start = Instant::now();
        let scene = look(&mut extractor, &image, told.as_ref())?;
        let ns = start.elapsed().as_secs_f64() * 1e9;
        match scene.followed {
            true => counts.followed.push(ns),
            false => counts.whole.push(ns),
        }
        let curves: Vec<_> = scene.curves.iter().map(seen).collect();
        let before = judge.verdict();
        let wrong = judge.look(&truth, &curves);
        let is_right = before.places() == judge.verdict().places();
        counts.right += u64::from(is_right);
        let shown = || scene.curves.iter().filter(|c| c.status != Status::Lost);
        if let Some(least) = shown().map(|c| c.confidence).reduce(f32::min) {
            counts.confidence.add(f64::from(least), is_right);
        }
        if wrong.is_empty() {
            continue;
        }
        if args.verbose {
            let how = if scene.followed { "followed" } else { "whole" };
            println!("{} {seed} {frame} ({how}): {}", show.name, wrong.join("; "))?;
        }
        if let Some(folder) = &args.overlay {
            let name = format!("{}-{frame:05}.png", show.file());
            let truth: Vec<_> = truth
                .iter()
                .flat_map(|rope| &rope.points)
                .copied()
                .collect();
            let curves: Vec<_> = shown().map(|c| (&c.points[..], &c.hidden[..])).collect();
            draw(&rgb, show.size, (&truth, &curves), &folder.join(name))?;
        }
    }
    Ok((judge.verdict(), counts))
}

/// Tracks the ropes. The mask is used only for a full extraction, like the mask of a slow network.
fn look<'a>(
    extractor: &'a mut Extractor,
    image: &Image,
    mask: Option<&Image>,
) -> Result<Scene<'a>> {
    let Some(mask) = mask else {
        return Ok(extractor.extract(image));
    };
    if extractor.follow(image).is_none() {
        extractor.extract_masked(image, mask)?;
    }
    Ok(extractor.scene())
}

fn seen(curve: &Curve) -> SeenCurve<'_> {
    SeenCurve {
        track: curve.track,
        status: match curve.status {
            Status::Ok => SeenStatus::Ok,
            // The judge lacks a doubtful state, so a doubtful rope is judged as partly visible.
            Status::Partial | Status::Doubtful => SeenStatus::Partial,
            Status::Lost => SeenStatus::Lost,
        },
        points: &curve.points,
        hidden: &curve.hidden,
    }
}

/// A curve's points, and whether each is hidden.
pub(crate) type SeenPoints<'a> = (&'a [[f32; 2]], &'a [bool]);

/// Draws the frame, the truth as thin dark dots, and the curves' points from red at ρ = 0 to blue
/// at 1. Hidden points are white.
pub(crate) fn draw(
    rgb: &[u8],
    size: [usize; 2],
    (truth, curves): (&[[f64; 2]], &[SeenPoints]),
    path: &Path,
) -> Result<()> {
    const ZOOM: u32 = 2;
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder)?;
    }
    let [width, height] = size.map(|side| side as u32);
    let picture = image::RgbImage::from_raw(width, height, rgb.to_vec())
        .context("a frame has three bytes a pixel")?;
    let mut canvas = Enlarged::new(&picture, ZOOM);
    canvas.dots(truth, 1.0, [0; 3]);
    for (points, hidden) in curves {
        let n = points.len();
        for (i, (p, &is_hidden)) in points.iter().zip(*hidden).enumerate() {
            let share = (255 * i / n.max(1)) as u8;
            let color = if is_hidden {
                [255; 3]
            } else {
                [255 - share, 160, share]
            };
            canvas.dots(&[p.map(f64::from)], 5.0, color);
        }
    }
    canvas
        .canvas
        .picture
        .save(path)
        .with_context(|| format!("cannot write {}", path.display()))
}
