//! What a controller tells a robot's grippers, where the robot is a simulated one.

#[cfg(feature = "transport")]
use iceoryx2::prelude::ZeroCopySend;

/// Most grippers of one robot.
pub const MAX_GRIPPERS: usize = 2;

message! {
    /// Velocities for a robot's grippers, from the moment of sending on. A layout like those of the other messages.
    ///
    /// Only the simulated rope takes commands: a real robot has a driver of its own.
    pub struct Command = "lariat.Command.v2" {
        /// How many the controller has sent, this one included.
        count: u64 = 0 => number,
        /// When it was sent, on the clock of [`now_ns`](crate::now_ns).
        sent_ns: u64 = 0 => number,
        /// When the image was taken that it goes by ([`Trace::exposed_ns`](crate::Trace::exposed_ns)); 0 if by none.
        exposed_ns: u64 = 0 => number,
        /// How many grippers are meant.
        grippers: u32 = 0 => count(velocities),
        /// Always 0.
        reserved: u32 = 0 => reserved,
        /// The velocity of each gripper: along x, y and z, then the turns about x, y and z in rad/s. Of a rope in the image the first two are in
        /// px/s and the last is the turn from x towards y, the others count for nothing; of a lifted one they are in mm/s and those of the
        /// robot's frame.
        velocities: [[f64; 6]; MAX_GRIPPERS] = [[0.0; 6]; MAX_GRIPPERS] => list(velocities),
    }
}

impl Command {
    /// The velocities that are meant.
    pub fn velocities(&self) -> &[[f64; 6]] {
        &self.velocities[..(self.grippers as usize).min(MAX_GRIPPERS)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_that_lies_about_its_grippers_has_no_more_than_there_are() {
        let command = Command {
            grippers: 7,
            ..Command::default()
        };
        assert_eq!(command.velocities().len(), MAX_GRIPPERS);
    }
}
