//! The reference image of a view of cusps.

use super::CuspView;
use super::lens::Seen;
use super::pixel::{Pixel, Rules, Singularity};
use crate::family::Reference;
use crate::gauss::Gauss;
use core::f64::consts::PI;
use emitree::Image;
use rayon::prelude::*;

/// Nodes of the coarser and of the finer rules, as [`Rules`] has them.
const RULES: [([usize; 4], [usize; 3]); 2] =
    [([8, 16, 8, 6], [9, 6, 4]), ([11, 26, 11, 9], [12, 8, 5])];
/// Nodes along each side of a pixel for what is smooth.
const SMOOTH: usize = 5;
/// What rounding can do to a pixel.
const ROUNDING: f64 = 1e-11;

/// The image with the finer rules, and its largest difference to the coarser ones, relative to the pixel.
pub(super) fn image(view: &CuspView) -> Reference {
    let [height, width] = view.shape;
    let rules = RULES.map(|(line, tensor)| Rules::new(line, tensor));
    let smooth = Gauss::new(SMOOTH);
    let of_pixel = |number: usize| {
        let pixel = view.pixel(number);
        let area = pixel.tensor(&smooth, |place| view.lens.density(place));
        let background =
            pixel.tensor(&smooth, |place| view.lens.density(place) * background_on(view, place));
        let [coarse, fine] =
            [0, 1].map(|k| (background + cusps_in(view, &pixel, &rules[k])) / area);
        let change = if fine > 0.0 { (fine - coarse).abs() / fine } else { 0.0 };
        (fine, change)
    };
    let found: Vec<(f64, f64)> = (0..height * width).into_par_iter().map(of_pixel).collect();
    let error = found.iter().map(|(_, change)| *change).fold(0.0, f64::max) + ROUNDING;
    let pixels = found.into_iter().map(|(value, _)| value).collect();
    Reference { image: Image::from_pixels(height, width, pixels), error }
}

/// ∫ of the radiance of all cusps over the solid angle of a pixel.
fn cusps_in(view: &CuspView, pixel: &Pixel, rules: &Rules) -> f64 {
    let of_cusp = |(cusp, seen): (&super::Cusp, &Seen)| {
        let relative = |at: [f64; 2]| [0, 1].map(|i| at[i] - seen.place[i]);
        let pixel = Pixel { low: relative(pixel.low), high: relative(pixel.high) };
        let in_image = if view.lens.is_parallel() { 1.0 } else { seen.distance };
        let singularity =
            Singularity { exponent: cusp.radial.exponent(), core: cusp.core / in_image };
        pixel.integral(singularity, rules, |offset| {
            let place = [0, 1].map(|i| seen.place[i] + offset[i]);
            let line = view.lens.line(seen, offset);
            cusp.integral(&line, &rules.line) * view.lens.density(place)
        })
    };
    view.cusps.iter().zip(&view.seen).map(of_cusp).sum()
}

/// ∫ of the background along the line of a place, by the error function.
fn background_on(view: &CuspView, place: [f64; 2]) -> f64 {
    let (origin, direction) = view.lens.origin_and_direction(place);
    let [near, far] = view.lens.depth;
    let of_blob = |blob: &super::Blob| {
        let to_centre: [f64; 3] = core::array::from_fn(|i| blob.centre[i] - origin[i]);
        let along = super::cusp::dot(to_centre, direction);
        let aside = super::cusp::dot(to_centre, to_centre) - along * along;
        let scaled = |t: f64| libm::erf((t - along) / blob.width);
        let length = 0.5 * PI.sqrt() * blob.width * (scaled(far) - scaled(near));
        blob.amplitude * libm::exp(-aside / (blob.width * blob.width)) * length
    };
    view.background.iter().map(of_blob).sum()
}
