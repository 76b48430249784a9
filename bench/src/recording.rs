//! `lariat-bench recording`: the write speed of recordings, next to `dd` with the same block size
//! on the same disk in the same run. Both count until the data is on disk. Also measures the effect
//! of compression on frames.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use crate::{Samples, Table, rendered};
use anyhow::{Context, Result, ensure};
use lariat_capture::RenderOptions;
use lariat_record::{Compression, Existing, Head, Topic, Writer, encode_image};
use lariat_wire::{FrameHeader, PixelFormat};

/// Folder, amount and rounds of writing.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Folder on the disk to measure (default: the system's folder for temporary files)
    #[arg(long, value_name = "DIR")]
    folder: Option<PathBuf>,
    /// Amount to write per round, in MB
    #[arg(long, value_name = "N", default_value_t = 1000)]
    megabytes: u64,
    /// Number of rounds
    #[arg(long, value_name = "N", default_value_t = 7)]
    rounds: u32,
}

/// Size at which the recorder closes its chunks, and the block size of `dd`.
const BLOCK_BYTES: u64 = 4 << 20;
/// Number of different frames: more than fit in a cache, so that they come from memory like a
/// camera's.
const FRAMES: u64 = 60;

const KINDS: [(&str, Compression); 3] = [
    ("none", Compression::None),
    ("lz4", Compression::Lz4),
    ("zstd", Compression::Zstd),
];

/// Measures and prints the medians.
///
/// # Errors
/// The folder cannot be written to, or `dd` is missing.
pub(crate) fn run(args: &Args) -> Result<()> {
    ensure!(
        args.rounds > 0 && args.megabytes > 0,
        "a measurement needs a round, and something to write"
    );
    let folder = args.folder.clone().unwrap_or_else(std::env::temp_dir);
    let folder = tempfile::tempdir_in(&folder)
        .with_context(|| format!("{} cannot be written to", folder.display()))?;
    let messages = messages()?;
    let blocks = (args.megabytes * 1_000_000).div_ceil(BLOCK_BYTES);
    let mut dd = Samples::default();
    let mut recorded = KINDS.map(|_| Samples::default());
    let mut shares = KINDS.map(|_| Samples::default());
    let mut sizes = KINDS.map(|_| 1.0);
    for _ in 0..args.rounds {
        let of_dd = dd_mb_s(&folder.path().join("dd"), blocks)?;
        dd.push(of_dd);
        for (i, (_, compression)) in KINDS.into_iter().enumerate() {
            let file = folder.path().join("a.mcap");
            let (mb_s, share) = recorded_mb_s(&file, compression, &messages, args.megabytes)?;
            recorded[i].push(mb_s);
            // The ratio is taken within one round, so that drift of the machine affects both.
            shares[i].push(mb_s / of_dd);
            sizes[i] = share;
        }
    }
    let mut table = Table::new(&["640×480 RGB, raw", "MB/s of frames", "of dd's", "size"]);
    table.push([
        format!("dd bs={BLOCK_BYTES} conv=fdatasync"),
        format!("{:.0}", dd.percentile(0.5)),
        "1".into(),
        "1".into(),
    ]);
    for (i, (name, _)) in KINDS.into_iter().enumerate() {
        table.push([
            format!("recording, compression {name}"),
            format!("{:.0}", recorded[i].percentile(0.5)),
            format!("{:.2}", shares[i].percentile(0.5)),
            format!("{:.2}", sizes[i]),
        ]);
    }
    println!("{table}")?;
    println!(
        "medians of {} rounds of {} MB, both until the disk has it",
        args.rounds, args.megabytes
    )?;
    Ok(())
}

/// Returns frames of the rendered rope in the encoding of a recording.
fn messages() -> Result<Vec<Vec<u8>>> {
    let frames = rendered(&RenderOptions {
        frames: Some(FRAMES),
        ..RenderOptions::default()
    })?;
    let mut messages = Vec::new();
    for frame in &frames {
        let picture = &frame.picture;
        let header = FrameHeader {
            width: picture.size()[0] as u32,
            height: picture.size()[1] as u32,
            stride: 3 * picture.size()[0] as u32,
            pixel_format: PixelFormat::Rgb8 as u32,
            ..FrameHeader::default()
        };
        let mut cdr = Vec::new();
        ensure!(
            encode_image(&header, picture.bytes(), 0, "default", &mut cdr),
            "a rendered frame is not an RGB image"
        );
        messages.push(cdr);
    }
    Ok(messages)
}

/// Returns the speed at which `dd` writes this many blocks to a new file.
fn dd_mb_s(file: &Path, blocks: u64) -> Result<f64> {
    let start = Instant::now();
    let status = Command::new("dd")
        .arg("if=/dev/zero")
        .arg(format!("of={}", file.display()))
        .arg(format!("bs={BLOCK_BYTES}"))
        .arg(format!("count={blocks}"))
        .arg("conv=fdatasync")
        .stderr(Stdio::null())
        .status()
        .context("dd cannot be run")?;
    let took_s = start.elapsed().as_secs_f64();
    ensure!(status.success(), "dd failed: is there room on the disk?");
    std::fs::remove_file(file)?;
    Ok((blocks * BLOCK_BYTES) as f64 / 1e6 / took_s)
}

/// Returns the speed of recording this many megabytes of frames, and the ratio of the file's size
/// to the frames' size.
fn recorded_mb_s(
    file: &Path,
    compression: Compression,
    messages: &[Vec<u8>],
    megabytes: u64,
) -> Result<(f64, f64)> {
    let head = Head {
        rig: "default".into(),
        about: Default::default(),
    };
    let start = Instant::now();
    let mut writer = Writer::create(file, Existing::Keep, &head, compression)?;
    let mut bytes = 0;
    for (count, message) in messages.iter().cycle().enumerate() {
        if bytes >= megabytes * 1_000_000 {
            break;
        }
        let log_ns = count as u64 * 16_666_667;
        writer.write(Topic::Image, count as u32, log_ns, message)?;
        bytes += message.len() as u64;
    }
    let written = writer.finish()?;
    let took_s = start.elapsed().as_secs_f64();
    std::fs::remove_file(file)?;
    Ok((
        bytes as f64 / 1e6 / took_s,
        written.bytes as f64 / bytes as f64,
    ))
}
