//! Control socket: other processes send requests to a running chain and receive answers. The socket
//! is in the same folder as the rig's other files, which only their owner can open.
//!
//! A client writes one request and shuts down its side of the connection. A request is `settings`,
//! `file`, `restart STAGE`, or `set` followed by one line `section.name=value` for each change. The
//! first line of the chain's answer is `ok`, `refused` or `wrong` (wrong use); the message follows
//! from the second line on. The chain waits at most one second for a client.

use std::fmt::Write as _;
use std::io::{self, ErrorKind, Read, Write};
use std::net::Shutdown;
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::fs::MetadataExt;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::exit::{is_wrong_use, wrong_use};
use anyhow::{Context, Result, anyhow, bail};
use lariat_wire::{Rig, control_socket};

/// Maximum size of a request or an answer, in bytes.
const LARGEST: u64 = 1 << 20;
/// Maximum number of clients whose requests are read at a time. Others wait.
const MOST_CLIENTS: usize = 32;
/// Time that the chain waits for a client that is slow to send its request or to read the answer.
const ASKING: Duration = Duration::from_secs(1);
/// Time that a client gives a chain to answer. The chain may be busy starting a stage.
const ANSWERING: Duration = Duration::from_secs(10);
/// Time that a client gives a chain to try a change: six times the default `start_limit_s`.
const TRYING: Duration = Duration::from_secs(120);

/// A request to a running chain.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Asked {
    /// Return the settings in force, as the text of a `lariat.toml`.
    Settings,
    /// Return the absolute path of the settings file, even if the file does not exist.
    File,
    /// Change settings. Each change is written as `section.name=value`.
    Set(Vec<String>),
    /// Restart a stage.
    Restart(String),
}

impl Asked {
    fn text(&self) -> String {
        match self {
            Self::Settings => "settings\n".to_owned(),
            Self::File => "file\n".to_owned(),
            Self::Restart(stage) => format!("restart {stage}\n"),
            Self::Set(changes) => changes.iter().fold("set\n".to_owned(), |mut text, change| {
                let _ = writeln!(text, "{change}");
                text
            }),
        }
    }

    fn of_text(text: &str) -> Result<Self> {
        let mut lines = text.lines();
        let request = lines.next().unwrap_or_default();
        Ok(match request.split_once(' ') {
            None if request == "settings" => Self::Settings,
            None if request == "file" => Self::File,
            None if request == "set" => Self::Set(lines.map(str::to_owned).collect()),
            Some(("restart", stage)) => Self::Restart(stage.to_owned()),
            _ => bail!("`{request}` is nothing that a chain of this release can do"),
        })
    }
}

/// Sends a request to the chain of a rig and returns its answer.
///
/// # Errors
/// Returns an error if no chain runs on the rig, or if the chain refuses. A refusal carries the
/// chain's own text.
pub fn ask(rig: &str, asked: &Asked) -> Result<String> {
    let path = control_socket(&rig.parse::<Rig>()?)?;
    let mut stream = match UnixStream::connect(&path) {
        Ok(stream) => stream,
        Err(cause)
            if matches!(
                cause.kind(),
                ErrorKind::NotFound | ErrorKind::ConnectionRefused
            ) =>
        {
            bail!("no chain runs on rig {rig}: `lariat run` starts one")
        }
        Err(cause) => {
            return Err(cause).with_context(|| format!("the chain of rig {rig} cannot be asked"));
        }
    };
    let exchange = || -> io::Result<String> {
        stream.set_read_timeout(Some(match asked {
            Asked::Set(_) => TRYING,
            _ => ANSWERING,
        }))?;
        stream.set_write_timeout(Some(ANSWERING))?;
        stream.write_all(asked.text().as_bytes())?;
        stream.shutdown(Shutdown::Write)?;
        let mut answer = String::new();
        stream.take(LARGEST).read_to_string(&mut answer)?;
        Ok(answer)
    };
    let answer = exchange().with_context(|| format!("the chain of rig {rig} does not answer"))?;
    match answer.split_once('\n') {
        Some(("ok", said)) => Ok(said.to_owned()),
        Some(("refused", why)) => bail!("{}", why.trim_end()),
        Some(("wrong", why)) => wrong_use!("{}", why.trim_end()),
        _ => bail!("the chain of rig {rig} ended before it answered"),
    }
}

/// The chain's end of the control socket. It never blocks on a client.
#[derive(Debug)]
pub struct Control {
    listener: UnixListener,
    /// Clients whose requests are incomplete.
    asking: Vec<Client>,
    path: PathBuf,
    /// Device and inode of the socket. If this socket is removed, another chain may create one of
    /// the same name.
    file: [u64; 2],
}

impl Control {
    /// Opens the control socket of a rig.
    ///
    /// # Errors
    /// Returns an error if the socket cannot be created.
    pub fn open(rig: &str) -> Result<Self> {
        Self::at(control_socket(&rig.parse::<Rig>()?)?)
    }

    fn at(path: PathBuf) -> Result<Self> {
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder)?;
        }
        // A socket that refuses connections is left over from a chain that was killed.
        if UnixStream::connect(&path)
            .is_err_and(|cause| cause.kind() == ErrorKind::ConnectionRefused)
        {
            std::fs::remove_file(&path)?;
        }
        let listener = UnixListener::bind(&path)
            .with_context(|| format!("no socket can be made at {}", path.display()))?;
        listener.set_nonblocking(true)?;
        let file = file_at(&path).context("the socket is gone")?;
        Ok(Self {
            listener,
            asking: Vec::new(),
            path,
            file,
        })
    }

    /// Returns true if the socket is still where it was created.
    pub fn is_there(&self) -> bool {
        file_at(&self.path) == Some(self.file)
    }

    /// Returns the next client whose request is complete, and the request. The request is an error
    /// if the client took longer than a second or asked for something unknown.
    pub fn next_request(&mut self) -> Option<(Client, Result<Asked>)> {
        self.next_at(Instant::now())
    }

    fn next_at(&mut self, now: Instant) -> Option<(Client, Result<Asked>)> {
        while self.has_room()
            && let Ok((stream, _)) = self.listener.accept()
        {
            self.asking.extend(Client::of(stream));
        }
        let mut done = None;
        for (at, client) in self.asking.iter_mut().enumerate() {
            if let Some(asked) = client.asked(now) {
                done = Some((at, asked));
                break;
            }
        }
        let (at, asked) = done?;
        Some((self.asking.swap_remove(at), asked))
    }

    fn has_room(&self) -> bool {
        self.asking.len() < MOST_CLIENTS
    }

    /// Returns the descriptors that become readable when [`next_request`](Self::next_request) has
    /// something to do.
    pub fn descriptors(&self) -> impl Iterator<Item = BorrowedFd<'_>> {
        let listener = self.has_room().then(|| self.listener.as_fd());
        let clients = self.asking.iter().map(|client| client.stream.as_fd());
        listener.into_iter().chain(clients)
    }

    /// Returns the time at which the first pending request expires.
    pub fn deadline(&self) -> Option<Instant> {
        self.asking.iter().map(|client| client.until).min()
    }
}

impl Drop for Control {
    fn drop(&mut self) {
        if self.is_there() {
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

fn file_at(path: &Path) -> Option<[u64; 2]> {
    let file = std::fs::symlink_metadata(path).ok()?;
    Some([file.dev(), file.ino()])
}

/// A client of the control socket.
#[derive(Debug)]
pub struct Client {
    stream: UnixStream,
    /// Bytes of the request that have arrived.
    text: Vec<u8>,
    /// Deadline for the end of the request.
    until: Instant,
}

impl Client {
    fn of(stream: UnixStream) -> Option<Self> {
        stream.set_nonblocking(true).ok()?;
        Some(Self {
            stream,
            text: Vec::new(),
            until: Instant::now() + ASKING,
        })
    }

    /// Reads the request. Returns `None` while it is incomplete.
    fn asked(&mut self, now: Instant) -> Option<Result<Asked>> {
        let mut bytes = [0; 4096];
        loop {
            match self.stream.read(&mut bytes) {
                Ok(0) => {
                    let text = String::from_utf8_lossy(&self.text);
                    return Some(Asked::of_text(&text));
                }
                Ok(count) => self.text.extend(&bytes[..count]),
                Err(cause) if cause.kind() == ErrorKind::Interrupted => {}
                Err(cause) if cause.kind() == ErrorKind::WouldBlock && now < self.until => {
                    return None;
                }
                Err(_) => return Some(Err(anyhow!("the request did not end"))),
            }
            if self.text.len() as u64 > LARGEST {
                return Some(Err(anyhow!("the request is too long")));
            }
        }
    }

    /// Sends the answer to the client.
    pub fn answer(mut self, answer: Result<String>) {
        let text = match answer {
            Ok(said) => format!("ok\n{said}"),
            Err(why) if is_wrong_use(&why) => format!("wrong\n{why:#}\n"),
            Err(why) => format!("refused\n{why:#}\n"),
        };
        // Errors are ignored: a client that is gone needs no answer.
        let _ = self.stream.set_nonblocking(false);
        let _ = self.stream.set_write_timeout(Some(ASKING));
        let _ = self.stream.write_all(text.as_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_client_that_says_nothing_holds_nobody_up_and_is_told_at_its_end() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("default.control");
        let mut control = Control::at(path.clone()).expect("a socket");
        let now = Instant::now();
        let mut silent = UnixStream::connect(&path).expect("it listens");
        assert!(control.next_at(now).is_none());
        let mut other = UnixStream::connect(&path).expect("it listens");
        other.write_all(b"restart fit\n").expect("it reads");
        other.shutdown(Shutdown::Write).expect("it reads");
        let (client, asked) = control.next_at(now).expect("the other");
        assert_eq!(asked.expect("a request"), Asked::Restart("fit".to_owned()));
        client.answer(Ok("done\n".to_owned()));
        assert!(control.next_at(now).is_none());
        assert_eq!(control.descriptors().count(), 2);
        let late = control.deadline().expect("one asks still");
        let (client, asked) = control.next_at(late).expect("the silent one");
        client.answer(asked.map(|_| String::new()));
        let mut answer = String::new();
        silent.read_to_string(&mut answer).expect("an answer");
        assert_eq!(answer, "refused\nthe request did not end\n");
    }
}
