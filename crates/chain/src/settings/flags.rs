//! The flags that overrule the file: one table, of which the command line, its help and the settings are made.

use crate::settings::curve::Family;
use crate::settings::keys::{self, KEYS};
use crate::settings::{Settings, arrangement, camera, duration, recording, view};
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};
use lariat_extract::Method;
use lariat_fit::{Knots, Rho, Solver};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use toml::Value;

/// What follows a flag, and what it is called there.
#[derive(Clone, Copy)]
enum Takes {
    /// Nothing: the flag switches its setting on.
    Nothing,
    Text(&'static str),
    /// One of a few names.
    Name(&'static str, fn() -> Vec<&'static str>),
    /// A whole number, or a word that the setting knows.
    Whole(&'static str),
    /// A number, or a word that the setting knows.
    Number(&'static str),
    /// A time, for a setting in this unit, of which so many make a second.
    Time(f64),
    /// Bytes, for a setting in MB.
    Size,
    Control,
    /// A value as the file has it, or a word.
    Toml(&'static str),
    /// One path or more, which may also stand without the flag.
    Paths,
}

/// One flag.
struct Flag {
    name: &'static str,
    /// Section and name of its setting.
    setting: (&'static str, &'static str),
    takes: Takes,
    /// The commands that have it, beside `run` and those that take all that `run` does.
    of: &'static str,
    heading: &'static str,
    /// A line for `-h`; `--help` has what the table of settings says.
    help: &'static str,
}

/// Commands that take every flag: those that run a whole chain, and those that it starts.
const TAKE_ALL: [&str; 4] = ["run", "recorder", "controller", "show"];
const STAGES: &str = "capture extract fit sink";
const SHAPES: &str = "fit trace replay";
const SEEN: &str = "extract trace replay";

macro_rules! flags {
    ($($heading:literal { $($name:literal $section:ident.$key:ident $takes:expr, $of:expr, $help:literal;)* })*) => {
        &[$($(Flag {
            name: $name,
            setting: (stringify!($section), stringify!($key)),
            takes: $takes,
            of: $of,
            heading: $heading,
            help: $help,
        },)*)*]
    };
}

use Takes::{Control, Name, Nothing, Number, Paths, Size, Text, Time, Toml, Whole};

#[rustfmt::skip]
const FLAGS: &[Flag] = flags! {
    "Source" {
        "--source" capture.source Paths, "capture snapshot", "Camera, pictures, video, recording, external or -";
        "--fps" capture.fps Number("NUMBER"), "capture sink snapshot trace", "Frames per second, `max` or `auto`";
        "--size" capture.size Text("WxH"), "capture snapshot trace", "Size of a camera's, rendered or raw picture";
        "--seed" capture.seed Whole("NUMBER"), "capture snapshot", "Which of all rendered or simulated ropes";
        "--from" capture.from Whole("PLACE"), "capture trace", "Begin with this frame, or time such as 2.5s";
        "--to" capture.to Whole("PLACE"), "capture trace", "End with this frame, or before this time";
        "--every" capture.every Whole("N"), "capture trace", "Show every Nth frame only";
        "--loop" capture.loop Nothing, "capture", "Begin again after the last file";
        "--topic" capture.topic Text("TOPIC"), "capture trace", "Of a recording with several cameras, the images";
        "--follow" capture.follow Nothing, "capture", "Show each picture that comes into a folder";
    }
    "Camera" {
        "--pixel-format" capture.pixel_format Text("CODE"), "capture snapshot trace", "Pixel format, such as yuyv or mjpg; raw: rgb8";
        "--io" capture.io Name("WAY", || names(&camera::IO)), "capture snapshot", "How frames come from the driver";
        "--control" capture.controls Control, "capture snapshot", "Set a control, such as exposure_auto=1";
        "--lock" capture.lock Nothing, "capture", "Hold exposure, white balance, gain and focus";
        "--restore" capture.restore Nothing, "capture", "Put controls back at the end";
    }
    "Rope" {
        "--mask" extract.mask Toml("MASK"), SEEN, "What is rope: auto, external or colours";
        "--ropes" extract.ropes Whole("N"), SEEN, "The most ropes reported, 1 to 8";
        "--start" extract.start Text("X,Y"), SEEN, "A rope's first end is the one nearest to this";
        "--roi" extract.roi Text("X,Y,W,H"), SEEN, "Part of the image that is read";
        "--points" extract.points Whole("N"), "capture extract fit trace replay", "Points of a centerline";
        "--method" extract.method Name("NAME", || names(&Method::ALL)), SEEN, "How the mask becomes a centerline";
    }
    "Curve" {
        "--basis" fit.basis Name("NAME", || names(&Family::ALL)), SHAPES, "Family of the curve";
        "--order" fit.order Whole("N"), SHAPES, "Order of the curve, 1 to 31, or `auto`";
        "--degree" fit.degree Whole("N"), SHAPES, "Degree of a B-spline's pieces";
        "--knots" fit.knots Name("NAME", || names(&Knots::NAMED)), SHAPES, "Where a B-spline's pieces meet";
        "--rho" fit.rho Name("NAME", || names(&Rho::ALL)), SHAPES, "Arc length that each point stands for";
        "--ridge" fit.ridge Number("NUMBER"), SHAPES, "What a bend of the control polygon costs";
        "--pin-ends" fit.pin_ends Nothing, SHAPES, "Begin and end at the centerline's ends";
        "--robust" fit.robust Nothing, SHAPES, "Let points far off the curve weigh less";
        "--filter" fit.filter Nothing, "fit trace replay", "Filter the control points in time";
        "--solver" fit.solver Name("NAME", || names(&Solver::ALL)), SHAPES, "How the curve is computed";
    }
    "Millimetres" {
        "--calibration" camera.calibration Text("FILE"), SHAPES, "Lens: a YAML file of OpenCV or ROS";
        "--plane" camera.plane Text("FILE"), SHAPES, "Table, by `lariat calibrate plane`";
        "--unit" camera.unit Name("UNIT", || names(&view::UNITS)), SHAPES, "What descriptors come in";
    }
    "Run" {
        "--duration" run.duration_s Time(1.0), "capture sink record", "Stop after this long, such as 10s or 2m";
        "--frames" run.frames Whole("COUNT"), "capture sink record", "Stop after this many frames";
        "--rig" run.rig Text("NAME"), "capture extract fit sink record", "Name of the chain, to run several";
        "--lossless" run.lossless Nothing, "capture extract fit sink record", "Wait for slow readers, lose no frame";
        "--fuse" run.fuse Nothing, "", "Capture, extract and fit in one process";
    }
    "Report" {
        "--out" run.out Text("DIR"), "sink", "Write the report into this folder";
        "--trace" run.trace Text("FILE.json"), "sink", "Write a timeline for ui.perfetto.dev";
        "--deadline" run.deadline_us Time(1e6), "sink", "Latency that counts as a miss, such as 33ms";
    }
    "Recording" {
        "--record" run.record Text("FILE.mcap"), "", "Record what the chain sees and says";
        "--images" record.images Name("KIND", || names(&recording::IMAGES)), "record", "How frames are recorded";
        "--quality" record.quality Whole("N"), "record", "Quality of JPEGs, 1 to 100";
        "--compression" record.compression Name("NAME", || names(&recording::COMPRESSIONS)), "record", "How it is compressed";
        "--queue" record.queue_mb Size, "record", "Memory for what waits for the disk";
        "--ring" record.ring_s Time(1.0), "record", "Keep the last so much, write it when told";
        "--ring-memory" record.ring_mb Size, "record", "The most memory that --ring may take";
        "--force" record.replace Nothing, "record sink", "Overwrite files that are there";
    }
    "Real time" {
        "--realtime" run.realtime Nothing, STAGES, "FIFO scheduling, locked memory, chosen cores";
        "--cpus" run.cpus Text("CORES"), STAGES, "Core of each stage, such as 0,0,1,1";
        "--scheduling" run.scheduling Name("CLASS", || names(&arrangement::SCHEDULING)), STAGES, "Scheduling class";
        "--priority" run.priority Whole("N"), STAGES, "Priority of capture under FIFO";
        "--lock-memory" run.lock_memory Nothing, STAGES, "Keep memory from being paged out";
        "--wake" run.wake Name("HOW", || names(&arrangement::WAKES)), "extract fit sink", "How a stage learns of a message";
        "--spin" run.spin_us Time(1e6), "extract fit sink", "How long --wake spin looks, such as 50us";
    }
};

fn names<T>(table: &[(&'static str, T)]) -> Vec<&'static str> {
    table.iter().map(|(name, _)| *name).collect()
}

/// The flags that were given. Which there are depends on the command whose arguments they become, by its name.
#[derive(Debug, Clone, Default)]
pub struct Flags {
    /// Settings file (`--config`).
    pub config: Option<PathBuf>,
    given: Vec<Given>,
}

#[derive(Debug, Clone)]
struct Given {
    flag: &'static str,
    /// What was typed behind it; nothing behind a switch.
    typed: Vec<String>,
    /// As the file would have it.
    value: Value,
}

/// What was typed behind a flag, and the value that it is.
#[derive(Clone)]
struct Typed(String, Value);

impl Flags {
    /// Those of one settings file alone.
    pub fn of_file(path: PathBuf) -> Self {
        Self {
            config: Some(path),
            given: Vec::new(),
        }
    }

    /// Whether there are any.
    pub fn is_given(&self) -> bool {
        self.config.is_some() || !self.given.is_empty()
    }

    /// Whether this one is among them.
    pub fn has(&self, flag: &str) -> bool {
        self.given.iter().any(|given| given.flag == flag)
    }

    /// All but these.
    pub fn without(&self, flags: &[&str]) -> Self {
        let given = self.given.iter();
        let others = given.filter(|given| !flags.contains(&given.flag));
        Self {
            config: self.config.clone(),
            given: others.cloned().collect(),
        }
    }

    /// These, and a source.
    pub fn with_source(&self, path: &Path) -> Self {
        let mut flags = self.clone();
        let path = path.to_string_lossy().into_owned();
        flags.given.push(Given {
            flag: "--source",
            typed: vec![path.clone()],
            value: Value::Array(vec![Value::String(path)]),
        });
        flags
    }

    /// As words of a command line, for the processes of a chain.
    pub fn words(&self) -> Vec<OsString> {
        let mut words = Vec::new();
        if let Some(path) = &self.config {
            words.extend(["--config".into(), path.into()]);
        }
        for Given { flag, typed, .. } in &self.given {
            if typed.is_empty() {
                words.push(flag.into());
            }
            words.extend(typed.iter().map(|text| format!("{flag}={text}").into()));
        }
        words
    }

    /// Each flag, with its setting's place in the table of settings.
    pub(super) fn given(&self) -> impl Iterator<Item = (&'static str, usize, &Value)> {
        self.given.iter().filter_map(|Given { flag, value, .. }| {
            let (section, name) = FLAGS.iter().find(|known| known.name == *flag)?.setting;
            Some((*flag, keys::position(section, name)?, value))
        })
    }

    fn take(&mut self, flag: &'static Flag, matches: &ArgMatches) {
        let id = &flag.name[2..];
        let mut give = |typed, value| {
            self.given.push(Given {
                flag: flag.name,
                typed,
                value,
            });
        };
        if let Nothing = flag.takes {
            // A command that has no such flag was not given it.
            if let Ok(Some(true)) = matches.try_get_one(id).map(|yes| yes.copied()) {
                give(Vec::new(), Value::Boolean(true));
            }
            return;
        }
        let of = |id| matches.try_get_many::<Typed>(id).ok().flatten();
        let values = of(id).into_iter().flatten().cloned();
        if let Paths = flag.takes {
            let bare = of(BARE_SOURCE).into_iter().flatten().cloned();
            let (typed, paths): (Vec<_>, Vec<_>) = bare
                .chain(values)
                .map(|Typed(text, value)| (text, value))
                .unzip();
            if !paths.is_empty() {
                give(typed, Value::Array(paths));
            }
            return;
        }
        for Typed(text, value) in values {
            give(vec![text], value);
        }
    }
}

/// The sources that stand without a flag before them.
const BARE_SOURCE: &str = "SOURCE";

/// Whether a chain started this process: its stages are given all of the chain's flags, and take what concerns them.
fn is_started_by_a_chain() -> bool {
    std::env::var_os(crate::stages::status::STATUS_FD).is_some()
}

impl Args for Flags {
    fn augment_args(command: Command) -> Command {
        let name = command.get_name().to_owned();
        let takes_all = TAKE_ALL.contains(&&name[..])
            || is_started_by_a_chain() && STAGES.split(' ').any(|stage| stage == name);
        let offered = |flag: &&Flag| takes_all || flag.of.split(' ').any(|of| of == name);
        let mut command = FLAGS
            .iter()
            .filter(offered)
            .fold(command, |command, flag| command.arg(flag.arg()));
        if ["run", "show", "capture"].contains(&&name[..]) {
            let bare = Arg::new(BARE_SOURCE)
                .num_args(1..)
                .action(ArgAction::Append)
                .value_parser(|text: &str| Paths.value(text))
                .help("Where frames come from, as with --source");
            command = command.arg(bare);
        }
        command.arg(
            Arg::new("config")
                .long("config")
                .value_name("FILE")
                .value_parser(clap::value_parser!(PathBuf))
                .help("Settings file [default: lariat.toml, if there]"),
        )
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for Flags {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut flags = Self {
            config: matches.get_one("config").cloned(),
            given: Vec::new(),
        };
        for flag in FLAGS {
            flags.take(flag, matches);
        }
        Ok(flags)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Flag {
    fn arg(&'static self) -> Arg {
        let name = &self.name[2..];
        let arg = Arg::new(name)
            .long(name)
            .help(self.help)
            .long_help(self.long_help())
            .help_heading(self.heading);
        let Some(value_name) = self.takes.value_name() else {
            return arg.action(ArgAction::SetTrue);
        };
        let takes = self.takes;
        let arg = arg
            .value_name(value_name)
            .value_parser(move |text: &str| takes.value(text))
            .allow_hyphen_values(matches!(
                takes,
                Whole(_) | Number(_) | Text("X,Y,W,H" | "X,Y")
            ));
        match takes {
            Paths => arg.num_args(1..).action(ArgAction::Append),
            Control => arg.action(ArgAction::Append),
            _ => arg.action(ArgAction::Set),
        }
    }

    /// What the table of settings says: what it does, what it is if nobody says anything, what there is to choose from.
    fn long_help(&self) -> String {
        let (section, name) = self.setting;
        let key = keys::position(section, name).map(|key| &KEYS[key]);
        let mut text = key.map_or(self.help.to_owned(), |key| key.about.replace('\n', " "));
        let default = key.and_then(|key| (key.get)(&Settings::default()));
        match default {
            None | Some(Value::Boolean(_)) => {}
            Some(Value::String(word)) => text += &format!(" [default: {word}]"),
            Some(value) => text += &format!(" [default: {}]", self.takes.shown(&value)),
        }
        if let Takes::Name(_, names) = self.takes {
            text += &format!(" [possible values: {}]", names().join(", "));
        }
        text
    }
}

impl Takes {
    fn value_name(self) -> Option<&'static str> {
        match self {
            Nothing => None,
            Text(name) | Name(name, _) | Whole(name) | Number(name) | Toml(name) => Some(name),
            Time(_) => Some("TIME"),
            Size => Some("SIZE"),
            Control => Some("NAME=VALUE"),
            Paths => Some("PATH"),
        }
    }

    /// The value as the file would have it. What the setting itself refuses is not refused here.
    fn value(self, text: &str) -> Result<Typed, String> {
        let word = || Value::String(text.to_owned());
        let value = match self {
            Nothing | Text(_) | Name(..) | Paths => word(),
            Whole(_) => text.parse().map_or_else(|_| word(), Value::Integer),
            Number(_) => text.parse().map_or_else(|_| word(), Value::Float),
            Time(per_s) => Value::Float(per_s * duration::parse(text)?.as_secs_f64()),
            Size => recording::megabytes_value(recording::size(text)?),
            Control => camera::control(text)?,
            Toml(_) => {
                let table = format!("value = {text}").parse::<toml::Table>();
                let value = table.ok().and_then(|mut table| table.remove("value"));
                value.unwrap_or_else(word)
            }
        };
        Ok(Typed(text.to_owned(), value))
    }

    /// A default, as a flag has it.
    fn shown(self, value: &Value) -> String {
        match (
            self,
            value.as_float().or(value.as_integer().map(|n| n as f64)),
        ) {
            (Time(per_s), Some(number)) if per_s > 1.0 => format!("{number}us"),
            (Time(_), Some(number)) => format!("{number}s"),
            (Size, Some(number)) => format!("{number}MB"),
            _ => value.to_string(),
        }
    }
}
