//! Setup that the tests share: both sides as processes, a relay between them, a chain at one end.

use std::io::Read;
use std::net::UdpSocket;
use std::process::{Child, Command as Process, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use lariat_chain::stages::arrangement::core_list;
use lariat_wire::{DESCRIPTORS, Delivery, Descriptors, Domain, Receiver, Rig, Writer, now_ns};

use crate::relay::{Relay, Weather};
use crate::rope;

/// Time limit that only a stuck test exceeds.
pub(crate) const PATIENCE: Duration = Duration::from_secs(20);
pub(crate) const PROGRAM: &str = env!("CARGO_BIN_EXE_lariat-bridge");

/// A process that ends with its test, even if the test panics.
pub(crate) struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A side of a bridge.
pub(crate) struct Side {
    process: Running,
    said: JoinHandle<String>,
}

impl Side {
    pub(crate) fn start(domain: &str, words: &[&str]) -> Self {
        let mut process = Process::new(PROGRAM)
            .args(words)
            .env("LARIAT_DOMAIN", domain)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("a process");
        let (mut out, mut errors) = (
            process.stdout.take().expect("piped"),
            process.stderr.take().expect("piped"),
        );
        let said = thread::spawn(move || {
            let mut said = String::new();
            let _ = errors.read_to_string(&mut said);
            let _ = out.read_to_string(&mut said);
            said
        });
        Self {
            process: Running(process),
            said,
        }
    }

    /// Returns for each thread its name, whether it has realtime priority, and how many cores it
    /// may run on.
    pub(crate) fn threads(&self) -> Vec<(String, bool, usize)> {
        let tasks = std::fs::read_dir(format!("/proc/{}/task", self.process.0.id()));
        let threads = tasks.expect("it lives").flatten().map(|task| {
            let read = |name| std::fs::read_to_string(task.path().join(name)).unwrap_or_default();
            let (stat, status) = (read("stat"), read("status"));
            // The policy is the 39th field after the name in parentheses: 1 is FIFO.
            let policy = stat
                .rsplit_once(')')
                .and_then(|(_, rest)| rest.split_whitespace().nth(38));
            let cores = status
                .lines()
                .find_map(|line| line.strip_prefix("Cpus_allowed_list:"));
            (
                read("comm").trim().to_owned(),
                policy == Some("1"),
                core_list(cores.unwrap_or_default()).len(),
            )
        });
        threads.collect()
    }

    /// Ends the process by a signal. Returns what it printed.
    pub(crate) fn end(mut self) -> String {
        let pid = rustix::process::Pid::from_child(&self.process.0);
        rustix::process::kill_process(pid, rustix::process::Signal::TERM).expect("it is ours");
        let status = self.process.0.wait().expect("it is ours");
        let said = self.said.join().expect("text");
        assert!(status.success(), "{status}: {said}");
        said
    }

    pub(crate) fn kill(self) {
        drop(self.process);
    }
}

/// Two domains, a port and a rig.
pub(crate) struct Place {
    pub(crate) near: String,
    pub(crate) far: String,
    pub(crate) port: u16,
    pub(crate) rig: Rig,
}

impl Place {
    pub(crate) fn new() -> Self {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let name = format!(
            "{}-{}",
            std::process::id(),
            COUNT.fetch_add(1, Ordering::Relaxed)
        );
        Self {
            near: format!("bn{name}"),
            far: format!("bf{name}"),
            port: free_port(),
            rig: rig(),
        }
    }

    pub(crate) fn at(port: u16) -> String {
        format!("udp/127.0.0.1:{port}")
    }

    pub(crate) fn listen(&self, more: &[&str]) -> Side {
        self.start(&self.near, "--listen", self.port, more)
    }

    /// Connects to a port, which is the relay's if there is one.
    pub(crate) fn connect(&self, port: u16, more: &[&str]) -> Side {
        self.start(&self.far, "--connect", port, more)
    }

    /// Starts a side without a key, unless `more` names one.
    fn start(&self, domain: &str, side: &str, port: u16, more: &[&str]) -> Side {
        let at = Self::at(port);
        let insecure: &[_] = match more.contains(&"--key") {
            true => &[],
            false => &["--insecure"],
        };
        let words = ["--rig", self.rig.as_str(), side, &at];
        Side::start(domain, &[&words, insecure, more].concat())
    }

    pub(crate) fn near(&self) -> Domain {
        Domain::named(&self.near).expect("a domain")
    }

    pub(crate) fn far(&self) -> Domain {
        Domain::named(&self.far).expect("a domain")
    }
}

/// Checks that nothing is left in shared memory.
impl Drop for Place {
    fn drop(&mut self) {
        if thread::panicking() {
            return;
        }
        let left = std::fs::read_dir("/dev/shm").expect("a folder");
        let left = left.flatten().map(|entry| entry.file_name());
        let ours = |name: &str| name.contains(&self.near) || name.contains(&self.far);
        let left: Vec<_> = left
            .filter(|name| name.to_str().is_some_and(ours))
            .collect();
        assert!(left.is_empty(), "{left:?}");
    }
}

pub(crate) fn free_port() -> u16 {
    let socket = UdpSocket::bind("127.0.0.1:0").expect("a port");
    socket.local_addr().expect("a port").port()
}

pub(crate) fn rig() -> Rig {
    "cell".parse().expect("a name")
}

/// A relay to a port, running until it is dropped.
pub(crate) struct Relayed {
    pub(crate) port: u16,
    wanted: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Relayed {
    pub(crate) fn start(to: u16, weather: Weather) -> Self {
        Self::at(free_port(), to, weather)
    }

    pub(crate) fn at(port: u16, to: u16, weather: Weather) -> Self {
        let wanted = Arc::new(AtomicBool::new(true));
        let [at, to] = [port, to].map(|port| ([127, 0, 0, 1], port).into());
        let mut relay = Relay::new(at, to, weather, 3).expect("a port");
        let wants = wanted.clone();
        let thread = thread::spawn(move || {
            relay
                .run(|| wants.load(Ordering::Relaxed))
                .expect("sockets");
        });
        Self {
            port,
            wanted,
            thread: Some(thread),
        }
    }
}

impl Drop for Relayed {
    fn drop(&mut self) {
        self.wanted.store(false, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// The end of a chain. Its thread sends a rope 100 times per second, from the moment when somebody
/// reads it until this value is dropped.
pub(crate) struct Chain {
    wanted: Arc<AtomicBool>,
    thread: Option<JoinHandle<u64>>,
}

impl Chain {
    pub(crate) fn start(place: &Place) -> Self {
        Self::of(place, rope::write)
    }

    /// Starts a chain of other ropes. `write` receives the message, its count and the time.
    pub(crate) fn of(place: &Place, write: fn(&mut Descriptors, u64, u64)) -> Self {
        let wanted = Arc::new(AtomicBool::new(true));
        let (wants, name, rig) = (wanted.clone(), place.near.clone(), place.rig.clone());
        let thread = thread::spawn(move || {
            let domain = Domain::named(&name).expect("a domain");
            let writer =
                Writer::<Descriptors>::create(&domain, &rig, &DESCRIPTORS, &Delivery::NewestWins);
            let (writer, mut count) = (writer.expect("the only one"), 0);
            while wants.load(Ordering::Relaxed) {
                // A camera's pace.
                thread::sleep(Duration::from_millis(10));
                if count == 0 && writer.readers() == 0 {
                    continue;
                }
                count += 1;
                let mut slot = writer.slot().expect("a slot");
                write(&mut slot, count, now_ns());
                slot.send().expect("sent");
            }
            count
        });
        Self {
            wanted,
            thread: Some(thread),
        }
    }
}

impl Drop for Chain {
    fn drop(&mut self) {
        self.wanted.store(false, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Passes all messages of a reader to `see`, in order, while `wanted` returns true.
pub(crate) fn take(
    reader: &Receiver<Descriptors>,
    mut see: impl FnMut(&Descriptors),
    mut wanted: impl FnMut() -> bool,
) {
    let deadline = Instant::now() + PATIENCE;
    while wanted() {
        assert!(Instant::now() < deadline, "nothing comes");
        let look_up = Instant::now() + Duration::from_millis(100);
        reader.sleep(Some(look_up), None).expect("a reader");
        while let Some(message) = reader.next().expect("a reader") {
            see(&message);
        }
    }
}

/// Returns the number after the last `before` in `said`.
pub(crate) fn number(said: &str, before: &str) -> u64 {
    let rest = said
        .split(before)
        .last()
        .filter(|rest| rest.len() < said.len());
    let digits = rest.unwrap_or_else(|| panic!("no {before:?} in {said}"));
    let digits = digits.split(|c: char| !c.is_ascii_digit()).next();
    digits.and_then(|digits| digits.parse().ok()).expect(said)
}

/// Returns the maximum error of timestamps that a domain's bridge reports in its roster, in µs.
pub(crate) fn said_bound_us(domain: &str) -> Option<f64> {
    let entries = std::fs::read_dir(format!("/tmp/lariat-{domain}/lariat-roster")).ok()?;
    let mut texts = entries
        .flatten()
        .map(|entry| std::fs::read_to_string(entry.path()));
    let said =
        texts.find_map(|text| Some(text.ok()?.split_once("clock_bound_us = ")?.1.to_owned()))?;
    said.lines().next()?.parse().ok()
}
