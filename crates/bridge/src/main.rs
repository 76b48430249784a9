//! `lariat-bridge`: carries a rig to another machine over UDP.
//!
//! On the camera's machine the bridge reads the rig. On the other machine it writes a rig of the
//! same name, so every reader there works unchanged. Only the used part of each message is sent, in
//! one datagram unless it is larger than UDP can carry. Delivery is best effort, and the newest
//! message wins. Queues that know priorities send messages before everything else.
//!
//! # Why a bare socket
//!
//! The thread that waits for descriptors also sends them, and the thread that waits at the far
//! socket also writes them: two wakeups, as for a ping. A session library puts threads of its own
//! in between, for features that are not needed here. zenoh 1.10 over UDP wakes five threads in a
//! row. It sends its subscriptions once over the same lossy link, so they must be renewed after a
//! silence. Its queue drops descriptors while its thread gets no core. It cannot secure plain UDP,
//! and it consists of 260 crates.
//!
//! QUIC's datagrams (RFC 9221) obey congestion control, which treats 2 % loss as a full link. At
//! 50 ms each way its window is then about 9 datagrams per round trip (`1.22 / √p`, Mathis and
//! others 1997). This window allows 90 datagrams per second, but a camera needs 200.
//!
//! Each datagram is therefore sealed here, with a key that both sides share: ChaCha20-Poly1305 of
//! `ring` (`key`, `datagram`). Sealing does not hide that there is a bridge, when it sends or how
//! much. It does not stop anyone on the network from flooding the port.
//!
//! A descriptor takes 2.4 to 3.2 times as long from shared memory to shared memory as a bare ping
//! (median, two busy cores, `tests/bridge/run --only none`). It takes three wakeups, in the bridge
//! here, the bridge there and the reader, where a ping takes two. The rest is the time to pack,
//! seal, open and unpack.
//!
//! The near side sends only to far sides that ask, each from an address that it has proved to be
//! its own (`peers`). Neither side ever waits for the network. A datagram that does not fit into a
//! full buffer is lost, and counted as lost on the network.
//!
//! # Losses
//!
//! The far side is one more stage of the chain: it numbers the messages that it writes, in their
//! traces (`bridged`). Every reader's ledger therefore includes all losses between fit and the far
//! side, wherever they happened, even while either side was down. The bridge itself counts exactly
//! what the network lost, from the count in each datagram (`tally`). It reports this when it ends,
//! when the link is silent, and in the roster once per second.
//!
//! | module | task |
//! |---|---|
//! | `args` | the command line, and the check for a key |
//! | `socket` | a UDP socket that never waits |
//! | `key`, `datagram`, `pack`, `question`, `chunks` | the wire format, from the outside in. Pure |
//! | `peers` | the far sides that receive messages. Pure |
//! | `clock`, `stamps`, `tally` | the other clock, timestamps converted from it, counts of what arrived. Pure |
//! | `refusals` | refused datagrams, reported at a limited rate |
//! | `channel` | a channel that is read while it has a writer |
//! | `near`, `near/hearing`, `near/robot`, `near/pictures` | the camera's side: messages out; questions and commands in; frames out |
//! | `far`, `far/link`, `far/written`, `far/controller`, `far/pictures` | the other side: questions; the state of the link; messages in; commands out; frames in |

mod args;
mod channel;
mod chunks;
mod clock;
mod datagram;
mod far;
mod key;
mod near;
mod pack;
mod peers;
mod question;
mod refusals;
mod socket;
mod stamps;
mod tally;

use std::process::ExitCode;

use anyhow::Result;
use args::Args;
use clap::Parser;
use lariat_chain::stages::arrangement::{join_stages, run_before_others};
use lariat_wire::take_short_slices;

/// Realtime priority, above the 40 to 43 of a chain: messages in transit go before those still
/// being made.
const PRIORITY: u8 = 44;

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            say(&format!("{error:#}"));
            lariat_chain::exit::code(&error)
        }
    }
}

fn run(args: &Args) -> Result<()> {
    match (&args.make_key, &args.listen, &args.connect) {
        (Some(path), ..) => key::Key::make(path),
        (_, Some(place), _) => near::run(args, place),
        (.., Some(place)) => far::run(args, place),
        // The command line requires one of them.
        (None, None, None) => Ok(()),
    }
}

/// Makes the scheduler run the calling thread as soon as it wakes. The thread carries descriptors,
/// questions or commands.
///
/// With `realtime` the thread asks for realtime priority on the core of the stages. The kernel
/// would otherwise spread realtime threads over sleeping cores. Returns false if realtime priority
/// was requested but not granted.
fn hurry(realtime: bool) -> bool {
    if realtime && run_before_others(PRIORITY) {
        // A failure to join is not an error.
        join_stages();
        return true;
    }
    take_short_slices();
    !realtime
}

/// Calls `hurry` for the main thread, and reports if realtime priority is not granted.
fn hurry_or_say(realtime: bool) {
    if !hurry(realtime) {
        say(
            "this user may not have realtime priority, and the bridge runs without: `lariat doctor` says what to type",
        );
    }
}

/// Prints a sentence on standard error.
fn say(sentence: &str) {
    eprintln!("lariat-bridge: {sentence}");
}
