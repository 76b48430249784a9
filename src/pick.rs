//! `lariat pick`: the colors of the ropes in a picture, as a setting to paste and as a picture of
//! the resulting mask.

use anyhow::{Context, Result};
use clap::Args;
use image::GrayImage;
use image::codecs::png::PngEncoder;
use lariat_chain::output::{Existing, Output, print};
use lariat_chain::picture::Picture;
use lariat_chain::settings::{image_positions, mask_text};
use lariat_extract::{Mask, PickJudgement, judge_pick, mask_of, pick};
use std::path::PathBuf;
use std::process::ExitCode;

/// Minimum agreement at which the ranges separate the rope from the rest. Below it, the user is
/// warned.
const GOOD: f32 = 0.7;

/// Pick the colors of a picture's ropes, as a mask for lariat.toml
#[derive(Debug, Args)]
pub(crate) struct PickArgs {
    /// Picture: PNG, JPEG, WebP, TIFF, BMP or PGM
    #[arg(value_name = "IMAGE")]
    image: PathBuf,
    /// Positions on the rope, in pixels from the top left, as in `lariat run --at`: one for each of
    /// its colors, or for its color in light and in shade (default: the ropes that stand out by
    /// themselves)
    #[arg(long, value_name = "X,Y,…", value_parser = positions, allow_hyphen_values = true)]
    at: Vec<Positions>,
    /// File to write the picture of the mask to, white for rope; - for standard output (default:
    /// the picture's name with -mask.png in the current folder)
    #[arg(long, value_name = "FILE.png")]
    out: Option<PathBuf>,
    /// Overwrite an existing file
    #[arg(long)]
    force: bool,
}

/// Positions of one `--at`.
#[derive(Debug, Clone)]
struct Positions(Vec<[f32; 2]>);

fn positions(text: &str) -> Result<Positions, String> {
    image_positions(text).map(Positions)
}

/// Runs `lariat pick`.
///
/// # Errors
/// Returns an error if the picture cannot be read, no rope is found, a position is not on a rope,
/// or the mask's picture cannot be written.
pub(crate) fn run(args: PickArgs) -> Result<ExitCode> {
    let shown = args.image.display();
    let output = match (&args.out, output(&args)) {
        (Some(_), Err(why)) => return Err(why),
        (_, output) => output,
    };
    let picture = Picture::load(&args.image)?;
    let image = picture.image().with_context(|| shown.to_string())?;
    let at: Vec<[f32; 2]> = args.at.iter().flat_map(|at| at.0.clone()).collect();
    let picked = pick(&image, &at).with_context(|| shown.to_string())?;
    let PickJudgement {
        doubt, confidences, ..
    } = judge_pick(&image, &picked.ranges, &at);
    let mask = Mask::Hsv(picked.ranges);
    let pixels = mask_of(&image, &mask);
    let covered = pixels.iter().filter(|&&pixel| pixel != 0).count() as f64;
    let share = 100.0 * covered / pixels.len() as f64;
    let text = format!(
        "# {}: {share:.1} % of it is in this mask.\n[extract]\nmask = {}\n",
        // A comment ends with its line, so control characters are replaced.
        shown.to_string().replace(char::is_control, " "),
        mask_text(&mask)
    );
    // The mask is written even if nobody reads this output. The colors are printed even if the mask
    // cannot be written under its default name.
    let said = match &output {
        Ok(output) => output.print(&text),
        Err(_) => print(&text),
    };
    let mut exit = ExitCode::SUCCESS;
    if let Some(doubt) = doubt {
        eprintln!("lariat: {doubt}");
        exit = ExitCode::FAILURE;
    } else if picked.agreement < GOOD {
        eprintln!(
            "lariat: colour alone tells this rope from the rest in {:.0} % only: look at the mask before you use it; a \
             mask from elsewhere may be needed (mask = \"external\")",
            100.0 * picked.agreement
        );
        exit = ExitCode::FAILURE;
    }
    let [by_color, automatic] = confidences.map(|known| match known {
        Some(confidence) => format!("{confidence:.2}"),
        None => "no rope".to_owned(),
    });
    eprintln!(
        "lariat: confidence of the ropes: {by_color} by this mask, {automatic} by the automatic one"
    );
    let output = output?;
    write(&output, pixels, [picture.width(), picture.height()])?;
    eprintln!("lariat: the mask is drawn in {output}");
    said?;
    Ok(exit)
}

/// Destination of the mask's picture.
fn output(args: &PickArgs) -> Result<Output> {
    let file = args.out.clone().unwrap_or_else(|| {
        let stem = args.image.file_stem().unwrap_or_default().to_string_lossy();
        PathBuf::from(format!("{stem}-mask.png"))
    });
    let output = Output::new(&file, Existing::forced(args.force), [args.image.as_path()])?;
    output.require_ending("png")?;
    Ok(output)
}

fn write(output: &Output, pixels: Vec<u8>, [width, height]: [u32; 2]) -> Result<()> {
    let about = "cannot encode the mask";
    let mask = GrayImage::from_raw(width, height, pixels).context(about)?;
    let mut png = Vec::new();
    mask.write_with_encoder(PngEncoder::new(&mut png))
        .context(about)?;
    output.write(&png)
}
