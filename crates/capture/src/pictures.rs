//! Shows picture files and folders of them as one sequence of frames.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use lariat_message::SourceKind;

use crate::ahead::{Ahead, Decode, Plan, Step};
use crate::foreign::Foreign;
use crate::natural::natural_order;
use crate::open::FileOptions;
use crate::picture::{
    PICTURES, PictureDecoder, is_hidden, is_picture, names_a_picture, probe, stranger,
};
use crate::range::Frames;
use crate::source::SourceError;

/// Lists the files of these pictures and folders in the given order, a folder's files in natural
/// order. Also returns sentences about files that were left out.
pub(crate) fn listed(paths: &[PathBuf]) -> Result<(Vec<PathBuf>, Vec<String>), SourceError> {
    let mut files = Vec::new();
    let mut warnings = Vec::new();
    for path in paths {
        let unreadable = |error| SourceError::Unreadable {
            path: path.clone(),
            error,
        };
        let found = fs::metadata(path).map_err(unreadable)?;
        if found.is_dir() {
            warnings.extend(list_folder(path, &mut files)?);
        } else if !found.is_file() {
            return Err(not_a_picture(path, &[]));
        } else {
            let mut head = Vec::new();
            let file = File::open(path).map_err(unreadable)?;
            file.take(16).read_to_end(&mut head).map_err(unreadable)?;
            if !is_picture(&head) && !names_a_picture(path) {
                return Err(not_a_picture(path, &head));
            }
            files.push(path.clone());
        }
    }
    Ok((files, warnings))
}

/// The error for a file with these first bytes.
fn not_a_picture(path: &Path, head: &[u8]) -> SourceError {
    SourceError::NotAPicture {
        path: path.to_owned(),
        what: stranger(path, head),
    }
}

/// Opens pictures and folders, shown in the given order. A folder's pictures are in natural order.
pub(crate) fn open_pictures(
    paths: &[PathBuf],
    options: &FileOptions,
) -> Result<Ahead, SourceError> {
    let (files, warnings) = listed(paths)?;
    let frames = options.range.frames(options.fps)?;
    let files = selected(files, frames)?;
    // A file with a broken header stays in the sequence and is lost when its turn comes.
    let (mut total_bytes, mut largest_frame_bytes) = (0, 0);
    for layout in files.iter().filter_map(|file| probe(file).ok()) {
        total_bytes += layout.bytes() as u64;
        largest_frame_bytes = largest_frame_bytes.max(layout.bytes());
    }
    let plan = Plan {
        kind: SourceKind::Files,
        largest_frame_bytes,
        native_fps: None,
        looped: options.looped,
        has_truth: false,
        total_bytes,
        warnings,
        news: frames.news(),
    };
    let pictures = Pictures {
        files,
        next: 0,
        decoder: PictureDecoder::default(),
    };
    Ahead::start(pictures, plan)
}

/// Returns the files that are in the range.
pub(crate) fn selected<T>(files: Vec<T>, frames: Frames) -> Result<Vec<T>, SourceError> {
    let count = files.len() as u64;
    if frames.of(count) == 0 {
        return Err(SourceError::BehindEnd {
            first: frames.first,
            count,
        });
    }
    // In range: the first is within the files.
    let (first, every) = (frames.first as usize - 1, frames.every as usize);
    let chosen = files.into_iter().skip(first).step_by(every);
    Ok(chosen.take(frames.of(count) as usize).collect())
}

/// Adds a folder's pictures. Returns a sentence if it contains other files too.
fn list_folder(folder: &Path, files: &mut Vec<PathBuf>) -> Result<Option<String>, SourceError> {
    let unreadable = |error| SourceError::Unreadable {
        path: folder.to_owned(),
        error,
    };
    let (mut found, ignored) = pictures_in(folder).map_err(unreadable)?;
    let other = foreign_example(&ignored);
    if found.is_empty() {
        let usual = "name a folder that holds the pictures itself, not in folders of its own";
        return Err(SourceError::NoPictures {
            path: folder.to_owned(),
            ignored: ignored.len(),
            advice: other.unwrap_or_else(|| usual.to_owned()),
        });
    }
    files.append(&mut found);
    let count = ignored.len();
    let plural = if count == 1 { "file" } else { "files" };
    let example = other.map(|other| format!(": {other}")).unwrap_or_default();
    Ok((count > 0).then(|| {
        format!(
            "left out {count} {plural} of {} that are not {PICTURES} by their names{example}",
            folder.display()
        )
    }))
}

/// Returns a sentence about the first of these files that, judging by its name, is a picture or
/// video that has to be converted. `None` if there is no such file.
pub fn foreign_example(files: &[PathBuf]) -> Option<String> {
    let known = files
        .iter()
        .filter(|path| !is_hidden(path))
        .min_by(|a, b| {
            let rank = |path: &Path| Foreign::named(path).is_none();
            rank(a).cmp(&rank(b)).then_with(|| a.cmp(b))
        })?;
    let foreign = Foreign::named(known)?;
    Some(format!("{} {}", known.display(), foreign.advice(known)))
}

/// Lists a folder's pictures, recognized by name, in natural order, and its other files.
pub(crate) fn pictures_in(folder: &Path) -> io::Result<(Vec<PathBuf>, Vec<PathBuf>)> {
    let mut found = Vec::new();
    let mut ignored = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            continue;
        }
        if names_a_picture(&path) {
            found.push(path);
        } else {
            ignored.push(path);
        }
    }
    let name = |path: &PathBuf| path.file_name().map(|name| name.to_owned());
    found.sort_by(|a, b| {
        let (a, b) = (name(a).unwrap_or_default(), name(b).unwrap_or_default());
        natural_order(a.as_encoded_bytes(), b.as_encoded_bytes())
    });
    Ok((found, ignored))
}

struct Pictures {
    files: Vec<PathBuf>,
    next: usize,
    decoder: PictureDecoder,
}

impl Decode for Pictures {
    fn rewind(&mut self) -> Result<(), SourceError> {
        self.next = 0;
        Ok(())
    }

    fn decode(&mut self, pixels: &mut [u8]) -> Step {
        let Some(file) = self.files.get(self.next) else {
            return Step::End(None);
        };
        self.next += 1;
        match self.decoder.decode(file, pixels) {
            Ok(layout) => Step::Decoded(layout),
            Err(reason) => Step::Lost(reason),
        }
    }
    fn take_news(&mut self) -> Option<String> {
        self.decoder.take_news()
    }
}
