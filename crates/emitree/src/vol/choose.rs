//! The choice between the low-rank approximation and the image tree.

use crate::energy::EnergyAxis;
use crate::error::RenderError;
use crate::exchange::MethodError;
use crate::meter::Meter;
use crate::method::Made;
use crate::tile::Tile;
use crate::tree::Ending;
use crate::vol::engine::by_tree;
use crate::vol::lowrank::{self, Attempted};
use crate::vol::seeds::check_seeds;
use crate::vol::{BASE_LEVELS, VolOptions};

/// The image that a camera sees, or the cube in the bins of `axis`, to the tolerance of `vol`.
pub(crate) async fn render(
    meter: &Meter,
    tiles: &[Tile<'_>],
    axis: Option<&EnergyAxis>,
    vol: &VolOptions,
) -> Result<Made, MethodError> {
    check(vol)?;
    check_seeds(&vol.seeds)?;
    let Attempted { found: products, samples } = match axis {
        None => lowrank::attempt(meter, tiles, vol).await?,
        Some(_) => Attempted::default(),
    };
    let is_good = |found: &Made| found.ending == Ending::Complete;
    let products = match products {
        Some(products) if is_good(&products) => return Ok(products),
        products => products,
    };
    match (products, by_tree(meter, tiles, axis, vol, samples).await) {
        // The time has ended before the lines have given an image.
        (Some(products), Err(RenderError::Time { .. })) => Ok(products),
        (products, tree) => {
            let tree = tree?;
            // A limit may end both: then the better one counts.
            let is_better = |products: &Made| products.estimated_error() < tree.estimated_error();
            Ok(products.filter(|p| !is_good(&tree) && is_better(p)).unwrap_or(tree))
        }
    }
}

/// Refuses options out of range.
fn check(vol: &VolOptions) -> Result<(), MethodError> {
    let option = |name, value: String, expected| Err(RenderError::Option { name, value, expected });
    if !(vol.tolerance > 0.0 && vol.tolerance < 1.0) {
        return option("tolerance", vol.tolerance.to_string(), "a fraction above 0 and below 1");
    }
    if !BASE_LEVELS.contains(&vol.base_level) {
        return option("base_level", vol.base_level.to_string(), "2 to 7");
    }
    Ok(())
}

#[cfg(test)]
mod tests;
