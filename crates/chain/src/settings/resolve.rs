//! Resolves the settings from defaults, file and flags, and checks that they are consistent.

use crate::settings::keys::{self, KEYS};
use crate::settings::problem::Origin;
use crate::settings::{
    self, ControlPoints, FILE_NAME, Family, Flags, Problems, Restart, Settings, curve, file, range,
};
use anyhow::Result;
use file::Entry;
use lariat_fit::Fitter;
use std::path::PathBuf;

/// Number of control points of the drawn rope's cubic B-spline. With 20, the curve stays on the
/// rope in every frame of 90 s for each of the seeds 1 to 7. With 16, up to 64 consecutive frames
/// miss the rope, which causes a warning. Command:
/// `lariat run --lossless --fps max --frames 2700 --basis bspline --control-points 20 --seed SEED
/// --record FILE --images none`, then `lariat export --format csv`, column `fit`.
const DRAWN_CONTROL_POINTS: usize = 20;

/// Settings and the origin of each.
pub struct Resolved {
    /// All settings.
    pub settings: Settings,
    /// Origins in the order of [`KEYS`].
    origins: Vec<Origin>,
}

impl Resolved {
    /// Resolves flags, file and defaults.
    ///
    /// # Errors
    /// Returns all errors in them.
    pub fn new(flags: &Flags) -> Result<Self> {
        Self::read(flags)?.with_a_fitter()
    }

    /// Resolves the settings of a whole chain, like [`new`](Self::new), with the curve that suits
    /// the source.
    ///
    /// # Errors
    /// Fails like [`new`](Self::new).
    pub fn of_chain(flags: &Flags) -> Result<Self> {
        Ok(Self::new(flags)?.with_curve_of_source())
    }

    /// Gives the drawn rope, which is the same on every machine, a curve of a fixed size that fits
    /// all its motions. Its descriptor then has the same length in every frame. A curve that the
    /// user chooses is kept.
    ///
    /// Only a chain may call this. The settings of `lariat trace` and other commands also name the
    /// drawn rope by default, but do not use it.
    pub(super) fn with_curve_of_source(mut self) -> Self {
        let keys = ["basis", "control_points"].map(|name| keys::position("fit", name));
        let Settings {
            capture,
            extract,
            fit,
            ..
        } = &mut self.settings;
        let is_flag = |key: usize| matches!(self.origins[key], Origin::Flag(_));
        // A new file contains the basis "auto", which is not the user's choice.
        let is_asked_for = keys.into_iter().flatten().any(is_flag)
            || fit.basis != Family::Auto
            || fit.control_points.is_some()
            || fit.degree != settings::Fit::default().degree;
        if capture.is_rendered() && !is_asked_for && extract.points > DRAWN_CONTROL_POINTS {
            fit.basis = Family::Named(lariat_wire::Basis::BSpline);
            fit.control_points = Some(ControlPoints::Named(DRAWN_CONTROL_POINTS));
            self.settings.has_curve_of_source = true;
        }
        self
    }

    /// Resolves settings like [`new`](Self::new), but does not check that a fitter exists. Whoever
    /// creates the fitter gets the error.
    pub(super) fn read(flags: &Flags) -> Result<Self> {
        let mut problems = Problems::default();
        let path = file::path(flags.config.as_deref());
        let entries = match &path {
            Some(path) => file::read(path, &mut problems)?,
            None => Vec::new(),
        };
        Self::of(entries, path, flags, problems)
    }

    /// Resolves the entries of a file and flags, like [`read`](Self::read).
    pub(super) fn of(
        entries: Vec<Entry>,
        file: Option<PathBuf>,
        flags: &Flags,
        mut problems: Problems,
    ) -> Result<Self> {
        let mut resolved = Self {
            settings: Settings {
                file,
                ..Settings::default()
            },
            origins: vec![Origin::Default; KEYS.len()],
        };
        for entry in entries {
            resolved.set(entry.key, entry.value, entry.origin, &mut problems);
        }
        for (flag, key, value) in flags.given() {
            resolved.set(key, value.clone(), Origin::Flag(flag), &mut problems);
        }
        if flags.config.is_none() {
            resolved.keep_existing_files();
        }
        resolved.settle_daemon();
        resolved.settle_fit(&mut problems);
        // Check the combination of settings only if each of them is valid.
        if problems.is_empty() {
            resolved.check_arrangement(&mut problems);
            resolved.check_restart(&mut problems);
            resolved.check_depth_source(&mut problems);
            resolved.check_second_rig(&mut problems);
            resolved.check_camera(&mut problems);
            resolved.check_source(&mut problems);
        }
        problems.into_result()?;
        Ok(resolved)
    }

    fn set(&mut self, key: usize, value: toml::Value, origin: Origin, problems: &mut Problems) {
        match (KEYS[key].set)(&mut self.settings, &value) {
            Ok(()) => self.origins[key] = origin,
            Err(why) => problems.add(&origin, format!("{}: {why}", origin.quote(key, &value))),
        }
    }

    /// Ignores `record.replace` in a file that was found in the current folder. The file may have
    /// come with somebody else's data and must not cause the user's files to be overwritten.
    fn keep_existing_files(&mut self) {
        let Some(key) = keys::position("record", "replace") else {
            return;
        };
        if self.settings.record.replace && matches!(self.origins[key], Origin::File { .. }) {
            self.settings.record.replace = false;
            self.origins[key] = Origin::Default;
            tracing::warn!(
                "record.replace of the {FILE_NAME} in this folder is ignored: give --force, or name the file (--config \
                 {FILE_NAME})"
            );
        }
    }

    /// Applies the defaults of an unattended chain, unless the user chose otherwise.
    fn settle_daemon(&mut self) {
        if !self.settings.run.daemon {
            return;
        }
        let is_said = |section, name| {
            let key = keys::position(section, name);
            key.is_some_and(|key| self.origins[key] != Origin::Default)
        };
        let (restart, live) = (is_said("run", "restart"), is_said("sink", "live"));
        if !restart {
            self.settings.run.restart = Restart::OnFailure;
        }
        if !live {
            self.settings.sink.live = false;
        }
    }

    /// Resolves a conflict between basis and control points in favor of the one set last. A flag
    /// counts as later than the file.
    fn settle_fit(&mut self, problems: &mut Problems) {
        let keys = ["basis", "control_points"].map(|name| keys::position("fit", name));
        let [Some(basis_key), Some(count_key)] = keys else {
            return;
        };
        let [basis, count] = [basis_key, count_key].map(|key| self.origins[key].clone());
        let rank = |origin: &Origin| match origin {
            Origin::Default => 0,
            Origin::File { .. } => 1,
            Origin::Flag(_) => 2,
        };
        let fit = &mut self.settings.fit;
        match (fit.basis, fit.control_points) {
            (Family::Auto, Some(_)) if rank(&basis) < rank(&count) => {
                fit.basis = Family::Named(lariat_wire::Basis::Bezier);
                self.origins[basis_key] = count;
            }
            (Family::Auto, Some(_)) if rank(&basis) > rank(&count) => fit.control_points = None,
            (Family::Auto, Some(_)) => problems.add(
                &count,
                "the basis \"auto\" chooses the control points itself: leave their number out, or name another basis".to_owned(),
            ),
            (Family::Auto, None) | (_, Some(_)) => {}
            (_, None) => fit.control_points = Some(ControlPoints::Named(curve::DEFAULT_CONTROL_POINTS)),
        }
        self.check_degree(problems);
    }

    /// Refuses a degree on the command line without a B-spline, because the user may mean the
    /// degree of a Bezier curve.
    fn check_degree(&self, problems: &mut Problems) {
        let Some(key) = keys::position("fit", "degree") else {
            return;
        };
        let origin = &self.origins[key];
        let is_spline = self.settings.fit.basis == Family::Named(lariat_wire::Basis::BSpline);
        if !is_spline && matches!(origin, Origin::Flag(_)) {
            let count = self.settings.fit.degree + 1;
            problems.add(
                origin,
                format!(
                    "only a B-spline's degree is set: add --basis bspline, or write --control-points {count} for a Bezier \
                     curve of degree {}",
                    self.settings.fit.degree
                ),
            );
        }
    }

    /// Checks that fitters for open and closed curves exist for these settings and this number of
    /// points. This takes as long as creating them, which is milliseconds.
    pub(super) fn with_a_fitter(self) -> Result<Self> {
        let fit = &self.settings.fit;
        let error = [false, true].into_iter().find_map(|closed| {
            let options = fit.options(self.settings.extract.points, closed);
            Fitter::new(options).err().map(|error| error.to_string())
        });
        let Some(error) = error.or(fit.unfilterable().map(str::to_owned)) else {
            return Ok(self);
        };
        // Attribute the error to the last of the settings that together cause it.
        let said = keys::of_section("fit")
            .chain(keys::position("extract", "points"))
            .map(|key| &self.origins[key])
            .max()
            .unwrap_or(&Origin::Default);
        let mut problems = Problems::default();
        problems.add(said, error);
        problems.into_result()?;
        Ok(self)
    }

    /// Checks that the calibration is valid.
    fn check_camera(&self, problems: &mut Problems) {
        if let Some(why) = (self.settings.camera).problem(self.settings.capture.likely_size()) {
            let said = keys::of_section("camera")
                .map(|key| &self.origins[key])
                .max();
            problems.add(said.unwrap_or(&Origin::Default), why);
        }
    }

    /// Checks that the settings apply to the source. Settings in the file for another source are
    /// allowed if a flag changes the source.
    fn check_source(&self, problems: &mut Problems) {
        let origin = |name: &str| {
            keys::position("capture", name).map_or(&Origin::Default, |key| &self.origins[key])
        };
        // A new file names the rendered rope, which is not the user's choice.
        let source_is_in_file = matches!(origin("source"), Origin::File { .. })
            && !self.is_default("capture", "source");
        let capture = &self.settings.capture;
        for (name, why) in range::meaningless(capture) {
            let is_meant = match origin(name) {
                Origin::Default => false,
                Origin::File { .. } => source_is_in_file && !self.is_default("capture", name),
                Origin::Flag(_) => true,
            };
            if is_meant {
                problems.add(origin(name), why);
            }
        }
        if problems.is_empty()
            && let Some((name, why)) = range::contradiction(capture)
        {
            problems.add(origin(name).max(origin("follow")), why);
        }
    }

    /// Returns true if a setting has its default value.
    fn is_default(&self, section: &str, name: &str) -> bool {
        keys::position(section, name).is_none_or(|key| {
            let get = KEYS[key].get;
            get(&self.settings) == get(&Settings::default())
        })
    }

    /// Checks that a depth camera has a calibration.
    fn check_depth_source(&self, problems: &mut Problems) {
        let Settings {
            capture, camera, ..
        } = &self.settings;
        if capture.is_camera()
            && capture.depth_source.is_some()
            && camera.depth.is_none()
            && let Some(key) = keys::position("capture", "depth_source")
        {
            let why = "of a depth camera it must be known what it is: name its calibration (--depth FILE)";
            problems.add(&self.origins[key], why.to_owned());
        }
    }

    /// Checks that a second camera has a rig.
    fn check_second_rig(&self, problems: &mut Problems) {
        let Settings { camera, run, .. } = &self.settings;
        let (name, why) = match (&camera.second, &camera.second_rig) {
            (Some(_), None) => (
                "second",
                "a second camera has a rig of its own: say which (--second-rig NAME)",
            ),
            (Some(_), Some(rig)) if *rig == run.rig => (
                "second_rig",
                "it is this rig itself: run the second camera on another one (lariat run --rig right)",
            ),
            (None, Some(_)) => (
                "second_rig",
                "of a second camera it must be known where it stands: name its calibration (--second FILE)",
            ),
            _ => return,
        };
        if let Some(key) = keys::position("camera", name) {
            problems.add(&self.origins[key], why.to_owned());
        }
    }

    /// Refuses restarts of stages that are threads of one process.
    fn check_restart(&self, problems: &mut Problems) {
        let run = &self.settings.run;
        if let Some(key) = keys::position("run", "restart")
            && run.fuse
            && run.restart != Restart::Never
            && self.origins[key] != Origin::Default
        {
            let why = "stages that share one process cannot be restarted: leave out --fuse, or restart the whole chain (lariat service)";
            problems.add(&self.origins[key], why.to_owned());
        }
    }

    /// Checks that the arrangement of the stages is possible.
    fn check_arrangement(&self, problems: &mut Problems) {
        if let Some(why) = self.settings.run.arrangement.contradiction() {
            let said = ["cpus", "wake"].into_iter();
            let said = said.filter_map(|name| keys::position("run", name));
            let said = said.map(|key| &self.origins[key]).max();
            problems.add(said.unwrap_or(&Origin::Default), why);
        }
    }

    /// Returns all settings as the text of a `lariat.toml`, each with its origin.
    pub fn show(&self) -> String {
        keys::document(|index, key| {
            let origin = &self.origins[index];
            match (key.get)(&self.settings) {
                Some(value) => format!("{} = {value}  # {origin}\n", key.name),
                None => format!("# {} is not set\n", key.name),
            }
        })
    }
}
