//! The table of all settings.

use crate::settings::curve::{Family, Order};
use crate::settings::keys::Key;
use crate::settings::{arrangement, camera, meaning, range, recording, simulation, view};
use lariat_extract::Method;
use lariat_fit::{Knots, MAX_ORDER, Rho, Solver};
use std::path::PathBuf;
use toml::Value;

pub(super) const KEYS: &[Key] = &[
    Key {
        section: "run",
        name: "rig",
        about: "Name of this camera chain, so that several run side by side: 1 to 32 of a-z, 0-9, _ and -.",
        example: "",
        set: |s, v| meaning::rig(v).map(|rig| s.run.rig = rig),
        get: |s| Some(Value::String(s.run.rig.clone())),
    },
    Key {
        section: "run",
        name: "lossless",
        about: "Let capture wait for slow readers instead of skipping frames (for files, not for a live robot).",
        example: "",
        set: |s, v| meaning::yes_or_no(v).map(|yes| s.run.lossless = yes),
        get: |s| Some(Value::Boolean(s.run.lossless)),
    },
    Key {
        section: "run",
        name: "duration_s",
        about: "Stop after this many seconds.",
        example: "10",
        set: |s, v| meaning::time(v, 1.0, "seconds").map(|time| s.run.duration = Some(time)),
        get: |s| {
            s.run
                .duration
                .map(|time| meaning::number_value(time.as_secs_f64()))
        },
    },
    Key {
        section: "run",
        name: "frames",
        about: "Stop after this many frames.",
        example: "1000",
        set: |s, v| meaning::whole(v, 1, i64::MAX).map(|n| s.run.frames = Some(n.unsigned_abs())),
        get: |s| {
            Some(Value::Integer(
                i64::try_from(s.run.frames?).unwrap_or(i64::MAX),
            ))
        },
    },
    Key {
        section: "run",
        name: "out",
        about: "Write the report (table, histograms, summary.json) into this folder.",
        example: "\"report\"",
        set: |s, v| meaning::text(v).map(|text| s.run.out = Some(PathBuf::from(text))),
        get: |s| s.run.out.as_ref().map(|path| path_value(path)),
    },
    Key {
        section: "run",
        name: "trace",
        about: "Write when each stage worked on each of the last 1,000 frames into this file, for ui.perfetto.dev.",
        example: "\"timeline.json\"",
        set: |s, v| meaning::text(v).map(|text| s.run.trace = Some(PathBuf::from(text))),
        get: |s| s.run.trace.as_ref().map(|path| path_value(path)),
    },
    Key {
        section: "run",
        name: "record",
        about: "Record what the chain sees and says into this file, which `lariat replay`, ROS 2 and Foxglove read.",
        example: "\"run.mcap\"",
        set: |s, v| meaning::text(v).map(|text| s.run.record = Some(PathBuf::from(text))),
        get: |s| s.run.record.as_ref().map(|path| path_value(path)),
    },
    Key {
        section: "run",
        name: "deadline_us",
        about: "A descriptor later than this after its image counts as a miss, in microseconds; if not \
                set,\nthe time between two frames.",
        example: "33000",
        set: |s, v| meaning::time(v, 1e-6, "microseconds").map(|time| s.run.deadline = Some(time)),
        get: |s| {
            s.run
                .deadline
                .map(|time| meaning::number_value(time.as_nanos() as f64 / 1e3))
        },
    },
    Key {
        section: "run",
        name: "fuse",
        about: "Run capture, extract and fit in one process (`lariat run`): waits are a fifth shorter, but a crash of one ends all.",
        example: "",
        set: |s, v| meaning::yes_or_no(v).map(|yes| s.run.fuse = yes),
        get: |s| Some(Value::Boolean(s.run.fuse)),
    },
    Key {
        section: "run",
        name: "realtime",
        about: "For a robot: FIFO scheduling, locked memory, and the stages on cores as `cpus` says. What of it this user\n\
                may not have is said in a sentence, and the chain runs without.",
        example: "",
        set: |s, v| meaning::yes_or_no(v).map(|yes| s.run.arrangement.realtime = yes),
        get: |s| Some(Value::Boolean(s.run.arrangement.realtime)),
    },
    Key {
        section: "run",
        name: "cpus",
        about: "The cores of capture, extract, fit and sink: [0, 0, 1, 1], or of some of them: { extract = 1 }. \"none\": where\n\
                the kernel likes. \"auto\": likewise; with realtime as was measured to be best.",
        example: "",
        set: |s, v| arrangement::cpus(v).map(|cpus| s.run.arrangement.cpus = cpus),
        get: |s| Some(arrangement::cpus_value(&s.run.arrangement.cpus)),
    },
    Key {
        section: "run",
        name: "scheduling",
        about: "The kernel's scheduling class of the stages: \"other\" as all programs, or \"fifo\", before all of them.",
        example: "",
        set: |s, v| {
            meaning::named("classes", &arrangement::SCHEDULING, v)
                .map(|class| s.run.arrangement.scheduling = class)
        },
        get: |s| meaning::name_of(&arrangement::SCHEDULING, s.run.arrangement.scheduling),
    },
    Key {
        section: "run",
        name: "priority",
        about: "Capture's priority under FIFO, 1 to 96; extract, fit and sink have 1, 2 and 3 more, so that a frame on its way\n\
                goes before the next one.",
        example: "",
        set: |s, v| {
            meaning::whole(v, 1, arrangement::MAX_PRIORITY)
                .map(|priority| s.run.arrangement.priority = priority as u8)
        },
        get: |s| Some(Value::Integer(s.run.arrangement.priority.into())),
    },
    Key {
        section: "run",
        name: "lock_memory",
        about: "Keep the stages' memory from being paged out.",
        example: "",
        set: |s, v| meaning::yes_or_no(v).map(|yes| s.run.arrangement.lock_memory = yes),
        get: |s| Some(Value::Boolean(s.run.arrangement.lock_memory)),
    },
    Key {
        section: "run",
        name: "wake",
        about: "How a stage learns of a message: woken (\"event\"), or looking for it for a while before it sleeps (\"spin\": faster,\n\
                for a machine with a core for each stage and nothing else to do).",
        example: "",
        set: |s, v| {
            meaning::named("ways", &arrangement::WAKES, v).map(|wake| s.run.arrangement.wake = wake)
        },
        get: |s| meaning::name_of(&arrangement::WAKES, s.run.arrangement.wake),
    },
    Key {
        section: "run",
        name: "spin_us",
        about: "For how long it looks, in microseconds: at most 10000.",
        example: "",
        set: |s, v| arrangement::spin(v).map(|spin| s.run.arrangement.spin = spin),
        get: |s| {
            let us = s.run.arrangement.spin.as_nanos() as f64 / 1e3;
            Some(meaning::number_value(us))
        },
    },
    Key {
        section: "capture",
        name: "source",
        about: "\"rendered\" (a rope drawn by lariat), \"simulated\" (one held by grippers), \"external\" (frames that a program of\n\
                yours writes), a camera (\"/dev/video0\", or better a name in /dev/v4l/by-id, which\n\
                stays), a recording (.mcap), or a picture, a folder of pictures or a Y4M video, or a list of them. \"-\": standard input, a\n\
                Y4M video, or frames as they are (then size and pixel_format say what they are).",
        example: "",
        set: |s, v| meaning::paths(v).map(|paths| s.capture.source = paths),
        get: |s| {
            Some(match &s.capture.source[..] {
                [one] => path_value(one),
                many => Value::Array(many.iter().map(|path| path_value(path)).collect()),
            })
        },
    },
    Key {
        section: "capture",
        name: "fps",
        about: "Frames per second, or \"max\". \"auto\": as many as a camera has, as a video or a recording was made, as they come on\n\
                standard input, 30 of all else.",
        example: "",
        set: |s, v| meaning::fps(v).map(|fps| s.capture.fps = fps),
        get: |s| Some(meaning::fps_value(s.capture.fps)),
    },
    Key {
        section: "capture",
        name: "size",
        about: "Width and height in pixels, 64 to 8192, of a camera's picture or the rendered one: [640, 480]. \"auto\": that, or\n\
                what a camera has near it.",
        example: "",
        set: |s, v| meaning::size(v).map(|size| s.capture.size = size),
        get: |s| Some(meaning::size_value(s.capture.size)),
    },
    Key {
        section: "capture",
        name: "seed",
        about: "Which of all rendered or simulated ropes: the same number makes the same rope on every machine.",
        example: "",
        set: |s, v| meaning::whole(v, 0, i64::MAX).map(|seed| s.capture.seed = seed.unsigned_abs()),
        get: |s| {
            Some(Value::Integer(
                i64::try_from(s.capture.seed).unwrap_or(i64::MAX),
            ))
        },
    },
    Key {
        section: "capture",
        name: "loop",
        about: "Begin again after the last file.",
        example: "",
        set: |s, v| meaning::yes_or_no(v).map(|yes| s.capture.looped = yes),
        get: |s| Some(Value::Boolean(s.capture.looped)),
    },
    Key {
        section: "capture",
        name: "from",
        about: "Of pictures or a video, begin with this frame: its number, from 1, or a time, \"2.5s\", by the video's own rate\n\
                or the pictures' fps.",
        example: "120",
        set: |s, v| range::position(v).map(|at| s.capture.range.from = at),
        get: |s| range::position_value(s.capture.range.from),
    },
    Key {
        section: "capture",
        name: "to",
        about: "And end with this frame, or before this time.",
        example: "\"10s\"",
        set: |s, v| range::position(v).map(|at| s.capture.range.to = at),
        get: |s| range::position_value(s.capture.range.to),
    },
    Key {
        section: "capture",
        name: "every",
        about: "Show every Nth of them only: 3 is the first, the fourth, the seventh, ...",
        example: "",
        set: |s, v| range::every(v).map(|every| s.capture.range.every = every),
        get: |s| {
            Some(Value::Integer(
                i64::try_from(s.capture.range.every.get()).unwrap_or(i64::MAX),
            ))
        },
    },
    Key {
        section: "capture",
        name: "follow",
        about: "Show what is in the folder, and then each picture as it comes, once it is closed or moved there.",
        example: "",
        set: |s, v| meaning::yes_or_no(v).map(|yes| s.capture.follow = yes),
        get: |s| Some(Value::Boolean(s.capture.follow)),
    },
    Key {
        section: "capture",
        name: "topic",
        about: "Which images of a recording are shown, if it has those of several cameras; `lariat info` lists them.",
        example: "\"/left/image_raw\"",
        set: |s, v| meaning::text(v).map(|text| s.capture.topic = Some(text.to_owned())),
        get: |s| s.capture.topic.clone().map(Value::String),
    },
    Key {
        section: "capture",
        name: "pixel_format",
        about: "A camera's pixel format, such as \"yuyv\" or \"mjpg\", as `lariat devices` lists them. \"auto\": the best for the mask.\n\
                Of raw frames on standard input: gray8, rgb8, bgr8, bgra8, yuyv, uyvy, nv12, gray16, bayer_rggb8, ...",
        example: "",
        set: |s, v| camera::pixel_format(v).map(|code| s.capture.camera.pixel_format = code),
        get: |s| Some(camera::pixel_format_value(s.capture.camera.pixel_format)),
    },
    Key {
        section: "capture",
        name: "io",
        about: "How frames come from a camera's driver: \"userptr\" straight into shared memory, \"mmap\" by one copy, or \"auto\".",
        example: "",
        set: |s, v| meaning::named("ways", &camera::IO, v).map(|io| s.capture.camera.io = io),
        get: |s| meaning::name_of(&camera::IO, s.capture.camera.io),
    },
    Key {
        section: "capture",
        name: "controls",
        about: "What a camera's controls are set to, by the names in `lariat devices`.",
        example: "{ auto_exposure = 1, exposure_time_absolute = 50 }",
        set: |s, v| camera::add_controls(v, &mut s.capture.camera.controls),
        get: |s| camera::controls_value(&s.capture.camera.controls),
    },
    Key {
        section: "capture",
        name: "lock",
        about: "Hold a camera's exposure, white balance, gain and focus as they are when its picture has settled, after a second.",
        example: "",
        set: |s, v| meaning::yes_or_no(v).map(|yes| s.capture.camera.lock = yes),
        get: |s| Some(Value::Boolean(s.capture.camera.lock)),
    },
    Key {
        section: "capture",
        name: "restore",
        about: "Put a camera's controls back at the end as they were.",
        example: "",
        set: |s, v| meaning::yes_or_no(v).map(|yes| s.capture.camera.restore = yes),
        get: |s| Some(Value::Boolean(s.capture.camera.restore)),
    },
    Key {
        section: "simulation",
        name: "grippers",
        about: "How many grippers hold the rope: 1 or 2. They take commands from lariat/<rig>/commands.",
        example: "",
        set: |s, v| set_count(v, 1, 2, &mut s.simulation.grippers),
        get: |s| Some(Value::Integer(s.simulation.grippers as i64)),
    },
    Key {
        section: "simulation",
        name: "length_px",
        about: "Length of the rope in pixels: 100 to two thirds of the picture's width, and of 4/3 of its height.",
        example: "",
        set: |s, v| simulation::between(v, 100.0, 6000.0).map(|px| s.simulation.length_px = px),
        get: |s| Some(meaning::number_value(s.simulation.length_px)),
    },
    Key {
        section: "simulation",
        name: "stiffness",
        about: "Bending stiffness by mass of length, in m⁴/s² with a pixel as a millimetre, 0.01 to 1: a cable has 0.1.",
        example: "",
        set: |s, v| simulation::between(v, 0.01, 1.0).map(|b| s.simulation.stiffness = b),
        get: |s| Some(meaning::number_value(s.simulation.stiffness)),
    },
    Key {
        section: "simulation",
        name: "friction",
        about: "Coefficient of friction with the table, 0 to 1.",
        example: "",
        set: |s, v| simulation::between(v, 0.0, 1.0).map(|mu| s.simulation.friction = mu),
        get: |s| Some(meaning::number_value(s.simulation.friction)),
    },
    Key {
        section: "simulation",
        name: "noise",
        about: "Standard deviation of the camera's noise in its picture, in steps of a byte, 0 to 4.",
        example: "",
        set: |s, v| simulation::between(v, 0.0, 4.0).map(|noise| s.simulation.noise = noise),
        get: |s| Some(meaning::number_value(s.simulation.noise)),
    },
    Key {
        section: "simulation",
        name: "hand_at_s",
        about: "Let a hand come and rest on the rope, from this moment on, in seconds after the first frame.",
        example: "2",
        set: |s, v| simulation::between(v, 0.0, 1e6).map(|at| s.simulation.hand_at_s = Some(at)),
        get: |s| s.simulation.hand_at_s.map(meaning::number_value),
    },
    Key {
        section: "simulation",
        name: "hand_for_s",
        about: "For how many seconds it rests there.",
        example: "",
        set: |s, v| simulation::between(v, 0.0, 1e6).map(|time| s.simulation.hand_for_s = time),
        get: |s| Some(meaning::number_value(s.simulation.hand_for_s)),
    },
    Key {
        section: "camera",
        name: "calibration",
        about: "The lens: a file of OpenCV's FileStorage or of ROS's camera_calibration (YAML). A rope's points are undistorted\n\
                by it, never the image.",
        example: "\"camera.yaml\"",
        set: |s, v| meaning::text(v).map(|text| s.camera.calibration = Some(PathBuf::from(text))),
        get: |s| s.camera.calibration.as_ref().map(|path| path_value(path)),
    },
    Key {
        section: "camera",
        name: "plane",
        about: "The table that the rope lies on: a file as `lariat calibrate plane` writes it.",
        example: "\"plane.toml\"",
        set: |s, v| meaning::text(v).map(|text| s.camera.plane = Some(PathBuf::from(text))),
        get: |s| s.camera.plane.as_ref().map(|path| path_value(path)),
    },
    Key {
        section: "camera",
        name: "unit",
        about: "What descriptors come in: \"px\" of the image (with a calibration, of one without distortion), or \"mm\" on the\n\
                plane. If not set, mm where a plane is named.",
        example: "\"mm\"",
        set: |s, v| meaning::named("units", &view::UNITS, v).map(|unit| s.camera.unit = Some(unit)),
        get: |s| s.camera.unit.map(|unit| Value::String(unit.to_string())),
    },
    Key {
        section: "extract",
        name: "mask",
        about: "What is rope. \"auto\" takes what differs from the background. Or colours, one range or more:\n\
                [{ hue_deg = [190, 250], saturation = [0.3, 1], value = [0.2, 1] }]\n\
                Hue in degrees, 0 to 360 (twice OpenCV's 0 to 179), and [350, 10] goes through red; saturation \
                and\nvalue from 0 to 1 (OpenCV's divided by 255). `lariat pick PICTURE` proposes them.\n\
                Or \"external\": another process writes each frame's mask to lariat/<rig>/masks.",
        example: "",
        set: |s, v| meaning::mask(v).map(|mask| s.extract.mask = mask),
        get: |s| Some(meaning::mask_value(&s.extract.mask)),
    },
    Key {
        section: "extract",
        name: "mask_deadline_us",
        about: "A frame whose external mask has not come this long after its capture is skipped, in microseconds.",
        example: "",
        set: |s, v| {
            meaning::time(v, 1e-6, "microseconds").map(|time| s.extract.mask_deadline = time)
        },
        get: |s| {
            let us = s.extract.mask_deadline.as_nanos() as f64 / 1e3;
            Some(meaning::number_value(us))
        },
    },
    Key {
        section: "extract",
        name: "method",
        about: "How the mask becomes a centerline: \"skeleton\", the most accurate and by far the fastest, or, to compare\n\
                with it, the centers of a clustering, put in order: \"kmeans\", \"som\", \"gmm\" or \"fcm\".",
        example: "",
        set: |s, v| {
            meaning::named("methods", &Method::ALL, v).map(|method| s.extract.method = method)
        },
        get: |s| Some(Value::String(s.extract.method.to_string())),
    },
    Key {
        section: "extract",
        name: "points",
        about: "Points of a centerline, at equal steps of arc length: more than the order, at most 256.",
        example: "",
        set: |s, v| set_count(v, 2, lariat_fit::MAX_POINTS, &mut s.extract.points),
        get: |s| Some(Value::Integer(s.extract.points as i64)),
    },
    Key {
        section: "extract",
        name: "ropes",
        about: "The most ropes reported, the longest first: 1 to 8.",
        example: "",
        set: |s, v| set_count(v, 1, 8, &mut s.extract.ropes),
        get: |s| Some(Value::Integer(s.extract.ropes as i64)),
    },
    Key {
        section: "extract",
        name: "start",
        about: "A rope's first point in the first frame is the end nearest to this position [x, y], in pixels; \
                if not\nset, the end nearest to the top left.",
        example: "[0, 0]",
        set: |s, v| meaning::position(v).map(|at| s.extract.start = Some(at)),
        get: |s| {
            Some(Value::Array(
                s.extract
                    .start?
                    .map(|c| meaning::number_value(c.into()))
                    .into(),
            ))
        },
    },
    Key {
        section: "extract",
        name: "keep_lost_s",
        about: "For how many seconds a rope that is out of sight is still reported, as lost.",
        example: "",
        set: |s, v| meaning::time(v, 1.0, "seconds").map(|time| s.extract.keep_lost = time),
        get: |s| Some(meaning::number_value(s.extract.keep_lost.as_secs_f64())),
    },
    Key {
        section: "extract",
        name: "roi",
        about: "The part of the image that is read, [x, y, width, height] in pixels: a rope ends at its edge as at the image's.",
        example: "[160, 120, 320, 240]",
        set: |s, v| view::region(v).map(|region| s.extract.roi = Some(region)),
        get: |s| s.extract.roi.map(view::region_value),
    },
    Key {
        section: "fit",
        name: "basis",
        about: "The family of curves: \"auto\" (the fewest control points that keep the curve on the rope), \"bezier\" (the paper's),\n\
                \"bspline\", \"rational\", \"points\" (of the rope itself), \"mass\" (its center). Closed ropes are always truncated\n\
                Fourier series; with \"fourier\" `lariat fit` takes every line for one.",
        example: "",
        set: |s, v| meaning::named("bases", &Family::ALL, v).map(|basis| s.fit.basis = basis),
        get: |s| Some(Value::String(s.fit.basis.to_string())),
    },
    Key {
        section: "fit",
        name: "order",
        about: "Order of the curve, 1 to 31 (8 if only its basis is named; without a basis it is a Bezier curve's), or \"auto\": the\n\
                least that keeps the curve on the rope. A curve has one control point more, of whatever basis (a closed one at\n\
                most as many numbers).",
        example: "8",
        set: |s, v| meaning::order(v).map(|order| s.fit.order = Some(order)),
        get: |s| {
            Some(match s.fit.order? {
                Order::Named(order) => Value::Integer(order as i64),
                Order::Auto => Value::String("auto".to_owned()),
            })
        },
    },
    Key {
        section: "fit",
        name: "max_order",
        about: "The highest order that order = \"auto\" chooses.",
        example: "",
        set: |s, v| set_count(v, 1, MAX_ORDER, &mut s.fit.max_order),
        get: |s| Some(Value::Integer(s.fit.max_order as i64)),
    },
    Key {
        section: "fit",
        name: "tolerance",
        about: "How far from the curve, in widths of the rope, 95 % of its points may be, and all within half a width. A curve that\n\
                is farther off is \"coarse\", which its descriptor says.",
        example: "",
        set: |s, v| meaning::above_zero(v).map(|widths| s.fit.tolerance = widths),
        get: |s| Some(meaning::number_value(s.fit.tolerance)),
    },
    Key {
        section: "fit",
        name: "tolerance_px",
        about: "And at most so many pixels of the image, which counts for wide ropes.",
        example: "",
        set: |s, v| meaning::above_zero(v).map(|px| s.fit.tolerance_px = px),
        get: |s| Some(meaning::number_value(s.fit.tolerance_px)),
    },
    Key {
        section: "fit",
        name: "degree",
        about: "Degree of a B-spline's pieces, 1 to 31.",
        example: "",
        set: |s, v| set_count(v, 1, MAX_ORDER, &mut s.fit.degree),
        get: |s| Some(Value::Integer(s.fit.degree as i64)),
    },
    Key {
        section: "fit",
        name: "knots",
        about: "Where a B-spline's pieces meet: at even steps (\"uniform\") or evenly among the points (\"averaged\").",
        example: "",
        set: |s, v| {
            meaning::named("kinds of knots", &Knots::NAMED, v).map(|knots| s.fit.knots = knots)
        },
        get: |s| meaning::name_of(&Knots::NAMED, s.fit.knots),
    },
    Key {
        section: "fit",
        name: "solver",
        about: "How it is computed: \"pinv\" (fastest), \"cholesky\" or \"qr\".",
        example: "",
        set: |s, v| meaning::named("solvers", &Solver::ALL, v).map(|solver| s.fit.solver = solver),
        get: |s| Some(Value::String(s.fit.solver.to_string())),
    },
    Key {
        section: "fit",
        name: "ridge",
        about: "What a bend of the control polygon costs, 0 or more: a little of it tames high orders.",
        example: "",
        set: |s, v| meaning::at_least_zero(v).map(|ridge| s.fit.ridge = ridge),
        get: |s| Some(meaning::number_value(s.fit.ridge)),
    },
    Key {
        section: "fit",
        name: "pin_ends",
        about: "Let curves begin and end exactly at the centerline's ends.",
        example: "",
        set: |s, v| meaning::yes_or_no(v).map(|yes| s.fit.pin_ends = yes),
        get: |s| Some(Value::Boolean(s.fit.pin_ends)),
    },
    Key {
        section: "fit",
        name: "rho",
        about: "The arc length that each point stands for: in \"even\" steps, or \"measured\" along the points, chord by chord.",
        example: "",
        set: |s, v| meaning::named("ways", &Rho::ALL, v).map(|rho| s.fit.rho = rho),
        get: |s| meaning::name_of(&Rho::ALL, s.fit.rho),
    },
    Key {
        section: "fit",
        name: "robust",
        about: "Let points far off the curve weigh less, and those of a rope that were covered nothing.",
        example: "",
        set: |s, v| meaning::yes_or_no(v).map(|yes| s.fit.robust = yes),
        get: |s| Some(Value::Boolean(s.fit.robust)),
    },
    Key {
        section: "fit",
        name: "filter",
        about: "Filter the control points in time (Kalman, constant velocity); descriptors then have velocities too.",
        example: "",
        set: |s, v| meaning::yes_or_no(v).map(|yes| s.fit.filter = yes),
        get: |s| Some(Value::Boolean(s.fit.filter)),
    },
    Key {
        section: "fit",
        name: "acceleration_px_s2",
        about: "How much the filter thinks the rope's points accelerate, in px/s² over 1 s (of the image, also where\n\
                descriptors come in mm): the more, the less it smooths.",
        example: "",
        set: |s, v| meaning::above_zero(v).map(|a| s.fit.acceleration_px_s2 = a),
        get: |s| Some(meaning::number_value(s.fit.acceleration_px_s2)),
    },
    Key {
        section: "sink",
        name: "live",
        about: "Show a line of figures while the chain runs.",
        example: "",
        set: |s, v| meaning::yes_or_no(v).map(|yes| s.sink.live = yes),
        get: |s| Some(Value::Boolean(s.sink.live)),
    },
    Key {
        section: "record",
        name: "images",
        about: "How frames are recorded: \"raw\" (as they are), \"png\" (a quarter to a half, to the bit, for a core's work),\n\
                \"jpeg\" (a tenth), or \"none\".",
        example: "",
        set: |s, v| {
            meaning::named("kinds of images", &recording::IMAGES, v)
                .map(|images| s.record.images = images)
        },
        get: |s| meaning::name_of(&recording::IMAGES, s.record.images),
    },
    Key {
        section: "record",
        name: "quality",
        about: "Quality of JPEGs, 1 to 100.",
        example: "",
        set: |s, v| meaning::whole(v, 1, 100).map(|n| s.record.quality = n as u8),
        get: |s| Some(Value::Integer(s.record.quality.into())),
    },
    Key {
        section: "record",
        name: "compression",
        about: "How the recording is compressed: \"none\", \"lz4\" or \"zstd\".",
        example: "",
        set: |s, v| {
            meaning::named("compressions", &recording::COMPRESSIONS, v)
                .map(|compression| s.record.compression = compression)
        },
        get: |s| meaning::name_of(&recording::COMPRESSIONS, s.record.compression),
    },
    Key {
        section: "record",
        name: "queue_mb",
        about: "Memory for what waits for the disk, in MB. What finds no room is dropped, and counted.",
        example: "",
        set: |s, v| recording::megabytes(v).map(|bytes| s.record.queue_bytes = bytes),
        get: |s| Some(recording::megabytes_value(s.record.queue_bytes)),
    },
    Key {
        section: "record",
        name: "ring_s",
        about: "Keep only the last so many seconds, in memory; `lariat record --flush` writes them.",
        example: "30",
        set: |s, v| meaning::time(v, 1.0, "seconds").map(|time| s.record.ring = Some(time)),
        get: |s| {
            s.record
                .ring
                .map(|time| meaning::number_value(time.as_secs_f64()))
        },
    },
    Key {
        section: "record",
        name: "ring_mb",
        about: "The most memory that these seconds may take, in MB.",
        example: "",
        set: |s, v| recording::megabytes(v).map(|bytes| s.record.ring_bytes = bytes),
        get: |s| Some(recording::megabytes_value(s.record.ring_bytes)),
    },
    Key {
        section: "record",
        name: "replace",
        about: "Let a recording, report or timeline that is there already make room for the new one.",
        example: "",
        set: |s, v| meaning::yes_or_no(v).map(|yes| s.record.replace = yes),
        get: |s| Some(Value::Boolean(s.record.replace)),
    },
];

fn set_count(value: &Value, low: usize, high: usize, to: &mut usize) -> Result<(), String> {
    let number = meaning::whole(value, low as i64, high as i64)?;
    *to = number.unsigned_abs() as usize;
    Ok(())
}

fn path_value(path: &std::path::Path) -> Value {
    Value::String(path.to_string_lossy().into_owned())
}
