//! Pairs picture files with depth image files: by the number or the time in their names, or by
//! order.
//!
//! Data sets leave images out or stamp the two kinds with different clocks, so the n-th files of
//! two folders need not match. If the number at one place differs between all names of a folder, it
//! identifies the files. Files with equal numbers belong together. Times need not be equal: the
//! nearest ones belong together, within three fifths of the depth images' period, as for cameras
//! ([`Pairing`](crate::pairing::Pairing)).

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

/// Smallest whole number that counts as a time. Unix time in seconds has had ten digits since 2001.
const FIRST_TIME_S: u128 = 1_000_000_000;
/// Units in a number's value: fractions are read to nine digits.
const UNITS: u128 = 1_000_000_000;

/// How depth images and pictures were paired.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum By {
    Number,
    Time,
    Order,
}

/// Returns each picture's depth image and how they were paired. The error is a sentence about names
/// that contradict each other.
pub(crate) fn pair(
    pictures: &[PathBuf],
    depths: &[PathBuf],
) -> Result<(Vec<Option<usize>>, By), String> {
    let [of_pictures, of_depths] = [pictures, depths].map(Numbers::of);
    let mut best: (usize, Vec<Option<usize>>, By) = (0, Vec::new(), By::Order);
    for (p, q) in of_pictures.places_with(&of_depths) {
        let (ours, theirs) = (of_pictures.column(p), of_depths.column(q));
        let is_time = ours.iter().chain(&theirs).all(|number| number.is_time);
        let (found, by) = match is_time {
            true => (nearest(&ours, &theirs), By::Time),
            false => (equal(&ours, &theirs), By::Number),
        };
        let count = found.iter().flatten().count();
        if count > best.0 {
            best = (count, found, by);
        }
    }
    if best.0 > 0 {
        return Ok((best.1, best.2));
    }
    let have_numbers = !of_pictures.places().is_empty() && !of_depths.places().is_empty();
    if have_numbers && pictures.len() != depths.len() {
        return Err(format!(
            "there are {} pictures and {} depth images, and their names have no number or time in common: give both the same \
             numbers, or as many depth images as pictures",
            pictures.len(),
            depths.len()
        ));
    }
    let by_order =
        (0..pictures.len()).map(|place| Some(place).filter(|place| *place < depths.len()));
    Ok((by_order.collect(), By::Order))
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Number {
    /// Value in billionths.
    value: u128,
    is_time: bool,
}

/// The numbers in each name of a folder.
struct Numbers(Vec<Vec<Number>>);

impl Numbers {
    fn of(files: &[PathBuf]) -> Self {
        Self(files.iter().map(|file| numbers(file)).collect())
    }

    fn column(&self, place: usize) -> Vec<Number> {
        self.0.iter().map(|numbers| numbers[place]).collect()
    }

    /// Places at which every name has a number and no two names have the same number. The last
    /// place comes first.
    fn places(&self) -> Vec<usize> {
        let count = self.0.iter().map(Vec::len).min().unwrap_or(0);
        let differ = |place: &usize| {
            let mut seen = HashSet::new();
            self.0
                .iter()
                .all(|numbers| seen.insert(numbers[*place].value))
        };
        (0..count).rev().filter(differ).collect()
    }

    /// Pairs of places whose numbers may mean the same. If all names have equally many numbers,
    /// only equal places are paired.
    fn places_with(&self, other: &Self) -> Vec<(usize, usize)> {
        let counts: HashSet<usize> = self.0.iter().chain(&other.0).map(Vec::len).collect();
        let theirs = other.places();
        let pairs = self
            .places()
            .into_iter()
            .flat_map(|p| theirs.iter().map(move |q| (p, *q)));
        pairs.filter(|(p, q)| counts.len() != 1 || p == q).collect()
    }
}

/// Extracts the numbers in a file's name. Digits after a point that follows digits are a fraction.
fn numbers(file: &Path) -> Vec<Number> {
    let stem = file.file_stem().map(|stem| stem.to_string_lossy());
    let stem = stem.unwrap_or_default();
    let mut rest = stem.as_bytes();
    let mut found = Vec::new();
    while let Some(begin) = rest.iter().position(u8::is_ascii_digit) {
        rest = &rest[begin..];
        let whole = digits(&mut rest);
        let fraction = match rest {
            [b'.', next, ..] if next.is_ascii_digit() => {
                rest = &rest[1..];
                digits(&mut rest)
            }
            _ => &[],
        };
        let value = |digits: &[u8]| {
            digits
                .iter()
                .fold(0_u128, |n, d| 10 * n + u128::from(d - b'0'))
        };
        // No counter or clock has more digits.
        if whole.len() > 24 {
            continue;
        }
        let mut billionths: Vec<u8> = fraction.iter().copied().take(9).collect();
        billionths.resize(9, b'0');
        found.push(Number {
            value: value(whole) * UNITS + value(&billionths),
            is_time: !fraction.is_empty() || value(whole) >= FIRST_TIME_S,
        });
    }
    found
}

fn digits<'a>(text: &mut &'a [u8]) -> &'a [u8] {
    let end = text.iter().position(|c| !c.is_ascii_digit());
    let (digits, rest) = text.split_at(end.unwrap_or(text.len()));
    *text = rest;
    digits
}

fn equal(pictures: &[Number], depths: &[Number]) -> Vec<Option<usize>> {
    let places = depths.iter().enumerate();
    let places: HashMap<u128, usize> = places
        .map(|(place, number)| (number.value, place))
        .collect();
    let found = pictures
        .iter()
        .map(|number| places.get(&number.value).copied());
    found.collect()
}

/// Returns the depth image nearest in time to each picture, if it is near enough.
fn nearest(pictures: &[Number], depths: &[Number]) -> Vec<Option<usize>> {
    let mut sorted: Vec<(u128, usize)> =
        depths.iter().map(|number| number.value).zip(0..).collect();
    sorted.sort_unstable();
    let mut steps: Vec<u128> = sorted.windows(2).map(|two| two[1].0 - two[0].0).collect();
    steps.sort_unstable();
    // The lower median, because missing images make steps longer. A single image gives a period of
    // 0 and must match exactly.
    let period = steps
        .get(steps.len().saturating_sub(1) / 2)
        .copied()
        .unwrap_or(0);
    let of = |number: &Number| {
        let behind = sorted.partition_point(|(value, _)| *value < number.value);
        let around = [behind.checked_sub(1), Some(behind)];
        let around = around
            .into_iter()
            .flatten()
            .filter_map(|place| sorted.get(place));
        let apart = |(value, _): &&(u128, usize)| value.abs_diff(number.value);
        let found = around.min_by_key(apart)?;
        (5 * apart(&found) <= 3 * period).then_some(found.1)
    };
    pictures.iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn paired(pictures: &[&str], depths: &[&str]) -> Result<(Vec<Option<usize>>, By), String> {
        let paths = |names: &[&str]| names.iter().map(PathBuf::from).collect::<Vec<_>>();
        pair(&paths(pictures), &paths(depths))
    }

    #[test]
    fn a_picture_whose_number_no_depth_image_has_is_without() {
        let pictures = [
            "frame_000.png",
            "frame_001.png",
            "frame_002.png",
            "frame_003.png",
        ];
        let depths = ["frame_001.png", "frame_002.png", "frame_003.png"];
        let right = Ok((vec![None, Some(0), Some(1), Some(2)], By::Number));
        assert_eq!(paired(&pictures, &depths), right);
        let depths = ["depth16_1.png", "depth16_2.png", "depth16_3.png"];
        assert_eq!(
            paired(&pictures, &depths),
            right,
            "zeros and other numbers do not matter"
        );
    }

    #[test]
    fn names_of_data_sets_are_paired_as_their_authors_pair_them() {
        // TUM: seconds from two clocks.
        let rgb = [
            "1305031102.175304.png",
            "1305031102.211214.png",
            "1305031102.243211.png",
        ];
        let depth = [
            "1305031102.160407.png",
            "1305031102.194330.png",
            "1305031102.226738.png",
        ];
        let right = Ok((vec![Some(0), Some(2), Some(2)], By::Time));
        assert_eq!(
            paired(&rgb, &depth),
            right,
            "the nearest, which may be that of two"
        );
        assert_eq!(paired(&rgb[1..], &depth).unwrap().0, [Some(2), Some(2)]);
        // Redwood: a number, and a time from each camera.
        let rgb = [
            "0000001-000000000000.jpg",
            "0000002-000000033369.jpg",
            "0000003-000000066738.jpg",
        ];
        let depth = ["0000002-000000035000.png", "0000003-000000068000.png"];
        assert_eq!(
            paired(&rgb, &depth),
            Ok((vec![None, Some(0), Some(1)], By::Number))
        );
        // 7-Scenes.
        let rgb = ["frame-000000.color.png", "frame-000001.color.png"];
        let depth = ["frame-000001.depth.png"];
        assert_eq!(paired(&rgb, &depth), Ok((vec![None, Some(0)], By::Number)));
    }

    #[test]
    fn every_second_depth_image_is_not_lent_to_a_neighbour() {
        let pictures = ["0.png", "1.png", "2.png", "3.png"];
        let right = Ok((vec![Some(0), None, Some(1), None], By::Number));
        assert_eq!(paired(&pictures, &["0.png", "2.png"]), right);
    }

    #[test]
    fn a_time_without_a_depth_image_near_it_is_without() {
        let pictures = [
            "1700000000.000.png",
            "1700000000.033.png",
            "1700000000.066.png",
        ];
        let depths = [
            "1700000000.001.png",
            "1700000000.067.png",
            "1700000000.100.png",
        ];
        assert_eq!(
            paired(&pictures, &depths).unwrap().0,
            [Some(0), None, Some(1)]
        );
    }

    #[test]
    fn names_without_numbers_are_paired_by_order() {
        let right = Ok((vec![Some(0), Some(1)], By::Order));
        assert_eq!(paired(&["a.png", "b.png"], &["c.png", "d.png"]), right);
        let short = Ok((vec![Some(0), None], By::Order));
        assert_eq!(paired(&["a.png", "b.png"], &["c.png"]), short);
        assert_eq!(paired(&["1.png", "2.png"], &["11.png", "12.png"]), right);
    }

    #[test]
    fn numbers_that_contradict_each_other_are_refused() {
        let refused = paired(&["1.png", "2.png"], &["11.png", "12.png", "13.png"]).unwrap_err();
        assert!(refused.contains("no number or time in common"), "{refused}");
    }
}
