//! A running `lariat view`, and plain requests to it.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, ChildStderr, Command, Stdio};

use rustix::process::Signal;

use crate::rig::{Bench, send};

/// A running `lariat view`.
pub(crate) struct Viewing {
    pub(crate) process: Child,
    /// `http://HOST:PORT/`, possibly with a token.
    pub(crate) url: String,
}

impl Viewing {
    pub(crate) fn start(bench: &Bench, arguments: &[&str]) -> Self {
        let arguments = [&["view"], arguments, &["--port", "0"]].concat();
        Self::start_command(bench.command(&arguments)).0
    }

    /// Starts a prepared command and reads the page's address. Also returns the rest of its output.
    pub(crate) fn start_command(mut command: Command) -> (Self, BufReader<ChildStderr>) {
        let command = command.stderr(Stdio::piped());
        let mut process = command.spawn().expect("the binary runs");
        let mut said = BufReader::new(process.stderr.take().expect("piped"));
        let url = url_in(&mut said);
        (Self { process, url }, said)
    }

    /// Returns the part between `http://` and the path.
    pub(crate) fn host(&self) -> &str {
        host(&self.url)
    }

    pub(crate) fn end(mut self) {
        send(self.process.id() as i32, Signal::TERM);
        assert!(self.process.wait().expect("waited for").success());
    }
}

/// Also cleans up after a failed test.
impl Drop for Viewing {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

pub(crate) fn url_in(said: &mut impl BufRead) -> String {
    let mut line = String::new();
    while !line.contains("http://") {
        line.clear();
        assert!(
            said.read_line(&mut line).expect("readable") > 0,
            "no address was said"
        );
    }
    line[line.find("http://").expect("looked for")..]
        .trim()
        .to_owned()
}

pub(crate) fn host(url: &str) -> &str {
    let rest = url.strip_prefix("http://").expect("an address");
    rest.split('/').next().expect("a host")
}

pub(crate) fn get(host: &str, path: &str, more: &str) -> String {
    let mut stream = TcpStream::connect(host).expect("it listens");
    let request = format!("GET {path} HTTP/1.1\r\n{more}\r\n");
    stream.write_all(request.as_bytes()).expect("sent");
    let mut answer = Vec::new();
    let _ = stream.read_to_end(&mut answer);
    String::from_utf8_lossy(&answer).into_owned()
}
