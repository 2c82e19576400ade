//! Polynomials in boxes, of total degree 4 or less.

use crate::projection::vector::difference;
use crate::vol::surfaces::columns::Columns;
use crate::vol::tuning::TUNING;

/// The highest total degree.
pub(super) const DEGREE: usize = 4;
/// The number of coefficients for each degree.
pub(super) const TERMS: [usize; DEGREE + 1] = [1, 4, 10, 20, 35];
/// The most |local coordinate| at which a polynomial is evaluated.
const BEYOND: f64 = 1.15;

/// A polynomial in Legendre polynomials of coordinates from −1 to 1.
#[derive(Clone, Debug)]
pub(super) struct Polynomial {
    low: [f64; 3],
    high: [f64; 3],
    coefficients: Vec<f64>,
    /// The expected error.
    pub(super) error: f64,
}

/// Powers of the terms, by total degree.
fn powers() -> impl Iterator<Item = [usize; 3]> {
    (0..=DEGREE).flat_map(|degree| {
        (0..=degree)
            .rev()
            .flat_map(move |i| (0..=degree - i).rev().map(move |j| [i, j, degree - i - j]))
    })
}

fn legendre(t: f64) -> [f64; DEGREE + 1] {
    let s = t * t;
    let three = (2.5 * s - 1.5) * t;
    [1.0, t, 1.5 * s - 0.5, three, (4.375 * s - 3.75) * s + 0.375]
}

impl Polynomial {
    /// The value 0 in the box between two corners.
    pub(super) fn zero(low: [f64; 3], high: [f64; 3]) -> Self {
        Self { low, high, coefficients: vec![0.0], error: 0.0 }
    }

    /// The polynomial in the box between two corners that fits points and their rates, of the degree with
    /// the least leave-one-out error.
    pub(super) fn fit(low: [f64; 3], high: [f64; 3], samples: &[([f64; 3], f64)]) -> Self {
        let mut best = Self::zero(low, high);
        if samples.is_empty() {
            return best;
        }
        let mut columns = Columns::new(samples.iter().map(|(_, rate)| *rate).collect());
        let rows: Vec<Vec<f64>> = samples.iter().map(|(at, _)| best.terms(*at).collect()).collect();
        let mut term = 0;
        best.error = f64::INFINITY;
        for terms in TERMS {
            if terms > 1 && (samples.len() as f64) < 1.25 * terms as f64 + 1.0 {
                break;
            }
            while term < terms {
                if !columns.add(rows.iter().map(|row| row[term]).collect()) {
                    return best;
                }
                term += 1;
            }
            let square = |i: usize| columns.left_out(i).powi(2);
            let mean = (0..samples.len()).map(square).sum::<f64>() / samples.len() as f64;
            let error = TUNING.surfaces.piece_margin * mean.sqrt();
            if error < best.error {
                best = Self { coefficients: columns.coefficients(), error, ..best };
            }
        }
        best
    }

    /// The integral along z from one depth to another.
    pub(super) fn integral(&self, [x, y]: [f64; 2], [from, to]: [f64; 2]) -> f64 {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        if let [constant] = self.coefficients[..] {
            return 2.0 * half * constant;
        }
        // Three Gauss nodes integrate a polynomial of degree 5.
        let beside = half * 0.6_f64.sqrt();
        let value = |z: f64| self.value([x, y, z]);
        let sum = 5.0 * (value(middle - beside) + value(middle + beside));
        half * (sum + 8.0 * value(middle)) / 9.0
    }

    /// The values of the terms at a point.
    fn terms(&self, at: [f64; 3]) -> impl Iterator<Item = f64> + use<> {
        let local = core::array::from_fn::<_, 3, _>(|k| {
            let t = (2.0 * at[k] - self.low[k] - self.high[k]) / (self.high[k] - self.low[k]);
            legendre(t.clamp(-BEYOND, BEYOND))
        });
        powers().map(move |[i, j, k]| local[0][i] * local[1][j] * local[2][k])
    }

    /// The value at a point.
    pub(super) fn value(&self, at: [f64; 3]) -> f64 {
        if let [constant] = self.coefficients[..] {
            return constant;
        }
        let local: [[f64; DEGREE + 1]; 3] = core::array::from_fn(|k| {
            let t = (2.0 * at[k] - self.low[k] - self.high[k]) / (self.high[k] - self.low[k]);
            legendre(t.clamp(-BEYOND, BEYOND))
        });
        // In the order of the powers.
        let (mut sum, mut number) = (0.0, 0);
        for degree in 0..=DEGREE {
            if number == self.coefficients.len() {
                break;
            }
            for i in (0..=degree).rev() {
                for j in (0..=degree - i).rev() {
                    let term = local[0][i] * local[1][j] * local[2][degree - i - j];
                    sum += self.coefficients[number] * term;
                    number += 1;
                }
            }
        }
        sum
    }

    /// The axis along which the higher terms are largest.
    pub(super) fn roughest_axis(&self) -> usize {
        let mut sums = [0.0; 3];
        for (powers, coefficient) in powers().zip(&self.coefficients) {
            for k in 0..3 {
                if powers[k] >= 2 {
                    sums[k] += coefficient.abs() * powers[k] as f64;
                }
            }
        }
        if sums.iter().all(|sum| *sum <= 0.0) {
            let edges = difference(self.high, self.low);
            return (0..3).fold(0, |best, k| if edges[k] > edges[best] { k } else { best });
        }
        (0..3).fold(0, |best, k| if sums[k] > sums[best] { k } else { best })
    }
}
