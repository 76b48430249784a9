//! Changes of settings that the chain sends to a running stage.
//!
//! They arrive as text on a pipe, whose descriptor number is in `LARIAT_ORDERS_FD`. Each starts
//! with a line `settings BYTES`, followed by this many bytes of a [`Settings::text`] that contains
//! its version. A thread sleeps on the pipe and prepares what the stage needs. The stage itself
//! only checks a flag between two frames and takes what is ready.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::os::fd::OwnedFd;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use anyhow::{Context, Result, bail};

use crate::settings::Settings;

/// Environment variable with the number of the pipe's descriptor.
pub const ORDERS_FD: &str = "LARIAT_ORDERS_FD";
/// Size limit of a settings text, in bytes. It takes a few kilobytes.
const LARGEST: u64 = 1 << 20;

/// The stage's end of the pipe. `None` if the stage was started by hand.
#[derive(Default)]
pub struct Orders(Option<File>);

/// New settings.
pub struct Change<T> {
    /// Version of the settings.
    pub version: u32,
    /// All settings as the text of a `lariat.toml`.
    pub text: String,
    /// Objects that the stage prepared from them, if they concern it.
    pub made: Option<T>,
}

/// Holds the newest change.
pub struct Changes<T> {
    is_there: Arc<AtomicBool>,
    next: Arc<Mutex<Option<Change<T>>>>,
}

impl Orders {
    /// Creates the orders of a stage that is a thread of the chain's own process.
    pub fn on(pipe: OwnedFd) -> Self {
        Self(Some(pipe.into()))
    }

    /// Opens the pipe of this process.
    ///
    /// # Errors
    /// Returns an error if the variable does not name a pipe.
    pub fn of_the_chain() -> Result<Self> {
        let Ok(number) = std::env::var(ORDERS_FD) else {
            return Ok(Self(None));
        };
        let pipe = File::open(format!("/proc/self/fd/{number}"))
            .with_context(|| format!("{ORDERS_FD} names no pipe: unset it"))?;
        Ok(Self(Some(pipe)))
    }

    /// Starts a thread that prepares what the stage needs for each change. `make` receives the
    /// previous and the new settings, and returns `None` if the change does not concern the stage.
    ///
    /// # Errors
    /// Returns an error if the thread cannot be started.
    pub fn listen<T: Send + 'static>(
        self,
        settings: &Settings,
        mut make: impl FnMut(&Settings, &Settings) -> Result<Option<T>> + Send + 'static,
    ) -> Result<Changes<T>> {
        let changes = Changes {
            is_there: Arc::default(),
            next: Arc::default(),
        };
        let Some(pipe) = self.0 else {
            return Ok(changes);
        };
        let (is_there, next) = (changes.is_there.clone(), changes.next.clone());
        let mut before = settings.clone();
        let work = move || {
            let mut pipe = BufReader::new(pipe);
            // If the chain ends or fails, no more changes follow.
            while let Ok(text) = next_text(&mut pipe) {
                let change =
                    Settings::of_text(&text).and_then(|now| Ok((make(&before, &now)?, now)));
                let (made, now) = match change {
                    Ok(change) => change,
                    Err(cause) => {
                        tracing::warn!("the settings stay as they are: {cause:#}");
                        continue;
                    }
                };
                let version = now.version;
                before = now;
                let mut next = next.lock().unwrap_or_else(PoisonError::into_inner);
                let waiting = next.take().and_then(|change: Change<T>| change.made);
                *next = Some(Change {
                    version,
                    text,
                    made: made.or(waiting),
                });
                is_there.store(true, Ordering::Release);
            }
        };
        std::thread::Builder::new()
            .name("orders".to_owned())
            .spawn(work)
            .context("the thread that listens to the chain could not be started")?;
        Ok(changes)
    }
}

impl<T> Changes<T> {
    /// Returns the newest change since the last call. Without a change, this only reads a flag.
    pub fn take(&self) -> Option<Change<T>> {
        if !self.is_there.load(Ordering::Acquire) {
            return None;
        }
        let mut next = self.next.lock().unwrap_or_else(PoisonError::into_inner);
        self.is_there.store(false, Ordering::Relaxed);
        next.take()
    }
}

/// Returns the bytes that the chain writes for a change.
pub fn order(settings: &str) -> String {
    format!("settings {}\n{settings}", settings.len())
}

fn next_text(pipe: &mut impl BufRead) -> Result<String> {
    let mut line = String::new();
    pipe.by_ref().take(64).read_line(&mut line)?;
    let length = line.trim_end().strip_prefix("settings ");
    let length: u64 = length.unwrap_or_default().parse()?;
    if length > LARGEST {
        bail!("settings of {length} bytes");
    }
    let mut text = String::new();
    pipe.take(length).read_to_string(&mut text)?;
    if text.len() as u64 != length {
        bail!("half of a text");
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rustix::pipe::{PipeFlags, pipe_with};
    use std::io::Write;
    use std::time::{Duration, Instant};

    fn next<T>(changes: &Changes<T>) -> Change<T> {
        let begin = Instant::now();
        loop {
            if let Some(change) = changes.take() {
                return change;
            }
            assert!(begin.elapsed() < Duration::from_secs(60), "no change came");
            std::thread::yield_now();
        }
    }

    #[test]
    fn a_change_is_taken_once_and_one_that_cannot_be_made_leaves_all_as_it_was() {
        let (pipe, its_end) = pipe_with(PipeFlags::CLOEXEC).unwrap();
        let mut chain = File::from(its_end);
        let settings = Settings::default();
        let changes = Orders::on(pipe)
            .listen(&settings, |before, now| {
                anyhow::ensure!(now.extract.points != 77, "not 77");
                let is_other = before.extract != now.extract;
                Ok(is_other.then_some([before, now].map(|settings| settings.extract.points)))
            })
            .unwrap();
        assert!(changes.take().is_none());
        let mut tell = |points, rig: &str, version| {
            let mut settings = Settings::default();
            settings.extract.points = points;
            settings.run.rig = rig.to_owned();
            settings.version = version;
            chain.write_all(order(&settings.text()).as_bytes()).unwrap();
        };
        tell(60, "default", 1);
        let change = next(&changes);
        assert_eq!((change.version, change.made), (1, Some([120, 60])));
        assert!(changes.take().is_none());
        tell(77, "default", 2);
        tell(60, "other", 3);
        let change = next(&changes);
        assert_eq!((change.version, change.made), (3, None));
        tell(50, "other", 4);
        assert_eq!(next(&changes).made, Some([60, 50]));
    }
}
