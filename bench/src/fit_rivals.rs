//! `lariat-bench fit-rivals`: the curve of order 8 through 120 points by NumPy, SciPy and geomdl,
//! and by lariat, in turns on one thread, in one table.

use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::time::Instant;

use crate::{Samples, Table, micros, multiple};
use anyhow::Result;
use lariat_fit::{Basis, Fitter, Knots, Options, Rho, Solver, Weights};
use serde::Deserialize;

use crate::python::Said;

/// Number of fits between two clock readings.
const BATCH: usize = 1000;

/// What to measure.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Python interpreter that has the libraries
    #[arg(long, value_name = "PATH", default_value = "python3")]
    python: PathBuf,
    /// Number of turns of each program
    #[arg(long, value_name = "N", default_value_t = 5)]
    passes: usize,
}

#[derive(Deserialize)]
struct Measured {
    name: String,
    median_ns: f64,
}

/// Results of the rivals over all passes.
#[derive(Default)]
struct Theirs {
    /// Times in the order in which the rivals reported them.
    ns: Vec<(String, Samples)>,
    said: Said,
}

/// Measures and prints the table.
///
/// # Errors
/// The points cannot be written for the script, or the script fails.
pub(crate) fn run(args: &Args) -> Result<()> {
    anyhow::ensure!(
        args.passes > 0,
        "there is nothing to measure: give --passes of 1 or more"
    );
    let rope = rope();
    let mut ours: Vec<(&str, Fitter, Samples)> = ways()
        .into_iter()
        .map(|(name, options)| Ok((name, Fitter::new(options)?, Samples::default())))
        .collect::<Result<_>>()?;
    let mut alone = (Fitter::new(Options::default())?, Samples::default());
    let mut theirs = Theirs::default();
    for _ in 0..args.passes {
        for (_, fitter, samples) in &mut ours {
            for _ in 0..100 {
                samples.push(nanoseconds(|| {
                    // These points can always be fitted.
                    let _ = black_box(fitter.fit(black_box(&rope)));
                }));
            }
        }
        for _ in 0..100 {
            let (fitter, samples) = &mut alone;
            samples.push(nanoseconds(|| {
                let _ = black_box(fitter.control_points(black_box(&rope)));
            }));
        }
        theirs.measure(&args.python, &rope)?;
    }
    let (alone_ns, pinv_ns) = (alone.1.median(), ours[0].2.median());
    let ratios = |ns: f64| [multiple(ns / alone_ns), multiple(ns / pinv_ns)];
    let mut table = Table::new(&[
        "order 8, 120 points",
        "median µs",
        "÷ control points alone",
        "÷ lariat pinv",
    ]);
    let fits = ours.iter().map(|(name, _, samples)| (*name, samples));
    for (name, samples) in [("control points alone", &alone.1)].into_iter().chain(fits) {
        let ns = samples.median();
        let [alone, pinv] = ratios(ns);
        table.push([
            format!("lariat {name}"),
            format!("{:.3}", ns / 1e3),
            alone,
            pinv,
        ]);
    }
    for (name, samples) in &theirs.ns {
        let ns = samples.median();
        let [alone, pinv] = ratios(ns);
        table.push([name.clone(), micros(ns), alone, pinv]);
    }
    print!("{table}")?;
    theirs.said.print(&args.python)?;
    Ok(())
}

/// Returns lariat's options to measure, the default first.
fn ways() -> Vec<(&'static str, Options)> {
    let plain = Options::default();
    let of = |basis| plain.basis(basis);
    let spline = Basis::BSpline {
        degree: 3,
        control_points: 9,
        knots: Knots::Uniform,
    };
    vec![
        ("pinv", plain),
        ("cholesky", plain.solver(Solver::Cholesky)),
        ("qr", plain.solver(Solver::Qr)),
        ("cubic B-spline", of(spline)),
        ("rational", of(Basis::RationalBezier { order: 8 })),
        ("Fourier", of(Basis::Fourier { harmonics: 4 })),
        ("measured arc length", plain.rho(Rho::Measured)),
        ("Huber", plain.weights(Weights::Robust)),
        (
            "order by tolerance, up to 16",
            Options::bezier(16).choose_size(true),
        ),
    ]
}

/// Returns the mean time of one call, in nanoseconds.
fn nanoseconds(mut fit: impl FnMut()) -> f64 {
    let start = Instant::now();
    for _ in 0..BATCH {
        fit();
    }
    start.elapsed().as_secs_f64() * 1e9 / BATCH as f64
}

/// Returns a noisy rope, so that no method has an easy case.
fn rope() -> Vec<[f64; 2]> {
    let mut state = 1u64;
    let mut noise = move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 40) as f64 / (1u64 << 24) as f64 - 0.5
    };
    (0..120)
        .map(|i| {
            let t = f64::from(i) / 119.0;
            [
                50.0 + 540.0 * t + noise(),
                240.0 + 150.0 * (5.0 * t).sin() + noise(),
            ]
        })
        .collect()
}

impl Theirs {
    fn measure(&mut self, python: &Path, points: &[[f64; 2]]) -> Result<()> {
        for line in self.said.ask(python, "fit.py", &points)? {
            let Measured { name, median_ns } = line;
            match self.ns.iter_mut().find(|(known, _)| *known == name) {
                Some((_, samples)) => samples.push(median_ns),
                None => self.ns.push((name, Samples::from_iter([median_ns]))),
            }
        }
        Ok(())
    }
}
