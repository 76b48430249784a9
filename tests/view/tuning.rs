//! Changes by a page: picked colors, settings, and dropped pictures.

use serde_json::json;
use tungstenite::Message;

use crate::page::{Page, asked, end, shown};
use crate::rig::Bench;

#[test]
fn a_page_picks_a_colour_and_changes_settings_that_can_be_kept() {
    let bench = Bench::new();
    std::fs::write(bench.path("lariat.toml"), "# mine\n[fit]\nfilter = true\n").expect("written");
    let (chain, viewing, mut page) = shown(&bench, &[]);
    page.ask();
    let (said, _) = page.moment();
    let on_rope = &said["ropes"][0]["points"][60];
    let pick = json!({"wish": "pick", "number": said["number"], "at": [on_rope]});
    page.0
        .send(Message::text(asked(2, pick).to_string()))
        .expect("sent");
    let mask = image::load_from_memory(&page.mask())
        .expect("a PNG")
        .into_luma8();
    let white = mask.pixels().filter(|pixel| pixel.0 == [255]).count();
    assert!((1_000..40_000).contains(&white), "{white} pixels are rope");
    let at = |i: usize| on_rope[i].as_f64().expect("a number").round() as u32;
    assert_eq!(mask.get_pixel(at(0), at(1)).0, [255]);
    // There is no rope on the table.
    let table = page.wish(json!({"wish": "pick", "number": said["number"], "at": [[2, 2]]}));
    assert!(table.is_err(), "{table:?}");
    let old = page.wish(json!({"wish": "pick", "number": 0, "at": []}));
    assert!(old.expect_err("no such frame").contains("too old"));

    let changes = json!(["extract.ropes=2", "extract.mask=network"]);
    let answer = page
        .wish(json!({"wish": "set", "changes": changes}))
        .expect("taken");
    assert!(
        answer
            .as_str()
            .is_some_and(|said| said.contains("extract.ropes")),
        "{answer}"
    );
    let settings = page.wish(json!({"wish": "settings"})).expect("settings");
    assert_eq!(
        (&settings["extract"]["ropes"], &settings["fit"]["filter"]),
        (&json!(2), &json!(true))
    );
    for wrong in [
        "extract.ropes=99",
        "extract.rpoes=1",
        "extract.ropes=1\nrestart fit",
    ] {
        let refused = page.wish(json!({"wish": "set", "changes": [wrong]}));
        assert!(refused.is_err(), "{wrong}: {refused:?}");
    }
    page.wish(json!({"wish": "keep", "changes": changes}))
        .expect("kept");
    let kept = std::fs::read_to_string(bench.path("lariat.toml")).expect("the file");
    assert_eq!(
        kept,
        "# mine\n[fit]\nfilter = true\n\n[extract]\nropes = 2\nmask = \"network\"\n"
    );
    end(chain, viewing);
}

#[test]
fn a_picture_that_is_dropped_is_traced() {
    let bench = Bench::new();
    let (chain, viewing, mut page) = shown(&bench, &[]);
    let picture =
        std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/rope.png")).expect("there");
    page.0.send(Message::binary(picture)).expect("sent");
    let (traced, _) = page.moment();
    assert_eq!(traced["number"], 0);
    assert_eq!(traced["ropes"].as_array().expect("ropes").len(), 1);
    page.0.send(Message::binary(vec![7; 100])).expect("sent");
    let why = loop {
        if let Message::Text(text) = page.0.read().expect("a message in time")
            && text.contains("undropped")
        {
            break text;
        }
    };
    assert!(why.contains("not a picture"), "{why}");
    end(chain, viewing);
}

#[test]
fn one_that_does_not_say_that_it_is_our_own_page_may_look_only() {
    let bench = Bench::new();
    let (chain, viewing, _) = shown(&bench, &[]);
    let mut page = Page::of(&viewing);
    for wish in ["set", "keep"] {
        let refused = page.wish(json!({"wish": wish, "changes": ["extract.ropes=3"]}));
        assert!(refused.expect_err("refused").contains("may not change"));
    }
    end(chain, viewing);
}
