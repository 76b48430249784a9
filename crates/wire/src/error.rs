//! Errors of this crate. Each message says what to do.

use thiserror::Error;

/// Reason why a domain, a writer or a reader could not be opened, or stopped working.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum WireError {
    /// A rig's name contains characters that are not allowed, or has the wrong length.
    #[error(
        "'{0}' is not a valid rig name: use 1 to 32 of the characters a-z, 0-9, '-' and '_', for example --rig left-arm"
    )]
    RigName(String),
    /// The value of `LARIAT_DOMAIN` is not a valid name.
    #[error(
        "LARIAT_DOMAIN is '{0}': use 1 to 16 of the characters a-z, 0-9, '-' and '_', or unset it"
    )]
    DomainName(String),
    /// `LARIAT_DOMAIN` names the domain of another user.
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
    /// The domain's folder belongs to another user.
    #[error(
        "{folder} belongs to {owner}, and only {owner} can use this domain: run lariat as {owner}, choose another one \
         with LARIAT_DOMAIN=NAME, or, if nothing of {owner}'s runs in it, remove it with 'sudo lariat doctor --clean'"
    )]
    Owner {
        /// The folder.
        folder: String,
        /// Its owner.
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
        /// Its owner.
        owner: String,
    },
    /// The domain's folder cannot be used.
    #[error("{folder} cannot be used ({cause}): make it a folder of yours, or remove it")]
    Folder {
        /// The folder.
        folder: String,
        /// The cause.
        cause: String,
    },
    /// Another process is stuck while it joins or leaves the domain.
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
    /// POSIX shared memory is missing.
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
        /// Size of its slots in MB.
        needed_mb: u64,
        /// Free space in MB.
        available_mb: u64,
    },
    /// The other side was built for another version of a message.
    #[error(
        "{channel} carries {theirs}, and this program was made for {ours}: use the same release of lariat for every process on a rig"
    )]
    Version {
        /// The channel.
        channel: String,
        /// Message type of this program.
        ours: String,
        /// Message type in use.
        theirs: String,
    },
    /// The channel already has its one writer.
    #[error(
        "{channel} already has a writer: stop the other one, or give this one a rig of its own with --rig NAME"
    )]
    SecondWriter {
        /// The channel.
        channel: String,
    },
    /// The channel already has its maximum number of readers.
    #[error("{channel} already has its {most} readers: stop one of them")]
    TooManyReaders {
        /// The channel.
        channel: String,
        /// Maximum number of readers.
        most: usize,
    },
    /// One side wants every message delivered, the other only the newest.
    #[error(
        "{channel} is open {theirs}, and this process was started {ours}: start all stages of a rig with --lossless, or none"
    )]
    Delivery {
        /// The channel.
        channel: String,
        /// Delivery of this process.
        ours: &'static str,
        /// Delivery of the open channel.
        theirs: &'static str,
    },
    /// Files of another user prevent access.
    #[error(
        "no permission for {channel}: it was opened by another user; run every stage of a rig as the same user"
    )]
    Permission {
        /// The channel, or the domain.
        channel: String,
    },
    /// The transport failed, for example because a reader's channel disappeared. Reading again does
    /// not help.
    #[error("{doing} failed ({cause}): stop every lariat process of this rig and start again")]
    Transport {
        /// The operation that failed.
        doing: String,
        /// Cause reported by the transport.
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

/// Maximum number of pixels along a side; the limit of extraction.
pub(crate) const MAX_SIDE: u32 = 8192;

/// Reason why an image was not sent.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum WriteError {
    /// Error of the channel or the transport.
    #[error(transparent)]
    Wire(#[from] WireError),
    /// Another process writes the rig's frames, most likely its own capture.
    #[error(
        "{channel} already has a writer: start the chain with `lariat run --source external`, so that it leaves its frames to this program, stop the other writer, or give this one a rig of its own"
    )]
    FramesTaken {
        /// The channel.
        channel: String,
    },
    /// Invalid image size.
    #[error("Invalid size {width}×{height}: use 1 to {MAX_SIDE} pixels along each side")]
    Size {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
    },
    /// The exposure time is in the future.
    #[error(
        "exposed_ns is {} s in the future: give nanoseconds of CLOCK_MONOTONIC (time.monotonic_ns() in Python, lariat_now_ns() in C), or leave it out for now",
        *ahead_ns / 1_000_000_000
    )]
    Future {
        /// Time from now until the exposure.
        ahead_ns: u64,
    },
    /// The exposure time is not after that of the last image.
    #[error(
        "exposed_ns is {} ms before the last image's: send images in the order in which they were taken",
        *behind_ns as f64 / 1e6
    )]
    Backwards {
        /// Time from the last image back to this one; 0 if both times are equal.
        behind_ns: u64,
    },
    /// The sequence number does not increase.
    #[error(
        "sequence is {given} after {last}: give numbers that rise, from 1 (each one left out counts as a frame lost at the source), or leave it out"
    )]
    Sequence {
        /// The given number.
        given: u64,
        /// The number of the last image.
        last: u64,
    },
    /// There is nothing to send.
    #[error("no slot is on loan: borrow one and fill it before it is sent")]
    NothingOnLoan,
    /// The frame is blank, without pixels to be masked.
    #[error("the frame has no image, and so needs no mask: wait for the next one")]
    NoImage,
}
