//! The message package of `lariat ros2` (`ros/lariat_msgs`), which has no tests of its own.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use lariat_record::{Losses, Record};
use lariat_wire::{Centerlines, Descriptors, Descriptors3, FrameHeader};

/// Collects the messages that a schema of lariat needs, including itself.
fn with_parts(message: &str, into: &mut BTreeSet<String>) {
    if !into.insert(message.to_owned()) {
        return;
    }
    let path = repository().join(format!("crates/record/schemas/{message}.msg"));
    let schema = fs::read_to_string(path).expect("a schema");
    for part in schema.split("lariat_msgs/").skip(1) {
        let name: String = part
            .chars()
            .take_while(char::is_ascii_alphanumeric)
            .collect();
        with_parts(&name, into);
    }
}

fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn the_package_of_messages_has_those_of_recordings_and_all_that_they_are_made_of() {
    let mut meant = BTreeSet::new();
    for whole in [
        Descriptors::SCHEMA,
        Descriptors3::SCHEMA,
        Centerlines::SCHEMA,
        FrameHeader::SCHEMA,
        Losses::SCHEMA,
    ] {
        let message = whole
            .name
            .strip_prefix("lariat_msgs/msg/")
            .expect("lariat's");
        with_parts(message, &mut meant);
    }
    let cmake = fs::read_to_string(repository().join("ros/lariat_msgs/CMakeLists.txt"));
    let cmake = cmake.expect("the package's");
    let (_, list) = cmake.split_once("set(messages").expect("a list");
    let (list, _) = list.split_once(')').expect("its end");
    let listed: BTreeSet<String> = list.split_whitespace().map(str::to_owned).collect();
    assert_eq!(listed, meant);
}
