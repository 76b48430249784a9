//! A file for a source to read, and the frames of that source.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use lariat_capture::{Source, open};
use lariat_message::{Centerlines, PixelFormat};

/// A file that is removed when dropped.
pub(crate) struct ScratchFile(PathBuf);

impl ScratchFile {
    pub(crate) fn new(extension: &str, bytes: &[u8]) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let name = format!("lariat-fuzz-{}-{number}.{extension}", std::process::id());
        let path = std::env::temp_dir().join(name);
        fs::write(&path, bytes).expect("there is room for a small file");
        Self(path)
    }

    pub(crate) fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for ScratchFile {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.0);
    }
}

/// A frame from a source.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Shown {
    pub(crate) sequence: u64,
    pub(crate) size: [u32; 3],
    pub(crate) format: PixelFormat,
    pub(crate) pixels: Vec<u8>,
    pub(crate) due_ns: Option<u64>,
}

/// Returns the first frames of a source; `None` if the source is refused.
pub(crate) fn show(source: &Source, most: usize) -> Option<Vec<Shown>> {
    let mut source = open(source).ok()?;
    let mut frames: Vec<Shown> = Vec::new();
    let mut truth = Box::new(Centerlines::EMPTY);
    while frames.len() < most {
        // An error ends the source.
        let Ok(Some(frame)) = source.next() else {
            break;
        };
        assert!(frame.bytes() <= source.largest_frame_bytes());
        let mut pixels = vec![0; frame.bytes()];
        source.write(&mut pixels);
        truth.trace.sequence = 77;
        source.truth(&mut truth);
        assert_eq!(truth.trace.sequence, 77);
        let shown = Shown {
            sequence: frame.sequence,
            size: [frame.width, frame.height, frame.stride],
            format: frame.format,
            pixels,
            due_ns: source.due_after_ns(),
        };
        if let Some(last) = frames.last() {
            assert!(shown.sequence > last.sequence);
            assert!(shown.due_ns.is_none() || shown.due_ns > last.due_ns);
        }
        frames.push(shown);
        while source.take_warning().is_some() {}
    }
    Some(frames)
}
