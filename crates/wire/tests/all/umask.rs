//! Files of other threads get the right permissions while threads open readers.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::process::Command;
use std::thread;

use lariat_wire::*;

#[test]
fn readers_are_opened_beside_threads_that_make_files() {
    // Runs in a separate process, so that other tests keep their umask.
    let opener = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "umask::opener", "--include-ignored"])
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&opener.stdout);
    assert!(opener.status.success(), "{said}");
}

#[test]
#[ignore = "it is started by the test before"]
fn opener() {
    let id = std::process::id();
    let folder = std::env::temp_dir().join(format!("umask-{id}"));
    let mode_of_new = || {
        fs::create_dir(&folder).unwrap();
        let mode = fs::metadata(&folder).unwrap().permissions().mode();
        fs::remove_dir(&folder).unwrap();
        mode
    };
    let before = mode_of_new();
    let open = move |i| {
        let name = format!("u{i}-{id}");
        let domain = Domain::named(&name).unwrap();
        for _ in 0..20 {
            Receiver::descriptors(&domain, &Rig::default()).unwrap();
        }
        drop(domain);
        let _ = fs::remove_dir_all(format!("/tmp/lariat-{name}"));
    };
    let openers = [0, 1, 2].map(|i| thread::spawn(move || open(i)));
    let mut meanwhile = Vec::new();
    while !openers.iter().all(|opener| opener.is_finished()) {
        meanwhile.push(mode_of_new());
    }
    for opener in openers {
        opener.join().unwrap();
    }
    assert!(meanwhile.iter().all(|&mode| mode == before));
    assert_eq!(mode_of_new(), before);
}
