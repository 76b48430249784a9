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
use anyhow::{Context, Result, bail};
use lariat_wire::{Rig, control_socket};

/// The largest request or answer, in bytes.
const LARGEST: u64 = 1 << 20;
/// How long one waits for the other: the chain for a client that is slow to ask, a client for a chain that is starting a stage.
const ASKING: Duration = Duration::from_secs(1);
const ANSWERING: Duration = Duration::from_secs(10);
/// How long a client waits for a chain that tries a change: longer than any stage takes to start.
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
    /// That a stage is started anew.
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

/// The chain's end: where it is asked.
#[derive(Debug)]
pub struct Control {
    listener: UnixListener,
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
            path,
            file,
        })
    }

    /// Whether its socket is where it was made.
    pub fn is_there(&self) -> bool {
        file_at(&self.path) == Some(self.file)
    }

    /// The next that asks, if one waits.
    pub fn next(&self) -> Option<Client> {
        let (stream, _) = self.listener.accept().ok()?;
        Some(Client(stream))
    }
}

impl AsFd for Control {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.listener.as_fd()
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
pub struct Client(UnixStream);

impl Client {
    /// What it asks for.
    ///
    /// # Errors
    /// It does not say within a second, or nothing that can be done.
    pub fn asked(&mut self) -> Result<Asked> {
        let end = Instant::now() + ASKING;
        let (mut text, mut bytes) = (Vec::new(), [0; 4096]);
        loop {
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() || text.len() as u64 > LARGEST {
                bail!("the request did not end");
            }
            self.0.set_read_timeout(Some(left))?;
            match self.0.read(&mut bytes) {
                Ok(0) => return Asked::of_text(&String::from_utf8(text)?),
                Ok(count) => text.extend(&bytes[..count]),
                Err(cause) if cause.kind() == ErrorKind::Interrupted => {}
                Err(_) => bail!("the request did not end"),
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
        let _ = self.0.set_write_timeout(Some(ASKING));
        let _ = self.0.write_all(text.as_bytes());
    }
}
