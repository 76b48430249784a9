//! Takes over the terminal, and restores it however the program ends, except for SIGKILL.

use std::fs::File;
use std::io::{self, IsTerminal, Stdout};
use std::mem::ManuallyDrop;
use std::os::fd::{AsFd, OwnedFd};
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use lariat_chain::stop::Stop;
use ratatui::backend::CrosstermBackend;
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};
use ratatui::{Frame, Terminal};
use rustix::event::{PollFd, PollFlags, Timespec, poll};

/// An action of the user.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Key {
    Quit,
    Pause,
    NextRig,
    Longer,
    Shorter,
    /// The size of the terminal has changed.
    Redraw,
}

/// A terminal in raw mode, on its alternate screen. A panic restores it before its message is
/// printed.
pub(super) struct Screen {
    /// Never dropped, because its destructor would report errors to a terminal that is gone, and
    /// panic.
    terminal: ManuallyDrop<Terminal<CrosstermBackend<Stdout>>>,
    /// Input of keys.
    keys: OwnedFd,
}

impl Screen {
    pub(super) fn enter() -> Result<Self> {
        let keys = match io::stdin() {
            stdin if stdin.is_terminal() => stdin.as_fd().try_clone_to_owned(),
            _ => File::open("/dev/tty").map(OwnedFd::from),
        };
        let keys = keys.context("the terminal's keys cannot be read")?;
        let terminal = ratatui::try_init().inspect_err(|_| ratatui::restore());
        let terminal = terminal.context("the terminal cannot be drawn on")?;
        Ok(Self {
            terminal: ManuallyDrop::new(terminal),
            keys,
        })
    }

    pub(super) fn draw(&mut self, picture: impl FnOnce(&mut Frame)) -> io::Result<()> {
        self.terminal.draw(picture).map(|_| ())
    }

    /// Returns the next key that has a meaning. Returns `None` at the deadline or after a signal.
    ///
    /// crossterm only reads what is available and never waits: if the terminal were closed
    /// meanwhile, it would read forever.
    pub(super) fn key(&mut self, until: Instant, stop: &Stop) -> Result<Option<Key>> {
        let gone = PollFlags::HUP | PollFlags::ERR | PollFlags::NVAL;
        let mut left = Duration::ZERO;
        loop {
            let ready = [self.keys.as_fd(), stop.as_fd()];
            let mut ready = ready.map(|fd| PollFd::from_borrowed_fd(fd, PollFlags::IN));
            // Interrupted by a signal, for example a change of size.
            let _ = poll(&mut ready, Timespec::try_from(left).ok().as_ref());
            if ready[0].revents().intersects(gone) {
                return Ok(Some(Key::Quit));
            }
            while event::poll(Duration::ZERO).context("the terminal's keys cannot be read")? {
                if let Some(key) = meaning(&event::read()?) {
                    return Ok(Some(key));
                }
            }
            left = until.saturating_duration_since(Instant::now());
            if left == Duration::ZERO || stop.asked() {
                return Ok(None);
            }
        }
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        // If the terminal is gone, nobody can see the errors.
        let _ = self.terminal.show_cursor();
        let _ = ratatui::try_restore();
    }
}

fn meaning(event: &Event) -> Option<Key> {
    let key = match event {
        Event::Resize(..) => return Some(Key::Redraw),
        Event::Key(KeyEvent {
            kind: KeyEventKind::Release,
            ..
        }) => return None,
        Event::Key(key) => key,
        _ => return None,
    };
    let is_control = key.modifiers.contains(KeyModifiers::CONTROL);
    Some(match key.code {
        // In raw mode, Ctrl-C on the keyboard is a key and not a signal.
        KeyCode::Char('c') if is_control => Key::Quit,
        _ if is_control => return None,
        KeyCode::Char('q') | KeyCode::Esc => Key::Quit,
        KeyCode::Char('p' | ' ') => Key::Pause,
        KeyCode::Char('r') | KeyCode::Tab => Key::NextRig,
        KeyCode::Char('+' | '=') => Key::Longer,
        KeyCode::Char('-') => Key::Shorter,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ctrl_c_quits_and_other_keys_with_ctrl_do_nothing() {
        let key = |code, modifiers| meaning(&Event::Key(KeyEvent::new(code, modifiers)));
        let with = KeyModifiers::CONTROL;
        assert_eq!(key(KeyCode::Char('c'), with), Some(Key::Quit));
        assert_eq!(key(KeyCode::Char('p'), with), None);
        let plain = KeyModifiers::NONE;
        assert_eq!(key(KeyCode::Char('c'), plain), None);
        assert_eq!(key(KeyCode::Tab, plain), Some(Key::NextRig));
        assert_eq!(meaning(&Event::Resize(80, 24)), Some(Key::Redraw));
    }
}
