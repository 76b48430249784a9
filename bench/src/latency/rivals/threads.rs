//! The four stages as threads of one process, connected by bounded channels. Buffers are handed
//! over; no pixel is copied.

use std::time::Duration;

use anyhow::{Result, anyhow};
use crossbeam::channel::{Receiver, Sender, TrySendError, bounded};
use lariat_sink::FinalCounts;
use lariat_wire::{Centerlines, Descriptors, FrameHeader};

use super::steps::{CaptureStep, ExtractStep, FitStep, SinkStep, Task};
use crate::latency::chain;
use crate::latency::figures::Outcome;
use crate::latency::guard::Placement;
use crate::latency::workplace::Workplace;
use lariat_chain::settings::Settings;
use lariat_chain::stop::Stop;

/// Maximum number of messages that wait for a stage, as on the chain's channel of frames.
const WAITING: usize = 3;
/// Buffers in circulation on a link: those that wait, and one at each end.
const BUFFERS: usize = WAITING + 2;

/// Runs the four threads in a process of their own.
pub(in crate::latency) fn measure(
    workplace: &Workplace,
    size: [u32; 2],
    fps: f64,
    time: Duration,
) -> Result<Outcome> {
    let out = workplace.path("threads");
    let mut command = workplace.part(Placement::default(), "threads");
    command.args(Task::words(size, fps, time.as_secs_f64(), &out));
    chain::watch(workplace, &mut command, time, &out, "the four threads")
}

/// Arguments of `latency-part threads`.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct ThreadsArgs {
    #[command(flatten)]
    task: Task,
}

struct Frame {
    header: FrameHeader,
    pixels: Vec<u8>,
}

/// A link whose buffers circulate: they are sent full and returned empty. A message that finds no
/// space is dropped, and its missing number is counted.
struct Link<T> {
    full: (Sender<T>, Receiver<T>),
    empty: (Sender<T>, Receiver<T>),
}

impl<T> Link<T> {
    fn new(make: impl Fn() -> T) -> Self {
        let link = Self {
            full: bounded(WAITING),
            empty: bounded(BUFFERS),
        };
        for _ in 0..BUFFERS {
            // The channel has space for all buffers.
            let _ = link.empty.0.send(make());
        }
        link
    }

    fn ends(self) -> (Outgoing<T>, Incoming<T>) {
        (
            Outgoing {
                full: self.full.0,
                empty: self.empty.1,
                unsent: None,
            },
            Incoming {
                full: self.full.1,
                empty: self.empty.0,
            },
        )
    }
}

struct Outgoing<T> {
    full: Sender<T>,
    empty: Receiver<T>,
    /// A buffer whose message found no space.
    unsent: Option<T>,
}

impl<T> Outgoing<T> {
    fn buffer(&mut self) -> Option<T> {
        self.unsent.take().or_else(|| self.empty.recv().ok())
    }

    fn send(&mut self, buffer: T) {
        if let Err(TrySendError::Full(buffer)) = self.full.try_send(buffer) {
            self.unsent = Some(buffer);
        }
    }
}

struct Incoming<T> {
    full: Receiver<T>,
    empty: Sender<T>,
}

impl<T> Incoming<T> {
    fn give_back(&self, buffer: T) {
        // The other end may already be gone during shutdown.
        let _ = self.empty.send(buffer);
    }
}

/// Runs the four threads until the time is over, and writes the report.
pub(in crate::latency) fn run(args: &ThreadsArgs) -> Result<()> {
    let (settings, stop) = (&args.task.settings(), &Stop::on_signals()?);
    let bytes = CaptureStep::new(settings)?.frame_bytes();
    let frames = Link::new(|| Frame {
        header: FrameHeader::default(),
        pixels: vec![0; bytes],
    });
    let centerlines = Link::new(|| Box::new(Centerlines::EMPTY));
    let descriptors = Link::new(|| Box::new(Descriptors::EMPTY));
    let (to_extract, from_capture) = frames.ends();
    let (to_fit, from_extract) = centerlines.ends();
    let (to_sink, from_fit) = descriptors.ends();
    std::thread::scope(|scope| {
        // Each thread owns its ends, so that a thread that fails ends the others.
        let sink = scope.spawn(move || count(settings, &from_fit));
        let fit = scope.spawn(move || fit(settings, &from_extract, to_sink));
        let extract = scope.spawn(move || look(settings, &from_capture, to_fit));
        let capture = scope.spawn(move || capture(settings, stop, to_extract));
        for thread in [capture, extract, fit, sink] {
            thread.join().map_err(|_| anyhow!("a thread broke off"))??;
        }
        Ok(())
    })
}

fn capture(settings: &Settings, stop: &Stop, mut frames: Outgoing<Frame>) -> Result<()> {
    let mut capture = CaptureStep::new(settings)?;
    while let Some(mut frame) = frames.buffer() {
        let Some(header) = capture.next(&mut frame.pixels, stop)? else {
            break;
        };
        frame.header = header;
        frames.send(frame);
        // Yields for the same reason as the chain's capture.
        std::thread::yield_now();
    }
    Ok(())
}

fn look(
    settings: &Settings,
    frames: &Incoming<Frame>,
    mut centerlines: Outgoing<Box<Centerlines>>,
) -> Result<()> {
    let mut extract = ExtractStep::new(settings)?;
    for frame in &frames.full {
        let Some(mut message) = centerlines.buffer() else {
            break;
        };
        extract.look(&frame.header, &frame.pixels, &mut message);
        frames.give_back(frame);
        centerlines.send(message);
    }
    Ok(())
}

fn fit(
    settings: &Settings,
    centerlines: &Incoming<Box<Centerlines>>,
    mut descriptors: Outgoing<Box<Descriptors>>,
) -> Result<()> {
    let mut fit = FitStep::new(settings)?;
    for seen in &centerlines.full {
        let Some(mut message) = descriptors.buffer() else {
            break;
        };
        fit.fit(&seen, &mut message);
        centerlines.give_back(seen);
        descriptors.send(message);
    }
    Ok(())
}

fn count(settings: &Settings, descriptors: &Incoming<Box<Descriptors>>) -> Result<()> {
    let mut sink = SinkStep::new(settings);
    for message in &descriptors.full {
        sink.count(&message);
        descriptors.give_back(message);
    }
    sink.report(settings, FinalCounts::default())
}
