//! `lariat-bridge`: a rig of lariat on another machine, over UDP.
//!
//! On the camera's machine it is a reader of the rig, on the other the writer of a rig of the same name: every reader there works unchanged. What
//! goes over the wire is what is meant of each message, in one datagram: best effort, the newest wins, before all else in the queues that know a
//! first.
//!
//! # Why a bare socket
//!
//! The thread that waits for descriptors sends them, and the one that waits at the far socket writes them: two wakings, as a ping has. A library of
//! sessions brings threads of its own between both, and what it would do for that is not wanted here. zenoh 1.10 over UDP, which carried this before,
//! woke five threads in a row. Its subscriptions went over the same lossy link, once, so that silence had to begin them again; its
//! queue gave up descriptors when its thread had no core; it has no security over plain UDP; and it is 260 crates. QUIC's datagrams (RFC 9221) obey
//! congestion control, which takes 2 % of loss for a full link: at 50 ms each way its window is then some 9 datagrams a round trip (`1.22 / √p`, Mathis
//! and others 1997), 90 a second, where a camera has 200. So each datagram is sealed here, with a key that both sides share: ChaCha20-Poly1305 of
//! `ring` (`key`, `datagram`). That does not hide that a bridge is there, when it sends and how much, and it does not stop someone on the
//! network who floods the port.
//!
//! Both built alike, without optimization of the whole, in turns on two busy cores (`tests/bridge/run --only none`): a descriptor from shared memory to shared memory
//! took 3.6, 3.9 and 6.3 × a bare ping at the middle by zenoh, and takes 2.8, 2.4 and 3.2 × by this. What is left are three wakings, of the bridge here, the
//! bridge there and the reader, where a ping has two; and 8 µs each of packing and sealing, and of opening and unpacking.
//!
//! Near sides send to those that ask, each from an address that it has shown to be its own (`peers`). Neither side ever waits for the network: what a
//! full buffer has no room for is lost, and counted, as on the way.
//!
//! # Losses
//!
//! The far side is one more stage of the chain: it counts what it writes into each trace (`bridged`), so that every reader's ledger finds what was lost
//! between fit and there, on whichever part of the way, also while either side was away. What the wire lost the bridge itself counts (`tally`), exactly, from
//! the count in each datagram, and says so when it ends, when the link is silent, and in the roster each second.
//!
//! | | |
//! |---|---|
//! | `args` | the command line, and what is safe |
//! | `socket` | a UDP socket that never waits |
//! | `key`, `datagram`, `pack`, `question`, `chunks` | what goes over the wire, from the outside in. Pure |
//! | `peers` | who is sent to. Pure |
//! | `clock`, `stamps`, `tally` | the other clock, stamps by it, counts of what came. Pure |
//! | `refusals` | what was refused, and that it is not said too often |
//! | `channel` | a channel that is read while it is written |
//! | `near`, `near/hearing`, `near/robot`, `near/pictures` | the camera's side: messages out; questions and commands in; frames out |
//! | `far`, `far/link`, `far/written`, `far/controller`, `far/pictures` | the other: questions; what is known of the near side; messages in; commands out; frames in |

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

/// Above those of a chain, 40 to 43: what is on its way goes before what is still made.
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
        // The command line asks for one of them.
        (None, None, None) => Ok(()),
    }
}

/// Has the calling thread, which carries descriptors, questions or commands, have a core as soon as it wakes; whether by realtime priority, if that is
/// asked for. Then on the core of the stages: threads of realtime priority are pushed apart by the kernel, each to a core that sleeps.
fn hurry(realtime: bool) -> bool {
    if realtime && run_before_others(PRIORITY) {
        // Not to be had is no fault.
        join_stages();
        return true;
    }
    take_short_slices();
    !realtime
}

/// The same for the main thread, which says what it cannot have.
fn hurry_or_say(realtime: bool) {
    if !hurry(realtime) {
        say(
            "this user may not have realtime priority, and the bridge runs without: `lariat doctor` says what to type",
        );
    }
}

/// Says a sentence on standard error.
fn say(sentence: &str) {
    eprintln!("lariat-bridge: {sentence}");
}
