//! From the paths that the user named to the pictures they mean.

use anyhow::{Context, Result, bail};
use std::cmp::Ordering;
use std::path::{Path, PathBuf};

/// The pictures, in the user's order and a folder's in natural order; and what is wrong with the rest.
pub(super) fn pictures(paths: &[PathBuf]) -> (Vec<PathBuf>, Vec<anyhow::Error>) {
    let (mut found, mut wrong) = (Vec::new(), Vec::new());
    for path in paths {
        if !path.is_dir() {
            // Whether it is a picture, and there at all, shows when it is opened.
            found.push(path.clone());
            continue;
        }
        match in_folder(path) {
            Ok(pictures) => found.extend(pictures),
            Err(error) => wrong.push(error),
        }
    }
    (found, wrong)
}

fn in_folder(folder: &Path) -> Result<Vec<PathBuf>> {
    let about = || format!("cannot list the folder {}", folder.display());
    let (mut pictures, mut folders) = (Vec::new(), Vec::new());
    for entry in std::fs::read_dir(folder).with_context(about)? {
        let path = entry.with_context(about)?.path();
        if path.is_dir() {
            folders.push(path.display().to_string());
        } else if is_picture_name(&path) && path.is_file() {
            pictures.push(path);
        }
    }
    if pictures.is_empty() && folders.is_empty() {
        bail!(
            "there is no PNG or JPEG in the folder {}: name the pictures, or another folder",
            folder.display()
        );
    }
    if pictures.is_empty() {
        folders.sort_by(|a, b| natural_order(a, b));
        bail!(
            "there is no PNG or JPEG in the folder {} itself: name one of its folders, such as {}",
            folder.display(),
            folders[0]
        );
    }
    pictures.sort_by(|a, b| natural_order(&a.to_string_lossy(), &b.to_string_lossy()));
    Ok(pictures)
}

fn is_picture_name(path: &Path) -> bool {
    path.extension().is_some_and(|extension| {
        ["png", "jpg", "jpeg"]
            .iter()
            .any(|known| extension.eq_ignore_ascii_case(known))
    })
}

/// As people count: `frame9` before `frame10`.
fn natural_order(a: &str, b: &str) -> Ordering {
    let (mut rest_a, mut rest_b) = (a, b);
    loop {
        let (piece_a, piece_b) = (first_piece(rest_a), first_piece(rest_b));
        let order = if starts_with_digit(piece_a) && starts_with_digit(piece_b) {
            let (number_a, number_b) = (
                piece_a.trim_start_matches('0'),
                piece_b.trim_start_matches('0'),
            );
            // Without leading zeros, more digits are a larger number.
            let by_length = number_a.len().cmp(&number_b.len());
            by_length.then_with(|| number_a.cmp(number_b))
        } else {
            piece_a.cmp(piece_b)
        };
        if order != Ordering::Equal {
            return order;
        }
        if piece_a.is_empty() {
            // Alike but for leading zeros: any order, as long as it is always the same.
            return a.cmp(b);
        }
        (rest_a, rest_b) = (&rest_a[piece_a.len()..], &rest_b[piece_b.len()..]);
    }
}

/// The digits or the other characters that `text` begins with.
fn first_piece(text: &str) -> &str {
    let is_number = starts_with_digit(text);
    let end = text
        .find(|c: char| c.is_ascii_digit() != is_number)
        .unwrap_or(text.len());
    &text[..end]
}

fn starts_with_digit(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_names_count() {
        let mut names = ["b2", "a10", "a9", "a", "a010", "a9b", "10", "9", ""];
        names.sort_by(|a, b| natural_order(a, b));
        assert_eq!(
            names,
            ["", "9", "10", "a", "a9", "a9b", "a010", "a10", "b2"]
        );
    }
}
