//! Invalid requests are refused before anything moves, with a message that says what to do.

use lariat_control::{Estimator, Metric, Options, Robot, Servo, ServoError, Workspace};

const TARGET: [f64; 4] = [0.0, 0.0, 100.0, 0.0];

fn refusal(options: Options, target: &[f64]) -> String {
    Servo::new(options, target)
        .expect_err("refused")
        .to_string()
}

#[test]
fn options_out_of_range_are_refused_by_name() {
    let robot = |robot| Options::default().robot(robot);
    let cases = [
        (
            Options::default().gain(f64::NAN),
            "gain is NaN: choose from 0.001 to 100",
        ),
        (
            Options::default().damping(-0.1),
            "damping is -0.1: choose from 0 to 1",
        ),
        (
            Options::default().estimator(Estimator::Broyden { share: 1.5 }),
            "share is 1.5",
        ),
        (
            robot(Robot::default().grippers(3)),
            "grippers is 3: choose from 1 to 2",
        ),
        (robot(Robot::default().lever_px(0.0)), "lever_px is 0"),
        (
            robot(Robot::default().speeds([0.0; 3])),
            "every speed limit is 0",
        ),
        (
            robot(Robot::default().workspaces(
                [Workspace {
                    least: [0.0; 3],
                    most: [1.0, 0.0, 1.0],
                }; 2],
            )),
            "the workspace of gripper 1 is empty along y",
        ),
    ];
    for (options, sentence) in cases {
        let refusal = refusal(options, &TARGET);
        assert!(refusal.starts_with(sentence), "{refusal}");
    }
}

#[test]
fn invalid_targets_are_refused() {
    for (target, sentence) in [
        (
            vec![],
            "invalid target of 0 coordinates: give x and y of 1 to 32 points",
        ),
        (vec![1.0; 3], "invalid target of 3 coordinates"),
        (vec![1.0; 66], "invalid target of 66 coordinates"),
        (vec![1.0, f64::NAN], "coordinate 1 of the target is NaN"),
    ] {
        let refusal = refusal(Options::default(), &target);
        assert!(refusal.starts_with(sentence), "{refusal}");
    }
    let metric = Metric::bezier(8).expect("a metric");
    let options = Options::default().metric(metric);
    let sentence = "the metric is of 9 points and the target has 2: make it of the target's basis";
    assert_eq!(refusal(options, &TARGET), sentence);
    let mut servo = Servo::new(Options::default(), &TARGET).expect("good options");
    let refused = servo.aim(&[0.0; 6]);
    assert_eq!(
        refused,
        Err(ServoError::OtherTarget {
            given: 6,
            expected: 4
        })
    );
    assert!(servo.know(&[[[0.0; 3]; 2]; 3]).is_err());
    assert!(servo.know(&[[[f64::NAN; 3]; 2]; 4]).is_err());
}
