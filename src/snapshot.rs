//! `lariat snapshot`: saves one frame of any source as a picture, read in the same way as in a
//! chain.
//!
//! Colors are those that the mask uses, so that the result of `lariat pick` on the picture also
//! holds in the chain.

use std::os::fd::AsFd;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::{Context, Result, bail};
use clap::Args;
use image::codecs::png::PngEncoder;
use image::{GrayImage, RgbImage};
use lariat_capture::{Frame, FrameSource, Next, Until};
use lariat_extract::{Image, PixelFormat};
use lariat_wire::now_ns;

use lariat_chain::output::{Existing, Output};
use lariat_chain::pipeline::pixel_format;
use lariat_chain::settings::{Flags, Settings, USUAL_FPS, duration};
use lariat_chain::stop::Stop;

/// Typical time for a camera's exposure and white balance to settle: about 30 frames.
const SETTLING: Duration = Duration::from_secs(1);

/// Longest wait for a frame: many times the period of the slowest camera.
const PATIENCE_NS: u64 = 10_000_000_000;

/// Save one frame of a camera or another source as PNG
#[derive(Debug, Args)]
pub(crate) struct SnapshotArgs {
    /// File to write; - for standard output
    #[arg(value_name = "FILE.png")]
    file: PathBuf,
    /// Time to wait before the picture is taken (default: 1s for a camera, so that its exposure settles; 0s for others)
    #[arg(long, value_name = "TIME", value_parser = duration::parse)]
    after: Option<Duration>,
    /// Overwrite an existing file
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    flags: Flags,
}

/// Runs `lariat snapshot`.
///
/// # Errors
/// Returns an error if the source cannot be opened or gives no frame, or if the picture cannot be
/// written. No partial picture is left behind.
pub(crate) fn run(args: SnapshotArgs) -> Result<ExitCode> {
    let (file, existing) = (args.file.clone(), Existing::forced(args.force));
    let after = args.after;
    let settings = Settings::resolve(&args.flags)?;
    let after = after.unwrap_or(match settings.capture.is_camera() {
        true => SETTLING,
        false => Duration::ZERO,
    });
    let output = Output::new(&file, existing, settings.inputs())?;
    output.require_ending("png")?;
    let stop = Stop::on_signals()?;
    let mut source = lariat_capture::open(&settings.source())?;
    let Some(frame) = frame_after(after, source.as_mut(), &stop)? else {
        bail!("no picture was taken: it was stopped before there was one");
    };
    let mut bytes = vec![0; frame.bytes()];
    source.write(&mut bytes);
    // Frees the camera before the file is written.
    drop(source);
    let picture = png(&frame, &bytes)?;
    output.write(&picture)?;
    let (width, height) = (frame.width, frame.height);
    eprintln!("lariat: wrote {output}, {width}x{height}");
    Ok(ExitCode::SUCCESS)
}

/// Returns the first frame that comes at least `after` later than the first of all; `None` if a
/// signal came.
fn frame_after(
    after: Duration,
    source: &mut dyn FrameSource,
    stop: &Stop,
) -> Result<Option<Frame>> {
    let after_ns = u64::try_from(after.as_nanos()).unwrap_or(u64::MAX);
    let period_ns = 1e9 / source.native_fps().unwrap_or(USUAL_FPS);
    let mut count = 0_u64;
    let mut first_ns = None;
    let mut patience_ends_ns = now_ns().saturating_add(PATIENCE_NS);
    while !stop.asked() {
        let next = source.advance(&Until::new(Some(patience_ends_ns), stop.as_fd()))?;
        while let Some(warning) = source.take_warning() {
            tracing::warn!("{warning}");
        }
        match next {
            // A frame without an image means that the camera is silent.
            Next::Frame(frame) if frame.width > 0 => {
                // Frames without an exposure time come as fast as possible, so their frame rate
                // gives the time.
                let live_ns = frame.exposed_ns.map(|_| now_ns());
                let at_ns = live_ns.unwrap_or((count as f64 * period_ns) as u64);
                if at_ns.saturating_sub(*first_ns.get_or_insert(at_ns)) >= after_ns {
                    return Ok(Some(frame));
                }
                count += 1;
                patience_ends_ns = now_ns().saturating_add(PATIENCE_NS);
            }
            Next::End if count > 0 => bail!(
                "the source ended after {count} frames, before {} s were over: say --after less",
                after.as_secs_f64()
            ),
            Next::End => bail!("the source has no frame"),
            Next::Frame(_) | Next::Nothing if now_ns() >= patience_ends_ns => bail!(
                "the source has given no frame for {} s",
                PATIENCE_NS / 1_000_000_000
            ),
            Next::Frame(_) | Next::Nothing => {}
        }
    }
    Ok(None)
}

/// Encodes a frame as PNG: grayscale for a gray frame, otherwise in color.
fn png(frame: &Frame, bytes: &[u8]) -> Result<Vec<u8>> {
    let (width, height, stride) = (frame.width, frame.height, frame.stride);
    let format = pixel_format(frame.format);
    let seen = Image::new(
        bytes,
        width as usize,
        height as usize,
        stride as usize,
        format,
    )?;
    let about = || "cannot encode the picture";
    let mut png = Vec::new();
    if matches!(format, PixelFormat::Gray8 | PixelFormat::Gray16) {
        let pixels = seen.to_rgb().into_iter().step_by(3).collect();
        let picture = GrayImage::from_raw(width, height, pixels).with_context(about)?;
        picture
            .write_with_encoder(PngEncoder::new(&mut png))
            .with_context(about)?;
    } else {
        let picture = RgbImage::from_raw(width, height, seen.to_rgb()).with_context(about)?;
        picture
            .write_with_encoder(PngEncoder::new(&mut png))
            .with_context(about)?;
    }
    Ok(png)
}
