//! The measurements, their order and their duration.

use std::time::Duration;

use super::BenchArgs;
use super::chain::Setup;
use super::choice::{Rate, knows, setups};
use super::figures::{Group, Item, Outcome};
use super::floors::{Pass, Sleep};
use super::guard::fifo_allowed;
use super::job::{Job, What};
use super::relay::Arrangement;
use super::rivals::Script;
use super::workplace::Workplace;

/// Size and rate of the comparisons.
pub(super) const SIZE: [u32; 2] = [640, 480];
pub(super) const FPS: f64 = 120.0;
/// Size and rate at which no frame may be lost.
pub(super) const FAST: ([u32; 2], Rate) = (SIZE, Some(1000.0));
/// A rate that Python scripts can sustain. Above it, a script falls behind more and more.
const SCRIPT_FPS: f64 = 30.0;

/// Name of the timer floor under FIFO.
pub(super) const TIMER_FIFO: &str = "timer.fifo";

/// All measurements and their results.
pub(super) struct Plan {
    pub(super) rounds: u32,
    pub(super) jobs: Vec<Job>,
    pub(super) items: Vec<Item>,
    /// Size and rate of the comparisons.
    pub(super) base: ([u32; 2], f64),
    /// Factor that scales the usual durations.
    stretch: f64,
}

impl Plan {
    pub(super) fn new(args: &BenchArgs, workplace: &Workplace) -> Self {
        let setups = setups(args);
        let size = setups.first().map_or(SIZE, |&(size, _)| size);
        let rates = || setups.iter().filter_map(|&(_, rate)| rate);
        let fps = rates().find(|&fps| fps == FPS).or_else(|| rates().next());
        let mut plan = Self {
            rounds: args.rounds.unwrap_or(if args.quick { 1 } else { 5 }),
            jobs: Vec::new(),
            items: Vec::new(),
            base: (size, fps.unwrap_or(FPS)),
            stretch: match (args.quick, args.full) {
                (true, _) => 0.15,
                (_, true) => 5.0,
                _ => 0.5,
            },
        };
        plan.add_floors(args, workplace, &setups);
        plan.add_chains(args, &setups);
        plan.add_rivals();
        plan
    }

    fn push(&mut self, item: Item, what: What, usual_s: f64, optional: bool) {
        self.jobs.push(Job {
            item: self.items.len(),
            what,
            time: Duration::from_secs_f64(usual_s * self.stretch),
            optional,
        });
        self.items.push(item);
    }

    fn floor(&mut self, id: &str, title: String, note: &'static str, what: What, usual_s: f64) {
        let item = Item::new(format!("floor.{id}"), Group::Floor, title, note);
        self.push(item, what, usual_s, false);
    }

    fn add_floors(&mut self, args: &BenchArgs, workplace: &Workplace, setups: &[([u32; 2], Rate)]) {
        let mut sizes: Vec<[u32; 2]> = setups.iter().map(|&(size, _)| size).collect();
        sizes.dedup();
        for [width, height] in sizes {
            let named = format!("{width}x{height}");
            let (read, copy) = (format!("read.{named}"), format!("copy.{named}"));
            let frame = format!("{width}×{height}, RGB");
            let (note, size) = (
                "one thread, by the widest loads, from the cache if it fits",
                [width, height],
            );
            self.floor(
                &read,
                format!("read {frame}"),
                note,
                What::Pass(Pass::Read, size),
                0.05,
            );
            self.floor(
                &copy,
                format!("copy {frame}"),
                note,
                What::Pass(Pass::Copy, size),
                0.05,
            );
        }
        let (first, last) = (workplace.cores.first(), workplace.cores.last());
        for (cores, id, place) in [
            ([last, last], "one_core", "on one core"),
            ([first, last], "across_cores", "across cores"),
        ] {
            let [Some(&from), Some(&to)] = cores else {
                continue;
            };
            if id == "across_cores" && from == to {
                continue;
            }
            for (sleep, kind) in [(Sleep::Futex, "futex"), (Sleep::Eventfd, "eventfd")] {
                let title = format!("wake {place}, {kind}");
                let note = "from the one's call to the other's return, to and fro";
                self.floor(
                    &format!("wake.{kind}.{id}"),
                    title,
                    note,
                    What::Wake(sleep, [from, to]),
                    0.1,
                );
            }
        }
        self.floor(
            "arithmetic",
            "the same arithmetic".to_owned(),
            "40,000 additions and products in registers, again and again: what of them takes longer, the machine does",
            What::Arithmetic,
            2.0,
        );
        self.add_timers(workplace);
        self.add_relays(args, setups);
    }

    /// Adds the timers. They wake at the highest frame rate, so that the maxima of timers and
    /// chains can be compared.
    fn add_timers(&mut self, workplace: &Workplace) {
        let note = "an absolute moment every millisecond, 1 ns of leeway asked for";
        let title = "wake at a moment: how late";
        self.floor("timer", title.to_owned(), note, What::Timer(None), 2.0);
        let title = format!("{title}, FIFO");
        self.floor(
            TIMER_FIFO,
            title,
            note,
            What::Timer(workplace.cores.last().copied()),
            2.0,
        );
        if let (Err(why), Some(item)) = (fifo_allowed(), self.items.last_mut()) {
            item.missing = Some(why);
        }
    }

    /// Adds the four processes with 64 bytes, at the rate of the comparisons and at the highest
    /// rate.
    fn add_relays(&mut self, args: &BenchArgs, setups: &[([u32; 2], Rate)]) {
        let mut rates = vec![self.base.1];
        let highest = setups
            .iter()
            .filter_map(|&(_, rate)| rate)
            .fold(0.0, f64::max);
        if highest > self.base.1 && !args.quick {
            rates.push(highest);
        }
        let fifo = fifo_allowed();
        for fps in rates {
            // Enough messages that one or two are beyond the 99th percentile.
            let usual_s = (205.0 / fps).max(0.5);
            for arrangement in Arrangement::ALL {
                // One of each kind is enough for a quick run.
                if args.quick
                    && !matches!(
                        arrangement,
                        Arrangement::Free | Arrangement::OneCore { fifo: false }
                    )
                {
                    continue;
                }
                let mut item = Item::new(
                    format!("floor.relay.{}@{fps}", arrangement.id()),
                    Group::Floor,
                    format!("four processes, {fps}/s, {}", arrangement.title()),
                    "64 bytes over three hops of bare iceoryx2, woken by its events; from when a message is due",
                );
                if let (true, Err(why)) = (arrangement.is_fifo(), &fifo) {
                    item.missing = Some(why.clone());
                }
                self.push(
                    item,
                    What::Relay(arrangement, fps),
                    usual_s,
                    arrangement.is_fifo(),
                );
            }
        }
    }

    fn add_chains(&mut self, args: &BenchArgs, setups: &[([u32; 2], Rate)]) {
        let plain = |size, fps| Setup {
            size,
            fps,
            flags: args.flags.clone(),
            variant: None,
            load: false,
            second: false,
        };
        for &(size, fps) in setups {
            let usual_s = match fps {
                Some(fps) if fps == self.base.1 => 3.0,
                Some(fps) if fps >= 1000.0 && args.full && size == SIZE => 2.4,
                _ => 2.0,
            };
            self.chain(plain(size, fps), usual_s);
            let is_base = (size, fps) == (self.base.0, Some(self.base.1));
            if is_base || (size, fps) == FAST {
                self.add_variants(args, &plain(size, fps), is_base, usual_s);
            }
        }
        let (size, fps) = self.base;
        let base = plain(size, Some(fps));
        let item = Item::new(
            "chain.start".to_owned(),
            Group::Chain,
            "from the command to the first descriptor".to_owned(),
            "resident: half a second later, what is shared counted once",
        );
        self.push(item, What::Start(base), 1.0, false);
        let item = Item::new(
            "chain.idle".to_owned(),
            Group::Chain,
            "while no frames come".to_owned(),
            "extract, fit and sink, without capture",
        );
        self.push(item, What::Idle, 2.0, false);
    }

    /// Adds the same chain with other flags and under other conditions.
    fn add_variants(&mut self, args: &BenchArgs, plain: &Setup, is_base: bool, usual_s: f64) {
        for variant in ["realtime", "fuse"] {
            // Only flags that this release has and that the user did not give already.
            let is_given = args
                .flags
                .iter()
                .any(|flag| flag[..].trim_start_matches('-') == variant);
            if !knows(variant) || is_given || args.quick || !(is_base || variant == "realtime") {
                continue;
            }
            let varied = Setup {
                variant: Some(variant),
                ..plain.clone()
            };
            self.chain(varied.clone(), usual_s);
            if args.load && variant == "realtime" {
                self.chain(
                    Setup {
                        load: true,
                        ..varied
                    },
                    usual_s,
                );
            }
        }
        if args.load {
            self.chain(
                Setup {
                    load: true,
                    ..plain.clone()
                },
                usual_s,
            );
        }
        if is_base && !args.quick {
            self.chain(
                Setup {
                    second: true,
                    ..plain.clone()
                },
                usual_s,
            );
        }
    }

    fn chain(&mut self, setup: Setup, usual_s: f64) {
        let [width, height] = setup.size;
        let rate = setup.fps.map_or("max".to_owned(), |fps| fps.to_string());
        let mut id = format!("chain.{width}x{height}@{rate}");
        let mut title = match setup.fps {
            Some(fps) => format!("{width}×{height}, {fps}/s"),
            None => format!("{width}×{height}, as fast as it goes"),
        };
        if let Some(variant) = setup.variant {
            id += &format!(".{variant}");
            title += &format!(" --{variant}");
        }
        if setup.load {
            id += ".load";
            title += ", every core busy";
        }
        if setup.second {
            id += ".second_rig";
            title += ", a second rig beside it";
        }
        let note =
            "four processes, three hops, the frame drawn into shared memory and never copied";
        let item = Item::new(id, Group::Chain, title, note);
        self.push(item, What::Chain(setup), usual_s, false);
    }

    fn add_rivals(&mut self) {
        let (size, fps) = self.base;
        let mut rival = |id: &str, title: String, note, what, optional| {
            let item = Item::new(format!("rival.{id}"), Group::Rival, title, note);
            self.push(item, what, 2.0, optional);
        };
        rival(
            "threads",
            format!("threads and channels, {fps}/s"),
            "the same stages in one process; buffers change hands, nothing is copied",
            What::Threads(size, fps),
            false,
        );
        rival(
            "sockets",
            format!("Unix sockets, {fps}/s"),
            "the same stages in four processes; the frame is copied twice, what is made of it sent as bytes",
            What::Sockets(size, fps),
            false,
        );
        for script in Script::ALL {
            let (title, note, fps) = match script {
                Script::Zmq => (
                    "ZeroMQ from Python",
                    "no work: four processes pass on a frame, 26 kB and 15 kB; the frame is copied in the kernel",
                    fps,
                ),
                Script::Zenoh => (
                    "zenoh shared memory from Python",
                    "no work: four processes pass on a frame, 26 kB and 15 kB; the frame is copied once",
                    fps,
                ),
                Script::Chain => (
                    "OpenCV and NumPy",
                    "the same work as users of these script it, in one process: no hop",
                    SCRIPT_FPS.min(fps),
                ),
            };
            let title = format!("{title}, {fps}/s");
            rival(
                script.id(),
                title,
                note,
                What::Script(script, size, fps),
                true,
            );
        }
    }

    pub(super) fn item(&self, job: usize) -> &Item {
        &self.items[self.jobs[job].item]
    }

    /// Returns true unless the item is already known to be missing.
    pub(super) fn is_wanted(&self, job: usize) -> bool {
        self.item(job).missing.is_none()
    }

    /// Marks the item as missing, for this reason.
    pub(super) fn give_up(&mut self, job: usize, why: &str) {
        self.items[self.jobs[job].item].missing = Some(why.to_owned());
    }

    pub(super) fn add(&mut self, job: usize, outcome: Outcome) {
        self.items[self.jobs[job].item].add(outcome);
    }

    /// Returns the relay of 64 bytes in the arrangement that is best in `figure`, at the rate
    /// nearest to `rate`.
    pub(super) fn relay_floor(&self, rate: Rate, figure: &str) -> Option<&Item> {
        let relays = self.jobs.iter().filter_map(|job| match job.what {
            What::Relay(_, fps) => Some((fps, &self.items[job.item])),
            _ => None,
        });
        let relays = relays.filter(|(_, item)| item.figure(figure).is_some());
        // "As fast as possible" is compared with the highest rate.
        let wanted = rate.unwrap_or(f64::MAX).ln();
        let median = |item: &Item| item.median(figure).unwrap_or(f64::INFINITY);
        relays
            .min_by(|(fps, item), (other_fps, other)| {
                let apart = |fps: f64| (fps.ln() - wanted).abs();
                let nearer = apart(*fps).total_cmp(&apart(*other_fps));
                nearer.then(median(item).total_cmp(&median(other)))
            })
            .map(|(_, item)| item)
    }

    /// Adds the ratio of the chain's overhead to the floor, round by round.
    pub(super) fn compare_with_the_floor(&mut self) {
        let mut found = Vec::new();
        for job in &self.jobs {
            let What::Chain(setup) = &job.what else {
                continue;
            };
            let item = &self.items[job.item];
            for (ratio, ours, theirs) in [
                ("overhead_to_floor_p50", "overhead_p50_us", "p50_us"),
                ("overhead_to_floor_p99", "overhead_p99_us", "p99_us"),
                ("links_to_floor_p50", "links_p50_us", "sent_p50_us"),
                ("links_to_floor_p99", "links_p99_us", "sent_p99_us"),
            ] {
                let floor = self.relay_floor(setup.fps, theirs);
                let theirs = floor.and_then(|floor| floor.figure(theirs));
                if let (Some(ours), Some(theirs)) = (item.figure(ours), theirs) {
                    let rounds = ours.rounds.iter().zip(&theirs.rounds);
                    found.extend(rounds.map(|(ours, theirs)| (job.item, ratio, ours / theirs)));
                }
            }
        }
        for (item, name, ratio) in found {
            self.items[item].add_figure(name, ratio);
        }
    }

    /// Returns the chain at this size and rate whose name ends in `behind`.
    pub(super) fn chain_at(
        &self,
        [width, height]: [u32; 2],
        fps: f64,
        behind: &str,
    ) -> Option<&Item> {
        let id = format!("chain.{width}x{height}@{fps}{behind}");
        self.items.iter().find(|item| item.id == id)
    }
}
