//! `lariat-ros2`: a rig of lariat in a ROS 2 graph.
//!
//! It is a reader of the rig like any control loop, a writer of its frames if those come from the graph, and a node of the graph, by RustDDS, without ROS installed. What nobody in the
//! graph listens to is not made; when nobody listens to anything, the rig is not read. Bytes on the wire are those of
//! `lariat-record`'s CDR, which recordings have too: there is one encoder, and one set of `.msg` files.
//!
//! | | |
//! |---|---|
//! | `args` | the command line, ROS's own words (`--ros-args -r`, `__ns`, `__node`) among it |
//! | `graph` | the node, its publishers, who listens |
//! | `rig` | the channels that are read, as long as there is a writer and a listener |
//! | `messages/` | what a message of lariat is in ROS's own types. Pure |
//! | `pictures` | a frame as JPEG, with and without the ropes drawn on it |
//! | `health` | what diagnostics say |
//! | `outgoing` | from the rig to the graph, message by message |
//! | `parameters` | the chain's settings as the node's parameters |
//! | `incoming/` | from the graph to the rig: images, masks, velocities of grippers, the camera's calibration |

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
