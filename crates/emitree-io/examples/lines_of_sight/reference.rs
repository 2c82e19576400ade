//! Pixels by a quadrature that has nothing in common with `vol` but the emission and the camera, with an error each.
//!
//! A pixel is the mean of ∫ g ds over the lines of a Fibonacci lattice (Niederreiter & Sloan 1994, J. Comput. Appl.
//! Math. 51, 57), weighted by solid angle. Lines are integrated by Simpson's rule in intervals that are halved until
//! two halves agree with the whole, so that jumps are bisected. Where one lattice and the next do not agree, or their
//! lines differ much, at limbs and surfaces, a larger one follows. The error of a pixel is what the last one changed,
//! the range of its lines over their number, and the mean of their errors.

use emitree::{Emission, Projection, Samples};
use rayon::prelude::*;

/// Lattices in a pixel: the lines, and the step along the second axis.
const LATTICES: [[u32; 2]; 8] =
    [[8, 5], [21, 13], [55, 34], [144, 89], [377, 233], [987, 610], [2584, 1597], [6765, 4181]];
/// The intervals of a line at first, and four steps in each.
const INTERVALS: usize = 64;
/// The shortest interval.
const SHORTEST: f64 = 1e-12;
/// What lattices may differ by, and the error of a line, as shares of the tolerance.
const DIFFERENCE: f64 = 0.1;
const OF_LINE: f64 = 0.02;
/// The largest pixel is estimated from one line in a square of so many pixels along each side.
const APART: usize = 4;

/// A view, rates in it, and the error that a pixel may have.
pub(crate) struct Exact<'a, E> {
    pub(crate) emission: &'a E,
    pub(crate) camera: &'a dyn Projection,
    pub(crate) shape: [usize; 2],
    /// As a share of the largest pixel.
    pub(crate) tolerance: f64,
}

/// Two ends and the middle of a part of a line, and g along it there.
#[derive(Clone, Copy)]
struct Interval {
    from: f64,
    width: f64,
    rates: [f64; 3],
}

impl Interval {
    fn simpson(&self) -> f64 {
        self.width / 6.0 * (self.rates[0] + 4.0 * self.rates[1] + self.rates[2])
    }

    fn halves(&self, quarters: [f64; 2]) -> [Self; 2] {
        let width = 0.5 * self.width;
        let [first, middle, last] = self.rates;
        [
            Self { from: self.from, width, rates: [first, quarters[0], middle] },
            Self { from: self.from + width, width, rates: [middle, quarters[1], last] },
        ]
    }
}

impl<E: Emission> Exact<'_, E> {
    /// The pixels, row by row, and their errors. Pixels without a line of sight are NaN.
    pub(crate) fn pixels(&self) -> Result<[Vec<f64>; 2], E::Error> {
        let largest = self.largest()?;
        let [height, width] = self.shape;
        let row = |row| -> Result<Vec<[f64; 2]>, E::Error> {
            (0..width).map(|column| self.pixel([row, column], largest)).collect()
        };
        let rows: Vec<_> = (0..height).into_par_iter().map(row).collect::<Result<_, _>>()?;
        let all = || rows.iter().flatten();
        Ok([all().map(|of| of[0]).collect(), all().map(|of| of[1]).collect()])
    }

    /// About the largest |pixel|.
    fn largest(&self) -> Result<f64, E::Error> {
        let [height, width] = self.shape;
        let mut largest: f64 = 0.0;
        for row in (0..height).step_by(APART) {
            for column in (0..width).step_by(APART) {
                let xy = self.place([row, column], [0.5; 2]);
                largest = largest.max(self.line(xy, f64::INFINITY)?[0].abs());
            }
        }
        Ok(largest)
    }

    /// Canonical coordinates of a place in a pixel.
    fn place(&self, [row, column]: [usize; 2], [x, y]: [f64; 2]) -> [f64; 2] {
        let [height, width] = self.shape.map(|of| of as f64);
        [(column as f64 + x) / width, (row as f64 + y) / height]
    }

    /// A pixel and its error.
    fn pixel(&self, pixel: [usize; 2], largest: f64) -> Result<[f64; 2], E::Error> {
        let mut found = [f64::NAN; 2];
        for [lines, step] in LATTICES {
            let (mut sum, mut errors, mut weights) = (0.0, 0.0, 0.0);
            let mut range = [f64::INFINITY, f64::NEG_INFINITY];
            for k in 0..lines {
                let along = |by: u32| (f64::from(k * by % lines) + 0.5) / f64::from(lines);
                let xy = self.place(pixel, [along(1), along(step)]);
                let weight = self.camera.solid_angle_density(xy);
                if weight > 0.0 {
                    let [radiance, error] = self.line(xy, OF_LINE * self.tolerance * largest)?;
                    sum += weight * radiance;
                    errors += weight * error;
                    weights += weight;
                    range = [range[0].min(radiance), range[1].max(radiance)];
                }
            }
            let mean = sum / weights;
            // Two lattices may agree by chance: an edge is between their lines.
            let of_lattice = (mean - found[0]).abs() + (range[1] - range[0]) / f64::from(lines);
            found = [mean, of_lattice + errors / weights];
            if of_lattice <= DIFFERENCE * self.tolerance * largest {
                break;
            }
        }
        Ok(found)
    }

    /// The integral along a line of sight and its error.
    fn line(&self, xy: [f64; 2], allowed: f64) -> Result<[f64; 2], E::Error> {
        let ends_and_middles: Vec<f64> =
            (0..=2 * INTERVALS).map(|k| k as f64 / (2 * INTERVALS) as f64).collect();
        let rates = self.rates(xy, &ends_and_middles)?;
        let width = 1.0 / INTERVALS as f64;
        let mut open: Vec<Interval> = (0..INTERVALS)
            .map(|k| Interval {
                from: k as f64 * width,
                width,
                rates: [rates[2 * k], rates[2 * k + 1], rates[2 * k + 2]],
            })
            .collect();
        let allowed = allowed / INTERVALS as f64;
        let mut found = [0.0; 2];
        while !open.is_empty() {
            let quarters = open.iter().flat_map(|of| [0.25, 0.75].map(|k| of.from + k * of.width));
            let rates = self.rates(xy, &quarters.collect::<Vec<_>>())?;
            let mut unresolved = Vec::new();
            for (interval, quarters) in open.iter().zip(rates.as_chunks::<2>().0) {
                let halves = interval.halves(*quarters);
                let sum = halves[0].simpson() + halves[1].simpson();
                let change = (sum - interval.simpson()).abs();
                if change <= allowed || interval.width < SHORTEST {
                    found = [found[0] + sum, found[1] + change];
                } else {
                    unresolved.extend(halves);
                }
            }
            open = unresolved;
        }
        Ok(found)
    }

    /// g times the path per depth at depths of a line of sight.
    fn rates(&self, [x, y]: [f64; 2], depths: &[f64]) -> Result<Vec<f64>, E::Error> {
        let points: Vec<_> =
            depths.iter().map(|z| self.camera.world_from_canonical([x, y, *z])).collect();
        let positions: Vec<_> = points.iter().map(|of| of.position).collect();
        let directions: Vec<_> = points.iter().map(|of| of.direction).collect();
        let mut rates = vec![0.0; depths.len()];
        self.emission.emission_rates(&Samples::new(&positions, &directions), &mut rates)?;
        let weighted = rates.iter().zip(&points).map(|(rate, of)| match of.path_per_depth {
            0.0 => 0.0,
            path => rate * path,
        });
        Ok(weighted.collect())
    }
}
