//! Checks of options, and the limits of a rendering, before anything is evaluated.

use crate::error::{OptionError, RenderError};
use crate::known::BYTES_PER_KNOWN_RATE;
use crate::memory::{check_size, evaluations_in_memory};
use crate::meter::{Deadline, Limits};
use crate::options::{Method, RenderOptions};

/// Refuses options out of range or without effect, and an image, or a cube of `bins` bands, beyond the memory allowed.
pub(crate) fn check_options<E>(
    shape: [usize; 2],
    bins: Option<usize>,
    options: &RenderOptions<'_>,
) -> Result<(), RenderError<E>> {
    if options.batch_size == 0 {
        return Err(OptionError::BatchSize(0).into());
    }
    if options.rounds == Some(0) {
        return Err(OptionError::Rounds(0).into());
    }
    if options.max_seconds.is_nan() || options.max_seconds <= 0.0 {
        return Err(OptionError::MaxSeconds(options.max_seconds).into());
    }
    let is_fixed = options.start.as_ref().is_some_and(|start| start.is_fixed);
    // Trees of cell averages have no meshes for other emissions.
    if is_fixed && matches!(options.method, Method::Paper(_)) {
        return Err(OptionError::FixedMesh.into());
    }
    match &options.method {
        Method::Vol(vol) if bins.is_none() && !vol.line_energies.is_empty() => {
            return Err(OptionError::LineEnergies.into());
        }
        Method::Vol(_) => {}
        method if options.frame.is_some() => return Err(OptionError::Frame(method.name()).into()),
        Method::Paper(_) | Method::Los(_) => {}
    }
    check_size(shape, bins, options)
}

/// Refuses callbacks, for a session whose caller has the loop and calls g.
pub(crate) fn refuse_callbacks(options: &RenderOptions<'_>) -> Result<(), OptionError> {
    let given = [("progress", options.progress.is_some()), ("frame", options.frame.is_some())];
    match given.into_iter().find(|(_, is_given)| *is_given) {
        Some((name, _)) => Err(OptionError::CallbackOfSession(name)),
        None => Ok(()),
    }
}

/// How often g may be called, and until when, counted from now.
pub(crate) fn limits(
    options: &RenderOptions<'_>,
    whole_batches: bool,
    keeps_rates: bool,
) -> Limits {
    let mut max_kept = evaluations_in_memory(options);
    if keeps_rates {
        max_kept = max_kept.min(options.max_memory_bytes / BYTES_PER_KNOWN_RATE);
    }
    let max_evaluations = options.max_evaluations;
    let deadline = Deadline::after_seconds(options.max_seconds);
    Limits { max_evaluations, max_kept, batch_size: options.batch_size, whole_batches, deadline }
}
