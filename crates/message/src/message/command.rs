//! Commands from a controller to the grippers of a simulated robot.

#[cfg(feature = "transport")]
use iceoryx2::prelude::ZeroCopySend;

/// Maximum number of grippers of one robot.
pub const MAX_GRIPPERS: usize = 2;

message! {
    /// Velocities for a robot's grippers, valid from the moment of sending. The layout follows the
    /// same rules as the other messages.
    ///
    /// Only the simulated rope accepts commands; a real robot has its own driver.
    pub struct Command = "lariat.Command.v2" {
        /// Commands sent, including this one.
        count: u64 = 0 => number,
        /// Time of sending on the clock of [`now_ns`](crate::now_ns).
        sent_ns: u64 = 0 => number,
        /// Exposure time of the image used ([`Trace::exposed_ns`](crate::Trace::exposed_ns)); 0 if
        /// none.
        exposed_ns: u64 = 0 => number,
        /// Number of valid grippers.
        grippers: u32 = 0 => count(velocities),
        /// Always 0.
        reserved: u32 = 0 => reserved,
        /// Gripper velocities along x, y, z in mm/s, then about x, y, z in rad/s, in the robot's
        /// frame. A rope in the image uses only the first two, in px/s, and the last, from x
        /// towards y.
        velocities: [[f64; 6]; MAX_GRIPPERS] = [[0.0; 6]; MAX_GRIPPERS] => list(velocities),
    }
}

impl Command {
    /// The valid velocities.
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
