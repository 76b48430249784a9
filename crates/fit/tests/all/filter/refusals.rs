//! Refusals of a filter and their messages. The filter is unchanged afterwards.

use crate::dense::Dense;
use faer::{Mat, MatRef};
use lariat_fit::{CurveSpace, Filter, FilterOptions, Noise};
use proptest::prelude::*;

fn space() -> CurveSpace {
    CurveSpace::new(Dense::bezier(2, 20).matrix()).unwrap()
}

const SHAPE: [[f64; 2]; 3] = [[0.0, 0.0], [10.0, 5.0], [20.0, 0.0]];
const EVEN: Noise = Noise::Even { variance_px2: 0.1 };

#[test]
fn spaces_that_are_none_say_why() {
    let refusal = |b: MatRef<'_, f64>| CurveSpace::new(b).unwrap_err().to_string();
    let ones = |rows, columns| Mat::from_fn(rows, columns, |_, _| 1.0);
    assert_eq!(
        refusal(ones(40, 33).as_ref()),
        "a curve cannot have 33 control points: choose from 1 to 32"
    );
    assert_eq!(
        CurveSpace::of_points(0).unwrap_err().to_string(),
        "a curve cannot have 0 control points: choose from 1 to 32"
    );
    assert!(CurveSpace::of_points(usize::MAX).is_err());
    assert_eq!(
        refusal(ones(2, 3).as_ref()),
        "B has 2 rows for 3 control points: give a row for each point, 3 to 256 of them"
    );
    assert!(CurveSpace::new(ones(257, 3).as_ref()).is_err());
    assert_eq!(
        refusal(MatRef::from_row_major_slice(
            &[1.0, 0.0, 0.0, f64::NAN],
            2,
            2
        )),
        "row 1 of B has no finite number in column 1: give B as it is evaluated"
    );
    assert_eq!(
        refusal(Dense::bezier(31, 32).matrix()),
        "the condition number of B is 2.34e12, and control points can only be trusted up to 4.5e9: choose fewer control points"
    );
    assert!(CurveSpace::new(Mat::zeros(4, 2).as_ref()).is_err());
    assert!(CurveSpace::new(Mat::zeros(8, 1).as_ref()).is_err());
}

#[test]
fn filters_that_cannot_be_say_why() {
    let refusal = |count, options| match Filter::<2>::new(count, options) {
        Ok(_) => panic!("it was made"),
        Err(error) => error.to_string(),
    };
    let usual = FilterOptions::default();
    assert_eq!(
        refusal(33, usual),
        "a filter cannot be made for 33 control points: choose from 1 to 32"
    );
    let acceleration_px_s2 = -1.0;
    assert_eq!(
        refusal(9, usual.acceleration_px_s2(acceleration_px_s2)),
        "the filter's acceleration_px_s2 cannot be -1: choose from 0 to 10000000"
    );
    let gate_sigma = f64::NAN;
    assert_eq!(
        refusal(9, usual.gate_sigma(gate_sigma)),
        "the filter's gate_sigma cannot be NaN: choose from 1 to inf"
    );
}

#[test]
fn shapes_that_cannot_be_taken_in_say_why_and_change_nothing() {
    let space = space();
    let mut filter = Filter::<2>::new(3, FilterOptions::default()).unwrap();
    assert_eq!(
        filter.predict(5).unwrap_err().to_string(),
        "nothing can be predicted before the first shape: call update first"
    );
    filter.update(1000, &space, &SHAPE, EVEN).unwrap();
    let before = filter.predict(2000).unwrap().clone();
    let mut refusal = |t_ns, space: &CurveSpace, shape: &[[f64; 2]], noise| {
        filter
            .update(t_ns, space, shape, noise)
            .unwrap_err()
            .to_string()
    };
    for t_ns in [999, 1000] {
        assert_eq!(
            refusal(t_ns, &space, &SHAPE, EVEN),
            format!(
                "a shape of {t_ns} ns cannot follow one of 1000 ns: give shapes in the order of their images, or call forget first"
            )
        );
    }
    assert_eq!(
        refusal(2000, &space, &SHAPE[..2], EVEN),
        "2 control points were given for a space of curves that have 3"
    );
    assert_eq!(
        refusal(
            2000,
            &CurveSpace::of_points(4).unwrap(),
            &[[0.0; 2]; 4],
            EVEN
        ),
        "4 control points were given to a filter made for at most 3: make it for more"
    );
    assert_eq!(
        refusal(2000, &space, &[SHAPE[0], SHAPE[1], [f64::NAN, 1.0]], EVEN),
        "control point 2 is not a position: all its numbers must be finite and below 1e12 px in size"
    );
    assert_eq!(
        refusal(2000, &space, &SHAPE, Noise::Even { variance_px2: -0.5 }),
        "invalid variance or covariance -0.5 px²: all must be finite and at most 1e18 px² in size, and variances not negative"
    );
    assert_eq!(
        refusal(2000, &space, &SHAPE, Noise::Covariance(&[1.0; 8])),
        "a covariance of 8 numbers was given for 3 control points: give all 9 of its rows, one after the other"
    );
    let indefinite = [1.0, 5.0, 0.0, 5.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    assert_eq!(
        refusal(2000, &space, &SHAPE, Noise::Covariance(&indefinite)),
        "the covariance of the control points is not positive semidefinite: some combination of them would have a negative variance"
    );
    assert_eq!(
        filter.predict(1_000_000_000).unwrap_err().to_string(),
        "1000000000 ns is 1.000 s from the last shape, and predictions are made up to 0.5 s: ask for a nearer moment, or raise longest_gap_s"
    );
    assert_eq!(filter.predict(2000).unwrap(), &before);
}

#[test]
fn a_covariance_that_rounding_has_emptied_is_refused() {
    let b = Dense::bezier(31, 256);
    let space = CurveSpace::new(b.matrix()).unwrap();
    let mut filter = Filter::<2>::new(32, FilterOptions::default()).unwrap();
    let shape = [[1.0, 2.0]; 32];
    let noise = Noise::Covariance(&[0.0; 32 * 32]);
    let refusal = filter.update(1, &space, &shape, noise).unwrap_err();
    assert!(
        refusal
            .to_string()
            .ends_with("give Noise::Even, or choose fewer control points")
    );
    assert!(filter.update(1, &space, &shape, EVEN).is_ok());
}

proptest! {
    #[test]
    fn any_numbers_at_all_are_taken_in_or_refused(
        shapes in prop::collection::vec(
            (any::<u64>(), prop::array::uniform3(prop::array::uniform2(prop::num::f64::ANY)),
             prop::array::uniform9(prop::num::f64::ANY), prop::num::f64::ANY),
            1..6,
        ),
        moment in any::<u64>(),
    ) {
        let space = space();
        let mut filter = Filter::<2>::new(3, FilterOptions::default()).unwrap();
        for (t_ns, shape, covariance, variance_px2) in shapes {
            let _ = filter.update(t_ns, &space, &shape, Noise::Covariance(&covariance));
            let _ = filter.update(t_ns, &space, &SHAPE, Noise::Even { variance_px2 });
            let _ = filter.update(t_ns.saturating_add(9), &space, &shape, EVEN);
        }
        if let Ok(found) = filter.predict(moment) {
            prop_assert!(found.control_points.iter().flatten().all(|c| c.is_finite()));
            prop_assert!(found.covariance_px2.iter().all(|c| c.is_finite()));
        }
    }
}
