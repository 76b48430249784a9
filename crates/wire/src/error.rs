//! What can go wrong on the wire, each as a sentence that says what to do.

use thiserror::Error;

/// Why a domain, a writer or a reader could not be had, or stopped working.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum WireError {
    /// A rig's name has other characters than it may.
    #[error(
        "'{0}' is not a valid rig name: use 1 to 32 of the characters a-z, 0-9, '-' and '_', for example --rig left-arm"
    )]
    RigName(String),
    /// The variable that names the domain holds something unusable.
    #[error(
        "LARIAT_DOMAIN is '{0}': use 1 to 16 of the characters a-z, 0-9, '-' and '_', or unset it"
    )]
    DomainName(String),
    /// The variable names the domain of another user.
    #[error(
        "LARIAT_DOMAIN={name} is the domain of {owner}, which no other user can enter: run lariat as {owner}, unset \
         LARIAT_DOMAIN, or choose a name with a letter in it"
    )]
    DomainOfUser {
        /// The domain.
        name: String,
        /// Its user.
        owner: String,
    },
    /// The domain's folder is another user's.
    #[error(
        "{folder} belongs to {owner}, and only {owner} can use this domain: run lariat as {owner}, choose another one \
         with LARIAT_DOMAIN=NAME, or, if nothing of {owner}'s runs in it, remove it with 'sudo lariat doctor --clean'"
    )]
    Owner {
        /// The folder.
        folder: String,
        /// Whose it is.
        owner: String,
    },
    /// Another user put a file where the domain's shared memory is.
    #[error(
        "{file} belongs to {owner}, and lies where this domain's shared memory is: have it removed with 'sudo lariat doctor --clean', \
         or choose another domain with LARIAT_DOMAIN=NAME"
    )]
    Intruder {
        /// The file.
        file: String,
        /// Whose it is.
        owner: String,
    },
    /// The domain's folder cannot be used.
    #[error("{folder} cannot be used ({cause}): make it a folder of yours, or remove it")]
    Folder {
        /// The folder.
        folder: String,
        /// Why.
        cause: String,
    },
    /// Another process joins or leaves the domain, and does not come to an end.
    #[error(
        "{holder} has been joining or leaving the domain of {folder} for 2 s and keeps all others from it: let it go on if it \
         was stopped (kill -CONT), or end it (kill -9)"
    )]
    Held {
        /// The domain's folder.
        folder: String,
        /// The process.
        holder: String,
    },
    /// The system has no POSIX shared memory.
    #[error(
        "there is no shared memory at /dev/shm ({0}): mount it with 'mount -t tmpfs tmpfs /dev/shm', or start the container with --ipc=host"
    )]
    NoSharedMemory(String),
    /// `/dev/shm` cannot hold the slots of a channel.
    #[error(
        "/dev/shm has {available_mb} MB free, and {channel} needs {needed_mb} MB: free some, make it larger ('mount -o remount,size=1G /dev/shm', or --shm-size=1g for a container), or use smaller images"
    )]
    TooLittleSpace {
        /// The channel whose slots do not fit.
        channel: String,
        /// What its slots take, in MB.
        needed_mb: u64,
        /// What is free, in MB.
        available_mb: u64,
    },
    /// The other side was built for another version of a message.
    #[error(
        "{channel} carries {theirs}, and this program was made for {ours}: use the same release of lariat for every process on a rig"
    )]
    Version {
        /// The channel.
        channel: String,
        /// The message type in this program.
        ours: String,
        /// The message type in use.
        theirs: String,
    },
    /// A channel has one writer, and it is there already.
    #[error(
        "{channel} already has a writer: stop the other one, or give this one a rig of its own with --rig NAME"
    )]
    SecondWriter {
        /// The channel.
        channel: String,
    },
    /// As many readers as a channel can have are there already.
    #[error("{channel} already has its {most} readers: stop one of them")]
    TooManyReaders {
        /// The channel.
        channel: String,
        /// How many it can have.
        most: usize,
    },
    /// One side wants every message delivered, the other the newest.
    #[error(
        "{channel} is open {theirs}, and this process was started {ours}: start all stages of a rig with --lossless, or none"
    )]
    Delivery {
        /// The channel.
        channel: String,
        /// How this process wants it.
        ours: &'static str,
        /// How it is open.
        theirs: &'static str,
    },
    /// Files of another user are in the way.
    #[error(
        "no permission for {channel}: it was opened by another user; run every stage of a rig as the same user"
    )]
    Permission {
        /// The channel, or the domain.
        channel: String,
    },
    /// A reader's channel went away in a way that reading again will not mend, or the transport failed otherwise.
    #[error("{doing} failed ({cause}): stop every lariat process of this rig and start again")]
    Transport {
        /// What was being done.
        doing: String,
        /// The transport's own word for it.
        cause: String,
    },
}

impl WireError {
    pub(crate) fn transport(doing: impl Into<String>, cause: impl std::fmt::Debug) -> Self {
        Self::Transport {
            doing: doing.into(),
            cause: format!("{cause:?}"),
        }
    }
}

/// Most pixels along a side: what extraction takes.
pub(crate) const MAX_SIDE: u32 = 8192;

/// Why an image was not sent.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum WriteError {
    /// The channel or the transport.
    #[error(transparent)]
    Wire(#[from] WireError),
    /// Somebody else writes the rig's frames, most likely its own capture.
    #[error(
        "{channel} already has a writer: start the chain with `lariat run --source external`, so that it leaves its frames to this program, stop the other writer, or give this one a rig of its own"
    )]
    FramesTaken {
        /// The channel.
        channel: String,
    },
    /// A size that no image has here.
    #[error("Invalid size {width}×{height}: use 1 to {MAX_SIDE} pixels along each side")]
    Size {
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// A moment that is still to come.
    #[error(
        "exposed_ns is {} s in the future: give nanoseconds of CLOCK_MONOTONIC (time.monotonic_ns() in Python, lariat_now_ns() in C), or leave it out for now",
        *ahead_ns / 1_000_000_000
    )]
    Future {
        /// How far ahead.
        ahead_ns: u64,
    },
    /// A moment that is not after the last image's.
    #[error(
        "exposed_ns is {} ms before the last image's: send images in the order in which they were taken",
        *behind_ns as f64 / 1e6
    )]
    Backwards {
        /// How far behind; 0: the same moment.
        behind_ns: u64,
    },
    /// A number that does not rise.
    #[error(
        "sequence is {given} after {last}: give numbers that rise, from 1 (each one left out counts as a frame lost at the source), or leave it out"
    )]
    Sequence {
        /// The number given.
        given: u64,
        /// The last image's.
        last: u64,
    },
    /// There is nothing to send.
    #[error("no slot is on loan: borrow one and fill it before it is sent")]
    NothingOnLoan,
    /// A blank frame has no pixels to be masked.
    #[error("the frame has no image, and so needs no mask: wait for the next one")]
    NoImage,
}
