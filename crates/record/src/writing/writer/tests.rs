use super::*;
use proptest::prelude::*;

const TOPICS: [Topic; 3] = [Topic::Image, Topic::Centerlines, Topic::Losses];

fn head() -> Head {
    Head {
        rig: "left".into(),
        about: BTreeMap::from([("version".into(), "0".into())]),
    }
}

/// A message that contains its number.
fn cdr(number: usize, bytes: usize) -> Vec<u8> {
    let mut cdr = vec![0; bytes.max(8)];
    cdr[..8].copy_from_slice(&(number as u64).to_le_bytes());
    // A compressible pattern.
    for (i, byte) in cdr[8..].iter_mut().enumerate() {
        *byte = (i * (number + 7) / 3) as u8;
    }
    cdr
}

fn read(path: &Path) -> Vec<(String, u32, u64, Vec<u8>)> {
    let bytes = std::fs::read(path).unwrap();
    let messages = mcap::MessageStream::new(&bytes).unwrap();
    messages
        .map(|message| {
            let message = message.unwrap();
            let topic = message.channel.topic.clone();
            (
                topic,
                message.sequence,
                message.log_time,
                message.data.to_vec(),
            )
        })
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn what_is_written_is_read_and_takes_no_more_room_than_was_reserved(
        sizes in prop::collection::vec((0..3_usize, 0..300_000_usize), 0..60),
        compression in prop::sample::select(vec![Compression::None, Compression::Lz4, Compression::Zstd]),
    ) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.mcap");
        let mut writer = Writer::create(&path, Existing::Keep, &head(), compression).unwrap();
        let mut expected = Vec::new();
        for (number, &(topic, bytes)) in sizes.iter().enumerate() {
            let (topic, cdr) = (TOPICS[topic], cdr(number, bytes));
            writer.write(topic, number as u32, 1000 + number as u64, &cdr).unwrap();
            expected.push((topic.on("left"), number as u32, 1000 + number as u64, cdr));
        }
        // Computes the same upper bound of the file's length as the writer, with no more messages
        // to come.
        let bound = writer.committed.load(Ordering::Relaxed)
            + compression.bound(writer.staged_bytes)
            + CHUNK_HEAD_BYTES
            + writer.summary_bytes;
        let written = writer.finish().unwrap();
        prop_assert_eq!(read(&path), expected);
        prop_assert_eq!(written.messages.iter().sum::<u64>(), sizes.len() as u64);
        prop_assert_eq!(written.bytes, std::fs::metadata(&path).unwrap().len());
        prop_assert!(written.bytes <= bound, "{} of {bound}", written.bytes);
        let bytes = std::fs::read(&path).unwrap();
        let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
        prop_assert_eq!(summary.stats.unwrap().message_count, sizes.len() as u64);
        prop_assert_eq!(summary.metadata_indexes.len(), 1);
    }
}

#[test]
fn bytes_without_any_pattern_fit_into_what_was_reserved_too() {
    for compression in [Compression::None, Compression::Lz4, Compression::Zstd] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.mcap");
        let mut writer = Writer::create(&path, Existing::Keep, &head(), compression).unwrap();
        let mut state = 1_u64;
        let mut noise = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 56) as u8
        };
        let cdr: Vec<u8> = (0..3_000_000).map(|_| noise()).collect();
        writer.write(Topic::Image, 1, 1, &cdr).unwrap();
        let bound = writer.committed.load(Ordering::Relaxed)
            + compression.bound(writer.staged_bytes)
            + CHUNK_HEAD_BYTES
            + writer.summary_bytes;
        let written = writer.finish().unwrap();
        assert!(written.bytes <= bound, "{} of {bound}", written.bytes);
        assert_eq!(read(&path)[0].3, cdr);
    }
}

#[test]
fn whole_chunks_are_in_the_file_before_it_is_closed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let mut writer = Writer::create(&path, Existing::Keep, &head(), Compression::None).unwrap();
    let message = cdr(0, 1 << 17);
    for number in 0..10 {
        writer
            .write(Topic::Image, number, number.into(), &message)
            .unwrap();
    }
    // A kill would leave the file like this: two chunks of four messages, and nothing of a third.
    let bytes = std::fs::read(&path).unwrap();
    let mut whole = 0;
    for record in mcap::read::ChunkFlattener::new_with_options(
        &bytes,
        mcap::read::Options::IgnoreEndMagic.into(),
    )
    .unwrap()
    {
        whole += u32::from(matches!(
            record.unwrap(),
            mcap::records::Record::Message { .. }
        ));
    }
    assert_eq!(whole, 8);
    assert_eq!(writer.finish().unwrap().messages[Topic::Image as usize], 10);
    assert_eq!(read(&path).len(), 10);
}

#[test]
fn what_is_attached_and_said_is_in_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let mut writer = Writer::create(&path, Existing::Keep, &head(), Compression::Lz4).unwrap();
    writer.write(Topic::Losses, 0, 5, &cdr(0, 100)).unwrap();
    writer
        .attach("lariat.toml", "application/toml", 7, b"[fit]\n")
        .unwrap();
    writer
        .about(&BTreeMap::from([("end".into(), "well".into())]))
        .unwrap();
    writer.finish().unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    assert_eq!(summary.metadata_indexes.len(), 2);
    let attachment = mcap::read::attachment(&bytes, &summary.attachment_indexes[0]).unwrap();
    assert_eq!(attachment.name, "lariat.toml");
    assert_eq!(&attachment.data[..], b"[fit]\n");
}

#[test]
fn a_recording_is_replaced_only_if_that_was_said_and_nothing_else_ever() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let create = |existing| Writer::create(&path, existing, &head(), Compression::None);
    let first = create(Existing::Keep).unwrap();
    // While the recording is being written, its file is in use.
    assert!(matches!(
        create(Existing::Replace),
        Err(WriteError::InUse(_))
    ));
    first.finish().unwrap();
    assert!(matches!(create(Existing::Keep), Err(WriteError::Exists(_))));
    let mut second = create(Existing::Replace).unwrap();
    second.write(Topic::Frames, 0, 1, &cdr(0, 50)).unwrap();
    second.finish().unwrap();
    assert_eq!(read(&path).len(), 1);
    std::fs::write(&path, "a letter").unwrap();
    for existing in [Existing::Keep, Existing::Replace] {
        assert!(matches!(create(existing), Err(WriteError::NoRecording(_))));
    }
    assert_eq!(std::fs::read(&path).unwrap(), b"a letter");
    let nowhere = folder.path().join("no/such/folder.mcap");
    let outcome = Writer::create(&nowhere, Existing::Keep, &head(), Compression::None);
    assert!(matches!(outcome, Err(WriteError::Begin { .. })));
}

#[test]
fn an_old_recording_is_there_until_the_new_one_has_something_in_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let create = |existing| Writer::create(&path, existing, &head(), Compression::None).unwrap();
    let mut first = create(Existing::Keep);
    first.write(Topic::Frames, 0, 1, &cdr(0, 50)).unwrap();
    first.finish().unwrap();
    let old = std::fs::read(&path).unwrap();

    // Losses are written even if nothing else came.
    let mut empty = create(Existing::Replace);
    empty.write(Topic::Losses, 0, 1, &cdr(0, 50)).unwrap();
    assert!(empty.finish().unwrap().kept_old);
    drop(create(Existing::Replace));
    assert_eq!(std::fs::read(&path).unwrap(), old);

    let mut full = create(Existing::Replace);
    full.write(Topic::Frames, 0, 2, &cdr(1, 50)).unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), old);
    full.about(&BTreeMap::new()).unwrap();
    // From here on, a killed writer leaves the new recording.
    assert_ne!(std::fs::read(&path).unwrap(), old);
    assert!(!full.finish().unwrap().kept_old);
    assert_eq!(read(&path).len(), 1);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn what_is_no_file_is_written_into() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pipe");
    let permissions = rustix::fs::Mode::from_bits_truncate(0o600);
    rustix::fs::mknodat(
        rustix::fs::CWD,
        &path,
        rustix::fs::FileType::Fifo,
        permissions,
        0,
    )
    .unwrap();
    let reader = {
        let path = path.clone();
        std::thread::spawn(move || std::fs::read(path).unwrap())
    };
    let mut writer = Writer::create(&path, Existing::Keep, &head(), Compression::Lz4).unwrap();
    for number in 0..3 {
        let message = cdr(number as usize, 5_000);
        writer.write(Topic::Frames, number, 1, &message).unwrap();
        writer.about(&BTreeMap::new()).unwrap();
    }
    writer.finish().unwrap();
    let bytes = reader.join().unwrap();
    std::fs::write(folder.path().join("a.mcap"), bytes).unwrap();
    assert_eq!(read(&folder.path().join("a.mcap")).len(), 3);
}

#[test]
fn after_the_end_nothing_is_reserved_any_more() {
    use std::os::unix::fs::MetadataExt;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let mut writer = Writer::create(&path, Existing::Keep, &head(), Compression::None).unwrap();
    writer.write(Topic::Losses, 0, 1, &cdr(0, 50)).unwrap();
    let written = writer.finish().unwrap();
    let blocks_bytes = std::fs::metadata(&path).unwrap().blocks() * 512;
    assert!(blocks_bytes < written.bytes + (1 << 20), "{blocks_bytes}");
}
