//! Follows a folder that grows: shows its pictures, then each new one as it arrives.
//!
//! A picture is read once its writer has closed it or moved it into place, so it is never
//! incomplete. That moment is its exposure time, to within the few milliseconds that it takes to
//! decode the previous picture. The source never ends.

mod folder;

use std::collections::VecDeque;
use std::ffi::OsString;
use std::fs;
use std::num::NonZeroU64;
use std::os::fd::AsFd;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use lariat_message::{SourceKind, now_ns};
use rustix::event::PollFlags;

use crate::ahead::Layout;
use crate::picture::{PictureDecoder, names_a_picture, probe};
use crate::pictures::pictures_in;
use crate::source::{Frame, FrameSource, Next, SourceError};
use crate::until::{Until, Woken};
use folder::{Event, Folder};

/// A folder to follow.
#[derive(Debug, Clone, PartialEq)]
pub struct FollowOptions {
    /// The folder.
    pub folder: PathBuf,
    /// Maximum number of frames per second; pictures that come faster wait. `None` shows each as it
    /// arrives.
    pub fps: Option<f64>,
    /// Shows every n-th picture, beginning with the first.
    pub every: NonZeroU64,
}

/// A picture that waits to be shown.
#[derive(Debug)]
struct Waiting {
    path: PathBuf,
    /// Time of arrival; `None` if the picture was there before the folder was watched.
    came_ns: Option<u64>,
}

/// Identifies a file under any name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Identity {
    inode: u64,
    bytes: u64,
    modified: (i64, i64),
}

impl Identity {
    fn of(path: &Path) -> Option<Self> {
        let file = fs::metadata(path).ok()?;
        Some(Self {
            inode: file.ino(),
            bytes: file.len(),
            modified: (file.mtime(), file.mtime_nsec()),
        })
    }
}

/// A folder that is followed.
pub(crate) struct Follow {
    folder: Folder,
    path: PathBuf,
    period_ns: u64,
    every: u64,
    waiting: VecDeque<Waiting>,
    /// Number of pictures that have arrived. Every `every`-th of them is shown.
    came: u64,
    decoder: PictureDecoder,
    /// The current picture, in a buffer for the largest one.
    pixels: Vec<u8>,
    /// The frame that is decoded but not yet due.
    ready: Option<Frame>,
    shown: Option<Identity>,
    sequence: u64,
    last_exposed_ns: u64,
    warnings: VecDeque<String>,
    news: Option<String>,
}

impl Follow {
    /// Watches a folder and lists what is in it.
    pub(crate) fn open(options: &FollowOptions) -> Result<Self, SourceError> {
        let path = &options.folder;
        let unreadable = |error| SourceError::Unreadable {
            path: path.clone(),
            error,
        };
        let whole = fs::canonicalize(path).map_err(unreadable)?;
        if !whole.is_dir() {
            return Err(SourceError::NotAFolder { path: path.clone() });
        }
        let folder = Folder::watch(&whole).map_err(|error| SourceError::Unwatchable {
            path: path.clone(),
            error: error.into(),
        })?;
        let mut follow = Self {
            folder,
            path: whole,
            period_ns: options.fps.map_or(0, |fps| (1e9 / fps) as u64),
            every: options.every.get(),
            waiting: VecDeque::new(),
            came: 0,
            decoder: PictureDecoder::default(),
            pixels: Vec::new(),
            ready: None,
            shown: None,
            sequence: 0,
            last_exposed_ns: 0,
            warnings: VecDeque::new(),
            news: None,
        };
        follow.list().map_err(unreadable)?;
        let there = follow.waiting.iter();
        let there = there.filter_map(|picture| probe(&picture.path).ok());
        let largest = there.map(|layout| layout.bytes()).max().unwrap_or(0);
        follow.pixels.resize(largest, 0);
        if largest == 0 {
            let waits = "no picture is there yet: the first one makes room for all";
            follow.news = Some(format!("{}: {waits}", path.display()));
        }
        Ok(follow)
    }

    /// Lists the pictures in the folder. Drops pending events about the same files.
    fn list(&mut self) -> std::io::Result<()> {
        let (found, _) = pictures_in(&self.path)?;
        let mut happened = Vec::new();
        self.folder.drain(|event| happened.push(event));
        for path in &found {
            self.note(path.clone(), None);
        }
        happened.retain(|event| match event {
            Event::Came(name) => !found.iter().any(|path| path.file_name() == Some(name)),
            _ => true,
        });
        for event in happened {
            self.take(event);
        }
        Ok(())
    }

    /// Queues a file if it is a picture that is to be shown.
    fn note(&mut self, path: PathBuf, came_ns: Option<u64>) {
        if names_a_picture(&path) {
            if self.came.is_multiple_of(self.every) {
                self.waiting.push_back(Waiting { path, came_ns });
            }
            self.came += 1;
        }
    }

    fn take(&mut self, event: Event) {
        match event {
            Event::Came(name) => {
                let path = self.path.join(name);
                if self.waiting.back().is_some_and(|last| last.path == path) {
                    // The file was overwritten before it was read.
                    self.waiting.pop_back();
                    self.sequence += 1;
                }
                self.note(path, Some(now_ns()));
            }
            Event::Left(name) => self.leave(&name),
            Event::Gone => self.warn("is gone: should it come back, it is followed again"),
            Event::Back => {
                self.news = Some(format!("{} is there again", self.path.display()));
                if let Err(error) = self.list() {
                    self.warn(&format!("cannot be read ({error})"));
                }
            }
            Event::Missed => {
                self.warn("has got more pictures at once than the system notes: some were missed");
            }
        }
    }

    /// Removes a picture that was moved away. If it was renamed within the folder, it arrives again
    /// under its new name.
    fn leave(&mut self, name: &OsString) {
        let waited = self.waiting.len();
        let is_another = |picture: &Waiting| picture.path.file_name() != Some(name);
        self.waiting.retain(is_another);
        self.came -= (waited - self.waiting.len()) as u64;
    }

    fn warn(&mut self, what: &str) {
        let folder = self.path.display();
        self.warnings
            .push_back(format!("the folder {folder} {what}"));
    }

    /// Handles all pending events.
    fn look(&mut self) {
        let mut happened = Vec::new();
        self.folder.drain(|event| happened.push(event));
        happened.into_iter().for_each(|event| self.take(event));
    }

    /// Decodes a picture; `None` if it yields no new frame.
    fn decode(&mut self, picture: &Waiting) -> Option<Frame> {
        let identity = Identity::of(&picture.path);
        // The file was opened for writing but not written, or renamed within the folder after it
        // was shown.
        if identity.is_some() && identity == self.shown {
            return None;
        }
        let taken_ns = now_ns();
        let is_first = self.pixels.is_empty();
        if is_first && let Ok(layout) = probe(&picture.path) {
            self.pixels.resize(layout.bytes(), 0);
        }
        let decoded = self.decoder.decode(&picture.path, &mut self.pixels);
        if is_first && decoded.is_err() {
            self.pixels.clear();
        }
        self.news = self.news.take().or(self.decoder.take_news());
        // Pictures that arrived meanwhile are stamped with the current time.
        self.look();
        let layout = match decoded {
            Ok(layout) => layout,
            Err(reason) => {
                self.lose(picture, &reason);
                return None;
            }
        };
        self.shown = identity;
        self.sequence += 1;
        let Layout {
            width,
            height,
            stride,
            format,
        } = layout;
        let earliest_ns = match self.last_exposed_ns {
            0 => 0,
            // Times increase from frame to frame.
            last_ns => last_ns + self.period_ns.max(1),
        };
        self.last_exposed_ns = picture.came_ns.unwrap_or(taken_ns).max(earliest_ns);
        Some(Frame {
            sequence: self.sequence,
            width,
            height,
            stride,
            format,
            exposed_ns: Some(self.last_exposed_ns),
            slot: None,
        })
    }

    /// Reports a picture that cannot be decoded. A picture that was there at the start may still be
    /// incomplete; it arrives again once its writer closes it.
    fn lose(&mut self, picture: &Waiting, reason: &str) {
        self.warnings.push_back(if picture.came_ns.is_some() {
            self.sequence += 1;
            format!("lost frame {}: {reason}", self.sequence)
        } else {
            format!("{reason}: if it is still being written, it is shown when it is closed")
        });
    }
}

impl FrameSource for Follow {
    fn kind(&self) -> SourceKind {
        SourceKind::Files
    }

    fn largest_frame_bytes(&self) -> usize {
        self.pixels.len()
    }

    fn advance(&mut self, until: &Until) -> Result<Next, SourceError> {
        loop {
            self.look();
            if self.ready.is_none()
                && let Some(picture) = self.waiting.pop_front()
            {
                self.ready = self.decode(&picture);
                continue;
            }
            let due_ns = self.ready.and_then(|frame| frame.exposed_ns);
            if due_ns.is_some_and(|due_ns| due_ns <= now_ns())
                && let Some(frame) = self.ready.take()
            {
                return Ok(Next::Frame(frame));
            }
            if !self.warnings.is_empty() || self.news.is_some() {
                // Report these messages before the wait, which may be long.
                return Ok(Next::Nothing);
            }
            let event = Some((self.folder.as_fd(), PollFlags::IN));
            if until.wait(event, due_ns) == Woken::Interrupted {
                return Ok(Next::Nothing);
            }
        }
    }

    fn write(&mut self, pixels: &mut [u8]) {
        let count = pixels.len().min(self.pixels.len());
        pixels[..count].copy_from_slice(&self.pixels[..count]);
    }

    fn take_warning(&mut self) -> Option<String> {
        self.warnings.pop_front()
    }

    fn take_news(&mut self) -> Option<String> {
        self.news.take()
    }
}
