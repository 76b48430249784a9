//! The table of all settings. It defines the file, the command line and their help.

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

// Each row is a setting. It starts with the field in `Settings`; the first part of the field is the
// section. If the setting's name differs from the field's, `as` and the name follow. The kind and
// the description follow; `--help` and new settings files show the description. A setting with a
// flag continues with the flag as the help shows it, then the commands that have it. `run`, and
// commands that take all flags of `run`, are not listed. The last two items are the flag's heading
// in the help and the line for `-h`.
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
        "Name of this camera's chain, so that several can run on one machine: 1 to 32 of a-z, 0-9, _ and -.",
        "--rig NAME", "capture extract fit sink record", "Run", "Name of the chain, to run several";
    run.lossless: SWITCH,
        "Let capture wait for slow readers instead of skipping frames. For files, not for a live robot.",
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
        "Write a timeline of the last 1,000 frames into this file, for ui.perfetto.dev.",
        "--trace FILE.json", "sink", "Report", "Write a timeline for ui.perfetto.dev";
    run.record: Maybe("\"run.mcap\"", PATH),
        "Record the chain's frames and results into this file, for `lariat replay`, ROS 2 and Foxglove.",
        "--record FILE.mcap", "", "Recording", "Record frames and results";
    run.deadline as deadline_us: Maybe("33000", MICROSECONDS),
        "Count a descriptor as a miss if it is older than this when it arrives, in microseconds. Default: the\n\
         time between two frames.",
        "--deadline TIME", "sink", "Report", "Latency that counts as a miss, such as 33ms";
    run.fuse: SWITCH,
        "Run capture, extract and fit in one process. Waits are a fifth shorter, but a crash of one stage ends\n\
         all three.",
        "--fuse", "", "Run", "Capture, extract and fit in one process";
    run.daemon: SWITCH,
        "Run unattended: no live line, and `restart` is \"on-failure\" unless set.",
        "--daemon", "", "Run", "Unattended: no live line, --restart on-failure";
    run.restart: Named("ways", &run::RESTARTS),
        "When to restart a stage while the others and all readers continue: \"never\" (the chain ends),\n\
         \"on-failure\" (after a crash, a hang, or a signal from elsewhere), or \"always\" (also when its source\n\
         has ended).",
        "--restart WHEN", "", "Run", "When to restart a stage, such as on-failure";
    run.max_restarts: Whole(1..=1_000_000),
        "Number of restarts within `restart_window_s` after which the chain ends. With `daemon` the chain never\n\
         ends for this, and retries every 5 s.";
    run.restart_window as restart_window_s: SECONDS,
        "Time window of `max_restarts`, in seconds.";
    run.hang as hang_s: SECONDS,
        "Restart a stage that makes no progress for this many seconds while work waits for it. Not with\n\
         `lossless`, where each stage waits for the next.";
    run.start_limit as start_limit_s: SECONDS,
        "Fail a stage that is not ready after this many seconds.";
    run.watch: SWITCH,
        "Apply changes of the settings file while the chain runs, as `lariat set` does.",
        "--watch", "", "Run", "Apply changes of the settings file while running";
    run.arrangement.realtime: SWITCH,
        "For a robot: FIFO scheduling, locked memory, and stages pinned to cores (see `cpus`). Without the\n\
         permission for one of these, lariat warns and runs without it.",
        "--realtime", STAGES, "Real time", "FIFO scheduling, locked memory, chosen cores";
    run.arrangement.cpus: By(arrangement::cpus, arrangement::cpus_value, Takes::Text),
        "Cores of capture, extract, fit and sink, such as [0, 0, 1, 1], or of some stages: { extract = 1 }.\n\
         \"none\": the kernel chooses. \"auto\": the kernel chooses, or with `realtime` the fastest measured\n\
         arrangement.",
        "--cpus CORES", STAGES, "Real time", "Core of each stage, such as 0,0,1,1";
    run.arrangement.scheduling: Named("classes", &arrangement::SCHEDULING),
        "Scheduling class of the stages: \"other\" (like ordinary programs) or \"fifo\" (before all of them).",
        "--scheduling CLASS", STAGES, "Real time", "Scheduling class";
    run.arrangement.priority: Whole(1..=arrangement::MAX_PRIORITY),
        "Priority of capture under FIFO, 1 to 96. Extract, fit and sink get 1, 2 and 3 more, so that a frame in\n\
         progress goes before the next one.",
        "--priority N", STAGES, "Real time", "Priority of capture under FIFO";
    run.arrangement.lock_memory: SWITCH,
        "Keep the stages' memory in RAM.",
        "--lock-memory", STAGES, "Real time", "Keep memory from being paged out";
    run.arrangement.wake: Named("ways", &arrangement::WAKES),
        "How a stage waits for a message: \"event\" (sleep until woken) or \"spin\" (poll for a while before\n\
         sleeping: faster, but it needs a free core for each stage).",
        "--wake HOW", "extract fit sink", "Real time", "How a stage waits for a message";
    run.arrangement.spin as spin_us: By(arrangement::spin, arrangement::spin_value, MICROSECONDS.takes()),
        "Time to poll with `wake = \"spin\"`, in microseconds, at most 10000.",
        "--spin TIME", "extract fit sink", "Real time", "Time to poll with --wake spin, such as 50us";

    capture.source: By(meaning::paths, |paths| meaning::paths_value(paths), Takes::Paths),
        "\"rendered\" (a rope drawn by lariat), \"simulated\" (a rope held by grippers), \"external\" (frames from your\n\
         own program), a camera (\"/dev/video0\", or a name in /dev/v4l/by-id, which does not change), a recording\n\
         (.mcap), a picture, a folder of pictures, a Y4M or MJPEG video, or a list of these. \"-\": standard input,\n\
         as Y4M or as raw frames (then set size and pixel_format).",
        "--source PATH", "capture snapshot", "Source", "Camera, pictures, video, recording, external or -";
    capture.fps: By(meaning::fps, meaning::fps_value, Takes::Number),
        "Frames per second, or \"max\". \"auto\": the rate of the camera, video or recording, the arrival times of\n\
         standard input, and 30 for other sources.",
        "--fps NUMBER", "capture sink snapshot trace", "Source", "Frames per second, `max` or `auto`";
    capture.size: By(meaning::size, meaning::size_value, Takes::Text),
        "Width and height of a camera's or rendered picture in pixels, 64 to 8192, such as [640, 480]. \"auto\":\n\
         640 × 480, or the camera's nearest size.",
        "--size WxH", "capture snapshot trace", "Source", "Size of a camera's, rendered or raw picture";
    capture.seed: Whole(0..=u64::MAX),
        "Number of the rendered or simulated rope. The same number gives the same rope on every machine.",
        "--seed NUMBER", "capture snapshot", "Source", "Number of the rendered or simulated rope";
    capture.looped as loop: SWITCH,
        "Start again after the last file.",
        "--loop", "capture", "Source", "Start again after the last file";
    capture.range.from: Maybe("120", PLACE),
        "First frame of pictures or a video: its number, from 1, or a time such as \"2.5s\", by the video's rate or\n\
         the pictures' fps.",
        "--from PLACE", "capture trace", "Source", "First frame, or a time such as 2.5s";
    capture.range.to: Maybe("\"10s\"", PLACE),
        "Last frame, or the time before which to end.",
        "--to PLACE", "capture trace", "Source", "Last frame, or the time before which to end";
    capture.range.every: By(range::every, range::every_value, Takes::Whole),
        "Show every Nth frame only: with 3 the first, the fourth, the seventh and so on.",
        "--every N", "capture trace", "Source", "Show every Nth frame only";
    capture.follow: SWITCH,
        "Show the pictures in the folder, then each new picture once it is closed or moved there.",
        "--follow", "capture", "Source", "Show each picture that comes into a folder";
    capture.topic: Maybe("\"/left/image_raw\"", TEXT),
        "Image topic of a recording with several cameras; `lariat info` lists them.",
        "--topic TOPIC", "capture trace", "Source", "Image topic of a recording";
    capture.depth_images: Maybe("\"depth/\"", PATH),
        "Depth images that belong to the source's pictures: a folder of 16-bit PNG files, one for each picture,\n\
         in the same order. camera.depth describes the depth camera.",
        "--depth-images PATH", "capture", "Source", "Folder of depth images, one for each picture";
    capture.depth_source: Maybe("\"/dev/video2\"", PATH),
        "Depth camera next to the source, which must be a camera: a node with Z16 or Y16, as `lariat devices`\n\
         lists it, or its name in /dev/v4l/by-id. camera.depth describes it and gives the size of its images.",
        "--depth-source PATH", "capture", "Camera", "Depth camera next to the source: /dev/video2";
    capture.depth_within as depth_within_us: Maybe("20000", MICROSECONDS),
        "Maximum time between a frame and its depth image, in microseconds. Default: three fifths of the time\n\
         between two depth images.";
    capture.camera.pixel_format: By(camera::pixel_format, camera::pixel_format_value, Takes::Text),
        "Pixel format of a camera, such as \"yuyv\" or \"mjpg\", as `lariat devices` lists them. \"auto\": the best for\n\
         the mask. Of raw frames on standard input: gray8, rgb8, bgr8, bgra8, i420, yuyv, nv12, gray16,\n\
         bayer_rggb8 and others.",
        "--pixel-format CODE", "capture snapshot trace", "Camera", "Pixel format, such as yuyv or mjpg; raw: rgb8";
    capture.camera.io: Named("ways", &camera::IO),
        "How frames come from the camera's driver: \"userptr\" (straight into shared memory), \"mmap\" (one copy), or\n\
         \"auto\".",
        "--io WAY", "capture snapshot", "Camera", "How frames come from the driver";
    capture.camera.controls: Controls,
        "Values for the camera's controls, by the names in `lariat devices`.",
        "--control NAME=VALUE", "capture snapshot", "Camera", "Set a control, such as exposure_auto=1";
    capture.camera.lock: SWITCH,
        "Hold exposure, white balance, gain and focus once the picture has settled, after a second.",
        "--lock", "capture", "Camera", "Hold exposure, white balance, gain and focus";
    capture.camera.restore: SWITCH,
        "Restore the camera's controls at the end.",
        "--restore", "capture", "Camera", "Restore the camera's controls at the end";

    simulation.grippers: Whole(1..=2),
        "Number of grippers that hold the rope, 1 or 2. They take commands from lariat/<rig>/commands.";
    simulation.length_px: Between(100.0..=6000.0),
        "Length of the rope in pixels: from 100 to two thirds of the picture's width, and at most 4/3 of its\n\
         height.";
    simulation.stiffness: Between(0.01..=1.0),
        "Bending stiffness divided by mass per length, in m⁴/s² for pixels of 1 mm, 0.01 to 1. A cable has 0.1.";
    simulation.friction: Between(0.0..=1.0),
        "Coefficient of friction with the table, 0 to 1.";
    simulation.noise: Between(0.0..=4.0),
        "Standard deviation of the camera's noise, in levels of 256, 0 to 4.";
    simulation.hand_at_s: Maybe("2", Between(0.0..=1e6)),
        "Time at which a hand comes and rests on the rope, in seconds after the first frame.";
    simulation.hand_for_s: Between(0.0..=1e6),
        "Time for which the hand rests there, in seconds.";

    camera.calibration: Maybe("\"camera.yaml\"", PATH),
        "Lens calibration: a YAML file of OpenCV (FileStorage) or of ROS (camera_calibration). It undistorts the\n\
         rope's points, never the image.",
        "--calibration FILE", "capture fit trace replay", "Millimetres", "Lens: a YAML file of OpenCV or ROS";
    camera.plane: Maybe("\"plane.toml\"", PATH),
        "Plane of the table that the rope lies on: a file written by `lariat calibrate plane`.",
        "--plane FILE", SHAPES, "Millimetres", "Table, by `lariat calibrate plane`";
    camera.unit: Maybe("\"mm\"", Named("units", &view::UNITS)),
        "Unit of descriptors: \"px\" of the image (without distortion, if there is a calibration) or \"mm\" on the\n\
         plane. Default: mm if there is a plane.",
        "--unit UNIT", SHAPES, "Millimetres", "Unit of descriptors";
    camera.depth: Maybe("\"depth.yaml\"", PATH),
        "Depth camera next to the colour camera: a file with its calibration, its pose relative to the colour\n\
         camera, and its errors. Descriptors then also come in space, in mm, from the images on\n\
         lariat/<rig>/depth. \"simulated\": the simulated rope is lifted, in front of known cameras.",
        "--depth FILE", "capture fit", "Millimetres", "Depth camera: a YAML file";
    camera.second: Maybe("\"right.yaml\"", PATH),
        "Second colour camera, instead of a depth camera: a file with its calibration, and its pose relative to\n\
         this one. Descriptors then also come in space, in mm, from the centerlines of the rig second_rig.",
        "--second FILE", "fit", "Millimetres", "Second colour camera: a YAML file";
    camera.second_rig: Maybe("\"right\"", By(meaning::rig, |rig| Value::String(rig.clone()), Takes::Text)),
        "Rig of the second camera, which runs on its own: lariat run --rig right.",
        "--second-rig NAME", "fit", "Millimetres", "Rig of the second camera";
    camera.second_within as second_within_us: Maybe("5000", MICROSECONDS),
        "Maximum time between a frame and the second camera's, in microseconds. Default: three fifths of the time\n\
         between two of the second camera's frames.";
    camera.pose: Maybe("\"pose.yaml\"", PATH),
        "Pose of the colour camera in the robot's frame (hand-eye calibration): rotation and translation_mm.\n\
         Ropes in space are then in the robot's frame, otherwise in the camera's.",
        "--pose FILE", "fit", "Millimetres", "Pose of the camera in the robot's frame: YAML";
    camera.depth_deadline as depth_deadline_us: MICROSECONDS,
        "Maximum time from capture to the depth image or second view, in microseconds. A frame that waits longer\n\
         is described without it.";

    extract.mask: By(meaning::mask, meaning::mask_value, Takes::Toml),
        "Which pixels are rope. \"auto\": pixels that differ from the background. \"network\": pixels that a small\n\
         neural network finds, on any background. Or colour ranges:\n\
         [{ hue_deg = [190, 250], saturation = [0.3, 1], value = [0.2, 1] }]\n\
         Hue is in degrees, 0 to 360 (twice OpenCV's), and [350, 10] goes through red; saturation and value are 0\n\
         to 1 (OpenCV's divided by 255). `lariat pick PICTURE` proposes them. \"external\": another process writes\n\
         each frame's mask to lariat/<rig>/masks.",
        "--mask MASK", SEEN, "Rope", "Mask of the ropes: auto, network, external, colours";
    extract.mask_level: By(meaning::mask_level, meaning::mask_level_value, Takes::Whole),
        "Lowest level of an external mask that is rope, 1 to 255. \"auto\" chooses it for each mask: low for soft\n\
         masks such as probabilities, so that ropes do not break where they are uncertain.";
    extract.network: Maybe("\"my.weights\"", PATH),
        "Weights of a network trained on your own pictures, instead of lariat's.",
        "--network FILE", SEEN, "Rope", "Network trained on your own pictures";
    extract.mask_deadline as mask_deadline_us: MICROSECONDS,
        "Maximum time from capture to a frame's external mask, in microseconds. Later frames are skipped.";
    extract.method: Named("methods", &Method::ALL),
        "How to find the centerline in the mask: \"skeleton\" (the most accurate and by far the fastest), or for\n\
         comparison the ordered centers of a clustering: \"kmeans\", \"som\", \"gmm\" or \"fcm\".",
        "--method NAME", SEEN, "Rope", "How to find the centerline in the mask";
    extract.points: Whole(2..=MAX_POINTS),
        "Number of points of a centerline, at equal steps of arc length: at least the number of control points,\n\
         at most 256.",
        "--points N", "capture extract fit trace replay", "Rope", "Points of a centerline";
    extract.ropes: Whole(1..=MAX_CURVES),
        "Maximum number of ropes reported, the most confident and longest, 1 to 24.",
        "--ropes N", SEEN, "Rope", "Maximum number of ropes reported, 1 to 24";
    extract.min_confidence: Between(0.0..=1.0),
        "Confidence below which a warning names a rope, 0 to 1. The rope is still reported; readers have a\n\
         threshold of their own.";
    extract.start: Maybe("[0, 0]", By(meaning::position, meaning::position_value, Takes::Numbers)),
        "Position [x, y] in pixels: in the first frame, the rope's end nearest to it becomes the first point.\n\
         Default: the end nearest to the top left.",
        "--start X,Y", SEEN, "Rope", "A rope's first end is the one nearest to this";
    extract.at: By(meaning::positions, |at| meaning::positions_value(at), Takes::Positions),
        "Positions [x, y] on the ropes to report, in the first frame that shows them. [] reports all ropes.",
        "--at X,Y,…", SEEN, "Rope", "Report only the ropes at these positions";
    extract.keep_lost as keep_lost_s: SECONDS,
        "Time for which a rope that is out of sight is still reported, as lost, in seconds.";
    extract.roi: Maybe("[160, 120, 320, 240]", By(view::region, view::region_value, Takes::Numbers)),
        "Part of the image to read, [x, y, width, height] in pixels. A rope ends at its border as at the image's.",
        "--roi X,Y,W,H", SEEN, "Rope", "Part of the image to read";

    fit.basis: Named("bases", &Family::ALL),
        "Family of curves: \"auto\" (the fewest control points that keep the curve on the rope), \"bezier\" (the\n\
         paper's), \"bspline\", \"rational\", \"points\" (points of the rope), or \"mass\" (its center). Closed ropes are\n\
         always truncated Fourier series. With \"fourier\" `lariat fit` treats every line as closed.",
        "--basis NAME", SHAPES, "Curve", "Family of the curve";
    fit.control_points: Maybe("9", By(meaning::control_points, meaning::control_points_value, Takes::Whole)),
        "Number of control points, 2 to 32, or \"auto\": the fewest that keep the curve on the rope. Default: 9 if\n\
         the basis is named. A number without a basis means a Bezier curve. A closed curve has as many\n\
         coefficients, or one fewer.",
        "--control-points N", SHAPES, "Curve", "Control points, 2 to 32, or `auto`";
    fit.max_control_points: Whole(2..=MAX_CONTROL_POINTS),
        "Maximum that control_points = \"auto\" chooses.";
    fit.tolerance: ABOVE_0,
        "Maximum distance of 95 % of the points from the curve, in widths of the rope. All points must be within\n\
         half a width. Otherwise the descriptor says that the curve is \"coarse\".";
    fit.tolerance_px: ABOVE_0,
        "Upper limit of `tolerance`, in pixels of the image, for wide ropes.";
    fit.degree: Whole(1..=MAX_ORDER),
        "Degree of a B-spline's pieces, 1 to 31. The degree of a Bezier curve is one less than its control\n\
         points.",
        "--degree N", SHAPES, "Curve", "Degree of a B-spline's pieces";
    fit.knots: Named("kinds of knots", &Knots::NAMED),
        "Knots of a B-spline: \"uniform\" (at equal steps) or \"averaged\" (by the points).",
        "--knots NAME", SHAPES, "Curve", "Knots of a B-spline";
    fit.solver: Named("solvers", &Solver::ALL),
        "Solver of the least squares: \"pinv\" (fastest), \"cholesky\" or \"qr\".",
        "--solver NAME", SHAPES, "Curve", "Solver of the least squares";
    fit.ridge: AT_LEAST_0,
        "Penalty on bends of the control polygon, 0 or more. A small one tames high orders.",
        "--ridge NUMBER", SHAPES, "Curve", "Penalty on bends of the control polygon";
    fit.pin_ends: SWITCH,
        "Make curves begin and end exactly at the centerline's ends.",
        "--pin-ends", SHAPES, "Curve", "Begin and end at the centerline's ends";
    fit.rho: Named("ways", &Rho::ALL),
        "Arc length of each point: \"even\" steps, or \"measured\" along the points, chord by chord.",
        "--rho NAME", SHAPES, "Curve", "Arc length of each point";
    fit.robust: SWITCH,
        "Give outliers less weight, and covered points none.",
        "--robust", SHAPES, "Curve", "Give outliers less weight";
    fit.filter: SWITCH,
        "Filter the control points in time (Kalman, constant velocity). Descriptors then also have velocities.",
        "--filter", "fit trace replay", "Curve", "Filter the control points in time";
    fit.acceleration_px_s2: ABOVE_0,
        "Acceleration of the rope's points that the filter expects, in px/s² over 1 s, also for descriptors in\n\
         mm. A larger one smooths less.";

    sink.live: SWITCH,
        "Show a live line of figures.";

    record.images: Named("kinds of images", &recording::IMAGES),
        "How to record frames: \"raw\" (unchanged), \"png\" (lossless, a quarter to a half of the size, costs a\n\
         core), \"jpeg\" (a tenth of the size), or \"none\".",
        "--images KIND", "record", "Recording", "How to record frames";
    record.quality: Whole(1..=100),
        "Quality of JPEGs, 1 to 100.",
        "--quality N", "record", "Recording", "Quality of JPEGs, 1 to 100";
    record.compression: Named("compressions", &recording::COMPRESSIONS),
        "Compression of the recording: \"none\", \"lz4\" or \"zstd\".",
        "--compression NAME", "record", "Recording", "Compression of the recording";
    record.queue_bytes as queue_mb: MEGABYTES,
        "Memory for data that waits for the disk, in MB. Data that does not fit is dropped and counted.",
        "--queue SIZE", "record", "Recording", "Memory for data that waits for the disk";
    record.ring as ring_s: Maybe("30", SECONDS),
        "Keep only the last seconds, in memory; `lariat record --flush` writes them.",
        "--ring TIME", "record", "Recording", "Keep only this long; write it on request";
    record.ring_bytes as ring_mb: MEGABYTES,
        "Maximum memory for these seconds, in MB.",
        "--ring-memory SIZE", "record", "Recording", "Maximum memory for --ring";
    record.replace: SWITCH,
        "Overwrite a recording, report or timeline that exists. Ignored in a file that is not named by --config.",
        "--force", "record sink", "Recording", "Overwrite files that exist";
};
