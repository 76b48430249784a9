//! Recordings: a chain's messages in MCAP files that ROS 2 and Foxglove also read.
//!
//! Messages are CDR (little endian), and each file contains their schemas.
//!
//! - [`Recorder`], [`Options`], [`RingOptions`]: record what a rig sends, or keep its last seconds
//! - [`Writer`], [`Topic`], [`Clock`]: one file, its topics and log times
//! - [`Recording`], [`Messages`], [`Entry`]: read a file
//! - [`Record`]: encodes and decodes one kind of message
//! - [`ImageRecord`], [`encode_ropes`]: images and annotations, in ROS 2's and Foxglove's schemas
//!
//! # Topics
//!
//! | topic | schema | log time |
//! |---|---|---|
//! | `/R/frames`, `/R/masks`, `/R/depth` | `lariat_msgs/msg/FrameHeader` | `captured_ns` |
//! | `/R/image`, `/R/mask_image`, `/R/depth_image` | `sensor_msgs/msg/Image` or `CompressedImage`, rows without padding | `captured_ns` |
//! | `/R/truth` | `lariat_msgs/msg/Centerlines` | `captured_ns` |
//! | `/R/centerlines` | `lariat_msgs/msg/Centerlines` | `extracted_ns` |
//! | `/R/descriptors`, `/R/descriptors3` | `lariat_msgs/msg/Descriptors`, `Descriptors3` | `fitted_ns` |
//! | `/R/annotations/ropes`, `/R/annotations/control_points` | `foxglove_msgs/msg/ImageAnnotations` | that of the message they draw |
//! | `/R/losses` | `lariat_msgs/msg/Losses`, in each second with a loss, and at the end | now |
//!
//! `R` is the rig. Annotations are shifted by half a pixel, as Foxglove counts from corners. Masks
//! are compressed as PNG only. Log times are Unix time: `CLOCK_MONOTONIC` plus an offset in the
//! metadata (`lariat`: `monotonic_to_wall_ns`, version, machine). Attached are `lariat.toml`, and
//! `calibration.yaml` and `plane.toml` if the settings name such files.
//!
//! `Losses` contains the chain's losses, counted as in sink, and the recorder's own losses
//! ([`Drops`]).
//!
//! # Recording
//!
//! ```text
//!  channels ──► reader: one copy into a message's bytes ──► queue, bounded in bytes
//!                                                             │
//!                file, in whole chunks ◄── writer thread ◄────┘
//!                         └────── buffers return to the reader ──────►
//! ```
//!
//! - **The chain does not wait.** The recorder (`src/record`) is a separate process. Only
//!   `descriptors` wake the recorder, when a frame's work is done; it polls the other channels
//!   (`looks`). If the queue is full, messages are dropped and counted. Part of the queue is
//!   reserved for small messages. With `--lossless` every message wakes the recorder, which waits
//!   for room.
//! - **A file is never broken.** Chunks (512 KiB, or a second) are built in memory and written at
//!   once. Room for each message, the open chunk and the index is reserved beforehand (`space`), so
//!   a file on a full disk still closes with its index. A failed write is undone to the last whole
//!   chunk (`staged`).
//! - **An old recording** is replaced only with `--force`, once the new one has a chunk with
//!   messages (`place`). Other files are never replaced.
//! - **The ring** keeps encoded messages, bounded in time and bytes. On request, the ring writes
//!   these messages but also keeps them, so two files may overlap.
//!
//! Compression is off by default: lz4 gains nothing on noisy images.
//!
//! # Reading
//!
//! Files are read in parts. The index at the end locates everything (`summary`). If it is missing
//! or damaged, a scan from record to record replaces it (`scan`). Lengths are checked before use,
//! and so are the sizes of unpacked chunks. A chunk with a wrong checksum is reported and skipped.
//! A cursor unpacks chunks into memory that it reuses. A message that it returns is valid until the
//! next is requested. A range selects frames by time, and all messages about these frames. It is
//! resolved from the message indexes, without unpacking.
//!
//! # Known limitations
//!
//! - Depth images and `descriptors3` are recorded, but not read again.
//! - Lariat's own schemas must be those of this release, except for comments.
//! - With `--images png`, YUV stays raw because PNG would round it.
//! - Room cannot be reserved in pipes and devices.

mod annotations;
mod cdr;
mod conversion;
mod foxglove;
mod images;
mod losses;
mod messages;
mod palette;
mod reading;
mod schema;
mod writing;

pub use annotations::{ANNOTATIONS, encode_control_points, encode_ropes};
pub use cdr::{Cdr, CdrError, Decoder, Encoder};
pub use conversion::{Converted, ENCODINGS, convert};
pub use images::{
    COMPRESSED_IMAGE, CompressedImageRecord, IMAGE, ImageRecord, encode_compressed_image,
    encode_image, put_header,
};
pub use losses::Losses;
pub use messages::Record;
pub use palette::rope_color;
pub use reading::{
    About, Entry, Frame, METADATA, Messages, Pixels, Place, READ, Recording, RecordingError, Span,
    TopicSummary, names_a_recording,
};
pub use schema::{ENCODING, SCHEMA_ENCODING, Schema};
pub use writing::{
    Clock, Compression, Drops, Ended, Ending, Existing, Flushed, Head, Images, NoRoom, Options,
    PictureMaker, Recorder, RingOptions, Topic, WriteError, Writer, Written,
};
