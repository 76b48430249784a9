//! Runs every target on the stored seeds and on thousands of reproducible mutations of them. This
//! is a short run of each fuzz target with the normal compiler.
//!
//! A mutation that fails is written to the folder for temporary files, and its path is reported. If
//! the file is copied to `seeds/`, it is tried first from then on. `LARIAT_HOSTILE_INPUTS=100000`
//! tries more mutations.

use std::fs;
use std::panic::catch_unwind;
use std::path::{Path, PathBuf};

use lariat_portable::SplitMix64;
use targets::{TARGETS, Target};

#[allow(unreachable_pub, reason = "`fuzz/` includes it as a part of a library")]
mod targets;

/// Maximum length of a mutated input.
const MOST_BYTES: usize = 600;

/// Number of inputs to try, unless the environment sets it. The default takes a few seconds per
/// target.
fn inputs(usual: u64) -> u64 {
    let asked = std::env::var("LARIAT_HOSTILE_INPUTS");
    asked.map_or(usual, |asked| asked.parse().expect("a whole number"))
}

fn seeds(name: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/hostile/seeds")
        .join(name);
    let entries = fs::read_dir(&folder).expect("a folder of seeds");
    let mut paths: Vec<_> = entries
        .map(|entry| entry.expect("readable").path())
        .collect();
    paths.sort();
    assert!(!paths.is_empty(), "{} is empty", folder.display());
    let read = |path: PathBuf| (path.clone(), fs::read(path).expect("readable"));
    paths.into_iter().map(read).collect()
}

/// Returns a seed, or parts of two, with some bytes changed, inserted or removed.
fn made_up(seeds: &[(PathBuf, Vec<u8>)], random: &mut SplitMix64) -> Vec<u8> {
    let pick = |random: &mut SplitMix64| seeds[random.below(seeds.len())].1.clone();
    let mut bytes = pick(random);
    if random.below(4) == 0 {
        let other = pick(random);
        bytes.truncate(random.below(bytes.len() + 1));
        bytes.extend(&other[random.below(other.len() + 1)..]);
    }
    for _ in 0..=random.below(12) {
        let place = random.below(bytes.len() + 1);
        let byte = random.next_u64() as u8;
        match random.below(4) {
            0 if place < bytes.len() => drop(bytes.remove(place)),
            1 if place < bytes.len() => bytes[place] = byte,
            2 => bytes.extend((0..random.below(40)).map(|_| random.next_u64() as u8)),
            _ => bytes.insert(place, byte),
        }
    }
    bytes.truncate(MOST_BYTES);
    bytes
}

fn hold(name: &str, usual: u64) {
    let target = TARGETS.iter().find(|(known, _)| *known == name);
    let (_, target): &(&str, Target) = target.expect("there is such a target");
    let seeds = seeds(name);
    for (path, bytes) in &seeds {
        let held = catch_unwind(|| target(bytes));
        assert!(held.is_ok(), "{} does not hold", path.display());
    }
    let mut random = SplitMix64::of_stream(1, name.len() as u64);
    for number in 0..inputs(usual) {
        let bytes = made_up(&seeds, &mut random);
        if catch_unwind(|| target(&bytes)).is_err() {
            let place = std::env::temp_dir().join(format!("lariat-hostile-{name}-{number}"));
            fs::write(&place, &bytes).expect("written");
            panic!("{name} does not hold for {}", place.display());
        }
    }
}

#[test]
fn descriptors() {
    hold("descriptors", 1000);
}

#[test]
fn descriptors3() {
    hold("descriptors3", 1000);
}

#[test]
fn centerlines() {
    hold("centerlines", 60);
}

#[test]
fn frame() {
    hold("frame", 5000);
}

#[test]
fn command() {
    hold("command", 5000);
}

#[test]
fn words() {
    hold("words", 50_000);
}

#[test]
fn front() {
    hold("front", 20_000);
}
