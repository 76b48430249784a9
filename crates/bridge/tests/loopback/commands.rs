//! Commands travel back to the camera's side.

use std::thread;
use std::time::{Duration, Instant};

use lariat_wire::{COMMANDS, Command, CommandReader, Delivery, Writer, now_ns};

use crate::relay::Weather;
use crate::sides::{PATIENCE, Place, Relayed, number, rig};

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
                velocities: [[count as f64, 0.0, 0.0, 0.0, 0.0, 0.0]; 2],
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
