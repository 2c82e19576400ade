//! Arrays as files have them, and the interface of every format.

use super::budget::{Budget, TWO_ORDERS};
use super::error::GridReadError;
use super::order::ArrayOrder;
use emitree_models::grid::Coordinates;

/// An array of a file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Array {
    /// The length of each axis, in the order that the format writes indices in.
    pub(crate) shape: Vec<usize>,
    /// How far apart in `values` neighbours along each axis are.
    strides: Vec<usize>,
    /// As many as the shape has room for.
    values: Vec<f64>,
    /// The unit of the values.
    pub(super) unit: Option<String>,
    /// The names of the axes; none where the format has no names for them.
    pub(crate) axis_names: Vec<String>,
}

impl Array {
    /// An array whose last axis varies fastest. The caller has counted the values.
    pub(super) fn c_order(shape: Vec<usize>, values: Vec<f64>) -> Self {
        let mut strides = products(shape.iter().rev());
        strides.reverse();
        Self { shape, strides, values, unit: None, axis_names: Vec::new() }
    }

    /// An array whose first axis varies fastest. The caller has counted the values.
    pub(super) fn fortran_order(shape: Vec<usize>, values: Vec<f64>) -> Self {
        let strides = products(shape.iter());
        Self { shape, strides, values, unit: None, axis_names: Vec::new() }
    }

    /// The unit of the values.
    pub(crate) fn unit(&self) -> Option<&str> {
        self.unit.as_deref()
    }

    /// Multiplies all values.
    #[cfg(feature = "hdf5")]
    pub(super) fn scale(&mut self, factor: f64) {
        if factor.to_bits() != 1.0_f64.to_bits() {
            self.values.iter_mut().for_each(|value| *value *= factor);
        }
    }

    /// The array at the chosen places of some axes, without those axes.
    pub(crate) fn selected(mut self, selection: &[Option<usize>]) -> Self {
        let chosen = |axis: usize| selection.get(axis).copied().flatten();
        if !(0..self.shape.len()).any(|axis| chosen(axis).is_some()) {
            return self;
        }
        let start: usize =
            self.strides.iter().enumerate().map(|(axis, s)| s * chosen(axis).unwrap_or(0)).sum();
        let kept = || (0..self.shape.len()).filter(|&axis| chosen(axis).is_none());
        let shape: Vec<usize> = kept().map(|axis| self.shape[axis]).collect();
        let strides: Vec<usize> = kept().map(|axis| self.strides[axis]).collect();
        let lengths = products(shape.iter().rev());
        let count: usize = shape.iter().product();
        let place = |at: usize| {
            let parts = lengths.iter().rev().zip(&shape).zip(&strides);
            start
                + parts.map(|((after, length), stride)| at / after % length * stride).sum::<usize>()
        };
        let values = (0..count).map(|at| self.values[place(at)]).collect();
        self.axis_names = match self.axis_names.len() == self.shape.len() {
            true => kept().map(|axis| self.axis_names[axis].clone()).collect(),
            false => Vec::new(),
        };
        let (unit, axis_names) = (self.unit, self.axis_names);
        Self { unit, axis_names, ..Self::c_order(shape, values) }
    }

    /// The numbers of an array that has no second axis longer than 1.
    pub(crate) fn into_line(self) -> Result<Vec<f64>, GridReadError> {
        if self.shape.iter().filter(|&&length| length != 1).count() <= 1 {
            Ok(self.values)
        } else {
            Err(GridReadError::NotALine { shape: self.shape })
        }
    }

    /// The values of an array of any axes, the last one varying fastest.
    pub(crate) fn into_last_fastest(self) -> Vec<f64> {
        let wanted = products(self.shape.iter().rev());
        if wanted.iter().rev().eq(&self.strides) {
            return self.values;
        }
        let place = |mut at: usize| {
            let lengths = self.shape.iter().zip(&self.strides).rev();
            lengths.fold(0, |place, (length, stride)| {
                let index = at % length;
                at /= length;
                place + index * stride
            })
        };
        (0..self.values.len()).map(|at| self.values[place(at)]).collect()
    }

    /// The values of an array of two axes, row after row.
    pub(super) fn into_rows(self) -> Vec<f64> {
        let [rows, columns] = [self.shape[0], self.shape[1]];
        let [of_row, of_column] = [self.strides[0], self.strides[1]];
        if of_column == 1 {
            return self.values;
        }
        let row = |i: usize| (0..columns).map(move |j| i * of_row + j * of_column);
        (0..rows).flat_map(row).map(|at| self.values[at]).collect()
    }

    /// The values of an array of any number of axes, the last one varying fastest.
    pub(crate) fn into_c_order(self) -> Vec<f64> {
        let mut strides = products(self.shape.iter().rev());
        strides.reverse();
        if self.strides == strides {
            return self.values;
        }
        let place = |at: usize| -> usize {
            let axes = self.shape.iter().zip(&strides).zip(&self.strides);
            axes.map(|((length, of_c), own)| at / of_c % length * own).sum()
        };
        (0..self.values.len()).map(|at| self.values[place(at)]).collect()
    }

    /// The order of the axes of these coordinates: the requested one, which must not contradict their names, or
    /// the one that the names give, or the first axis last.
    pub(super) fn order(
        &self,
        coordinates: Coordinates,
        asked: Option<ArrayOrder>,
    ) -> Result<ArrayOrder, GridReadError> {
        let named = ArrayOrder::from_names(coordinates, &self.axis_names);
        match (asked, named) {
            (Some(asked), _) if asked.coordinates() != coordinates => {
                Err(GridReadError::OrderOfOthers { asked, coordinates })
            }
            (Some(asked), Some(named)) if asked != named => {
                Err(GridReadError::Order { asked, named })
            }
            _ => Ok(asked.or(named).unwrap_or(ArrayOrder::reversed(coordinates))),
        }
    }

    /// The values of an array of three axes, x (or the first of others) varying fastest, then y.
    ///
    /// Another order is made in a second array: both must fit in memory.
    pub(super) fn into_x_fastest(
        self,
        order: ArrayOrder,
        budget: Budget,
    ) -> Result<Vec<f64>, GridReadError> {
        let places = [0, 1, 2].map(|axis| order.place_of(axis));
        let [nx, ny, nz] = places.map(|place| self.shape[place]);
        let [x_stride, y_stride, z_stride] = places.map(|place| self.strides[place]);
        if [x_stride, y_stride, z_stride] == [1, nx, nx * ny] {
            return Ok(self.values);
        }
        budget.check(&self.shape, TWO_ORDERS, 0)?;
        let mut values = budget.reserve(&self.shape, 0)?;
        for z in 0..nz {
            for y in 0..ny {
                let row = z * z_stride + y * y_stride;
                values.extend((0..nx).map(|x| self.values[row + x * x_stride]));
            }
        }
        Ok(values)
    }
}

/// The products of all lengths before each: 1, then the first, and so on.
fn products<'a>(lengths: impl Iterator<Item = &'a usize>) -> Vec<usize> {
    let next = |product: &mut usize, length: &usize| {
        let before = *product;
        *product = product.saturating_mul(*length);
        Some(before)
    };
    lengths.scan(1, next).collect()
}

/// The axes of an array.
pub(crate) struct Described {
    /// The length of each axis.
    pub(crate) shape: Vec<usize>,
    /// The names of the axes; none where the format has no names for them.
    pub(crate) axis_names: Vec<String>,
}

/// A file that has been opened, of whatever format.
pub(crate) trait Container {
    /// The axes of the values: those of this name, or those that the format has by default.
    fn describe(&mut self, name: Option<&str>) -> Result<Described, GridReadError>;

    /// These values at the chosen places of the axes that have one, without those axes; nothing is chosen of axes
    /// beyond the list.
    fn values(
        &mut self,
        name: Option<&str>,
        selection: &[Option<usize>],
    ) -> Result<Array, GridReadError>;

    /// An array by its name, which may be relative to that of the values.
    fn array_beside(&mut self, name: &str) -> Result<Array, GridReadError> {
        self.array(name)
    }

    /// An array by its name.
    fn array(&mut self, name: &str) -> Result<Array, GridReadError>;

    /// The nodes in the file itself along `axis` (0 is x), which has one of `names` there and is the one at
    /// `place` of the array of the values.
    fn nodes(
        &mut self,
        axis: usize,
        names: &[&str],
        place: usize,
        values: &Array,
    ) -> Result<Nodes, GridReadError>;
}

/// The nodes along an axis, and what a file says of them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Nodes {
    pub(crate) values: Vec<f64>,
    /// The name of their array.
    pub(super) name: String,
    pub(super) unit: Option<String>,
}

impl Nodes {
    /// Nodes that no file says anything of.
    pub(super) fn plain(values: Vec<f64>) -> Self {
        Self { values, name: String::new(), unit: None }
    }

    /// The numbers of an array with one axis.
    pub(super) fn of(name: &str, array: Array) -> Result<Self, GridReadError> {
        let unit = array.unit.clone();
        Ok(Self { values: array.into_line()?, name: name.to_owned(), unit })
    }
}

#[cfg(test)]
mod tests {
    use super::super::request::GridRequest;
    use super::*;

    /// 100 z + 10 y + x at [z, y, x] of 2 x 3 x 4, as an array of any order of axes.
    fn array(order: ArrayOrder, fortran: bool) -> Array {
        let lengths = [4, 3, 2];
        let axis_at = |place: usize| (0..3).find(|&axis| order.place_of(axis) == place).unwrap();
        let axes = [0, 1, 2].map(axis_at);
        let shape: Vec<usize> = axes.iter().map(|&axis| lengths[axis]).collect();
        let weight = |axis: usize| [1.0, 10.0, 100.0][axis];
        let mut values = vec![0.0; 24];
        for (at, value) in values.iter_mut().enumerate() {
            let mut rest = at;
            let mut places = [0, 1, 2];
            if !fortran {
                places.reverse();
            }
            for place in places {
                *value += weight(axes[place]) * (rest % shape[place]) as f64;
                rest /= shape[place];
            }
        }
        if fortran { Array::fortran_order(shape, values) } else { Array::c_order(shape, values) }
    }

    #[test]
    fn any_order_is_turned_to_x_fastest() {
        let mut expected = Vec::new();
        for z in [0.0, 100.0] {
            for y in [0.0, 10.0, 20.0] {
                expected.extend([0.0, 1.0, 2.0, 3.0].map(|x| x + y + z));
            }
        }
        let budget = Budget::of(&GridRequest::default());
        for text in ["xyz", "xzy", "yxz", "yzx", "zxy", "zyx"] {
            let order: ArrayOrder = text.parse().unwrap();
            assert_eq!(order.to_string(), text);
            for fortran in [false, true] {
                let values = array(order, fortran).into_x_fastest(order, budget).unwrap();
                assert_eq!(values, expected, "{text} {fortran}");
            }
        }
    }

    #[test]
    fn only_lines_are_axes() {
        let line = Array::c_order(vec![1, 3, 1], vec![1.0, 2.0, 3.0]);
        assert_eq!(line.into_line().unwrap(), [1.0, 2.0, 3.0]);
        let error = Array::c_order(vec![2, 2], vec![0.0; 4]).into_line().unwrap_err();
        assert_eq!(error.to_string(), "it is an array of shape [2, 2]: expected one axis");
    }

    #[test]
    fn names_of_axes_tell_their_order() {
        let mut array = Array::c_order(vec![1, 1, 1], vec![0.0]);
        assert_eq!(array.order(Coordinates::Cartesian, None).unwrap(), ArrayOrder::ZYX);
        array.axis_names = ["X", "y", "z"].map(str::to_owned).to_vec();
        assert_eq!(array.order(Coordinates::Cartesian, None).unwrap(), ArrayOrder::XYZ);
        assert_eq!(
            array.order(Coordinates::Cartesian, Some(ArrayOrder::XYZ)).unwrap(),
            ArrayOrder::XYZ
        );
        let error = array.order(Coordinates::Cartesian, Some(ArrayOrder::ZYX)).unwrap_err();
        assert_eq!(
            error.to_string(),
            "the order of axes is given as zyx, but the file names them xyz: expected the same"
        );
        array.axis_names = ["lat", "y", "z"].map(str::to_owned).to_vec();
        assert_eq!(
            array.order(Coordinates::Cartesian, Some(ArrayOrder::XYZ)).unwrap(),
            ArrayOrder::XYZ
        );
    }
}
