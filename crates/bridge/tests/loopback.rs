//! Both sides of a bridge as processes, each in a domain of its own, over the loopback and over a relay that delays, loses and reorders: what comes
//! is what was sent, stamps are right to the stated bound, sent = received + lost, nothing goes back in time, each side may be killed, commands come
//! back and never late, and only who has the key is heard.

#[path = "../examples/wire/relay.rs"]
mod relay;
#[path = "../examples/wire/rope.rs"]
mod rope;

use std::io::Read;
use std::net::UdpSocket;
use std::path::PathBuf;
use std::process::{Child, Command as Process, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use lariat_wire::{
    CENTERLINES, COMMANDS, Centerlines, Command, CommandReader, DESCRIPTORS, Delivery, Descriptors,
    Domain, FRAMES, FrameHeader, PixelFormat, Reader, Receiver, Rig, Seen, TRUTH, Writer, now_ns,
};
use relay::{Relay, Weather};

/// Nothing takes so long that goes on at all.
const PATIENCE: Duration = Duration::from_secs(20);
const PROGRAM: &str = env!("CARGO_BIN_EXE_lariat-bridge");

/// A process that ends with its test, however that ends.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // Ended already, or of no use to anyone.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A side of a bridge.
struct Side {
    process: Running,
    said: JoinHandle<String>,
}

impl Side {
    fn start(domain: &str, words: &[&str]) -> Self {
        let mut process = Process::new(PROGRAM)
            .args(["--rig", "cell"])
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

    /// Ends it as Ctrl-C does; what it said.
    fn end(mut self) -> String {
        let pid = rustix::process::Pid::from_child(&self.process.0);
        rustix::process::kill_process(pid, rustix::process::Signal::TERM).expect("it is ours");
        let status = self.process.0.wait().expect("it is ours");
        let said = self.said.join().expect("text");
        assert!(status.success(), "{status}: {said}");
        said
    }

    fn kill(self) {
        drop(self.process);
    }
}

/// Two domains, and a port.
struct Place {
    near: String,
    far: String,
    port: u16,
}

impl Place {
    fn new() -> Self {
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
        }
    }

    fn at(port: u16) -> String {
        format!("udp/127.0.0.1:{port}")
    }

    fn listen(&self, more: &[&str]) -> Side {
        let at = Self::at(self.port);
        Side::start(&self.near, &[&["--listen", &at], more].concat())
    }

    /// `port`: the relay's, if there is one.
    fn connect(&self, port: u16, more: &[&str]) -> Side {
        let at = Self::at(port);
        Side::start(&self.far, &[&["--connect", &at], more].concat())
    }

    fn near(&self) -> Domain {
        Domain::named(&self.near).expect("a domain")
    }

    fn far(&self) -> Domain {
        Domain::named(&self.far).expect("a domain")
    }
}

/// Nothing is left behind.
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

fn free_port() -> u16 {
    let socket = UdpSocket::bind("127.0.0.1:0").expect("a port");
    socket.local_addr().expect("a port").port()
}

fn rig() -> Rig {
    "cell".parse().expect("a name")
}

/// A relay to a port, for as long as it is kept.
struct Relayed {
    port: u16,
    wanted: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Relayed {
    fn start(to: u16, weather: Weather) -> Self {
        let (port, wanted) = (free_port(), Arc::new(AtomicBool::new(true)));
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

/// A chain's end: sends a rope 100 times a second, in a thread of its own, until it is dropped.
struct Chain {
    wanted: Arc<AtomicBool>,
    thread: Option<JoinHandle<u64>>,
}

impl Chain {
    fn start(place: &Place) -> Self {
        let wanted = Arc::new(AtomicBool::new(true));
        let (wants, name) = (wanted.clone(), place.near.clone());
        let thread = thread::spawn(move || {
            let domain = Domain::named(&name).expect("a domain");
            let writer =
                Writer::<Descriptors>::create(&domain, &rig(), &DESCRIPTORS, &Delivery::NewestWins);
            let (writer, mut count) = (writer.expect("the only one"), 0);
            while wants.load(Ordering::Relaxed) {
                // A camera's pace.
                thread::sleep(Duration::from_millis(10));
                count += 1;
                let mut slot = writer.slot().expect("a slot");
                rope::write(&mut slot, count, now_ns());
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

/// The next messages of a reader; all that waits is taken, in its order.
fn take(
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

/// The number behind a word in what was said.
fn number(said: &str, before: &str) -> u64 {
    let rest = said
        .split(before)
        .last()
        .filter(|rest| rest.len() < said.len());
    let digits = rest.unwrap_or_else(|| panic!("no {before:?} in {said}"));
    let digits = digits.split(|c: char| !c.is_ascii_digit()).next();
    digits.and_then(|digits| digits.parse().ok()).expect(said)
}

#[test]
fn what_comes_is_what_was_sent_with_stamps_right_to_the_stated_bound() {
    let place = Place::new();
    let sides = (place.listen(&[]), place.connect(place.port, &[]));
    let domain = place.far();
    let reader = Receiver::descriptors(&domain, &rig()).expect("a reader");
    let chain = Chain::start(&place);
    let (mut count, mut last) = (0, 0);
    let (mut bound_us, mut compared) = (None, 0);
    let mut expected = Box::new(Descriptors::EMPTY);
    let see = |message: &Descriptors| {
        let written_ns = rope::written_ns(message);
        rope::write(&mut expected, message.trace.fitted, written_ns);
        let ours = &mut expected.curves[0];
        assert_eq!(message.curves[0].control_points(), ours.control_points());
        assert_eq!(message.curves[0].covariances(), ours.covariances());
        assert_eq!(message.curves[0].inner_knots(), ours.inner_knots());
        let points = [message, &expected].map(|message| message.centerlines[0].points());
        for (came, sent) in points[0].iter().zip(points[1]) {
            assert!(came.iter().zip(sent).all(|(a, b)| (a - b).abs() < 0.01));
        }
        assert_eq!(points[0].len(), points[1].len());
        assert!(message.trace.fitted > last);
        last = message.trace.fitted;
        // One machine, one clock: what a stamp is off by is known. The bound gets better with each answer, and by no more worse than clocks drift apart.
        if let Some(bound_us) = bound_us {
            let off_us = message.trace.exposed_ns.abs_diff(written_ns) as f64 * 1e-3;
            assert!(off_us < bound_us + 1000.0, "{off_us} ± {bound_us}");
            compared += 1;
        }
        count += 1;
        bound_us = bound_us.or_else(|| said_bound_us(&place.far));
    };
    let until = Instant::now() + Duration::from_millis(1500);
    take(&reader, see, || Instant::now() < until);
    assert!(count > 1 && compared > 0, "{count} {compared}");
    let (said, near) = (sides.1.end(), sides.0.end());
    assert!(
        number(&near, "cell: sent ") >= number(&said, "received "),
        "{near} {said}"
    );
    drop((reader, domain, chain));
}

/// By how much stamps may be off, as a bridge of a domain says in its roster.
fn said_bound_us(domain: &str) -> Option<f64> {
    let entries = std::fs::read_dir(format!("/tmp/lariat-{domain}/lariat-roster")).ok()?;
    let mut texts = entries
        .flatten()
        .map(|entry| std::fs::read_to_string(entry.path()));
    let said =
        texts.find_map(|text| Some(text.ok()?.split_once("clock_bound_us = ")?.1.to_owned()))?;
    said.lines().next()?.parse().ok()
}

#[test]
fn losses_are_exact_and_nothing_goes_back_in_time_over_a_link_that_delays_loses_and_reorders() {
    let place = Place::new();
    let weather = Weather {
        delay: Duration::from_millis(20),
        jitter: Duration::from_millis(30),
        lost_of_1000: 20,
    };
    let relay = Relayed::start(place.port, weather);
    let sides = (place.listen(&[]), place.connect(relay.port, &[]));
    let domain = place.far();
    let reader = Receiver::descriptors(&domain, &rig()).expect("a reader");
    // Once there was an answer, all that is sent is known of.
    let deadline = Instant::now() + PATIENCE;
    take(
        &reader,
        |_| {},
        || said_bound_us(&place.far).is_none() && Instant::now() < deadline,
    );
    let chain = Chain::start(&place);
    let (mut count, mut last) = (0, (0, 0));
    let see = |message: &Descriptors| {
        let at = (message.trace.fitted, message.trace.exposed_ns);
        assert!(at.0 > last.0 && at.1 > last.1, "{at:?} after {last:?}");
        // Both ways take 50 ms at most, so that no stamp is off by more than half of the way there and back.
        assert!(at.1.abs_diff(rope::written_ns(message)) < 100_000_000);
        last = at;
        count += 1;
    };
    let until = Instant::now() + Duration::from_secs(3);
    take(&reader, see, || Instant::now() < until);
    // What is under way arrives, and an answer says how many there were.
    drop(chain);
    let until = Instant::now() + Duration::from_millis(300);
    take(&reader, |_| count += 1, || Instant::now() < until);
    let (far, near) = (sides.1.end(), sides.0.end());
    let [sent, received, lost] = ["lost; sent ", "received ", " lost "].map(|word| match word {
        "lost; sent " => number(&far, "cell: sent "),
        word => number(&far, word),
    });
    assert_eq!(sent, received + lost, "{far}");
    assert_eq!(received, count, "{far}");
    assert_eq!(sent, number(&near, "cell: sent "), "{near} {far}");
    assert!(lost > 0 && received > lost, "{far}");
    drop((reader, domain));
}

#[test]
fn either_side_may_be_killed_and_readers_go_on_by_themselves() {
    let place = Place::new();
    // The other side is there first.
    let mut far = place.connect(place.port, &[]);
    let mut reader = Reader::open_in(place.far(), &rig()).expect("a reader");
    let chain = Chain::start(&place);
    let mut near = place.listen(&[]);
    let max_age = Duration::from_millis(200);
    let until = |reader: &mut Reader, is_wanted: fn(&Seen) -> bool| {
        let deadline = Instant::now() + PATIENCE;
        loop {
            let look_up = Instant::now() + Duration::from_millis(50);
            let seen = reader.wait(look_up).expect("a reader").only_rope(max_age);
            if is_wanted(&seen) {
                break;
            }
            assert!(Instant::now() < deadline, "{seen}");
        }
    };
    let is_fresh = |seen: &Seen| matches!(seen, Seen::Fresh(_));
    let is_stale = |seen: &Seen| matches!(seen, Seen::Stale(_));
    until(&mut reader, is_fresh);
    for _ in 0..2 {
        near.kill();
        until(&mut reader, is_stale);
        near = place.listen(&[]);
        until(&mut reader, is_fresh);
        far.kill();
        until(&mut reader, is_stale);
        far = place.connect(place.port, &[]);
        until(&mut reader, is_fresh);
    }
    far.end();
    near.end();
    drop((reader, chain));
}

#[test]
fn several_machines_read_one_camera() {
    let place = Place::new();
    let other = Place::new();
    let near = place.listen(&[]);
    let places = [&place, &other];
    let far = places.map(|of| of.connect(place.port, &[]));
    let domains = places.map(Place::far);
    let readers = domains
        .each_ref()
        .map(|domain| Receiver::descriptors(domain, &rig()).expect("a reader"));
    let chain = Chain::start(&place);
    for reader in &readers {
        let came = std::cell::Cell::new(0);
        take(reader, |_| came.set(came.get() + 1), || came.get() < 20);
    }
    for side in far {
        let said = side.end();
        assert!(!said.contains("two bridges"), "{said}");
    }
    near.end();
    drop((readers, domains, chain));
}

#[test]
fn commands_come_back_and_never_late() {
    for (delay_ms, most_age, is_given) in [(1, "10s", true), (80, "50ms", false)] {
        let place = Place::new();
        let weather = Weather {
            delay: Duration::from_millis(delay_ms),
            ..Weather::default()
        };
        let relay = Relayed::start(place.port, weather);
        let near = place.listen(&["--command-age", most_age]);
        let far = place.connect(relay.port, &[]);
        let robot = CommandReader::open(place.near(), &rig()).expect("a reader");
        let domain = place.far();
        let controller =
            Writer::<Command>::create(&domain, &rig(), &COMMANDS, &Delivery::NewestWins)
                .expect("the only one");
        let mut given = Vec::new();
        let until = Instant::now()
            + if is_given {
                PATIENCE
            } else {
                Duration::from_secs(2)
            };
        for count in 1.. {
            if given.len() >= 10 || Instant::now() > until {
                break;
            }
            let mut slot = controller.slot().expect("a slot");
            *slot = Command {
                count,
                sent_ns: now_ns(),
                grippers: 1,
                velocities: [[count as f64, 0.0, 0.0]; 2],
                ..Command::default()
            };
            slot.send().expect("sent");
            // A controller's pace.
            thread::sleep(Duration::from_millis(10));
            while let Some(command) = robot.next().expect("a reader") {
                assert_eq!(command.velocities()[0][0], command.count as f64);
                given.push(command.count);
            }
        }
        assert_eq!(given.is_empty(), !is_given, "{given:?}");
        assert!(given.is_sorted_by(|a, b| a < b), "{given:?}");
        far.end();
        let said = near.end();
        assert_eq!(number(&said, "given, ") > 0, !is_given, "{said}");
        assert_eq!(said.contains("--command-age"), !is_given, "{said}");
        drop((robot, controller, domain));
    }
}

#[test]
fn centerlines_and_the_truth_come_where_they_are_asked_for() {
    let place = Place::new();
    let near = place.listen(&[]);
    let far = place.connect(place.port, &["--also", "centerlines,truth"]);
    let (here, there) = (place.far(), place.near());
    let chain = Chain::start(&place);
    let channels = [&CENTERLINES, &TRUTH];
    let writers = channels.map(|channel| {
        Writer::<Centerlines>::create(&there, &rig(), channel, &Delivery::NewestWins)
            .expect("the only one")
    });
    let readers = channels
        .map(|channel| Receiver::create_unwoken(&here, &rig(), channel, None).expect("a reader"));
    let mut came = [0; 2];
    let deadline = Instant::now() + PATIENCE;
    while came.contains(&0) {
        assert!(Instant::now() < deadline, "{came:?}");
        for (width, writer) in writers.iter().enumerate() {
            let mut slot = writer.slot().expect("a slot");
            *slot = Centerlines::EMPTY;
            (slot.width, slot.count, slot.curves[0].count) = (width as u32 + 1, 1, 3);
            slot.curves[0].points[..3].copy_from_slice(&[[0.0, 9.0], [1.0, 8.0], [2.0, 7.0]]);
            slot.trace.exposed_ns = now_ns();
            slot.send().expect("sent");
        }
        // The cameras' pace.
        thread::sleep(Duration::from_millis(20));
        for (at, reader) in readers.iter().enumerate() {
            while let Some(message) = reader.next().expect("a reader") {
                assert_eq!(message.width as usize, at + 1);
                assert_eq!(message.curves()[0].points()[2], [2.0, 7.0]);
                came[at] += 1;
            }
        }
    }
    far.end();
    near.end();
    drop((readers, writers, here, there, chain));
}

#[test]
fn frames_come_where_they_are_asked_for() {
    let place = Place::new();
    let near = place.listen(&[]);
    let far = place.connect(place.port, &["--frames", "20"]);
    let (here, there) = (place.far(), place.near());
    let (width, height) = (160, 120);
    let bytes = 3 * (width * height) as usize;
    let color = |at: usize| [(at % 160) as u8, (at / 160) as u8, 90];
    let writer = Writer::<[u8]>::frames(&there, &rig(), &Delivery::NewestWins, bytes);
    let writer = writer.expect("the only one");
    let reader = Receiver::create_unwoken(&here, &rig(), &FRAMES, None).expect("a reader");
    let (mut came, mut sequence, mut last) = (0, 0, 0);
    let deadline = Instant::now() + PATIENCE;
    while came < 3 {
        assert!(Instant::now() < deadline, "no frames come");
        sequence += 1;
        let mut slot = writer.frame_slot(bytes).expect("a slot");
        for (at, pixel) in slot.chunks_exact_mut(3).enumerate() {
            pixel.copy_from_slice(&color(at));
        }
        let header = slot.header_mut();
        *header = FrameHeader {
            width,
            height,
            stride: 3 * width,
            pixel_format: PixelFormat::Rgb8 as u32,
            ..FrameHeader::default()
        };
        (header.trace.sequence, header.trace.exposed_ns) = (sequence, now_ns());
        slot.send().expect("sent");
        // The camera's pace.
        thread::sleep(Duration::from_millis(20));
        while let Some(frame) = reader.next().expect("a reader") {
            let header = frame.header();
            assert_eq!((header.width, header.height), (width, height));
            assert!(header.trace.sequence > last);
            last = header.trace.sequence;
            // A JPEG's.
            let off = frame.chunks_exact(3).enumerate().map(|(at, pixel)| {
                let off = |i: usize| u32::from(pixel[i].abs_diff(color(at)[i]));
                off(0) + off(1) + off(2)
            });
            let off: u32 = off.sum();
            assert!(off / (width * height) < 9, "{off}");
            came += 1;
        }
    }
    far.end();
    near.end();
    drop((reader, writer, here, there));
}

/// A file with a key.
fn key(name: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("lariat-bridge-{name}-{}", std::process::id()));
    let made = Process::new(PROGRAM).arg("--make-key").arg(&path).status();
    assert!(made.expect("a process").success());
    path
}

#[test]
fn only_who_has_the_key_is_heard() {
    let keys = [key("one"), key("other")];
    let words = keys
        .each_ref()
        .map(|key| ["--key", key.to_str().expect("text")]);
    for (near_words, far_words, why) in [
        (&words[0][..], &words[0][..], None),
        (&words[0], &words[1], Some("another key")),
        (&words[0], &[], Some("--key FILE")),
        (&[], &words[0], Some("--key FILE")),
    ] {
        let place = Place::new();
        let (near, far) = (
            place.listen(near_words),
            place.connect(place.port, far_words),
        );
        let domain = place.far();
        let reader = Receiver::descriptors(&domain, &rig()).expect("a reader");
        let chain = Chain::start(&place);
        let mut count = 0;
        let until = Instant::now() + Duration::from_millis(1200);
        match why {
            None => {
                let came = std::cell::Cell::new(false);
                take(&reader, |_| came.set(true), || !came.get());
            }
            Some(_) => take(&reader, |_| count += 1, || Instant::now() < until),
        }
        assert_eq!(count, 0);
        let said = far.end() + &near.end();
        assert!(why.is_none_or(|why| said.contains(why)), "{said}");
        drop((reader, domain, chain));
    }
    for key in keys {
        std::fs::remove_file(key).expect("it is ours");
    }
}

#[test]
fn what_makes_no_sense_is_refused_with_a_sentence() {
    for (words, code, sentence) in [
        (&["--listen", "udp/0.0.0.0:7447"][..], 2, "--make-key"),
        (&["--connect", "udp/192.0.2.1:7447"], 2, "--insecure"),
        (&["--listen", "tcp/127.0.0.1:7447"], 2, "udp/192.168"),
        (
            &["--listen", "udp/192.0.2.1:7447", "--insecure"],
            1,
            "cannot be listened",
        ),
        (
            &["--connect", "udp/127.0.0.1:7447", "--key", "/nowhere"],
            1,
            "/nowhere",
        ),
    ] {
        let place = Place::new();
        let done = Process::new(PROGRAM)
            .args(words)
            .env("LARIAT_DOMAIN", &place.near)
            .output();
        let done = done.expect("a process");
        let said = String::from_utf8_lossy(&done.stderr);
        assert_eq!(done.status.code(), Some(code), "{said}");
        assert!(said.contains(sentence), "{said}");
    }
}
