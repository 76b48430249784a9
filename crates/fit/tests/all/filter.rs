//! What a filter's users may rely on.

mod behaviour;
mod consistency;
mod oracle;
mod refusals;
