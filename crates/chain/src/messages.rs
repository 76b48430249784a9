//! Writes the messages of all processes of a chain to standard error, which may be a terminal that
//! also shows a live line.
//!
//! The terminal handles each `write` as a whole. A message therefore clears the live line in the
//! same `write` and never mixes with it. The live line is redrawn below the message.
//!
//! Only `lariat run` writes to standard error. Each stage writes into a pipe, which a thread
//! empties into a queue ([`Intake`]). Another thread writes the queue ([`Relay`]). So a stage never
//! waits for a blocked terminal, and everything that a stage wrote before it died is shown. The
//! queue is bounded: messages beyond its capacity are dropped and counted.

use std::borrow::Cow;
use std::collections::VecDeque;
use std::io::{self, ErrorKind, IsTerminal, Read, Write, stderr};
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use crate::layout;

/// Environment variable that tells a stage that its messages go to a terminal.
const TERMINAL: &str = "LARIAT_STDERR_IS_TERMINAL";
/// Moves the cursor to the start of the line and erases the line.
const CLEAR: &str = "\r\x1b[K";
/// Prefix of messages that are not log lines.
const NAME: &[u8] = b"lariat: ";
/// Erases from the cursor to the end of the line. Every live line ends with this code.
const ERASE_REST: &[u8] = b"\x1b[K";
/// Capacity of the queue, in bytes: about ten thousand messages.
const CAPACITY: usize = 1 << 20;
/// Stack size of a thread that only copies bytes.
const STACK: usize = 128 << 10;

/// Set once a live line may be on the terminal.
static HAS_LIVE_LINE: AtomicBool = AtomicBool::new(false);
static QUEUE: Mutex<Queue> = Mutex::new(Queue::EMPTY);
static CHANGED: Condvar = Condvar::new();

/// Messages that wait for standard error.
struct Queue {
    waiting: VecDeque<Vec<u8>>,
    bytes: usize,
    /// Number of messages that did not fit.
    dropped: u64,
    /// Set while a thread writes the queue.
    is_open: bool,
}

impl Queue {
    const EMPTY: Self = Self {
        waiting: VecDeque::new(),
        bytes: 0,
        dropped: 0,
        is_open: false,
    };

    fn push(&mut self, message: Vec<u8>) {
        if self.bytes + message.len() > CAPACITY {
            self.dropped += 1;
            return;
        }
        self.bytes += message.len();
        self.waiting.push_back(message);
    }

    /// Empties the queue and returns the bytes to write.
    fn take(&mut self) -> Vec<u8> {
        let mut bytes: Vec<u8> = self.waiting.drain(..).flatten().collect();
        self.bytes = 0;
        let dropped = std::mem::take(&mut self.dropped);
        if dropped > 0 {
            let note =
                format!("lariat: {dropped} messages were dropped while standard error took none\n");
            bytes.extend(cleared(note.as_bytes()).iter());
        }
        bytes
    }
}

fn queue() -> MutexGuard<'static, Queue> {
    QUEUE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Returns true if the messages of this process go to a terminal.
pub fn is_terminal() -> bool {
    stderr().is_terminal() || std::env::var_os(TERMINAL).is_some()
}

/// Makes all further messages of this process clear the cursor's line first.
pub fn expect_live_line() {
    HAS_LIVE_LINE.store(true, Ordering::Relaxed);
}

/// Writes a message and a line end to standard error. Long lines are folded to fit a terminal.
/// Errors are ignored, because they cannot be reported anywhere.
pub fn say(message: &str) {
    let message = format!("{}\n", layout::said(message));
    send(cleared(message.as_bytes()));
}

/// Writes a live line to standard error.
pub(crate) fn show(live_line: &str) {
    send(live_line.as_bytes().into());
}

fn send(message: Cow<[u8]>) {
    let mut queue = queue();
    if queue.is_open {
        queue.push(message.into_owned());
        CHANGED.notify_all();
    } else {
        drop(queue);
        let _ = stderr().write_all(&message);
    }
}

/// Prepends the code that clears the live line, if there may be one.
fn cleared(message: &[u8]) -> Cow<'_, [u8]> {
    // A live line overwrites the previous one, and an empty line ends it.
    let is_of_live_line = message == b"\n" || message.starts_with(b"\r");
    match HAS_LIVE_LINE.load(Ordering::Relaxed) && !is_of_live_line && stderr().is_terminal() {
        true => [CLEAR.as_bytes(), message].concat().into(),
        false => message.into(),
    }
}

/// The writer of the log. Each event is one message.
#[derive(Debug)]
pub struct Log;

impl Write for Log {
    fn write(&mut self, event: &[u8]) -> io::Result<usize> {
        say(String::from_utf8_lossy(event).trim_end_matches('\n'));
        Ok(event.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// The thread that writes all messages of this process and of the processes that it starts.
/// Dropping it waits until they are written.
#[derive(Debug)]
pub struct Relay(Option<JoinHandle<()>>);

impl Relay {
    /// Starts the thread.
    ///
    /// # Errors
    /// Returns an error if the thread cannot be started.
    pub fn start() -> io::Result<Self> {
        expect_live_line();
        queue().is_open = true;
        let thread = thread("messages").spawn(write_queue);
        // Without the thread, messages are written directly.
        queue().is_open = thread.is_ok();
        thread.map(|thread| Self(Some(thread)))
    }
}

impl Drop for Relay {
    fn drop(&mut self) {
        queue().is_open = false;
        CHANGED.notify_all();
        if let Some(thread) = self.0.take() {
            let _ = thread.join();
        }
    }
}

fn write_queue() {
    loop {
        let mut queue = queue();
        while queue.waiting.is_empty() && queue.is_open {
            queue = CHANGED.wait(queue).unwrap_or_else(PoisonError::into_inner);
        }
        let bytes = queue.take();
        drop(queue);
        if bytes.is_empty() {
            return;
        }
        let _ = stderr().write_all(&bytes);
    }
}

fn thread(name: &str) -> std::thread::Builder {
    std::thread::Builder::new()
        .name(name.to_owned())
        .stack_size(STACK)
}

/// The thread that reads the messages of a process that this one has started. It returns the last
/// message.
#[derive(Debug)]
pub struct Intake(JoinHandle<String>);

impl Intake {
    /// Prepares a command so that its messages can be read.
    pub fn prepare(command: &mut Command) -> &mut Command {
        match is_terminal() {
            true => command.env(TERMINAL, "1"),
            false => command.env_remove(TERMINAL),
        };
        command.stderr(std::process::Stdio::piped())
    }

    /// Reads the messages of the process at the other end of the pipe.
    ///
    /// # Errors
    /// Returns an error if the thread cannot be started.
    pub fn of(pipe: impl Read + Send + 'static) -> io::Result<Self> {
        let take_in = move || {
            let mut last = String::new();
            take_in(pipe, |message| {
                if let Some(text) = message.strip_prefix(NAME) {
                    last = String::from_utf8_lossy(text).trim_end().to_owned();
                }
                send(cleared(message));
            });
            last
        };
        Ok(Self(thread("intake").spawn(take_in)?))
    }

    /// Waits until all messages of a process that has ended are read. Returns the last message that
    /// starts with lariat's name, without the name. The string is empty without such a message.
    pub fn finish(self) -> String {
        self.0.join().unwrap_or_default()
    }
}

/// Reads to the end, and passes on each line and each live line as a whole.
fn take_in(mut pipe: impl Read, mut pass_on: impl FnMut(&[u8])) {
    let (mut unread, mut buffer) = (Vec::new(), [0; 4096]);
    loop {
        match pipe.read(&mut buffer) {
            Ok(0) => break,
            Ok(count) => unread.extend(&buffer[..count]),
            Err(cause) if cause.kind() == ErrorKind::Interrupted => continue,
            Err(_) => break,
        }
        while let Some(end) = end_of_first(&unread) {
            pass_on(&unread[..end]);
            unread.drain(..end);
        }
    }
    // The process died in the middle of a line.
    if !unread.is_empty() {
        unread.push(b'\n');
        pass_on(&unread);
    }
}

fn end_of_first(bytes: &[u8]) -> Option<usize> {
    let end: &[u8] = match bytes.first()? {
        b'\r' => ERASE_REST,
        _ => b"\n",
    };
    let at = bytes.windows(end.len()).position(|window| window == end)?;
    Some(at + end.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A reader that returns one byte at a time.
    struct Slow<'a>(&'a [u8]);

    impl Read for Slow<'_> {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            self.0.read(&mut buffer[..1])
        }
    }

    fn taken_in(bytes: &[u8]) -> Vec<String> {
        let collect = |pipe: &mut dyn Read| {
            let mut messages = Vec::new();
            take_in(pipe, |message| {
                messages.push(String::from_utf8_lossy(message).into_owned());
            });
            messages
        };
        let at_once = collect(&mut &*bytes);
        assert_eq!(at_once, collect(&mut Slow(bytes)));
        at_once
    }

    #[test]
    fn each_line_is_passed_on_whole_however_it_arrives() {
        assert_eq!(taken_in(b"one\ntwo\n"), ["one\n", "two\n"]);
    }

    #[test]
    fn the_last_words_of_a_process_that_died_within_a_line_are_passed_on() {
        assert_eq!(taken_in(b"one\nthread 'fi"), ["one\n", "thread 'fi\n"]);
        assert_eq!(taken_in(b""), [""; 0]);
    }

    #[test]
    fn a_live_line_on_standard_error_is_passed_on_without_a_line_end() {
        let bytes = b"\r30/s\x1b[K\r31/s\x1b[Kword\n\n";
        let pieces = ["\r30/s\x1b[K", "\r31/s\x1b[K", "word\n", "\n"];
        assert_eq!(taken_in(bytes), pieces);
    }

    #[test]
    fn messages_beyond_the_capacity_are_counted_and_the_others_kept_in_order() {
        let mut queue = Queue::EMPTY;
        let half = vec![b'a'; CAPACITY / 2];
        for _ in 0..4 {
            queue.push(half.clone());
        }
        let bytes = queue.take();
        assert!(bytes.starts_with(&[half.clone(), half].concat()));
        let note = String::from_utf8_lossy(&bytes[CAPACITY..]).into_owned();
        assert!(note.contains("2 messages were dropped"), "{note}");
        queue.push(b"next\n".to_vec());
        assert_eq!(queue.take(), b"next\n");
    }
}
