//! A process that makes masks for lariat, as a neural network would: it reads frames and writes
//! masks.
//!
//! With `mask = "external"` under `[extract]` in lariat.toml:
//!
//! ```sh
//! cargo run --release --example mask_network &
//! lariat run
//! ```
//!
//! Replace `rope_probability` with your network. It gets the newest frame, and skips the frames
//! that come while it works. If a mask does not arrive in time, extract counts its frame as
//! skipped. Flags: `--rig NAME`, and `--lossless` if the chain is lossless.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use lariat_wire::{
    Domain, FrameHeader, FrameReader, MaskWriter, PixelFormat, Rig, Waiting, WriteError,
};

#[allow(dead_code, reason = "a test runs `serve` alone")]
fn main() -> anyhow::Result<()> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        signal_hook::flag::register(signal, stop.clone())?;
    }
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let rig = arguments.windows(2).find(|pair| pair[0] == "--rig");
    let rig = rig.map_or(Ok(Rig::default()), |pair| pair[1].parse())?;
    let lossless = arguments.iter().any(|argument| argument == "--lossless");
    serve([Domain::open()?, Domain::open()?], &rig, lossless, &stop)?;
    Ok(())
}

/// Answers frames with masks until it is stopped.
///
/// # Errors
/// Returns errors of the transport.
pub(crate) fn serve(
    [for_frames, for_masks]: [Domain; 2],
    rig: &Rig,
    lossless: bool,
    stop: &Arc<AtomicBool>,
) -> Result<(), WriteError> {
    let waiting = Waiting {
        lossless: Some(lossless),
        stop: stop.clone(),
        meanwhile: None,
    };
    let mut frames = FrameReader::open_in(for_frames, rig, Some(lossless))?;
    let mut masks = MaskWriter::open_in(for_masks, rig, waiting)?;
    while !stop.load(Ordering::Relaxed) {
        let look_up = Instant::now() + Duration::from_millis(50);
        let Some(frame) = frames.wait(Some(look_up))? else {
            continue;
        };
        if frame.header().is_blank() {
            // The camera has no image at the moment.
            continue;
        }
        let mask = masks.loan(frame.header())?;
        rope_probability(frame.header(), frame, mask);
        masks.send()?;
    }
    Ok(())
}

/// Probability that each pixel is rope, 0 to 255. Here: the excess of blue over red. Frames that
/// are not RGB have no rope.
fn rope_probability(header: &FrameHeader, frame: &[u8], mask: &mut [u8]) {
    if header.format() != Some(PixelFormat::Rgb8) {
        mask.fill(0);
        return;
    }
    let rows = frame.chunks_exact(header.stride as usize);
    for (row, mask) in rows.zip(mask.chunks_exact_mut(header.width as usize)) {
        for (pixel, likely) in row.chunks_exact(3).zip(mask) {
            *likely = pixel[2].saturating_sub(pixel[0]).saturating_mul(3);
        }
    }
}
