//! The error allowed in each pixel: `rtol`, `atol`, `floor`, `weights`, `mask` and `per_band` of `[render]`.

use super::camera::Camera;
use super::document::{Node, Value};
use super::error::SceneError;
use super::radiometry::Quantity;
use super::table::Table;
use super::{beside_scene, is_option};
use crate::grid::read_map;
use emitree::vol::PixelTolerance;
use emitree::{Image, VolOptions};
use std::sync::Arc;

/// What is rendered, for the settings that depend on it.
pub(super) struct RenderedView<'a> {
    /// Height and width of the image.
    pub(super) shape: [usize; 2],
    pub(super) has_energies: bool,
    pub(super) quantity: Quantity,
    /// The unit of the scene, for lengths with a unit of their own.
    pub(super) length_unit: Option<&'a str>,
    pub(super) camera: &'a Camera,
    /// The units of the values and of their integral over all energies, or empty, and the factor of the latter.
    pub(super) unit: &'a str,
    pub(super) band_unit: &'a str,
    pub(super) band_factor: f64,
}

/// The keys, with their values.
pub(super) struct Accuracy {
    rtol: Option<Node>,
    atol: Option<Node>,
    floor: Option<Node>,
    weights: Option<Node>,
    mask: Option<Node>,
    per_band: Option<Node>,
}

impl Accuracy {
    pub(super) fn take(table: &mut Table) -> Self {
        Self {
            rtol: table.take("rtol"),
            atol: table.take("atol"),
            floor: table.take("floor"),
            weights: table.take("weights"),
            mask: table.take("mask"),
            per_band: table.take("per_band"),
        }
    }

    /// The keys that are given.
    pub(super) fn given(&self) -> Vec<&'static str> {
        let all = [
            ("rtol", &self.rtol),
            ("atol", &self.atol),
            ("floor", &self.floor),
            ("weights", &self.weights),
            ("mask", &self.mask),
            ("per_band", &self.per_band),
        ];
        all.into_iter().filter(|(_, node)| node.is_some()).map(|(key, _)| key).collect()
    }

    /// Sets the options; `tolerance` is the key of that name, which the options have already.
    pub(super) fn set(
        self,
        options: &mut VolOptions,
        tolerance: Option<&Node>,
        view: &RenderedView<'_>,
    ) -> Result<(), SceneError> {
        if let (Some(node), Quantity::Irradiance) = (&self.atol, view.quantity) {
            return Err(
                node.refuse("given", "none, or `image.quantity = \"radiance\"`, whose unit it has")
            );
        }
        if let Some(node) = &self.per_band {
            options.per_band = boolean(node)?;
            if options.per_band && !view.has_energies {
                return Err(node.refuse("true", "an energy axis, `[energy]`, for it"));
            }
        }
        let maps = [(&self.weights, false), (&self.mask, true)];
        for (node, is_mask) in maps {
            let Some(node) = node else { continue };
            let map = map(node, is_mask, view.shape)?;
            options.weights = Some(Arc::new(match &options.weights {
                Some(weights) => times(weights, &map),
                None => map,
            }));
        }
        let is_dark = |weights: &Image| weights.pixels().iter().all(|weight| *weight == 0.0);
        if let (true, Some(node)) =
            (options.weights.as_deref().is_some_and(is_dark), self.mask.or(self.weights))
        {
            return Err(node.refuse("0 in all pixels", "a pixel that matters"));
        }
        options.by_pixel = by_pixel(self.rtol, self.atol, self.floor, tolerance)?;
        Ok(())
    }
}

fn by_pixel(
    rtol: Option<Node>,
    atol: Option<Node>,
    floor: Option<Node>,
    tolerance: Option<&Node>,
) -> Result<Option<PixelTolerance>, SceneError> {
    if let (Some(tolerance), Some(own)) = (tolerance, rtol.as_ref().or(atol.as_ref())) {
        match [tolerance, own].map(|node| is_option(&node.place.source)) {
            // The command line is later than the scene.
            [true, false] => return Ok(None),
            [false, true] => {}
            _ => {
                let name = own.path.rsplit('.').next().unwrap_or("rtol");
                let message = format!("both `tolerance` and `{name}` are given");
                return Err(SceneError::at(&own.place, message).label(
                    "expected one of them: an error relative to the largest pixel, or by pixel",
                ));
            }
        }
    }
    let number = |node: &Node, fits: fn(f64) -> bool, expected: &str| {
        let value = node.number()?;
        if fits(value) { Ok(value) } else { Err(node.refuse(&value.to_string(), expected)) }
    };
    const FLOOR: &str = "a fraction of the largest pixel, from 0 to below 1";
    let floor = floor
        .map(|node| Ok((number(&node, |floor| (0.0..1.0).contains(&floor), FLOOR)?, node)))
        .transpose()?;
    let rtol = rtol
        .map(|node| {
            number(&node, |rtol| rtol > 0.0 && rtol < 1.0, "a fraction above 0 and below 1")
        })
        .transpose()?;
    const ATOL: &str = "an error above 0, in the unit of the image";
    let atol = atol.map(|node| number(&node, |atol| atol > 0.0, ATOL)).transpose()?;
    let mut found = match (rtol, atol) {
        (None, None) => {
            return match floor {
                Some((floor, node)) => Err(node.refuse(&floor.to_string(), "`rtol` beside it")),
                None => Ok(None),
            };
        }
        (Some(rtol), None) => PixelTolerance::relative(rtol),
        (Some(rtol), Some(atol)) => PixelTolerance::relative(rtol).with_floor(0.0).with_atol(atol),
        (None, Some(atol)) => PixelTolerance::absolute(atol),
    };
    if let Some((floor, _)) = floor {
        found = found.with_floor(floor);
    }
    Ok(Some(found))
}

pub(super) fn boolean(node: &Node) -> Result<bool, SceneError> {
    match node.value {
        Value::Boolean(value) => Ok(value),
        _ => Err(node.refuse(node.value.kind(), "true or false")),
    }
}

/// The map in the file that a node names: weights, or 1 where a mask is not 0.
fn map(node: &Node, is_mask: bool, shape: [usize; 2]) -> Result<Image, SceneError> {
    let mut map = map_of_shape(node, shape)?;
    if is_mask {
        map.pixels_mut().iter_mut().for_each(|pixel| *pixel = f64::from(u8::from(*pixel != 0.0)));
    }
    let is_weight = |weight: &f64| *weight >= 0.0 && weight.is_finite();
    if let Some(pixel) = map.pixels().iter().position(|weight| !is_weight(weight)) {
        let (row, column) = (pixel / shape[1], pixel % shape[1]);
        let weight = map.pixels()[pixel];
        let message = format!("the map has {weight} in row {row}, column {column}");
        let message = format!("`{}`: {message}", node.path);
        return Err(
            SceneError::at(&node.place, message).label("expected finite weights of 0 or more")
        );
    }
    Ok(map)
}

/// The map in the file that a node names.
pub(super) fn map_of_shape(node: &Node, shape: [usize; 2]) -> Result<Image, SceneError> {
    let (file, place) = node.text()?;
    let refuse = |reason: String| SceneError::at(&place, format!("`{}`: {reason}", node.path));
    let map = read_map(&beside_scene(&file, &place))
        .map_err(|error| refuse(format!("the map {}: {}", error.path.display(), error.cause)))?;
    let found = [map.height(), map.width()];
    if found != shape {
        let [rows, columns] = found;
        let message = format!("the map has {rows} rows of {columns} pixels");
        let [height, width] = shape;
        return Err(refuse(message).label(format!("expected {height} rows of {width} pixels")));
    }
    Ok(map)
}

fn times(a: &Image, b: &Image) -> Image {
    let pixels = a.pixels().iter().zip(b.pixels()).map(|(a, b)| a * b).collect();
    Image::from_pixels(a.height(), a.width(), pixels)
}

#[cfg(test)]
mod tests;
