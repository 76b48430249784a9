//! The camera's side: what the rig says goes out, questions are answered, and commands come in.
//!
//! Questions are answered in zenoh's own thread, at once: each µs that an answer waits there is a µs of doubt about the clock. Nothing is sent while
//! nobody asks.

mod pictures;
mod robot;

use std::iter;
use std::os::fd::AsFd;
use std::sync::atomic::{AtomicU8, AtomicU16, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use lariat_chain::stop::Stop;
use lariat_wire::fields::Message;
use lariat_wire::{
    CENTERLINES, Centerlines, DESCRIPTORS, DESCRIPTORS3, Descriptors, Descriptors3, Domain, TRUTH,
    now_ns,
};
use zenoh::qos::Priority;
use zenoh::sample::Sample;

use crate::args::{Also, Args, Place};
use crate::channel::{Read, Woken};
use crate::datagram::{Incoming, Kind, Outgoing, Refused};
use crate::inbox::{Arrived, Inbox};
use crate::key::{self, Side};
use crate::pack::pack;
use crate::question::{Answer, Question, bit};
use crate::refusals::Refusals;
use crate::say;
use crate::session::{Open, Way, Wire, parts};
use robot::Robot;

/// How often it is looked whether the rig is written.
const CHECK: Duration = Duration::from_millis(250);
/// Who has asked nothing for so long has gone.
const ASKS_NS: u64 = 2_000_000_000;

/// What zenoh's thread and this one share.
struct Heard {
    outgoing: Outgoing,
    incoming: Mutex<(Incoming, Vec<u8>)>,
    commands: Inbox,
    /// Rung by the first question.
    first: Inbox,
    /// When a question came last, 0 before the first, and what was asked for beside descriptors.
    asked_ns: AtomicU64,
    also: AtomicU8,
    /// How long it is from one frame to the next that is asked for, ms; 0 for none.
    frames_ms: AtomicU16,
    questions: AtomicU64,
    refusals: Mutex<Refusals>,
}

impl Heard {
    /// Whether somebody listens.
    fn is_asked(&self, now_ns: u64) -> bool {
        let asked_ns = self.asked_ns.load(Ordering::Relaxed);
        asked_ns > 0 && now_ns.saturating_sub(asked_ns) < ASKS_NS
    }

    /// How long it is from one frame to the next that is asked for; `None` if none is.
    fn frames_ns(&self, now_ns: u64) -> Option<u64> {
        let period_ms = self.frames_ms.load(Ordering::Relaxed);
        (period_ms > 0 && self.is_asked(now_ns)).then_some(u64::from(period_ms) * 1_000_000)
    }

    /// Takes what came, in zenoh's thread.
    fn hear(&self, at_ns: u64, sample: &Sample, wire: &Wire) {
        let mut incoming = self.incoming.lock().unwrap_or_else(PoisonError::into_inner);
        let (incoming, bytes) = &mut *incoming;
        bytes.clear();
        parts(sample).for_each(|part| bytes.extend_from_slice(part));
        let datagram = match incoming.read(bytes) {
            Ok(datagram) => datagram,
            Err(cause) => return self.refuse(cause),
        };
        match datagram.kind {
            Kind::Ask => {
                let Some(question) = Question::read(datagram.says) else {
                    return self.refuse(Refused::Release);
                };
                let is_first = !self.is_asked(at_ns);
                self.asked_ns.store(at_ns, Ordering::Relaxed);
                if is_first {
                    self.first.put(at_ns, iter::empty());
                }
                self.also.fetch_or(question.also, Ordering::Relaxed);
                if question.frames_ms > 0 {
                    self.frames_ms.store(question.frames_ms, Ordering::Relaxed);
                }
                self.questions.fetch_add(1, Ordering::Relaxed);
                let sent = Kind::COUNTED.map(|kind| self.outgoing.sent(kind));
                let mut answer = Vec::with_capacity(128);
                self.outgoing.write(Kind::Answer, &mut answer, |to| {
                    Answer {
                        token: question.token,
                        got_ns: at_ns,
                        answered_ns: now_ns(),
                        sent,
                    }
                    .write(to);
                });
                wire.put(&answer, Priority::RealTime);
            }
            Kind::Command => {
                let head = [datagram.process.to_le_bytes(), datagram.count.to_le_bytes()];
                let parts = head.iter().map(|number| &number[..]).chain([datagram.says]);
                self.commands.put(at_ns, parts);
            }
            _ => self.refuse(Refused::Foreign),
        }
    }

    fn refuse(&self, cause: Refused) {
        self.refusals().add(cause);
    }

    fn refusals(&self) -> MutexGuard<'_, Refusals> {
        self.refusals.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Sends what the rig says for as long as no signal comes.
///
/// # Errors
/// The domain cannot be joined, or it cannot be listened there.
pub(crate) fn run(args: &Args, place: &Place) -> Result<()> {
    let stop = Stop::on_signals()?;
    let domain = Domain::open()?;
    let (key, rig) = (args.key()?, &args.rig);
    let heard = Arc::new(Heard {
        outgoing: Outgoing::new(key::random_number()?, key.as_ref(), Side::Near, rig),
        incoming: Mutex::new((Incoming::new(key, Side::Far, rig), Vec::new())),
        commands: Inbox::new().context("the system has no descriptor left")?,
        first: Inbox::new().context("the system has no descriptor left")?,
        asked_ns: AtomicU64::new(0),
        also: AtomicU8::new(0),
        frames_ms: AtomicU16::new(0),
        questions: AtomicU64::new(0),
        refusals: Mutex::default(),
    });
    let wire = Wire::open(Open::Listen, &place.to_string(), Way::Down, rig)
        .with_context(|| format!("it cannot be listened on {place}"))?;
    let (hears, answers) = (heard.clone(), wire.clone());
    wire.hear(Way::Up, rig, move |at_ns, sample| {
        hears.hear(at_ns, sample, &answers)
    })?;
    say(&format!("rig {rig} is at {place}"));
    // A thread of its own: a command is not to wait for a descriptor, nor the other way round.
    let (robot_stop, mut stopper) = Stop::by_another()?;
    let robot = {
        let (heard, rig, most) = (heard.clone(), rig.clone(), args.command_age);
        let robot = move || {
            Robot::new(&rig, heard.outgoing.process(), most).obey(&heard.commands, &robot_stop)
        };
        thread::Builder::new()
            .name("robot".into())
            .spawn(robot)
            .context("no thread could be started")?
    };
    let (pictures_stop, mut pictures_stopper) = Stop::by_another()?;
    let pictures = {
        let (heard, rig, place) = (heard.clone(), rig.clone(), place.clone());
        thread::Builder::new()
            .name("pictures".into())
            .spawn(move || pictures::run(&rig, &place, &heard, &pictures_stop))
            .context("no thread could be started")?
    };
    let mut sender = Sender::new(&heard, &wire);
    while !stop.asked() {
        sender.look(&domain, args);
        sender.sleep(&stop);
        sender.send();
    }
    stopper.stop();
    pictures_stopper.stop();
    let (commands, pictures) = (robot.join(), pictures.join());
    let missed = sender.missed;
    wire.close();
    println!(
        "rig {rig}: sent {} descriptors (and missed {}), {} in space, {} centerlines, {} truths, {} frames; answered {} questions; refused {}",
        heard.outgoing.sent(Kind::Descriptors),
        missed,
        heard.outgoing.sent(Kind::Descriptors3),
        heard.outgoing.sent(Kind::Centerlines),
        heard.outgoing.sent(Kind::Truth),
        pictures.unwrap_or_default(),
        heard.questions.load(Ordering::Relaxed),
        heard.refusals().count(),
    );
    if let Ok(commands) = commands {
        println!("{commands}");
    }
    Ok(())
}

/// The rig's channels, and the way that their messages go.
struct Sender<'h> {
    heard: &'h Heard,
    wire: &'h Wire,
    descriptors: Read<Descriptors>,
    descriptors3: Read<Descriptors3>,
    centerlines: Read<Centerlines>,
    truth: Read<Centerlines>,
    checked: Option<Instant>,
    is_asked: bool,
    /// Fit's count of the last descriptors, and how many had no room to wait until they were read.
    fitted: Option<u64>,
    missed: u64,
    datagram: Vec<u8>,
}

impl<'h> Sender<'h> {
    fn new(heard: &'h Heard, wire: &'h Wire) -> Self {
        Self {
            heard,
            wire,
            descriptors: Read::new(&DESCRIPTORS, Woken::Yes),
            descriptors3: Read::new(&DESCRIPTORS3, Woken::No),
            centerlines: Read::new(&CENTERLINES, Woken::No),
            truth: Read::new(&TRUTH, Woken::No),
            checked: None,
            is_asked: false,
            fitted: None,
            missed: 0,
            datagram: Vec::new(),
        }
    }

    /// Takes up the channels that are asked for, where that is due.
    fn look(&mut self, domain: &Domain, args: &Args) {
        if self.checked.is_some_and(|at| at.elapsed() < CHECK) {
            return;
        }
        self.checked = Some(Instant::now());
        let is_asked = self.heard.is_asked(now_ns());
        if is_asked != self.is_asked {
            say(if is_asked {
                "somebody listens"
            } else {
                "nobody listens any more"
            });
            if !is_asked {
                self.heard.also.store(0, Ordering::Relaxed);
                self.heard.frames_ms.store(0, Ordering::Relaxed);
            }
        }
        if is_asked != self.is_asked {
            // What is sent meanwhile is for nobody.
            self.fitted = None;
        }
        self.is_asked = is_asked;
        let also = self.heard.also.load(Ordering::Relaxed);
        let wants = |channel: Also| is_asked && also & bit(channel) != 0;
        self.descriptors.follow(domain, &args.rig, is_asked);
        self.descriptors3.follow(domain, &args.rig, is_asked);
        self.centerlines
            .follow(domain, &args.rig, wants(Also::Centerlines));
        self.truth.follow(domain, &args.rig, wants(Also::Truth));
    }

    /// Sleeps until descriptors may have come, until the next look, or until a signal.
    fn sleep(&mut self, stop: &Stop) {
        let due = Instant::now() + CHECK;
        let slept = self
            .descriptors
            .receiver()
            .is_some_and(|reader| reader.sleep(Some(due), Some(stop.as_fd())).is_ok());
        if !slept {
            self.heard
                .first
                .sleep(now_ns() + CHECK.as_nanos() as u64, stop.as_fd());
        }
        let mut first = Arrived::default();
        while self.heard.first.next(&mut first) {
            self.checked = None;
        }
    }

    /// Sends what waits: descriptors before all else.
    fn send(&mut self) {
        while let Some(message) = self.descriptors.next() {
            let fitted = message.trace.fitted;
            self.missed += missed(self.fitted.replace(fitted), fitted);
            // As here, so there: who has descriptors has what stands in space beside them.
            while let Some(message) = self.descriptors3.next() {
                self.put(&*message, Kind::Descriptors3, Priority::RealTime);
            }
            self.put(&*message, Kind::Descriptors, Priority::RealTime);
        }
        while let Some(message) = self.centerlines.next() {
            self.put(&*message, Kind::Centerlines, Priority::Data);
        }
        while let Some(message) = self.truth.next() {
            self.put(&*message, Kind::Truth, Priority::Data);
        }
    }

    fn put(&mut self, message: &dyn Message, kind: Kind, priority: Priority) {
        let outgoing = &self.heard.outgoing;
        outgoing.write(kind, &mut self.datagram, |to| pack(message, to));
        self.wire.put(&self.datagram, priority);
    }
}

/// How many messages of a run of the chain lie between two of its fit's counts.
fn missed(last: Option<u64>, next: u64) -> u64 {
    let last = last.filter(|last| *last < next);
    last.map_or(0, |last| next - last - 1)
}

#[cfg(test)]
mod tests {
    use super::missed;

    #[test]
    fn what_was_overwritten_is_missed_and_a_chain_that_begins_anew_is_not() {
        assert_eq!(
            [(None, 9), (Some(9), 10), (Some(9), 13), (Some(9), 1)]
                .map(|(last, next)| missed(last, next)),
            [0, 0, 3, 0]
        );
    }
}
