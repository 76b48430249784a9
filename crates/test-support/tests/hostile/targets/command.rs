//! Commands that the simulated robot receives.

use std::cell::RefCell;

use lariat_simulation::{Options, Simulation, SpaceSimulation};
use lariat_wire::fields::Message as _;
use lariat_wire::{COMMANDS, Command, CommandReader, Delivery, MAX_GRIPPERS, Writer, now_ns};

use super::edit::edit_all;
use super::input::Input;
use super::rig::Place;

/// Number of steps after a command, enough for it to have an effect.
const STEPS: usize = 20;

/// A writer of a rig, a reader, and ropes at rest.
struct Bench {
    writer: Writer<Command>,
    reader: CommandReader,
    at_rest: Simulation,
    lifted: SpaceSimulation,
    /// Dropped last.
    _place: Place,
}

impl Bench {
    fn new() -> Self {
        let place = Place::new();
        let (domain, rig) = (place.domain(), &place.rig);
        let writer = Writer::<Command>::create(&domain, rig, &COMMANDS, &Delivery::NewestWins);
        let at_rest = Simulation::new(&Options::default());
        let lifted = SpaceSimulation::new(&Options::default());
        Self {
            writer: writer.expect("the rig's only writer"),
            reader: CommandReader::open(domain, rig).expect("a reader"),
            at_rest: at_rest.expect("options that make sense"),
            lifted: lifted.expect("options that make sense"),
            _place: place,
        }
    }
}

thread_local! {
    static BENCH: RefCell<Bench> = RefCell::new(Bench::new());
}

/// Sends a command, which the simulated robot follows as far as possible.
///
/// # Panics
/// Panics if an invariant does not hold.
pub fn command(bytes: &[u8]) {
    let mut message = Command {
        count: 1,
        sent_ns: now_ns(),
        grippers: 2,
        velocities: [
            [20.0, 0.0, 5.0, 0.1, 0.0, 0.3],
            [-20.0, 5.0, 0.0, 0.0, -0.2, -0.3],
        ],
        ..Command::EMPTY
    };
    edit_all(&mut message, &mut Input(bytes));
    BENCH.with_borrow(|bench| {
        let (mut simulation, mut lifted) = (bench.at_rest.clone(), bench.lifted.clone());
        let mut slot = bench.writer.slot().expect("a slot");
        *slot = message;
        slot.send().expect("sent");
        let command = bench
            .reader
            .next()
            .expect("readable")
            .expect("it has just come");
        assert!(command.velocities().len() <= MAX_GRIPPERS);
        assert!(!command.fields().is_empty());
        let in_plane = |&[x, y, .., turn]: &[f64; 6]| [x, y, turn];
        let flat: Vec<_> = command.velocities().iter().map(in_plane).collect();
        simulation.command(&flat);
        lifted.command(command.velocities());
        for _ in 0..STEPS {
            simulation.step();
            lifted.step();
        }
        let nodes = simulation.nodes().as_flattened().iter();
        let mut all = nodes.chain(lifted.nodes().as_flattened());
        assert!(all.all(|coordinate| coordinate.is_finite()));
        let velocities = simulation.velocities().iter().flatten();
        assert!(velocities.into_iter().all(|velocity| velocity.is_finite()));
    });
}
