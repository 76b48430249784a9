//! `lariat calibrate plane`: computes the plane's file from points that were clicked in a picture
//! and measured on the table.

mod points;

use anyhow::{Context, Result};
use clap::{Args, Subcommand};
use lariat_camera::{Camera, Pair};
use lariat_chain::calibrated::read_camera;
use lariat_chain::exit::wrong_use;
use lariat_chain::layout::{self, Column, Table, hanging};
use lariat_chain::measured_plane::MeasuredPlane;
use lariat_chain::output::{Existing, Output, print};
use lariat_chain::picture::Picture;
use lariat_chain::settings;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Calibrate positions in the camera's view
#[derive(Debug, Args)]
pub(crate) struct CalibrateArgs {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    /// Calibrate the table's plane from at least four points with known positions
    Plane(PlaneArgs),
}

/// Calibrate the table's plane from at least four points with known positions
#[derive(Debug, Args)]
struct PlaneArgs {
    /// Picture that the points were read in; it also gives the size of the camera's images
    #[arg(value_name = "IMAGE")]
    image: Option<PathBuf>,
    /// Points as pixels=millimeters, for instance "100,80=0,0 540,85=297,0 560,400=297,210
    /// 90,395=0,210"
    #[arg(long, value_name = "X,Y=X,Y …", allow_hyphen_values = true)]
    points: Option<String>,
    /// File of points, one per line: x y in pixels, then X Y in millimeters
    #[arg(long, value_name = "FILE", conflicts_with = "points")]
    points_file: Option<PathBuf>,
    /// Lens calibration, if the lens distorts: a YAML file from OpenCV or ROS
    #[arg(long, value_name = "FILE")]
    calibration: Option<PathBuf>,
    /// Size of the images, for instance 640x480 (default: the picture's size, otherwise the
    /// calibration's)
    #[arg(long, value_name = "WxH")]
    size: Option<String>,
    /// File to write the plane to, - for standard output; without it, the plane is only judged
    #[arg(long, value_name = "FILE.toml")]
    out: Option<PathBuf>,
    /// Overwrite an existing file
    #[arg(long)]
    force: bool,
}

impl PlaneArgs {
    /// Prepares an output file, which must not replace an input.
    fn output(&self, file: &Path) -> Result<Output> {
        let inputs = [&self.image, &self.points_file, &self.calibration];
        let inputs = inputs.into_iter().flatten().map(PathBuf::as_path);
        Output::new(file, Existing::forced(self.force), inputs)
    }
}

/// Runs `lariat calibrate`.
///
/// # Errors
/// Returns an error if the points determine no plane, the calibration is invalid, or a file cannot
/// be read or written.
pub(crate) fn run(args: CalibrateArgs) -> Result<ExitCode> {
    let What::Plane(args) = args.what;
    let camera = args.calibration.as_deref().map(read_camera).transpose()?;
    let size = size(&args, camera.as_ref())?;
    let output = args.out.as_deref();
    let output = output.map(|file| args.output(file)).transpose()?;
    let pairs = match (&args.points, &args.points_file) {
        (Some(text), _) => points::of_flag(text)?,
        (None, Some(path)) => {
            let text = lariat_chain::bounded::read_text(path)
                .with_context(|| format!("cannot read the points {}", path.display()))?;
            points::of_file(&text).with_context(|| path.display().to_string())?
        }
        (None, None) => wrong_use!(
            "name four points or more: --points \"x,y=X,Y x,y=X,Y …\" (pixels=millimetres), or --points-file FILE; to click \
             them, open `lariat run --view`"
        ),
    };
    let measured = MeasuredPlane::of(&pairs, camera.as_ref(), size)?;
    let judged = judged(&pairs, &measured);
    // The file is written even if nobody reads this output.
    let said = match &output {
        Some(output) => output.print(&judged),
        None => print(&judged),
    };
    if let Some(output) = &output {
        let text = measured.file_text("`lariat calibrate plane`");
        output.write(text.as_bytes())?;
        eprintln!("lariat: the plane is in {output}: use it with --plane");
    }
    said?;
    Ok(ExitCode::SUCCESS)
}

/// Size of the images: as given, otherwise the picture's, otherwise the calibration's.
fn size(args: &PlaneArgs, camera: Option<&Camera>) -> Result<[u32; 2]> {
    let of_picture = match &args.image {
        Some(image) => {
            let picture = Picture::load(image)?;
            Some([picture.width(), picture.height()])
        }
        None => None,
    };
    if let Some(text) = &args.size {
        let said = match settings::image_size(text) {
            Ok(size) => size,
            Err(why) => wrong_use!("--size {text}: {why}"),
        };
        if let Some([width, height]) = of_picture.filter(|picture| *picture != said) {
            wrong_use!("--size {text}: the picture has {width}×{height} pixels: leave --size out");
        }
        return Ok(said);
    }
    let known = of_picture.or(camera.and_then(Camera::size));
    let Some(known) = known else {
        wrong_use!(
            "say how large the images are in which the points were read: name the picture, or --size 640x480"
        );
    };
    Ok(known)
}

/// Describes how well the points agree, and how large a pixel is.
fn judged(pairs: &[Pair], measured: &MeasuredPlane) -> String {
    let headings = ["point", "x px", "y px", "X mm", "Y mm", "off mm", "off px"];
    let mut rows = Vec::new();
    for (index, (Pair { pixel, plane_mm }, off)) in pairs.iter().zip(measured.off()).enumerate() {
        let ([x, y], [u, v]) = (pixel, plane_mm);
        let places = [x, y, u, v].map(|place| format!("{place:.1}"));
        let off = [off.mm, off.px].map(|off| format!("{off:.2}"));
        rows.push([&[(index + 1).to_string()], &places[..], &off].concat());
    }
    let mut text = Table::text(headings.map(Column::figures).into(), &rows, layout::width());
    text.push_str(&match measured.error_mm() {
        None => "four points determine the plane and leave nothing to tell their errors by:\na fifth would\n".to_owned(),
        Some([rms, most]) => {
            format!("off by {rms:.2} mm (root of the mean square), at most {most:.2} mm\n")
        }
    });
    let mapping = measured.mapping();
    let [right, bottom] = mapping.size().map(|side| f64::from(side) - 1.0);
    let places = [
        ("at the middle", [0.5 * right, 0.5 * bottom]),
        ("top left", [0.0, 0.0]),
        ("top right", [right, 0.0]),
        ("bottom left", [0.0, bottom]),
        ("bottom right", [right, bottom]),
    ];
    let scales = places.map(|(name, at)| match mapping.unit_per_px(at) {
        Ok(mm) => format!("{mm:.3} {name}"),
        Err(_) => format!("no table {name}"),
    });
    let scales = format!("mm per pixel: {}", scales.join(", "));
    text.push_str(&format!("{}\n", hanging(&scales, 2, layout::width())));
    text
}
