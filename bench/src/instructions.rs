//! `lariat-bench instructions`: runs the parts that determine lariat's speed, one at a time, for
//! valgrind to count their instructions.
//!
//! A count is exact on a busy machine, unlike a time. `.ci/gates instructions` starts this command
//! under `valgrind --tool=callgrind --toggle-collect='*instructions::counted*'`. Valgrind then
//! counts only within [`counted`], and the gate compares the counts with its record. The counts
//! come from the test build and from AVX2, because valgrind does not support AVX-512. Only changes
//! of the counts are meaningful.

use std::hint::black_box;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use lariat_capture::RenderOptions;
use lariat_drawn::scenes::{Class, draw};
use lariat_extract::Extractor;
use lariat_fit::{Basis, Fitter, Knots, Options, Solver};
use lariat_network::{Maps, Network, Workspace};
use lariat_wire::{DESCRIPTORS, Delivery, Descriptors, Domain, Receiver, Rig, Writer};

use crate::{Picture, paint, rendered};

const SIZE: [usize; 2] = [640, 480];
/// Size of the network's picture.
const SMALL: [usize; 2] = [160, 128];
/// Number of frames tracked before the one that is counted.
const FRAMES_BEFORE: u64 = 6;

/// The part to run.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Name of the part; without it, list all parts and draw their pictures
    part: Option<String>,
    /// Folder that holds the pictures, because drawing them under valgrind takes minutes
    #[arg(long, value_name = "DIR")]
    pictures: PathBuf,
}

/// Draws the pictures and lists the parts, or runs one part.
///
/// # Errors
/// The part is unknown, or a picture cannot be written or read.
pub(crate) fn run(args: &Args) -> Result<()> {
    let folder = Folder(&args.pictures);
    let Some(part) = &args.part else {
        folder.draw()?;
        return PARTS.iter().try_for_each(|(name, _)| println!("{name}"));
    };
    let Some((_, work)) = PARTS.iter().find(|(name, _)| name == part) else {
        bail!("the part {part} is unknown: the command lists all parts if none is given");
    };
    work(&folder)
}

type Part = fn(&Folder) -> Result<()>;

const PARTS: [(&str, Part); 13] = [
    ("extract-1-crossing", |folder| {
        first_frame(folder, "1-crossing")
    }),
    ("extract-5-crossings", |folder| {
        first_frame(folder, "5-crossings")
    }),
    ("extract-10-crossings", |folder| {
        first_frame(folder, "10-crossings")
    }),
    ("extract-8-ropes", |folder| first_frame(folder, "8-ropes")),
    ("follow", next_frame),
    ("network", network),
    ("fit-pinv", |_| fit(Solver::Pinv)),
    ("fit-cholesky", |_| fit(Solver::Cholesky)),
    ("fit-qr", |_| fit(Solver::Qr)),
    ("fit-weighted", |_| weighted_fit()),
    ("set-up-bezier", |_| set_up(Options::bezier(8))),
    ("set-up-bspline", |_| {
        set_up(Options::bezier(8).basis(Basis::BSpline {
            degree: 3,
            control_points: 12,
            knots: Knots::Uniform,
        }))
    }),
    ("message", |_| message()),
];

/// Does the work that is counted.
#[inline(never)]
fn counted<T>(work: impl FnOnce() -> T) -> T {
    black_box(work())
}

/// A folder of pictures as raw RGB bytes.
struct Folder<'a>(&'a Path);

impl Folder<'_> {
    fn draw(&self) -> Result<()> {
        let still = |class| Ok::<_, anyhow::Error>(draw(class, 1, SIZE[0], SIZE[1])?.rgb);
        self.write("1-crossing", &still(Class::Crossings1)?)?;
        self.write("5-crossings", &still(Class::Crossings5)?)?;
        self.write("10-crossings", paint::ten_crossings()?.bytes())?;
        self.write("8-ropes", paint::eight_ropes()?.bytes())?;
        let options = RenderOptions {
            frames: Some(FRAMES_BEFORE + 1),
            ..RenderOptions::default()
        };
        for (k, frame) in rendered(&options)?.iter().enumerate() {
            self.write(&format!("film-{k}"), frame.picture.bytes())?;
        }
        Ok(())
    }

    fn write(&self, name: &str, bytes: &[u8]) -> Result<()> {
        let path = self.0.join(name);
        std::fs::write(&path, bytes)
            .with_context(|| format!("{} cannot be written", path.display()))
    }

    fn read(&self, name: &str) -> Result<Picture> {
        let path = self.0.join(name);
        let bytes = std::fs::read(&path);
        let bytes = bytes.with_context(|| format!("{} cannot be read", path.display()))?;
        Picture::rgb(SIZE, &bytes).context("the picture has another size")
    }
}

fn extractor() -> Result<Extractor> {
    let mut extractor = Extractor::new(lariat_extract::Options::default())?;
    extractor.prepare(SIZE[0], SIZE[1]);
    Ok(extractor)
}

fn first_frame(folder: &Folder, name: &str) -> Result<()> {
    let (mut extractor, picture) = (extractor()?, folder.read(name)?);
    counted(|| extractor.extract(&picture.image()).curves.len());
    Ok(())
}

fn next_frame(folder: &Folder) -> Result<()> {
    let mut extractor = extractor()?;
    for k in 0..FRAMES_BEFORE {
        extractor.extract(&folder.read(&format!("film-{k}"))?.image());
    }
    let last = folder.read(&format!("film-{FRAMES_BEFORE}"))?;
    counted(|| extractor.extract(&last.image()).curves.len());
    Ok(())
}

fn network(folder: &Folder) -> Result<()> {
    let whole = folder.read("1-crossing")?;
    let [width, height] = SMALL;
    let network = Network::ropes();
    let mut workspace = Workspace::new();
    workspace.reserve(width, height);
    let [mut rope, mut seam] = [(); 2].map(|()| vec![0; width * height]);
    let picture = lariat_network::Picture {
        rgb: whole.bytes(),
        width,
        height,
        stride: 3 * SIZE[0],
    };
    let maps = Maps {
        rope: &mut rope,
        seam: &mut seam,
        stride: width,
    };
    counted(|| network.run(&mut workspace, picture, maps))?;
    Ok(())
}

fn points() -> Vec<[f64; 2]> {
    let at = |i: i32| {
        let t = f64::from(i) / 119.0;
        [50.0 + 540.0 * t, 240.0 + 150.0 * (5.0 * t).sin()]
    };
    (0..120).map(at).collect()
}

fn fit(solver: Solver) -> Result<()> {
    let points = points();
    let mut fitter = Fitter::new(Options::bezier(8).points(points.len()).solver(solver))?;
    counted(|| fitter.fit(&points).map(|fit| fit.rms_px))?;
    Ok(())
}

fn weighted_fit() -> Result<()> {
    let points = points();
    let weights: Vec<f64> = (0..points.len()).map(|i| 1.0 + (i % 3) as f64).collect();
    let mut fitter = Fitter::new(
        Options::bezier(8)
            .points(points.len())
            .weights(lariat_fit::Weights::Given),
    )?;
    counted(|| fitter.fit_weighted(&points, &weights).map(|fit| fit.rms_px))?;
    Ok(())
}

fn set_up(options: Options) -> Result<()> {
    let options = options.points(120);
    counted(|| Fitter::new(options))?;
    Ok(())
}

/// Writes and reads a message of descriptors.
fn message() -> Result<()> {
    let domain = Domain::named(&format!("count-{}", std::process::id()))?;
    let rig: Rig = "default".parse()?;
    let writer = Writer::<Descriptors>::create(&domain, &rig, &DESCRIPTORS, &Delivery::NewestWins)?;
    let reader = Receiver::descriptors(&domain, &rig)?;
    // The first messages connect to the reader.
    for _ in 0..2 {
        writer.slot()?.send()?;
        reader.next()?;
    }
    counted(|| {
        writer.slot()?.send()?;
        reader.next()
    })?
    .context("the message did not come")?;
    Ok(())
}
