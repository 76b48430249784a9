//! `lariat-bench calibrate-confidence`: fits the weights of a curve's confidence to drawn pictures,
//! and checks its reliability on others.
//!
//! Each picture of every class, including the hard ones, is drawn plain, on backgrounds of
//! increasing texture and with noise. For each drawing, the extractor is run with its own mask,
//! with the network, and with external masks. These are the true mask, an uneven one like a
//! network's, and one that also has gaps and false strands.
//!
//! Each curve is compared with the truth. It is right if it covers 93 % of its rope, is on it for
//! the same share of its own length, and follows it in order. Seeds alternate between fit and check
//! in groups of four. Labeled pictures, as `lariat-scenes` draws them, are used in the same way.

mod ground;
mod logistic;
mod masks;
mod warp;

use std::path::{Path, PathBuf};

use anyhow::Result;
use lariat_drawn::scenes::{self, Class, Still};
use lariat_extract::{
    Class as CurveClass, Curve, Evidence, Extractor, Image, Maker, Mask, Options, PixelFormat, pick,
};
use lariat_plot::{Axis, Chart, LineStyle, Marker, Stroke, draw as draw_charts};
use lariat_portable::SplitMix64;

use lariat_chain::output::{Existing, Output};
use lariat_wire::MIN_CONFIDENCE;

use crate::accuracy::labelled::{self, Labelled};
use crate::parallel::in_parallel;
use crate::reliability::Reliability;
use crate::right;
use ground::Ground;
use logistic::{Example, Label, Weights};
use warp::Warp;

/// First seed of the hard classes. `lariat-bench backgrounds` uses the lower seeds to measure the
/// weights that are fitted here.
const HARD_FROM: u64 = 1000;

/// What to draw.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Number of pictures of each class; half of them are used for the fit
    #[arg(long, value_name = "N", default_value_t = 12)]
    seeds: u64,
    /// Also fit to labeled pictures: a folder of sets, each with `images/` and `labels/`
    #[arg(long, value_name = "DIR")]
    labelled: Option<PathBuf>,
    /// Fit nothing: report the reliability of the built-in confidence on these labeled pictures
    #[arg(long, value_name = "DIR", conflicts_with_all = ["seeds", "labelled"])]
    check: Option<PathBuf>,
    /// Draw the share of right curves against their confidence, one chart for each mask source
    #[arg(long, value_name = "FILE.svg", requires = "check")]
    diagram: Option<PathBuf>,
    /// Write one line per judged curve: the source of the mask, whether the curve is right and used
    /// for the fit, and its clues
    #[arg(long, value_name = "FILE.csv")]
    examples: Option<PathBuf>,
}

/// Draws a picture of a class. Two of four seeds have the usual size. One has half that size, so
/// its ropes are short relative to their width. One is scaled down by half, so its ropes are thin.
fn draw(class: Class, seed: u64) -> Option<Still> {
    let [width, height] = match seed % 4 {
        2 => [320, 240],
        _ => [640, 480],
    };
    // Not every class fits the small size.
    let still = scenes::draw(class, seed, width, height).ok()?;
    Some(if seed % 4 == 3 { halved(&still) } else { still })
}

fn halved(still: &Still) -> Still {
    let (width, height) = (still.width / 2, still.height / 2);
    let mut rgb = Vec::with_capacity(3 * width * height);
    for y in 0..height {
        for x in 0..width {
            for channel in 0..3 {
                let at =
                    |x: usize, y: usize| u16::from(still.rgb[3 * (y * still.width + x) + channel]);
                let [left, top] = [2 * x, 2 * y];
                let sum =
                    at(left, top) + at(left + 1, top) + at(left, top + 1) + at(left + 1, top + 1);
                rgb.push((sum / 4) as u8);
            }
        }
    }
    let mask = (0..width * height)
        .map(|i| {
            let at = |dx, dy| {
                let [x, y] = [2 * (i % width) + dx, 2 * (i / width) + dy];
                u16::from(still.mask[y * still.width + x])
            };
            ((at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1)) / 4) as u8
        })
        .collect();
    let mut truth = still.truth.clone();
    for rope in &mut truth.ropes {
        (rope.length_px, rope.width_px) = (rope.length_px / 2.0, rope.width_px / 2.0);
        for point in &mut rope.points {
            *point = point.map(|c| (c + 0.5) / 2.0 - 0.5);
        }
    }
    Still {
        width,
        height,
        rgb,
        mask,
        truth,
    }
}

/// The sources of masks, with the names of their weights.
const MAKERS: [(&str, Maker); 4] = [
    ("OWN", Maker::Own),
    ("COLOR", Maker::Color),
    ("NETWORK", Maker::Network),
    ("ELSEWHERE", Maker::Elsewhere),
];

/// Prints the reliability of the built-in confidence, and its effect on a control loop that
/// requires at least [`MIN_CONFIDENCE`]. Draws the diagram if `diagram` is given.
fn check(examples: &[Example], diagram: Option<&Path>) -> Result<()> {
    let mut charts = Vec::new();
    for (name, maker) in MAKERS {
        let of = examples
            .iter()
            .filter(|example| example.evidence.maker == maker);
        let said: Vec<(f64, bool)> = of
            .map(|example| {
                (
                    example.evidence.verdict(false).confidence.into(),
                    example.is_right(),
                )
            })
            .collect();
        let mut reliability = Reliability::default();
        said.iter()
            .for_each(|&(confidence, is_right)| reliability.add(confidence, is_right));
        charts.push(chart(maker, &reliability));
        let count =
            |is: &dyn Fn(f64, bool) -> bool| said.iter().filter(|one| is(one.0, one.1)).count();
        let is_given = |confidence: f64| confidence >= f64::from(MIN_CONFIDENCE);
        let (right, held) = (
            count(&|_, is_right| is_right),
            count(&|c, is_right| is_right && !is_given(c)),
        );
        let (given, wrong) = (
            count(&|c, _| is_given(c)),
            count(&|c, is_right| is_given(c) && !is_right),
        );
        print!("{name}: {reliability}")?;
        println!(
            "  {held} of {right} right curves are below {MIN_CONFIDENCE}, {wrong} of {given} above are wrong"
        )?;
    }
    let Some(file) = diagram else {
        return Ok(());
    };
    let output = Output::new(file, Existing::Replace, std::iter::empty::<&Path>())?;
    output.write(draw_charts("reliability", &charts, 2)?.as_bytes())
}

/// Returns a reliability diagram. It is a diagonal where the confidence is correct.
fn chart(maker: Maker, reliability: &Reliability) -> Chart {
    let title = match maker {
        Maker::Own => "mask from the table",
        Maker::Color => "mask from colours",
        Maker::Network => "mask from the network",
        Maker::Elsewhere => "mask given",
    };
    let axis = |label| Axis::linear(label, [0.0, 1.0], 0.2);
    let mut chart = Chart::new(axis("confidence"), axis("share that is right")).titled(title);
    let diagonal = LineStyle::nth(1)
        .marker(Marker::None)
        .stroke(Stroke::Dashed);
    chart.line("as said", diagonal, vec![[0.0; 2], [1.0; 2]]);
    chart.line("curves", LineStyle::nth(0), reliability.points());
    chart
}

/// Writes one line per curve.
fn write_examples(file: Option<&Path>, examples: &[Example]) -> Result<()> {
    let Some(file) = file else {
        return Ok(());
    };
    let names = Evidence::MEANINGS.map(|(name, _)| name).join(",");
    let mut text = format!("maker,class,fitted,{names}\n");
    for Example {
        evidence,
        label,
        is_fitted,
    } in examples
    {
        let clues: Vec<String> = evidence.clues.iter().map(f32::to_string).collect();
        text += &format!(
            "{:?},{},{},{}\n",
            evidence.maker,
            label.name(),
            u8::from(*is_fitted),
            clues.join(",")
        );
    }
    let output = Output::new(file, Existing::Replace, std::iter::empty::<&Path>())?;
    output.write(text.as_bytes())
}

/// Fits the weights, and prints tables and reliability.
///
/// # Errors
/// An extraction fails.
pub(crate) fn run(args: &Args) -> Result<()> {
    let mut examples = Vec::new();
    if let Some(folder) = &args.check {
        look_at_labelled(folder, false, &mut examples)?;
        write_examples(args.examples.as_deref(), &examples)?;
        return check(&examples, args.diagram.as_deref());
    }
    let hard = Class::HARD
        .into_iter()
        .filter(|class| !Class::ALL.contains(class));
    let all = [&Class::ALL[..], &Class::PLAIN].concat();
    let classes = all.into_iter().map(|class| (class, 0));
    let classes = classes.chain(hard.map(|class| (class, HARD_FROM)));
    let pictures = classes
        .flat_map(|(class, first)| (first..first + args.seeds).map(move |seed| (class, seed)));
    let pictures: Vec<_> = pictures.collect();
    examples.extend(in_parallel(&pictures, |&(class, seed), examples| {
        let Some(still) = draw(class, seed) else {
            return Ok(());
        };
        (Ground::ALL.into_iter())
            .try_for_each(|ground| look(&still, (class, seed), ground, examples))
    })?);
    if let Some(folder) = &args.labelled {
        look_at_labelled(folder, true, &mut examples)?;
    }
    write_examples(args.examples.as_deref(), &examples)?;
    for (name, maker) in MAKERS {
        let of = |is_fitted: bool| {
            let some = examples.iter().filter(move |one: &&Example| {
                one.evidence.maker == maker && one.is_fitted == is_fitted
            });
            some.collect::<Vec<_>>()
        };
        let weights = Weights::fit(&of(true), maker.others().len());
        print!("{}", weights.as_rust(name))?;
        println!("fitted: {}", weights.reliability(&of(true)))?;
        println!("others: {}", weights.reliability(&of(false)))?;
    }
    Ok(())
}

/// Extracts from a picture on a background with every kind of mask.
fn look(
    still: &Still,
    (class, seed): (Class, u64),
    ground: Ground,
    examples: &mut Vec<Example>,
) -> Result<()> {
    let mut random = SplitMix64::of_stream(seed, 0xC0F1 + 8 * class as u64 + ground as u64);
    let (width, height) = (still.width, still.height);
    let cover = masks::cover(still);
    let mut rgb = still.rgb.clone();
    ground.lay(&mut rgb, &cover, width, &mut random);
    let image = Image::new(&rgb, width, height, 3 * width, PixelFormat::Rgb8)?;
    let uneven = masks::uneven(&cover, width, &mut random);
    let damaged = masks::damaged(&cover, still, &mut random);
    let damaged = masks::uneven(&damaged, width, &mut random);
    // A given mask is the same on each background, so it is used on only one.
    let is_given = ground as u64 == seed % Ground::ALL.len() as u64;
    let given = [&cover, &uneven, &damaged];
    let given = given.into_iter().filter(|_| is_given);
    for (how, mask) in kinds(&image, seed, given) {
        let (curves, evidence) = extract(&image, how, mask)?;
        let judged = curves.iter().zip(&evidence);
        examples.extend(judged.map(|(curve, evidence): (_, &Evidence)| {
            let is_right = right::is_right(&still.truth, curve) && evidence.is_shown();
            let label = match right::is_false(&still.truth, curve) {
                _ if is_right => Label::of(CurveClass::Rope),
                true => label_of_thing(class, seed, evidence),
                false => Label::of(CurveClass::Fragment),
            };
            Example {
                evidence: *evidence,
                label: label.for_maker(evidence.maker),
                is_fitted: seed / 4 % 2 == 0,
            }
        }));
    }
    Ok(())
}

/// Returns what is known of a curve that is off every rope.
fn label_of_thing(class: Class, seed: u64, evidence: &Evidence) -> Label {
    use CurveClass::{Edge, Mark, Pen, Rim, Shadow};
    match class {
        Class::HardShadow | Class::SoftShadow => Label::of(Shadow),
        Class::Things => Label::of([Pen, Pen, Edge, Rim, Mark][seed as usize % 5]),
        _ => Label::of_thing(evidence),
    }
}

/// Extracts from labeled pictures with every kind of mask. If `are_warped`, three of four pictures
/// are warped first.
fn look_at_labelled(folder: &Path, are_warped: bool, examples: &mut Vec<Example>) -> Result<()> {
    let pictures: Vec<_> = labelled::photographs(folder)?.enumerate().collect();
    examples.extend(in_parallel(&pictures, |(number, picture), examples| {
        let mut picture = picture.load()?;
        if are_warped && !number.is_multiple_of(4) {
            let mut random = SplitMix64::of_stream(*number as u64, 0xC0F3);
            let warp = Warp::draw(&mut random);
            picture.map(|photo| warp.picture(photo), |label| warp.labels(label));
        }
        look_at_one(*number, &picture, examples)
    })?);
    Ok(())
}

fn look_at_one(number: usize, picture: &Labelled, examples: &mut Vec<Example>) -> Result<()> {
    let rgb = picture.photo.to_rgb8();
    let [width, height] = [rgb.width() as usize, rgb.height() as usize];
    let image = Image::new(&rgb, width, height, 3 * width, PixelFormat::Rgb8)?;
    let mask = picture.mask();
    let mut random = SplitMix64::of_stream(number as u64, 0xC0F2);
    let uneven = masks::uneven(&mask, width, &mut random);
    for (how, mask) in kinds(&image, number as u64, [&mask, &uneven]) {
        let (curves, judged) = extract(&image, how, mask)?;
        let right = picture.is_whole(&curves);
        let all = curves.iter().zip(judged).zip(right);
        examples.extend(all.map(|((curve, evidence), is_right)| {
            let label = match picture.is_off(curve) {
                _ if is_right && evidence.is_shown() => Label::of(CurveClass::Rope),
                true => Label::of_thing(&evidence),
                false => Label::of(CurveClass::Fragment),
            };
            Example {
                evidence,
                label: label.for_maker(evidence.maker),
                is_fitted: (number / 4).is_multiple_of(2),
            }
        }));
    }
    Ok(())
}

/// Returns the kinds of masks to try on a picture. Color ranges are picked only in every fourth
/// one, because picking takes a tenth of a second.
fn kinds<'a>(
    image: &Image,
    number: u64,
    given: impl IntoIterator<Item = &'a Vec<u8>>,
) -> Vec<(Mask, Option<&'a [u8]>)> {
    let picked = (number.is_multiple_of(4))
        .then(|| pick(image, &[]).ok())
        .flatten();
    let by_color = picked.map(|picked| (Mask::Hsv(picked.ranges), None));
    let given = given
        .into_iter()
        .map(|mask| (Mask::External, Some(&mask[..])));
    let own = [(Mask::Auto, None), (Mask::Network, None)];
    own.into_iter().chain(by_color).chain(given).collect()
}

/// Returns all curves in a picture, including unlikely ones, and the evidence for them.
fn extract(image: &Image, how: Mask, mask: Option<&[u8]>) -> Result<(Vec<Curve>, Vec<Evidence>)> {
    let (width, height) = (image.width(), image.height());
    let mut extractor = Extractor::new(Options::default().mask(how).min_confidence(0.0))?;
    let curves = match mask {
        None => extractor.extract(image).curves.to_vec(),
        Some(mask) => {
            let mask = Image::new(mask, width, height, width, PixelFormat::Gray8)?;
            extractor.extract_masked(image, &mask)?.curves.to_vec()
        }
    };
    Ok((curves, extractor.evidence().copied().collect()))
}
