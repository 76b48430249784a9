//! A recording instead of a chain.

use serde_json::Value;
use tungstenite::Message;

use crate::page::{Page, assert_curves_lie_on_the_rope};
use crate::plane::make_plane;
use crate::rig::Bench;
use crate::viewing::Viewing;

const GOLDEN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/recordings/rope.mcap");

#[test]
fn of_a_recording_any_frame_is_had_as_it_was_recorded() {
    let bench = Bench::new();
    let viewing = Viewing::start(&bench, &[GOLDEN]);
    let mut page = Page::of(&viewing);
    let status = page.status(|_| true);
    assert_eq!(status["film"]["name"], "rope.mcap");
    let frames = status["film"]["frames"].as_u64().expect("a number");
    let export = bench.run(&["export", GOLDEN, "--format", "jsonl", "--out", "-"]);
    let text = String::from_utf8(export.stdout).expect("text");
    let recorded: Vec<Value> = (text.lines())
        .map(|line| serde_json::from_str(line).expect("JSON"))
        .collect();
    assert_eq!(recorded.len() as u64, frames);
    // Forward, back, a jump, and to the end.
    for place in [0, 1, 0, frames / 2, frames - 1] {
        let wish = format!(r#"{{"type":"frame","place":{place},"width":4000}}"#);
        page.0.send(Message::text(wish)).expect("sent");
        let (said, jpeg) = page.moment();
        assert_eq!(said["number"].as_u64(), Some(place + 1));
        let picture = image::load_from_memory(&jpeg).expect("a JPEG");
        assert_eq!(Some(u64::from(picture.width())), said["width"].as_u64());
        let whole = &recorded[place as usize];
        assert_eq!(said["frame"], whole["trace"]["sequence"], "{whole}");
    }
    for place in [frames, u64::MAX] {
        let wish = format!(r#"{{"type":"frame","place":{place},"width":4000}}"#);
        page.0.send(Message::text(wish)).expect("sent");
        let Message::Text(said) = page.0.read().expect("a message in time") else {
            panic!("there is no frame {place}");
        };
        assert!(said.contains("missing"), "{said}");
    }
    assert!(Page::open(&viewing.url, None, "foxglove.websocket.v1").is_err());
    viewing.end();
    let none = bench.run(&["view", "none.mcap"]);
    assert!(!none.status.success());
}

#[test]
fn a_recordings_curves_in_millimetres_are_drawn_by_the_plane_that_is_in_it() {
    let bench = Bench::new();
    make_plane(&bench, "table.toml", &[]);
    let flags = [
        "--plane",
        "table.toml",
        "--record",
        "run.mcap",
        "--frames",
        "20",
    ];
    assert!(bench.start(&flags).end().status.success());
    std::fs::remove_file(bench.path("table.toml")).expect("removed");
    let viewing = Viewing::start(&bench, &["run.mcap"]);
    let mut page = Page::of(&viewing);
    let wish = r#"{"type":"frame","place":10,"width":4000}"#;
    page.0.send(Message::text(wish)).expect("sent");
    let (said, jpeg) = page.moment();
    assert_eq!(said["unit"], "mm");
    assert_curves_lie_on_the_rope(&said, &jpeg);
    viewing.end();
}
