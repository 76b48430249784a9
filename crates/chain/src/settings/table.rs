//! The table of all settings: the file, the command line and their helps are made of it.

use crate::settings::curve::Family;
use crate::settings::flags::Flag;
use crate::settings::keys::Key;
use crate::settings::kind::{
    ABOVE_0, AT_LEAST_0, Between, By, Controls, Kind, MEGABYTES, MICROSECONDS, Maybe, Named, PATH,
    SECONDS, SWITCH, TEXT, Takes, Whole,
};
use crate::settings::{arrangement, camera, meaning, range, recording, run, view};
use lariat_capture::Position;
use lariat_extract::Method;
use lariat_fit::{Knots, MAX_CONTROL_POINTS, MAX_ORDER, MAX_POINTS, Rho, Solver};
use lariat_wire::MAX_CURVES;
use toml::Value;

// A row is a setting: its field in `Settings`, which begins with its section; `as` its name, if the field's is another;
// its kind; and what it does. If it has a flag, then as the help shows it; the commands that have it, beside `run` and
// those that take all that `run` does; its heading in the help; and a line for `-h`. `--help` shows what the setting does.
macro_rules! keys {
    ($($section:ident $(.$field:ident)+ $(as $name:ident)?: $kind:expr, $about:literal $(, $flag:literal, $of:expr, $heading:literal, $help:literal)?;)*) => {
        &[$(Key {
            section: stringify!($section),
            name: last(&[$(stringify!($field),)+ $(stringify!($name))?]),
            about: $about,
            set: |s, value| $kind.set(&mut s.$section $(.$field)+, value),
            get: |s| $kind.shown(&s.$section $(.$field)+),
            takes: || $kind.takes(),
            example: || $kind.example(),
            flag: keys!(@flag $($flag, $of, $heading, $help)?),
        }),*]
    };
    (@flag) => { None };
    (@flag $usage:literal, $of:expr, $heading:literal, $help:literal) => {
        Some(Flag { usage: $usage, of: $of, heading: $heading, help: $help })
    };
}

const fn last(names: &[&'static str]) -> &'static str {
    names[names.len() - 1]
}

const STAGES: &str = "capture extract fit sink";
const SEEN: &str = "extract trace replay";
const SHAPES: &str = "fit trace replay";

const PLACE: By<Position> = By(range::position, range::position_value, Takes::Whole);

pub(super) const KEYS: &[Key] = keys! {
    run.rig: By(meaning::rig, |rig| Value::String(rig.clone()), Takes::Text),
        "Name of this camera chain, so that several run side by side: 1 to 32 of a-z, 0-9, _ and -.",
        "--rig NAME", "capture extract fit sink record", "Run", "Name of the chain, to run several";
    run.lossless: SWITCH,
        "Let capture wait for slow readers instead of skipping frames (for files, not for a live robot).",
        "--lossless", "capture extract fit sink record", "Run", "Wait for slow readers, lose no frame";
    run.duration as duration_s: Maybe("10", SECONDS),
        "Stop after this many seconds.",
        "--duration TIME", "capture sink record", "Run", "Stop after this long, such as 10s or 2m";
    run.frames: Maybe("1000", Whole(1..=u64::MAX)),
        "Stop after this many frames.",
        "--frames COUNT", "capture sink record", "Run", "Stop after this many frames";
    run.out: Maybe("\"report\"", PATH),
        "Write the report (table, histograms, summary.json) into this folder.",
        "--out DIR", "sink", "Report", "Write the report into this folder";
    run.trace: Maybe("\"timeline.json\"", PATH),
        "Write when each stage worked on each of the last 1,000 frames into this file, for ui.perfetto.dev.",
        "--trace FILE.json", "sink", "Report", "Write a timeline for ui.perfetto.dev";
    run.record: Maybe("\"run.mcap\"", PATH),
        "Record what the chain sees and says into this file, which `lariat replay`, ROS 2 and Foxglove read.",
        "--record FILE.mcap", "", "Recording", "Record what the chain sees and says";
    run.deadline as deadline_us: Maybe("33000", MICROSECONDS),
        "A descriptor later than this after its image counts as a miss, in microseconds; if not set,\n\
         the time between two frames.",
        "--deadline TIME", "sink", "Report", "Latency that counts as a miss, such as 33ms";
    run.fuse: SWITCH,
        "Run capture, extract and fit in one process (`lariat run`): waits are a fifth shorter, but a crash of one ends all.",
        "--fuse", "", "Run", "Capture, extract and fit in one process";
    run.daemon: SWITCH,
        "Nobody looks on: no line of figures is shown, and `restart` is \"on-failure\" if nothing else is said.",
        "--daemon", "", "Run", "Unattended: no live line, --restart on-failure";
    run.restart: Named("ways", &run::RESTARTS),
        "When a stage is started anew in its place, while the others and all readers go on: \"never\" (its chain ends with it),\n\
         \"on-failure\" (it died, hangs, or was told to end by another than its chain), or \"always\" (also when its source has ended).",
        "--restart WHEN", "", "Run", "Start a stage anew that fell: on-failure";
    run.max_restarts: Whole(1..=1_000_000),
        "How often stages are started anew within `restart_window_s` before the chain gives up and ends. With `daemon` it\n\
         never gives up, and retries every 5 s.";
    run.restart_window as restart_window_s: SECONDS,
        "See `max_restarts`, in seconds.";
    run.hang as hang_s: SECONDS,
        "A stage that stands still for so many seconds while work waits for it hangs, and is started anew (not with lossless, where\n\
         each waits for the next).";
    run.start_limit as start_limit_s: SECONDS,
        "Fail a stage that is not ready after this many seconds.";
    run.watch: SWITCH,
        "Take a change of the settings file while the chain runs, as `lariat set` does.",
        "--watch", "", "Run", "Take changes of the settings file while it runs";
    run.arrangement.realtime: SWITCH,
        "For a robot: FIFO scheduling, locked memory, and the stages on cores as `cpus` says. What of it this user\n\
         may not have is said in a sentence, and the chain runs without.",
        "--realtime", STAGES, "Real time", "FIFO scheduling, locked memory, chosen cores";
    run.arrangement.cpus: By(arrangement::cpus, arrangement::cpus_value, Takes::Text),
        "The cores of capture, extract, fit and sink: [0, 0, 1, 1], or of some of them: { extract = 1 }. \"none\": where\n\
         the kernel likes. \"auto\": likewise; with realtime as was measured to be best.",
        "--cpus CORES", STAGES, "Real time", "Core of each stage, such as 0,0,1,1";
    run.arrangement.scheduling: Named("classes", &arrangement::SCHEDULING),
        "The kernel's scheduling class of the stages: \"other\" as all programs, or \"fifo\", before all of them.",
        "--scheduling CLASS", STAGES, "Real time", "Scheduling class";
    run.arrangement.priority: Whole(1..=arrangement::MAX_PRIORITY),
        "Capture's priority under FIFO, 1 to 96; extract, fit and sink have 1, 2 and 3 more, so that a frame on its way\n\
         goes before the next one.",
        "--priority N", STAGES, "Real time", "Priority of capture under FIFO";
    run.arrangement.lock_memory: SWITCH,
        "Keep the stages' memory from being paged out.",
        "--lock-memory", STAGES, "Real time", "Keep memory from being paged out";
    run.arrangement.wake: Named("ways", &arrangement::WAKES),
        "How a stage learns of a message: woken (\"event\"), or looking for it for a while before it sleeps (\"spin\": faster,\n\
         for a machine with a core for each stage and nothing else to do).",
        "--wake HOW", "extract fit sink", "Real time", "How a stage learns of a message";
    run.arrangement.spin as spin_us: By(arrangement::spin, arrangement::spin_value, MICROSECONDS.takes()),
        "For how long it looks, in microseconds: at most 10000.",
        "--spin TIME", "extract fit sink", "Real time", "How long --wake spin looks, such as 50us";

    capture.source: By(meaning::paths, |paths| meaning::paths_value(paths), Takes::Paths),
        "\"rendered\" (a rope drawn by lariat), \"simulated\" (one held by grippers), \"external\" (frames that a program of\n\
         yours writes), a camera (\"/dev/video0\", or better a name in /dev/v4l/by-id, which\n\
         stays), a recording (.mcap), or a picture, a folder of pictures or a Y4M or MJPEG video, or a list of them. \"-\": standard input, a\n\
         Y4M video, or frames as they are (then size and pixel_format say what they are).",
        "--source PATH", "capture snapshot", "Source", "Camera, pictures, video, recording, external or -";
    capture.fps: By(meaning::fps, meaning::fps_value, Takes::Number),
        "Frames per second, or \"max\". \"auto\": as many as a camera has, as a video or a recording was made, as they come on\n\
         standard input, 30 of all else.",
        "--fps NUMBER", "capture sink snapshot trace", "Source", "Frames per second, `max` or `auto`";
    capture.size: By(meaning::size, meaning::size_value, Takes::Text),
        "Width and height in pixels, 64 to 8192, of a camera's picture or the rendered one: [640, 480]. \"auto\": that, or\n\
         what a camera has near it.",
        "--size WxH", "capture snapshot trace", "Source", "Size of a camera's, rendered or raw picture";
    capture.seed: Whole(0..=u64::MAX),
        "Which of all rendered or simulated ropes: the same number makes the same rope on every machine.",
        "--seed NUMBER", "capture snapshot", "Source", "Which of all rendered or simulated ropes";
    capture.looped as loop: SWITCH,
        "Begin again after the last file.",
        "--loop", "capture", "Source", "Begin again after the last file";
    capture.range.from: Maybe("120", PLACE),
        "Of pictures or a video, begin with this frame: its number, from 1, or a time, \"2.5s\", by the video's own rate\n\
         or the pictures' fps.",
        "--from PLACE", "capture trace", "Source", "Begin with this frame, or time such as 2.5s";
    capture.range.to: Maybe("\"10s\"", PLACE),
        "And end with this frame, or before this time.",
        "--to PLACE", "capture trace", "Source", "End with this frame, or before this time";
    capture.range.every: By(range::every, range::every_value, Takes::Whole),
        "Show every Nth of them only: 3 is the first, the fourth, the seventh, ...",
        "--every N", "capture trace", "Source", "Show every Nth frame only";
    capture.follow: SWITCH,
        "Show what is in the folder, and then each picture as it comes, once it is closed or moved there.",
        "--follow", "capture", "Source", "Show each picture that comes into a folder";
    capture.topic: Maybe("\"/left/image_raw\"", TEXT),
        "Which images of a recording are shown, if it has those of several cameras; `lariat info` lists them.",
        "--topic TOPIC", "capture trace", "Source", "Of a recording with several cameras, the images";
    capture.depth_images: Maybe("\"depth/\"", PATH),
        "Depth images beside the source's pictures: a folder of PNG files of 16 bits, one for each, in the same order. camera.depth\n\
         says what they are.",
        "--depth-images PATH", "capture", "Source", "Depth images beside the pictures: a folder";
    capture.depth_source: Maybe("\"/dev/video2\"", PATH),
        "A depth camera beside the source, which is a camera, too: a node that gives Z16 or Y16, as `lariat devices` lists it, or better a\n\
         name in /dev/v4l/by-id. camera.depth says what it is; its images have that file's size.",
        "--depth-source PATH", "capture", "Camera", "Depth camera beside the camera: /dev/video2";
    capture.depth_within as depth_within_us: Maybe("20000", MICROSECONDS),
        "Of that camera each frame has the image nearest in time, taken no more than this before or after it, in microseconds. If not\n\
         set, three fifths of the time between two of its images.";
    capture.camera.pixel_format: By(camera::pixel_format, camera::pixel_format_value, Takes::Text),
        "A camera's pixel format, such as \"yuyv\" or \"mjpg\", as `lariat devices` lists them. \"auto\": the best for the mask.\n\
         Of raw frames on standard input: gray8, rgb8, bgr8, bgra8, i420, yuyv, nv12, gray16, bayer_rggb8, ...",
        "--pixel-format CODE", "capture snapshot trace", "Camera", "Pixel format, such as yuyv or mjpg; raw: rgb8";
    capture.camera.io: Named("ways", &camera::IO),
        "How frames come from a camera's driver: \"userptr\" straight into shared memory, \"mmap\" by one copy, or \"auto\".",
        "--io WAY", "capture snapshot", "Camera", "How frames come from the driver";
    capture.camera.controls: Controls,
        "What a camera's controls are set to, by the names in `lariat devices`.",
        "--control NAME=VALUE", "capture snapshot", "Camera", "Set a control, such as exposure_auto=1";
    capture.camera.lock: SWITCH,
        "Hold a camera's exposure, white balance, gain and focus as they are when its picture has settled, after a second.",
        "--lock", "capture", "Camera", "Hold exposure, white balance, gain and focus";
    capture.camera.restore: SWITCH,
        "Put a camera's controls back at the end as they were.",
        "--restore", "capture", "Camera", "Put controls back at the end";

    simulation.grippers: Whole(1..=2),
        "How many grippers hold the rope: 1 or 2. They take commands from lariat/<rig>/commands.";
    simulation.length_px: Between(100.0..=6000.0),
        "Length of the rope in pixels: 100 to two thirds of the picture's width, and of 4/3 of its height.";
    simulation.stiffness: Between(0.01..=1.0),
        "Bending stiffness by mass of length, in m⁴/s² with a pixel as a millimetre, 0.01 to 1: a cable has 0.1.";
    simulation.friction: Between(0.0..=1.0),
        "Coefficient of friction with the table, 0 to 1.";
    simulation.noise: Between(0.0..=4.0),
        "Standard deviation of the camera's noise in its picture, in steps of a byte, 0 to 4.";
    simulation.hand_at_s: Maybe("2", Between(0.0..=1e6)),
        "Let a hand come and rest on the rope, from this moment on, in seconds after the first frame.";
    simulation.hand_for_s: Between(0.0..=1e6),
        "For how many seconds it rests there.";

    camera.calibration: Maybe("\"camera.yaml\"", PATH),
        "The lens: a file of OpenCV's FileStorage or of ROS's camera_calibration (YAML). A rope's points are undistorted\n\
         by it, never the image.",
        "--calibration FILE", "capture fit trace replay", "Millimetres", "Lens: a YAML file of OpenCV or ROS";
    camera.plane: Maybe("\"plane.toml\"", PATH),
        "The table that the rope lies on: a file as `lariat calibrate plane` writes it.",
        "--plane FILE", SHAPES, "Millimetres", "Table, by `lariat calibrate plane`";
    camera.unit: Maybe("\"mm\"", Named("units", &view::UNITS)),
        "What descriptors come in: \"px\" of the image (with a calibration, of one without distortion), or \"mm\" on the\n\
         plane. If not set, mm where a plane is named.",
        "--unit UNIT", SHAPES, "Millimetres", "What descriptors come in";
    camera.depth: Maybe("\"depth.yaml\"", PATH),
        "A depth camera beside the colour one: its calibration, its pose to the colour camera, and how it errs. Ropes are described in\n\
         space, too, in mm, from the images on lariat/<rig>/depth. \"simulated\": the simulated rope is lifted, before cameras that are known.",
        "--depth FILE", "capture fit", "Millimetres", "Depth camera beside the colour one: a YAML file";
    camera.second: Maybe("\"right.yaml\"", PATH),
        "A second colour camera beside this one, in the place of a depth camera: its calibration, and its pose to this one. Ropes are\n\
         described in space, too, in mm, by what the rig second_rig sees of them.",
        "--second FILE", "fit", "Millimetres", "Second colour camera beside this one: a YAML file";
    camera.second_rig: Maybe("\"right\"", By(meaning::rig, |rig| Value::String(rig.clone()), Takes::Text)),
        "The rig of that camera, which runs by itself: lariat run --rig right.",
        "--second-rig NAME", "fit", "Millimetres", "Rig of the second camera";
    camera.second_within as second_within_us: Maybe("5000", MICROSECONDS),
        "Each frame has what that camera saw nearest in time, no more than this before or after it, in microseconds. If not set, three\n\
         fifths of the time between two of its frames.";
    camera.pose: Maybe("\"pose.yaml\"", PATH),
        "Where the colour camera stands before the robot (hand-eye): rotation and translation_mm. Ropes in space are described in the\n\
         robot's frame then, else in the camera's.",
        "--pose FILE", "fit", "Millimetres", "Pose of the camera before the robot: a YAML file";
    camera.depth_deadline as depth_deadline_us: MICROSECONDS,
        "A frame whose depth image, or second view, has not come this long after its capture is described without, in microseconds.";

    extract.mask: By(meaning::mask, meaning::mask_value, Takes::Toml),
        "What is rope. \"auto\" takes what differs from the background; \"network\" asks a small neural network, for ropes\n\
         on any ground. Or colours, one range or more:\n\
         [{ hue_deg = [190, 250], saturation = [0.3, 1], value = [0.2, 1] }]\n\
         Hue in degrees, 0 to 360 (twice OpenCV's 0 to 179), and [350, 10] goes through red; saturation and\n\
         value from 0 to 1 (OpenCV's divided by 255). `lariat pick PICTURE` proposes them.\n\
         Or \"external\": another process writes each frame's mask to lariat/<rig>/masks.",
        "--mask MASK", SEEN, "Rope", "What is rope: auto, network, external or colours";
    extract.mask_level: By(meaning::mask_level, meaning::mask_level_value, Takes::Whole),
        "From which level on a pixel of an external mask is rope, 1 to 255. \"auto\" chooses it by the mask itself: low where\n\
         it is soft, as a network's probabilities are, so that ropes do not break where the network is unsure.";
    extract.network: Maybe("\"my.weights\"", PATH),
        "A network trained on pictures of your own, in the place of the one that lariat brings along.",
        "--network FILE", SEEN, "Rope", "Network trained on pictures of your own";
    extract.mask_deadline as mask_deadline_us: MICROSECONDS,
        "A frame whose external mask has not come this long after its capture is skipped, in microseconds.";
    extract.method: Named("methods", &Method::ALL),
        "How the mask becomes a centerline: \"skeleton\", the most accurate and by far the fastest, or, to compare\n\
         with it, the centers of a clustering, put in order: \"kmeans\", \"som\", \"gmm\" or \"fcm\".",
        "--method NAME", SEEN, "Rope", "How the mask becomes a centerline";
    extract.points: Whole(2..=MAX_POINTS),
        "Points of a centerline, at equal steps of arc length: at least as many as control points, at most 256.",
        "--points N", "capture extract fit trace replay", "Rope", "Points of a centerline";
    extract.ropes: Whole(1..=MAX_CURVES),
        "The most ropes reported, the surest and longest: 1 to 24.",
        "--ropes N", SEEN, "Rope", "The most ropes reported, 1 to 24";
    extract.min_confidence: Between(0.0..=1.0),
        "The confidence, 0 to 1, below which a rope is warned of where nothing else says why it may be wrong. It is reported\n\
         all the same: a loop asks for its own.";
    extract.start: Maybe("[0, 0]", By(meaning::position, meaning::position_value, Takes::Numbers)),
        "A rope's first point in the first frame is the end nearest to this position [x, y], in pixels; if not\n\
         set, the end nearest to the top left.",
        "--start X,Y", SEEN, "Rope", "A rope's first end is the one nearest to this";
    extract.at: By(meaning::positions, |at| meaning::positions_value(at), Takes::Positions),
        "The ropes that are meant, each by a position [x, y] on it in the first frame in which it is found; others are not\n\
         reported. [] means all.",
        "--at X,Y,…", SEEN, "Rope", "Only the ropes that lie here";
    extract.keep_lost as keep_lost_s: SECONDS,
        "For how many seconds a rope that is out of sight is still reported, as lost.";
    extract.roi: Maybe("[160, 120, 320, 240]", By(view::region, view::region_value, Takes::Numbers)),
        "The part of the image that is read, [x, y, width, height] in pixels: a rope ends at its edge as at the image's.",
        "--roi X,Y,W,H", SEEN, "Rope", "Part of the image that is read";

    fit.basis: Named("bases", &Family::ALL),
        "The family of curves: \"auto\" (the fewest control points that keep the curve on the rope), \"bezier\" (the paper's),\n\
         \"bspline\", \"rational\", \"points\" (of the rope itself), \"mass\" (its center). Closed ropes are always truncated\n\
         Fourier series; with \"fourier\" `lariat fit` takes every line for one.",
        "--basis NAME", SHAPES, "Curve", "Family of the curve";
    fit.control_points: Maybe("9", By(meaning::control_points, meaning::control_points_value, Takes::Whole)),
        "Control points of the curve, 2 to 32 (9 if only its basis is named; without a basis they are a Bezier curve's), or\n\
         \"auto\": as few as keep the curve on the rope. A closed curve has as many coefficients, or one fewer.",
        "--control-points N", SHAPES, "Curve", "Control points, 2 to 32, or `auto`";
    fit.max_control_points: Whole(2..=MAX_CONTROL_POINTS),
        "The most control points that control_points = \"auto\" chooses.";
    fit.tolerance: ABOVE_0,
        "How far from the curve, in widths of the rope, 95 % of its points may be, and all within half a width. A curve that\n\
         is farther off is \"coarse\", which its descriptor says.";
    fit.tolerance_px: ABOVE_0,
        "And at most so many pixels of the image, which counts for wide ropes.";
    fit.degree: Whole(1..=MAX_ORDER),
        "Degree of a B-spline's pieces, 1 to 31. A Bezier curve's degree is one less than its control points.",
        "--degree N", SHAPES, "Curve", "Degree of a B-spline's pieces";
    fit.knots: Named("kinds of knots", &Knots::NAMED),
        "Where a B-spline's pieces meet: at even steps (\"uniform\") or evenly among the points (\"averaged\").",
        "--knots NAME", SHAPES, "Curve", "Where a B-spline's pieces meet";
    fit.solver: Named("solvers", &Solver::ALL),
        "How it is computed: \"pinv\" (fastest), \"cholesky\" or \"qr\".",
        "--solver NAME", SHAPES, "Curve", "How the curve is computed";
    fit.ridge: AT_LEAST_0,
        "What a bend of the control polygon costs, 0 or more: a little of it tames high orders.",
        "--ridge NUMBER", SHAPES, "Curve", "What a bend of the control polygon costs";
    fit.pin_ends: SWITCH,
        "Let curves begin and end exactly at the centerline's ends.",
        "--pin-ends", SHAPES, "Curve", "Begin and end at the centerline's ends";
    fit.rho: Named("ways", &Rho::ALL),
        "The arc length that each point stands for: in \"even\" steps, or \"measured\" along the points, chord by chord.",
        "--rho NAME", SHAPES, "Curve", "Arc length that each point stands for";
    fit.robust: SWITCH,
        "Let points far off the curve weigh less, and those of a rope that were covered nothing.",
        "--robust", SHAPES, "Curve", "Let points far off the curve weigh less";
    fit.filter: SWITCH,
        "Filter the control points in time (Kalman, constant velocity); descriptors then have velocities too.",
        "--filter", "fit trace replay", "Curve", "Filter the control points in time";
    fit.acceleration_px_s2: ABOVE_0,
        "How much the filter thinks the rope's points accelerate, in px/s² over 1 s (of the image, also where\n\
         descriptors come in mm): the more, the less it smooths.";

    sink.live: SWITCH,
        "Show a line of figures while the chain runs.";

    record.images: Named("kinds of images", &recording::IMAGES),
        "How frames are recorded: \"raw\" (as they are), \"png\" (a quarter to a half, to the bit, for a core's work),\n\
         \"jpeg\" (a tenth), or \"none\".",
        "--images KIND", "record", "Recording", "How frames are recorded";
    record.quality: Whole(1..=100),
        "Quality of JPEGs, 1 to 100.",
        "--quality N", "record", "Recording", "Quality of JPEGs, 1 to 100";
    record.compression: Named("compressions", &recording::COMPRESSIONS),
        "How the recording is compressed: \"none\", \"lz4\" or \"zstd\".",
        "--compression NAME", "record", "Recording", "How it is compressed";
    record.queue_bytes as queue_mb: MEGABYTES,
        "Memory for what waits for the disk, in MB. What finds no room is dropped, and counted.",
        "--queue SIZE", "record", "Recording", "Memory for what waits for the disk";
    record.ring as ring_s: Maybe("30", SECONDS),
        "Keep only the last so many seconds, in memory; `lariat record --flush` writes them.",
        "--ring TIME", "record", "Recording", "Keep the last so much, write it when told";
    record.ring_bytes as ring_mb: MEGABYTES,
        "The most memory that these seconds may take, in MB.",
        "--ring-memory SIZE", "record", "Recording", "The most memory that --ring may take";
    record.replace: SWITCH,
        "Overwrite a recording, report or timeline that exists. Ignored in a file that is not named by --config.",
        "--force", "record sink", "Recording", "Overwrite files that are there";
};
