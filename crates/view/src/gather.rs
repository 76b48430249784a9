//! Collects what the screen shows: from descriptors, from their channel, and from `/proc`.

use std::os::fd::BorrowedFd;
use std::time::Instant;

use lariat_chain::settings::settings_of;
use lariat_extract::Mask;
use lariat_sink::{Arrival, Ledger, points_along};
use lariat_wire::{
    Basis, DESCRIPTORS, DESCRIPTORS3, Descriptor, Descriptors, Descriptors3, Domain, FitQuality,
    Member, Receiver, Rig, Trace, Unit, WireError, members,
};

use super::processes::Processes;
use super::recent::Recent;
use super::view::{InSpace, Losses, Rope, Shape, StageRow, View};

/// Interval at which processes and rigs are looked up.
const ROSTER_NS: u64 = 1_000_000_000;
/// Interval at which the channel is checked for a writer.
const LINK_NS: u64 = 300_000_000;
/// Duration over which rates are measured.
const RATE_NS: u64 = 1_000_000_000;
/// Windows for latencies that can be chosen, in seconds.
const WINDOWS_S: [u64; 5] = [1, 3, 10, 30, 60];
/// Maximum time between a rope in 3-D and the image next to which it is shown.
const SAME_TIME_NS: u64 = 200_000_000;
/// Number of points that a rope is drawn with.
const DRAWN: usize = 160;

/// Watches one rig at a time, through its descriptors.
#[derive(Debug)]
pub struct Gatherer<'d> {
    domain: &'d Domain,
    /// The requested rig, or the one that is shown. If it has gone, the gatherer waits for it.
    rig: Option<Rig>,
    rigs: Vec<Rig>,
    members: Vec<Member>,
    roster_due_ns: u64,
    /// Index into [`WINDOWS_S`].
    window: usize,
    look: RigState,
}

/// State of the rig that is shown. It is reset for another rig.
#[derive(Debug, Default)]
struct RigState {
    reader: Option<Receiver<Descriptors>>,
    is_lossless: bool,
    link_due_ns: u64,
    obstacle: Option<String>,
    shared_mb: Option<f64>,
    processes: Processes,
    stages: Vec<StageRow>,
    ledger: Option<Ledger>,
    recent: Recent,
    /// The trace of about a second ago, where the measurement of rates started.
    rate_from: Option<Trace>,
    rate: Option<[f64; 3]>,
    newest: Option<Box<Descriptors>>,
    /// Reader of ropes in 3-D, if the chain sends them.
    space: Option<Receiver<Descriptors3>>,
    newest_in_space: Option<Box<Descriptors3>>,
    reach: Option<[f64; 4]>,
}

impl<'d> Gatherer<'d> {
    /// Creates a gatherer that starts with `rig`, or by default with the rig `default` or the first
    /// one found.
    pub fn new(domain: &'d Domain, rig: Option<Rig>) -> Self {
        Self {
            domain,
            rig,
            rigs: Vec::new(),
            members: Vec::new(),
            roster_due_ns: 0,
            window: 1,
            look: RigState::default(),
        }
    }

    /// Switches to the next rig.
    pub fn next_rig(&mut self) {
        let here = self
            .rigs
            .iter()
            .position(|rig| Some(rig) == self.rig.as_ref());
        let next = here.map_or(0, |here| (here + 1) % self.rigs.len());
        if let Some(rig) = self.rigs.get(next)
            && Some(rig) != self.rig.as_ref()
        {
            self.rig = Some(rig.clone());
            self.look = RigState::default();
            // Its processes are to be listed in the first view.
            self.roster_due_ns = 0;
        }
    }

    /// Widens the window for latencies.
    pub fn longer(&mut self) {
        self.window = (self.window + 1).min(WINDOWS_S.len() - 1);
    }

    /// Narrows the window for latencies.
    pub fn shorter(&mut self) {
        self.window = self.window.saturating_sub(1);
    }

    /// Returns whether the rig waits for its readers, so that messages must be taken as they come.
    pub fn must_keep_up(&self) -> bool {
        self.look.is_lossless && self.look.reader.is_some()
    }

    /// Returns the newest descriptors, if the rig has sent any while watched.
    pub fn newest(&self) -> Option<&Descriptors> {
        self.look.newest.as_deref()
    }

    /// Returns the rig, while it is read.
    pub(crate) fn linked(&self) -> Option<&Rig> {
        self.rig.as_ref().filter(|_| self.look.reader.is_some())
    }

    /// Returns what one of the rig's stages reported about itself when it was last checked.
    pub(crate) fn stage(&self, name: &str) -> Option<&Member> {
        stage_of(&self.members, self.rig.as_ref()?.as_str(), name)
    }

    /// Returns the frames lost since the gatherer began to watch the rig.
    pub(crate) fn losses(&self, now_ns: u64) -> lariat_record::Losses {
        let lost = self.look.ledger.as_ref().map(Ledger::lost);
        let lost = lost.unwrap_or_default();
        lariat_record::Losses {
            at_ns: now_ns,
            source: lost.source,
            capture: lost.capture,
            extract: lost.extract,
            bridge: lost.bridge,
            ..Default::default()
        }
    }

    /// Returns the time from exposure to fit of each frame since `since_ns`, in µs.
    pub(crate) fn fitted_us(&self, since_ns: u64) -> Vec<f64> {
        self.look.recent.fitted_us(since_ns)
    }

    /// Takes messages until `until`, or until `also` is readable.
    pub fn keep_up(&mut self, until: Instant, also: Option<BorrowedFd>) {
        if let Some(reader) = &self.look.reader
            && let Err(error) = reader.sleep(Some(until), also)
        {
            self.look.obstacle = Some(error.to_string());
            self.look.reader = None;
        }
        self.look.drain();
    }

    /// Does every check that is due, and takes all messages.
    pub fn look(&mut self, now_ns: u64) {
        if now_ns >= self.roster_due_ns {
            self.roster_due_ns = now_ns + ROSTER_NS;
            self.look_at_roster(now_ns);
        }
        let Some(rig) = &self.rig else {
            return;
        };
        if now_ns >= self.look.link_due_ns {
            self.look.link_due_ns = now_ns + LINK_NS;
            self.look.link(self.domain, rig);
        }
        self.look.drain();
        let longest_ns = WINDOWS_S[WINDOWS_S.len() - 1] * 1_000_000_000;
        let recent = &mut self.look.recent;
        recent.forget_before(now_ns.saturating_sub(longest_ns));
    }

    fn look_at_roster(&mut self, now_ns: u64) {
        self.members = members().unwrap_or_default();
        let names = self.members.iter().map(|one| one.rig.as_str());
        self.rigs = names.filter_map(|name| name.parse().ok()).collect();
        self.rigs.dedup();
        if self.rig.is_none() {
            let usual = Rig::default();
            let is_there = self.rigs.contains(&usual);
            self.rig = if is_there {
                Some(usual)
            } else {
                self.rigs.first().cloned()
            };
        }
        let Some(rig) = &self.rig else {
            return;
        };
        let look = &mut self.look;
        look.stages = look.processes.look(&self.members, rig.as_str(), now_ns);
        let channels = self.domain.channels().unwrap_or_default();
        let of_rig = channels.iter().filter(|state| state.rig == *rig);
        let writers = of_rig.filter_map(|state| state.ends.as_ref()?.writer.as_ref());
        let bytes: u64 = writers.map(|writer| writer.shared_bytes).sum();
        look.shared_mb = (bytes > 0).then_some(bytes as f64 / 1e6);
    }

    /// Returns what is to be shown now.
    pub fn view(&self, now_ns: u64) -> View {
        let look = &self.look;
        let here = self
            .rigs
            .iter()
            .position(|rig| Some(rig) == self.rig.as_ref());
        let window_s = WINDOWS_S[self.window];
        let mut stages = look.stages.clone();
        if let Some(rates) = look.rate {
            for (name, rate) in ["capture", "extract", "fit"].into_iter().zip(rates) {
                let of_stage = stages.iter_mut().filter(|row| row.stage == name);
                of_stage.for_each(|row| row.frames_per_s = Some(rate));
            }
        }
        let lost = look.ledger.as_ref().map(Ledger::lost).unwrap_or_default();
        View {
            rig: self.rig.as_ref().map(Rig::to_string),
            place: (here.map_or(0, |here| here + 1), self.rigs.len()),
            is_paused: false,
            obstacle: self.obstacle(),
            is_lossless: look.is_lossless,
            shared_mb: look.shared_mb,
            clock_bound_us: self
                .rig
                .as_ref()
                .and_then(|rig| clock_bound_us(&self.members, rig)),
            stages,
            window_s,
            steps: look
                .recent
                .since(now_ns.saturating_sub(window_s * 1_000_000_000)),
            lost: Losses {
                source: lost.source,
                capture: lost.capture,
                extract: lost.extract,
                bridge: lost.bridge,
            },
            shape: look.shape(now_ns),
        }
    }

    /// Returns the reason if there is nothing to show.
    fn obstacle(&self) -> Option<String> {
        if let Some(obstacle) = &self.look.obstacle {
            return Some(obstacle.clone());
        }
        let has_reader = self.look.reader.is_some();
        match &self.rig {
            _ if has_reader && self.look.newest.is_some() => None,
            Some(rig) if has_reader => Some(self.awaited(rig)),
            Some(rig) if self.rigs.contains(rig) => Some(format!(
                "Rig {rig} is starting or ending: nothing writes descriptors."
            )),
            Some(rig) => Some(format!(
                "Nothing runs on rig {rig}: start it with `lariat run{}`; this screen waits for it.",
                match rig.as_str() {
                    "default" => String::new(),
                    name => format!(" --rig {name}"),
                }
            )),
            None => Some(
                "No chain is running here: start one with `lariat run`; this screen waits for it."
                    .into(),
            ),
        }
    }
}

impl Gatherer<'_> {
    /// Describes what a chain that has sent nothing yet waits for.
    fn awaited(&self, rig: &Rig) -> String {
        let settings = stage_of(&self.members, rig.as_str(), "extract")
            .and_then(|extract| settings_of(extract).ok());
        match settings {
            Some(settings) if settings.extract.mask == Mask::External => format!(
                "The chain is up, and no frame has had a mask in time: start the program that writes lariat/{rig}/masks."
            ),
            _ => "The chain is up, and waits for its first frame.".into(),
        }
    }
}

impl RigState {
    /// Becomes a reader when there is a writer, and stops with it. A reader that stayed would block
    /// a chain that is restarted with another delivery.
    fn link(&mut self, domain: &Domain, rig: &Rig) {
        let state = domain.channel(rig, DESCRIPTORS.name());
        let is_written = state.as_ref().is_some_and(|state| {
            // If the channel has another version, opening it reports that.
            state.ends.as_ref().is_none_or(|ends| ends.writer.is_some())
        });
        if !is_written {
            let stages = std::mem::take(&mut self.stages);
            let processes = std::mem::take(&mut self.processes);
            *self = Self {
                stages,
                processes,
                link_due_ns: self.link_due_ns,
                ..Self::default()
            };
            return;
        }
        if self.reader.is_some() {
            return;
        }
        self.is_lossless = state.is_some_and(|state| state.lossless);
        match open(domain, rig, self.is_lossless) {
            Ok(reader) => {
                self.reader = Some(reader);
                self.obstacle = None;
                self.space = self.in_space(domain, rig);
            }
            Err(error) => self.obstacle = Some(error.to_string()),
        }
    }

    /// Opens a reader of ropes in 3-D, if there are any. A lossless chain gets none, because it
    /// waits for each of its readers to wake.
    fn in_space(&self, domain: &Domain, rig: &Rig) -> Option<Receiver<Descriptors3>> {
        let ends = domain.channel(rig, DESCRIPTORS3.name())?.ends?;
        (ends.writer.is_some() && !self.is_lossless)
            .then(|| Receiver::create_unwoken(domain, rig, &DESCRIPTORS3, None).ok())
            .flatten()
    }

    fn drain(&mut self) {
        // Each is sent before the descriptors of the same frame.
        if let Some(Ok(Some(message))) = self.space.as_ref().map(Receiver::latest) {
            let empty = || Box::new(Descriptors3::EMPTY);
            let newest = self.newest_in_space.get_or_insert_with(empty);
            newest.copy_meant(&message);
        }
        while let Some(reader) = &self.reader {
            match reader.next() {
                Ok(Some(message)) => self.take(&message),
                Ok(None) => return,
                Err(error) => {
                    self.obstacle = Some(error.to_string());
                    self.reader = None;
                }
            }
        }
    }

    fn take(&mut self, message: &Descriptors) {
        let trace = &message.trace;
        let ledger = self.ledger.get_or_insert_with(|| Ledger::new(false));
        if ledger.received(trace, lariat_wire::now_ns()) == Arrival::Stale {
            return;
        }
        // Without an image, nothing was exposed.
        if message.width > 0 {
            self.recent.add(trace);
        }
        self.rates(trace);
        let empty = || Box::new(Descriptors::EMPTY);
        self.newest.get_or_insert_with(empty).copy_meant(message);
        self.reach = message
            .curves()
            .iter()
            .flat_map(|rope| rope.control_points())
            .filter(|point| point.iter().all(|x| x.is_finite()))
            .fold(self.reach, |reach, &[x, y]| {
                let [x0, y0, x1, y1] = reach.unwrap_or([x, y, x, y]);
                Some([x0.min(x), y0.min(y), x1.max(x), y1.max(y)])
            });
    }

    /// Measures the frames per second of capture, extract and fit: the increase of each counter,
    /// divided by the time between two of fit's timestamps.
    fn rates(&mut self, trace: &Trace) {
        let Some(from) = &self.rate_from else {
            self.rate_from = Some(*trace);
            return;
        };
        let counts = |trace: &Trace| [trace.captured, trace.extracted, trace.fitted];
        let (before, now) = (counts(from), counts(trace));
        let is_restart = before.iter().zip(now).any(|(before, now)| now < *before);
        let elapsed_ns = trace.fitted_ns.saturating_sub(from.fitted_ns);
        if is_restart || elapsed_ns >= RATE_NS {
            let per_s = |i: usize| (now[i] - before[i]) as f64 * 1e9 / elapsed_ns as f64;
            self.rate = (!is_restart).then(|| std::array::from_fn(per_s));
            self.rate_from = Some(*trace);
        }
    }

    /// Returns where a rope of a frame is in 3-D, from the newest message. For display, a position
    /// from a frame or two away is just as good.
    fn place_of(&self, track: u32, trace: &Trace) -> Option<InSpace> {
        let newest = self.newest_in_space.as_deref()?;
        let apart_ns = newest.trace.exposed_ns.abs_diff(trace.exposed_ns);
        let found = newest.curves().iter().find(|curve| curve.track == track)?;
        (apart_ns <= SAME_TIME_NS).then(|| InSpace {
            place: found.place(),
            length_mm: found.length,
        })
    }

    fn shape(&self, now_ns: u64) -> Option<Shape> {
        let newest = self.newest.as_deref()?;
        let unit = newest.unit();
        let age_ns = now_ns.saturating_sub(newest.trace.exposed_ns);
        Some(Shape {
            frame: newest.trace.sequence,
            width: newest.width,
            height: newest.height,
            unit: unit.map_or("?", Unit::name),
            is_of_image: unit == Some(Unit::Pixel),
            age_s: age_ns as f64 / 1e9,
            ropes: (newest.curves().iter())
                .map(|descriptor| Rope {
                    in_space: self.place_of(descriptor.track, &newest.trace),
                    ..rope(descriptor)
                })
                .collect(),
            reach: self.reach.unwrap_or_default(),
        })
    }
}

/// Finds a stage of a rig.
pub(crate) fn stage_of<'a>(members: &'a [Member], rig: &str, name: &str) -> Option<&'a Member> {
    let mut of_rig = members.iter().filter(|member| member.rig == rig);
    of_rig.find(|member| member.stage == name)
}

/// Returns the maximum error of a rig's timestamps in µs, if a bridge brings the rig from a machine
/// with its own clock. The bridge reports it in the roster. `None` for a rig of this machine.
pub fn clock_bound_us(members: &[Member], rig: &Rig) -> Option<f64> {
    bound_in(&stage_of(members, rig.as_str(), "bridge")?.settings)
}

fn bound_in(settings: &str) -> Option<f64> {
    let settings: toml::Table = settings.parse().ok()?;
    let us = settings.get("bridge")?.get("clock_bound_us")?.as_float();
    us.filter(|us| us.is_finite())
}

/// Opens a reader. Messages wake it only if the chain would wait for it.
fn open(domain: &Domain, rig: &Rig, woken: bool) -> Result<Receiver<Descriptors>, WireError> {
    if woken {
        Receiver::create(domain, rig, &DESCRIPTORS, None)
    } else {
        Receiver::create_unwoken(domain, rig, &DESCRIPTORS, None)
    }
}

fn rope(descriptor: &Descriptor) -> Rope {
    let mut points = vec![[0.0; 2]; DRAWN];
    let is_curve = points_along(descriptor, &mut points);
    if !is_curve || points.iter().flatten().any(|x| !x.is_finite()) {
        points.clear();
    }
    Rope {
        track: descriptor.track,
        status: descriptor.status(),
        is_closed: descriptor.closed != 0,
        basis: descriptor.basis().map_or("?", Basis::name),
        control_point_count: descriptor.count,
        length: descriptor.length,
        rms: descriptor.rms,
        confidence: descriptor.confidence,
        is_coarse: descriptor.fit() == Some(FitQuality::Coarse),
        age_s: descriptor.age_ns as f64 / 1e9,
        // A Fourier series has coefficients, not points.
        control_points: match descriptor.basis() {
            Some(Basis::Fourier) | None => Vec::new(),
            Some(_) => descriptor.control_points().to_vec(),
        },
        points,
        in_space: None,
    }
}

#[cfg(test)]
mod tests {
    use super::bound_in;

    #[test]
    fn the_bound_is_what_the_bridge_says_and_nothing_else() {
        let said = "[bridge]\nconnect = \"udp/camera:7447\"\nclock_bound_us = 40.0\nsent = 3\n";
        assert_eq!(bound_in(said), Some(40.0));
        for other in [
            "",
            "clock_bound_us = 40.0",
            "[bridge]\nclock_bound_us = inf",
            "[",
        ] {
            assert_eq!(bound_in(other), None, "{other}");
        }
    }
}
