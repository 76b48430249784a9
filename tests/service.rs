//! `lariat service`: the files that it writes and those that it leaves alone. If systemd is
//! installed, it also checks the unit. `crates/chain/src/notify.rs` has the tests of the manager's
//! protocol.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

use tempfile::TempDir;

const UNIT: &str = "usr/lib/systemd/system/lariat@.service";

/// Runs the command on a package's root.
fn service(root: &Path, words: &[&str]) -> Result<String, String> {
    let root = ["--root", root.to_str().expect("a plain path")];
    outcome(lariat().arg("service").args(words).args(root))
}

fn lariat() -> Command {
    Command::new(env!("CARGO_BIN_EXE_lariat"))
}

fn outcome(command: &mut Command) -> Result<String, String> {
    let output = command.output().expect("the binary runs");
    let text = |bytes| String::from_utf8(bytes).expect("text");
    match output.status.success() {
        true => Ok(text(output.stdout)),
        false => Err(text(output.stderr)),
    }
}

fn read(path: impl AsRef<Path>) -> String {
    fs::read_to_string(path).expect("a file")
}

fn is_there(program: &str) -> bool {
    Command::new(program).arg("--version").output().is_ok()
}

#[test]
fn what_is_installed_is_a_unit_and_settings_that_are_good() {
    let root = TempDir::new().expect("a folder");
    let said = service(root.path(), &["install", "--rig", "cell"]).expect("installed");
    let settings = root.path().join("etc/lariat/cell.toml");
    assert!(
        said.contains("etc/lariat/cell.toml: name the camera"),
        "{said}"
    );
    outcome(lariat().args(["config", "check"]).arg(&settings)).expect("good settings");
    let unit = read(root.path().join(UNIT));
    for line in [
        "Type=notify",
        "ExecStart=/usr/bin/lariat run --config %E/lariat/%i.toml --rig %i --daemon",
        "PrivateTmp=no",
        "User=lariat",
    ] {
        assert!(unit.lines().any(|found| found == line), "{line}\n{unit}");
    }
    let shown = service(root.path(), &["show", "--rig", "cell"]).expect("shown");
    assert_eq!(shown, unit);
}

#[test]
fn settings_are_never_overwritten_and_outlive_the_unit() {
    let root = TempDir::new().expect("a folder");
    let settings = root.path().join("etc/lariat/cell.toml");
    fs::create_dir_all(settings.parent().expect("a folder")).expect("made");
    fs::write(&settings, "[fit]\ncontrol_points = 6\n").expect("written");
    for words in [
        &["install", "--rig", "cell"],
        &["uninstall", "--rig", "cell"],
    ] {
        let said = service(root.path(), words).expect("done");
        assert!(said.contains("kept"), "{said}");
        assert_eq!(read(&settings), "[fit]\ncontrol_points = 6\n");
    }
    assert!(!root.path().join(UNIT).exists());
    let said = service(root.path(), &["uninstall"]).expect_err("nothing is there");
    assert!(said.contains("nothing to take away"), "{said}");
}

#[test]
fn the_unit_stays_as_long_as_another_rig_needs_it() {
    let root = TempDir::new().expect("a folder");
    service(root.path(), &["install"]).expect("installed");
    let unit = root.path().join(UNIT);
    let wants = unit.with_file_name("multi-user.target.wants");
    fs::create_dir(&wants).expect("made");
    for rig in ["left", "right"] {
        symlink(&unit, wants.join(format!("lariat@{rig}.service"))).expect("linked");
    }
    let said = service(root.path(), &["uninstall", "--rig", "left"]).expect("done");
    assert!(said.contains("serves right too"), "{said}");
    assert!(unit.exists());
    fs::remove_file(wants.join("lariat@left.service")).expect("removed");
    service(root.path(), &["uninstall", "--rig", "right"]).expect("done");
    assert!(!unit.exists());
}

#[test]
fn a_unit_of_lariat_is_written_anew_and_one_of_another_is_not_touched() {
    let root = TempDir::new().expect("a folder");
    service(root.path(), &["install", "--as", "ann"]).expect("installed");
    service(root.path(), &["install", "--as", "bob"]).expect("installed again");
    let unit = root.path().join(UNIT);
    assert!(read(&unit).contains("User=bob"));
    fs::write(&unit, "[Service]\nExecStart=/bin/true\n").expect("written");
    for word in ["install", "uninstall"] {
        let said = service(root.path(), &[word]).expect_err("it is another's");
        assert!(said.contains("was not written by lariat"), "{said}");
        assert!(read(&unit).contains("/bin/true"));
    }
}

#[test]
fn a_user_has_a_unit_and_settings_of_their_own() {
    let home = TempDir::new().expect("a folder");
    let of_user = |words: &[&str]| {
        let mut command = lariat();
        command.args(words).env("HOME", home.path());
        // With this PATH, the systemd of the person who tests is not notified, either.
        outcome(
            command
                .env_remove("XDG_CONFIG_HOME")
                .env("PATH", home.path()),
        )
    };
    let unit = of_user(&["service", "show", "--user"]).expect("shown");
    assert!(unit.contains(env!("CARGO_BIN_EXE_lariat")), "{unit}");
    assert!(unit.contains("WantedBy=default.target"), "{unit}");
    assert!(!unit.contains("User="), "{unit}");
    if Path::new("/run/systemd/system").exists() {
        return;
    }
    let said = of_user(&["service", "install", "--user", "--rig", "desk"]).expect("installed");
    assert!(
        said.contains("systemctl --user enable --now lariat@desk"),
        "{said}"
    );
    let config = home.path().join(".config");
    assert_eq!(read(config.join("systemd/user/lariat@.service")), unit);
    assert!(config.join("lariat/desk.toml").exists());
}

#[test]
fn what_cannot_be_installed_is_refused_with_what_to_do() {
    let root = TempDir::new().expect("a folder");
    let said = service(
        root.path(),
        &["install", "--as", "ann\nExecStartPre=/bin/sh"],
    );
    assert!(said.expect_err("no name").contains("is not a user name"));
    let said = service(root.path(), &["install", "--rig", "../cell"]);
    assert!(said.expect_err("no rig").contains("../cell"));
    fs::write(root.path().join("usr"), "a file").expect("written");
    let said = service(root.path(), &["install"]).expect_err("no folder");
    assert!(said.contains("cannot be made"), "{said}");
}

/// Writes the units of the machine and of a user, which start this binary.
fn units(folder: &Path) -> [std::path::PathBuf; 2] {
    [&[][..], &["--user"]].map(|words| {
        let text = outcome(lariat().args(["service", "show"]).args(words)).expect("shown");
        let folder = folder.join(words.join(""));
        fs::create_dir_all(&folder).expect("made");
        let unit = folder.join("lariat@cell.service");
        fs::write(&unit, text).expect("written");
        unit
    })
}

#[test]
fn systemd_finds_nothing_to_complain_of() {
    if !is_there("systemd-analyze") {
        return;
    }
    let folder = TempDir::new().expect("a folder");
    for unit in units(folder.path()) {
        let mut command = Command::new("systemd-analyze");
        let output = command.args(["verify", "--man=no"]).arg(&unit).output();
        let output = output.expect("it runs");
        // systemd-analyze also reports on the machine's other units.
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        let of_ours: Vec<_> = said
            .lines()
            .filter(|line| line.contains("lariat"))
            .collect();
        assert!(output.status.success() && of_ours.is_empty(), "{said}");
    }
}

#[test]
fn the_unit_of_the_machine_is_fenced_in() {
    if !is_there("systemd-analyze") {
        return;
    }
    let folder = TempDir::new().expect("a folder");
    let [unit, _] = units(folder.path());
    let mut command = Command::new("systemd-analyze");
    // The threshold is out of 100, on systemd's own scale. systemd calls 25 "OK", and a unit
    // without restrictions has 96.
    command.args(["security", "--offline=true", "--threshold=25", "--no-pager"]);
    let output = command.arg(&unit).output().expect("it runs");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stdout)
    );
}
