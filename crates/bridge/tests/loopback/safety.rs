//! Datagrams are accepted only from a side with the key, and invalid ones are refused.

use std::net::UdpSocket;
use std::path::PathBuf;
use std::process::Command as Process;
use std::time::{Duration, Instant};

use lariat_wire::Receiver;

use crate::sides::{Chain, PATIENCE, PROGRAM, Place, rig, take};

/// Makes a file with a key.
fn key(name: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("lariat-bridge-{name}-{}", std::process::id()));
    let made = Process::new(PROGRAM).arg("--make-key").arg(&path).status();
    assert!(made.expect("a process").success());
    path
}

#[test]
fn only_who_has_the_key_is_heard() {
    let keys = [key("one"), key("other")];
    let words = keys
        .each_ref()
        .map(|key| ["--key", key.to_str().expect("text")]);
    for (near_words, far_words, why) in [
        (&words[0][..], &words[0][..], None),
        (&words[0], &words[1], Some("another key")),
        (&words[0], &[], Some("--key FILE")),
        (&[], &words[0], Some("--key FILE")),
    ] {
        let place = Place::new();
        let (near, far) = (
            place.listen(near_words),
            place.connect(place.port, far_words),
        );
        let domain = place.far();
        let reader = Receiver::descriptors(&domain, &rig()).expect("a reader");
        let chain = Chain::start(&place);
        let mut count = 0;
        let until = Instant::now() + Duration::from_millis(1200);
        match why {
            None => {
                let came = std::cell::Cell::new(false);
                take(&reader, |_| came.set(true), || !came.get());
            }
            Some(_) => take(&reader, |_| count += 1, || Instant::now() < until),
        }
        assert_eq!(count, 0);
        let said = far.end() + &near.end();
        assert!(why.is_none_or(|why| said.contains(why)), "{said}");
        drop((reader, domain, chain));
    }
    for key in keys {
        std::fs::remove_file(key).expect("it is ours");
    }
}

#[test]
fn nobody_is_sent_more_than_it_sent_before_it_has_shown_its_address() {
    // Records a question of a far side, as any listener receives it.
    let recorder = UdpSocket::bind("127.0.0.1:0").expect("a port");
    recorder
        .set_read_timeout(Some(PATIENCE))
        .expect("it is ours");
    let port = recorder.local_addr().expect("a port").port();
    let other = Place::new();
    let asks = other.connect(port, &[]);
    let mut buffer = [0; 2000];
    let length = recorder.recv(&mut buffer).expect("a question");
    let question = buffer[..length].to_vec();
    asks.end();
    // Descriptors come to a far side that has proved its address.
    let place = Place::new();
    let (near, far) = (place.listen(&[]), place.connect(place.port, &[]));
    let domain = place.far();
    let reader = Receiver::descriptors(&domain, &rig()).expect("a reader");
    let chain = Chain::start(&place);
    let came = std::cell::Cell::new(false);
    take(&reader, |_| came.set(true), || !came.get());
    let stranger = UdpSocket::bind("127.0.0.1:0").expect("a port");
    let patience = Some(Duration::from_millis(50));
    stranger.set_read_timeout(patience).expect("it is ours");
    let (mut sent, mut got) = (0, 0);
    for _ in 0..20 {
        sent += stranger
            .send_to(&question, ("127.0.0.1", place.port))
            .expect("sent");
        while let Ok(length) = stranger.recv(&mut buffer) {
            got += length;
        }
    }
    assert!((length..=sent).contains(&got), "{got} for {sent}");
    far.end();
    near.end();
    drop((reader, domain, chain));
}

#[test]
fn what_makes_no_sense_is_refused_with_a_sentence() {
    for (words, code, sentence) in [
        (&["--listen", "udp/0.0.0.0:7447"][..], 2, "--make-key"),
        (&["--listen", "udp/127.0.0.1:7447"], 2, "--make-key"),
        (&["--connect", "udp/192.0.2.1:7447"], 2, "--insecure"),
        (&["--listen", "tcp/127.0.0.1:7447"], 2, "udp/192.168"),
        (
            &["--listen", "udp/192.0.2.1:7447", "--insecure"],
            1,
            "cannot be listened",
        ),
        (
            &["--connect", "udp/127.0.0.1:7447", "--key", "/nowhere"],
            1,
            "/nowhere",
        ),
    ] {
        let place = Place::new();
        let done = Process::new(PROGRAM)
            .args(words)
            .env("LARIAT_DOMAIN", &place.near)
            .output();
        let done = done.expect("a process");
        let said = String::from_utf8_lossy(&done.stderr);
        assert_eq!(done.status.code(), Some(code), "{said}");
        assert!(said.contains(sentence), "{said}");
    }
}
