//! `lariat-bench network`: the cost of the mask network on one core, layer by layer. It is shown
//! next to the machine's maximum rate of multiply-adds, for every kind of registers, and next to
//! ONNX Runtime with the same weights.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use crate::{Samples, Table, micros, millis, multiple};
use anyhow::{Context, Result, ensure};
use lariat_network::{LAYERS, Maps, Network, Picture, Workspace};
use lariat_portable::{ConvolutionKernels, SplitMix64};
use serde::{Deserialize, Serialize};

use crate::python::Said;

/// What to measure.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// File of weights (default: random ones, which cost the same)
    #[arg(value_name = "WEIGHTS")]
    weights: Option<PathBuf>,
    /// Width of the picture in pixels
    #[arg(long, value_name = "PX", default_value_t = 640)]
    width: usize,
    /// Height of the picture in pixels
    #[arg(long, value_name = "PX", default_value_t = 480)]
    height: usize,
    /// Number of pictures for each median
    #[arg(long, value_name = "N", default_value_t = 200)]
    rounds: usize,
    /// Python interpreter that has onnx and onnxruntime: measure these too (the sides must be
    /// multiples of 16)
    #[arg(long, value_name = "PATH")]
    python: Option<PathBuf>,
    /// Write the ONNX models next to this name
    #[arg(long, value_name = "PATH", requires = "python")]
    keep: Option<PathBuf>,
}

/// Number of times that the instruction alone is timed, some 50 µs each. The best time gives the
/// limit.
const SPINS: usize = 400;
const SPIN_ROUNDS: u64 = 20_000;
/// Number of rounds of the scalar loop, which serves to check equality and not to measure speed.
const PLAIN_ROUNDS: usize = 2;
/// Work outside the layers.
const OTHERS: [&str; 3] = ["picture", "skips", "maps"];

/// Measures and prints the tables.
///
/// # Errors
/// The file does not contain weights, or a script fails.
pub(crate) fn run(args: &Args) -> Result<()> {
    ensure!(
        args.rounds > 0,
        "there is nothing to measure: give --rounds of 1 or more"
    );
    let mut bench = Bench::new(args)?;
    let mut kinds = Table::new(&["instructions", "median ms", "GMAC/s", "limit", "share %"]);
    for kernels in ConvolutionKernels::all().into_iter().rev() {
        let rounds = if kernels.name() == "plain" {
            PLAIN_ROUNDS
        } else {
            args.rounds
        };
        let mut samples = Samples::default();
        bench.whole(kernels, rounds.min(args.rounds), &mut samples)?;
        let ns = samples.median();
        let (rate, limit) = (bench.multiply_adds() / ns, limit(kernels));
        let figures = [millis(ns), tenth(rate), tenth(limit), percent(rate / limit)];
        kinds.push([kernels.name().to_owned()].into_iter().chain(figures));
    }
    print!("{}\n{kinds}", bench.layers(args.rounds)?)?;
    if let Some(python) = &args.python {
        bench.rivals(args, python)?;
    }
    Ok(())
}

/// The network, a picture, and memory for its maps.
struct Bench {
    network: Network,
    workspace: Workspace,
    rgb: Vec<u8>,
    size: [usize; 2],
    maps: [Vec<u8>; 2],
}

impl Bench {
    fn new(args: &Args) -> Result<Self> {
        let network = match &args.weights {
            None => Network::random(1),
            Some(path) => {
                let bytes =
                    fs::read(path).with_context(|| format!("{} cannot be read", path.display()))?;
                Network::from_bytes(&bytes)?
            }
        };
        let pixels = args.width * args.height;
        let mut random = SplitMix64::new(1);
        Ok(Self {
            network,
            workspace: Workspace::new(),
            rgb: (0..3 * pixels).map(|_| random.next_u64() as u8).collect(),
            size: [args.width, args.height],
            maps: [(); 2].map(|()| vec![0; pixels]),
        })
    }

    fn multiply_adds(&self) -> f64 {
        let [width, height] = self.size;
        LAYERS
            .iter()
            .map(|layer| layer.multiply_adds(width, height) as f64)
            .sum()
    }

    /// Runs the network on the picture. `done` receives the name of each completed step.
    fn look(&mut self, kernels: ConvolutionKernels, done: impl FnMut(&'static str)) -> Result<()> {
        let [width, height] = self.size;
        let picture = Picture {
            rgb: &self.rgb,
            width,
            height,
            stride: 3 * width,
        };
        let [rope, seam] = &mut self.maps;
        let maps = Maps {
            rope,
            seam,
            stride: width,
        };
        self.network
            .run_observed(kernels, &mut self.workspace, picture, maps, done)?;
        Ok(())
    }

    fn whole(
        &mut self,
        kernels: ConvolutionKernels,
        rounds: usize,
        samples: &mut Samples,
    ) -> Result<()> {
        for _ in 0..rounds {
            let mut done = Ok(());
            samples.time(|| done = self.look(kernels, |_| ()));
            done?;
        }
        Ok(())
    }

    /// Measures each layer with the default registers.
    fn layers(&mut self, rounds: usize) -> Result<Table> {
        let kernels = ConvolutionKernels::new();
        let names = LAYERS.iter().map(|layer| layer.name).chain(OTHERS);
        let mut samples = Vec::from_iter(names.map(|name| (name, Samples::default())));
        for _ in 0..rounds {
            let mut ns = vec![0.0; samples.len()];
            let mut before = Instant::now();
            self.look(kernels, |name| {
                let now = Instant::now();
                if let Some(at) = samples.iter().position(|(known, _)| *known == name) {
                    ns[at] += (now - before).as_secs_f64() * 1e9;
                }
                before = now;
            })?;
            for ((_, samples), ns) in samples.iter_mut().zip(ns) {
                samples.push(ns);
            }
        }
        let limit = limit(kernels);
        let head = [kernels.name(), "median µs", "MMAC", "GMAC/s", "share %"];
        let mut table = Table::new(&head);
        let mut row = |name: &str, ns: f64, multiply_adds: f64| {
            let rate = multiply_adds / ns;
            let figures = match multiply_adds {
                0.0 => [(); 3].map(|()| "-".to_owned()),
                _ => [
                    tenth(multiply_adds / 1e6),
                    tenth(rate),
                    percent(rate / limit),
                ],
            };
            table.push([name.to_owned(), micros(ns)].into_iter().chain(figures));
        };
        let [width, height] = self.size;
        let mut sum = 0.0;
        for (name, samples) in &samples {
            let layer = LAYERS.iter().find(|layer| layer.name == *name);
            let multiply_adds = layer.map_or(0, |layer| layer.multiply_adds(width, height));
            sum += samples.median();
            row(name, samples.median(), multiply_adds as f64);
        }
        row("all", sum, self.multiply_adds());
        Ok(table)
    }

    /// Runs ONNX Runtime on the same picture and prints a table.
    fn rivals(&mut self, args: &Args, python: &Path) -> Result<()> {
        let [width, height] = self.size;
        ensure!(
            width % Network::MULTIPLE == 0 && height % Network::MULTIPLE == 0,
            "ONNX Runtime's models are of whole pictures: give sides that are multiples of {}",
            Network::MULTIPLE
        );
        let kernels = ConvolutionKernels::new();
        let mut own = Samples::default();
        self.whole(kernels, args.rounds, &mut own)?;
        let folder = tempfile::tempdir()?;
        let write = |name: &str, bytes: &[u8]| -> Result<PathBuf> {
            let path = folder.path().join(name);
            fs::write(&path, bytes).context("cannot write what the script is asked")?;
            Ok(path)
        };
        let request = Request {
            weights: write("weights", &self.network.to_bytes())?,
            picture: write("picture", &self.rgb)?,
            rope: write("rope", &self.maps[0])?,
            seam: write("seam", &self.maps[1])?,
            width,
            height,
            rounds: args.rounds,
            keep: args.keep.clone(),
        };
        let mut said = Said::default();
        let theirs = said.ask::<Measured>(python, "network.py", &request)?;
        // lariat is measured before and after the rivals, so that drift of the machine affects
        // both.
        self.whole(kernels, args.rounds, &mut own)?;
        let ns = own.median();
        let head = [
            "",
            "median ms",
            "÷ lariat",
            "mean off",
            "most off",
            "other %",
        ];
        let mut table = Table::new(&head);
        let own = [
            millis(ns),
            multiple(1.0),
            "-".into(),
            "-".into(),
            "-".into(),
        ];
        table.push(
            [format!("lariat, {}", kernels.name())]
                .into_iter()
                .chain(own),
        );
        for theirs in theirs {
            table.push([
                format!("ONNX Runtime, {}", theirs.name),
                millis(theirs.median_ns),
                multiple(theirs.median_ns / ns),
                format!("{:.4}", theirs.mean),
                format!("{:.1}", theirs.most),
                percent(theirs.other),
            ]);
        }
        print!("\n{table}")?;
        said.print(python)?;
        Ok(())
    }
}

/// Request to the script.
#[derive(Serialize)]
struct Request {
    weights: PathBuf,
    picture: PathBuf,
    rope: PathBuf,
    seam: PathBuf,
    width: usize,
    height: usize,
    rounds: usize,
    keep: Option<PathBuf>,
}

/// A model's time, and the difference of its maps from lariat's in byte steps.
#[derive(Deserialize)]
struct Measured {
    name: String,
    median_ns: f64,
    mean: f64,
    most: f64,
    /// Share of pixels that differ by more than half a step.
    other: f64,
}

/// Returns the multiply-adds per nanosecond of the instruction alone.
fn limit(kernels: ConvolutionKernels) -> f64 {
    let rate = |_| {
        let start = Instant::now();
        let spin = std::hint::black_box(kernels.spin(SPIN_ROUNDS));
        spin.multiply_adds as f64 / (start.elapsed().as_secs_f64() * 1e9)
    };
    (0..SPINS).map(rate).fold(0.0, f64::max)
}

fn tenth(value: f64) -> String {
    format!("{value:.1}")
}

fn percent(share: f64) -> String {
    tenth(100.0 * share)
}
