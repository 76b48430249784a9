//! What is asked of a report, and what can be wrong.

use lariat_capture::SourceError;
use lariat_drawn::scenes::SceneError;
use lariat_extract::{ImageError, OptionsError};
use lariat_fit::{
    CurveError, CurveSpaceError, FilterError, FitError, FitterError, PredictError, UpdateError,
};
use lariat_plot::PlotError;
use lariat_plot::words::count;
use thiserror::Error;

use crate::Picture;

/// What a report is made from, beside pictures.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Which of all ropes and noises. Default: 1.
    pub seed: u64,
    /// How much of each experiment is made. Default: [`Effort::default`].
    pub effort: Effort,
    /// The machine that times are measured on, in words; printed among the parameters.
    pub machine: Option<String>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            seed: 1,
            effort: Effort::default(),
            machine: None,
        }
    }
}

/// How much of each experiment is made: the more, the less chance is in its numbers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Effort {
    /// Width and height of drawn pictures, px; 160 at least.
    pub size_px: [usize; 2],
    /// Ropes that are drawn and fitted.
    pub shapes: usize,
    /// The first pictures of these, on which the clusterings are compared.
    pub pictures: usize,
    /// Pictures of each kind of light.
    pub lights: usize,
    /// Ropes at rest.
    pub ropes_at_rest: usize,
    /// Frames of each.
    pub frames_at_rest: usize,
    /// Measurements of each time, of which the median is taken.
    pub rounds: usize,
}

impl Default for Effort {
    /// Under a minute on two slow cores.
    fn default() -> Self {
        Self {
            size_px: [640, 480],
            shapes: 120,
            pictures: 20,
            lights: 8,
            ropes_at_rest: 4,
            frames_at_rest: 150,
            rounds: 15,
        }
    }
}

impl Effort {
    /// As little as shows everything once, in some seconds: for a first look, and for tests.
    pub fn least() -> Self {
        Self {
            size_px: [240, 180],
            shapes: 8,
            pictures: 1,
            lights: 2,
            ropes_at_rest: 1,
            frames_at_rest: 40,
            rounds: 3,
        }
    }
}

/// What the experiments are made on.
pub enum Ropes<'a> {
    /// Ropes that are drawn by the seed, so that the truth is known.
    Drawn,
    /// Those in pictures, each read when it is needed; or why one cannot be, as a sentence.
    Pictured(&'a mut dyn Iterator<Item = Result<Picture, String>>),
}

/// Why there is no report.
#[derive(Debug, Error)]
pub enum PaperError {
    /// No open rope was seen in any picture.
    #[error(
        "no open rope that is wholly seen was found in the {pictures}: choose pictures of one rope whose both ends are seen, \
         and see what `lariat trace` says of them", pictures = count(*.pictures, "picture", "pictures")
    )]
    NoRope {
        /// How many were looked at.
        pictures: usize,
    },
    /// A picture that cannot be had, and why.
    #[error("{0}")]
    Picture(String),
    /// A picture that the extractor does not take.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// The extractor's options.
    #[error(transparent)]
    Extraction(#[from] OptionsError),
    /// A rope that cannot be drawn.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A film that cannot be drawn.
    #[error(transparent)]
    Film(#[from] SourceError),
    /// A curve that cannot be fitted at all.
    #[error(transparent)]
    Fitter(#[from] FitterError),
    /// Points that cannot be fitted.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// An invalid curve.
    #[error(transparent)]
    Curve(#[from] CurveError),
    /// A filter's options.
    #[error(transparent)]
    Filter(#[from] FilterError),
    /// A filter's curves.
    #[error(transparent)]
    Space(#[from] CurveSpaceError),
    /// A filter's measurement.
    #[error(transparent)]
    Update(#[from] UpdateError),
    /// A filter's answer.
    #[error(transparent)]
    Predict(#[from] PredictError),
    /// A drawing failed.
    #[error(transparent)]
    Plot(#[from] PlotError),
}
