//! Guarantees of a filter.

mod behaviour;
mod consistency;
mod oracle;
mod refusals;
