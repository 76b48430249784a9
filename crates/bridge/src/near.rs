//! The camera's side: sends the rig's messages, answers questions, and takes commands.
//!
//! The thread that waits for descriptors packs, seals and sends them itself. The thread that waits
//! at the socket answers questions and executes commands itself. Nothing waits for a third thread.
//! Nothing is sent while no far side asks.

mod hearing;
mod pictures;
mod robot;

use std::net::SocketAddr;
use std::os::fd::{AsFd, OwnedFd};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use lariat_chain::stop::Stop;
use lariat_wire::fields::Message;
use lariat_wire::{
    CENTERLINES, Centerlines, DESCRIPTORS, DESCRIPTORS3, Descriptors, Descriptors3, Domain, TRUTH,
    now_ns,
};
use rustix::event::{EventfdFlags, eventfd};

use crate::args::{Also, Args, Place};
use crate::channel::{Read, Woken};
use crate::chunks::chunks;
use crate::datagram::{Datagram, Incoming, Kind, Outgoing, Refused};
use crate::key::{self, Side};
use crate::pack::pack;
use crate::peers::{Peers, Told, Wants};
use crate::question::{Answer, Question, bit};
use crate::refusals::Refusals;
use crate::say;
use crate::socket::{LARGEST_DATAGRAM, Rank, Socket, sleep};
use robot::Robot;

/// Interval at which channels are checked for writers.
const CHECK: Duration = Duration::from_millis(250);

/// State that the threads share.
struct Near {
    outgoing: Outgoing,
    peers: Mutex<Peers>,
    /// Signaled when the first far side has joined.
    first: OwnedFd,
    questions: AtomicU64,
    refusals: Mutex<Refusals>,
}

impl Near {
    fn peers(&self) -> MutexGuard<'_, Peers> {
        self.peers.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn refuse(&self, cause: Refused) {
        self.refusals().add(cause);
    }

    fn refusals(&self) -> MutexGuard<'_, Refusals> {
        self.refusals.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Writes the answer to a question that arrived at `at_ns`.
    fn answer(&self, question: &Question, told: Told, at_ns: u64, into: &mut Vec<u8>) {
        self.questions.fetch_add(1, Ordering::Relaxed);
        let sent = Kind::COUNTED.map(|kind| self.outgoing.sent(kind));
        self.outgoing.write(Kind::Answer, into, |to| {
            Answer {
                token: question.token,
                got_ns: at_ns,
                answered_ns: now_ns(),
                sent,
                cookie: told.cookie,
                is_heard: told.is_heard,
            }
            .write(to);
        });
    }
}

/// Handles a question. Returns the question and the reply to it; `None` if it is invalid or
/// outdated.
fn ask(
    peers: &mut Peers,
    datagram: &Datagram,
    from: SocketAddr,
    at_ns: u64,
) -> Option<(Question, Told)> {
    let question = Question::read(datagram.says)?;
    let count = (datagram.process, datagram.count);
    let told = peers.ask(count, &question, from, at_ns)?;
    Some((question, told))
}

/// Sends the rig's messages until a signal comes.
///
/// # Errors
/// Fails if the domain cannot be joined, or the address cannot be listened on.
pub(crate) fn run(args: &Args, place: &Place) -> Result<()> {
    let stop = Stop::on_signals()?;
    let domain = Domain::open()?;
    let (key, rig) = (args.key()?, &args.rig);
    let near = &Near {
        outgoing: Outgoing::new(key::random_number()?, &key, Side::Near, rig),
        peers: Mutex::new(Peers::new()?),
        first: eventfd(0, EventfdFlags::NONBLOCK | EventfdFlags::CLOEXEC)
            .context("the system has no descriptor left")?,
        questions: AtomicU64::new(0),
        refusals: Mutex::default(),
    };
    let socket = Socket::listen(place, Rank::First)
        .with_context(|| format!("it cannot be listened on {place}"))?;
    let socket = &socket;
    say(&format!("rig {rig} is at {place}"));
    let incoming = [key.clone(), key].map(|key| Incoming::new(key, Side::Far, rig));
    let [hears, pictures_hear] = incoming;
    let (hearing_stop, mut hearing_stopper) = Stop::by_another()?;
    let (pictures_stop, mut pictures_stopper) = Stop::by_another()?;
    let robot = Robot::new(rig, near.outgoing.process(), args.command_age);
    thread::scope(|scope| {
        let hearing = thread::Builder::new()
            .name("hearing".into())
            .spawn_scoped(scope, || {
                crate::hurry(args.realtime);
                hearing::run(near, socket, hears, robot, &hearing_stop)
            })
            .context("no thread could be started")?;
        let pictures = thread::Builder::new()
            .name("pictures".into())
            .spawn_scoped(scope, || {
                pictures::run(rig, place, near, pictures_hear, &pictures_stop)
            });
        crate::hurry_or_say(args.realtime);
        let mut sender = Sender::new(near, socket);
        while pictures.is_ok() && !stop.asked() {
            sender.look(&domain, args);
            sender.sleep(&stop);
            sender.send();
        }
        hearing_stopper.stop();
        pictures_stopper.stop();
        let commands = hearing.join();
        let pictures = pictures.context("no thread could be started")?.join();
        let [frames, masks] = pictures.unwrap_or_default();
        let sent = |kind| near.outgoing.sent(kind);
        println!(
            "rig {rig}: sent {} descriptors (and missed {}), {} in space, {} centerlines, {} truths, {} frames, {} masks; answered {} questions; refused {}",
            sent(Kind::Descriptors),
            sender.missed,
            sent(Kind::Descriptors3),
            sent(Kind::Centerlines),
            sent(Kind::Truth),
            frames,
            masks,
            near.questions.load(Ordering::Relaxed),
            near.refusals().count(),
        );
        if let Ok(commands) = commands {
            println!("{commands}");
        }
        Ok(())
    })
}

/// The rig's channels, and the socket that their messages go to.
struct Sender<'n> {
    near: &'n Near,
    socket: &'n Socket,
    descriptors: Read<Descriptors>,
    descriptors3: Read<Descriptors3>,
    centerlines: Read<Centerlines>,
    truth: Read<Centerlines>,
    checked: Option<Instant>,
    is_asked: bool,
    /// Fit's count in the last descriptors, and the number of descriptors overwritten before they
    /// were read.
    fitted: Option<u64>,
    missed: u64,
    datagram: Vec<u8>,
    part: Vec<u8>,
    to: Vec<SocketAddr>,
}

impl<'n> Sender<'n> {
    fn new(near: &'n Near, socket: &'n Socket) -> Self {
        Self {
            near,
            socket,
            descriptors: Read::new(&DESCRIPTORS, Woken::Yes),
            descriptors3: Read::new(&DESCRIPTORS3, Woken::No),
            centerlines: Read::new(&CENTERLINES, Woken::No),
            truth: Read::new(&TRUTH, Woken::No),
            checked: None,
            is_asked: false,
            fitted: None,
            missed: 0,
            datagram: Vec::new(),
            part: Vec::new(),
            to: Vec::new(),
        }
    }

    /// Opens wanted channels and closes unwanted ones, if a check is due.
    fn look(&mut self, domain: &Domain, args: &Args) {
        if self.checked.is_some_and(|at| at.elapsed() < CHECK) {
            return;
        }
        self.checked = Some(Instant::now());
        let also = self.near.peers().also(now_ns());
        let is_asked = also.is_some();
        if is_asked != self.is_asked {
            say(if is_asked {
                "somebody listens"
            } else {
                "nobody listens any more"
            });
            // Messages sent in the meantime are for nobody, so none counts as missed.
            self.fitted = None;
        }
        self.is_asked = is_asked;
        let wants = |channel: Also| also.is_some_and(|also| also & bit(channel) != 0);
        self.descriptors.follow(domain, &args.rig, is_asked);
        self.descriptors3.follow(domain, &args.rig, is_asked);
        self.centerlines
            .follow(domain, &args.rig, wants(Also::Centerlines));
        self.truth.follow(domain, &args.rig, wants(Also::Truth));
    }

    /// Sleeps until descriptors may have come, until the next check, or until a signal.
    fn sleep(&mut self, stop: &Stop) {
        let due = Instant::now() + CHECK;
        let slept = self
            .descriptors
            .receiver()
            .is_some_and(|reader| reader.sleep(Some(due), Some(stop.as_fd())).is_ok());
        if !slept {
            let first = &self.near.first;
            let due_ns = now_ns() + CHECK.as_nanos() as u64;
            sleep([first.as_fd(), stop.as_fd()], due_ns);
            if rustix::io::read(first, &mut [0_u8; 8]).is_ok() {
                self.checked = None;
            }
        }
    }

    /// Sends all waiting messages, descriptors first.
    fn send(&mut self) {
        while let Some(message) = self.descriptors.next() {
            let fitted = message.trace.fitted;
            self.missed += missed(self.fitted.replace(fitted), fitted);
            // 3-D descriptors go before the descriptors of the same frame, on both machines.
            while let Some(message) = self.descriptors3.next() {
                self.put(&*message, Kind::Descriptors3, Wants::Descriptors);
            }
            self.put(&*message, Kind::Descriptors, Wants::Descriptors);
        }
        while let Some(message) = self.centerlines.next() {
            self.put(&*message, Kind::Centerlines, Wants::Also(Also::Centerlines));
        }
        while let Some(message) = self.truth.next() {
            self.put(&*message, Kind::Truth, Wants::Also(Also::Truth));
        }
    }

    /// Sends a message to all who want it. It is counted before its receivers are looked up, so a
    /// far side that joins in between counts it as sent before it joined.
    fn put(&mut self, message: &dyn Message, kind: Kind, wants: Wants) {
        let outgoing = &self.near.outgoing;
        outgoing.write(kind, &mut self.datagram, |to| pack(message, to));
        self.to.clear();
        self.to.extend(self.near.peers().addresses(wants, now_ns()));
        if self.datagram.len() <= LARGEST_DATAGRAM {
            return self.socket.send_all(&self.datagram, &self.to);
        }
        let whole = outgoing.sent(Kind::Part) as u32;
        for (head, chunk) in chunks(whole, &self.datagram) {
            outgoing.write(Kind::Part, &mut self.part, |to| {
                to.extend(head);
                to.extend(chunk);
            });
            self.socket.send_all(&self.part, &self.to);
        }
    }
}

/// Returns the number of messages missing between two of fit's counts in one run of the chain.
fn missed(last: Option<u64>, next: u64) -> u64 {
    let last = last.filter(|last| *last < next);
    last.map_or(0, |last| next - last - 1)
}

#[cfg(test)]
mod tests {
    use super::missed;

    #[test]
    fn what_was_overwritten_is_missed_and_a_chain_that_begins_again_is_not() {
        assert_eq!(
            [(None, 9), (Some(9), 10), (Some(9), 13), (Some(9), 1)]
                .map(|(last, next)| missed(last, next)),
            [0, 0, 3, 0]
        );
    }
}
