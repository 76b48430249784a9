//! From the graph to the rig: images as its frames, their masks, velocities for the simulated
//! rope's grippers, and the camera's calibration.
//!
//! This runs in its own thread, which incoming messages wake; the other thread sleeps until the rig
//! has messages. An image is copied once, from the transport's memory into the slot of shared
//! memory; an image file is decoded into the slot. A frame's number is the publisher's message
//! number, so the whole chain counts a message lost on the way as a frame lost at the source.
//! Unusable messages are counted and reported once.

mod calibration;
mod frames;
mod grippers;
mod masks;
mod pixels;
mod received;
mod stamps;
mod trouble;

use std::cell::RefCell;
use std::future::{Future, poll_fn};
use std::pin::pin;
use std::sync::Arc;
use std::sync::mpsc::{Sender, channel};
use std::task::{Context, Poll};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result};
use futures::channel::oneshot;
use futures::stream::{LocalBoxStream, StreamExt, pending};
use lariat_chain::stop::Stop;
use lariat_wire::{Domain, FrameWriter, MaskWriter, Rig, Waiting};
use ros2_client::ros2::ReadError;
use ros2_client::{MessageInfo, Subscription};

use crate::args::Args;
use crate::graph::{Delivery, Graph};
use calibration::Calibration;
use frames::Frames;
use grippers::Grippers;
use masks::Masks;
use received::{CameraInfo, PictureSeed, TwistStamped};
pub(crate) use stamps::Originals;
use stamps::Stamps;
use trouble::{Tally, Trouble};

/// Time after which a topic without publisher is reported.
const PATIENCE: Duration = Duration::from_secs(5);
/// Messages that may wait for this process; images are large.
const IMAGES_KEPT: usize = 8;
const OTHERS_KEPT: usize = 32;

/// The incoming topics; dropping this ends their thread.
pub(crate) struct Incoming {
    // Dropped first, which ends the thread.
    end: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
    topics: Vec<Expected>,
    originals: Originals,
}

/// A topic that others should publish.
struct Expected {
    what: &'static str,
    name: String,
    /// Such as `sensor_msgs::msg::dds_::Image_`.
    type_name: String,
    tally: Arc<Tally>,
    since: Instant,
    said: Option<String>,
}

/// The subscribed topics.
#[derive(Default)]
struct Feeds {
    image: Option<Feed<Result<u64, Trouble>>>,
    mask: Option<Feed<Result<masks::Taken, Trouble>>>,
    grippers: Vec<Feed<TwistStamped>>,
    camera_info: Option<Feed<CameraInfo>>,
}

/// A subscribed topic. `M` is its type of message, or of the values that are made from its messages
/// on receipt.
struct Feed<M> {
    subscription: Subscription<M>,
    name: String,
    tally: Arc<Tally>,
    /// True if its images are files.
    is_file: bool,
}

impl Incoming {
    /// Subscribes to the requested topics, if any.
    ///
    /// # Errors
    /// A topic's name is invalid, or the rig has another writer.
    pub(crate) fn start(args: &Args, graph: &mut Graph, stop: &Stop) -> Result<Self> {
        let mut incoming = Self {
            end: None,
            thread: None,
            topics: Vec::new(),
            originals: Originals::default(),
        };
        let feeds = incoming.feeds(args, graph)?;
        if incoming.topics.is_empty() {
            return Ok(incoming);
        }
        let (end, ended) = oneshot::channel();
        let (ready, is_ready) = channel();
        let reader = Reader {
            rig: args.rig.clone(),
            by_arrival: args.stamp_on_arrival,
            calibration: args.calibration_out.clone(),
            stop: stop.flag(),
            originals: incoming.originals.clone(),
        };
        let thread = std::thread::Builder::new().name("ros-incoming".to_owned());
        incoming.thread = Some(thread.spawn(move || reader.read(&feeds, ended, &ready))?);
        incoming.end = Some(end);
        is_ready
            .recv()
            .context("what reads the graph has ended")??;
        Ok(incoming)
    }

    fn feeds(&mut self, args: &Args, graph: &mut Graph) -> Result<Feeds> {
        let images = Delivery {
            reliable: args.reliable_images,
            kept: IMAGES_KEPT,
        };
        let others = Delivery {
            reliable: false,
            kept: OTHERS_KEPT,
        };
        let mut feeds = Feeds::default();
        if let Some(name) = &args.image {
            let kind = image_kind(&args.names.topic(name));
            feeds.image = Some(self.feed("images", graph, name, kind, images)?);
        }
        if let Some(name) = &args.mask {
            let kind = image_kind(&args.names.topic(name));
            feeds.mask = Some(self.feed("masks", graph, name, kind, images)?);
        }
        for name in &args.gripper {
            let kind = ("geometry_msgs", "TwistStamped");
            let feed = self.feed("velocities", graph, name, kind, others)?;
            feeds.grippers.push(feed);
        }
        if let Some(name) = &args.camera_info {
            let kind = ("sensor_msgs", "CameraInfo");
            feeds.camera_info = Some(self.feed("camera infos", graph, name, kind, others)?);
        }
        Ok(feeds)
    }

    fn feed<M: 'static>(
        &mut self,
        what: &'static str,
        graph: &mut Graph,
        name: &str,
        (package, kind): (&str, &str),
        delivery: Delivery,
    ) -> Result<Feed<M>> {
        let (name, subscription) = graph.subscription(name, package, kind, delivery)?;
        let tally = Arc::<Tally>::default();
        self.topics.push(Expected {
            what,
            name: name.clone(),
            type_name: format!("{package}::msg::dds_::{kind}_"),
            tally: tally.clone(),
            since: Instant::now(),
            said: None,
        });
        Ok(Feed {
            subscription,
            name,
            tally,
            is_file: kind == COMPRESSED.1,
        })
    }

    /// The original stamps of the newest frames.
    pub(crate) fn originals(&self) -> &Originals {
        &self.originals
    }

    /// Counts of each topic for diagnostics.
    pub(crate) fn values(&self) -> impl Iterator<Item = (String, String)> {
        let topics = self.topics.iter();
        topics.flat_map(|topic| {
            topic
                .tally
                .values(&format!("{} ({})", topic.what, topic.name))
        })
    }

    /// Reports the likely cause if nothing arrives on a topic.
    pub(crate) fn look(&mut self, graph: &Graph) {
        for topic in &mut self.topics {
            if topic.tally.has_come() || topic.since.elapsed() < PATIENCE {
                continue;
            }
            let types = graph.published(&topic.name);
            let trouble = match types.iter().find(|name| **name != topic.type_name) {
                None if types.is_empty() => "no node publishes it yet".to_owned(),
                // The publisher matches: it may be silent, or offer a weaker quality of service
                // than requested.
                None => "a node publishes it, and nothing comes: is its quality of service best effort, and --reliable-images was \
                         said?"
                    .to_owned(),
                Some(other) => format!(
                    "it is of type {}, and {} was expected: a topic of files ends in /compressed",
                    in_ros_words(other),
                    in_ros_words(&topic.type_name)
                ),
            };
            if topic.said.as_ref() != Some(&trouble) {
                eprintln!("lariat-ros2: {}: {trouble}", topic.name);
                topic.said = Some(trouble);
            }
        }
    }
}

impl Drop for Incoming {
    fn drop(&mut self) {
        self.end = None;
        if let Some(thread) = self.thread.take() {
            // The thread has already reported its error, if there was one.
            let _ = thread.join();
        }
    }
}

const COMPRESSED: (&str, &str) = ("sensor_msgs", "CompressedImage");

/// Topics of image files are recognized by the names of `image_transport`.
fn image_kind(topic: &str) -> (&'static str, &'static str) {
    if topic.ends_with("/compressed") {
        COMPRESSED
    } else {
        ("sensor_msgs", "Image")
    }
}

/// Converts `sensor_msgs::msg::dds_::Image_` to `sensor_msgs/msg/Image`.
fn in_ros_words(type_name: &str) -> String {
    let name = type_name.replace("::dds_::", "::").replace("::", "/");
    name.strip_suffix('_').unwrap_or(&name).to_owned()
}

/// State with which the thread is started.
struct Reader {
    rig: Rig,
    by_arrival: bool,
    calibration: Option<std::path::PathBuf>,
    stop: Arc<std::sync::atomic::AtomicBool>,
    originals: Originals,
}

/// Handlers of the incoming messages.
struct Takers {
    frames: Option<RefCell<Frames>>,
    masks: Option<RefCell<Masks>>,
    grippers: Option<Grippers>,
    calibration: Option<Calibration>,
}

impl Reader {
    /// Reads until `ended`. Reports on `ready` when the rig's writers are open, or why they are
    /// not.
    fn read(self, feeds: &Feeds, ended: oneshot::Receiver<()>, ready: &Sender<Result<()>>) {
        // Declared first, so that it is dropped after everything that is in it.
        let domain = match Domain::open() {
            Ok(domain) => domain,
            Err(cause) => return drop(ready.send(Err(cause.into()))),
        };
        let mut takers = match self.takers(feeds, &domain) {
            Ok(takers) => takers,
            Err(cause) => return drop(ready.send(Err(cause))),
        };
        let _ = ready.send(Ok(()));
        let (frames, masks) = (takers.frames.take(), takers.masks.take());
        let mut streams = Streams {
            images: match (&feeds.image, &frames) {
                (Some(feed), Some(take)) => feed.pictures(take),
                _ => pending().boxed_local(),
            },
            masks: match (&feeds.mask, &masks) {
                (Some(feed), Some(take)) => feed.pictures(take),
                _ => pending().boxed_local(),
            },
            grippers: feeds
                .grippers
                .iter()
                .map(|feed| feed.subscription.async_stream().boxed_local())
                .collect(),
            camera_info: match &feeds.camera_info {
                Some(feed) => feed.subscription.async_stream().boxed_local(),
                None => pending().boxed_local(),
            },
        };
        let mut ended = pin!(ended);
        futures::executor::block_on(poll_fn(|cx| {
            loop {
                if ended.as_mut().poll(cx).is_ready() {
                    return Poll::Ready(());
                }
                let taken = [
                    streams.poll_image(cx, frames.as_ref(), masks.as_ref()),
                    streams.poll_mask(cx, masks.as_ref()),
                    streams.poll_grippers(cx, takers.grippers.as_mut()),
                    streams.poll_camera_info(cx, takers.calibration.as_mut()),
                ];
                if !taken.contains(&true) {
                    return Poll::Pending;
                }
            }
        }));
    }

    fn takers(&self, feeds: &Feeds, domain: &Domain) -> Result<Takers> {
        let stamps = || Stamps::new(self.by_arrival);
        let waiting = || Waiting {
            stop: self.stop.clone(),
            ..Waiting::default()
        };
        let frames = match &feeds.image {
            None => None,
            Some(feed) => Some(Frames::new(
                &feed.name,
                feed.is_file,
                FrameWriter::open_in(Domain::open()?, &self.rig, waiting())?,
                stamps(),
                self.originals.clone(),
                feed.tally.clone(),
            )),
        };
        let masks = match (&feeds.mask, &frames) {
            (Some(feed), Some(frames)) => Some(Masks::new(
                &feed.name,
                MaskWriter::open_in(Domain::open()?, &self.rig, waiting())?,
                frames.sent(),
                feed.tally.clone(),
            )),
            _ => None,
        };
        let grippers = match &feeds.grippers[..] {
            [] => None,
            grippers => Some(Grippers::open(
                grippers
                    .iter()
                    .map(|feed| (feed.name.clone(), feed.tally.clone()))
                    .collect(),
                domain,
                &self.rig,
                stamps(),
            )?),
        };
        let calibration = feeds.camera_info.as_ref().map(|feed| {
            Calibration::new(
                &feed.name,
                &self.rig,
                self.calibration.as_deref(),
                feed.tally.clone(),
            )
        });
        Ok(Takers {
            frames: frames.map(RefCell::new),
            masks: masks.map(RefCell::new),
            grippers,
            calibration,
        })
    }
}

impl<M: 'static> Feed<M> {
    /// The images of this feed, each read in the transport's memory.
    fn pictures<'a, F>(&'a self, take: &'a RefCell<F>) -> Read<'a, M>
    where
        F: received::TakePicture<Taken = M>,
    {
        let seed = PictureSeed {
            is_file: self.is_file,
            take,
        };
        self.subscription.async_stream_seed(seed).boxed_local()
    }
}

type Read<'a, M> = LocalBoxStream<'a, Result<(M, MessageInfo), ReadError>>;

/// The incoming messages, one stream per topic.
struct Streams<'a> {
    images: Read<'a, Result<u64, Trouble>>,
    masks: Read<'a, Result<masks::Taken, Trouble>>,
    grippers: Vec<Read<'a, TwistStamped>>,
    camera_info: Read<'a, CameraInfo>,
}

impl Streams<'_> {
    /// This function and the ones below handle one waiting message, if any, and return whether they
    /// did.
    fn poll_image(
        &mut self,
        cx: &mut Context,
        frames: Option<&RefCell<Frames>>,
        masks: Option<&RefCell<Masks>>,
    ) -> bool {
        let Poll::Ready(Some(read)) = self.images.poll_next_unpin(cx) else {
            return false;
        };
        let Some(mut frames) = frames.map(RefCell::borrow_mut) else {
            return false;
        };
        let sent = match read {
            Ok((taken, info)) => frames.send(taken, &info),
            Err(cause) => {
                frames.refuse_unread(&malformed(&cause));
                None
            }
        };
        if let (Some(stamp_ns), Some(masks)) = (sent, masks) {
            masks.borrow_mut().offer(stamp_ns);
        }
        true
    }

    fn poll_mask(&mut self, cx: &mut Context, masks: Option<&RefCell<Masks>>) -> bool {
        let Poll::Ready(Some(read)) = self.masks.poll_next_unpin(cx) else {
            return false;
        };
        if let Some(mut masks) = masks.map(RefCell::borrow_mut) {
            match read {
                Ok((taken, _)) => masks.send(taken),
                Err(cause) => masks.refuse(&malformed(&cause)),
            }
        }
        true
    }

    fn poll_grippers(&mut self, cx: &mut Context, grippers: Option<&mut Grippers>) -> bool {
        let Some(grippers) = grippers else {
            return false;
        };
        let mut came = false;
        for (gripper, stream) in self.grippers.iter_mut().enumerate() {
            let Poll::Ready(Some(read)) = stream.poll_next_unpin(cx) else {
                continue;
            };
            came = true;
            match read {
                Ok((twist, _)) => grippers.send(gripper, &twist),
                Err(cause) => grippers.refuse(gripper, &malformed(&cause)),
            }
        }
        came
    }

    fn poll_camera_info(
        &mut self,
        cx: &mut Context,
        calibration: Option<&mut Calibration>,
    ) -> bool {
        let Poll::Ready(Some(read)) = self.camera_info.poll_next_unpin(cx) else {
            return false;
        };
        if let Some(calibration) = calibration {
            match read {
                Ok((info, _)) => calibration.take(&info),
                Err(cause) => calibration.refuse(malformed(&cause).to_string()),
            }
        }
        true
    }
}

fn malformed(cause: &ReadError) -> Trouble {
    Trouble::Malformed(cause.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_topic_of_files_is_known_by_its_name() {
        assert_eq!(image_kind("/camera/image_raw").1, "Image");
        assert_eq!(image_kind("/camera/image_raw/compressed"), COMPRESSED);
        assert_eq!(
            in_ros_words("sensor_msgs::msg::dds_::Image_"),
            "sensor_msgs/msg/Image"
        );
    }
}
