//! The same pictures give the same numbers, to the last bit, on every machine, vector set and
//! build. Drawn films pass through the extractor and through every kind of fit, and the results are
//! compared with a file of hashes.
//!
//! Each line of the file is a case and a step, with a hash for each frame. The first difference
//! tells where to look. After an intended change, rewrite the file with
//! `LARIAT_WRITE_HASHES=1 cargo test -p lariat-extract --test same_bits`.
//! `tests/simd/run` runs this test on other kinds of processors.

mod drawing;
#[path = "same_bits/fitted.rs"]
mod fitted;
#[path = "same_bits/hash.rs"]
mod hash;
#[path = "same_bits/seen.rs"]
mod seen;

use std::fmt::Write;

use lariat_portable::Arch;

/// Hashes of the frames, for each step of each case.
#[derive(Default)]
struct Told(Vec<(String, Vec<u32>)>);

impl Told {
    fn frame(&mut self, case: &str, step: &str, hash: hash::Hash) {
        let name = format!("{case}, {step}");
        match self.0.iter_mut().find(|(known, _)| *known == name) {
            Some((_, hashes)) => hashes.push(hash.value()),
            None => self.0.push((name, vec![hash.value()])),
        }
    }

    fn text(&self) -> String {
        let mut text = String::new();
        for (name, hashes) in &self.0 {
            let _ = write!(text, "{name}:");
            for hash in hashes {
                let _ = write!(text, " {hash:08x}");
            }
            text.push('\n');
        }
        text
    }
}

/// The names of the lines that differ, and the first frame of each that does.
fn differences(found: &str, expected: &str) -> Vec<String> {
    let expected: Vec<&str> = expected.lines().collect();
    let mut differences = Vec::new();
    for (i, line) in found.lines().enumerate() {
        let other = expected.get(i).copied().unwrap_or("");
        if line == other {
            continue;
        }
        let name = line.split(':').next().unwrap_or(line);
        let frame = line
            .split(' ')
            .zip(other.split(' '))
            .take_while(|(a, b)| a == b)
            .count();
        let words = name.split(' ').count();
        differences.push(format!(
            "{name}: from frame {} on",
            frame.saturating_sub(words)
        ));
    }
    differences
}

#[test]
fn the_same_pictures_give_the_same_bits_on_every_machine() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/same_bits/hashes.txt");
    let mut rewrites = std::env::var_os("LARIAT_WRITE_HASHES").is_some();
    let (pictures, lines) = (seen::Pictures::draw(), fitted::lines());
    for arch in Arch::all() {
        arch.keep_to();
        let mut told = Told::default();
        pictures.tell(&mut told);
        fitted::fits(&mut told, &lines);
        let found = told.text();
        if rewrites {
            std::fs::write(path, &found).expect("the file of hashes can be written");
            rewrites = false;
        }
        let expected = std::fs::read_to_string(path).expect("the file of hashes can be read");
        let differences = differences(&found, &expected);
        assert!(differences.is_empty(), "{arch:?}: {differences:#?}");
        assert_eq!(found.lines().count(), expected.lines().count());
    }
}
