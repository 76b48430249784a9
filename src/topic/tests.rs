use super::*;

fn state(rig: &str) -> ChannelState {
    ChannelState {
        rig: rig.parse().expect("a name"),
        channel: "descriptors",
        message: String::new(),
        ours: String::new(),
        lossless: false,
        buffer: 8,
        most_readers: 24,
        ends: None,
    }
}

#[test]
fn the_rig_is_the_one_asked_for_the_usual_one_or_the_only_one() {
    let chosen = |wanted: Option<&str>, there: &[&str]| {
        let states: Vec<_> = there.iter().map(|rig| state(rig)).collect();
        let wanted = wanted.map(|name| name.parse().expect("a name"));
        choose_rig(wanted, &states)
            .map(|rig| rig.to_string())
            .map_err(|error| error.to_string())
    };
    assert_eq!(
        chosen(Some("left"), &["left", "right"]).as_deref(),
        Ok("left")
    );
    assert_eq!(
        chosen(None, &["default", "right"]).as_deref(),
        Ok("default")
    );
    assert_eq!(chosen(None, &["right"]).as_deref(), Ok("right"));
    let error = chosen(None, &["left", "right"]).expect_err("two");
    assert_eq!(error, "say which rig with --rig NAME: there is left, right");
    let error = chosen(Some("up"), &["left"]).expect_err("another");
    assert_eq!(error, "there is no rig up here: there is left");
    let error = chosen(None, &[]).expect_err("none");
    assert!(error.contains("start one with `lariat run`"), "{error}");
}
