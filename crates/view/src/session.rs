//! A WebSocket on one thread, which sleeps until the client says something or there is something to
//! say.
//!
//! The socket does not block. Data that cannot be written at once waits in memory, and nothing is
//! added to it meanwhile. A client that takes nothing for [`PATIENCE`] is disconnected, and so is a
//! client that sends too much.

use std::io::{ErrorKind, Read, Write};
use std::os::fd::{AsFd, BorrowedFd};
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use tungstenite::protocol::{Role, WebSocketConfig};
use tungstenite::{Bytes, Error, Message, WebSocket};

/// Time limit for a client that takes nothing, or leaves a ping unanswered.
const PATIENCE: Duration = Duration::from_secs(10);
/// Time of silence before a client is pinged.
const SILENCE: Duration = Duration::from_secs(20);
/// Maximum length of a client's message in bytes: a dropped picture.
pub(crate) const LARGEST: usize = 24 << 20;
/// Maximum rate of a client's messages per second, on average: ten times that of a page at
/// 60 frames/s.
const MOST_PER_S: f64 = 600.0;

/// Event that ended the session's sleep.
#[derive(Debug, PartialEq)]
pub(crate) enum Event {
    /// The client sent text.
    Text(String),
    /// The client sent bytes.
    Binary(Bytes),
    /// The event descriptor is readable, or the time is over.
    News,
    /// The connection is over: the client has gone, or was disconnected.
    End,
}

/// A client's WebSocket.
pub(crate) struct Session<S: Read + Write + AsFd> {
    socket: WebSocket<S>,
    /// Time when data began to wait to be written, if any waits.
    stuck: Option<Instant>,
    heard: Instant,
    asked: Option<Instant>,
    /// Number of messages that the client may still send at once.
    allowance: f64,
    counted: Instant,
}

impl<S: Read + Write + AsFd> Session<S> {
    /// Creates a session. `rest` is what came after the opening.
    pub(crate) fn new(stream: S, rest: Vec<u8>) -> Self {
        let config = WebSocketConfig::default()
            .read_buffer_size(16 << 10)
            .write_buffer_size(0)
            .max_message_size(Some(LARGEST))
            .max_frame_size(Some(LARGEST));
        let now = Instant::now();
        Self {
            socket: WebSocket::from_partially_read(stream, rest, Role::Server, Some(config)),
            stuck: None,
            heard: now,
            asked: None,
            allowance: MOST_PER_S,
            counted: now,
        }
    }

    /// Returns whether everything has gone out.
    pub(crate) fn is_clear(&self) -> bool {
        self.stuck.is_none()
    }

    /// Sends a message, which waits in memory if the client does not take it now. Returns false if
    /// the connection is over.
    pub(crate) fn say(&mut self, message: Message) -> bool {
        let result = self.socket.write(message);
        goes_on(result) && self.flush()
    }

    fn flush(&mut self) -> bool {
        let result = self.socket.flush();
        match &result {
            Ok(()) => self.stuck = None,
            Err(Error::Io(cause)) if cause.kind() == ErrorKind::WouldBlock => {
                self.stuck.get_or_insert_with(Instant::now);
            }
            Err(_) => {}
        }
        goes_on(result)
    }

    /// Sleeps until the client says something, `bell` is readable, or the time is over.
    pub(crate) fn next(&mut self, bell: Option<BorrowedFd>, longest: Duration) -> Event {
        let until = Instant::now() + longest;
        loop {
            match self.socket.read() {
                Ok(message) => {
                    self.heard = Instant::now();
                    self.asked = None;
                    if !self.is_allowed() {
                        return Event::End;
                    }
                    match message {
                        Message::Text(text) => return Event::Text(text.as_str().to_owned()),
                        Message::Binary(bytes) => return Event::Binary(bytes),
                        Message::Close(_) => {
                            self.flush();
                            return Event::End;
                        }
                        // The reply to a ping waits to be written.
                        _ => {
                            if !self.flush() {
                                return Event::End;
                            }
                            continue;
                        }
                    }
                }
                Err(Error::Io(cause)) if cause.kind() == ErrorKind::WouldBlock => {}
                Err(Error::Io(cause)) if cause.kind() == ErrorKind::Interrupted => continue,
                Err(_) => return Event::End,
            }
            if !self.is_patient() {
                return Event::End;
            }
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Event::News;
            }
            match self.sleep(bell, left) {
                Some(true) => return Event::News,
                Some(false) => {}
                None => return Event::End,
            }
        }
    }

    /// Sleeps. Returns whether `bell` is readable; `None` if the connection is over.
    fn sleep(&mut self, bell: Option<BorrowedFd>, longest: Duration) -> Option<bool> {
        let is_stuck = self.stuck.is_some();
        let wanted = match is_stuck {
            true => PollFlags::IN | PollFlags::OUT,
            false => PollFlags::IN,
        };
        let (told, is_writable) = {
            let stream = self.socket.get_ref().as_fd();
            let mut both = [
                PollFd::from_borrowed_fd(stream, wanted),
                // Without a bell, the stream is polled twice.
                PollFd::from_borrowed_fd(bell.unwrap_or(stream), PollFlags::IN),
            ];
            let longest = Timespec::try_from(longest.min(PATIENCE)).ok()?;
            match poll(&mut both, Some(&longest)) {
                Ok(_) | Err(rustix::io::Errno::INTR) => {}
                Err(_) => return None,
            }
            let [stream, rung] = both.map(|one| one.revents());
            (
                bell.is_some() && rung.contains(PollFlags::IN),
                stream.contains(PollFlags::OUT),
            )
        };
        if is_stuck && is_writable && !self.flush() {
            return None;
        }
        Some(told)
    }

    /// Returns whether the client is within its rate of messages.
    fn is_allowed(&mut self) -> bool {
        let now = Instant::now();
        let since = now.duration_since(self.counted).as_secs_f64();
        self.counted = now;
        self.allowance = (self.allowance + since * MOST_PER_S).min(MOST_PER_S) - 1.0;
        self.allowance > 0.0
    }

    /// Returns whether the client is still there and takes what it is sent. Pings the client now
    /// and then.
    fn is_patient(&mut self) -> bool {
        let now = Instant::now();
        if self.stuck.is_some_and(|since| now - since > PATIENCE) {
            return false;
        }
        match self.asked {
            Some(asked) => now - asked <= PATIENCE,
            None if now - self.heard > SILENCE && self.is_clear() => {
                self.asked = Some(now);
                self.say(Message::Ping(Bytes::new()))
            }
            None => true,
        }
    }
}

/// Returns whether the connection continues after this.
fn goes_on(result: Result<(), Error>) -> bool {
    match result {
        Ok(()) => true,
        Err(Error::Io(cause)) => {
            matches!(cause.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted)
        }
        Err(_) => false,
    }
}
