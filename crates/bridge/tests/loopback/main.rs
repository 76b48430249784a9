//! Both sides of a bridge as processes, each in a domain of its own, over the loopback and over a relay that delays, loses and reorders: what comes
//! is what was sent, stamps are right to the stated bound, sent = received + lost, nothing goes back in time, each side may be killed, commands come
//! back and never late, and only who has the key is heard.

#[path = "../../examples/wire/relay.rs"]
mod relay;
#[path = "../../examples/wire/rope.rs"]
mod rope;

mod channels;
mod commands;
mod links;
mod safety;
mod sides;
