//! Channels and the processes at their ends are listed without joining them.

use lariat_wire::*;

/// A domain that no other test run shares.
fn domain() -> Domain {
    Domain::named(&format!("s{}", std::process::id())).expect("a domain")
}

/// The channels of one rig, because concurrent tests share the process's domain.
fn channels(domain: &Domain, rig: &Rig) -> Vec<ChannelState> {
    let all = domain.channels().expect("listed");
    all.into_iter().filter(|state| state.rig == *rig).collect()
}

#[test]
fn a_channel_is_listed_with_its_writer_its_readers_and_its_memory() {
    let (domain, rig): (_, Rig) = (domain(), "ends".parse().expect("a name"));
    let me = std::process::id();
    let _reader = Receiver::descriptors(&domain, &rig).expect("a reader");
    let before = channels(&domain, &rig);
    assert_eq!(before.len(), 1);
    let ends = before[0].ends.clone().expect("its own version");
    assert_eq!((ends.writer, ends.readers), (None, vec![me]));

    let writer = Writer::<Descriptors>::create(&domain, &rig, &DESCRIPTORS, &Delivery::NewestWins);
    let writer = writer.expect("a writer");
    let frames = Writer::frames(&domain, &rig, &Delivery::NewestWins, 1000).expect("a writer");
    let now = channels(&domain, &rig);
    let names: Vec<&str> = now.iter().map(|state| state.channel).collect();
    assert_eq!(names, ["frames", "descriptors"], "in the order of the way");
    let image = now[0].ends.as_ref().and_then(|ends| ends.writer.clone());
    let image = image.expect("there");
    assert_eq!((image.pid, image.message_bytes), (me, 1000));
    assert!(image.shared_bytes > image.slots as u64 * 1000);
    assert_eq!(now[0].message, "u8 with lariat.FrameHeader.v3");
    assert_eq!(now[1].message, "lariat.Descriptors.v9");
    assert_eq!((now[1].lossless, now[1].buffer), (false, 8));
    let shape = now[1].ends.as_ref().and_then(|ends| ends.writer.clone());
    assert_eq!(
        shape.expect("there").message_bytes,
        size_of::<Descriptors>()
    );
    drop((writer, frames));
    assert_eq!(channels(&domain, &rig), before);
}

#[test]
fn looking_makes_nothing_and_keeps_nothing() {
    let (domain, rig): (_, Rig) = (domain(), "looking".parse().expect("a name"));
    assert_eq!(domain.channel(&rig, "descriptors"), None);
    let reader = Receiver::descriptors(&domain, &rig).expect("a reader");
    assert!(domain.channel(&rig, "descriptors").is_some());
    assert_eq!(domain.channel(&rig, "no such channel"), None);
    drop(reader);
    assert_eq!(
        domain.channel(&rig, "descriptors"),
        None,
        "it went with its reader"
    );
}
