//! The terminal: taken over, and given back as it was however the program ends, but for SIGKILL.

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

/// What the user wants.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Key {
    Quit,
    Pause,
    NextRig,
    Longer,
    Shorter,
    /// The terminal has another size.
    Redraw,
}

/// A terminal in raw mode, on its alternate screen. A panic gives it back before it says what happened.
pub(super) struct Screen {
    /// Its own drop would tell a terminal that is gone that it is, and break off over that.
    terminal: ManuallyDrop<Terminal<CrosstermBackend<Stdout>>>,
    /// Where keys come from.
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

    /// The next key that means something, until the moment; `None` when it has come, or a signal.
    ///
    /// crossterm is asked for what is there, and never waited in: a terminal that is closed meanwhile it would read for ever.
    pub(super) fn key(&mut self, until: Instant, stop: &Stop) -> Result<Option<Key>> {
        let gone = PollFlags::HUP | PollFlags::ERR | PollFlags::NVAL;
        let mut left = Duration::ZERO;
        loop {
            let ready = [self.keys.as_fd(), stop.as_fd()];
            let mut ready = ready.map(|fd| PollFd::from_borrowed_fd(fd, PollFlags::IN));
            // What interrupts it is a signal, as that of another size.
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
        // Where it is gone, nobody is left to be told.
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
        // In raw mode the keyboard's Ctrl-C is a key, and no signal.
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
