//! Features that speak against a strand's continuation, its end, or the number of strands on an edge.
//!
//! A cost is the weighted sum of these features, in log-odds. `lariat-bench learn-joins` fits the
//! weights to 1,250 films and 2,240 stills with seeds from 500,000, except for those that it prints as
//! held.

macro_rules! features {
    ($($(#[$doc:meta])* $name:ident $label:literal $weight:literal;)*) => {
        #[allow(non_camel_case_types, clippy::upper_case_acronyms)]
        enum Index { $($name,)* Count }
        /// Number of features.
        pub(crate) const COUNT: usize = Index::Count as usize;
        $($(#[$doc])* pub(crate) const $name: usize = Index::$name as usize;)*
        /// Names of the features, and their weights.
        pub const FEATURES: [(&str, f32); COUNT] = [$(($label, $weight)),*];
    };
}

features! {
    /// For a join: bending energy of the cubic between both ends.
    BEND "bend" 3.9;
    /// For a join: the same beyond the arc that both strands are on.
    OFF_ARC "off arc" 4.2;
    /// For a join: squared turn to one side and back.
    S_BEND "S-bend" 2.0;
    /// For a join: squared difference of both strands' curvatures, per three widths.
    CURVATURE "curvature" 0.7;
    /// For a join: squared relative difference in width.
    WIDTH "width" 7.6;
    /// For a join: squared difference in color.
    COLOR "color" 3.0;
    /// For a join: length of the part outside of the mask, in widths.
    OUTSIDE "outside" 4.1;
    /// For a join: 1 if it changes sides in a passed edge that is too wide for a crossing, or keeps
    /// them in one that has a crossing.
    SIDES "sides" 3.0;
    /// For a join: disagreement with the prior.
    PRIOR "prior" 8.0;
    /// For an end: 1.
    END "end" 4.8;
    /// For an end: 1 if the piece has the two tips of one rope.
    END_OF_ONE "end of one" 4.8;
    /// For an end: 1 if the rope of the prior continues there.
    PRIOR_END "prior end" 8.0;
    /// For one strand on an edge: excess width times length.
    ONE_IN_WIDE "one in wide" 3.6;
    /// For several strands on an edge: lack of width times length.
    TWO_IN_NARROW "two in narrow" 2.4;
    /// For an empty edge: length in widths.
    LEFT_OUT "left out" 3.7;
    /// For an edge that one strand passes: length beyond a width, in widths.
    PASSED "passed" 1.4;
    /// For an assignment: number of rings.
    RING "ring" 4.8;
}

/// Values of all features.
pub(crate) type Features = [f32; COUNT];

/// Weighted sum of features.
pub(crate) fn cost(features: &Features) -> f32 {
    (features.iter().zip(FEATURES))
        .map(|(value, (_, weight))| value * weight)
        .sum()
}
