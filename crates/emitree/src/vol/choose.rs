//! The choice between the low-rank approximation and the image tree.

use crate::energy::EnergyAxis;
use crate::error::{OptionError, RenderError};
use crate::exchange::MethodError;
use crate::meter::Meter;
use crate::output::MethodOutput;
use crate::tile::Tile;
use crate::tree::StopReason;
use crate::vol::engine::by_tree;
use crate::vol::lowrank::{self, Attempted};
use crate::vol::seeds::check_seeds;
use crate::vol::{BASE_LEVELS, VolOptions};

/// Renders an image, or a cube in the bins of `axis`, to the tolerance of `vol`.
pub(crate) async fn render(
    meter: &Meter,
    tiles: &[Tile<'_>],
    axis: Option<&EnergyAxis>,
    vol: &VolOptions,
) -> Result<MethodOutput, MethodError> {
    check(vol)?;
    check_seeds(&vol.seeds)?;
    let Attempted { found: products, samples } = match axis {
        None => lowrank::attempt(meter, tiles, vol).await?,
        Some(_) => Attempted::default(),
    };
    let is_complete = |found: &MethodOutput| found.ending == StopReason::Complete;
    let products = match products {
        Some(products) if is_complete(&products) => return Ok(products),
        products => products,
    };
    match (products, by_tree(meter, tiles, axis, vol, samples).await) {
        // The time limit was reached before lines gave an image.
        (Some(products), Err(RenderError::Time { .. })) => Ok(products),
        (products, tree) => {
            let tree = tree?;
            // If a limit ended both, the one with the smaller estimated error is used.
            let is_better =
                |products: &MethodOutput| products.estimated_error() < tree.estimated_error();
            Ok(products.filter(|p| !is_complete(&tree) && is_better(p)).unwrap_or(tree))
        }
    }
}

/// Returns an error if an option is out of range.
fn check(vol: &VolOptions) -> Result<(), MethodError> {
    if !(vol.tolerance > 0.0 && vol.tolerance < 1.0) {
        return Err(OptionError::Tolerance(vol.tolerance).into());
    }
    if !BASE_LEVELS.contains(&vol.base_level) {
        let expected = [*BASE_LEVELS.start(), *BASE_LEVELS.end()];
        return Err(OptionError::BaseLevel { level: vol.base_level, expected }.into());
    }
    Ok(())
}

#[cfg(test)]
mod tests;
