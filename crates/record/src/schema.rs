//! The definitions of the messages, as ROS 2 writes them: they stand in each file, so that any tool can read it.

/// How messages are encoded: CDR, little endian.
pub const ENCODING: &str = "cdr";
/// How schemas are written.
pub const SCHEMA_ENCODING: &str = "ros2msg";

/// The definition of one kind of message.
#[derive(Debug, PartialEq, Eq)]
pub struct Schema {
    /// Its full name, such as `sensor_msgs/msg/Image`.
    pub name: &'static str,
    /// Its definition, followed by those of the messages in it.
    pub text: &'static str,
}

/// A definition with those it needs behind it, in the way of ROS 2.
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
