//! Tests of the screen, drawn into memory.

use lariat_sink::Step;
use lariat_wire::{Place, Status};
use ratatui::Terminal;
use ratatui::backend::TestBackend;

use super::*;
use lariat_view::{InSpace, Losses, Rope, Shape, StageRow, StepRow};

fn screen(view: &View, width: u16, height: u16) -> String {
    let mut terminal = Terminal::new(TestBackend::new(width, height)).expect("memory");
    terminal
        .draw(|frame| super::draw(frame, view))
        .expect("memory takes it");
    let buffer = terminal.backend().buffer();
    let row = |y: u16| -> String {
        let cells = (0..width).map(|x| buffer[(x, y)].symbol());
        cells.collect::<String>().trim_end().to_owned()
    };
    (0..height).map(|y| row(y) + "\n").collect()
}

/// A rope in the shape of a parabola, with the control points of that curve.
fn rope(track: u32, status: Status) -> Rope {
    let y = |x: f64| 400.0 - (x - 320.0) * (x - 320.0) / 250.0;
    let points = (0..100).map(|i| 60.0 + 5.2 * f64::from(i));
    Rope {
        track,
        status: Some(status),
        basis: "bezier",
        control_point_count: 3,
        length: 761.23,
        rms: 0.456,
        confidence: 0.97,
        age_s: 0.75,
        control_points: vec![[60.0, y(60.0)], [317.4, 663.8], [574.8, y(574.8)]],
        points: points.map(|x| [x, y(x)]).collect(),
        ..Rope::default()
    }
}

fn view() -> View {
    let stage = |stage: &str, pid, cpu_percent, own_mb| StageRow {
        stage: stage.to_owned(),
        pid,
        cpu_percent: Some(cpu_percent),
        own_mb: Some(own_mb),
        frames_per_s: (stage != "sink").then_some(59.94),
    };
    let step = |(step, p50): (Step, f64)| StepRow {
        step,
        p50,
        p90: 1.5 * p50,
        p99: 4.0 * p50,
        max: 10.0 * p50,
    };
    View {
        rig: Some("left-arm".into()),
        place: (1, 2),
        shared_mb: Some(26.23),
        stages: vec![
            stage("capture", 4101, 12.34, 7.1),
            stage("extract", 4102, 95.0, 14.6),
            stage("fit", 4103, 0.4, 6.2),
            stage("sink", 4104, 0.3, 6.9),
        ],
        window_s: 3,
        steps: [
            (Step::Fitted, 190.0),
            (Step::Capture, 60.0),
            (Step::WaitExtract, 25.0),
            (Step::Extract, 60.0),
            (Step::WaitFit, 30.0),
            (Step::Fit, 15.0),
        ]
        .map(step)
        .to_vec(),
        lost: Losses {
            source: 0,
            capture: 12,
            extract: 0,
            bridge: 0,
        },
        shape: Some(Shape {
            frame: 1234,
            width: 640,
            height: 480,
            unit: "px",
            is_of_image: true,
            age_s: 0.012,
            ropes: vec![rope(0, Status::Ok)],
            reach: [0.0; 4],
        }),
        ..View::default()
    }
}

#[test]
fn everything_has_its_place_in_80_columns_and_24_rows() {
    insta::assert_snapshot!(screen(&view(), 80, 24));
}

#[test]
fn more_room_is_the_picture_s() {
    let mut view = view();
    let shape = view.shape.as_mut().expect("there");
    shape.ropes.push(Rope {
        points: vec![[100.0, 60.0], [500.0, 60.0]],
        control_points: vec![[100.0, 60.0], [500.0, 60.0]],
        ..rope(7, Status::Lost)
    });
    view.is_paused = true;
    view.is_lossless = true;
    insta::assert_snapshot!(screen(&view, 120, 40));
}

#[test]
fn a_coarse_curve_a_doubtful_rope_and_low_confidence_stand_out() {
    let mut view = view();
    let shape = view.shape.as_mut().expect("there");
    shape.ropes[0].is_coarse = true;
    shape.ropes.push(Rope {
        confidence: 0.31,
        ..rope(1, Status::Doubtful)
    });
    let mut terminal = Terminal::new(TestBackend::new(80, 24)).expect("memory");
    terminal
        .draw(|frame| super::draw(frame, &view))
        .expect("memory takes it");
    let cells = terminal.backend().buffer().content();
    let colored = |color: Color| {
        let cells = cells.iter().filter(|cell| cell.fg == color);
        cells.map(|cell| cell.symbol()).collect::<String>()
    };
    assert!(colored(Color::Red).contains(", coarse"));
    assert!(colored(Color::Yellow).contains("0.31  doubtful"));
    assert!(!colored(Color::Yellow).contains("0.97"));
}

#[test]
fn what_is_known_in_space_stands_below_each_rope() {
    let mut view = view();
    let said = |place, view: &mut View| {
        let in_space = InSpace {
            place: Some(place),
            length_mm: 548.94,
        };
        let shape = view.shape.as_mut().expect("there is one");
        shape.ropes[0].in_space = Some(in_space);
        screen(view, 120, 40)
    };
    assert!(!screen(&view, 120, 40).contains("in space"));
    let known = said(Place::Known, &mut view);
    assert!(known.contains("548.9 mm in space"), "{known}");
    let thin = said(Place::Thin, &mut view);
    assert!(
        thin.contains("in space: thin") && !thin.contains("548.9"),
        "{thin}"
    );
}

#[test]
fn without_a_chain_it_says_what_it_waits_for() {
    let view = View {
        obstacle: Some(
            "No chain is running here: start one with `lariat run`; this screen waits for it."
                .into(),
        ),
        window_s: 3,
        ..View::default()
    };
    insta::assert_snapshot!(screen(&view, 60, 12));
}

#[test]
fn a_camera_that_is_gone_and_a_chain_that_is_silent_are_told() {
    let mut view = view();
    let shape = view.shape.as_mut().expect("there");
    (shape.width, shape.height, shape.age_s) = (0, 0, 7.2);
    shape.ropes[0].status = Some(Status::Lost);
    shape.reach = [60.0, 100.0, 600.0, 700.0];
    view.steps.clear();
    let screen = screen(&view, 80, 24);
    for said in [
        "no image",
        "silent for 7 s",
        "lost for 0.8 s",
        "no frame with an image",
    ] {
        assert!(screen.contains(said), "{screen}");
    }
}

#[test]
fn how_well_another_machine_s_clock_is_known_and_what_was_lost_on_the_way_is_told() {
    let mut view = view();
    assert!(!screen(&view, 120, 24).contains("of clock"));
    view.clock_bound_us = Some(41.6);
    view.lost.bridge = 208;
    let screen = screen(&view, 120, 24);
    assert!(screen.contains("± 41.6 µs of clock"));
    assert!(screen.contains("source extract   fit  here"), "{screen}");
    assert!(screen.contains("     0      12     0   208"), "{screen}");
}

#[test]
fn no_size_is_too_small_and_no_number_too_wild() {
    let mut view = view();
    let shape = view.shape.as_mut().expect("there");
    shape.ropes[0].control_points = vec![[f64::NAN, 1.0], [f64::INFINITY, -1e300]];
    shape.is_of_image = false;
    shape.reach = [f64::MIN, 0.0, f64::MAX, 0.0];
    view.stages.extend(vec![StageRow::default(); 20]);
    for (width, height) in [(0, 0), (1, 1), (10, 3), (40, 10), (80, 9), (300, 100)] {
        screen(&view, width, height);
    }
}
