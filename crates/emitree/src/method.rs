//! The methods behind one function: from a view to values and their errors.

use crate::energy::EnergyAxis;
use crate::exchange::MethodError;
use crate::meter::Meter;
use crate::options::Method;
use crate::output::MethodOutput;
use crate::tile::Tile;
use crate::{los, paper, vol};
use core::future::Future;
use core::pin::Pin;

/// A method in progress, which waits for rates.
pub(crate) type Running<'a> =
    Pin<Box<dyn Future<Output = Result<MethodOutput, MethodError>> + Send + 'a>>;

/// [`run`], boxed: compiled here, once, and not in each function that is generic in the emission.
pub(crate) fn begin<'a>(
    meter: &'a Meter,
    tiles: &'a [Tile<'a>],
    axis: Option<&'a EnergyAxis>,
    method: &'a Method,
) -> Running<'a> {
    Box::pin(run(meter, tiles, axis, method))
}

/// The image of a camera, or the cube in the bins of `axis`, by a method.
pub(crate) async fn run(
    meter: &Meter,
    tiles: &[Tile<'_>],
    axis: Option<&EnergyAxis>,
    method: &Method,
) -> Result<MethodOutput, MethodError> {
    match method {
        Method::Vol(vol) => vol::render(meter, tiles, axis, vol).await,
        Method::Paper(paper) => paper::render(meter, tiles, axis, paper).await,
        Method::Los(los) => los::render(meter, tiles, axis, los).await,
    }
}
