//! From the rig to the graph, message by message.

use std::path::PathBuf;
use std::time::SystemTime;

use anyhow::Result;
use lariat_camera::Camera;
use lariat_chain::calibrated::{calibration_of, read_camera};
use lariat_chain::stop::Stop;
use lariat_record::{Clock, Record};
use lariat_wire::{Centerlines, Descriptors, Domain, Rig, Status, now_ns};

use crate::args::Args;
use crate::graph::{Graph, Topic, in_ros};
use crate::health::Health;
use crate::incoming::Incoming;
use crate::messages::{self, Header, Scale};
use crate::parameters::Parameters;
use crate::pictures::Pictures;
use crate::rig::{Channels, Wanted};

/// How often diagnostics are said, and the clocks are held against each other.
const SECOND_NS: u64 = 1_000_000_000;
/// Topics of single ropes: as many as a message has ropes.
const MOST_PATHS: usize = lariat_wire::MAX_CURVES;
/// A rope that was not seen for so long has no topic any more.
const PATH_ENDS_NS: u64 = 60 * SECOND_NS;

/// Sends what the rig says, and takes what it is to be told, for as long as no signal comes.
///
/// # Errors
/// The graph or the rig's domain cannot be entered.
pub(crate) fn run(args: &Args) -> Result<()> {
    let stop = Stop::on_signals()?;
    let domain = Domain::open()?;
    while serve(args, &domain, &stop)? == Ended::WithTheGraph {
        eprintln!(
            "lariat-ros2: this process was stopped for a while, and the transport did not go on with it: the graph is entered anew"
        );
    }
    Ok(())
}

/// Why nothing is sent any more.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Ended {
    Asked,
    WithTheGraph,
}

fn serve(args: &Args, domain: &Domain, stop: &Stop) -> Result<Ended> {
    let mut graph = Graph::enter(args)?;
    let incoming = Incoming::start(args, &mut graph, stop)?;
    let mut node = Outgoing::new(args, &mut graph, incoming)?;
    eprintln!(
        "lariat-ros2: rig {} is under {} in ROS domain {}",
        args.rig,
        args.names.topic(&node.prefix),
        args.domain_id()?
    );
    let mut channels = Channels::new(domain, &args.rig);
    while !stop.asked() {
        if channels.is_check_due() {
            if !graph.is_alive() {
                return Ok(Ended::WithTheGraph);
            }
            channels.check(node.wanted(&graph));
        }
        channels.sleep(stop);
        node.every_second(&graph, channels.is_open());
        while let Some(message) = channels.next() {
            node.take(&mut graph, &mut channels, &message)?;
            if stop.asked() || channels.is_check_due() {
                break;
            }
        }
    }
    Ok(Ended::Asked)
}

/// The topics, and what their messages are made with.
struct Outgoing<'a> {
    args: &'a Args,
    prefix: String,
    points: Topic,
    endpoints: Topic,
    markers: Topic,
    descriptors: Topic,
    image: Topic,
    overlay: Topic,
    camera_info: Topic,
    diagnostics: Topic,
    paths: Vec<Path>,
    pictures: Pictures,
    health: Health,
    lens: Lens,
    parameters: Parameters,
    incoming: Incoming,
    clock: Clock,
    second_due_ns: u64,
    frame_id: String,
    camera_frame_id: String,
    said_unit: bool,
    buffer: Vec<u8>,
    picture: Vec<u8>,
}

/// The calibration that the rig goes by.
#[derive(Default)]
struct Lens {
    file: Option<(PathBuf, Option<SystemTime>)>,
    camera: Option<Camera>,
}

impl Lens {
    /// Reads it, where it is another one than before.
    fn look(&mut self, rig: &Rig) {
        let file = calibration_of(rig).map(|path| {
            let changed = path.metadata().and_then(|file| file.modified()).ok();
            (path, changed)
        });
        if file != self.file {
            let path = file.as_ref().map(|(path, _)| path);
            // What is wrong with it the chain has said, which goes by it.
            self.camera = path.and_then(|path| read_camera(path).ok());
            self.file = file;
        }
    }
}

/// The topic of one rope.
struct Path {
    track: u32,
    topic: Topic,
    seen_ns: u64,
}

impl<'a> Outgoing<'a> {
    fn new(args: &'a Args, graph: &mut Graph, incoming: Incoming) -> Result<Self> {
        let prefix = format!("lariat/{}", in_ros(args.rig.as_str()));
        let mut topic = |name: &str, package: &str, kind: &str| {
            graph.publisher(&format!("{prefix}/{name}"), package, kind)
        };
        Ok(Self {
            points: topic("points", "sensor_msgs", "PointCloud2")?,
            endpoints: topic("endpoints", "geometry_msgs", "PoseArray")?,
            markers: topic("markers", "visualization_msgs", "MarkerArray")?,
            descriptors: topic("descriptors", "lariat_msgs", "Descriptors")?,
            image: topic("image/compressed", "sensor_msgs", "CompressedImage")?,
            overlay: topic("overlay/compressed", "sensor_msgs", "CompressedImage")?,
            camera_info: topic("camera_info", "sensor_msgs", "CameraInfo")?,
            diagnostics: topic("diagnostics", "diagnostic_msgs", "DiagnosticArray")?,
            paths: Vec::new(),
            pictures: Pictures::new(args.jpeg_quality),
            health: Health::new(),
            lens: Lens::default(),
            parameters: Parameters::default(),
            incoming,
            clock: Clock::now(),
            second_due_ns: 0,
            frame_id: args.frame_id(),
            camera_frame_id: args.camera_frame_id(),
            said_unit: false,
            buffer: Vec::new(),
            picture: Vec::new(),
            args,
            prefix,
        })
    }

    /// What is to be read for those who listen.
    fn wanted(&self, graph: &Graph) -> Wanted {
        let heard = |topics: &[&Topic]| topics.iter().any(|topic| graph.is_heard(topic));
        let centerlines = heard(&[&self.markers, &self.overlay]);
        let frames = heard(&[&self.image, &self.overlay, &self.camera_info]);
        let shapes = [
            &self.points,
            &self.endpoints,
            &self.descriptors,
            &self.diagnostics,
        ];
        // A rope's own topic is there once the rope was seen, and may be listened to before.
        let path = graph.is_heard_below(&format!("{}/path", self.prefix));
        Wanted {
            descriptors: centerlines || frames || path || heard(&shapes),
            centerlines,
            frames,
        }
    }

    /// What a message says goes to whoever listens.
    fn take(
        &mut self,
        graph: &mut Graph,
        channels: &mut Channels,
        message: &Descriptors,
    ) -> Result<()> {
        self.health.take(message, now_ns());
        self.say_unit(message);
        self.make_paths(graph, message)?;
        let exposed_ns = message.trace.exposed_ns;
        // Of an image that came with a stamp, that one to the last digit.
        let original_ns = self.incoming.originals().of(exposed_ns);
        let stamp_ns = original_ns.unwrap_or_else(|| self.clock.wall_ns(exposed_ns));
        let frame_id = std::mem::take(&mut self.frame_id);
        let header = Header {
            stamp_ns,
            frame_id: &frame_id,
        };
        let sequence = message.trace.sequence;
        // What a control loop steers by goes first, and pictures, which take milliseconds, last.
        let buffer = &mut self.buffer;
        if graph.is_heard(&self.descriptors) {
            message.encode(buffer);
            graph.send(&mut self.descriptors, buffer);
        }
        if graph.is_heard(&self.endpoints) {
            messages::endpoints(message, &header, buffer);
            graph.send(&mut self.endpoints, buffer);
        }
        if graph.is_heard(&self.points) {
            messages::points(message, &header, buffer);
            graph.send(&mut self.points, buffer);
        }
        self.send_paths(graph, message, &header);
        let seen = channels.centerlines_of(sequence);
        let buffer = &mut self.buffer;
        if graph.is_heard(&self.markers) {
            messages::markers(message, seen.as_deref(), &header, buffer);
            graph.send(&mut self.markers, buffer);
        }
        if let Some(frame) = channels.frame_of(sequence) {
            self.send_pictures(graph, frame.header(), &frame, seen.as_deref(), stamp_ns);
        }
        self.frame_id = frame_id;
        Ok(())
    }

    /// Makes the topics of ropes that are seen for the first time: before anything is sent, so that who is sent something finds a process that
    /// makes nothing more.
    fn make_paths(&mut self, graph: &mut Graph, message: &Descriptors) -> Result<()> {
        let now_ns = now_ns();
        for rope in message.curves() {
            if rope.status() == Some(Status::Lost) {
                continue;
            }
            let known = self.paths.iter().position(|path| path.track == rope.track);
            let place = match known {
                Some(place) => place,
                // RustDDS 0.15 waits for itself where a writer is made and its threads have ended.
                None if self.paths.len() < MOST_PATHS && graph.is_alive() => {
                    let name = format!("{}/path/rope_{}", self.prefix, rope.track);
                    let topic = graph.publisher(&name, "nav_msgs", "Path")?;
                    self.paths.push(Path {
                        track: rope.track,
                        topic,
                        seen_ns: now_ns,
                    });
                    self.paths.len() - 1
                }
                None => continue,
            };
            self.paths[place].seen_ns = now_ns;
        }
        self.paths
            .retain(|path| now_ns.saturating_sub(path.seen_ns) < PATH_ENDS_NS);
        Ok(())
    }

    fn send_paths(&mut self, graph: &Graph, message: &Descriptors, header: &Header) {
        for rope in message.curves() {
            let known = self.paths.iter_mut().find(|path| path.track == rope.track);
            if rope.status() != Some(Status::Lost)
                && let Some(path) = known
                && graph.is_heard(&path.topic)
                && messages::path(rope, Scale::of(message), header, &mut self.buffer)
            {
                graph.send(&mut path.topic, &self.buffer);
            }
        }
    }

    fn send_pictures(
        &mut self,
        graph: &Graph,
        frame: &lariat_wire::FrameHeader,
        bytes: &[u8],
        seen: Option<&Centerlines>,
        stamp_ns: u64,
    ) {
        let header = Header {
            stamp_ns,
            frame_id: &self.camera_frame_id,
        };
        if graph.is_heard(&self.camera_info) && !frame.is_blank() {
            messages::camera_info(frame, self.lens.camera.as_ref(), &header, &mut self.buffer);
            graph.send(&mut self.camera_info, &self.buffer);
        }
        let [plain, drawn] = [&self.image, &self.overlay].map(|topic| graph.is_heard(topic));
        if !(plain || drawn)
            || !self
                .pictures
                .plain(frame, bytes, &header, &mut self.picture)
        {
            return;
        }
        if plain {
            graph.send(&mut self.image, &self.picture);
        }
        if let Some(seen) = seen.filter(|_| drawn) {
            let made = self
                .pictures
                .with_ropes(&self.picture, seen, &header, &mut self.buffer);
            if made.is_ok() {
                graph.send(&mut self.overlay, &self.buffer);
            }
        }
    }

    /// Diagnostics, parameters, and the clock's offset, which the keepers of the time of day move.
    fn every_second(&mut self, graph: &Graph, is_open: bool) {
        let now_ns = now_ns();
        if now_ns < self.second_due_ns {
            return;
        }
        self.second_due_ns = now_ns + SECOND_NS;
        self.incoming.look(graph);
        self.parameters.look(&self.args.rig, graph, now_ns);
        if graph.is_heard(&self.camera_info) {
            self.lens.look(&self.args.rig);
        }
        if is_open {
            self.clock = Clock::now();
        }
        if !graph.is_heard(&self.diagnostics) {
            return;
        }
        let topics = [
            &self.points,
            &self.endpoints,
            &self.markers,
            &self.descriptors,
            &self.image,
            &self.overlay,
            &self.camera_info,
        ];
        let paths = self.paths.iter().map(|path| &path.topic);
        let unsent = topics.into_iter().chain(paths).map(Topic::unsent).sum();
        let mut status = self.health.status(self.args.rig.as_str(), unsent, now_ns);
        status.values.extend(self.incoming.values());
        let header = Header {
            stamp_ns: self.clock.wall_ns(now_ns),
            frame_id: "",
        };
        messages::diagnostics(&[status], &header, &mut self.buffer);
        graph.send(&mut self.diagnostics, &self.buffer);
    }

    /// A ROS message's lengths are metres. Where they are not, that is said.
    fn say_unit(&mut self, message: &Descriptors) {
        let in_metres = message.unit() == Some(lariat_wire::Unit::Millimeter);
        if !in_metres && message.width > 0 && !std::mem::replace(&mut self.said_unit, true) {
            eprintln!(
                "lariat-ros2: rig {} has no plane, so that positions are pixels and not metres: `lariat calibrate plane` makes one",
                self.args.rig
            );
        }
    }
}
