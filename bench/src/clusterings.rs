//! `lariat-bench clusterings`: computes 120 centers in the mask of a rope with the paper's four
//! clusterings. One table compares lariat's implementations with those of scikit-learn, MiniSom and
//! scikit-fuzzy. They run in turns on one thread, from the same start.

use std::path::PathBuf;
use std::time::Instant;

use crate::{Samples, Table, millis, rendered, times};
use anyhow::{Context, Result};
use lariat_capture::RenderOptions;
use lariat_clustering::{FuzzyMeans, KMeans, Mixture, Outcome, Pixels, Som, Start, seed_centers};
use lariat_extract::{Mask, mask_of};
use serde::{Deserialize, Serialize};

use crate::python::Said;

/// Number of centers, equal to the paper's number of points.
const CENTERS: usize = 120;
/// Number of lariat's runs per turn.
const RUNS: usize = 20;

/// What to measure.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Python interpreter that has the libraries
    #[arg(long, value_name = "PATH", default_value = "python3")]
    python: PathBuf,
    /// Number of turns of each program (scikit-fuzzy, which takes some 20 s, has only one)
    #[arg(long, value_name = "N", default_value_t = 3)]
    passes: usize,
    /// Seed of the rope and of the initial centers
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
}

/// Runs a method.
type Run = Box<dyn FnMut(&Pixels, Start, &mut [[f32; 2]]) -> Outcome>;

/// A method of lariat's.
struct Method {
    /// Name of the method in the script.
    name: &'static str,
    objective: &'static str,
    run: Run,
    rival: Rival,
}

/// Runs requested from the rival.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Rival {
    /// Both starts in every pass, because the rival treats the last frame's centers like any
    /// others.
    Both,
    /// Only the first start, in every pass.
    Cold,
    /// Only the first start, once: it takes some 20 s.
    Once,
}

/// Returns the methods in the order of the paper.
fn methods() -> Vec<Method> {
    fn of(
        name: &'static str,
        objective: &'static str,
        rival: Rival,
        run: impl FnMut(&Pixels, Start, &mut [[f32; 2]]) -> Outcome + 'static,
    ) -> Method {
        Method {
            name,
            objective,
            run: Box::new(run),
            rival,
        }
    }
    let (mut kmeans, mut som) = (KMeans::default(), Som::default());
    let (mut mixture, mut fuzzy) = (Mixture::default(), FuzzyMeans::default());
    let (likelihood, quantization) = ("log-likelihood of a pixel, nats", "quantization error, px");
    vec![
        of("kmeans", "inertia, px²", Rival::Both, move |p, s, c| {
            kmeans.run(p, s, c)
        }),
        of("som", quantization, Rival::Cold, move |p, s, c| {
            som.run(p, s, c)
        }),
        of("gmm", likelihood, Rival::Both, move |p, s, c| {
            mixture.run(p, s, c)
        }),
        of("fcm", "J, px²", Rival::Once, move |p, s, c| {
            fuzzy.run(p, s, c)
        }),
    ]
}

/// A method from one start: its times and its final state.
#[derive(Default)]
struct Measured {
    ns: Samples,
    last: Option<Ended>,
}

struct Ended {
    rounds: u32,
    objective: f64,
}

/// Request to the script.
#[derive(Serialize)]
struct Request<'a> {
    /// The pixels of each mask.
    masks: [Vec<[f32; 2]>; 2],
    /// Seed of the samples that a self-organizing map draws.
    seed: u64,
    runs: Vec<Asked<'a>>,
}

/// One requested run: its method, mask and initial centers.
#[derive(Serialize)]
struct Asked<'a> {
    method: &'a str,
    mask: usize,
    centers: &'a [[f32; 2]],
}

/// The script's answer about a run.
#[derive(Deserialize)]
struct Answer {
    run: usize,
    ns: f64,
    rounds: u32,
    objective: f64,
}

/// A method with two results from lariat and two from its rival: those from the k-means++ start and
/// those from the last frame's centers.
struct Row {
    method: Method,
    /// Initial centers of the second frame's run: the final ones of the first.
    centers: Vec<[f32; 2]>,
    ours: [Measured; 2],
    theirs: [Measured; 2],
}

/// Measures and prints the table.
///
/// # Errors
/// The rope cannot be drawn, the pixels cannot be written for the script, or the script fails.
pub(crate) fn run(args: &Args) -> Result<()> {
    anyhow::ensure!(
        args.passes > 0,
        "there is nothing to measure: give --passes of 1 or more"
    );
    let masks = masks(args.seed)?;
    let mut start = vec![[0.0; 2]; CENTERS];
    seed_centers(&masks[0], args.seed, &mut start);
    let row = |method| Row {
        method,
        centers: vec![[0.0; 2]; CENTERS],
        ours: Default::default(),
        theirs: Default::default(),
    };
    let mut rows: Vec<Row> = methods().into_iter().map(row).collect();
    let mut said = Said::default();
    for pass in 0..args.passes {
        for row in &mut rows {
            row.measure(&masks, args.seed);
        }
        ask(&mut said, args, &masks, &start, pass, &mut rows)?;
    }
    print!("{}", table(&rows))?;
    let pixels = masks.each_ref().map(Pixels::len);
    println!(
        "{CENTERS} centers, {} pixels, from k-means++ (lariat's in its time, the rival's not); then {} pixels, 1/30 s \
         later, from where lariat ended.\n÷ lariat: the rival's time by lariat's, from the same start; its first: from \
         k-means++. objectives: lariat's ÷ the rival's. Objective: {}",
        pixels[0],
        pixels[1],
        rows.iter()
            .map(|row| format!("{} {}", row.method.name, row.method.objective))
            .collect::<Vec<_>>()
            .join("; ")
    )?;
    said.print(&args.python)?;
    Ok(())
}

/// Returns the pixels of two successive frames of the rope that the chain renders, some 27,000
/// each.
fn masks(seed: u64) -> Result<[Pixels; 2]> {
    let frames = rendered(&RenderOptions {
        seed,
        width: 960,
        height: 720,
        rope_px: 32.0,
        frames: Some(2),
        ..RenderOptions::default()
    })?;
    let mut masks = Vec::new();
    for frame in &frames {
        let image = frame.picture.image();
        let mask = mask_of(&image, &Mask::default());
        masks.push(Pixels::of_rows(mask.chunks(image.width())));
    }
    <[Pixels; 2]>::try_from(masks)
        .ok()
        .context("the rendered rope does not have the two frames requested")
}

impl Row {
    /// Runs lariat's turn.
    fn measure(&mut self, masks: &[Pixels; 2], seed: u64) {
        let mut centers = vec![[0.0; 2]; CENTERS];
        for _ in 0..RUNS {
            let starts = [Start::Seeded(seed), Start::Given];
            for ((start, pixels), ours) in starts.into_iter().zip(masks).zip(&mut self.ours) {
                let begin = Instant::now();
                let outcome = (self.method.run)(pixels, start, &mut centers);
                ours.ns.push(begin.elapsed().as_secs_f64() * 1e9);
                ours.last = Some(Ended {
                    rounds: outcome.rounds,
                    objective: outcome.objective,
                });
                if start != Start::Given {
                    self.centers.clone_from(&centers);
                }
            }
        }
    }
}

/// Runs the rivals' turn.
fn ask(
    said: &mut Said,
    args: &Args,
    masks: &[Pixels; 2],
    start: &[[f32; 2]],
    pass: usize,
    rows: &mut [Row],
) -> Result<()> {
    let of_pass = |row: &&mut Row| pass == 0 || row.method.rival != Rival::Once;
    // Row and start of each requested run.
    let mut asked = Vec::new();
    let mut runs = Vec::new();
    let mut rows: Vec<_> = rows.iter_mut().filter(of_pass).collect();
    for (index, row) in rows.iter().enumerate() {
        for mask in 0..if row.method.rival == Rival::Both {
            2
        } else {
            1
        } {
            asked.push((index, mask));
            runs.push(Asked {
                method: row.method.name,
                mask,
                centers: if mask == 0 { start } else { &row.centers },
            });
        }
    }
    let places = |pixels: &Pixels| {
        let places = pixels.xs().iter().zip(pixels.ys());
        places.map(|(&x, &y)| [x, y]).collect()
    };
    let masks = masks.each_ref().map(places);
    let seed = args.seed;
    let request = Request { masks, seed, runs };
    for answer in said.ask::<Answer>(&args.python, "methods.py", &request)? {
        let run = answer.run;
        let (row, start) = *asked
            .get(run)
            .with_context(|| format!("methods.py was not asked for a run {run}"))?;
        let theirs = &mut rows[row].theirs[start];
        theirs.ns.push(answer.ns);
        theirs.last = Some(Ended {
            rounds: answer.rounds,
            objective: answer.objective,
        });
    }
    Ok(())
}

fn table(rows: &[Row]) -> Table {
    let mut table = Table::new(&[
        "method, from",
        "ms",
        "rounds",
        "objective",
        "rival's ms",
        "rounds",
        "objective",
        "÷ lariat",
        "its first ÷ lariat",
        "objectives",
    ]);
    for row in rows {
        let starts = ["k-means++", "last frame"].into_iter().zip(&row.ours);
        for ((start, ours), theirs) in starts.zip(&row.theirs) {
            let mut cells = vec![format!("{}, {start}", row.method.name)];
            cells.extend(ours.cells());
            cells.extend(theirs.cells());
            let ns = ours.ns.median();
            for theirs in [theirs, &row.theirs[0]] {
                cells.push(theirs.ns().map_or("-".into(), |theirs| times(theirs, ns)));
            }
            cells.push(match (&ours.last, &theirs.last) {
                (Some(ours), Some(theirs)) => {
                    format!("{:.4}", ours.objective / theirs.objective)
                }
                _ => "-".into(),
            });
            table.push(cells);
        }
    }
    table
}

impl Measured {
    /// Returns the median time in nanoseconds, if it was measured.
    fn ns(&self) -> Option<f64> {
        self.last.as_ref().map(|_| self.ns.median())
    }

    fn cells(&self) -> [String; 3] {
        match &self.last {
            Some(last) => [
                millis(self.ns.median()),
                last.rounds.to_string(),
                // Six significant digits.
                match last.objective {
                    o if o.abs() < 1e3 => format!("{o:.4}"),
                    o => format!("{o:.0}"),
                },
            ],
            None => ["-", "-", "-"].map(Into::into),
        }
    }
}
