//! The measurements behind the figures that lariat claims, in `benches/`. Each prints its figure beside a floor of the
//! same run, so that what counts is the ratio.
//!
//! `cargo bench -p lariat-bench --bench fit`: one fit, beside the bare multiply-adds.
