//! Accepts clients, and serves each on its own thread, at most [`MOST_CLIENTS`] at a time.

use std::io::{ErrorKind, Read, Write};
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::os::fd::{AsFd, BorrowedFd};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::Builder;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use lariat_wire::Rig;
use rustix::event::{PollFd, PollFlags, Timespec, poll};

use crate::film::Film;
use crate::guard::{Admitted, Guard, token};
use crate::http::{Refusal, Request, answer, switch};
use crate::hub::Hub;
use crate::peer::Peer;
use crate::session::Session;
use crate::{foxglove, live, page};

/// Maximum number of connections. A browser uses a few for the page's files, and one that stays
/// open.
const MOST_CLIENTS: usize = 32;
/// Number of connections at which other users of the machine are refused, to keep room for the
/// page's owner.
const MOST_FOREIGN: usize = MOST_CLIENTS / 2;
/// Time limit for a client to send its request, and to take the answer.
const ASKING: Duration = Duration::from_secs(5);
/// Stack size of a client's thread, which keeps pictures on the heap.
const STACK: usize = 512 << 10;

/// Content of a page.
#[derive(Debug, Clone)]
pub enum Shown {
    /// A rig; `None` selects `default`, or the first one found.
    Rig(Option<Rig>),
    /// A recording.
    Recording {
        /// Path of the file.
        path: PathBuf,
        /// Topic whose images are the frames, if there are several cameras.
        topic: Option<String>,
    },
}

/// Options for serving a page.
#[derive(Debug, Clone)]
pub struct Options {
    /// Content of the page.
    pub shown: Shown,
    /// Address to listen on. Any address but a loopback address requires a token.
    pub listen: IpAddr,
    /// Port to listen on; 0 for any that is free.
    pub port: u16,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            shown: Shown::Rig(None),
            listen: Ipv4Addr::LOCALHOST.into(),
            port: 8765,
        }
    }
}

/// A server that listens.
#[derive(Debug)]
pub struct Server {
    listener: TcpListener,
    shared: Arc<Shared>,
}

/// State that all clients share.
#[derive(Debug)]
struct Shared {
    guard: Guard,
    hub: Arc<Hub>,
    /// Recording that is shown in place of the rig.
    film: Option<Film>,
    clients: AtomicUsize,
}

impl Server {
    /// Starts to listen. Nobody is answered before [`run`](Self::run).
    ///
    /// # Errors
    /// Fails if the port is taken, the address is not this machine's, or the recording cannot be
    /// shown.
    pub fn bind(options: &Options) -> Result<Self> {
        let (rig, film) = match &options.shown {
            Shown::Rig(rig) => (rig.clone(), None),
            Shown::Recording { path, topic } => (None, Some(Film::open(path, topic.as_deref())?)),
        };
        let asked = SocketAddr::new(options.listen, options.port);
        let listener = TcpListener::bind(asked).map_err(|cause| match cause.kind() {
            ErrorKind::AddrInUse => anyhow::anyhow!(
                "port {} is in use, perhaps by another `lariat view`: say --port with another number",
                options.port
            ),
            ErrorKind::AddrNotAvailable => anyhow::anyhow!(
                "{} is not an address of this machine: say --listen with one, or 0.0.0.0 for all",
                options.listen
            ),
            _ => anyhow::Error::new(cause).context(format!("cannot listen on {asked}")),
        })?;
        listener.set_nonblocking(true).context("cannot listen")?;
        let guard = Guard {
            address: listener.local_addr().context("cannot listen")?,
            token: token().context("no random token can be made")?,
        };
        Ok(Self {
            listener,
            shared: Arc::new(Shared {
                guard,
                hub: Hub::new(rig),
                film,
                clients: AtomicUsize::new(0),
            }),
        })
    }

    /// Returns the address to open in a browser.
    pub fn url(&self) -> String {
        let Guard { address, token } = &self.shared.guard;
        match address.ip() {
            ip if ip.is_loopback() => format!("http://{address}/"),
            ip if ip.is_unspecified() => {
                let name = rustix::system::uname();
                let name = name.nodename().to_string_lossy().into_owned();
                format!("http://{name}:{}/{token}/", address.port())
            }
            _ => format!("http://{address}/{token}/"),
        }
    }

    /// Returns the address with the token. With it, anyone may connect, even another site's page.
    pub fn url_with_token(&self) -> String {
        let Guard { address, token } = &self.shared.guard;
        match address.ip() {
            ip if ip.is_loopback() => format!("http://{address}/{token}/"),
            _ => self.url(),
        }
    }

    /// Serves until `stop` is readable.
    ///
    /// # Errors
    /// Fails if no thread can be started, or waiting for clients fails.
    pub fn run(&self, stop: BorrowedFd) -> Result<()> {
        let hub = self.shared.hub.clone();
        let reader = Builder::new().name("view-hub".into());
        let reader = reader
            .spawn(move || hub.run())
            .context("no thread can be started")?;
        let mut is_told = false;
        while !is_told {
            let mut both = [
                PollFd::new(&self.listener, PollFlags::IN),
                PollFd::from_borrowed_fd(stop, PollFlags::IN),
            ];
            match poll(&mut both, None) {
                Ok(_) | Err(rustix::io::Errno::INTR) => {}
                Err(cause) => return Err(cause).context("cannot wait for clients"),
            }
            is_told = !both[1].revents().is_empty();
            while let Ok((stream, _)) = self.listener.accept() {
                self.receive(stream);
            }
        }
        self.shared.hub.end();
        // A thread that panicked has reported it.
        let _ = reader.join();
        Ok(())
    }

    /// True for a connection of another user of this machine.
    fn is_foreign(&self, stream: &TcpStream) -> bool {
        let is_local = self.shared.guard.address.ip().is_loopback();
        is_local && !Peer::of(stream).is_some_and(|peer| peer.is_of_this_user())
    }

    fn receive(&self, stream: TcpStream) {
        if stream.set_nonblocking(true).is_err() {
            return;
        }
        // Send a picture at once, instead of waiting for more data.
        let _ = stream.set_nodelay(true);
        let place = Place(self.shared.clone());
        let clients = self.shared.clients.fetch_add(1, Ordering::Relaxed);
        if clients >= MOST_CLIENTS || clients >= MOST_FOREIGN && self.is_foreign(&stream) {
            let refusal = Refusal(503, "Too many connections: close some of the pages.");
            let _ = (&stream).write(&refusal.answer());
            return;
        }
        let client = Builder::new().name("view-client".into()).stack_size(STACK);
        // Without a thread, the connection is closed.
        let _ = client.spawn(move || {
            let peer = Peer::of(&stream);
            let is_of_this_user = || peer.is_some_and(|peer| peer.is_of_this_user());
            attend(stream, &place.0, is_of_this_user);
        });
    }
}

/// A client's place among all, given back when this is dropped.
struct Place(Arc<Shared>);

impl Drop for Place {
    fn drop(&mut self) {
        self.0.clients.fetch_sub(1, Ordering::Relaxed);
    }
}

/// Serves one nonblocking connection until it ends, for tests. It counts as a connection from this
/// machine and user, and `token` is the server's.
pub fn serve(stream: impl Read + Write + AsFd, token: &str) {
    let shared = Shared {
        guard: Guard {
            address: SocketAddr::new(Ipv4Addr::LOCALHOST.into(), 8765),
            token: token.to_owned(),
        },
        hub: Hub::new(None),
        film: None,
        clients: AtomicUsize::new(0),
    };
    attend(stream, &shared, || true);
}

fn attend(
    mut stream: impl Read + Write + AsFd,
    shared: &Shared,
    is_of_this_user: impl FnOnce() -> bool,
) {
    let asked = ask(&mut stream).and_then(|(request, rest)| {
        let admitted = shared.guard.admit(&request, is_of_this_user)?;
        Ok((request, admitted, rest))
    });
    let (request, admitted, rest) = match asked {
        Ok(asked) => asked,
        Err(refusal) => return write_all(&mut stream, &refusal.answer()),
    };
    match &request.key {
        Some(key) => open(stream, key, &request, &admitted, rest, shared),
        None => {
            let Some((kind, file)) = page::at(&admitted.path) else {
                let refusal = Refusal(404, "There is no such file here.");
                return write_all(&mut stream, &refusal.answer());
            };
            write_all(&mut stream, &answer(200, kind, file, request.is_head));
        }
    }
}

/// Opens a WebSocket with the first known protocol among the client's, and serves it until it ends.
fn open<S: Read + Write + AsFd>(
    mut stream: S,
    key: &str,
    request: &Request,
    admitted: &Admitted,
    rest: Vec<u8>,
    shared: &Shared,
) {
    let is_foxglove = |name: &str| foxglove::PROTOCOLS.contains(&name);
    let is_known = |name: &&String| match name.as_str() {
        live::PROTOCOL => true,
        // Foxglove opens recordings itself.
        name => shared.film.is_none() && is_foxglove(name),
    };
    let Some(protocol) = request.protocols.iter().find(is_known) else {
        let refusal = Refusal(400, "This WebSocket speaks nothing that is known here.");
        return write_all(&mut stream, &refusal.answer());
    };
    if let Some(film) = &shared.film {
        write_all(&mut stream, &switch(key, protocol));
        return live::show_film(Session::new(stream, rest), admitted.may_write, film);
    }
    let Ok(watcher) = shared.hub.join() else {
        let refusal = Refusal(503, "Too many connections: close some of the pages.");
        return write_all(&mut stream, &refusal.answer());
    };
    write_all(&mut stream, &switch(key, protocol));
    let session = Session::new(stream, rest);
    match is_foxglove(protocol) {
        true => foxglove::run(session, &watcher),
        false => live::show_rig(session, admitted.may_write, &watcher),
    }
}

/// Reads a client's request. Returns it, and what the client has sent after it.
fn ask(stream: &mut (impl Read + AsFd)) -> Result<(Request, Vec<u8>), Refusal> {
    let until = Instant::now() + ASKING;
    let mut head = Vec::new();
    let mut bytes = [0; 4096];
    loop {
        match stream.read(&mut bytes) {
            Ok(0) => return Err(Refusal(400, "The request did not end.")),
            Ok(count) => {
                head.extend_from_slice(&bytes[..count]);
                if let Some((request, length)) = Request::parse(&head)? {
                    return Ok((request, head.split_off(length)));
                }
            }
            Err(cause) if cause.kind() == ErrorKind::Interrupted => {}
            Err(cause) if cause.kind() == ErrorKind::WouldBlock => {
                if !wait(stream, PollFlags::IN, until) {
                    return Err(Refusal(408, "The request did not end in time."));
                }
            }
            Err(_) => return Err(Refusal(400, "The request did not end.")),
        }
    }
}

/// Writes all bytes, if the client takes them in time.
fn write_all(stream: &mut (impl Write + AsFd), mut bytes: &[u8]) {
    let until = Instant::now() + ASKING;
    while !bytes.is_empty() {
        match stream.write(bytes) {
            Ok(count @ 1..) => bytes = &bytes[count..],
            Err(cause) if cause.kind() == ErrorKind::Interrupted => {}
            Err(cause) if cause.kind() == ErrorKind::WouldBlock => {
                if !wait(stream, PollFlags::OUT, until) {
                    return;
                }
            }
            Ok(_) | Err(_) => return,
        }
    }
}

/// Waits until the stream can be read or written. Returns false if the time is over.
fn wait(stream: &impl AsFd, for_what: PollFlags, until: Instant) -> bool {
    let left = until.saturating_duration_since(Instant::now());
    let Ok(longest) = Timespec::try_from(left) else {
        return false;
    };
    let mut one = [PollFd::new(stream, for_what)];
    !left.is_zero()
        && matches!(
            poll(&mut one, Some(&longest)),
            Ok(1..) | Err(rustix::io::Errno::INTR)
        )
}
