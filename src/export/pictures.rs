//! Frames as numbered, lossless PNGs: each value in a picture equals that in the frame.

use super::{Part, Written};
use anyhow::{Context, Result, bail};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use lariat_chain::output::of_the_system;
use lariat_chain::pipeline::FrameView;
use lariat_chain::recorded::{Decoder, Pixels};
use lariat_wire::{FrameHeader, PixelFormat};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

pub(super) fn write(part: &Part, folder: &Path) -> Result<Written> {
    if folder.exists() && !folder.is_dir() {
        bail!(
            "{} is not a folder: name one that is new or empty",
            folder.display()
        );
    }
    if !part.args.force && folder.exists() && !is_empty_folder(folder) {
        bail!(
            "{} is there already: name a folder that is new or empty, or overwrite the pictures in it with --force",
            folder.display()
        );
    }
    let about = || format!("cannot write {}", folder.display());
    // Written next to the requested folder and then moved, so that the folder appears complete or
    // not at all.
    let parent = match folder.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let growing = tempfile::Builder::new()
        .prefix(".lariat-export")
        .tempdir_in(parent)
        .map_err(|cause| of_the_system(&cause))
        .with_context(about)?;
    let mut frames = part.frames()?;
    let mut decoder = Decoder::of(part.recording);
    let mut rgb = Vec::new();
    let (mut place, mut count, mut jpegs, mut mosaics) = (0, 0_u64, false, false);
    while let Some(frame) = frames.next_frame()? {
        let wanted = part.is_wanted(place);
        place += 1;
        let (kind, bytes) = Pixels::split(frame.pixels);
        if !wanted || kind == Pixels::None {
            continue;
        }
        let path = name(growing.path(), &frame.header);
        if kind == Pixels::Png {
            std::fs::write(&path, bytes).with_context(about)?;
        } else {
            jpegs |= kind == Pixels::Jpeg;
            let (header, bytes) = decoder.decode(&frame.header, kind, bytes)?;
            mosaics |= header.format().is_some_and(is_mosaic);
            encode(&header, bytes, &path, &mut rgb)?;
        }
        count += 1;
    }
    if count == 0 {
        bail!("there are no images in this part of the recording");
    }
    place_folder(growing, folder).with_context(about)?;
    let notes = [
        (
            jpegs,
            "the frames were recorded as JPEG: the pictures are exactly those, and no longer the camera's",
        ),
        (
            mosaics,
            "the frames are a mosaic of colors: in the pictures each pixel has all three, as extraction fills them in",
        ),
    ];
    let notes = notes.into_iter().filter(|(holds, _)| *holds);
    let notes = notes.map(|(_, note)| note.to_owned());
    Ok(Written {
        what: format!("{count} pictures"),
        notes: notes.chain(decoder.take_news()).collect(),
    })
}

fn is_mosaic(format: PixelFormat) -> bool {
    matches!(
        format,
        PixelFormat::BayerRggb8
            | PixelFormat::BayerBggr8
            | PixelFormat::BayerGrbg8
            | PixelFormat::BayerGbrg8
    )
}

fn is_empty_folder(folder: &Path) -> bool {
    std::fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_none())
}

fn name(folder: &Path, header: &FrameHeader) -> PathBuf {
    folder.join(format!("frame-{:08}.png", header.trace.sequence))
}

/// Moves the finished folder into place. A temporary folder is private to its owner, so it first
/// gets the usual permissions.
fn place_folder(growing: tempfile::TempDir, folder: &Path) -> Result<()> {
    use std::os::unix::fs::PermissionsExt;
    let permissions = std::fs::Permissions::from_mode(0o755);
    std::fs::set_permissions(growing.path(), permissions)?;
    if folder.exists() && !is_empty_folder(folder) {
        for picture in std::fs::read_dir(growing.path())? {
            let picture = picture?;
            std::fs::rename(picture.path(), folder.join(picture.file_name()))?;
        }
        return Ok(());
    }
    // An empty folder of that name is replaced.
    std::fs::rename(growing.path(), folder)?;
    // The temporary folder has moved, so it must not be removed.
    let _ = growing.keep();
    Ok(())
}

fn encode(header: &FrameHeader, bytes: &[u8], path: &Path, rgb: &mut Vec<u8>) -> Result<()> {
    // The path is left out, because the folder still has its temporary name.
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let about = || format!("cannot write {name}");
    let (pixels, color) = match header.format() {
        Some(PixelFormat::Gray8) => (bytes, ExtendedColorType::L8),
        // PNG encoding expects native byte order, which the frame has.
        Some(PixelFormat::Gray16) => (bytes, ExtendedColorType::L16),
        Some(PixelFormat::Rgb8) => (bytes, ExtendedColorType::Rgb8),
        Some(PixelFormat::Bgr8) => {
            rgb.clear();
            rgb.extend_from_slice(bytes);
            rgb.as_chunks_mut::<3>()
                .0
                .iter_mut()
                .for_each(|p| p.swap(0, 2));
            (&rgb[..], ExtendedColorType::Rgb8)
        }
        Some(format) if format == PixelFormat::Bgra8 || is_mosaic(format) => {
            *rgb = FrameView::new(header, bytes).image()?.to_rgb();
            (&rgb[..], ExtendedColorType::Rgb8)
        }
        _ => bail!(
            "the frames are in the camera's own format of brightness and color, which a PNG cannot hold without rounding: \
             --format y4m holds it exactly"
        ),
    };
    let mut file = BufWriter::new(File::create(path).with_context(about)?);
    let encoder =
        PngEncoder::new_with_quality(&mut file, CompressionType::Fast, FilterType::Adaptive);
    encoder
        .write_image(pixels, header.width, header.height, color)
        .with_context(about)?;
    file.flush().with_context(about)
}
