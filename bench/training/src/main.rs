//! Draws pictures of ropes on all kinds of backgrounds, with their masks, for training the network
//! that segments ropes.
//!
//! A seed determines a picture: the same seed and the same photographs give the same picture on
//! every machine. The pictures differ on purpose from those that extraction is measured with
//! (`lariat-drawn`), so that the test pictures are never trained on.

mod camera;
mod canvas;
mod ground;
mod path;
mod photographs;
mod rope;
mod scene;
mod stroke;
mod thing;
mod tool;

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Parser;
use image::ExtendedColorType;

use photographs::Photographs;

/// Draw training pictures into a NumPy file: count × side × side × 5 bytes (red, green, blue, rope,
/// seam); or into a folder of pictures with labels.
#[derive(Parser)]
#[command(group = clap::ArgGroup::new("what").required(true).args(["out", "labelled"]))]
struct Args {
    /// File to write.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Folder to write `images` and `labels` to: PNGs named by their seeds. Each label pixel holds
    /// the number of its rope.
    #[arg(long)]
    labelled: Option<PathBuf>,
    /// Seed of the first picture; each following picture has the next seed.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Number of pictures.
    #[arg(long, default_value_t = 1000)]
    count: u64,
    /// Side of the pictures in pixels.
    #[arg(long, default_value_t = 256)]
    side: usize,
    /// Folder of photographs without ropes to draw on, in addition to drawn backgrounds.
    #[arg(long)]
    photographs: Option<PathBuf>,
}

fn main() -> anyhow::Result<()> {
    let args = Args::parse();
    let photographs = Photographs::of(args.photographs.as_deref())?;
    if let Some(out) = &args.out {
        write_file(out, &args, &photographs)?;
    }
    if let Some(folder) = &args.labelled {
        write_labelled(folder, &args, &photographs)?;
    }
    Ok(())
}

impl Args {
    fn seeds(&self) -> std::ops::Range<u64> {
        self.seed..self.seed + self.count
    }
}

fn write_file(out: &Path, args: &Args, photographs: &Photographs) -> anyhow::Result<()> {
    let shape = [args.count as usize, args.side, args.side, scene::CHANNELS];
    let unfinished = out.with_extension("part");
    let file = File::create(&unfinished)
        .with_context(|| format!("cannot write {}", unfinished.display()))?;
    let mut file = BufWriter::new(file);
    file.write_all(&header(shape))?;
    for seed in args.seeds() {
        file.write_all(&scene::draw(seed, args.side, photographs)?.interleaved())?;
    }
    file.into_inner()?.sync_all()?;
    std::fs::rename(&unfinished, out).with_context(|| format!("cannot write {}", out.display()))
}

fn write_labelled(folder: &Path, args: &Args, photographs: &Photographs) -> anyhow::Result<()> {
    let [images, labels] = ["images", "labels"].map(|name| folder.join(name));
    for folder in [&images, &labels] {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("cannot make the folder {}", folder.display()))?;
    }
    let side = args.side as u32;
    for seed in args.seeds() {
        let drawn = scene::draw(seed, args.side, photographs)?;
        let name = format!("{seed:06}.png");
        for (folder, bytes, color) in [
            (&images, &drawn.rgb, ExtendedColorType::Rgb8),
            (&labels, &drawn.labels, ExtendedColorType::L8),
        ] {
            let path = folder.join(&name);
            image::save_buffer(&path, bytes, side, side, color)
                .with_context(|| format!("cannot write {}", path.display()))?;
        }
    }
    Ok(())
}

/// Returns the header of NumPy's format, version 1: magic, length, a dictionary padded to 64 bytes.
fn header(shape: [usize; 4]) -> Vec<u8> {
    let shape = shape.map(|count| count.to_string()).join(", ");
    let mut words = format!("{{'descr': '|u1', 'fortran_order': False, 'shape': ({shape}), }}");
    while (10 + words.len() + 1) % 64 != 0 {
        words.push(' ');
    }
    words.push('\n');
    let mut head = b"\x93NUMPY\x01\x00".to_vec();
    head.extend((words.len() as u16).to_le_bytes());
    head.extend(words.as_bytes());
    head
}
