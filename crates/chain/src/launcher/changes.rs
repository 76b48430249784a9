//! Requests from other processes to a running chain, and changes of settings.
//!
//! A change that restarts a stage is tried first. If the stage does not become ready, the chain
//! returns to the previous settings, restarts the stage with them, and tells the client the reason.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use super::child::Child;
use super::watch::Watch;
use super::{Chain, Part};
use crate::control::{Asked, Client, Control};
use crate::exit::wrong_use;
use crate::pipeline::{CurveFitter, FrameExtractor};
use crate::settings::{FILE_NAME, Flags, Settings};

/// Stages that a change of settings can restart.
const TRIED: [Part; 4] = [Part::Capture, Part::Extract, Part::Fit, Part::Sink];

/// A change of settings that is being tried.
pub(super) struct Trial {
    /// Marks the stages of [`TRIED`] that restart.
    again: [bool; 4],
    flags_before: Flags,
    before: Arc<Settings>,
    /// The client that asked for the change; `None` for an edited file.
    client: Option<Client>,
    /// The answer if all these stages become ready.
    answer: String,
    /// Deadline for the stages to become ready.
    pub(super) until: Instant,
}

impl Trial {
    fn parts(&self) -> impl Iterator<Item = Part> + use<> {
        let again = self.again;
        TRIED.into_iter().filter(move |part| again[*part as usize])
    }
}

impl Chain {
    /// Creates the control socket if there is none, for example because it was removed. When all
    /// processes in the domain die at once, the next process to join removes what they left,
    /// including the socket.
    pub(super) fn listen_to_others(&mut self) {
        if self.control.as_ref().is_some_and(Control::is_there) {
            return;
        }
        match Control::open(&self.settings.run.rig) {
            Ok(control) => self.control = Some(control),
            Err(cause) => {
                tracing::warn!("the running chain takes no commands: {cause:#}")
            }
        }
    }

    /// Answers the requests of other processes.
    pub(super) fn answer_others(&mut self) {
        while self.trial.is_none()
            && let Some((client, asked)) = self.control.as_mut().and_then(Control::next_request)
        {
            let answer = match asked {
                Ok(Asked::Settings) => Ok(self.settings.text()),
                Ok(Asked::File) => self.file_path(),
                Ok(Asked::Set(changes)) => self.set(&changes),
                Ok(Asked::Restart(name)) => self.renew_by_name(&name),
                Err(cause) => Err(cause),
            };
            match (answer, &mut self.trial) {
                (Ok(answer), Some(trial)) => (trial.client, trial.answer) = (Some(client), answer),
                (answer, _) => client.answer(answer),
            }
        }
    }

    fn is_up(&self, part: Part) -> bool {
        let is_on_its_way = self.renewed[part as usize] || self.due[part as usize].is_some();
        let is_up = |child: &Child| child.is_ready() && child.ending().is_none();
        !is_on_its_way && self.child(part).is_some_and(is_up)
    }

    /// Accepts the tried change once its stages are ready. Reverts it if they take too long.
    pub(super) fn judge_trial(&mut self) {
        let Some(trial) = &self.trial else { return };
        if trial.parts().all(|part| self.is_up(part)) {
            if let Some(Trial {
                client: Some(client),
                answer,
                ..
            }) = self.trial.take()
            {
                client.answer(Ok(answer));
            }
        } else if Instant::now() >= trial.until {
            self.take_back();
        }
    }

    /// Returns true if this part ended before it was ready, while a change that restarts it is
    /// being tried.
    pub(super) fn is_tried_in_vain(&self, part: Part) -> bool {
        let is_tried = |trial: &Trial| trial.parts().any(|tried| tried == part);
        let has_ended = |child: &Child| child.ending().is_some() && !child.is_ready();
        self.trial.as_ref().is_some_and(is_tried) && self.child(part).is_some_and(has_ended)
    }

    /// Reverts a change: the previous settings apply again, and the stages restart with them.
    pub(super) fn take_back(&mut self) {
        let Some(trial) = self.trial.take() else {
            return;
        };
        let failed = trial.parts().find(|part| !self.is_up(*part));
        let why = failed.and_then(|part| self.child(part)).map(|child| {
            format!(
                "{} cannot start with this change: {}",
                child.part.name(),
                child.reason()
            )
        });
        let why = format!(
            "{}; the previous settings stay in force",
            why.unwrap_or_default().trim_end_matches('.')
        );
        let mut settings = Settings::clone(&trial.before);
        settings.version = self.settings.version + 1;
        self.flags = trial.flags_before.clone();
        self.hand_out(settings);
        for part in trial.parts() {
            self.renew(part);
        }
        match trial.client {
            Some(client) => client.answer(Err(anyhow::anyhow!(why))),
            None => tracing::warn!("{why}"),
        }
    }

    /// Applies settings and sends them to all parts.
    fn hand_out(&mut self, settings: Settings) {
        let text = settings.text();
        self.settings = Arc::new(settings);
        for child in self.children.iter_mut().flatten() {
            if child.ending().is_none() && !child.order(&text) {
                tracing::warn!(
                    "{} does not listen, and keeps the settings it has",
                    child.part.name()
                );
            }
        }
    }

    /// Returns the path of the settings file, even if the file does not exist.
    fn file_path(&self) -> anyhow::Result<String> {
        let file = self.settings.file.as_deref();
        let path = std::path::absolute(file.unwrap_or(Path::new(FILE_NAME)))?;
        Ok(format!("{}\n", path.display()))
    }

    /// Applies changes that are written as `section.name=value`.
    pub(super) fn set(&mut self, changes: &[String]) -> anyhow::Result<String> {
        let (mut flags, mut alone) = (self.flags.clone(), Flags::default());
        for change in changes {
            (flags, alone) = (flags.with_change(change)?, alone.with_change(change)?);
        }
        // A file may have changed although its name has not, so read it again.
        let is_read_again = alone.set_any_of("camera");
        let answer = self.change(self.settings.changed_by(&alone)?, is_read_again)?;
        self.flags = flags;
        Ok(answer)
    }

    /// Reads the settings file again if it has changed.
    pub(super) fn read_the_file(&mut self) {
        if self.trial.is_some() || !self.file.as_mut().is_some_and(Watch::has_changed) {
            return;
        }
        match Settings::of_chain(&self.flags).and_then(|settings| self.change(settings, false)) {
            Ok(answer) => eprintln!("lariat: {}", answer.trim_end()),
            Err(cause) => tracing::warn!("the settings stay as they are: {cause:#}"),
        }
    }

    /// Applies other settings. Returns lines that say what changed and when it takes effect. If
    /// `is_read_again` is set, the files of `[camera]` are read again even if their names are the
    /// same.
    ///
    /// # Errors
    /// Returns the reason if the settings cannot be applied. Nothing has changed then.
    pub(super) fn change(
        &mut self,
        mut settings: Settings,
        is_read_again: bool,
    ) -> anyhow::Result<String> {
        let differences: Vec<_> = settings.differences(&self.settings).collect();
        if differences.is_empty() && !is_read_again {
            return Ok("nothing has changed\n".to_owned());
        }
        let mut concerned = settings.concerned(&self.settings)?;
        concerned.live[Part::Fit as usize] |= is_read_again && !concerned.again[Part::Fit as usize];
        let named = |of: [bool; 4]| {
            let names: Vec<_> = TRIED
                .iter()
                .filter(|part| of[**part as usize])
                .map(|part| part.name())
                .collect();
            names.join(", ")
        };
        if concerned.again.contains(&true) && settings.run.fuse {
            anyhow::bail!(
                "{} would have to be restarted, which a fused chain cannot do: stop it, and start it with the new value",
                named(concerned.again)
            );
        }
        // Try what a stage would do, so that the client receives the error.
        if concerned.live[Part::Extract as usize] {
            FrameExtractor::new(&settings.extract)?;
        }
        if concerned.live[Part::Fit as usize] {
            CurveFitter::new(&settings)?;
        }
        settings.version = self.settings.version + 1;
        let mut answer = format!("settings {}:", settings.version);
        if differences.is_empty() {
            answer += " the files of [camera] are read again";
        }
        for (name, value) in differences {
            answer += &format!(" {name} = {value}");
        }
        if concerned.live.contains(&true) {
            answer += &format!("; {} between two frames", named(concerned.live));
        }
        if concerned.again.contains(&true) {
            answer += &format!("; restarted: {}", named(concerned.again));
        }
        answer.push('\n');
        if concerned.again.contains(&true) {
            self.trial = Some(Trial {
                again: concerned.again,
                flags_before: self.flags.clone(),
                before: self.settings.clone(),
                client: None,
                answer: String::new(),
                until: Instant::now() + settings.run.start_limit,
            });
        }
        self.hand_out(settings);
        for part in TRIED
            .into_iter()
            .filter(|part| concerned.again[*part as usize])
        {
            self.renew(part);
        }
        Ok(answer)
    }

    pub(super) fn renew_by_name(&mut self, name: &str) -> anyhow::Result<String> {
        let part = Part::ALL.into_iter().find(|part| part.name() == name);
        let Some(part) = part.filter(|part| self.child(*part).is_some()) else {
            if Part::ALL.iter().all(|part| part.name() != name) {
                wrong_use!(
                    "no part of a chain is called {name}: name capture, extract, fit or sink"
                );
            }
            anyhow::bail!("this chain has no {name}: name capture, extract, fit or sink");
        };
        if self.settings.run.fuse && part.fused().is_some() {
            anyhow::bail!("{name} has no process of its own, as the chain is fused");
        }
        self.renew(part);
        Ok(format!("{name} is restarted\n"))
    }

    /// Ends a part so that it is restarted.
    pub(super) fn renew(&mut self, part: Part) {
        let Some(child) = self.children[part as usize].as_mut() else {
            return;
        };
        if child.ending().is_some() {
            // It is restarted anyway.
            self.due[part as usize].get_or_insert_with(Instant::now);
            return;
        }
        self.renewed[part as usize] = true;
        // The sink and the recorder would write their reports on a signal, and a part that is still
        // starting may miss the signal. Kill them instead.
        match part.is_told_the_last_word() || !child.is_ready() {
            true => child.strike(),
            false => child.tell_to_stop(),
        }
    }
}
