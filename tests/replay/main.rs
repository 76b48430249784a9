//! Recordings recomputed, exported and described, on the real binary.

mod export;

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use lariat_record::{Entry, Recording, Span};
use serde_json::Value;
use tempfile::TempDir;

/// The reference recording for results, whatever changes in the code. CONTRIBUTING says how to
/// renew it after intended changes.
const GOLDEN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/recordings/rope.mcap");

/// A folder to run the binary in, and a separate domain.
struct Place {
    folder: TempDir,
}

impl Place {
    fn new() -> Self {
        Self {
            folder: TempDir::new().unwrap(),
        }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Name of the transport's domain.
    fn domain(&self) -> String {
        let name = self.folder.path().file_name().unwrap().to_string_lossy();
        let plain = name.chars().filter(char::is_ascii_alphanumeric);
        plain.take(12).collect::<String>().to_lowercase()
    }

    fn run(&self, arguments: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_lariat"))
            .args(arguments)
            .env("LARIAT_DOMAIN", self.domain())
            .current_dir(self.folder.path())
            .stdin(Stdio::null())
            .output()
            .unwrap()
    }

    /// Runs a command that must succeed, and returns its output.
    fn printed(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        let complaint = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{arguments:?}: {complaint}");
        String::from_utf8(output.stdout).unwrap()
    }

    /// Runs a command that must fail, and returns its error message.
    fn complaint(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        let printed = String::from_utf8_lossy(&output.stdout);
        assert!(!output.status.success(), "{arguments:?}: {printed}");
        assert!(output.stdout.is_empty(), "{printed}");
        String::from_utf8(output.stderr).unwrap()
    }

    fn json(&self, arguments: &[&str]) -> Value {
        serde_json::from_str(&self.printed(arguments)).unwrap()
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(format!("/tmp/lariat-{}", self.domain()));
    }
}

#[test]
fn the_golden_recording_comes_out_the_same() {
    let place = Place::new();
    let outcome = place.json(&["replay", GOLDEN, "--check", "--json"]);
    assert_eq!(outcome["centerlines"], 43);
    assert_eq!(outcome["descriptors"], 43);
    assert_eq!(outcome["difference"], Value::Null);
    assert!(outcome["largest_px"].as_f64().unwrap() <= 1e-9);
    assert!(crossings(GOLDEN) > 0, "the rope should cross itself");
    let size = std::fs::metadata(GOLDEN).unwrap().len();
    assert!(
        size <= 300_000,
        "{size} bytes are too many for a repository"
    );
}

/// Number of frames with a crossing.
fn crossings(path: &str) -> usize {
    let recording = Recording::open(Path::new(path)).unwrap();
    let mut messages = recording.messages(Span::default()).unwrap();
    let mut frames = 0;
    while let Some(entry) = messages.next().unwrap() {
        if let Entry::Centerlines(seen) = entry {
            frames += usize::from(!seen.crossings().is_empty());
        }
    }
    frames
}

#[test]
fn a_chain_s_recording_comes_out_the_same_and_tells_what_it_holds() {
    let place = Place::new();
    let run = [
        "run", "--record", "run.mcap", "--frames", "20", "--fps", "100",
    ];
    place.printed(&[&run[..], &["--lossless", "--size", "320x240", "--filter"]].concat());
    let outcome = place.json(&["replay", "run.mcap", "--check", "--json"]);
    assert_eq!(outcome["difference"], Value::Null, "{outcome}");
    assert_eq!(
        (&outcome["centerlines"], &outcome["rule"]),
        (&20.into(), &"bits".into())
    );
    let said = place.printed(&["replay", "run.mcap", "--check"]);
    // Sentences are wrapped to the width of a terminal.
    let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        said.contains("computed again are the same to the bit"),
        "{said}"
    );

    let info = place.json(&["info", "run.mcap", "--json"]);
    assert_eq!(
        (&info["closed"], &info["frames"]),
        (&true.into(), &20.into())
    );
    assert_eq!(info["settings"]["fit.filter"], "true");
    assert_eq!(info["about"]["rig"], "default");
    let topics = info["topics"].as_array().unwrap();
    let of = |name: &str| topics.iter().find(|topic| topic["name"] == name).unwrap();
    assert_eq!(of("/default/image")["messages"], 20);
    assert_eq!(of("/default/image")["schema"], "sensor_msgs/msg/Image");
    let text = place.printed(&["info", "run.mcap"]);
    for part in [
        "20 frames",
        "/default/descriptors",
        "nothing was lost, on no link",
    ] {
        assert!(text.contains(part), "{text}");
    }
}

#[test]
fn a_recording_that_was_cut_off_is_checked_up_to_there() {
    let place = Place::new();
    let golden = std::fs::read(GOLDEN).unwrap();
    // Cut off the index.
    let data_end = golden.len() - 2000;
    std::fs::write(place.path("cut.mcap"), &golden[..data_end]).unwrap();
    let output = place.run(&["replay", "cut.mcap", "--check"]);
    let complaint = String::from_utf8(output.stderr).unwrap();
    assert!(
        complaint.contains("cut.mcap: this recording was not closed"),
        "{complaint}"
    );
    assert!(output.status.success(), "{complaint}");
    assert_eq!(place.json(&["info", "cut.mcap", "--json"])["closed"], false);
}

#[test]
fn a_comparison_shows_what_a_setting_changes() {
    let place = Place::new();
    let comparison = place.json(&[
        "replay",
        GOLDEN,
        "--compare",
        "--control-points",
        "3",
        "--json",
    ]);
    let rms = |of: &str| comparison[of]["rms"].as_f64().unwrap();
    assert!(rms("now") > rms("recorded"));
    assert_eq!(comparison["against"], "truth");
    std::fs::write(place.path("new.toml"), "[fit]\ncontrol_points = 7\n").unwrap();
    let table = place.printed(&["replay", GOLDEN, "--compare", "--config", "new.toml"]);
    assert!(table.starts_with("43 frames\n"), "{table}");
    assert!(table.contains("curve from the truth, mean, px"), "{table}");
}

#[test]
fn what_cannot_be_done_is_said_in_a_sentence() {
    let place = Place::new();
    std::fs::write(place.path("text.mcap"), "nothing of the kind").unwrap();
    for (arguments, sentence) in [
        (
            &["replay", GOLDEN][..],
            "say what to do with the recording: --check",
        ),
        (&["replay", "none.mcap", "--check"], "No such file"),
        (
            &["replay", "text.mcap", "--check"],
            "this is not a recording",
        ),
        (&["info", "text.mcap"], "this is not a recording"),
        (
            &["replay", GOLDEN, "--check", "--control-points", "7"],
            "a check uses the settings of the recording",
        ),
        (
            &["replay", GOLDEN, "--check", "--topic", "/none"],
            "there is no topic /none with images",
        ),
    ] {
        let complaint = place.complaint(arguments);
        assert!(complaint.contains(sentence), "{arguments:?}: {complaint}");
    }
}

#[test]
fn a_settings_file_beside_a_recording_is_not_the_recording_s() {
    let place = Place::new();
    std::fs::write(place.path("lariat.toml"), "[extract]\npoints = 9\n").unwrap();
    place.printed(&["replay", GOLDEN, "--check"]);
}

/// With one recorded number changed, the check names it and fails.
#[test]
fn a_check_that_finds_a_difference_fails_and_shows_it() {
    let place = Place::new();
    let made = changed(Path::new(GOLDEN));
    std::fs::write(place.path("changed.mcap"), made).unwrap();
    let output = place.run(&["replay", "changed.mcap", "--check"]);
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(
        said.contains("the centerlines of frame 7 are not the same:"),
        "{said}"
    );
    assert!(said.contains("rope 1, point 3, x: recorded"), "{said}");
}

/// Rewrites the recording with point 3 of frame 7 moved a hundredth of a pixel to the right.
fn changed(path: &Path) -> Vec<u8> {
    use lariat_record::Record;
    let bytes = std::fs::read(path).unwrap();
    let mut writer = mcap::Writer::new(std::io::Cursor::new(Vec::new())).unwrap();
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    for index in &summary.attachment_indexes {
        let attachment = mcap::read::attachment(&bytes, index).unwrap();
        writer.attach(&attachment).unwrap();
    }
    for index in &summary.metadata_indexes {
        let metadata = mcap::read::metadata(&bytes, index).unwrap();
        writer.write_metadata(&metadata).unwrap();
    }
    let mut centerlines = Box::new(lariat_wire::Centerlines::EMPTY);
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let mut message = message.unwrap();
        if message.channel.topic.ends_with("/centerlines") {
            centerlines.decode(&message.data).unwrap();
            if centerlines.trace.sequence == 7 {
                centerlines.curves[0].points[3][0] += 0.01;
                let mut cdr = Vec::new();
                centerlines.encode(&mut cdr);
                message.data = cdr.into();
            }
        }
        writer.write(&message).unwrap();
    }
    writer.finish().unwrap();
    writer.into_inner().into_inner()
}

#[test]
fn every_json_object_has_the_version_of_its_keys() {
    let place = Place::new();
    place.printed(&["export", GOLDEN, "--format", "jsonl", "--out", "all.jsonl"]);
    let exported = std::fs::read_to_string(place.path("all.jsonl")).unwrap();
    let commands: [&[&str]; 4] = [
        &["info", GOLDEN, "--json"],
        &["replay", GOLDEN, "--check", "--json"],
        &["devices", "--json"],
        &["doctor", "--json"],
    ];
    // Some of them report that something needs to be done.
    let printed = commands.map(|words| String::from_utf8(place.run(words).stdout).unwrap());
    let whole = printed.iter().map(String::as_str);
    for text in whole.chain(exported.lines()) {
        let object: Value = serde_json::from_str(text).unwrap();
        assert!(object["schema"].is_u64(), "{text}");
    }
}
