//! Polynomials in boxes, of total degree 4 or less.

use crate::projection::vector::difference;
use crate::vol::surfaces::columns::Columns;
use crate::vol::tuning::TUNING;
use multiversion::multiversion;

/// The highest total degree.
pub(super) const DEGREE: usize = 4;
/// The number of coefficients for each degree.
pub(super) const TERMS: [usize; DEGREE + 1] = [1, 4, 10, 20, 35];
/// The same of polynomials of x and y.
const TERMS_OF_XY: [usize; DEGREE + 1] = [1, 3, 6, 10, 15];
/// The most |local coordinate| at which a polynomial is evaluated.
const BEYOND: f64 = 1.15;

/// A polynomial in Legendre polynomials of coordinates from −1 to 1.
#[derive(Clone, Debug)]
pub(super) struct Polynomial {
    low: [f64; 3],
    high: [f64; 3],
    degree: usize,
    /// By powers of z, then by the degree in x and y, then by powers of y; 0 above the degree.
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

/// The number of the coefficient of a term.
fn number([i, j, k]: [usize; 3]) -> usize {
    let before: usize = (0..k).map(|lower| TERMS_OF_XY[DEGREE - lower]).sum();
    before + (i + j) * (i + j + 1) / 2 + j
}

#[inline(always)]
fn legendre(t: f64) -> [f64; DEGREE + 1] {
    let s = t * t;
    let three = (2.5 * s - 1.5) * t;
    [1.0, t, 1.5 * s - 0.5, three, (4.375 * s - 3.75) * s + 0.375]
}

/// The number of lines that are integrated side by side.
pub(super) const LANES: usize = 8;
/// A number for each of them.
pub(super) type Lanes = [f64; LANES];

/// The Legendre polynomials of the coordinates from −1 to 1 that belong to some between two ends.
#[inline(always)]
fn legendre_between(at: &Lanes, low: f64, high: f64) -> [Lanes; DEGREE + 1] {
    let mut values = [[0.0; LANES]; DEGREE + 1];
    for lane in 0..LANES {
        let of_lane = legendre(local(at[lane], low, high));
        for (values, of_lane) in values.iter_mut().zip(of_lane) {
            values[lane] = of_lane;
        }
    }
    values
}

/// The coordinate from −1 to 1 of a place between two ends.
#[inline(always)]
fn local(at: f64, low: f64, high: f64) -> f64 {
    ((2.0 * at - low - high) / (high - low)).clamp(-BEYOND, BEYOND)
}

/// The sums of products.
#[inline(always)]
fn dot(a: &[Lanes; DEGREE + 1], b: &[Lanes; DEGREE + 1]) -> Lanes {
    let mut sums = [0.0; LANES];
    for (a, b) in a.iter().zip(b) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    sums
}

/// Writes the integrals along z at places (x, y), each from one depth to another, to `integrals`.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(super) fn integrate(
    of: &Polynomial,
    x: &Lanes,
    y: &Lanes,
    from: &Lanes,
    to: &Lanes,
    integrals: &mut Lanes,
) {
    let (mut middle, mut half) = ([0.0; LANES], [0.0; LANES]);
    for lane in 0..LANES {
        middle[lane] = 0.5 * (from[lane] + to[lane]);
        half[lane] = 0.5 * (to[lane] - from[lane]);
    }
    if of.degree == 0 {
        for lane in 0..LANES {
            integrals[lane] = 2.0 * half[lane] * of.coefficients[0];
        }
        return;
    }
    let of_lines = of.along_z(x, y);
    // Three Gauss nodes integrate a polynomial of degree 5.
    let (mut below, mut above) = ([0.0; LANES], [0.0; LANES]);
    for lane in 0..LANES {
        let beside = half[lane] * 0.6_f64.sqrt();
        below[lane] = middle[lane] - beside;
        above[lane] = middle[lane] + beside;
    }
    let below = dot(&of_lines, &legendre_between(&below, of.low[2], of.high[2]));
    let above = dot(&of_lines, &legendre_between(&above, of.low[2], of.high[2]));
    let middle = dot(&of_lines, &legendre_between(&middle, of.low[2], of.high[2]));
    for lane in 0..LANES {
        let sum = 5.0 * (below[lane] + above[lane]);
        integrals[lane] = half[lane] * (sum + 8.0 * middle[lane]) / 9.0;
    }
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
                for (powers, of_column) in powers().zip(of_columns) {
                    best.coefficients[number(powers)] = of_column;
                }
            }
        }
        best
    }

    /// The coefficients in Legendre polynomials of z on the lines at places (x, y).
    #[inline(always)]
    fn along_z(&self, x: &Lanes, y: &Lanes) -> [Lanes; DEGREE + 1] {
        let of_x = legendre_between(x, self.low[0], self.high[0]);
        let of_y = legendre_between(y, self.low[1], self.high[1]);
        let (mut products, mut number) = ([[0.0; LANES]; TERMS_OF_XY[DEGREE]], 0);
        for degree in 0..=DEGREE {
            for j in 0..=degree {
                for lane in 0..LANES {
                    products[number][lane] = of_x[degree - j][lane] * of_y[j][lane];
                }
                number += 1;
            }
        }
        // Loops of constant length: of a lower degree, the sums have terms of 0.
        let (mut sums, mut first) = ([[0.0; LANES]; DEGREE + 1], 0);
        for (k, of_power) in sums.iter_mut().enumerate() {
            // Not in place: a sum that goes through memory waits for each addition several times as long.
            let mut sums = [0.0; LANES];
            for term in 0..TERMS_OF_XY[DEGREE - k] {
                for lane in 0..LANES {
                    sums[lane] += self.coefficients[first + term] * products[term][lane];
                }
            }
            *of_power = sums;
            first += TERMS_OF_XY[DEGREE - k];
        }
        sums
    }

    /// The values of the terms at a point.
    fn terms(&self, at: [f64; 3]) -> impl Iterator<Item = f64> + use<> {
        let local = core::array::from_fn::<_, 3, _>(|k| legendre(local(at[k], self.low[k], self.high[k])));
        powers().map(move |[i, j, k]| local[0][i] * local[1][j] * local[2][k])
    }

    /// The value at a point.
    pub(super) fn value(&self, at: [f64; 3]) -> f64 {
        if self.degree == 0 {
            return self.coefficients[0];
        }
        let [x, y, z] = at.map(|along| [along; LANES]);
        dot(&self.along_z(&x, &y), &legendre_between(&z, self.low[2], self.high[2]))[0]
    }

    /// The axis along which the higher terms are largest.
    pub(super) fn roughest_axis(&self) -> usize {
        let mut sums = [0.0; 3];
        for powers in powers() {
            let coefficient = self.coefficients[number(powers)];
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
