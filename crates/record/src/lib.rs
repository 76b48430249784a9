//! Recordings: what a chain saw and said, in MCAP files that ROS 2 and Foxglove read too.
//!
//! Every message is CDR, as ROS 2 has it, and its schema stands in the file. Each [`Record`] is one kind of message, both
//! ways; images and what is drawn over them are in the field's own schemas ([`ImageRecord`], [`encode_ropes`]).
//!
//! # Recording
//!
//! `crates/record` (`writing/`), `src/record/`. The recorder is a process of its own, a fifth child of the chain or one that the user
//! starts: one more reader of every channel, of ordinary priority, and never on the core that `--realtime` has for the stages. It
//! is up before capture starts and is told to stop when all stages have ended, so that everything sent is in the file.
//!
//! ```text
//!  channels ──► reader: one copy out of shared memory, into the bytes of the message ──► queue, bounded in bytes
//!                                                                                          │
//!               file, by whole chunks ◄── writer: picture or not, chunk, compression ◄─────┘
//!                         └──────────────── buffers go back to the reader ────────────────►
//! ```
//!
//! **It does not slow the chain.** Its receivers are unwoken but for `descriptors`: one wake a frame, when the frame's work is done.
//! So that frames are not missed where descriptors are slow or do not come, it looks by itself one and a half frame periods
//! after the last look (three frames have room to wait), less and less often while nothing comes, twice a second at rest
//! (`looks`). A message is encoded straight from shared memory into a buffer that goes to the writer and comes back (`queue`):
//! no allocation a frame once the pool has grown. Full, it drops and counts; a part is kept for small messages, so that
//! images that find no room do not take the shapes with them. With `--lossless` it is woken for every message and waits.
//!
//! **A file is never broken** (`writer`, `staged`, `space`). A chunk (4 MiB, or a second) is built in memory and written in one go.
//! Before a message is taken in, room is reserved (`fallocate`, which leaves the length) for it, the open chunk and the index at the
//! end, by upper bounds that a property test holds against what is written; the file size limit is looked at as well. So a full disk
//! refuses a message, and the file is closed with an index in the room that was kept. A write that fails all the same (a broken
//! disk; a file system that cannot reserve) is undone to the last whole chunk, and an end without an index put behind it.
//!
//! | topic | schema | log time |
//! |---|---|---|
//! | `/R/frames` | `lariat_msgs/msg/FrameHeader` | `captured_ns` |
//! | `/R/image` | `sensor_msgs/msg/Image`, tight rows; or `CompressedImage` | `captured_ns` |
//! | `/R/masks`, `/R/mask_image` | as the two above; PNG where images are compressed | `captured_ns` |
//! | `/R/depth`, `/R/depth_image` | as the first two, `mono16`, as it is; not read again | `captured_ns` |
//! | `/R/truth` | `lariat_msgs/msg/Centerlines` | `captured_ns` |
//! | `/R/centerlines` | `lariat_msgs/msg/Centerlines` | `extracted_ns` |
//! | `/R/descriptors` | `lariat_msgs/msg/Descriptors` | `fitted_ns` |
//! | `/R/descriptors3` | `lariat_msgs/msg/Descriptors3`; not read again | `fitted_ns` |
//! | `/R/annotations/ropes`, `/R/annotations/control_points` | `foxglove_msgs/msg/ImageAnnotations`, half a pixel on: it counts from the corner | as what they draw |
//! | `/R/losses` | `lariat_msgs/msg/Losses`: each second in which something was lost, and last | now |
//!
//! `R` is the rig. All are CDR, little endian; of lists only what is meant is written. Log times are Unix time: `CLOCK_MONOTONIC` and one offset,
//! fixed at the start and written in the metadata (`lariat`: `monotonic_to_wall_ns`, version, machine, how it was made), so that the sum
//! can be undone to the bit; what `trace` holds is exact anyway. An image's stamp is when it was taken. YUV stays raw with
//! `--images png`, which would round it. Attached are `lariat.toml` (all settings that hold), `calibration.yaml` and `plane.toml` if
//! the settings name such files: of a chain its own, of a rig that is recorded from outside what its stages say of themselves
//! (the roster), again after each restart that changed them.
//!
//! **Losses** in the file are of two kinds: the chain's, from the counters, as sink (`ARCHITECTURE.md`) has them; and the
//! recorder's own (what overflowed before it looked, from the same counters, and what found no room in the queue). A frame is in
//! the file whole, or its image is counted. Descriptors that did not reach the recorder are lost after fit.
//!
//! **The ring** holds encoded messages (pictures as pictures) of the last seconds, bounded in bytes, in the queue's own buffers. When it is
//! asked for, they are written between the messages that come in, and kept: two files may overlap.
//!
//! **The chain's latency** stays as it is because nothing of the chain waits for the recorder: it is started after the sink, since a channel's
//! readers are woken in the order in which they came, and the other way round the sink was woken onto a busy core: p99 1.6 × instead
//! of 1.06. Under `SCHED_IDLE` the writing thread cost the chain less still when it compresses with zstd, and would starve on a machine
//! whose cores others keep busy; so it has no priority of its own. Nothing is compressed unless asked: lz4 halves the speed and saves
//! nothing on images with a camera's noise.
//!
//! **If it ends early** (killed, no room, SIGTERM) the chain says so and goes on, and its exit code is 1 at the end. A recording
//! that is there already is replaced only with `--force`, and what is no recording never. The old one stays until the new one has a chunk with
//! messages in it: it grows beside it till then (`place`). Into a pipe or a device chunks go one after the other, without room reserved.
//!
//! # Recordings, read
//!
//! **Reading** (`crates/record/src/reading`). A file is read at places and never as a whole. If it was closed, its summary tells
//! where everything is (`summary`); if not, or if that is damaged, a walk from record to record does (`scan`): chunks are leapt
//! over, unpacked are only those with topics not yet known, and the last one, which alone can be torn. Records are taken apart by
//! fields of our own (`fields`, `layout`), not by the mcap crate's, which slice out of range on short attachments: no length is
//! believed before its bytes are there, and a chunk no larger than its compression can have made it (255 : 1 for lz4, 32 KiB : 1
//! for zstd). A chunk whose checksum is not that of its bytes is told of and passed over. A cursor (`cursor`) unpacks one
//! chunk after the other into memory that it keeps, and lends each message until the next: images where they lie, without a copy.
//! A frame's header waits for the image of the same log time. Parts are chosen by frames' times, found in the message indexes
//! without unpacking; what was made of a frame belongs to its part. Lariat's own schemas must be this release's, but for comments.
//!
//! **Computing again** (`src/replay`). The pipeline takes messages wherever these lie; `replay/stages` hands it recorded ones. `crates/chain/src/recorded` brings together what the channels said of one frame: complete when each
//! channel has told of it or has gone on to a later frame. `--check` goes by the counters in the traces: extract is handed the frames that
//! have centerlines, fit the recorded centerlines that have descriptors; a counter that is 1 again is a stage restarted; a gap is
//! a message that the recorder did not get, so that the past is not known and the check impossible. To the bit where architecture
//! and processor are those in the metadata, else within 10⁻⁹ px (numbers that are no positions: relatively). `--compare` runs the
//! recorded settings beside the new ones, frame by frame in turns, each first in half of the frames, so that times are of one run; errors
//! are `crates/sink`'s, against the truth or, without one, against the recorded centerlines.

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
