//! The whole chain, on the real binary: real processes, real shared memory, and their ends.

mod arrangement;
mod blank;
mod cameras;
mod curves;
mod deaths;
mod external;
mod frames;
mod fused;
mod masks;
mod messages;
mod outputs;
mod piped;
mod restarts;
mod rig;
mod screen;
mod simulated;
mod sink;
mod sources;
mod space;
mod topic;
mod users;
