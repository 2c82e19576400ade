//! A function on a chart by its means over the cells of a raster, and its values at any place.
//!
//! The value at a place is that of the polynomial of degree 3 along each axis that has the means of
//! the four cells around it: means of the polynomial over these cells are the given ones.

/// Cells from which a value is computed along each axis.
const CELLS: usize = 4;

/// A place on a raster: the first of the cells along one axis, and their weights.
#[derive(Clone, Copy, Debug)]
struct Along {
    first: usize,
    weights: [f64; CELLS],
}

impl Along {
    /// At `x` ∈ \[0, 1\] on an axis of `cells` cells, four or more.
    #[inline(always)]
    fn new(x: f64, cells: usize) -> Self {
        let at = x.clamp(0.0, 1.0) * cells as f64;
        let first = crate::cell::whole(at).saturating_sub(1).min(cells - CELLS);
        let t = at - first as f64;
        let weights = WEIGHTS.map(|c| c[0] + t * (c[1] + t * (c[2] + t * c[3])));
        Self { first, weights }
    }
}

/// For each cell the coefficients, in ascending powers of the distance t from the lower border of
/// the first one, of its weight. The sum of the cells below border k is the value at k of a
/// polynomial of degree 4, and the function is its slope: the weight of a cell is the slope of the
/// sum of the Lagrange polynomials of all borders above it.
const WEIGHTS: [[f64; CELLS]; CELLS] = {
    let mut weights = [[0.0; CELLS]; CELLS];
    let mut border = 1;
    while border <= CELLS {
        // The Lagrange polynomial of this border.
        let mut polynomial = [0.0; CELLS + 1];
        polynomial[0] = 1.0;
        let mut other = 0;
        while other <= CELLS {
            if other != border {
                let scale = border as f64 - other as f64;
                let mut power = CELLS;
                while power > 0 {
                    polynomial[power] =
                        (polynomial[power - 1] - other as f64 * polynomial[power]) / scale;
                    power -= 1;
                }
                polynomial[0] = -(other as f64) * polynomial[0] / scale;
            }
            other += 1;
        }
        let mut cell = 0;
        while cell < border {
            let mut power = 0;
            while power < CELLS {
                weights[cell][power] += (power + 1) as f64 * polynomial[power + 1];
                power += 1;
            }
            cell += 1;
        }
        border += 1;
    }
    weights
};

/// The weights of the means of a raster in the value at one place.
#[derive(Clone, Copy, Debug)]
struct Place {
    x: Along,
    y: Along,
}

impl Place {
    /// At (u, v) ∈ \[0, 1\]² on a raster of `shape` = \[rows, columns\], four or more of each.
    #[inline(always)]
    fn new([u, v]: [f64; 2], [rows, columns]: [usize; 2]) -> Self {
        Self { x: Along::new(u, columns), y: Along::new(v, rows) }
    }

    /// The value there of the function with the given `means`, row by row of `columns` cells.
    #[inline(always)]
    fn value(&self, means: &[f64], columns: usize) -> f64 {
        let of_row = |k: usize| {
            let first = (self.y.first + k) * columns + self.x.first;
            let cells = &means[first..first + CELLS];
            cells.iter().zip(self.x.weights).map(|(mean, weight)| mean * weight).sum::<f64>()
        };
        (0..CELLS).map(|k| self.y.weights[k] * of_row(k)).sum()
    }
}

/// A function on a chart by its means over the cells of a raster.
#[derive(Clone, Debug)]
pub(crate) struct Raster {
    /// Row by row.
    means: Vec<f64>,
    /// Rows and columns.
    pub(crate) shape: [usize; 2],
}

impl Raster {
    /// The raster with these means, row by row.
    pub(crate) fn new(shape: [usize; 2], means: Vec<f64>) -> Self {
        Self { means, shape }
    }

    /// The value of the function at (u, v) ∈ \[0, 1\]².
    #[inline(always)]
    pub(crate) fn value(&self, uv: [f64; 2]) -> f64 {
        Place::new(uv, self.shape).value(&self.means, self.shape[1])
    }

    /// The same function on the raster with half as many rows and columns; both numbers must be even, and
    /// eight or more.
    pub(crate) fn halved(&self) -> Self {
        let columns = self.shape[1];
        let shape = self.shape.map(|cells| cells / 2);
        let pairs = self.means.chunks_exact(2 * columns);
        let of_pair = |pair: &[f64]| {
            let (first, second) = pair.split_at(columns);
            let quadruples = first.chunks_exact(2).zip(second.chunks_exact(2));
            quadruples.map(|(a, b)| 0.25 * (a[0] + a[1] + b[0] + b[1])).collect::<Vec<_>>()
        };
        Self { means: pairs.flat_map(of_pair).collect(), shape }
    }
}

/// The cell of a raster that contains (u, v).
pub(crate) fn cell_at([u, v]: [f64; 2], [rows, columns]: [usize; 2]) -> usize {
    let along =
        |x: f64, cells: usize| crate::cell::whole(x.clamp(0.0, 1.0) * cells as f64).min(cells - 1);
    along(v, rows) * columns + along(u, columns)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubics_follow_from_their_means() {
        let shape = [5, 9];
        let cubic = |x: f64| 1.0 - 2.0 * x + 3.0 * x * x - x.powi(3);
        let mean = |k: usize, n: usize| {
            let integral = |x: f64| x - x * x + x.powi(3) - 0.25 * x.powi(4);
            let [low, high] = [k, k + 1].map(|k| k as f64 / n as f64);
            (integral(high) - integral(low)) * n as f64
        };
        let means: Vec<f64> = (0..shape[0])
            .flat_map(|row| (0..shape[1]).map(move |column| mean(row, 5) * mean(column, 9)))
            .collect();
        for u in [0.0, 0.13, 0.5, 0.77, 1.0] {
            for v in [0.0, 0.31, 0.6, 1.0] {
                let found = Place::new([u, v], shape).value(&means, shape[1]);
                assert!((found - cubic(u) * cubic(v)).abs() < 1e-12, "{u} {v}");
            }
        }
    }

    /// The error of smooth functions falls with the fourth power of the size of a cell.
    #[test]
    fn values_converge_with_the_fourth_power() {
        let worst = |cells: usize| {
            let border = |k: usize| (5.0 * k as f64 / cells as f64).sin() / 5.0 * cells as f64;
            let along: Vec<f64> = (0..cells).map(|k| border(k + 1) - border(k)).collect();
            let means: Vec<f64> =
                along.iter().flat_map(|a| along.iter().map(move |b| a * b)).collect();
            let wrong = |k: usize| {
                let [u, v] = [k % 40, k / 40].map(|i| (i as f64 + 0.5) / 40.0);
                let value = Place::new([u, v], [cells; 2]).value(&means, cells);
                (value - (5.0 * u).cos() * (5.0 * v).cos()).abs()
            };
            (0..1600).map(wrong).fold(0.0, f64::max)
        };
        let [coarse, fine] = [16, 64].map(worst);
        assert!(coarse < 5e-3 && fine < coarse / 128.0, "{coarse} {fine}");
    }

    #[test]
    fn a_halved_raster_has_the_means_of_four_cells() {
        let raster = Raster::new([8, 10], (0..80).map(f64::from).collect());
        let halved = raster.halved();
        assert_eq!(halved.shape, [4, 5]);
        for (cell, mean) in [(0, 5.5), (1, 7.5), (19, 73.5)] {
            assert!((halved.means[cell] - mean).abs() < 1e-12, "{cell}");
        }
        // Both have the linear function itself.
        for uv in [[0.1, 0.7], [0.52, 0.03]] {
            assert!((raster.value(uv) - halved.value(uv)).abs() < 1e-12);
        }
    }

    #[test]
    fn a_place_is_in_the_cell_around_it() {
        let shape = [3, 5];
        assert_eq!(cell_at([0.0, 0.0], shape), 0);
        assert_eq!(cell_at([0.39, 0.34], shape), 5 + 1);
        assert_eq!(cell_at([0.41, 0.32], shape), 2);
        assert_eq!(cell_at([1.0, 1.0], shape), 14);
        assert_eq!(cell_at([-0.5, 1.5], shape), 10);
    }
}
