//! What a filter's users may rely on.

mod behaviour;
mod consistency;
mod dense;
mod oracle;
mod refusals;
