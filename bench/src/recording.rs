//! `lariat-bench recording`: how fast recordings are written, beside `dd` with the same block size on the same disk in the
//! same run, both until the disk has it; and what compression makes of frames.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use crate::{Samples, Table, rendered};
use anyhow::{Context, Result, ensure};
use lariat_capture::RenderOptions;
use lariat_record::{Compression, Existing, Head, Topic, Writer, encode_image};
use lariat_wire::{FrameHeader, PixelFormat};

/// Where to, how much and how often.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// A folder on the disk that is measured (default: the system's for temporary files)
    #[arg(long, value_name = "DIR")]
    folder: Option<PathBuf>,
    /// How much is written in a round, MB
    #[arg(long, value_name = "N", default_value_t = 1000)]
    megabytes: u64,
    /// How many rounds
    #[arg(long, value_name = "N", default_value_t = 7)]
    rounds: u32,
}

/// What the recorder closes its chunks at, and `dd` is told to write at a time.
const BLOCK_BYTES: u64 = 4 << 20;
/// Different frames: more than any cache holds, so that they come from memory as a camera's do.
const FRAMES: u64 = 60;

const KINDS: [(&str, Compression); 3] = [
    ("none", Compression::None),
    ("lz4", Compression::Lz4),
    ("zstd", Compression::Zstd),
];

/// Measures, and prints the medians.
///
/// # Errors
/// The folder cannot be written to; there is no `dd`.
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
            // Within one round: what drifts on a machine drifts for both.
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

/// Frames of the rendered rope, as they go to a recording.
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

/// How fast `dd` writes so many blocks into a new file.
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

/// How fast so many megabytes of frames are recorded, and which share of their size the file has.
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
