//! Options of a report, and its errors.

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

/// Parameters of a report, apart from pictures.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Seed of all ropes and noise. Default: 1.
    pub seed: u64,
    /// Extent of each experiment. Default: [`Effort::default`].
    pub effort: Effort,
    /// Description of the machine that times are measured on. It is printed among the parameters.
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

/// Extent of each experiment: larger values leave less to chance.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Effort {
    /// Width and height of drawn pictures, px. Minimum: 160.
    pub size_px: [usize; 2],
    /// Number of ropes that are drawn and fitted.
    pub shapes: usize,
    /// Number of pictures on which the clusterings are compared. They show the first of these
    /// ropes.
    pub pictures: usize,
    /// Number of pictures for each kind of light.
    pub lights: usize,
    /// Number of ropes at rest.
    pub ropes_at_rest: usize,
    /// Frames of each rope at rest.
    pub frames_at_rest: usize,
    /// Repetitions of each timing. The median is reported.
    pub rounds: usize,
}

impl Default for Effort {
    /// Returns an effort that takes under a minute on two slow cores.
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
    /// Returns the least effort that still shows everything once. It takes some seconds and is
    /// meant for a first look and for tests.
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

/// The ropes of the experiments.
pub enum Ropes<'a> {
    /// Ropes drawn from the seed, with known ground truth.
    Drawn,
    /// Ropes in pictures. Each picture is read when it is needed. If it cannot be read, the error
    /// is a sentence that says why.
    Pictured(&'a mut dyn Iterator<Item = Result<Picture, String>>),
}

/// Errors that prevent a report.
#[derive(Debug, Error)]
pub enum PaperError {
    /// No open rope was found in any picture.
    #[error(
        "no open rope that is wholly seen was found in the {pictures}: choose pictures of one rope whose both ends are seen, \
         and see what `lariat trace` says of them", pictures = count(*.pictures, "picture", "pictures")
    )]
    NoRope {
        /// Number of pictures searched.
        pictures: usize,
    },
    /// A picture could not be obtained, for the given reason.
    #[error("{0}")]
    Picture(String),
    /// The extractor rejected a picture.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// The extractor's options are invalid.
    #[error(transparent)]
    Extraction(#[from] OptionsError),
    /// A rope could not be drawn.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A film could not be drawn.
    #[error(transparent)]
    Film(#[from] SourceError),
    /// The fitter could not be created.
    #[error(transparent)]
    Fitter(#[from] FitterError),
    /// Points could not be fitted.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// A curve is invalid.
    #[error(transparent)]
    Curve(#[from] CurveError),
    /// A filter's options are invalid.
    #[error(transparent)]
    Filter(#[from] FilterError),
    /// A filter cannot use the curve space.
    #[error(transparent)]
    Space(#[from] CurveSpaceError),
    /// A filter rejected a measurement.
    #[error(transparent)]
    Update(#[from] UpdateError),
    /// A filter could not predict.
    #[error(transparent)]
    Predict(#[from] PredictError),
    /// A drawing failed.
    #[error(transparent)]
    Plot(#[from] PlotError),
}
