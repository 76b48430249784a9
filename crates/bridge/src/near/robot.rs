//! Writes commands to the rig: never late, never twice, from one controller at a time.

use std::fmt;
use std::time::Duration;

use lariat_wire::{COMMANDS, Command, Delivery, Domain, Rig, WireError, Writer, now_ns};

use crate::pack::unpack;
use crate::say;
use crate::tally::Tally;

/// A controller that is silent for this long releases the robot. Another controller may then take
/// over, on either side.
const LETS_GO_NS: u64 = 1_000_000_000;
/// Number of controllers that are remembered, so that none of their commands is executed twice.
const CONTROLLERS: usize = 16;
/// Minimum time between two reports of dropped commands.
const SAY_NS: u64 = 1_000_000_000;

/// A controller, and the count of its commands.
struct Controller {
    process: u64,
    heard_ns: u64,
    tally: Tally,
}

/// Decides which commands of far controllers reach the rig.
pub(super) struct Robot {
    rig: Rig,
    /// This process's random number, which each command repeats.
    process: u64,
    most_age_ns: u64,
    /// Known controllers, starting with the one whose command was accepted last.
    controllers: Vec<Controller>,
    done: Done,
    said_ns: u64,
    said: Option<String>,
}

/// Writer of the rig's channel of commands, open while a controller controls the robot.
pub(super) struct Gives {
    // Before the domain, so that it is dropped first.
    writer: Option<Writer<Command>>,
    domain: Domain,
}

impl Gives {
    /// # Errors
    /// Fails if the domain cannot be joined.
    pub(super) fn open() -> Result<Self, WireError> {
        Ok(Self {
            writer: None,
            domain: Domain::open()?,
        })
    }

    fn give(&mut self, rig: &Rig, command: &Command) -> Result<(), WireError> {
        let writer = match &mut self.writer {
            Some(writer) => writer,
            empty => empty.insert(Writer::<Command>::create(
                &self.domain,
                rig,
                &COMMANDS,
                &Delivery::NewestWins,
            )?),
        };
        let mut slot = writer.slot()?;
        *slot = *command;
        slot.send()?;
        Ok(())
    }

    /// Closes the channel, so that another writer can open it.
    pub(super) fn let_go(&mut self) {
        self.writer = None;
    }
}

/// Counts of commands that were passed on, dropped, lost or refused.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
pub(super) struct Done {
    given: u64,
    old: u64,
    lost: u64,
    refused: u64,
}

impl fmt::Display for Done {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            given,
            old,
            lost,
            refused,
        } = self;
        write!(
            f,
            "commands: {given} given, {old} too old, {lost} lost, {refused} refused"
        )
    }
}

/// A command to pass on to the rig, or the reason why it is not passed on.
#[derive(Debug, PartialEq)]
enum Judged {
    Give(Command),
    Old(u64),
    Refused,
}

impl Robot {
    pub(super) fn new(rig: &Rig, process: u64, most_age: Duration) -> Self {
        Self {
            rig: rig.clone(),
            process,
            most_age_ns: u64::try_from(most_age.as_nanos()).unwrap_or(u64::MAX),
            controllers: Vec::new(),
            done: Done::default(),
            said_ns: 0,
            said: None,
        }
    }

    /// Passes a command on to the rig, if it is valid and new.
    pub(super) fn obey(&mut self, gives: &mut Gives, process: u64, count: u64, says: &[u8]) {
        match self.judge(process, count, says, now_ns()) {
            Judged::Give(command) => {
                let given = gives.give(&self.rig, &command);
                self.note(given);
            }
            Judged::Old(age_ns) => {
                self.done.old += 1;
                self.say_old(age_ns);
            }
            Judged::Refused => self.done.refused += 1,
        }
    }

    /// Returns counts of all commands by outcome.
    pub(super) fn done(&self) -> Done {
        let lost = self.controllers.iter().map(|one| one.tally.lost());
        Done {
            lost: self.done.lost + lost.sum::<u64>(),
            ..self.done
        }
    }

    /// Returns whether a controller controls the robot.
    pub(super) fn is_held(&self, now_ns: u64) -> bool {
        let newest = self.controllers.first();
        newest.is_some_and(|one| now_ns.saturating_sub(one.heard_ns) <= LETS_GO_NS)
    }

    /// Decides what to do with a process's `count`-th command. `says` holds the process that it is
    /// meant for, then the command on this machine's clock.
    fn judge(&mut self, process: u64, count: u64, says: &[u8], now_ns: u64) -> Judged {
        let mut command = Command::default();
        let Some((meant, packed)) = says.split_first_chunk() else {
            return Judged::Refused;
        };
        if u64::from_le_bytes(*meant) != self.process
            || unpack(&mut command, packed).is_err()
            || !command
                .velocities()
                .as_flattened()
                .iter()
                .all(|v| v.is_finite())
        {
            return Judged::Refused;
        }
        let at = self
            .controllers
            .iter()
            .position(|one| one.process == process);
        // The robot has one controller at a time.
        if self.is_held(now_ns) && at != Some(0) {
            return Judged::Refused;
        }
        let mut tally = at.map_or_else(Tally::default, |at| self.controllers[at].tally);
        if !tally.receive(count) {
            return Judged::Refused;
        }
        let age_ns = now_ns.saturating_sub(command.sent_ns);
        if age_ns > self.most_age_ns {
            // The command counts as received, but an old command does not give anyone control of
            // the robot.
            if let Some(at) = at {
                self.controllers[at].tally = tally;
            }
            return Judged::Old(age_ns);
        }
        at.map(|at| self.controllers.remove(at));
        let heard = Controller {
            process,
            heard_ns: now_ns,
            tally,
        };
        self.controllers.insert(0, heard);
        if self.controllers.len() > CONTROLLERS {
            self.done.lost += self.controllers.pop().map_or(0, |one| one.tally.lost());
        }
        // Times in the future are set to now.
        command.sent_ns = command.sent_ns.min(now_ns);
        command.exposed_ns = command.exposed_ns.min(now_ns);
        Judged::Give(command)
    }

    fn note(&mut self, given: Result<(), WireError>) {
        match &given {
            Ok(()) => self.done.given += 1,
            Err(_) => self.done.refused += 1,
        }
        let cause = given.err().map(|cause| cause.to_string());
        if cause.is_some() && cause != self.said {
            say(cause.as_deref().unwrap_or_default());
        }
        self.said = cause;
    }

    fn say_old(&mut self, age_ns: u64) {
        let now_ns = now_ns();
        if now_ns.saturating_sub(self.said_ns) > SAY_NS {
            self.said_ns = now_ns;
            say(&format!(
                "a command came {:.1} ms after it was given, and was dropped, like all older than {:.1} ms ({} until now): --command-age sets that",
                age_ns as f64 * 1e-6,
                self.most_age_ns as f64 * 1e-6,
                self.done.old
            ));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pack::pack;

    const NOW: u64 = 10_000_000_000;

    fn robot() -> Robot {
        Robot::new(&Rig::default(), 5, Duration::from_millis(100))
    }

    fn judge(
        robot: &mut Robot,
        (process, count, meant): (u64, u64, u64),
        command: &Command,
        now_ns: u64,
    ) -> Judged {
        let mut says = meant.to_le_bytes().to_vec();
        pack(command, &mut says);
        robot.judge(process, count, &says, now_ns)
    }

    fn command(sent_ns: u64) -> Command {
        Command {
            count: 1,
            sent_ns,
            grippers: 1,
            velocities: [[1.0, 2.0, 3.0, 0.1, 0.2, 0.3]; 2],
            ..Command::default()
        }
    }

    #[test]
    fn an_old_command_is_dropped_and_a_new_one_given() {
        let mut robot = robot();
        let given = |judged| matches!(judged, Judged::Give(_));
        assert!(given(judge(
            &mut robot,
            (1, 1, 5),
            &command(NOW - 100_000_000),
            NOW
        )));
        assert_eq!(
            judge(&mut robot, (1, 2, 5), &command(NOW - 100_000_001), NOW),
            Judged::Old(100_000_001)
        );
        // Times in the future are set to now.
        match judge(&mut robot, (1, 3, 5), &command(NOW + 50), NOW) {
            Judged::Give(command) => assert_eq!(command.sent_ns, NOW),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn no_command_comes_twice_or_for_another_or_from_another() {
        let mut robot = robot();
        let new = command(NOW);
        assert!(matches!(
            judge(&mut robot, (1, 7, 5), &new, NOW),
            Judged::Give(_)
        ));
        for (process, count, meant) in [(1, 7, 5), (1, 6, 5), (1, 8, 4), (2, 1, 5)] {
            assert_eq!(
                judge(&mut robot, (process, count, meant), &new, NOW),
                Judged::Refused
            );
        }
        assert!(matches!(
            judge(&mut robot, (1, 10, 5), &new, NOW),
            Judged::Give(_)
        ));
        // Another controller may take over when the first has released the robot. Old commands of
        // either are not treated as new.
        let later = NOW + LETS_GO_NS + 1;
        let mut old = command(later);
        assert_eq!(judge(&mut robot, (1, 10, 5), &old, later), Judged::Refused);
        old.sent_ns = NOW;
        assert!(matches!(
            judge(&mut robot, (3, 1, 5), &old, later),
            Judged::Old(_)
        ));
        assert!(matches!(
            judge(&mut robot, (2, 1, 5), &command(later), later),
            Judged::Give(_)
        ));
        assert_eq!(
            judge(&mut robot, (1, 11, 5), &command(later), later),
            Judged::Refused
        );
        assert_eq!(
            robot
                .controllers
                .iter()
                .map(|one| one.tally.lost())
                .sum::<u64>(),
            2
        );
    }

    #[test]
    fn what_is_no_command_is_refused() {
        let mut robot = robot();
        let mut wrong = command(NOW);
        wrong.velocities[0][1] = f64::NAN;
        assert_eq!(judge(&mut robot, (1, 1, 5), &wrong, NOW), Judged::Refused);
        let mut whole = 5_u64.to_le_bytes().to_vec();
        pack(&command(NOW), &mut whole);
        for length in 0..whole.len() {
            assert_eq!(robot.judge(1, 1, &whole[..length], NOW), Judged::Refused);
        }
    }
}
