//! Encoding of a film as a Y4M video: Y, U and V of each frame, with color shared by four pixels.

use std::io::{BufWriter, Write};
use std::path::Path;

use crate::{Picture, converted};
use anyhow::{Context, Result};
use lariat_chain::output::{Existing, Output};
use lariat_drawn::moving::Film;
use lariat_extract::PixelFormat;

/// Writes this many frames of a film. Its sides must be even.
pub(super) fn write(mut film: Film, size: [usize; 2], frames: u64, path: &Path) -> Result<()> {
    let [width, height] = size;
    let about = || format!("cannot write {}", path.display());
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).with_context(about)?;
    }
    let mut video = Output::new(path, Existing::Replace, [])?.begin()?;
    let mut to = BufWriter::new(&mut video);
    writeln!(
        to,
        "YUV4MPEG2 W{width} H{height} F30:1 Ip A1:1 C420jpeg XCOLORRANGE=FULL"
    )
    .with_context(about)?;
    let mut rgb = Vec::new();
    for _ in 0..frames {
        film.next(&mut rgb);
        let frame = Picture::rgb(size, &rgb)
            .and_then(|picture| converted(&picture, PixelFormat::Nv12))
            .context("a side is odd: give even ones, as colour is shared by 2×2 pixels")?;
        let (luma, pairs) = frame.bytes().split_at(width * height);
        to.write_all(b"FRAME\n").with_context(about)?;
        to.write_all(luma).with_context(about)?;
        for channel in 0..2 {
            let plane: Vec<u8> = pairs.iter().copied().skip(channel).step_by(2).collect();
            to.write_all(&plane).with_context(about)?;
        }
    }
    to.flush().with_context(about)?;
    drop(to);
    video.place()
}
