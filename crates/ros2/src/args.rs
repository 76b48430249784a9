//! Command-line options of lariat and of ROS.

use std::ffi::OsString;
use std::path::PathBuf;

use anyhow::Result;
use clap::Parser;
use lariat_chain::exit::{WrongUse, wrong_use};
use lariat_wire::{Axes, MAX_GRIPPERS, Rig};

/// A rig in a ROS 2 graph: ropes, images and health as topics, for as long as something subscribes
#[derive(Debug, Clone, Parser)]
#[command(name = "lariat ros2", version, after_help = EXAMPLES)]
pub(crate) struct Args {
    /// Name of the rig
    #[arg(long, value_name = "NAME", default_value = "default")]
    pub(crate) rig: Rig,
    /// Domain of the graph, 0 to 232; by default ROS_DOMAIN_ID, or 0
    #[arg(long, value_name = "N")]
    domain_id: Option<u16>,
    /// Coordinate frame of ropes; by default the rig's name, or that of images for ropes in the
    /// camera's axes
    #[arg(long, value_name = "NAME")]
    frame_id: Option<String>,
    /// Coordinate frame of images; by default the rig's name with _camera
    #[arg(long, value_name = "NAME")]
    camera_frame_id: Option<String>,
    /// Send each message once, as sensor data. Subscribers that request reliable delivery, such as
    /// RViz, are then not matched
    #[arg(long)]
    pub(crate) best_effort: bool,
    /// JPEG quality of images, 1 to 100
    #[arg(long, value_name = "N", default_value_t = 80, value_parser = clap::value_parser!(u8).range(1..=100))]
    pub(crate) jpeg_quality: u8,
    /// Maximum size of a message in bytes; larger ones are not sent
    #[arg(long, value_name = "N", default_value_t = 4_000_000)]
    pub(crate) max_bytes: usize,
    /// Topic whose images become the rig's frames: sensor_msgs/Image, or CompressedImage if it ends
    /// in /compressed
    #[arg(long, value_name = "TOPIC", help_heading = IN)]
    pub(crate) image: Option<String>,
    /// Topic of masks of these images, mono8, paired by stamp, for a chain with --mask external
    #[arg(long, value_name = "TOPIC", requires = "image", help_heading = IN)]
    pub(crate) mask: Option<String>,
    /// Topic of the camera's sensor_msgs/CameraInfo, which becomes the chain's calibration
    #[arg(long, value_name = "TOPIC", help_heading = IN)]
    pub(crate) camera_info: Option<String>,
    /// File for that calibration; by default the rig's name with _camera.yaml, in the current
    /// folder
    #[arg(long, value_name = "FILE", requires = "camera_info", help_heading = IN)]
    pub(crate) calibration_out: Option<PathBuf>,
    /// Topic of geometry_msgs/TwistStamped that moves a gripper of the simulated rope; repeat for
    /// the second gripper
    #[arg(long, value_name = "TOPIC", help_heading = IN)]
    pub(crate) gripper: Vec<String>,
    /// Request that lost images and masks are sent again; best-effort publishers are then not
    /// received
    #[arg(long, help_heading = IN)]
    pub(crate) reliable_images: bool,
    /// Use the arrival time of messages instead of their stamps, for recorded or simulated time
    #[arg(long, help_heading = IN)]
    pub(crate) stamp_on_arrival: bool,
    #[arg(skip)]
    pub(crate) names: Names,
}

const IN: &str = "From the graph to the rig";

const EXAMPLES: &str = "Examples:
  lariat ros2                                  the rig default, under /lariat/default/
  lariat ros2 --rig left --frame-id table
  lariat ros2 --image /camera/image_raw        the frames of `lariat run --source external`
  lariat ros2 --ros-args -r __ns:=/cell -r /lariat/default/points:=/rope";

/// Names of the node and its topics.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Names {
    node: Option<String>,
    namespace: Option<String>,
    /// Pairs of old and new name.
    topics: Vec<(String, String)>,
}

impl Args {
    /// Parses the arguments of this process; exits on `--help` or a syntax error.
    pub(crate) fn from_command_line() -> Result<Self> {
        let (ours, ros) = split(std::env::args_os().collect());
        let mut args = Self::parse_from(ours);
        args.names = Names::of(&ros)?;
        if args.gripper.len() > MAX_GRIPPERS {
            wrong_use!(
                "the simulated rope has {MAX_GRIPPERS} grippers at most: say --gripper no more often"
            );
        }
        Ok(args)
    }

    /// Domain of the graph.
    pub(crate) fn domain_id(&self) -> Result<u16> {
        let id = match (self.domain_id, std::env::var("ROS_DOMAIN_ID")) {
            (Some(id), _) => id,
            (None, Ok(text)) if !text.trim().is_empty() => text.trim().parse().map_err(|_| {
                WrongUse(format!(
                    "ROS_DOMAIN_ID={text} is not a number from 0 to 232"
                ))
            })?,
            _ => 0,
        };
        // Ports follow from it, and there are no more.
        if id > 232 {
            wrong_use!("the domain {id} is too large: use 0 to 232");
        }
        Ok(id)
    }

    /// Coordinate frame of ropes: in space with these axes, otherwise on the plane or in the image.
    pub(crate) fn frame_id(&self, in_space: Option<Axes>) -> String {
        let usual = || match in_space {
            Some(Axes::Camera) => self.camera_frame_id(),
            Some(Axes::Robot) | None => self.rig.to_string(),
        };
        self.frame_id.clone().unwrap_or_else(usual)
    }

    /// Coordinate frame of images.
    pub(crate) fn camera_frame_id(&self) -> String {
        let usual = || format!("{}_camera", self.rig);
        self.camera_frame_id.clone().unwrap_or_else(usual)
    }
}

impl Names {
    /// Parses the words between `--ros-args` and `--`.
    fn of(words: &[String]) -> Result<Self> {
        let mut names = Self::default();
        let mut words = words.iter();
        while let Some(word) = words.next() {
            match word.as_str() {
                "-r" | "--remap" => {
                    let Some(rule) = words.next() else {
                        wrong_use!("{word} wants FROM:=TO behind it");
                    };
                    names.add(rule)?;
                }
                // ROS's own log always goes to standard error.
                "--log-level" => drop(words.next()),
                "--enable-rosout-logs"
                | "--disable-rosout-logs"
                | "--enable-stdout-logs"
                | "--disable-stdout-logs" => {}
                other => wrong_use!(
                    "{other} behind --ros-args is not understood: -r FROM:=TO, -r __ns:=NAMESPACE and -r __node:=NAME are"
                ),
            }
        }
        Ok(names)
    }

    fn add(&mut self, rule: &str) -> Result<()> {
        let parts = rule.split_once(":=");
        let Some((from, to)) = parts.filter(|(from, to)| !from.is_empty() && !to.is_empty()) else {
            wrong_use!("{rule} is not a rule for a name: write FROM:=TO");
        };
        match from {
            "__ns" => self.namespace = Some(to.to_owned()),
            "__node" => self.node = Some(to.to_owned()),
            _ => self.topics.push((from.to_owned(), to.to_owned())),
        }
        Ok(())
    }

    /// Name of the node, or `usual` if none was given.
    pub(crate) fn node<'a>(&'a self, usual: &'a str) -> &'a str {
        self.node.as_deref().unwrap_or(usual)
    }

    /// Namespace of the node.
    pub(crate) fn namespace(&self) -> &str {
        self.namespace.as_deref().unwrap_or("/")
    }

    /// Full name of a topic whose name in the namespace is this, such as `lariat/default/points`.
    pub(crate) fn topic(&self, name: &str) -> String {
        let whole = self.whole(name);
        let rule = self
            .topics
            .iter()
            .find(|(from, _)| self.whole(from) == whole);
        rule.map_or(whole, |(_, to)| self.whole(to))
    }

    fn whole(&self, name: &str) -> String {
        if name.starts_with('/') {
            return name.to_owned();
        }
        format!("{}/{name}", self.namespace().trim_end_matches('/'))
    }
}

/// Separates lariat's words from ROS's.
fn split(words: Vec<OsString>) -> (Vec<OsString>, Vec<String>) {
    let (mut ours, mut ros, mut is_ros) = (Vec::new(), Vec::new(), false);
    for word in words {
        match (word.to_str(), is_ros) {
            (Some("--ros-args"), _) => is_ros = true,
            (Some("--"), true) => is_ros = false,
            (_, true) => ros.push(word.to_string_lossy().into_owned()),
            (_, false) => ours.push(word),
        }
    }
    (ours, ros)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(words: &[&str]) -> Result<Names> {
        let words: Vec<String> = words.iter().map(ToString::to_string).collect();
        Names::of(&words)
    }

    #[test]
    fn topics_lie_in_the_namespace_and_are_renamed_by_rules() {
        let plain = Names::default();
        assert_eq!(plain.topic("lariat/left/points"), "/lariat/left/points");
        let named = names(&[
            "-r",
            "__ns:=/cell",
            "--remap",
            "__node:=eyes",
            "-r",
            "lariat/left/points:=/rope",
            "-r",
            "/cell/lariat/left/markers:=drawn",
        ])
        .expect("rules");
        assert_eq!(named.node("lariat"), "eyes");
        assert_eq!(named.topic("lariat/left/points"), "/rope");
        assert_eq!(named.topic("lariat/left/markers"), "/cell/drawn");
        assert_eq!(
            named.topic("lariat/left/endpoints"),
            "/cell/lariat/left/endpoints"
        );
    }

    #[test]
    fn what_is_no_rule_is_refused_with_a_sentence() {
        for words in [&["-r"][..], &["-r", "points"], &["-r", ":=to"], &["--more"]] {
            let error = names(words).expect_err("no rule").to_string();
            assert!(
                error.contains("-r") || error.contains("FROM:=TO"),
                "{error}"
            );
        }
    }

    #[test]
    fn words_of_ros_end_where_it_says() {
        let words = [
            "lariat",
            "--rig",
            "a",
            "--ros-args",
            "-r",
            "b:=c",
            "--",
            "--best-effort",
        ];
        let (ours, ros) = split(words.iter().map(OsString::from).collect());
        assert_eq!(ours, ["lariat", "--rig", "a", "--best-effort"]);
        assert_eq!(ros, ["-r", "b:=c"]);
    }
}
