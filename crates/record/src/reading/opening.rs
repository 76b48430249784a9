//! Opens the files of a recording.

use std::path::Path;
use std::sync::Arc;

use super::about::About;
use super::cursor::Source;
use super::error::RecordingError;
use super::files;
use super::layout::MAGIC;
use super::scan::{self, End};
use super::storage::{FileStorage, Storage};
use super::summary;
use super::topics::Topics;

/// A file of a recording.
pub(super) struct Opened {
    pub(super) source: Source,
    pub(super) about: About,
    /// Message about a missing part at the end.
    pub(super) cut_off: Option<String>,
}

/// Opens all files that a path names, at least one. Also returns messages about
/// files that are missing, cut off or not readable.
pub(super) fn open(
    path: &Path,
    topic: Option<&str>,
) -> Result<(Vec<Opened>, Vec<String>), RecordingError> {
    let (listed, mut notes) = files::listed(path)?;
    let [_, _, ..] = listed[..] else {
        let mut file = Opened::new(Arc::new(FileStorage::open(&listed[0])?), topic)?;
        notes.extend(file.cut_off.take());
        return Ok((vec![file], notes));
    };
    let (mut files, mut refused) = (Vec::<Opened>::new(), None);
    for path in &listed {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        // All files show the topic that was chosen for the first file.
        let chosen = (files.iter()).find_map(|file| file.source.topics.images.clone());
        let open = || {
            Opened::new(
                Arc::new(FileStorage::open(path)?),
                topic.or(chosen.as_deref()),
            )
        };
        match open() {
            Ok(mut file) => {
                notes.extend(file.cut_off.take().map(|note| format!("{name}: {note}")));
                files.push(file);
            }
            Err(error) => {
                use RecordingError::{Empty, NoImages, NoTopic};
                // A file of a long recording may contain no images.
                if !matches!(error, Empty { .. } | NoImages { .. } | NoTopic { .. }) {
                    notes.push(format!("{name} is not read: {error}"));
                }
                refused.get_or_insert(RecordingError::OfFile {
                    name: name.into_owned(),
                    error: Box::new(error),
                });
            }
        }
    }
    match (files.is_empty(), refused) {
        (false, _) => Ok((files, notes)),
        (true, refused) => Err(refused.unwrap_or(RecordingError::NoFile)),
    }
}

impl Opened {
    /// Opens one file.
    ///
    /// # Errors
    /// Fails if the file is not a recording, or contains nothing that lariat reads.
    pub(super) fn new(
        storage: Arc<dyn Storage>,
        topic: Option<&str>,
    ) -> Result<Self, RecordingError> {
        let mut begin = [0; 16];
        let begin = storage.read_some(0, &mut begin)?;
        if !begin.starts_with(&MAGIC) {
            return Err(match begin {
                b"SQLite format 3\0" => RecordingError::Sqlite,
                begin if begin.starts_with(b"#ROSBAG V") => RecordingError::Ros1,
                _ => RecordingError::NotMcap,
            });
        }
        let (index, end) = match summary::read(storage.as_ref())? {
            Some(index) => (index, End::Closed),
            None => {
                let found = scan::scan(&storage)?;
                (found.index, found.end)
            }
        };
        let cut = matches!(end, End::Torn { .. });
        if index.parts.is_empty() {
            return Err(RecordingError::Empty { cut });
        }
        let about = About::read(storage.as_ref(), &index)?;
        let topics = Topics::choose(&index, about.version(), topic)?;
        let cut_off = cut_off(end, storage.size(), about.version().is_some());
        Ok(Self {
            source: Source {
                offset_ns: about.monotonic_to_wall_ns(),
                storage,
                index: Arc::new(index),
                topics: Arc::new(topics),
            },
            about,
            cut_off,
        })
    }
}

fn cut_off(end: End, size: u64, is_ours: bool) -> Option<String> {
    match end {
        End::Torn { at } => Some(format!(
            "this recording was not closed (its writer was killed, or the machine went down): what was written up to byte {at} \
             of {size} is whole and is read, what was not yet in a whole chunk then is missing"
        )),
        // Recordings of other programs may normally end without an index.
        End::WithoutIndex if is_ours => Some(
            "this recording was closed in need (its disk was full, or failed): it is whole up to there".to_owned(),
        ),
        End::WithoutIndex | End::Closed => None,
    }
}
