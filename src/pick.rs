//! `lariat pick`: the colours of the ropes in a picture, as the setting to paste and as a picture of the mask they make.

use crate::picture::Picture;
use crate::settings::mask_text;
use crate::whole_file::{self, Existing};
use anyhow::{Context, Result, bail};
use clap::Args;
use image::{GrayImage, ImageFormat};
use lariat_extract::{Mask, mask_of, pick};
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Below this agreement the ranges do not tell the rope from the rest, and the user is told.
const GOOD: f32 = 0.8;

/// The colours of the ropes in a picture, as a mask for lariat.toml
#[derive(Debug, Args)]
pub(crate) struct PickArgs {
    /// PNG or JPEG picture
    #[arg(value_name = "IMAGE")]
    image: PathBuf,
    /// A point on the rope, in pixels from the top left (default: the ropes that stand out by themselves)
    #[arg(long, value_name = "X,Y", value_parser = point, allow_hyphen_values = true)]
    at: Option<[f32; 2]>,
    /// Where to write the picture of the mask, white for rope (default: the picture's name with -mask.png in this
    /// folder, if there is none yet)
    #[arg(long, value_name = "FILE.png")]
    out: Option<PathBuf>,
}

fn point(text: &str) -> Result<[f32; 2], String> {
    let numbers: Vec<Option<f32>> = text.split(',').map(|c| c.trim().parse().ok()).collect();
    match numbers[..] {
        [Some(x), Some(y)] if x.is_finite() && y.is_finite() => Ok([x, y]),
        _ => Err("a point is two numbers of pixels, such as 320,240".to_owned()),
    }
}

/// Runs `lariat pick`.
///
/// # Errors
/// The picture cannot be read, no rope is found, the point is on none, or the mask's picture cannot be written.
pub(crate) fn run(args: PickArgs) -> Result<ExitCode> {
    let shown = args.image.display();
    let picture = Picture::load(&args.image)?;
    let image = picture.image().with_context(|| shown.to_string())?;
    let picked = pick(&image, args.at).with_context(|| shown.to_string())?;
    let mask = Mask::Hsv(picked.ranges);
    let pixels = mask_of(&image, &mask);
    let covered = pixels.iter().filter(|&&pixel| pixel != 0).count() as f64;
    let share = 100.0 * covered / pixels.len() as f64;
    let text = format!(
        "# {}: {share:.1} % of it is in this mask.\n[extract]\nmask = {}\n",
        // A comment ends where its line does.
        shown.to_string().replace(char::is_control, " "),
        mask_text(&mask)
    );
    std::io::stdout().write_all(text.as_bytes())?;
    if picked.agreement < GOOD {
        eprintln!(
            "lariat: colour alone tells this rope from the rest in {:.0} % only: look at the mask before you use it; a \
             mask from elsewhere may be needed (mask = \"external\")",
            100.0 * picked.agreement
        );
    }
    let (file, existing) = file(&args)?;
    write(&file, existing, pixels, [picture.width(), picture.height()])?;
    eprintln!("lariat: the mask is drawn in {}", file.display());
    Ok(ExitCode::SUCCESS)
}

/// Where the mask's picture goes. A name that the user gave may replace a file, but not the picture itself.
fn file(args: &PickArgs) -> Result<(PathBuf, Existing)> {
    let Some(file) = &args.out else {
        let stem = args.image.file_stem().unwrap_or_default().to_string_lossy();
        let file = PathBuf::from(format!("{stem}-mask.png"));
        if file.exists() {
            bail!(
                "the mask is not drawn, as there is a file {} already: name one to write with --out",
                file.display()
            );
        }
        return Ok((file, Existing::Keep));
    };
    let is_png = |path: &Path| {
        path.extension()
            .is_some_and(|extension| extension.eq_ignore_ascii_case("png"))
    };
    if !is_png(file) {
        bail!(
            "the mask is drawn as a PNG: give --out a name that ends in .png, not {}",
            file.display()
        );
    }
    if let (Ok(out), Ok(image)) = (file.canonicalize(), args.image.canonicalize())
        && out == image
    {
        bail!(
            "the mask would replace the picture {}: give --out another name",
            file.display()
        );
    }
    Ok((file.clone(), Existing::Replace))
}

fn write(
    file: &Path,
    existing: Existing,
    pixels: Vec<u8>,
    [width, height]: [u32; 2],
) -> Result<()> {
    let about = || format!("cannot encode {}", file.display());
    let mask = GrayImage::from_raw(width, height, pixels).with_context(about)?;
    let mut png = Vec::new();
    mask.write_to(&mut Cursor::new(&mut png), ImageFormat::Png)
        .with_context(about)?;
    whole_file::write(file, &png, existing)
}
