//! Recordings made here frame by frame, as a chain would make them from a rendered rope, but
//! without a chain.

mod checks;
mod comparisons;
mod golden;

use super::stages::{Prepared, Stages};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use lariat_capture::{RenderOptions, Source, open};
use lariat_chain::recorded::SETTINGS;
use lariat_chain::settings::Settings;
use lariat_record::{
    Compression, Existing, Head, Record, Recording, Topic, Writer, encode_compressed_image,
    encode_image,
};
use lariat_sink::Machine;
use lariat_wire::{Centerlines, Descriptors, FrameHeader, SourceKind, Trace};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// Offset added to the times in a trace.
const OFFSET_NS: u64 = 1_700_000_000_000_000_000;
/// Exposure time of the first frame.
const BEGIN_NS: u64 = 5_000_000_000;

/// Messages of one frame, before they are written.
struct Shot<'a> {
    /// Frame number, from 1.
    number: u64,
    header: FrameHeader,
    bytes: &'a [u8],
    mask: Option<Vec<u8>>,
    truth: Option<Box<Centerlines>>,
    centerlines: Option<Box<Centerlines>>,
    descriptors: Option<Box<Descriptors>>,
    has_frame: bool,
}

type MaskMaker = fn(&[u8]) -> Vec<u8>;

/// Content and format of a test recording.
struct Making<'a> {
    settings: &'a str,
    render: RenderOptions,
    compression: Compression,
    /// `png`, `jpeg`, or raw.
    images: &'a str,
    cpu: Option<&'a str>,
    /// Selects the frames that extract processes, by number.
    seen: fn(u64) -> bool,
    /// Selects which of those frames fit receives.
    sent: fn(u64) -> bool,
    /// Makes a mask of a frame's bytes.
    mask: Option<MaskMaker>,
    /// Number of the frame before which extract and fit are restarted.
    again: Option<u64>,
    /// Changes a frame's messages on their way into the recording.
    change: &'a dyn Fn(&mut Shot),
}

impl Default for Making<'_> {
    fn default() -> Self {
        Self {
            settings: "",
            render: RenderOptions {
                width: 160,
                height: 120,
                rope_px: 5.0,
                frame_interval_s: 0.15,
                frames: Some(12),
                ..RenderOptions::default()
            },
            compression: Compression::Lz4,
            images: "raw",
            cpu: None,
            seen: |_| true,
            sent: |_| true,
            mask: None,
            again: None,
            change: &|_| {},
        }
    }
}

/// A recording in a folder of its own.
struct Made {
    _folder: TempDir,
    path: PathBuf,
}

impl Made {
    fn open(&self) -> Recording {
        Recording::open(&self.path).unwrap()
    }
}

impl Making<'_> {
    fn make(&self) -> Made {
        let folder = TempDir::new().unwrap();
        let path = folder.path().join("made.mcap");
        self.make_at(&path);
        Made {
            _folder: folder,
            path,
        }
    }

    fn make_at(&self, path: &Path) {
        let settings_file = TempDir::new().unwrap();
        let settings_file = settings_file.path().join(SETTINGS);
        std::fs::write(&settings_file, self.settings).unwrap();
        let settings = Settings::of_file(&settings_file).unwrap();
        let mut stages = Stages::new(&settings).unwrap();
        let mut writer = self.begin(path);
        let mut source = open(&Source::Rendered(self.render)).unwrap();
        let mut bytes = vec![0; source.largest_frame_bytes()];
        let (mut extracted, mut fitted) = (0, 0);
        while let Some(frame) = source.next().unwrap() {
            source.write(&mut bytes);
            let number = frame.sequence;
            let period_ns = (1e9 * self.render.frame_interval_s) as u64;
            let exposed_ns = BEGIN_NS + number * period_ns;
            let trace = Trace {
                sequence: number,
                captured: number,
                exposed_ns,
                captured_ns: exposed_ns + 100_000,
                ..Trace::EMPTY
            };
            let header = FrameHeader {
                trace,
                width: frame.width,
                height: frame.height,
                stride: frame.stride,
                pixel_format: frame.format as u32,
                source: SourceKind::Rendered as u32,
                ..FrameHeader::default()
            };
            if self.again == Some(number) {
                stages.restart_extract(&settings).unwrap();
                stages.restart_fit(&settings).unwrap();
                (extracted, fitted) = (0, 0);
            }
            let mask = self.mask.map(|mask| mask(&bytes));
            let mut shot = Shot {
                number,
                header,
                bytes: &bytes,
                truth: Some(Box::new(Centerlines::EMPTY)),
                centerlines: None,
                descriptors: None,
                has_frame: true,
                mask,
            };
            let truth = shot.truth.as_mut().unwrap();
            source.truth(truth);
            truth.trace = trace;
            if (self.seen)(number) {
                extracted += 1;
                let trace = Trace {
                    extracted,
                    extract_started_ns: trace.captured_ns + 50_000,
                    extracted_ns: trace.captured_ns + 900_000,
                    ..trace
                };
                let of_mask = header.of_mask();
                let mask = shot.mask.as_deref().map(|mask| (of_mask, mask));
                let prepared = Prepared::new(header, &bytes, mask);
                stages.extract(&prepared, trace);
                shot.centerlines = Some(stages.centerlines.clone());
                if (self.sent)(number) {
                    fitted += 1;
                    stages.fit_seen(Trace {
                        fitted,
                        fit_started_ns: trace.extracted_ns + 50_000,
                        fitted_ns: trace.extracted_ns + 80_000,
                        ..trace
                    });
                    shot.descriptors = Some(stages.descriptors.clone());
                }
            }
            (self.change)(&mut shot);
            self.write(&mut writer, &shot);
        }
        writer.finish().unwrap();
    }

    fn begin(&self, path: &Path) -> Writer {
        let cpu = Machine::this().cpu.unwrap_or_default();
        let about = [
            ("version", env!("CARGO_PKG_VERSION").to_owned()),
            ("rig", "default".to_owned()),
            ("arch", std::env::consts::ARCH.to_owned()),
            ("cpu", self.cpu.map_or(cpu, str::to_owned)),
            ("monotonic_to_wall_ns", OFFSET_NS.to_string()),
        ];
        let about: BTreeMap<_, _> = about.map(|(key, value)| (key.to_owned(), value)).into();
        let head = Head {
            rig: "default".to_owned(),
            about,
        };
        let existing = Existing::Replace;
        let mut writer = Writer::create(path, existing, &head, self.compression).unwrap();
        let settings = self.settings.as_bytes();
        writer
            .attach(SETTINGS, "application/toml", OFFSET_NS, settings)
            .unwrap();
        writer
    }

    fn write(&self, writer: &mut Writer, shot: &Shot) {
        let mut cdr = Vec::new();
        let sequence = shot.number as u32;
        let captured = OFFSET_NS + shot.header.trace.captured_ns;
        let mut write = |topic, at, cdr: &[u8]| writer.write(topic, sequence, at, cdr).unwrap();
        if shot.has_frame {
            shot.header.encode(&mut cdr);
            write(Topic::Frames, captured, &cdr);
            let (header, bytes) = (&shot.header, shot.bytes);
            if self.images == "raw" {
                assert!(encode_image(header, bytes, captured, "default", &mut cdr));
                write(Topic::Image, captured, &cdr);
            } else {
                let file = picture(header, bytes, self.images);
                encode_compressed_image(&file, self.images, captured, "default", &mut cdr);
                write(Topic::Picture, captured, &cdr);
            }
        }
        if let Some(mask) = &shot.mask {
            let header = shot.header.of_mask();
            header.encode(&mut cdr);
            write(Topic::Masks, captured, &cdr);
            assert!(encode_image(&header, mask, captured, "default", &mut cdr));
            write(Topic::MaskImage, captured, &cdr);
        }
        if let Some(truth) = &shot.truth {
            truth.encode(&mut cdr);
            write(Topic::Truth, captured, &cdr);
        }
        if let Some(centerlines) = &shot.centerlines {
            centerlines.encode(&mut cdr);
            let at = OFFSET_NS + centerlines.trace.extracted_ns;
            write(Topic::Centerlines, at, &cdr);
        }
        if let Some(descriptors) = &shot.descriptors {
            descriptors.encode(&mut cdr);
            let at = OFFSET_NS + descriptors.trace.fitted_ns;
            write(Topic::Descriptors, at, &cdr);
        }
    }
}

fn picture(header: &FrameHeader, bytes: &[u8], format: &str) -> Vec<u8> {
    let mut file = Vec::new();
    let (width, height) = (header.width, header.height);
    let rgb = ExtendedColorType::Rgb8;
    match format {
        "png" => {
            PngEncoder::new_with_quality(&mut file, CompressionType::Best, FilterType::Adaptive)
                .write_image(bytes, width, height, rgb)
        }
        _ => image::codecs::jpeg::JpegEncoder::new_with_quality(&mut file, 95)
            .write_image(bytes, width, height, rgb),
    }
    .unwrap();
    file
}
