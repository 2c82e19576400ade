//! Cubes of VTK: images (structured points) and rectilinear grids, in the legacy format or in XML.
//!
//! The x coordinate varies fastest. Data of cells have their nodes at the centres of cells. `vtk/legacy.rs` and
//! `vtk/xml.rs` are the two formats, `vtk/blocks.rs` the bytes of arrays in XML.

mod blocks;
mod legacy;
mod xml;

use super::array::{Array, Container, Described, Nodes};
use super::budget::Budget;
use super::error::GridReadError;
use super::request::GridFormat;
use std::io::Read;

/// The endings of names that choose a component of vectors.
const COMPONENTS: [&str; 3] = [":x", ":y", ":z"];

/// A file of arrays on one grid.
pub(super) struct VtkCube {
    content: Content,
    /// Whether the values that were read are those of cells.
    is_of_cells: bool,
    budget: Budget,
}

/// What is in a file.
struct Content {
    /// The coordinates of points along x, y and z.
    points: [Vec<f64>; 3],
    arrays: Vec<Data>,
    source: Box<dyn Source>,
}

/// An array of the data.
#[derive(Debug)]
struct Data {
    name: String,
    components: usize,
    is_of_cells: bool,
}

/// The numbers of arrays, by their place among all arrays.
trait Source {
    /// The bytes that it holds.
    fn bytes(&self) -> usize;

    /// Calls `take` with the index and the value of each number of an array, of which `count` are expected.
    fn each(
        &self,
        number: usize,
        count: usize,
        take: &mut dyn FnMut(usize, f64),
    ) -> Result<(), GridReadError>;
}

impl VtkCube {
    /// The grid in a source of `length` bytes.
    pub(super) fn open(
        mut source: impl Read,
        length: u64,
        budget: Budget,
    ) -> Result<Self, GridReadError> {
        budget.check(&[usize::try_from(length).unwrap_or(usize::MAX)], 1, 0)?;
        let mut bytes = Vec::new();
        source.read_to_end(&mut bytes).map_err(GridReadError::Unreadable)?;
        let content = if xml::is_xml(&bytes) {
            xml::open(bytes, budget)?
        } else {
            legacy::Legacy::open(bytes)?
        };
        Ok(Self { content, is_of_cells: false, budget })
    }

    /// The number of an array, and which of its components is meant.
    fn find(&self, name: Option<&str>) -> Result<(usize, usize), GridReadError> {
        let missing = |name: &str| {
            let available = self.content.arrays.iter().flat_map(|data| match data.components {
                3 => COMPONENTS.map(|component| format!("{}{component}", data.name)).to_vec(),
                _ => vec![data.name.clone()],
            });
            GridReadError::Missing { name: name.to_owned(), available: available.collect() }
        };
        let arrays = || self.content.arrays.iter().enumerate();
        let mut scalars = arrays().filter(|(_, data)| data.components == 1);
        let Some(name) = name else {
            return match (scalars.next(), scalars.next()) {
                (Some((only, _)), None) => Ok((only, 0)),
                _ => Err(missing("values")),
            };
        };
        if let Some((number, _)) = scalars.find(|(_, data)| data.name == name) {
            return Ok((number, 0));
        }
        let component = COMPONENTS.iter().enumerate().find_map(|(component, ending)| {
            let of = name.strip_suffix(ending)?;
            let is_vector = |data: &Data| data.components == 3 && data.name == of;
            Some((arrays().find(|(_, data)| is_vector(data))?.0, component))
        });
        component.ok_or_else(|| missing(name))
    }

    /// The numbers of points or cells along z, y and x.
    fn shape(&self, is_of_cells: bool) -> Vec<usize> {
        let fewer = usize::from(is_of_cells);
        let lengths = self
            .content
            .points
            .iter()
            .rev()
            .map(|points| points.len().saturating_sub(fewer).max(1));
        lengths.collect()
    }
}

impl Container for VtkCube {
    fn describe(&mut self, name: Option<&str>) -> Result<Described, GridReadError> {
        let (number, _) = self.find(name)?;
        let axis_names = ["z", "y", "x"].map(str::to_owned).to_vec();
        Ok(Described { shape: self.shape(self.content.arrays[number].is_of_cells), axis_names })
    }

    fn values(&mut self, name: Option<&str>, _: &[Option<usize>]) -> Result<Array, GridReadError> {
        let (number, component) = self.find(name)?;
        let Content { arrays, source, .. } = &self.content;
        let data = &arrays[number];
        let shape = self.shape(data.is_of_cells);
        let mut values = self.budget.reserve(&shape, source.bytes() as u64)?;
        let expected: usize = shape.iter().product();
        let count = expected.saturating_mul(data.components);
        source.each(number, count, &mut |index, value| {
            if index % data.components == component {
                values.push(value);
            }
        })?;
        if values.len() != expected {
            let (name, found) = (&data.name, values.len());
            let reason =
                format!("the array `{name}` has {found} values: expected {expected}, of {shape:?}");
            return Err(malformed(reason));
        }
        self.is_of_cells = data.is_of_cells;
        let mut array = Array::c_order(shape, values);
        array.axis_names = ["z", "y", "x"].map(str::to_owned).to_vec();
        Ok(array)
    }

    fn array(&mut self, name: &str) -> Result<Array, GridReadError> {
        self.values(Some(name), &[])
    }

    fn nodes(
        &mut self,
        axis: usize,
        names: &[&str],
        _: usize,
        _: &Array,
    ) -> Result<Nodes, GridReadError> {
        let Some(points) =
            self.content.points.get(axis).filter(|_| ["x", "y", "z"].contains(&names[0]))
        else {
            return Err(GridReadError::NoNodes("Cartesian coordinates".to_owned()));
        };
        let middles = || points.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
        Ok(Nodes::plain(if self.is_of_cells { middles() } else { points.clone() }))
    }
}

fn malformed(reason: impl ToString) -> GridReadError {
    GridReadError::malformed(GridFormat::Vtk, reason)
}

#[cfg(test)]
mod tests;
