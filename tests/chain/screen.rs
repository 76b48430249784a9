//! A real terminal, provided by tmux. Without tmux, the tests that need it say so and are skipped;
//! `.ci/run` installs it.

use std::process::{Command, Output};
use std::time::{Duration, Instant};

use crate::rig::{Bench, program};

/// A terminal of 80 columns and 24 rows with a shell in it.
pub(crate) struct Screen {
    socket: String,
}

pub(crate) fn is_tmux_here() -> bool {
    let is_here = Command::new("tmux").arg("-V").output().is_ok();
    if !is_here {
        eprintln!("tmux is not on this machine: nothing is tested in a terminal");
    }
    is_here
}

impl Screen {
    /// Runs a script in the bench's domain and folder, with the binary as `$LARIAT`.
    pub(crate) fn open(bench: &Bench, script: &str) -> Self {
        let screen = Self {
            socket: format!("lariat-{}", bench.domain),
        };
        let mut tmux = screen.tmux(&[
            "-f",
            "/dev/null",
            "new-session",
            "-d",
            "-x",
            "80",
            "-y",
            "24",
        ]);
        let domain = format!("LARIAT_DOMAIN={}", bench.domain);
        let lariat = format!("LARIAT={}", program().display());
        tmux.current_dir(bench.folder.path());
        tmux.args(["env", &domain, &lariat, "sh", "-c", script]);
        run(tmux);
        screen
    }

    pub(crate) fn tmux(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new("tmux");
        // -u allows it to draw all characters.
        command.args(["-u", "-L", &self.socket]).args(arguments);
        command.env("LC_ALL", "C.UTF-8").env_remove("TMUX");
        command
    }

    pub(crate) fn text(&self) -> String {
        let output = run(self.tmux(&["capture-pane", "-p"]));
        String::from_utf8_lossy(&output.stdout).into_owned()
    }

    /// Waits until the screen meets a condition.
    pub(crate) fn wait_for(&self, what: &str, is_so: impl Fn(&str) -> bool) -> String {
        let deadline = Instant::now() + Duration::from_secs(60);
        loop {
            let text = self.text();
            if is_so(&text) {
                return text;
            }
            assert!(Instant::now() < deadline, "{what} never came:\n{text}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    pub(crate) fn wait_for_text(&self, text: &str) -> String {
        self.wait_for(text, |screen| screen.contains(text))
    }

    pub(crate) fn keys(&self, keys: &str) {
        run(self.tmux(&["send-keys", keys]));
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        let _ = self.tmux(&["kill-server"]).output();
    }
}

pub(crate) fn run(mut command: Command) -> Output {
    let output = command.output().expect("tmux runs");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    output
}
