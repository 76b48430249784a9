//! Rivals in Python. Each script receives frames in a file and prints the latency of each.

use std::fs::File;
use std::io::{Read, Write};
use std::process::Stdio;
use std::time::Duration;

use crate::opencv_bounds;
use anyhow::{Context, Result, bail};
use lariat_capture::{RenderOptions, Source};
use lariat_extract::{Image, PixelFormat, pick};
use lariat_sink::Times;
use serde::{Deserialize, Serialize};

use crate::latency::figures::Outcome;
use crate::latency::guard::{Guarded, Placement};
use crate::latency::workplace::Workplace;

/// The scripts of `bench/rivals`. They are embedded, so the program needs no source tree.
const FILES: [(&str, &str); 9] = [
    ("timing.py", include_str!("../../../rivals/timing.py")),
    ("pacing.py", include_str!("../../../rivals/pacing.py")),
    ("threshold.py", include_str!("../../../rivals/threshold.py")),
    (
        "components.py",
        include_str!("../../../rivals/components.py"),
    ),
    ("distance.py", include_str!("../../../rivals/distance.py")),
    ("chain.py", include_str!("../../../rivals/chain.py")),
    (
        "latency_zmq.py",
        include_str!("../../../rivals/latency_zmq.py"),
    ),
    (
        "latency_zenoh.py",
        include_str!("../../../rivals/latency_zenoh.py"),
    ),
    (
        "latency_chain.py",
        include_str!("../../../rivals/latency_chain.py"),
    ),
];

/// Number of frames that are sent in turn: enough that none is still in a cache from its last use.
const FRAMES: u64 = 24;

/// A script.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::latency) enum Script {
    Zmq,
    Zenoh,
    Chain,
}

impl Script {
    pub(in crate::latency) const ALL: [Self; 3] = [Self::Zmq, Self::Zenoh, Self::Chain];

    pub(in crate::latency) fn id(self) -> &'static str {
        match self {
            Self::Zmq => "zmq",
            Self::Zenoh => "zenoh",
            Self::Chain => "python_chain",
        }
    }

    fn file(self) -> &'static str {
        match self {
            Self::Zmq => "latency_zmq.py",
            Self::Zenoh => "latency_zenoh.py",
            Self::Chain => "latency_chain.py",
        }
    }
}

#[derive(Serialize)]
struct Request {
    frames: std::path::PathBuf,
    width: u32,
    height: u32,
    count: u64,
    fps: f64,
    seconds: f64,
    /// The rope's color ranges, in OpenCV's units.
    ranges: Vec<[[u8; 3]; 2]>,
}

#[derive(Deserialize)]
struct Answer {
    missing: Option<String>,
    #[serde(default)]
    whole_ns: Vec<i64>,
    #[serde(default)]
    work_ns: Vec<i64>,
    #[serde(default)]
    versions: std::collections::BTreeMap<String, String>,
}

/// Runs a script. The error is a sentence that says what is missing.
pub(in crate::latency) fn measure(
    workplace: &Workplace,
    script: Script,
    size: [u32; 2],
    fps: f64,
    time: Duration,
) -> Result<Outcome> {
    let request = prepare(workplace, size, fps, time)?;
    let mut command = workplace.program(Placement::default(), &workplace.python);
    command.arg(workplace.path(script.file())).arg(request);
    command.env("PYTHONDONTWRITEBYTECODE", "1");
    let mut program = Guarded::start(command.stdout(Stdio::piped()))?;
    let reader = program.child().stdout.take().map(|mut stdout| {
        std::thread::spawn(move || {
            let mut text = String::new();
            let _ = stdout.read_to_string(&mut text);
            text
        })
    });
    let finished = workplace.finish(program, time + Duration::from_secs(60), "the script");
    let said = reader
        .and_then(|thread| thread.join().ok())
        .unwrap_or_default();
    finished?;
    let answer: Answer = serde_json::from_str(said.trim()).with_context(|| {
        format!(
            "{} does not run as a Python should",
            workplace.python.display()
        )
    })?;
    if let Some(package) = answer.missing {
        bail!(
            "{} has no {package}: `{} -m pip install {package}` (versions: bench/rivals/requirements.txt)",
            workplace.python.display(),
            workplace.python.display()
        );
    }
    let heap = |times_ns: &[i64]| {
        let mut times = Times::default();
        times_ns.iter().for_each(|&ns| times.add(ns.max(0) as u64));
        times
    };
    let mut outcome = Outcome::of_times(heap(&answer.whole_ns));
    let work = heap(&answer.work_ns).quantile_us(0.5);
    outcome.figures.extend(work.map(|us| ("work_p50_us", us)));
    let known = answer
        .versions
        .iter()
        .filter(|(_, version)| !version.is_empty());
    let versions: Vec<String> = known
        .map(|(name, version)| format!("{name} {version}"))
        .collect();
    outcome.versions = versions.join(", ");
    Ok(outcome)
}

/// Writes scripts, frames and the request to the workplace's folder.
fn prepare(
    workplace: &Workplace,
    size: [u32; 2],
    fps: f64,
    time: Duration,
) -> Result<std::path::PathBuf> {
    for (name, text) in FILES {
        std::fs::write(workplace.path(name), text).context("the scripts cannot be written")?;
    }
    let [width, height] = size;
    let frames = workplace.path(&format!("frames-{width}x{height}.rgb"));
    let ranges = write_frames(&frames, size)?;
    let request = Request {
        frames,
        width,
        height,
        count: FRAMES,
        fps,
        seconds: time.as_secs_f64(),
        ranges,
    };
    let path = workplace.path("request.json");
    std::fs::write(&path, serde_json::to_vec(&request)?).context("no request can be written")?;
    Ok(path)
}

/// Writes the first frames of the rendered rope in sequence. Returns the rope's color ranges.
fn write_frames(path: &std::path::Path, [width, height]: [u32; 2]) -> Result<Vec<[[u8; 3]; 2]>> {
    let options = RenderOptions {
        width,
        height,
        frames: Some(FRAMES),
        ..RenderOptions::default()
    };
    let mut source = lariat_capture::open(&Source::Rendered(options))?;
    let mut bytes = vec![0; source.largest_frame_bytes()];
    let mut ranges = Vec::new();
    let about = || format!("cannot write {}", path.display());
    let mut file = File::create(path).with_context(about)?;
    while let Some(frame) = source.next()? {
        source.write(&mut bytes);
        file.write_all(&bytes).with_context(about)?;
        if ranges.is_empty() {
            let (width, height) = (width as usize, height as usize);
            let stride = frame.stride as usize;
            let image = Image::new(&bytes, width, height, stride, PixelFormat::Rgb8)?;
            ranges = pick(&image, &[])?
                .ranges
                .iter()
                .flat_map(opencv_bounds)
                .collect();
        }
    }
    Ok(ranges)
}
