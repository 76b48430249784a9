//! Problems of incoming messages, each with an error text, and their counts.

use std::mem::{Discriminant, discriminant};
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Reason why a message was rejected or changed.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub(crate) enum Trouble {
    #[error(
        "the encoding {0} is not understood: rgb8, bgr8, rgba8, bgra8, mono8, mono16, rgb16, bgr16, yuv422_yuy2, uyvy, nv12, nv21, nv24, i420, bayer_*8, bayer_*16 and 32FC1 are"
    )]
    Encoding(String),
    #[error(
        "an image of {width}×{height} {encoding} with a step of {step} has {bytes} bytes, which do not fit together: bytes are step × \
         height, and a step holds a row"
    )]
    Size {
        width: u32,
        height: u32,
        encoding: String,
        step: u32,
        bytes: usize,
    },
    #[error("a compressed image cannot be read: {0}; JPEG, PNG, WebP, TIFF and BMP can")]
    File(String),
    #[error("the message is not what its type says: {0}")]
    Malformed(String),
    #[error("{0}")]
    NotWritten(String),
    #[error(
        "an image was taken {} s before the one that came before it, and is not used: does more than one node publish it?", secs(*behind_ns)
    )]
    Backwards { behind_ns: u64 },
    #[error("messages have no stamp: they count as of the moment when they arrive")]
    NoStamp,
    #[error(
        "a stamp lies {} s ahead of this machine's clock: it counts as of the moment when it arrived. Keep the clocks of both machines the \
         same (chrony, PTP), or say --stamp-on-arrival", secs(*ahead_ns)
    )]
    Ahead { ahead_ns: u64 },
    #[error(
        "a message was stamped {} s ago, and is not used: with recorded or simulated time, say --stamp-on-arrival", secs(*age_ns)
    )]
    Old { age_ns: u64 },
    #[error(
        "a mask of {} has no image with its stamp: give it the header of the image that it is of", secs(*stamp_ns)
    )]
    NoImage { stamp_ns: u64 },
    #[error("a mask of {mask} pixels is of an image of {image}: it must be as large")]
    MaskSize { mask: String, image: String },
    #[error("a mask is mono8, and not {0}")]
    MaskEncoding(String),
    #[error("a velocity is not a finite number, and is not used")]
    NotFinite,
}

fn secs(ns: u64) -> String {
    format!("{:.3}", ns as f64 / 1e9)
}

/// Counts of the messages of a topic.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    taken: AtomicU64,
    lost: AtomicU64,
    refused: AtomicU64,
    restamped: AtomicU64,
}

impl Tally {
    pub(super) fn take(&self) {
        self.taken.fetch_add(1, Relaxed);
    }

    /// Counts messages that were sent but never arrived.
    pub(super) fn lose(&self, count: u64) {
        self.lost.fetch_add(count, Relaxed);
    }

    pub(super) fn refuse(&self) {
        self.refused.fetch_add(1, Relaxed);
    }

    pub(super) fn restamp(&self) {
        self.restamped.fetch_add(1, Relaxed);
    }

    /// Returns whether any message has arrived.
    pub(super) fn has_come(&self) -> bool {
        self.taken.load(Relaxed) + self.refused.load(Relaxed) > 0
    }

    /// The counts for diagnostics.
    pub(crate) fn values(&self, what: &str) -> [(String, String); 4] {
        [
            ("taken", &self.taken),
            ("lost on the way", &self.lost),
            ("refused", &self.refused),
            ("with another stamp", &self.restamped),
        ]
        .map(|(how, count)| (format!("{what} {how}"), count.load(Relaxed).to_string()))
    }
}

/// Reports each kind of problem once per topic.
#[derive(Default)]
pub(super) struct TroubleReporter(Vec<Discriminant<Trouble>>);

impl TroubleReporter {
    pub(super) fn report(&mut self, topic: &str, trouble: &Trouble) {
        let kind = discriminant(trouble);
        if !self.0.contains(&kind) {
            self.0.push(kind);
            eprintln!("lariat-ros2: {topic}: {trouble}");
        }
    }
}
