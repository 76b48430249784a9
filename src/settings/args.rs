//! The flags that overrule the file.

use crate::settings::{camera, duration, recording};
use clap::Args;
use std::path::PathBuf;
use std::time::Duration;
use toml::Value;

/// The flags of every command that makes descriptors.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct ShapeArgs {
    /// Order of the curve, or `auto`: it has one control point more
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) order: Option<String>,
    /// Family of the curve: bezier, bspline, rational, fourier, points or mass
    #[arg(long, value_name = "NAME")]
    pub(crate) basis: Option<String>,
    /// Degree of a B-spline's pieces
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) degree: Option<i64>,
    /// Where a B-spline's pieces meet: uniform or averaged
    #[arg(long, value_name = "NAME")]
    pub(crate) knots: Option<String>,
    /// What a bend of the control polygon costs: tames high orders
    #[arg(long, value_name = "NUMBER", allow_negative_numbers = true)]
    pub(crate) ridge: Option<f64>,
    /// Let the curve begin and end exactly at the centerline's ends
    #[arg(long)]
    pub(crate) pin_ends: bool,
    /// Arc length that each point stands for: even or measured
    #[arg(long, value_name = "NAME")]
    pub(crate) rho: Option<String>,
    /// Let points far off the curve weigh less, and hidden ones nothing
    #[arg(long)]
    pub(crate) robust: bool,
    /// How the mask becomes a centerline: skeleton, kmeans, som, gmm or fcm
    #[arg(long, value_name = "NAME")]
    pub(crate) method: Option<String>,
    /// Points of a centerline
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) points: Option<i64>,
    /// How the curve is computed: pinv, cholesky or qr
    #[arg(long, value_name = "NAME")]
    pub(crate) solver: Option<String>,
    /// Lens calibration: a YAML file of OpenCV or ROS
    #[arg(long, value_name = "FILE")]
    pub(crate) calibration: Option<PathBuf>,
    /// Plane that the rope lies on, as `lariat calibrate plane` writes it
    #[arg(long, value_name = "FILE")]
    pub(crate) plane: Option<PathBuf>,
    /// What descriptors come in: px or mm (default: mm where a plane is named)
    #[arg(long, value_name = "UNIT")]
    pub(crate) unit: Option<String>,
    /// Part of the image that is read, in pixels
    #[arg(long, value_name = "X,Y,W,H", allow_hyphen_values = true)]
    pub(crate) roi: Option<String>,
    /// Settings file (default: lariat.toml in this folder, if there is one)
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
}

impl ShapeArgs {
    /// Whether any of them was given.
    pub(crate) fn is_given(&self) -> bool {
        let config = self.config.is_some();
        config || !ChainArgs::from(self.clone()).given().is_empty()
    }
}

impl From<ShapeArgs> for ChainArgs {
    fn from(shape: ShapeArgs) -> Self {
        Self {
            shape,
            ..Self::default()
        }
    }
}

/// The flags of every command that records.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct RecordingArgs {
    /// How frames are recorded: raw, png, jpeg or none
    #[arg(long, value_name = "KIND")]
    pub(crate) images: Option<String>,
    /// Quality of JPEGs, 1 to 100
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) quality: Option<i64>,
    /// How the recording is compressed: none, lz4 or zstd
    #[arg(long, value_name = "NAME")]
    pub(crate) compression: Option<String>,
    /// Memory for what waits for the disk, for instance 128MB
    #[arg(long, value_name = "SIZE", value_parser = recording::size)]
    pub(crate) queue: Option<usize>,
    /// Keep only the last so much in memory, for instance 30s, and write it when told to (SIGUSR1)
    #[arg(long, value_name = "TIME", value_parser = duration::parse)]
    pub(crate) ring: Option<Duration>,
    /// The most memory that --ring may take, for instance 1GB
    #[arg(long, value_name = "SIZE", value_parser = recording::size)]
    pub(crate) ring_memory: Option<usize>,
    /// Overwrite files that are there already
    #[arg(long)]
    pub(crate) force: bool,
}

/// The flags of every command that runs the chain or a part of it.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct ChainArgs {
    /// Where frames come from: `rendered`, `simulated`, a camera (/dev/video0), or pictures, folders of them, or a Y4M video (may be
    /// repeated)
    #[arg(long, value_name = "PATH", num_args = 1..)]
    pub(crate) source: Vec<PathBuf>,
    /// Frames per second, `max` or `auto`
    #[arg(long, value_name = "NUMBER")]
    pub(crate) fps: Option<String>,
    /// Stop after this long, for instance 10s, 500ms or 2m
    #[arg(long, value_name = "TIME", value_parser = duration::parse)]
    pub(crate) duration: Option<Duration>,
    /// Stop after this many frames
    #[arg(long, value_name = "COUNT")]
    pub(crate) frames: Option<u64>,
    #[command(flatten)]
    pub(crate) shape: ShapeArgs,
    /// Name of the camera chain, so that several run side by side
    #[arg(long, value_name = "NAME")]
    pub(crate) rig: Option<String>,
    /// Wait for slow readers instead of skipping frames
    #[arg(long)]
    pub(crate) lossless: bool,
    /// Latency that counts as a miss, for instance 33ms (default: the time between two frames)
    #[arg(long, value_name = "TIME", value_parser = duration::parse)]
    pub(crate) deadline: Option<Duration>,
    /// Write the report into this folder
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Write when each stage worked on the last 1,000 frames into this file, for ui.perfetto.dev; - for standard output
    #[arg(long, value_name = "FILE.json")]
    pub(crate) trace: Option<PathBuf>,
    /// Record what the chain sees and says into this file
    #[arg(long, value_name = "FILE.mcap")]
    pub(crate) record: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) recording: RecordingArgs,
    /// Size of a camera's picture or the rendered one, for instance 640x480
    #[arg(long, value_name = "WxH")]
    pub(crate) size: Option<String>,
    /// Which of all rendered or simulated ropes
    #[arg(long, value_name = "NUMBER")]
    pub(crate) seed: Option<u64>,
    /// Filter the control points in time
    #[arg(long)]
    pub(crate) filter: bool,
    /// Run capture, extract and fit in one process
    #[arg(long)]
    pub(crate) fuse: bool,
    /// For a robot: FIFO scheduling, locked memory and chosen cores, as far as this user may have them
    #[arg(long)]
    pub(crate) realtime: bool,
    /// Core of each stage, for instance 0,0,1,1; or `none`, or `auto`
    #[arg(long, value_name = "CORES")]
    pub(crate) cpus: Option<String>,
    /// Scheduling class of the stages: other or fifo
    #[arg(long, value_name = "CLASS")]
    pub(crate) scheduling: Option<String>,
    /// Priority of capture under FIFO scheduling; each later stage has one more
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) priority: Option<i64>,
    /// Keep the stages' memory from being paged out
    #[arg(long)]
    pub(crate) lock_memory: bool,
    /// How a stage learns of a message: event, or spin
    #[arg(long, value_name = "HOW")]
    pub(crate) wake: Option<String>,
    /// How long a stage looks before it sleeps, with --wake spin, for instance 50us
    #[arg(long, value_name = "TIME", value_parser = duration::parse)]
    pub(crate) spin: Option<Duration>,
    /// Pixel format of a camera, for instance yuyv or mjpg
    #[arg(long, value_name = "CODE")]
    pub(crate) pixel_format: Option<String>,
    /// How frames come from a camera's driver: `userptr` straight into shared memory, `mmap` by one copy, or `auto`
    #[arg(long, value_name = "WAY")]
    pub(crate) io: Option<String>,
    /// Set a camera's control, for instance exposure_auto=1 (may be repeated)
    #[arg(long, value_name = "NAME=VALUE", value_parser = camera::name_and_value)]
    pub(crate) control: Vec<(String, String)>,
    /// Hold a camera's exposure, white balance, gain and focus once its picture has settled
    #[arg(long)]
    pub(crate) lock: bool,
    /// Put a camera's controls back at the end as they were
    #[arg(long)]
    pub(crate) restore: bool,
    /// Begin again after the last file
    #[arg(long = "loop")]
    pub(crate) looped: bool,
    /// Of pictures or a video, begin with this frame: its number, or a time such as 2.5s
    #[arg(long, value_name = "PLACE", allow_negative_numbers = true)]
    pub(crate) from: Option<String>,
    /// And end with this frame, or before this time
    #[arg(long, value_name = "PLACE", allow_negative_numbers = true)]
    pub(crate) to: Option<String>,
    /// Show each how-manieth frame of pictures or a video
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) every: Option<i64>,
    /// Show what is in a folder, and then each picture as it comes
    #[arg(long)]
    pub(crate) follow: bool,
}

impl ChainArgs {
    /// What was given: the flag, the setting's section and name, and the value as the file would have it.
    pub(super) fn given(&self) -> Vec<(&'static str, &'static str, &'static str, Value)> {
        // Larger than TOML's numbers is out of every range anyway.
        let count = |n: u64| Value::Integer(i64::try_from(n).unwrap_or(i64::MAX));
        let path = |p: &PathBuf| Value::String(p.to_string_lossy().into_owned());
        let yes = |given: bool| given.then_some(Value::Boolean(true));
        let text = |text: &Option<String>| text.clone().map(Value::String);
        let fps = self.fps.as_ref().map(|text| number_or_text(text));
        let whole = |text: &String| match text.parse() {
            Ok(number) => Value::Integer(number),
            Err(_) => Value::String(text.clone()),
        };
        let order = self.shape.order.as_ref().map(whole);
        let (from, to) = (self.from.as_ref().map(whole), self.to.as_ref().map(whole));
        let source =
            (!self.source.is_empty()).then(|| Value::Array(self.source.iter().map(path).collect()));
        let duration_s = self.duration.map(|d| Value::Float(d.as_secs_f64()));
        let deadline_us = self.deadline.map(|d| Value::Float(1e6 * d.as_secs_f64()));
        let spin_us = self.spin.map(|d| Value::Float(1e6 * d.as_secs_f64()));
        let priority = self.priority.map(Value::Integer);
        let megabytes = |bytes: Option<usize>| bytes.map(recording::megabytes_value);
        let recording = &self.recording;
        let ring_s = recording.ring.map(|d| Value::Float(d.as_secs_f64()));
        [
            ("--source", "capture", "source", source),
            ("--fps", "capture", "fps", fps),
            ("--size", "capture", "size", text(&self.size)),
            ("--seed", "capture", "seed", self.seed.map(count)),
            ("--loop", "capture", "loop", yes(self.looped)),
            ("--from", "capture", "from", from),
            ("--to", "capture", "to", to),
            (
                "--every",
                "capture",
                "every",
                self.every.map(Value::Integer),
            ),
            ("--follow", "capture", "follow", yes(self.follow)),
            (
                "--pixel-format",
                "capture",
                "pixel_format",
                text(&self.pixel_format),
            ),
            ("--io", "capture", "io", text(&self.io)),
            (
                "--control",
                "capture",
                "controls",
                camera::controls_of_flags(&self.control),
            ),
            ("--lock", "capture", "lock", yes(self.lock)),
            ("--restore", "capture", "restore", yes(self.restore)),
            ("--duration", "run", "duration_s", duration_s),
            ("--frames", "run", "frames", self.frames.map(count)),
            ("--rig", "run", "rig", text(&self.rig)),
            ("--lossless", "run", "lossless", yes(self.lossless)),
            ("--deadline", "run", "deadline_us", deadline_us),
            ("--out", "run", "out", self.out.as_ref().map(path)),
            ("--trace", "run", "trace", self.trace.as_ref().map(path)),
            ("--record", "run", "record", self.record.as_ref().map(path)),
            ("--fuse", "run", "fuse", yes(self.fuse)),
            ("--realtime", "run", "realtime", yes(self.realtime)),
            ("--cpus", "run", "cpus", text(&self.cpus)),
            ("--scheduling", "run", "scheduling", text(&self.scheduling)),
            ("--priority", "run", "priority", priority),
            ("--lock-memory", "run", "lock_memory", yes(self.lock_memory)),
            ("--wake", "run", "wake", text(&self.wake)),
            ("--spin", "run", "spin_us", spin_us),
            ("--method", "extract", "method", text(&self.shape.method)),
            (
                "--points",
                "extract",
                "points",
                self.shape.points.map(Value::Integer),
            ),
            ("--roi", "extract", "roi", text(&self.shape.roi)),
            (
                "--calibration",
                "camera",
                "calibration",
                self.shape.calibration.as_ref().map(path),
            ),
            (
                "--plane",
                "camera",
                "plane",
                self.shape.plane.as_ref().map(path),
            ),
            ("--unit", "camera", "unit", text(&self.shape.unit)),
            ("--order", "fit", "order", order),
            ("--basis", "fit", "basis", text(&self.shape.basis)),
            (
                "--degree",
                "fit",
                "degree",
                self.shape.degree.map(Value::Integer),
            ),
            ("--knots", "fit", "knots", text(&self.shape.knots)),
            (
                "--ridge",
                "fit",
                "ridge",
                self.shape.ridge.map(Value::Float),
            ),
            ("--pin-ends", "fit", "pin_ends", yes(self.shape.pin_ends)),
            ("--rho", "fit", "rho", text(&self.shape.rho)),
            ("--robust", "fit", "robust", yes(self.shape.robust)),
            ("--filter", "fit", "filter", yes(self.filter)),
            ("--solver", "fit", "solver", text(&self.shape.solver)),
            ("--images", "record", "images", text(&recording.images)),
            (
                "--quality",
                "record",
                "quality",
                recording.quality.map(Value::Integer),
            ),
            (
                "--compression",
                "record",
                "compression",
                text(&recording.compression),
            ),
            ("--queue", "record", "queue_mb", megabytes(recording.queue)),
            ("--ring", "record", "ring_s", ring_s),
            (
                "--ring-memory",
                "record",
                "ring_mb",
                megabytes(recording.ring_memory),
            ),
            ("--force", "record", "replace", yes(recording.force)),
        ]
        .into_iter()
        .filter_map(|(flag, section, name, value)| Some((flag, section, name, value?)))
        .collect()
    }
}

fn number_or_text(text: &str) -> Value {
    text.parse()
        .map_or_else(|_| Value::String(text.to_owned()), Value::Float)
}
