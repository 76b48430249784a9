//! Definitions of the messages in ROS 2's format. Each file contains them, so that any tool can
//! read it.

/// Encoding of messages: CDR, little endian.
pub const ENCODING: &str = "cdr";
/// Encoding of schemas.
pub const SCHEMA_ENCODING: &str = "ros2msg";

/// The definition of one kind of message.
#[derive(Debug, PartialEq, Eq)]
pub struct Schema {
    /// Full name, such as `sensor_msgs/msg/Image`.
    pub name: &'static str,
    /// Definition, followed by those of the messages in it.
    pub text: &'static str,
}

/// Joins a definition and those it needs, as ROS 2 does.
macro_rules! schema {
    ($name:literal, $file:literal $(, $part:literal = $part_file:literal)*) => {
        Schema {
            name: $name,
            text: concat!(
                include_str!(concat!("../schemas/", $file)),
                $(
                    "================================================================================\n",
                    "MSG: ", $part, "\n",
                    include_str!(concat!("../schemas/", $part_file)),
                )*
            ),
        }
    };
}
pub(crate) use schema;
