//! Moments and status of a running chain, also while it ends and starts, and the cost of a page.

use rustix::process::Signal;
use serde_json::Value;

use crate::page::{self, PATIENCE, Page, assert_curves_lie_on_the_rope};
use crate::rig::Bench;
use crate::viewing::Viewing;

/// Number of readers of a rig's channels: frames, centerlines, descriptors.
fn readers(bench: &Bench, rig: &str) -> Vec<u64> {
    let output = bench.run(&["topic", "list", "--json"]);
    let all: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let list = |of: &Value| of.as_array().expect("a list").clone();
    let of_rig = list(&all["rigs"])
        .into_iter()
        .find(|one| one["rig"] == rig)
        .expect("the rig");
    let of = |name: &str| {
        let channels = list(&of_rig["channels"]);
        let found = channels.iter().find(|one| one["channel"] == name);
        list(&found.expect(name)["readers"]).len() as u64
    };
    ["frames", "centerlines", "descriptors"].map(of).to_vec()
}

#[test]
fn a_page_gets_pictures_with_the_curve_on_the_rope() {
    let bench = Bench::new();
    let mut chain = bench.start(&["--rig", "cell", "--seed", "3"]);
    chain.wait_for_frames();
    let viewing = Viewing::start(&bench, &["--rig", "cell"]);
    let mut page = Page::of(&viewing);
    let mut frames = Vec::new();
    for _ in 0..5 {
        page.ask();
        let (said, jpeg) = page.moment();
        let picture = image::load_from_memory(&jpeg).expect("a JPEG").into_rgb8();
        assert_eq!(
            (said["width"].as_u64(), said["height"].as_u64()),
            (Some(640), Some(480))
        );
        assert_eq!(picture.dimensions(), (640, 480));
        assert_curves_lie_on_the_rope(&said, &jpeg);
        frames.push(said["frame"].as_u64().expect("a number"));
    }
    assert!(frames.is_sorted_by(|a, b| a < b), "{frames:?}");
    let status = page.status(|status| {
        status["steps"]
            .as_array()
            .is_some_and(|steps| !steps.is_empty())
    });
    assert_eq!(status["rig"], "cell");
    assert_eq!(status["stages"].as_array().expect("stages").len(), 4);
    viewing.end();
    chain.signal_chain(Signal::INT);
    assert!(chain.end().status.success());
    bench.assert_nothing_is_left();
}

#[test]
fn without_a_page_nothing_is_read_and_a_page_that_asks_for_nothing_has_no_picture() {
    let bench = Bench::new();
    let mut chain = bench.start(&["--rig", "cell"]);
    chain.wait_for_frames();
    let alone = readers(&bench, "cell");
    let viewing = Viewing::start(&bench, &["--rig", "cell"]);
    assert_eq!(readers(&bench, "cell"), alone);
    let mut page = Page::of(&viewing);
    page.status(|status| status["fps"].as_f64().is_some());
    // The page gets the rig's status, and no frame is copied for it.
    assert_eq!(readers(&bench, "cell"), [alone[0], alone[1], alone[2] + 1]);
    page.ask();
    page.moment();
    let all: Vec<u64> = alone.iter().map(|count| count + 1).collect();
    assert_eq!(readers(&bench, "cell"), all);
    drop(page);
    let mut left = readers(&bench, "cell");
    let deadline = std::time::Instant::now() + PATIENCE;
    while left != alone && std::time::Instant::now() < deadline {
        left = readers(&bench, "cell");
    }
    assert_eq!(left, alone);
    viewing.end();
    chain.signal_chain(Signal::INT);
    assert!(chain.end().status.success());
}

#[test]
fn a_page_goes_on_when_its_chain_is_restarted() {
    let bench = Bench::new();
    let viewing = Viewing::start(&bench, &["--rig", "cell"]);
    let mut page = Page::of(&viewing);
    let waits = |status: &Value| {
        status["obstacle"]
            .as_str()
            .is_some_and(|why| why.contains("lariat run --rig cell"))
    };
    page.status(waits);
    for _ in 0..2 {
        let chain = bench.start(&["--rig", "cell"]);
        page.ask();
        let (said, _) = page.moment();
        assert!(said["frame"].as_u64() >= Some(1));
        chain.signal_chain(Signal::INT);
        assert!(chain.end().status.success());
        page.status(waits);
    }
    viewing.end();
    bench.assert_nothing_is_left();
}

#[test]
fn a_lossless_chain_loses_nothing_to_a_page_that_asks_for_nothing_more() {
    let bench = Bench::new();
    let viewing = Viewing::start(&bench, &["--rig", "cell"]);
    let mut page = Page::of(&viewing);
    page.ask();
    let flags = [
        "--rig",
        "cell",
        "--lossless",
        "--fps",
        "max",
        "--frames",
        "400",
        "--out",
        "report",
    ];
    let ended = bench.start(&flags).end();
    assert!(ended.status.success(), "{}", ended.stderr);
    page.moment();
    assert_eq!(bench.summary("report")["frames"]["received"], 400);
    viewing.end();
}

#[test]
fn a_chain_that_waits_for_masks_says_so() {
    let bench = Bench::new();
    let chain = bench.start(&["--rig", "cell", "--mask", "external", "--fps", "30"]);
    let viewing = Viewing::start(&bench, &["--rig", "cell"]);
    let mut page = Page::of(&viewing);
    let status = page.status(|status| {
        let obstacle = status["obstacle"].as_str().unwrap_or_default();
        obstacle.contains("lariat/cell/masks")
    });
    assert_eq!(status["rig"], "cell");
    page::end(chain, viewing);
}
