//! Failures, their messages and their exit codes.

use emitree::RenderError;
use emitree::world_tree::WorldTreeError;
use emitree_instrument::{ObservationError, PoissonError};
use emitree_io::{
    ComparisonError, EmissionFailure, EncodeError, FitsEncodeError, LargeError, OutputError,
    PlannedError, SceneError, UnknownEnding,
};
use miette::{GraphicalReportHandler, GraphicalTheme};
use std::convert::Infallible;
use std::io::{IsTerminal, Write};
use std::process::ExitCode;

/// Two images differ by more than is allowed.
pub(crate) const DIFFERS: u8 = 1;
/// The scene or the options are wrong.
const BAD_REQUEST: u8 = 2;
/// The emission failed, or was not finite somewhere.
const BAD_EMISSION: u8 = 3;
/// The budget ended before the tolerance was met; the image was written all the same.
pub(crate) const BUDGET_ENDED: u8 = 4;
/// A planned run needs the rates of more points.
pub(crate) const NEEDS_RATES: u8 = 5;
/// The code of shells for a program ended by Ctrl-C: 128 + SIGINT.
const INTERRUPTED: u8 = 130;

/// Why a command failed.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Render(#[from] RenderError<EmissionFailure>),
    /// A rendering of a problem with an exact image, which can't fail by itself.
    #[error(transparent)]
    Problem(#[from] RenderError<Infallible>),
    #[error(transparent)]
    Tree(#[from] WorldTreeError<EmissionFailure>),
    #[error("expected counts: {0}")]
    Observation(#[from] ObservationError),
    #[error("--counts: {0}")]
    Poisson(#[from] PoissonError),
    #[error(transparent)]
    Planned(#[from] PlannedError),
    #[error(transparent)]
    Output(#[from] OutputError),
    #[error("output: {0}")]
    Ending(#[from] UnknownEnding),
    #[error(transparent)]
    Fits(#[from] FitsEncodeError),
    #[error(transparent)]
    Large(#[from] LargeError<EmissionFailure>),
    #[error(transparent)]
    Encode(#[from] EncodeError),
    #[error(transparent)]
    Figure(#[from] emitree_io::figure::FigureError),
    #[error(transparent)]
    Comparison(#[from] ComparisonError),
    #[error("{0}")]
    Request(String),
    /// One image of several failed.
    #[error("{label}: {failure}")]
    Image { label: String, failure: Box<Self> },
    #[error("can't write to the terminal: {0}")]
    Terminal(#[from] std::io::Error),
}

fn code_of<E>(error: &RenderError<E>) -> u8 {
    match error {
        RenderError::NotFinite { .. }
        | RenderError::AbsorptionNotFinite { .. }
        | RenderError::ImageNotFinite { .. }
        | RenderError::Emission(_) => BAD_EMISSION,
        RenderError::Interrupted => INTERRUPTED,
        _ => BAD_REQUEST,
    }
}

impl Failure {
    /// The failure of one image of several.
    pub(crate) fn of_image(self, label: String) -> Self {
        Self::Image { label, failure: Box::new(self) }
    }

    /// The exit code.
    pub(crate) fn code(&self) -> u8 {
        match self {
            Self::Tree(WorldTreeError::Directional { .. }) => BAD_EMISSION,
            Self::Render(error) | Self::Tree(WorldTreeError::Render(error)) => code_of(error),
            Self::Problem(error) => code_of(error),
            Self::Large(LargeError::Render(error)) => code_of(error),
            Self::Planned(PlannedError::Render(error)) => code_of(error),
            Self::Planned(PlannedError::NotFinite { .. }) => BAD_EMISSION,
            Self::Image { failure, .. } => failure.code(),
            _ => BAD_REQUEST,
        }
    }

    /// Prints the message, and returns the exit code.
    pub(crate) fn report(&self) -> ExitCode {
        let mut stderr = std::io::stderr().lock();
        // The code is returned even if the message can't be written.
        let _ = match self {
            // A reader that has closed the pipe (`emitree models | head`) is no failure.
            Self::Terminal(error) if error.kind() == std::io::ErrorKind::BrokenPipe => {
                return ExitCode::SUCCESS;
            }
            Self::Scene(error) => {
                let theme = if stderr.is_terminal() {
                    GraphicalTheme::unicode()
                } else {
                    GraphicalTheme::unicode_nocolor()
                };
                let mut text = String::new();
                let rendered = GraphicalReportHandler::new_themed(theme)
                    .with_width(100)
                    .render_report(&mut text, error);
                match rendered {
                    Ok(()) => write!(stderr, "{}", text.trim_start_matches('\n')),
                    Err(_) => writeln!(stderr, "emitree: {error}"),
                }
            }
            _ => writeln!(stderr, "emitree: {self}"),
        };
        ExitCode::from(self.code())
    }
}
