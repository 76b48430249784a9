//! `lariat calibrate plane`: from points that were clicked in a picture and measured on the table to the plane's file.

mod page;
mod points;

use anyhow::{Context, Result, bail};
use clap::{Args, Subcommand};
use lariat_camera::{Camera, Mapping, Pair, Plane};
use lariat_chain::calibrated::read_camera;
use lariat_chain::exit::wrong_use;
use lariat_chain::layout::{self, Column, Table, hanging};
use lariat_chain::output::{Existing, Output, print};
use lariat_chain::picture::Picture;
use lariat_chain::plane_file;
use lariat_chain::settings;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Where what the camera sees lies
#[derive(Debug, Args)]
pub(crate) struct CalibrateArgs {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    /// The table, from four points or more whose place on it is known
    Plane(PlaneArgs),
}

/// The table, from four points or more whose place on it is known
#[derive(Debug, Args)]
struct PlaneArgs {
    /// Picture that the points were read in: it tells the size of the camera's images
    #[arg(value_name = "IMAGE")]
    image: Option<PathBuf>,
    /// Points as pixels=millimetres, for instance "100,80=0,0 540,85=297,0 560,400=297,210 90,395=0,210"
    #[arg(long, value_name = "X,Y=X,Y …", allow_hyphen_values = true)]
    points: Option<String>,
    /// File of points, a line each: x y in pixels, then X Y in millimetres
    #[arg(long, value_name = "FILE", conflicts_with = "points")]
    points_file: Option<PathBuf>,
    /// Lens calibration, if the lens distorts: a YAML file of OpenCV or ROS
    #[arg(long, value_name = "FILE")]
    calibration: Option<PathBuf>,
    /// Size of the images, for instance 640x480 (default: the picture's, else the calibration's)
    #[arg(long, value_name = "WxH")]
    size: Option<String>,
    /// Where to write the plane, - for standard output; without it, it is only judged
    #[arg(long, value_name = "FILE.toml")]
    out: Option<PathBuf>,
    /// Write a page on which the points are clicked in the picture, and do nothing else
    #[arg(long, value_name = "FILE.html", requires = "image", conflicts_with_all = ["points", "points_file", "out"])]
    html: Option<PathBuf>,
    /// Overwrite a file that is there already
    #[arg(long)]
    force: bool,
}

impl PlaneArgs {
    /// Where a file goes, beside those that are read.
    fn output(&self, file: &Path) -> Result<Output> {
        let inputs = [&self.image, &self.points_file, &self.calibration];
        let inputs = inputs.into_iter().flatten().map(PathBuf::as_path);
        Output::new(file, Existing::forced(self.force), inputs)
    }
}

/// Runs `lariat calibrate`.
///
/// # Errors
/// Points that determine no plane, an invalid calibration, files that cannot be read or written.
pub(crate) fn run(args: CalibrateArgs) -> Result<ExitCode> {
    let What::Plane(args) = args.what;
    let camera = args.calibration.as_deref().map(read_camera).transpose()?;
    let size = size(&args, camera.as_ref())?;
    let output = args.html.as_deref().or(args.out.as_deref());
    let output = output.map(|file| args.output(file)).transpose()?;
    if let (true, Some(html), Some(image)) = (args.html.is_some(), &output, &args.image) {
        let page = page::of(image, size, args.calibration.as_deref())?;
        html.write(page.as_bytes())?;
        eprintln!("lariat: open {html} in a browser and click the points");
        return Ok(ExitCode::SUCCESS);
    }
    let pairs = match (&args.points, &args.points_file) {
        (Some(text), _) => points::of_flag(text)?,
        (None, Some(path)) => {
            let text = lariat_chain::bounded::read_text(path)
                .with_context(|| format!("cannot read the points {}", path.display()))?;
            points::of_file(&text).with_context(|| path.display().to_string())?
        }
        (None, None) => wrong_use!(
            "name four points or more: --points \"x,y=X,Y x,y=X,Y …\" (pixels=millimetres), --points-file FILE, or --html \
             FILE.html IMAGE to click them"
        ),
    };
    let (plane, mapping) = plane(&pairs, camera.as_ref(), size)?;
    let judged = judged(&pairs, &mapping);
    // The file is written also where nobody reads this.
    let said = match &output {
        Some(output) => output.print(&judged),
        None => print(&judged),
    };
    if let Some(output) = &output {
        let about = format!("From {} points, by `lariat calibrate plane`.", pairs.len());
        let text = plane_file::text(plane.homography(), size, camera.as_ref(), &about);
        output.write(text.as_bytes())?;
        eprintln!("lariat: the plane is in {output}: use it with --plane");
    }
    said?;
    Ok(ExitCode::SUCCESS)
}

/// The images' size: as it is said, else the picture's, else the calibration's.
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
            bail!("--size {text}: the picture has {width}×{height} pixels: leave --size out");
        }
        return Ok(said);
    }
    let known = of_picture.or(camera.and_then(Camera::size));
    known.context("say how large the images are in which the points were read: name the picture, or --size 640x480")
}

/// The plane of the points, with the way of pixels to it.
fn plane(pairs: &[Pair], camera: Option<&Camera>, size: [u32; 2]) -> Result<(Plane, Mapping)> {
    let lens =
        Mapping::new(camera, None, size).context("the calibration does not fit the images")?;
    let ideal = pairs.iter().enumerate().map(|(index, pair)| {
        let place = lens
            .place(pair.pixel)
            .with_context(|| format!("point {}", index + 1))?;
        Ok(Pair {
            pixel: place.point,
            ..*pair
        })
    });
    let ideal = ideal.collect::<Result<Vec<Pair>>>()?;
    let mut plane = Plane::from_pairs(&ideal)?.in_images_of(size);
    if let Some(camera) = camera {
        let ([fx, fy], [cx, cy]) = (camera.focal_px(), camera.center_px());
        plane = plane.undistorted_by([fx, fy, cx, cy]);
    }
    Ok((plane, Mapping::new(camera, Some(&plane), size)?))
}

/// How well the points agree, and how large a pixel is.
fn judged(pairs: &[Pair], mapping: &Mapping) -> String {
    let headings = ["point", "x px", "y px", "X mm", "Y mm", "off mm", "off px"];
    let mut rows = Vec::new();
    let apart = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    let (mut squares, mut most) = (0.0, 0.0f64);
    for (index, Pair { pixel, plane_mm }) in pairs.iter().enumerate() {
        let off_mm = mapping
            .place(*pixel)
            .map_or(f64::NAN, |place| apart(place.point, *plane_mm));
        let off_px = mapping
            .pixel(*plane_mm)
            .map_or(f64::NAN, |seen| apart(seen, *pixel));
        squares += off_mm * off_mm;
        most = most.max(off_mm);
        let ([x, y], [u, v]) = (pixel, plane_mm);
        let places = [x, y, u, v].map(|place| format!("{place:.1}"));
        let off = [off_mm, off_px].map(|off| format!("{off:.2}"));
        rows.push([&[(index + 1).to_string()], &places[..], &off].concat());
    }
    let mut text = Table::text(headings.map(Column::figures).into(), &rows, layout::width());
    text.push_str(&match pairs.len() {
        4 => "four points determine the plane and leave nothing to tell their errors by:\na fifth would\n".to_owned(),
        count => {
            let rms = (squares / count as f64).sqrt();
            format!("off by {rms:.2} mm (root of the mean square), at most {most:.2} mm\n")
        }
    });
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_points_of_a_distorting_lens_lie_where_they_were_measured() {
        let yaml = "image_width: 1280\nimage_height: 960\nK: [1200, 0, 640, 0, 1200, 480, 0, 0, 1]\nD: [-0.3, 0.1, 0, 0]";
        let camera = Camera::from_yaml(yaml).unwrap();
        let pairs = points::of_flag("60,50=0,0 590,45=297,0 600,430=297,210 40,440=0,210").unwrap();
        // In images half as large as the calibration's.
        let (plane, mapping) = plane(&pairs, Some(&camera), [640, 480]).unwrap();
        let text = judged(&pairs, &mapping);
        assert!(text.contains("    0.00    0.00\n"), "{text}");
        assert!(text.contains("mm per pixel: 0."), "{text}");
        // The very points, also at the calibration's own size.
        let large = Mapping::new(Some(&camera), Some(&plane), [1280, 960]).unwrap();
        let corner = large
            .place([60.0, 50.0].map(|c| 2.0 * c + 0.5))
            .unwrap()
            .point;
        assert!(corner[0].hypot(corner[1]) < 1e-6, "{corner:?}");
    }

    #[test]
    fn a_fifth_point_tells_how_far_they_are_off() {
        let pairs =
            points::of_flag("0,0=0,0 100,0=100,0 100,100=100,100 0,100=0,100 50,50=52,50").unwrap();
        let (_, mapping) = plane(&pairs, None, [640, 480]).unwrap();
        let text = judged(&pairs, &mapping);
        assert!(
            text.contains("off by 0.") && text.contains("at most 1."),
            "{text}"
        );
    }
}
