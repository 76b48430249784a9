//! Runs both sides of a bridge as processes, each in a domain of its own. They talk over the
//! loopback interface, or over a relay that delays, loses and reorders.
//!
//! The tests check that messages arrive as sent, that timestamps are right within the stated bound,
//! and that sent = received + lost. Nothing goes back in time, either side may be killed, commands
//! travel back and are never late, and datagrams are accepted only from a side with the key.

#[path = "../../examples/wire/relay.rs"]
mod relay;
#[path = "../../examples/wire/rope.rs"]
mod rope;

mod channels;
mod commands;
mod links;
mod safety;
mod sides;
