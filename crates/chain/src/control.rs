//! How another process tells a running chain what to do, and is answered: a socket beside the rig's other files, which only their
//! owner can open.
//!
//! The client writes one request, and ends its side: `settings`, `file`, `restart STAGE`, or `set` and a line `section.name=value` for each
//! change. The chain answers `ok`, `refused` or `wrong` (use), and what it has to say from the second line on. Both are small, and wait a
//! second for each other at most.

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

/// The largest request or answer, in bytes.
const LARGEST: u64 = 1 << 20;
/// Clients whose requests are read at a time; others wait.
const MOST_CLIENTS: usize = 32;
/// How long one waits for the other: the chain for a client that is slow to ask, a client for a chain that is starting a stage.
const ASKING: Duration = Duration::from_secs(1);
const ANSWERING: Duration = Duration::from_secs(10);
/// Time that a client gives a chain to try a change: six times the usual `start_limit_s`.
const TRYING: Duration = Duration::from_secs(120);

/// What a chain can be asked for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Asked {
    /// The settings that hold, as the text of a `lariat.toml`.
    Settings,
    /// Where the settings file is that it goes by, or would be: its whole path.
    File,
    /// That settings hold from now on, each written as `section.name=value`.
    Set(Vec<String>),
    /// That a stage is restarted.
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

/// Asks the chain of a rig, and returns what it says.
///
/// # Errors
/// There is none, or it refuses, in its own words.
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

/// The chain's end: where it is asked. It never waits for a client.
#[derive(Debug)]
pub struct Control {
    listener: UnixListener,
    /// Clients that have not ended their request.
    asking: Vec<Client>,
    path: PathBuf,
    /// Device and number of the socket: another chain may make one of the same name, when this one's was removed.
    file: [u64; 2],
}

impl Control {
    /// # Errors
    /// The socket cannot be made.
    pub fn open(rig: &str) -> Result<Self> {
        Self::at(control_socket(&rig.parse::<Rig>()?)?)
    }

    fn at(path: PathBuf) -> Result<Self> {
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder)?;
        }
        // That of a chain that was killed is nobody's.
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

    /// Whether its socket is where it was made.
    pub fn is_there(&self) -> bool {
        file_at(&self.path) == Some(self.file)
    }

    /// The next client that has ended its request, and what it asks for; an error: it has not within a second, or asks for nothing
    /// that can be done.
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

    /// Readable when [`next_request`](Self::next_request) has something to do.
    pub fn descriptors(&self) -> impl Iterator<Item = BorrowedFd<'_>> {
        let listener = self.has_room().then(|| self.listener.as_fd());
        let clients = self.asking.iter().map(|client| client.stream.as_fd());
        listener.into_iter().chain(clients)
    }

    /// When a client has asked for too long.
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

/// One that asks.
#[derive(Debug)]
pub struct Client {
    stream: UnixStream,
    /// Bytes of its request that have arrived.
    text: Vec<u8>,
    /// By when its request is to end.
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

    /// Its request; `None` while that is incomplete.
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

    /// Answers it.
    pub fn answer(mut self, answer: Result<String>) {
        let text = match answer {
            Ok(said) => format!("ok\n{said}"),
            Err(why) if is_wrong_use(&why) => format!("wrong\n{why:#}\n"),
            Err(why) => format!("refused\n{why:#}\n"),
        };
        // One that is gone need not be told.
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
