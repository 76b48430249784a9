//! Writes velocities received on topics, one topic per gripper, as the commands of a rig whose rope
//! is simulated. Their units are those of the rig: in its image or, for a lifted rope, in its
//! robot's frame.

use std::sync::Arc;

use anyhow::Result;
use lariat_wire::{
    COMMANDS, Command, Delivery, Domain, MAX_GRIPPERS, Rig, WireError, Writer, now_ns,
};

use super::received::TwistStamped;
use super::stamps::Stamps;
use super::trouble::{Tally, Trouble, TroubleReporter};

/// Age at which a velocity is no longer used. The simulated robot also stops by itself this long
/// after its last command.
const HOLDS_NS: u64 = 250_000_000;

/// The rig's commands.
pub(super) struct Grippers {
    topics: Vec<(String, Arc<Tally>)>,
    writer: Writer<Command>,
    /// Newest velocity of each gripper, and its time.
    newest: [(u64, [f64; 6]); MAX_GRIPPERS],
    count: u64,
    stamps: Stamps,
    reporter: TroubleReporter,
}

impl Grippers {
    /// Opens the writer of the rig's commands.
    ///
    /// # Errors
    /// Another process writes them.
    pub(super) fn open(
        topics: Vec<(String, Arc<Tally>)>,
        domain: &Domain,
        rig: &Rig,
        stamps: Stamps,
    ) -> Result<Self, WireError> {
        Ok(Self {
            topics,
            writer: Writer::<Command>::create(domain, rig, &COMMANDS, &Delivery::NewestWins)?,
            newest: [(0, [0.0; 6]); MAX_GRIPPERS],
            count: 0,
            stamps,
            reporter: TroubleReporter::default(),
        })
    }

    /// Sends a gripper's velocity, together with the other one's last velocity unless that is too
    /// old.
    pub(super) fn send(&mut self, gripper: usize, twist: &TwistStamped) {
        match self.try_send(gripper, twist) {
            Ok(()) => self.topics[gripper].1.take(),
            Err(trouble) => self.refuse(gripper, &trouble),
        }
    }

    /// Counts an invalid command.
    pub(super) fn refuse(&mut self, gripper: usize, trouble: &Trouble) {
        let (topic, tally) = &self.topics[gripper];
        tally.refuse();
        self.reporter.report(topic, trouble);
    }

    fn try_send(&mut self, gripper: usize, twist: &TwistStamped) -> Result<(), Trouble> {
        let ([x, y, z], [a, b, c]) = (twist.linear, twist.angular);
        let velocity = [x, y, z, a, b, c];
        if !velocity.iter().all(|v| v.is_finite()) {
            return Err(Trouble::NotFinite);
        }
        let now_ns = now_ns();
        let stamp_ns = twist.header.stamp_ns();
        let (told_ns, trouble) = self.stamps.moment(stamp_ns, now_ns, HOLDS_NS)?;
        if let Some(trouble) = trouble {
            let (topic, tally) = &self.topics[gripper];
            tally.restamp();
            self.reporter.report(topic, &trouble);
        }
        self.newest[gripper] = (told_ns, velocity);
        self.count += 1;
        let command = Command {
            count: self.count,
            sent_ns: now_ns,
            grippers: self.topics.len() as u32,
            velocities: self.newest.map(|of| held(of, now_ns)),
            ..Command::default()
        };
        let send = || -> Result<(), WireError> {
            let mut slot = self.writer.slot()?;
            *slot = command;
            slot.send()?;
            Ok(())
        };
        send().map_err(|cause| Trouble::NotWritten(cause.to_string()))
    }
}

/// The velocity, or 0 if it is too old.
fn held((told_ns, velocity): (u64, [f64; 6]), now_ns: u64) -> [f64; 6] {
    let is_old = now_ns.saturating_sub(told_ns) > HOLDS_NS;
    if is_old { [0.0; 6] } else { velocity }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gripper_that_is_told_nothing_any_more_stands_still() {
        let told = (1_000_000_000, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!(held(told, 1_000_000_000 + HOLDS_NS), told.1);
        assert_eq!(held(told, 1_000_000_001 + HOLDS_NS), [0.0; 6]);
    }
}
