//! Sums over named regions: `sums` of `[render]`.

use super::accuracy::{RenderedView, map_of_shape};
use super::camera::{PlotAxis, PlotFrame, PlotScale};
use super::document::{Node, Value};
use super::error::SceneError;
use super::radiometry::Quantity;
use super::table::Table;
use emitree::Image;
use emitree::radiance::irradiance_of;
use emitree::sums::{Region, Sum, SumKind};

/// Parts of a pixel along each axis, where the border of a region is no ellipse in pixels: the share of
/// a pixel on the border has an error of some 0.01.
const PARTS: usize = 16;

/// The most sums: keywords of FITS have eight letters, of which two are the number.
const MOST_SUMS: usize = 99;

const REGIONS: &str = "`circle`, `box` or `mask`";

/// A sum over a region, as the scene asks for it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SceneSum {
    /// The name.
    pub name: String,
    /// What is asked: `sum`, `mean` or `flux`.
    pub of: &'static str,
    /// The error allowed relative to the value.
    pub tolerance: f64,
    /// The unit of the value, in the grammar of FITS, or empty.
    pub unit: String,
    /// The unit of the sum over one band of a cube, or empty.
    pub band_unit: String,
}

/// The sums, with what the library takes for each.
pub(super) fn read(
    node: Node,
    view: &RenderedView<'_>,
) -> Result<(Vec<SceneSum>, Vec<Sum>), SceneError> {
    let place = node.place.clone();
    let Value::Table(entries) = node.value else {
        let expected =
            "a table of names, as in { on = { circle = { center = [32, 24], radius = 10 } } }";
        return Err(node.refuse(node.value.kind(), expected));
    };
    let (mut asked, mut sums) = (Vec::new(), Vec::new());
    for (name, entry) in entries {
        let is_name = |c: char| c.is_ascii_alphanumeric() || "_-+. ".contains(c);
        if name.is_empty() || !name.chars().all(is_name) {
            let message = format!("`{name}` is the name of a sum");
            return Err(SceneError::at(&entry.key, message)
                .label("expected letters and digits of ASCII, with `_`, `-`, `+`, `.` or spaces"));
        }
        let (of_scene, sum) = one(&name, entry.node, view)?;
        asked.push(of_scene);
        sums.push(sum);
    }
    if sums.len() > MOST_SUMS {
        let message = format!("`render.sums` has {} sums", sums.len());
        return Err(SceneError::at(&place, message).label(format!("expected at most {MOST_SUMS}")));
    }
    if sums.is_empty() {
        return Err(SceneError::at(&place, "`render.sums` is empty").label("expected a sum"));
    }
    Ok((asked, sums))
}

fn one(name: &str, node: Node, view: &RenderedView<'_>) -> Result<(SceneSum, Sum), SceneError> {
    let (path, place) = (node.path.clone(), node.place.clone());
    // The name of a file alone is that of a mask.
    let mut table = match node.value {
        Value::Text(_) => Table::absent(&path, &place),
        _ => Table::new(node.clone())?,
    };
    let (circle, rectangle) = (table.take("circle"), table.take("box"));
    let mask = match node.value {
        Value::Text(_) => Some(node),
        _ => table.take("mask"),
    };
    let of = table.text("of")?;
    let tolerance = table.take("tolerance");
    let atol = table.take("atol");
    let is_on_axes = match table.text("coordinates")? {
        None => false,
        Some((name, place)) => match name.as_str() {
            "pixels" => false,
            "axes" => true,
            _ => {
                return Err(SceneError::at(&place, format!("`{path}.coordinates` is `{name}`"))
                    .label("expected `pixels`, or `axes` for those of the camera"));
            }
        },
    };
    table.finish()?;
    let weights = match (circle, rectangle, mask) {
        (Some(circle), None, None) => Shape::circle(circle)?.weights(view, is_on_axes, &place)?,
        (None, Some(of_box), None) => Shape::of_box(of_box)?.weights(view, is_on_axes, &place)?,
        (None, None, Some(mask)) => signed_map(&mask, view.shape)?,
        _ => {
            return Err(SceneError::at(&place, format!("`{path}` has no region of its own"))
                .label(format!("expected one of {REGIONS}")));
        }
    };
    let kind = match of.as_ref().map(|(name, place)| (name.as_str(), place)) {
        None | Some(("sum", _)) => SumKind::Sum,
        Some(("mean", _)) => SumKind::Mean,
        Some(("flux", place)) => {
            if !view.camera.description().has_solid_angles {
                return Err(SceneError::at(place, format!("`{path}.of` is `flux`")).label(
                    "expected `sum` or `mean`: pixels of this camera have no solid angles",
                ));
            }
            SumKind::Flux
        }
        Some((other, place)) => {
            return Err(SceneError::at(place, format!("`{path}.of` is `{other}`"))
                .label("expected `sum`, `mean` or `flux`"));
        }
    };
    let tolerance = tolerance
        .map(|node| {
            let value = node.number()?;
            match (0.0..1.0).contains(&value) {
                true => Ok(value),
                false => Err(node.refuse(&value.to_string(), "a fraction, from 0 to below 1")),
            }
        })
        .transpose()?;
    let atol = atol
        .map(|node| {
            let value = node.number()?;
            let expected = "an error above 0, in the unit of the sum";
            if value > 0.0 { Ok(value) } else { Err(node.refuse(&value.to_string(), expected)) }
        })
        .transpose()?;
    let rtol = tolerance.unwrap_or(if atol.is_some() { 0.0 } else { 0.01 });
    if rtol <= 0.0 && atol.is_none() {
        let message = format!("`{path}.tolerance` is 0");
        return Err(SceneError::at(&place, message).label("expected a fraction above 0, or `atol`"));
    }
    let asked = SceneSum {
        name: name.to_owned(),
        of: name_of(kind),
        tolerance: rtol,
        unit: unit_of(kind, view.quantity, view.band_unit),
        band_unit: unit_of(kind, view.quantity, view.unit),
    };
    let (kind, weights) = of_radiances(kind, weights, view);
    if weights.pixels().iter().all(|weight| *weight == 0.0) {
        return Err(SceneError::at(&place, format!("`{path}` is empty"))
            .label("expected a pixel of the image in the region"));
    }
    let atol = atol.unwrap_or(0.0) / view.band_factor;
    let sum = Sum::new(name, weights).with_kind(kind).with_tolerance(rtol).with_atol(atol);
    Ok((asked, sum))
}

fn name_of(kind: SumKind) -> &'static str {
    match kind {
        SumKind::Sum => "sum",
        SumKind::Mean => "mean",
        SumKind::Flux => "flux",
    }
}

/// The unit of a sum of values in `unit`, which may be empty: a flux of radiances is an irradiance.
fn unit_of(kind: SumKind, quantity: Quantity, unit: &str) -> String {
    if kind != SumKind::Flux || quantity == Quantity::Irradiance || unit.is_empty() {
        return unit.to_owned();
    }
    let factors: Vec<&str> = unit.split(' ').collect();
    match factors.iter().position(|factor| *factor == "sr-1") {
        Some(at) => [&factors[..at], &factors[at + 1..]].concat().join(" "),
        None => format!("{unit} sr"),
    }
}

/// The same as a sum of radiances, where the pixels of the scene are irradiances.
fn of_radiances(kind: SumKind, weights: Image, view: &RenderedView<'_>) -> (SumKind, Image) {
    match (view.quantity, kind) {
        (Quantity::Radiance, _) => (kind, weights),
        (Quantity::Irradiance, SumKind::Sum | SumKind::Flux) => (SumKind::Flux, weights),
        (Quantity::Irradiance, SumKind::Mean) => {
            let [height, width] = view.shape;
            let ones = Image::from_pixels(height, width, vec![1.0; height * width]);
            let solid_angles = irradiance_of(&ones, view.camera.projection());
            let pixels = weights.pixels().iter().zip(solid_angles.pixels());
            let of_all: f64 = pixels.filter(|(_, angle)| **angle > 0.0).map(|(w, _)| w).sum();
            let mean = |weight: &f64| if of_all == 0.0 { 0.0 } else { weight / of_all };
            let weights = weights.pixels().iter().map(mean).collect();
            (SumKind::Flux, Image::from_pixels(height, width, weights))
        }
    }
}

/// A circle or a box in the coordinates of the scene.
struct Shape {
    region: Region,
}

impl Shape {
    fn circle(node: Node) -> Result<Self, SceneError> {
        let mut table = Table::new(node)?;
        const CENTER: &str = "[x, y], the centre";
        let center = table.require("center", CENTER)?.vector(CENTER)?;
        let radius = table.require("radius", "a radius above 0")?;
        table.finish()?;
        let value = radius.number()?;
        if value > 0.0 {
            return Ok(Self { region: Region::circle(center, value) });
        }
        Err(radius.refuse(&value.to_string(), "a radius above 0"))
    }

    fn of_box(node: Node) -> Result<Self, SceneError> {
        let mut table = Table::new(node)?;
        const MIN: &str = "[x, y], the corner at the lower left";
        const MAX: &str = "[x, y], the corner at the upper right";
        let min: [f64; 2] = table.require("min", MIN)?.vector(MIN)?;
        let at_max = table.require("max", MAX)?;
        let max: [f64; 2] = at_max.vector(MAX)?;
        table.finish()?;
        if max[0] > min[0] && max[1] > min[1] {
            return Ok(Self { region: Region::rectangle(min, max) });
        }
        Err(at_max.refuse(&format!("{max:?}"), "coordinates above those of `min`"))
    }

    /// The share of each pixel that is inside.
    fn weights(
        &self,
        view: &RenderedView<'_>,
        is_on_axes: bool,
        place: &super::source::Place,
    ) -> Result<Image, SceneError> {
        let refuse = |message: &str| {
            Err(SceneError::at(place, message).label("expected a `mask`, or regions in pixels"))
        };
        if view.camera.description().is_sky() {
            return refuse("a circle or a box on a sky of twelve faces");
        }
        if !is_on_axes {
            return Ok(self.region.weights(view.shape));
        }
        let (PlotFrame::Axes { x, y } | PlotFrame::UnlikeAxes { x, y }) = view.camera.frame()
        else {
            return refuse("this camera has no axes for `coordinates`");
        };
        let [height, width] = view.shape;
        let axes = [(x, width), (y, height)];
        let is_even = axes.iter().all(|(axis, _)| axis.scale != PlotScale::Tangents);
        if is_even {
            // From axes to pixels.
            let at = |values: [f64; 2]| {
                [0, 1].map(|k| {
                    let (axis, pixels) = axes[k];
                    let [low, high] = axis.ends;
                    (values[k] - low) / (high - low) * pixels as f64
                })
            };
            let region = match self.region {
                Region::Ellipse { center, radii } => {
                    let [from, to] = [at(center), at([center[0] + radii[0], center[1] + radii[1]])];
                    Region::ellipse(from, [(to[0] - from[0]).abs(), (to[1] - from[1]).abs()])
                }
                Region::Rectangle { min, max } => {
                    let [a, b] = [at(min), at(max)];
                    let low = [a[0].min(b[0]), a[1].min(b[1])];
                    Region::rectangle(low, [a[0].max(b[0]), a[1].max(b[1])])
                }
                _ => return refuse("this region has no border on the axes"),
            };
            return Ok(region.weights(view.shape));
        }
        let along = |k: usize| -> Vec<f64> {
            let (axis, pixels) = axes[k];
            let parts = pixels * PARTS;
            (0..parts).map(|i| coordinate(&axis, (i as f64 + 0.5) / parts as f64)).collect()
        };
        let [xs, ys] = [along(0), along(1)];
        let is_inside = |x: f64, y: f64| match self.region {
            Region::Ellipse { center, radii } => {
                ((x - center[0]) / radii[0]).powi(2) + ((y - center[1]) / radii[1]).powi(2) < 1.0
            }
            Region::Rectangle { min, max } => {
                (min[0]..max[0]).contains(&x) && (min[1]..max[1]).contains(&y)
            }
            _ => false,
        };
        let share = |pixel: usize| {
            let [column, row] = [pixel % width * PARTS, pixel / width * PARTS];
            let of_row =
                |y: &f64| xs[column..][..PARTS].iter().filter(|x| is_inside(**x, *y)).count();
            let inside: usize = ys[row..][..PARTS].iter().map(of_row).sum();
            inside as f64 / (PARTS * PARTS) as f64
        };
        Ok(Image::from_pixels(height, width, (0..height * width).map(share).collect()))
    }
}

/// The coordinate on an axis at a fraction of the image.
fn coordinate(axis: &PlotAxis, along: f64) -> f64 {
    let [low, high] = axis.ends;
    match axis.scale {
        PlotScale::Tangents => {
            let [low, high] = [low, high].map(|end| end.to_radians().tan());
            (low + along * (high - low)).atan().to_degrees()
        }
        PlotScale::Lengths | PlotScale::Angles => low + along * (high - low),
    }
}

/// A map of weights of either sign.
fn signed_map(node: &Node, shape: [usize; 2]) -> Result<Image, SceneError> {
    let map = map_of_shape(node, shape)?;
    if let Some(pixel) = map.pixels().iter().position(|weight| !weight.is_finite()) {
        let (row, column) = (pixel / shape[1], pixel % shape[1]);
        let weight = map.pixels()[pixel];
        let message =
            format!("`{}`: the map has {weight} in row {row}, column {column}", node.path);
        return Err(SceneError::at(&node.place, message).label("expected finite weights"));
    }
    Ok(map)
}

#[cfg(test)]
mod tests;
