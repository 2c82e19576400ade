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
    degree: usize,
    coefficients: [f64; TERMS[DEGREE]],
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

fn dot(a: &[f64; DEGREE + 1], b: &[f64; DEGREE + 1]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl Polynomial {
    /// The value 0 in the box between two corners.
    pub(super) fn zero(low: [f64; 3], high: [f64; 3]) -> Self {
        Self { low, high, degree: 0, coefficients: [0.0; TERMS[DEGREE]], error: 0.0 }
    }

    /// The polynomial in the box between two corners that fits points and their rates, of the degree with
    /// the least error at the places where it is used: the leave-one-out error, multiplied by the standard
    /// deviation of the fit there in units of that of a value, as far as this is larger than at the border
    /// of the samples: an extrapolation.
    pub(super) fn fit(
        low: [f64; 3],
        high: [f64; 3],
        samples: &[([f64; 3], f64)],
        places: &[[f64; 3]],
    ) -> Self {
        let mut best = Self::zero(low, high);
        best.error = f64::INFINITY;
        if samples.len() < 2 {
            best.coefficients[0] = samples.first().map_or(0.0, |of| of.1);
            return best;
        }
        let mut columns =
            Columns::new(samples.iter().map(|(_, rate)| *rate).collect(), TERMS[DEGREE]);
        let terms_at = |at: &[f64; 3]| best.terms(*at).collect();
        let rows: Vec<Vec<f64>> = samples.iter().map(|(at, _)| terms_at(at)).collect();
        let mut places: Vec<(Vec<f64>, Vec<f64>)> =
            places.iter().map(|at| (terms_at(at), Vec::new())).collect();
        let mut term = 0;
        for (degree, terms) in TERMS.into_iter().enumerate() {
            if terms > 1 && (samples.len() as f64) < 1.25 * terms as f64 + 1.0 {
                break;
            }
            while term < terms {
                if !columns.add(rows.iter().map(|row| row[term])) {
                    return best;
                }
                term += 1;
            }
            let square = |i: usize| columns.left_out(i).powi(2);
            let mean = (0..samples.len()).map(square).sum::<f64>() / samples.len() as f64;
            let mut variance: f64 = 1.0;
            for (row, known) in &mut places {
                columns.extend_row(row, known);
                let of_place: f64 = known.iter().map(|of| of * of).sum();
                variance = variance.max(of_place / TUNING.surfaces.piece_variance);
            }
            let error = TUNING.surfaces.piece_margin * (mean * variance).sqrt();
            if error < best.error {
                best = Self { degree, error, ..best };
                let of_columns = columns.coefficients();
                best.coefficients.iter_mut().zip(of_columns).for_each(|(to, of)| *to = of);
            }
        }
        best
    }

    /// The integral along z from one depth to another.
    pub(super) fn integral(&self, [x, y]: [f64; 2], [from, to]: [f64; 2]) -> f64 {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        if self.degree == 0 {
            return 2.0 * half * self.coefficients[0];
        }
        let of_line = self.along_z([x, y]);
        // Three Gauss nodes integrate a polynomial of degree 5.
        let beside = half * 0.6_f64.sqrt();
        let value = |z: f64| dot(&of_line, &legendre(self.local(2, z)));
        let sum = 5.0 * (value(middle - beside) + value(middle + beside));
        half * (sum + 8.0 * value(middle)) / 9.0
    }

    /// The coordinate from −1 to 1 along an axis.
    fn local(&self, axis: usize, at: f64) -> f64 {
        let [low, high] = [self.low[axis], self.high[axis]];
        ((2.0 * at - low - high) / (high - low)).clamp(-BEYOND, BEYOND)
    }

    /// The coefficients in Legendre polynomials of z on the line at (x, y).
    fn along_z(&self, [x, y]: [f64; 2]) -> [f64; DEGREE + 1] {
        let [of_x, of_y] = [legendre(self.local(0, x)), legendre(self.local(1, y))];
        // In the order of the powers.
        let (mut sums, mut number) = ([0.0; DEGREE + 1], 0);
        for degree in 0..=DEGREE {
            if degree > self.degree {
                break;
            }
            for i in (0..=degree).rev() {
                for j in (0..=degree - i).rev() {
                    sums[degree - i - j] += self.coefficients[number] * (of_x[i] * of_y[j]);
                    number += 1;
                }
            }
        }
        sums
    }

    /// The values of the terms at a point.
    fn terms(&self, at: [f64; 3]) -> impl Iterator<Item = f64> + use<> {
        let local = core::array::from_fn::<_, 3, _>(|k| legendre(self.local(k, at[k])));
        powers().map(move |[i, j, k]| local[0][i] * local[1][j] * local[2][k])
    }

    /// The value at a point.
    pub(super) fn value(&self, at: [f64; 3]) -> f64 {
        if self.degree == 0 {
            return self.coefficients[0];
        }
        dot(&self.along_z([at[0], at[1]]), &legendre(self.local(2, at[2])))
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
