//! A place to run the binary in. Each has its own domain, so that tests do not see each other and
//! leftovers are noticed.

use std::ffi::OsStr;
use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Output, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};

use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use tempfile::TempDir;

/// The tested program: `lariat`; in the tests of `bench/`, `lariat-bench`; and in those of
/// `crates/top`, the `lariat` next to `lariat-top`.
pub(crate) fn program() -> PathBuf {
    let own = option_env!("CARGO_BIN_EXE_lariat").or(option_env!("CARGO_BIN_EXE_lariat-bench"));
    let top = option_env!("CARGO_BIN_EXE_lariat-top");
    let program = own
        .map(PathBuf::from)
        .or_else(|| top.map(|top| Path::new(top).with_file_name("lariat")))
        .expect("cargo names the tested program");
    assert!(
        program.is_file(),
        "`cargo test --workspace` builds {} first",
        program.display()
    );
    program
}

/// A domain, and a folder for the files of a test.
pub(crate) struct Bench {
    pub(crate) domain: String,
    pub(crate) folder: TempDir,
}

impl Bench {
    pub(crate) fn new() -> Self {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let domain = format!(
            "t{}-{}",
            std::process::id(),
            NEXT.fetch_add(1, Ordering::Relaxed)
        );
        Self {
            domain,
            folder: TempDir::new().expect("a temporary folder"),
        }
    }

    pub(crate) fn command(&self, arguments: &[&str]) -> Command {
        self.command_of(program(), arguments)
    }

    /// A command that runs a copy of the binary.
    pub(crate) fn command_of(&self, binary: impl AsRef<OsStr>, arguments: &[&str]) -> Command {
        let mut command = Command::new(binary);
        command
            .args(arguments)
            .env("LARIAT_DOMAIN", &self.domain)
            .current_dir(self.folder.path())
            .stdin(Stdio::null());
        command
    }

    /// Runs a command to its end.
    pub(crate) fn run(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().expect("the binary runs")
    }

    /// Starts `lariat run` and waits until all its stages are up.
    pub(crate) fn start(&self, arguments: &[&str]) -> Running {
        self.start_command(self.command(&[&["run"], arguments].concat()))
    }

    /// Starts a prepared `lariat run` command and waits until all its stages are up.
    pub(crate) fn start_command(&self, mut command: Command) -> Running {
        let mut process = command
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the binary runs");
        let mut stderr = BufReader::new(process.stderr.take().expect("piped"));
        let mut introduction = String::new();
        while !introduction.contains('→') {
            let mut line = String::new();
            let read = stderr.read_line(&mut line).expect("readable");
            assert!(read > 0, "the chain did not come up: {introduction}");
            introduction += &line;
        }
        let ids = ["capture", "extract", "fit", "sink"].map(|stage| {
            // Stages may print messages before it.
            let line = introduction.lines().last().expect("a line");
            if stage == "capture" && line.contains("external →") {
                return 0;
            }
            let mut words = line.split_whitespace().skip_while(|word| *word != stage);
            words
                .nth(1)
                .and_then(|id| id.parse().ok())
                .expect("a process id")
        });
        Running {
            process,
            stderr,
            introduction,
            ids,
        }
    }

    /// A path in the test's folder.
    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Returns the summary that `--out FOLDER` wrote.
    pub(crate) fn summary(&self, folder: &str) -> Value {
        let text = fs::read_to_string(self.path(folder).join("summary.json")).expect("a summary");
        serde_json::from_str(&text).expect("JSON")
    }

    /// Checks that each frame that capture sent has arrived, or is counted as lost where it was
    /// lost.
    pub(crate) fn assert_every_frame_is_accounted_for(&self, folder: &str) {
        let frames = &self.summary(folder)["frames"];
        let count = |value: &Value| value.as_u64().expect("a count");
        let lost = &frames["lost"];
        let accounted = [
            &frames["received"],
            &lost["capture"],
            &lost["mask"],
            &lost["extract"],
            &lost["fit"],
            &lost["sink"],
        ];
        assert_eq!(
            count(&frames["published"]),
            accounted.into_iter().map(count).sum::<u64>(),
            "{frames}"
        );
    }

    /// Returns the names of files of this domain in shared memory and in the transport's folder.
    pub(crate) fn left_behind(&self) -> Vec<String> {
        let mut found = Vec::new();
        for entry in fs::read_dir("/dev/shm").expect("shared memory").flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            if name.starts_with(&format!("lariat_{}_", self.domain)) {
                found.push(name);
            }
        }
        let mut folders = vec![PathBuf::from(format!("/tmp/lariat-{}", self.domain))];
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(&folder).into_iter().flatten().flatten() {
                if entry.path().is_dir() {
                    folders.push(entry.path());
                } else {
                    found.push(entry.path().display().to_string());
                }
            }
        }
        found
    }

    pub(crate) fn assert_nothing_is_left(&self) {
        let left = self.left_behind();
        assert!(left.is_empty(), "left behind: {left:#?}");
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(format!("/tmp/lariat-{}", self.domain));
    }
}

/// A running chain.
pub(crate) struct Running {
    pub(crate) process: Child,
    stderr: BufReader<std::process::ChildStderr>,
    /// Its output before the stages were up.
    pub(crate) introduction: String,
    /// Process ids of capture (0 if frames come from elsewhere), extract, fit, sink.
    pub(crate) ids: [i32; 4],
}

/// Result of a chain that has ended.
pub(crate) struct Ended {
    pub(crate) status: ExitStatus,
    /// Its output before the stages were up.
    pub(crate) introduction: String,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Running {
    /// Waits until the sink reports that frames have arrived.
    pub(crate) fn wait_for_frames(&mut self) {
        // On a loaded machine, its first line may report none.
        self.wait_until(|said| {
            said.strip_suffix(" received, ")
                .is_some_and(|said| !said.ends_with(" 0"))
        });
    }

    /// Waits until the sink prints these words.
    pub(crate) fn wait_until_it_says(&mut self, words: &str) {
        self.wait_until(|said| said.ends_with(words));
    }

    /// Waits until the sink's output meets a condition.
    fn wait_until(&mut self, is_so: impl Fn(&str) -> bool) {
        let stdout = self.process.stdout.as_mut().expect("piped");
        let mut text = String::new();
        let mut byte = [0];
        while !is_so(&text) {
            assert_eq!(
                stdout.read(&mut byte).expect("readable"),
                1,
                "the chain ended: {text}"
            );
            text.push(byte[0].into());
        }
    }

    /// Reads messages until one contains these words.
    pub(crate) fn wait_for_message(&mut self, words: &str) {
        let mut line = String::new();
        while !line.contains(words) {
            line.clear();
            let read = self.stderr.read_line(&mut line).expect("readable");
            assert!(read > 0, "the chain ended without {words:?}");
        }
    }

    pub(crate) fn signal_chain(&self, signal: Signal) {
        send(self.process.id() as i32, signal);
    }

    pub(crate) fn signal_stage(&self, place: usize, signal: Signal) {
        send(self.ids[place], signal);
    }

    /// Waits for the end, and reads the output meanwhile.
    pub(crate) fn end(mut self) -> Ended {
        let mut stdout = self.process.stdout.take().expect("piped");
        let (out, err) = std::thread::scope(|scope| {
            let out = scope.spawn(|| {
                let mut text = Vec::new();
                stdout
                    .read_to_end(&mut text)
                    .map(|_| String::from_utf8_lossy(&text).into_owned())
            });
            let mut err = String::new();
            self.stderr.read_to_string(&mut err).expect("readable");
            (out.join().expect("no panic").expect("readable"), err)
        });
        Ended {
            status: self.process.wait().expect("waited for"),
            introduction: self.introduction,
            stdout: out,
            stderr: err,
        }
    }
}

pub(crate) fn send(id: i32, signal: Signal) {
    kill_process(Pid::from_raw(id).expect("a process id"), signal).expect("the process is there");
}

/// Waits until a process has a handler for SIGTERM.
pub(crate) fn wait_until_told_by_signals(id: u32) {
    let deadline = std::time::Instant::now() + std::time::Duration::from_secs(30);
    let handles_term = || {
        let status = fs::read_to_string(format!("/proc/{id}/status")).unwrap_or_default();
        let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:"));
        let caught = caught.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
        // Signal n is bit n − 1.
        caught.is_some_and(|mask| mask >> (Signal::TERM.as_raw() - 1) & 1 == 1)
    };
    while !handles_term() {
        assert!(
            std::time::Instant::now() < deadline,
            "process {id} never got ready"
        );
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
}

/// Waits until a process is gone.
pub(crate) fn wait_until_gone(id: i32) {
    let deadline = std::time::Instant::now() + std::time::Duration::from_secs(30);
    while fs::metadata(format!("/proc/{id}")).is_ok() {
        assert!(
            std::time::Instant::now() < deadline,
            "process {id} is still there"
        );
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
}
