//! Changes of settings while a chain runs: how a change is written, which stages it concerns, and
//! how they receive it.

use crate::exit::{WrongUse, wrong_use};
use crate::settings::file;
use crate::settings::keys::{self, KEYS};
use crate::settings::kind::Takes;
use crate::settings::meaning;
use crate::settings::{FILE_NAME, Family, Flags, Problems, Resolved, Settings, Stage, renamed};
use anyhow::{Result, bail};
use lariat_capture::Source;
use lariat_extract::Mask;
use lariat_wire::Member;
use std::path::Path;
use toml::Value;

/// Prefix of the first line of a versioned text.
const VERSION: &str = "# lariat settings ";

/// Returns the line with the version of a settings text.
pub fn version_line(version: u32) -> String {
    match version {
        0 => String::new(),
        _ => format!("{VERSION}{version}\n"),
    }
}

/// Stages that a change concerns, in the order of [`Stage`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Concerned {
    /// Stages that apply the change between two frames.
    pub live: [bool; 4],
    /// Stages that restart.
    pub again: [bool; 4],
}

/// How a change of a setting takes effect.
enum Way {
    /// One stage applies it between two frames.
    Live(Stage),
    /// Stages restart.
    Restart(&'static [Stage]),
    /// Only the chain itself uses the setting.
    Chain,
    /// The setting cannot change.
    Fixed,
}

fn way(section: &str, name: &str, [before, now]: [&Settings; 2]) -> Way {
    let all = [before, now];
    match (section, name) {
        // A channel is added or removed.
        ("extract", "mask") if all.iter().any(|s| s.extract.mask == Mask::External) => {
            Way::Restart(&[Stage::Extract])
        }
        ("extract", "points") if all.iter().any(|s| knows_truth(s)) => {
            Way::Restart(&[Stage::Capture, Stage::Extract])
        }
        ("extract", _) => Way::Live(Stage::Extract),
        // Channels are added or removed. Capture may supply the depth camera's files itself.
        ("camera", "second" | "second_rig" | "second_within_us") => Way::Restart(&[Stage::Fit]),
        ("camera", "depth" | "depth_deadline_us") => Way::Restart(&[Stage::Capture, Stage::Fit]),
        ("fit" | "camera", _) => Way::Live(Stage::Fit),
        ("capture", "source") if all.iter().any(|s| s.capture.is_external()) => Way::Fixed,
        ("capture", _) if all.iter().all(|s| s.capture.is_external()) => Way::Chain,
        ("capture" | "simulation", _) => Way::Restart(&[Stage::Capture]),
        ("run", "restart" | "max_restarts" | "restart_window_s" | "hang_s" | "start_limit_s") => {
            Way::Chain
        }
        (
            "run",
            "realtime" | "cpus" | "scheduling" | "priority" | "lock_memory" | "wake" | "spin_us",
        ) => Way::Restart(&[Stage::Capture, Stage::Extract, Stage::Fit, Stage::Sink]),
        _ => Way::Fixed,
    }
}

/// Returns true if the source sends a truth, which must have as many points as extract's
/// centerlines.
fn knows_truth(settings: &Settings) -> bool {
    matches!(
        settings.source(),
        Source::Rendered(_) | Source::Simulated(_)
    )
}

impl Settings {
    /// Returns the stages that are concerned if these settings replace the previous ones.
    ///
    /// # Errors
    /// Returns an error that names the settings that cannot change while a chain runs.
    pub fn concerned(&self, before: &Self) -> Result<Concerned> {
        let mut concerned = Concerned::default();
        let mut fixed = Vec::new();
        for key in KEYS {
            if (key.get)(self) == (key.get)(before) {
                continue;
            }
            match way(key.section, key.name, [before, self]) {
                Way::Live(stage) => concerned.live[stage as usize] = true,
                Way::Restart(stages) => {
                    for &stage in stages {
                        concerned.again[stage as usize] = true;
                    }
                }
                Way::Chain => {}
                Way::Fixed => fixed.push(format!("{}.{}", key.section, key.name)),
            }
        }
        if !fixed.is_empty() {
            bail!(
                "{} cannot change while the chain runs: stop it, and start it with the new value",
                fixed.join(", ")
            );
        }
        for stage in 0..4 {
            concerned.live[stage] &= !concerned.again[stage];
        }
        Ok(concerned)
    }

    /// Returns the settings that differ from the previous ones: `section.name`, and the value as in
    /// the file.
    pub fn differences(&self, before: &Self) -> impl Iterator<Item = (String, String)> {
        KEYS.iter().filter_map(move |key| {
            let value = (key.get)(self);
            let value_text = value
                .as_ref()
                .map_or_else(|| "not set".to_owned(), Value::to_string);
            (value != (key.get)(before))
                .then(|| (format!("{}.{}", key.section, key.name), value_text))
        })
    }

    /// Returns these settings with changes from [`Flags::with_change`].
    ///
    /// # Errors
    /// Returns an error if a change is invalid, alone or together with the other settings.
    pub fn changed_by(&self, changes: &Flags) -> Result<Self> {
        let mut before = self.clone();
        // If the user sets a basis or a number of control points, it replaces the whole default of
        // the drawn rope.
        let has_curve_of_source = self.has_curve_of_source
            && !["basis", "control_points"]
                .iter()
                .any(|name| changes.set("fit", name));
        if self.has_curve_of_source && !has_curve_of_source {
            (before.fit.basis, before.fit.control_points) = (Family::Auto, None);
        }
        let mut problems = Problems::default();
        let entries = file::entries(Path::new(FILE_NAME), &before.text(), &mut problems);
        let resolved = Resolved::of(entries, self.file.clone(), changes, problems)?;
        Ok(Self {
            has_curve_of_source,
            ..resolved.with_a_fitter()?.settings
        })
    }

    /// Parses the settings from a [`text`](Self::text). The writer of the text has checked that a
    /// fitter exists for them.
    ///
    /// # Errors
    /// Returns all errors in the text, with a sentence for each.
    pub fn of_text(text: &str) -> Result<Self> {
        let mut problems = Problems::default();
        let entries = file::entries(Path::new(FILE_NAME), text, &mut problems);
        let mut settings = Resolved::of(entries, None, &Flags::default(), problems)?.settings;
        settings.version = version_of(text);
        Ok(settings)
    }
}

/// Returns the settings that a process has announced. The files of `[camera]` have absolute paths.
///
/// # Errors
/// Fails like [`Settings::of_text`].
pub fn settings_of(member: &Member) -> Result<Settings> {
    let mut table: toml::Table = member.settings.parse()?;
    if let Some(camera) = table.get_mut("camera").and_then(Value::as_table_mut) {
        for key in ["calibration", "plane", "depth", "second", "pose"] {
            if let Some(Value::String(path)) = camera.get_mut(key) {
                *path = member.folder.join(&*path).to_string_lossy().into_owned();
            }
        }
    }
    let version = version_line(version_of(&member.settings));
    Settings::of_text(&(version + &table.to_string()))
}

/// Returns the version of a settings text, or 0 if it contains none.
pub fn version_of(text: &str) -> u32 {
    let line = text.lines().next().unwrap_or_default();
    let version = line.strip_prefix(VERSION).map(str::parse);
    version.and_then(Result::ok).unwrap_or(0)
}

/// Parses a change written as `section.name=value`. Returns the index in [`KEYS`] and the value as
/// in the file.
///
/// # Errors
/// Returns a sentence that says what is wrong.
pub(super) fn parse(text: &str) -> Result<(usize, Value)> {
    let Some((name, typed)) = text.split_once('=') else {
        wrong_use!("{text}: write SECTION.SETTING=VALUE, such as fit.control_points=7");
    };
    let (name, typed) = (name.trim(), typed.trim());
    let known = name.split_once('.');
    let Some(key) = known.and_then(|(section, name)| keys::position(section, name)) else {
        let names: Vec<String> = KEYS
            .iter()
            .map(|key| format!("{}.{}", key.section, key.name))
            .collect();
        let same = KEYS.iter().position(|key| key.name == name);
        let like = same
            .map(|key| &names[key][..])
            .or_else(|| meaning::nearest(name, names.iter().map(String::as_str)));
        let guess = like.map_or_else(
            || "`lariat config show` lists them".to_owned(),
            |like| format!("did you mean {like}?"),
        );
        if let Some((section, name)) = known
            && let Some(value) = Takes::Whole.value(typed).ok()
            && let Some(instead) = renamed::instead(section, name, &value)
        {
            wrong_use!(
                "there is no setting {section}.{name} any more: write {section}.{}",
                instead.replace(" = ", "=")
            );
        }
        wrong_use!("there is no setting {name}: {guess}");
    };
    let takes = (KEYS[key].takes)();
    let is_toml = typed.starts_with(['[', '{', '"']) || matches!(takes, Takes::Nothing);
    let takes = if is_toml { Takes::Toml } else { takes };
    let value = takes
        .value(typed)
        .map_err(|why| WrongUse(format!("{name}={typed}: {why}")))?;
    Ok((key, value))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::{ControlPoints, Restart};

    fn changed(changes: &[&str]) -> Settings {
        let flags = changes
            .iter()
            .try_fold(Flags::default(), |flags, change| flags.with_change(change));
        Settings::resolve(&flags.unwrap()).unwrap()
    }

    fn of(stages: &[Stage]) -> [bool; 4] {
        let mut of = [false; 4];
        stages.iter().for_each(|&stage| of[stage as usize] = true);
        of
    }

    #[test]
    fn a_change_concerns_the_stages_that_go_by_it() {
        let before = changed(&["capture.source=[\"a.png\"]"]);
        let concerned = |changes: &[&str]| {
            let all = [&["capture.source=[\"a.png\"]"], changes].concat();
            changed(&all).concerned(&before)
        };
        let live = |stages| Concerned {
            live: of(stages),
            ..Concerned::default()
        };
        let again = |stages| Concerned {
            again: of(stages),
            ..Concerned::default()
        };
        let here = concerned(&["fit.control_points=7", "extract.min_confidence=0.25"]).unwrap();
        assert_eq!(here, live(&[Stage::Extract, Stage::Fit]));
        assert_eq!(concerned(&[]).unwrap(), Concerned::default());
        assert_eq!(
            concerned(&["capture.fps=60"]).unwrap(),
            again(&[Stage::Capture])
        );
        assert_eq!(
            concerned(&["extract.mask=external", "extract.ropes=2"]).unwrap(),
            again(&[Stage::Extract])
        );
        assert_eq!(
            concerned(&["run.restart=always"]).unwrap(),
            Concerned::default()
        );
        let refused = concerned(&["run.rig=other", "sink.live=false"]).unwrap_err();
        assert_eq!(
            refused.to_string(),
            "run.rig, sink.live cannot change while the chain runs: stop it, and start it with the new value"
        );
    }

    #[test]
    fn who_is_unattended_is_restarted_unless_something_else_is_said() {
        let run = |changes: &[&str]| {
            let settings = changed(changes);
            (settings.run.restart, settings.sink.live)
        };
        assert_eq!(run(&[]), (Restart::Never, true));
        assert_eq!(run(&["run.daemon=true"]), (Restart::OnFailure, false));
        let all = ["run.daemon=true", "run.restart=never", "sink.live=true"];
        assert_eq!(run(&all), (Restart::Never, true));
    }

    #[test]
    fn a_change_is_read_as_a_flag_or_the_file_has_it() {
        let settings = changed(&[
            "fit.filter=true",
            "run.cpus=[0, 0, 1, 1]",
            "extract.keep_lost_s = 2s",
            "capture.size=320x240",
        ]);
        assert!(settings.fit.filter);
        assert_eq!(settings.extract.keep_lost.as_secs(), 2);
        let refuse = |text| parse(text).unwrap_err().to_string();
        assert_eq!(
            refuse("fit.degre=3"),
            "there is no setting fit.degre: did you mean fit.degree?"
        );
        assert_eq!(
            refuse("fit.degree"),
            "fit.degree: write SECTION.SETTING=VALUE, such as fit.control_points=7"
        );
    }

    #[test]
    fn a_number_of_control_points_alone_replaces_the_curve_that_the_drawn_rope_has_by_itself() {
        let own = Resolved::of_chain(&Flags::default()).unwrap().settings;
        let curve = |settings: &Settings| (settings.fit.basis, settings.fit.control_points);
        let named = |basis, count| (Family::Named(basis), Some(ControlPoints::Named(count)));
        assert_eq!(curve(&own), named(lariat_wire::Basis::BSpline, 20));
        let change = |settings: &Settings, text| {
            let flags = Flags::default().with_change(text).unwrap();
            settings.changed_by(&flags).unwrap()
        };
        let filtered = change(&own, "fit.filter=true");
        assert_eq!(curve(&filtered), curve(&own));
        for settings in [&own, &filtered] {
            let changed = change(settings, "fit.control_points=7");
            assert_eq!(curve(&changed), named(lariat_wire::Basis::Bezier, 7));
            let changed = change(settings, "fit.basis=auto");
            assert_eq!(curve(&changed), (Family::Auto, None));
        }
    }

    #[test]
    fn a_drawn_rope_has_a_curve_of_its_own_only_if_no_other_is_asked_for() {
        let curve = |changes: &[&str]| {
            let mut flags = Flags::default();
            for change in changes {
                flags = flags.with_change(change).unwrap();
            }
            let fit = Resolved::of_chain(&flags).unwrap().settings.fit;
            (fit.basis, fit.control_points)
        };
        for changes in [
            &["fit.basis=auto"][..],
            &["extract.points=20"],
            &["capture.source=simulated"],
        ] {
            assert_eq!(curve(changes), (Family::Auto, None), "{changes:?}");
        }
        let asked = curve(&["fit.basis=points", "fit.control_points=4"]);
        assert_eq!(
            asked,
            (
                Family::Named(lariat_wire::Basis::FeaturePoints),
                Some(ControlPoints::Named(4))
            )
        );
    }

    #[test]
    fn a_versioned_text_gives_the_same_settings() {
        let mut settings = changed(&[
            "fit.control_points=7",
            "run.rig=left",
            "extract.roi=[1, 2, 30, 40]",
        ]);
        for version in [0, 7] {
            settings.version = version;
            assert_eq!(Settings::of_text(&settings.text()).unwrap(), settings);
        }
        assert!(Settings::of_text("[fit]\ncontrol_points = \"many\"\n").is_err());
    }
}
