//! Access to the page: who gets it and with what rights, and that input from others is harmless.

use std::fs::{self, Permissions};
use std::io::Write;
use std::net::TcpStream;
use std::os::unix::fs::PermissionsExt;
use std::os::unix::process::CommandExt;
use std::process::Command;

use rustix::process::{Signal, geteuid};
use tungstenite::Message;

use crate::page::{PROTOCOL, Page};
use crate::rig::Bench;
use crate::viewing::{Viewing, get, url_in};

#[test]
fn the_page_is_whole_and_needs_nothing_from_elsewhere() {
    let bench = Bench::new();
    let viewing = Viewing::start(&bench, &[]);
    let local = format!("Host: {}\r\n", viewing.host());
    let page = get(viewing.host(), "/", &local);
    assert!(page.starts_with("HTTP/1.1 200 "), "{page}");
    assert!(page.contains("Content-Security-Policy: default-src 'none'"));
    let mut waiting: Vec<String> = vec![page];
    let mut seen = std::collections::BTreeSet::new();
    while let Some(text) = waiting.pop() {
        let named = text.split('"').skip(1).step_by(2).filter(|word| {
            [".js", ".css", ".svg"]
                .iter()
                .any(|ending| word.ends_with(ending))
        });
        for name in named {
            assert!(!name.contains("//"), "{name} is elsewhere");
            let name = name.trim_start_matches("./").to_owned();
            if seen.insert(name.clone()) {
                let file = get(viewing.host(), &format!("/{name}"), &local);
                assert!(file.starts_with("HTTP/1.1 200 "), "{name}: {file}");
                waiting.push(file);
            }
        }
    }
    assert!(seen.len() > 5, "{seen:?}");
    assert!(get(viewing.host(), "/../Cargo.toml", &local).starts_with("HTTP/1.1 404 "));
    viewing.end();
}

#[test]
fn other_sites_and_other_names_are_refused_and_a_token_opens() {
    let bench = Bench::new();
    let viewing = Viewing::start(&bench, &[]);
    assert!(get(viewing.host(), "/", "Host: evil.example\r\n").starts_with("HTTP/1.1 403 "));
    for origin in ["https://evil.example", "null"] {
        assert!(
            Page::open(&viewing.url, Some(origin), PROTOCOL).is_err(),
            "{origin}"
        );
    }
    let own = viewing.url.trim_end_matches('/');
    assert!(Page::open(&viewing.url, Some(own), PROTOCOL).is_ok());
    assert!(Page::open(&viewing.url, None, "unknown.v1").is_err());
    viewing.end();

    let open = Viewing::start(&bench, &["--listen", "0.0.0.0"]);
    let port = open.host().rsplit(':').next().expect("a port");
    let token = open
        .url
        .trim_end_matches('/')
        .rsplit('/')
        .next()
        .expect("a token");
    assert_eq!(token.len(), 32);
    let here = format!("127.0.0.1:{port}");
    let local = format!("Host: {here}\r\n");
    assert!(get(&here, "/", &local).starts_with("HTTP/1.1 403 "));
    assert!(get(&here, &format!("/{token}/"), &local).starts_with("HTTP/1.1 200 "));
    assert!(Page::open(&format!("http://{here}/"), None, PROTOCOL).is_err());
    let address = format!("http://{here}/{token}/");
    assert!(Page::open(&address, Some("https://elsewhere.example"), PROTOCOL).is_ok());
    open.end();
}

/// Only root can act as two users; otherwise this test reports that it was skipped.
#[test]
fn another_user_of_this_machine_needs_the_token() {
    if !geteuid().is_root() {
        eprintln!("left out: only root can run lariat as another user");
        return;
    }
    let bench = Bench::new();
    // A user that no other test uses, below 65,536, which is the limit in containers.
    let user = 30_000 + std::process::id() % 5_000;
    fs::set_permissions(bench.folder.path(), Permissions::from_mode(0o777)).expect("its folder");
    // Other users may not have access to cargo's folder.
    fs::copy(env!("CARGO_BIN_EXE_lariat"), bench.path("lariat")).expect("copied");
    let mut command = bench.command_of(bench.path("lariat"), &["view", "--port", "0", "-v"]);
    command.env_remove("LARIAT_DOMAIN").uid(user).gid(user);
    let (viewing, mut said) = Viewing::start_command(command);
    let local = format!("Host: {}\r\n", viewing.host());
    let refused = get(viewing.host(), "/", &local);
    assert!(
        refused.starts_with("HTTP/1.1 403 ") && refused.contains("another user's"),
        "{refused}"
    );
    let own = viewing.url.trim_end_matches('/').to_owned();
    assert!(Page::open(&viewing.url, Some(&own), PROTOCOL).is_err());
    // The owner is admitted however many connections others hold.
    let silent: Vec<_> = (0..100)
        .map(|_| TcpStream::connect(viewing.host()))
        .collect();
    let (_, port) = viewing.host().split_once(':').expect("a port");
    let ask = format!(
        "exec 3<>/dev/tcp/127.0.0.1/{port}; printf 'GET / HTTP/1.1\\r\\nHost: {}\\r\\n\\r\\n' >&3; head -n 1 <&3",
        viewing.host()
    );
    let owner = Command::new("bash")
        .args(["-c", &ask])
        .uid(user)
        .gid(user)
        .output();
    let answer = owner.expect("bash runs").stdout;
    let answer = String::from_utf8_lossy(&answer).into_owned();
    assert!(answer.starts_with("HTTP/1.1 200 "), "{answer}");
    drop(silent);
    let with_token = url_in(&mut said);
    assert!(with_token.len() > viewing.url.len() + 30, "{with_token}");
    assert!(Page::open(&with_token, Some(&own), PROTOCOL).is_ok());
    viewing.end();
    let _ = fs::remove_dir_all(format!("/tmp/lariat-{user}"));
}

#[test]
fn what_is_no_request_harms_nobody_else() {
    let bench = Bench::new();
    let mut chain = bench.start(&["--rig", "cell"]);
    chain.wait_for_frames();
    let viewing = Viewing::start(&bench, &["--rig", "cell"]);
    let mut page = Page::of(&viewing);
    // A client that is silent, one that stops in the middle, one that sends nonsense, and one that
    // never reads.
    let silent = TcpStream::connect(viewing.host()).expect("it listens");
    let mut half = TcpStream::connect(viewing.host()).expect("it listens");
    half.write_all(b"GET / HT").expect("sent");
    let mut nonsense = TcpStream::connect(viewing.host()).expect("it listens");
    nonsense.write_all(&[0xff; 3000]).expect("sent");
    let mut deaf = Page::of(&viewing);
    (0..20).for_each(|_| deaf.ask());
    for _ in 0..3 {
        page.ask();
        page.moment();
    }
    // A flood closes the connection that sends it.
    let mut flood = Page::of(&viewing);
    let is_ended = (0..100_000).any(|_| flood.0.send(Message::text("{}")).is_err());
    assert!(is_ended);
    page.ask();
    page.moment();
    drop((silent, half, nonsense, deaf));
    viewing.end();
    chain.signal_chain(Signal::INT);
    assert!(chain.end().status.success());
}
