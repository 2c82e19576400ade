//! The scaling of G for errors by pixel.
//!
//! Where the error allowed falls with the brightness, by five decades in an image of a corona, a sum of products of
//! polynomials for G itself has to be accurate to the smallest error everywhere. The search is therefore for
//! h(x, y, z) = ω(x) ω'(y) G(x, y, z), in which about the same error is allowed everywhere, and the means over pixels are
//! those of h/(ω ω'). Any positive ω and ω' that are smooth serve: here exponentials of polynomials, fitted to
//! the brightness that the first scattered samples show. What they leave of the weights of errors, residuals have.

use crate::vol::lowrank::Attempt;
use crate::vol::tuning::TUNING;
use crate::vol::view::raster::cell_at;
use nalgebra::{DMatrix, DVector};

/// The cells along each axis in which samples are averaged for the fit: some eight samples are in each.
const CELLS: usize = 8;
/// The number of the Chebyshev polynomials of degree 1 and more along each axis.
const DEGREE: usize = 3;

/// ω and ω', by the coefficients of the Chebyshev polynomials of degree 1 to [`DEGREE`] of their logarithms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scaling([[f64; DEGREE]; 2]);

impl Scaling {
    /// ω ω' at a place.
    pub(crate) fn at(&self, [u, v]: [f64; 2]) -> f64 {
        (self.logarithm(0, u) + self.logarithm(1, v)).exp()
    }

    /// 1/ω along x (axis 0), or 1/ω' along y (axis 1).
    pub(super) fn inverse(&self, axis: usize, x: f64) -> f64 {
        (-self.logarithm(axis, x)).exp()
    }

    fn logarithm(&self, axis: usize, x: f64) -> f64 {
        self.0[axis].iter().zip(polynomials(x)).map(|(c, t)| c * t).sum()
    }

    /// That in which the error allowed varies least, from the `wanted` ω ω' at places; `None` if these do not differ
    /// enough.
    fn fitted(wanted: &[([f64; 2], f64)]) -> Option<Self> {
        let columns = 1 + 2 * DEGREE;
        if wanted.len() < 2 * columns {
            return None;
        }
        let row = |[u, v]: [f64; 2]| -> Vec<f64> {
            core::iter::once(1.0).chain(polynomials(u)).chain(polynomials(v)).collect()
        };
        let rows: Vec<f64> = wanted.iter().flat_map(|(at, _)| row(*at)).collect();
        let matrix = DMatrix::from_row_slice(wanted.len(), columns, &rows);
        let logarithms = DVector::from_iterator(wanted.len(), wanted.iter().map(|of| of.1.ln()));
        // Directions that the places do not determine are left out.
        let found = matrix.clone().svd(true, true).solve(&logarithms, 1e-6).ok()?;
        let of_axis = |axis: usize| core::array::from_fn(|k| found[1 + axis * DEGREE + k]);
        let scaling = Self([of_axis(0), of_axis(1)]);
        let (mean, fitted) = (logarithms.mean(), matrix * &found);
        let variance = logarithms.map(|of| (of - mean).powi(2)).sum();
        if (fitted - &logarithms).norm_squared() > (1.0 - TUNING.lowrank.least_explained) * variance
        {
            return None;
        }
        let all = wanted.iter().map(|(at, _)| scaling.at(*at));
        let [least, most] = all.fold([f64::INFINITY, 0.0], |[least, most], of| {
            [f64::min(least, of), f64::max(most, of)]
        });
        (most > TUNING.lowrank.least_scaling * least && most.is_finite()).then_some(scaling)
    }
}

/// The Chebyshev polynomials of degree 1 to [`DEGREE`] on the unit interval.
fn polynomials(x: f64) -> [f64; DEGREE] {
    let s = 1.0 - 2.0 * x;
    let (mut before, mut now) = (1.0, s);
    core::array::from_fn(|_| {
        let value = now;
        (before, now) = (now, 2.0 * s * now - before);
        value
    })
}

impl Attempt<'_> {
    /// The scaling for the error allowed by pixel, from the scattered samples; `None` if it is nearly the same everywhere.
    pub(super) fn fitted_scaling(&self) -> Option<Scaling> {
        let by_pixel = self.vol.by_pixel.filter(|of| of.rtol > 0.0)?;
        let scale = &self.part.scale;
        let scale_at = |uv: [f64; 2]| scale.pixels()[cell_at(uv, [scale.height(), scale.width()])];
        let mut sums = vec![[0.0; 4]; CELLS * CELLS];
        for ([u, v, _], rate) in self.search.probed() {
            let sum = &mut sums[cell_at([u, v], [CELLS; 2])];
            let more = [1.0, u, v, rate.abs()];
            sum.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
        }
        let means = sums.iter().filter(|[count, ..]| *count > 0.0).map(|[count, sums @ ..]| {
            let [u, v, rate] = sums.map(|sum| sum / count);
            ([u, v], rate, scale_at([u, v]))
        });
        let seen: Vec<([f64; 2], f64, f64)> = means.filter(|(_, _, scale)| *scale > 0.0).collect();
        let pixel = |(_, rate, scale): &([f64; 2], f64, f64)| rate * scale;
        let largest = seen.iter().map(pixel).fold(self.largest_of_others, f64::max);
        let wanted = seen.iter().map(|of| (of.0, of.2 / by_pixel.allowed(pixel(of), largest)));
        let wanted: Vec<([f64; 2], f64)> = wanted.filter(|(_, of)| of.is_finite()).collect();
        Scaling::fitted(&wanted)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The centres of the cells of a square lattice, with ω ω' as it is wanted there.
    fn wanted(of: impl Fn([f64; 2]) -> f64) -> Vec<([f64; 2], f64)> {
        let centre = |k: usize| (k as f64 + 0.5) / CELLS as f64;
        let places = (0..CELLS * CELLS).map(|k| [centre(k % CELLS), centre(k / CELLS)]);
        places.map(|place| (place, of(place))).collect()
    }

    #[test]
    fn the_product_that_is_wanted_is_found_up_to_a_factor() {
        let of = |[u, v]: [f64; 2]| 7.0 * (9.0 * u - 3.0 * u * u + 2.0 * v).exp();
        let scaling = Scaling::fitted(&wanted(of)).unwrap();
        let ratio = |place| scaling.at(place) / of(place);
        assert!((ratio([0.1, 0.9]) / ratio([0.8, 0.3]) - 1.0).abs() < 1e-9);
        let inverse = scaling.inverse(0, 0.3) * scaling.inverse(1, 0.6);
        assert!((inverse * scaling.at([0.3, 0.6]) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn rings_nearly_uniform_images_and_few_places_have_none() {
        let ring = |[u, v]: [f64; 2]| (40.0 * ((u - 0.5).hypot(v - 0.5) - 0.35).abs()).exp();
        assert_eq!(Scaling::fitted(&wanted(ring)), None);
        assert_eq!(Scaling::fitted(&wanted(|[u, _]| 1.0 + u)), None);
        assert_eq!(Scaling::fitted(&wanted(|[u, _]| (9.0 * u).exp())[..8]), None);
    }
}
