//! From the rig to the graph, message by message.

mod paths;

use std::path::PathBuf;
use std::time::SystemTime;

use anyhow::Result;
use lariat_camera::Camera;
use lariat_chain::calibrated::{calibration_of, read_camera};
use lariat_chain::stop::Stop;
use lariat_record::{Clock, Record};
use lariat_wire::{Centerlines, Descriptors, Domain, FrameHeader, Rig, now_ns};

use crate::args::Args;
use crate::graph::{Graph, Topic, in_ros};
use crate::health::Health;
use crate::incoming::Incoming;
use crate::messages::{self, Header, Shapes};
use crate::parameters::Parameters;
use crate::pictures::Pictures;
use crate::rig::{Channels, Space, Wanted};
use paths::Paths;

/// Interval at which diagnostics are sent and the clocks are compared.
const SECOND_NS: u64 = 1_000_000_000;

/// Publishes the rig's messages, and handles incoming ones, until a signal arrives.
///
/// # Errors
/// The graph or the rig's domain cannot be joined.
pub(crate) fn run(args: &Args) -> Result<()> {
    let stop = Stop::on_signals()?;
    let domain = Domain::open()?;
    while serve(args, &domain, &stop)? == Ended::WithTheGraph {
        eprintln!(
            "lariat-ros2: this process was stopped for a while, and the transport did not continue with it: the graph is entered again"
        );
    }
    Ok(())
}

/// Reason why publishing ended.
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

/// The topics, and the state for making their messages.
struct Outgoing<'a> {
    args: &'a Args,
    prefix: String,
    points: Topic,
    endpoints: Topic,
    markers: Topic,
    descriptors: Topic,
    descriptors3: Topic,
    image: Topic,
    overlay: Topic,
    camera_info: Topic,
    diagnostics: Topic,
    paths: Paths,
    pictures: Pictures,
    health: Health,
    lens: Lens,
    parameters: Parameters,
    incoming: Incoming,
    clock: Clock,
    second_due_ns: u64,
    camera_frame_id: String,
    said_unit: bool,
    buffer: Vec<u8>,
    picture: Vec<u8>,
}

/// The calibration that the rig uses.
#[derive(Default)]
struct Lens {
    file: Option<(PathBuf, Option<SystemTime>)>,
    camera: Option<Camera>,
}

impl Lens {
    /// Reads the calibration if it has changed.
    fn look(&mut self, rig: &Rig) {
        let file = calibration_of(rig).map(|path| {
            let changed = path.metadata().and_then(|file| file.modified()).ok();
            (path, changed)
        });
        if file != self.file {
            let path = file.as_ref().map(|(path, _)| path);
            // The chain uses the same file and has already reported any error in it.
            self.camera = path.and_then(|path| read_camera(path).ok());
            self.file = file;
        }
    }
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
            descriptors3: topic("descriptors3", "lariat_msgs", "Descriptors3")?,
            image: topic("image/compressed", "sensor_msgs", "CompressedImage")?,
            overlay: topic("overlay/compressed", "sensor_msgs", "CompressedImage")?,
            camera_info: topic("camera_info", "sensor_msgs", "CameraInfo")?,
            diagnostics: topic("diagnostics", "diagnostic_msgs", "DiagnosticArray")?,
            paths: Paths::of(&prefix),
            pictures: Pictures::new(args.jpeg_quality),
            health: Health::new(),
            lens: Lens::default(),
            parameters: Parameters::default(),
            incoming,
            clock: Clock::now(),
            second_due_ns: 0,
            camera_frame_id: args.camera_frame_id(),
            said_unit: false,
            buffer: Vec::new(),
            picture: Vec::new(),
            args,
            prefix,
        })
    }

    /// The channels that the current subscribers need.
    fn wanted(&self, graph: &Graph) -> Wanted {
        let heard = |topics: &[&Topic]| topics.iter().any(|topic| graph.is_heard(topic));
        let centerlines = heard(&[&self.markers, &self.overlay]);
        let frames = heard(&[&self.image, &self.overlay, &self.camera_info]);
        let shapes = [
            &self.points,
            &self.endpoints,
            &self.descriptors,
            &self.descriptors3,
            &self.diagnostics,
        ];
        // A rope's own topic exists only after the rope was detected, but may have subscribers
        // before that.
        let path = graph.is_heard_below(self.paths.prefix());
        Wanted {
            descriptors: centerlines || frames || path || heard(&shapes),
            centerlines,
            frames,
        }
    }

    /// Publishes the contents of a message to the subscribers.
    fn take(
        &mut self,
        graph: &mut Graph,
        channels: &mut Channels,
        message: &Descriptors,
    ) -> Result<()> {
        let sequence = message.trace.sequence;
        let space = channels.space_of(sequence);
        let shapes = match &space {
            Space::None => Some(Shapes::Flat(message)),
            Space::Of(space) => Some(Shapes::InSpace(space)),
            Space::Missing => None,
        };
        self.health.take(message, shapes, now_ns());
        self.say_unit(message, shapes);
        self.paths.make(graph, message)?;
        let exposed_ns = message.trace.exposed_ns;
        // If the image came with a stamp, exactly that stamp is published.
        let original_ns = self.incoming.originals().of(exposed_ns);
        let stamp_ns = original_ns.unwrap_or_else(|| self.clock.wall_ns(exposed_ns));
        // Descriptors for control loops come first; images, which take milliseconds, come last.
        if graph.is_heard(&self.descriptors) {
            message.encode(&mut self.buffer);
            graph.send(&mut self.descriptors, &self.buffer);
        }
        let seen = channels.centerlines_of(sequence);
        // For a rig in space, nothing is published about a frame whose message in space is missing.
        if let Some(shapes) = shapes {
            self.send_shapes(graph, shapes, seen.as_deref(), stamp_ns);
        }
        if let Some(frame) = channels.frame_of(sequence) {
            self.send_pictures(graph, frame.header(), &frame, seen.as_deref(), stamp_ns);
        }
        Ok(())
    }

    fn send_shapes(
        &mut self,
        graph: &Graph,
        shapes: Shapes,
        seen: Option<&Centerlines>,
        stamp_ns: u64,
    ) {
        let header = Header {
            stamp_ns,
            frame_id: &self.args.frame_id(shapes.axes()),
        };
        let buffer = &mut self.buffer;
        if let Shapes::InSpace(message) = shapes
            && graph.is_heard(&self.descriptors3)
        {
            message.encode(buffer);
            graph.send(&mut self.descriptors3, buffer);
        }
        let sure = shapes.sure();
        if graph.is_heard(&self.endpoints) {
            messages::endpoints(&sure, &header, buffer);
            graph.send(&mut self.endpoints, buffer);
        }
        if graph.is_heard(&self.points) {
            messages::points(shapes, &header, buffer);
            graph.send(&mut self.points, buffer);
        }
        self.paths.send(graph, &sure, &header, buffer);
        if graph.is_heard(&self.markers) {
            let crossed = match shapes {
                Shapes::Flat(message) => seen.map(|seen| (message, seen)),
                Shapes::InSpace(_) => None,
            };
            messages::markers(&sure, crossed, &header, buffer);
            graph.send(&mut self.markers, buffer);
        }
    }

    fn send_pictures(
        &mut self,
        graph: &Graph,
        frame: &FrameHeader,
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

    /// Updates diagnostics, parameters, and the clock's offset, which changes when the wall clock
    /// is adjusted.
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
            &self.descriptors3,
            &self.image,
            &self.overlay,
            &self.camera_info,
        ];
        let topics = topics.into_iter().chain(self.paths.topics());
        let unsent = topics.map(Topic::unsent).sum();
        let mut status = self.health.status(self.args.rig.as_str(), unsent, now_ns);
        status.values.extend(self.incoming.values());
        let header = Header {
            stamp_ns: self.clock.wall_ns(now_ns),
            frame_id: "",
        };
        messages::diagnostics(&[status], &header, &mut self.buffer);
        graph.send(&mut self.diagnostics, &self.buffer);
    }

    /// Reports once that positions are pixels, because lengths in ROS messages should be meters.
    fn say_unit(&mut self, message: &Descriptors, shapes: Option<Shapes>) {
        let is_flat = matches!(shapes, Some(Shapes::Flat(_)));
        let in_pixels = message.unit() != Some(lariat_wire::Unit::Millimeter);
        if is_flat
            && in_pixels
            && message.width > 0
            && !std::mem::replace(&mut self.said_unit, true)
        {
            eprintln!(
                "lariat-ros2: rig {} has no plane, so that positions are pixels and not metres: `lariat calibrate plane` makes one",
                self.args.rig
            );
        }
    }
}
