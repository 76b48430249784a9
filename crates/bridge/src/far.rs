//! The other side: writes what arrives to the rig's channels here, with its timestamps on this
//! machine's clock.
//!
//! Readers here see the same rig as on the camera's machine. While nothing arrives, the last
//! message ages, and readers notice that by themselves (`Seen::Stale`). The bridge asks the other
//! side for its time 20 times per second. After [`SILENCE_NS`] without an answer it looks the name
//! up again and reconnects. The cause may be a cut link, a killed process or an address that moved.
//! The thread that waits at the socket opens, checks and writes messages itself.

mod controller;
mod link;
mod pictures;
mod written;

use std::net::SocketAddr;
use std::os::fd::AsFd;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use anyhow::{Context, Result};
use lariat_chain::stop::Stop;
use lariat_wire::{
    CENTERLINES, Centerlines, DESCRIPTORS, DESCRIPTORS3, Descriptors, Descriptors3, Domain, Rig,
    TRUTH, now_ns,
};

use crate::args::{Also, Args, Place};
use crate::chunks::Assembly;
use crate::clock::Offset;
use crate::datagram::{Incoming, Kind, Outgoing, Refused};
use crate::key::{self, Side};
use crate::question::{Answer, Question, bit};
use crate::refusals::Refusals;
use crate::say;
use crate::socket::{LARGEST_DATAGRAM, Rank, Socket, sleep};
use crate::stamps::Stamps;
use link::{Link, Took};
use written::Written;

/// Interval between two questions.
const ASK_NS: u64 = 50_000_000;
/// A question may leave this much earlier, if a message has just arrived.
const ASK_EARLY_NS: u64 = 10_000_000;
/// The bridge reconnects after eight questions without an answer.
const SILENCE_NS: u64 = 8 * ASK_NS;
/// Time between two attempts while a name is unknown or an address unreachable.
const RETRY_NS: u64 = 100_000_000;
/// Interval at which the roster is updated.
const SECOND_NS: u64 = 1_000_000_000;

/// State that is shared with the thread that sends commands.
#[derive(Default)]
struct Upward {
    socket: Option<(Arc<Socket>, SocketAddr)>,
    /// The process of the other side, and its clock.
    near: Option<(u64, Offset)>,
}

/// Carries messages until a signal comes.
///
/// # Errors
/// Fails if the domain cannot be joined.
pub(crate) fn run(args: &Args, place: &Place) -> Result<()> {
    let stop = Stop::on_signals()?;
    let domain = Domain::open()?;
    let key = args.key()?;
    let outgoing = Arc::new(Outgoing::new(
        key::random_number()?,
        &key,
        Side::Far,
        &args.rig,
    ));
    let upward = Arc::new(Mutex::new(Upward::default()));
    let (controller_stop, mut stopper) = Stop::by_another()?;
    let realtime = args.realtime;
    let controller = {
        let (rig, outgoing, upward) = (args.rig.clone(), outgoing.clone(), upward.clone());
        thread::Builder::new()
            .name("controller".into())
            .spawn(move || {
                crate::hurry(realtime);
                controller::run(&rig, &outgoing, &upward, &controller_stop)
            })
            .context("no thread could be started")?
    };
    let (pictures_stop, mut pictures_stopper) = Stop::by_another()?;
    let masks = also(args) & bit(Also::Masks);
    let pictures = match (args.frames_ms(), masks) {
        (0, 0) => None,
        _ => {
            let (rig, place, upward) = (args.rig.clone(), place.clone(), upward.clone());
            let incoming = Incoming::new(key.clone(), Side::Near, &rig);
            let (outgoing, frames_ms) = (outgoing.clone(), args.frames_ms());
            let run = move || {
                let asks = pictures::Asks::new(outgoing, masks, frames_ms);
                pictures::run(&rig, &place, asks, incoming, &upward, &pictures_stop)
            };
            let thread = thread::Builder::new().name("pictures".into()).spawn(run);
            Some(thread.context("no thread could be started")?)
        }
    };
    crate::hurry_or_say(realtime);
    let mut far = Far::new(
        args,
        &domain,
        Incoming::new(key, Side::Near, &args.rig),
        outgoing,
        upward,
    );
    let carried = far.carry(place, &stop);
    stopper.stop();
    pictures_stopper.stop();
    let commands = controller.join().unwrap_or_default();
    let [frames, masks] = pictures.map_or([0; 2], |thread| thread.join().unwrap_or_default());
    println!("rig {}: {}", args.rig, far.link.sentence(now_ns()));
    println!(
        "took {frames} frames, {masks} masks; refused {} messages; sent {commands} commands",
        far.refusals.count()
    );
    carried
}

/// Returns the channels to ask for in addition to descriptors, one bit each.
fn also(args: &Args) -> u8 {
    args.also.iter().fold(0, |bits, also| bits | bit(*also))
}

/// The rig's channels, and what is known of the other side.
struct Far<'a> {
    rig: &'a Rig,
    domain: &'a Domain,
    also: u8,
    frames_ms: u16,
    outgoing: Arc<Outgoing>,
    upward: Arc<Mutex<Upward>>,
    incoming: Incoming,
    /// Parts of a datagram that is larger than UDP can carry, and the reassembled datagram.
    parts: Assembly,
    whole: Vec<u8>,
    link: Link,
    descriptors: Written<Descriptors>,
    descriptors3: Written<Descriptors3>,
    /// True if 3-D descriptors have come, so that the rig has a depth camera.
    is_in_space: bool,
    /// Timestamps of both kinds of descriptors.
    stamps: Stamps,
    centerlines: Written<Centerlines>,
    centerline_stamps: Stamps,
    truth: Written<Centerlines>,
    truth_stamps: Stamps,
    refusals: Refusals,
    /// Cookie of the last answer.
    cookie: u64,
    datagram: Vec<u8>,
}

impl<'a> Far<'a> {
    fn new(
        args: &'a Args,
        domain: &'a Domain,
        incoming: Incoming,
        outgoing: Arc<Outgoing>,
        upward: Arc<Mutex<Upward>>,
    ) -> Self {
        Self {
            rig: &args.rig,
            domain,
            also: also(args),
            frames_ms: args.frames_ms(),
            outgoing,
            upward,
            incoming,
            parts: Assembly::default(),
            whole: Vec::new(),
            link: Link::default(),
            descriptors: Written::new(&DESCRIPTORS, Descriptors::EMPTY),
            descriptors3: Written::new(&DESCRIPTORS3, Descriptors3::EMPTY),
            is_in_space: false,
            stamps: Stamps::default(),
            centerline_stamps: Stamps::default(),
            truth_stamps: Stamps::default(),
            centerlines: Written::new(&CENTERLINES, Centerlines::EMPTY),
            truth: Written::new(&TRUTH, Centerlines::EMPTY),
            refusals: Refusals::default(),
            cookie: 0,
            datagram: Vec::new(),
        }
    }

    /// Opens one socket after another. Each is used until answers stop.
    fn carry(&mut self, place: &Place, stop: &Stop) -> Result<()> {
        let mut announcement = None;
        let mut is_silent = None;
        let mut attempt = 0;
        while !stop.asked() {
            // The addresses of a name are tried in turn.
            let address = place.addresses().map(|all| all[attempt % all.len()]);
            let opened =
                address.and_then(|at| Ok((Arc::new(Socket::toward(at, Rank::First)?), at)));
            let has_answered = match opened {
                Ok((socket, at)) => {
                    self.upward().socket = Some((socket.clone(), at));
                    let answered = self.listen((&socket, at), stop, |far, is_first| {
                        if is_first && is_silent != Some(false) {
                            is_silent = Some(false);
                            say(&format!("rig {} of {place} is here", far.rig));
                        }
                        far.announce(place, &mut announcement);
                    });
                    *self.upward() = Upward::default();
                    answered
                }
                Err(_) => {
                    self.open_channels();
                    stop.sleep_until(now_ns() + RETRY_NS);
                    false
                }
            };
            if stop.asked() {
                break;
            }
            if has_answered {
                is_silent = Some(true);
                say(&format!(
                    "{place} is silent: {}",
                    self.link.sentence(now_ns())
                ));
                continue;
            }
            attempt += 1;
            if is_silent.is_none() {
                is_silent = Some(true);
                say(&format!(
                    "nobody answers at {place} yet: `lariat bridge --listen` on the camera's machine"
                ));
            }
        }
        Ok(())
    }

    /// Asks questions and handles all datagrams that arrive, until a signal or a silence. Returns
    /// whether there was an answer. Calls `every_second` on the first answer, and then once per
    /// second.
    fn listen(
        &mut self,
        (socket, near): (&Socket, SocketAddr),
        stop: &Stop,
        mut every_second: impl FnMut(&mut Self, bool),
    ) -> bool {
        let mut buffer = vec![0; LARGEST_DATAGRAM];
        let mut ask_due_ns = now_ns();
        let mut silent_ns = ask_due_ns + SILENCE_NS;
        let mut second_due_ns = 0;
        let mut has_answered = false;
        self.cookie = 0;
        while !stop.asked() && now_ns() < silent_ns {
            if now_ns() >= ask_due_ns {
                ask_due_ns = (ask_due_ns + ASK_NS).max(now_ns());
                self.open_channels();
                self.ask(socket, near);
            }
            let Some((bytes, _)) = socket.next(&mut buffer) else {
                sleep([socket.as_fd(), stop.as_fd()], ask_due_ns.min(silent_ns));
                continue;
            };
            let Some(answer) = self.take(now_ns(), bytes) else {
                // Right after a message, a question and its answer delay no other message.
                if now_ns() + ASK_EARLY_NS >= ask_due_ns {
                    ask_due_ns = now_ns();
                }
                continue;
            };
            silent_ns = now_ns() + SILENCE_NS;
            // Nothing is sent to this side before it has repeated the cookie.
            if answer.cookie != std::mem::replace(&mut self.cookie, answer.cookie) {
                ask_due_ns = now_ns();
            }
            let is_first = !std::mem::replace(&mut has_answered, true);
            if is_first || now_ns() >= second_due_ns {
                second_due_ns = now_ns() + SECOND_NS;
                every_second(self, is_first);
            }
        }
        has_answered
    }

    fn ask(&mut self, socket: &Socket, near: SocketAddr) {
        let Ok(token) = key::random_number() else {
            return;
        };
        let question = Question {
            token,
            cookie: self.cookie,
            also: self.also,
            frames_ms: self.frames_ms,
        };
        self.outgoing
            .write(Kind::Ask, &mut self.datagram, |to| question.write(to));
        self.link.ask(token, now_ns());
        socket.send(&self.datagram, near);
    }

    /// Takes a datagram that arrived at `at_ns`. Returns the answer, if it is one.
    fn take(&mut self, at_ns: u64, bytes: &mut [u8]) -> Option<Answer> {
        let datagram = match self.incoming.read(bytes) {
            Ok(datagram) if datagram.kind == Kind::Part => {
                let whole = self.link.is_of_near(&datagram).then_some(datagram.says);
                self.whole.clear();
                self.whole.extend(self.parts.take(whole?)?);
                self.incoming.read(&mut self.whole)
            }
            read => read,
        };
        let datagram = match datagram {
            Ok(datagram) => datagram,
            Err(cause) => {
                self.refusals.add(cause);
                return None;
            }
        };
        if datagram.kind == Kind::Answer {
            let answer = Answer::read(datagram.says)?;
            let took = self.link.answer(datagram.process, &answer, at_ns);
            if took == Took::Both {
                say("two bridges send this rig: the one that was there first is gone by");
            }
            if took == Took::No {
                return None;
            }
            let near = self.link.near();
            self.upward().near = near;
            return Some(answer);
        }
        let offset = self.link.receive(&datagram)?;
        let taken = match datagram.kind {
            Kind::Descriptors => self
                .descriptors
                .take(&datagram, &mut self.stamps, &offset, at_ns),
            Kind::Descriptors3 => {
                if !std::mem::replace(&mut self.is_in_space, true) {
                    self.descriptors3.open(self.domain, self.rig);
                }
                self.descriptors3
                    .take(&datagram, &mut self.stamps, &offset, at_ns)
            }
            Kind::Centerlines => {
                let stamps = &mut self.centerline_stamps;
                self.centerlines.take(&datagram, stamps, &offset, at_ns)
            }
            Kind::Truth => {
                let stamps = &mut self.truth_stamps;
                self.truth.take(&datagram, stamps, &offset, at_ns)
            }
            _ => None,
        };
        if taken.is_none() {
            self.refusals.add(Refused::Nonsense);
        }
        None
    }

    /// Becomes the writer of the rig's channels right at the start, so that readers know that a
    /// writer exists. The channel of 3-D descriptors is opened only for a rig with a depth camera,
    /// to save memory.
    fn open_channels(&mut self) {
        self.descriptors.open(self.domain, self.rig);
        if self.is_in_space {
            self.descriptors3.open(self.domain, self.rig);
        }
        if self.also & bit(Also::Centerlines) != 0 {
            self.centerlines.open(self.domain, self.rig);
        }
        if self.also & bit(Also::Truth) != 0 {
            self.truth.open(self.domain, self.rig);
        }
    }

    /// Writes the state to the roster, for `lariat topic delay` and `lariat top`.
    fn announce(&mut self, place: &Place, announcement: &mut Option<lariat_wire::Announcement>) {
        let settings = self.link.settings(place, now_ns());
        // Ignore errors: nothing depends on the roster.
        match announcement {
            Some(announcement) => drop(announcement.renew(&settings)),
            None => *announcement = self.domain.announce(self.rig, "bridge", &settings).ok(),
        }
    }

    fn upward(&self) -> std::sync::MutexGuard<'_, Upward> {
        self.upward.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
