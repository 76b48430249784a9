//! `lariat-ros2`: a rig of lariat in a ROS 2 graph.
//!
//! It is a reader of the rig like any control loop, and a writer of its frames if those come from
//! the graph. It is a node of the graph through RustDDS, without a ROS installation. Messages
//! without a subscriber are not made, and without any subscriber the rig is not read. The encoding
//! is that of `lariat-record`'s CDR, which recordings use too: there is one encoder and one set of
//! `.msg` files.
//!
//! | | |
//! |---|---|
//! | `args` | the command line, including ROS's own options (`--ros-args -r`, `__ns`, `__node`) |
//! | `graph` | the node, its publishers and their subscribers |
//! | `rig` | the channels, read while there is a writer and a subscriber |
//! | `messages/` | conversion of lariat's messages to ROS's own types. Pure |
//! | `pictures` | a frame as JPEG, with or without the ropes drawn on it |
//! | `health` | contents of diagnostics |
//! | `outgoing` | from the rig to the graph, message by message |
//! | `parameters` | the chain's settings as the node's parameters |
//! | `incoming/` | from the graph to the rig: images, masks, velocities of grippers, the camera's
//! calibration |

mod args;
mod graph;
mod health;
mod incoming;
mod messages;
mod outgoing;
mod parameters;
mod pictures;
mod rig;

use std::process::ExitCode;

use args::Args;

fn main() -> ExitCode {
    match Args::from_command_line().and_then(|args| outgoing::run(&args)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("lariat-ros2: {error:#}");
            lariat_chain::exit::code(&error)
        }
    }
}
