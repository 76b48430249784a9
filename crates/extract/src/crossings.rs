//! The crossings of the visible ropes: where the finished curves meet ([`meet`]), and which strand
//! is on top ([`over`]).

pub(crate) mod meet;
mod over;
pub(crate) mod place;

use crate::image::Image;
use crate::scene::{Crossing, Curve, MOST_CROSSINGS};
use meet::Meeter;
use over::Judge;
use place::Place;

/// Memory of the step.
#[derive(Debug, Default)]
pub(crate) struct Crosser {
    meeter: Meeter,
    judge: Judge,
}

impl Crosser {
    /// Finds the crossings of `curves` as seen in `image`.
    pub(crate) fn find(&mut self, image: &Image, curves: &[Curve], out: &mut Vec<Crossing>) {
        out.clear();
        self.meeter.find(curves);
        for meeting in self.meeter.crossings.iter().take(MOST_CROSSINGS) {
            let verdict = self.judge.judge(image, curves, [meeting.a, meeting.b]);
            let (over, under) = if verdict.second {
                (meeting.b, meeting.a)
            } else {
                (meeting.a, meeting.b)
            };
            let rho = |place: Place| place.at / curves[place.curve].intervals() as f32;
            out.push(Crossing {
                at: meeting.at,
                over: over.curve,
                under: under.curve,
                over_rho: rho(over),
                under_rho: rho(under),
                confidence: verdict.confidence,
            });
        }
    }
}
