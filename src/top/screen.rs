//! The terminal: taken over, and given back as it was however the program ends, but for SIGKILL.

use std::io::{self, Stdout};
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use ratatui::backend::CrosstermBackend;
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};
use ratatui::{Frame, Terminal};

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
pub(super) struct Screen(Terminal<CrosstermBackend<Stdout>>);

impl Screen {
    pub(super) fn enter() -> Result<Self> {
        let terminal = ratatui::try_init().inspect_err(|_| ratatui::restore());
        Ok(Self(terminal.context("the terminal cannot be drawn on")?))
    }

    pub(super) fn draw(&mut self, picture: impl FnOnce(&mut Frame)) -> io::Result<()> {
        self.0.draw(picture).map(|_| ())
    }

    /// The next key that means something, until the moment; `None` when it has come.
    pub(super) fn key(&mut self, until: Instant) -> Result<Option<Key>> {
        loop {
            let left = until.saturating_duration_since(Instant::now());
            if !event::poll(left).context("the terminal's keys cannot be read")? {
                return Ok(None);
            }
            if let Some(key) = meaning(&event::read()?) {
                return Ok(Some(key));
            }
            if left == Duration::ZERO {
                return Ok(None);
            }
        }
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        ratatui::restore();
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
