//! Cubes in FITS: an image of three axes, the first of them x, and its nodes.
//!
//! The layout of the modelling groups of the SMILE mission has the cube in the primary HDU, as
//! `numpy` reads it as `[z, y, x]`, and the nodes, evenly spaced or not, in image extensions `x`, `y`
//! and `z`. A cube without them has its nodes from the linear coordinates of its header.

use super::array::{Array, Container, Described, Nodes};
use super::budget::Budget;
use super::error::GridReadError;
use super::request::GridFormat;
use fits_well::FitsReader;
use fits_well::io::{Hdu, HduKind, StreamReader};
use std::io::{Read, Seek};
use std::ops::Range;

/// The axes of a cube.
const AXES: usize = 3;
/// What a term of the coordinates that should be 0 may be.
const ROUNDING: f64 = 1e-12;

/// A FITS file, and which of its HDUs has the values.
pub(super) struct FitsCube<R> {
    reader: StreamReader<R>,
    values: usize,
    budget: Budget,
}

impl<R: Read + Seek> FitsCube<R> {
    pub(super) fn open(source: R, budget: Budget) -> Result<Self, GridReadError> {
        let reader = FitsReader::open(source).map_err(malformed)?;
        match reader.scan_defect() {
            Some(defect) => Err(malformed(defect)),
            None => Ok(Self { reader, values: 0, budget }),
        }
    }

    /// The image in an HDU, its axes as C has them: the last one of FITS first.
    fn image(&mut self, index: usize, selection: &[Option<usize>]) -> Result<Array, GridReadError> {
        let mut image = self.reader.image(index).map_err(malformed)?;
        let axes = image.metadata().shape.to_vec();
        let chosen = |axis: usize| selection.get(axes.len() - 1 - axis).copied().flatten();
        let kept = (0..axes.len()).rev().filter(|&axis| chosen(axis).is_none());
        let shape: Vec<usize> = kept.map(|axis| axes[axis]).collect();
        let mut values = self.budget.reserve(&shape, 0)?;
        let range = |axis: usize| chosen(axis).map_or(0..axes[axis], |index| index..index + 1);
        let mut region: Vec<Range<usize>> = (0..axes.len()).map(range).collect();
        // One step of the last axis after the other, so that there are never two copies of the whole.
        for step in region.last().cloned().unwrap_or_default() {
            if let Some(last) = region.last_mut() {
                *last = step..step + 1;
            }
            image.physical_into(&region[..], &mut values).map_err(malformed)?;
        }
        let mut array = Array::c_order(shape, values);
        let header = &self.reader.hdus()[index].header;
        let unit = header.get_text("BUNIT").map_err(malformed)?.map(str::trim);
        array.unit = unit.filter(|unit| !unit.is_empty()).map(str::to_owned);
        Ok(array)
    }

    /// The image extension of this name, in either case.
    fn named(&self, name: &str) -> Option<usize> {
        self.reader
            .images()
            .find(|hdu| name_of(hdu).eq_ignore_ascii_case(name))
            .map(|hdu| hdu.index)
    }

    /// The images beside the values, if they have no names and are one for each axis at least.
    fn nameless(&self, axis: usize) -> Option<usize> {
        let others = || self.reader.images().filter(|hdu| hdu.index != self.values);
        if others().count() < AXES || others().any(|hdu| !name_of(hdu).is_empty()) {
            return None;
        }
        others().nth(axis).map(|hdu| hdu.index)
    }

    /// The nodes that the linear coordinates of the header give to an axis of FITS, from 1.
    fn linear_nodes(&self, n: usize, length: usize) -> Result<Option<Vec<f64>>, GridReadError> {
        let header = &self.reader.hdus()[self.values].header;
        let real = |keyword: String| header.get_real(keyword.as_str()).map_err(malformed);
        let matrix = real(format!("CD{n}_{n}"))?;
        let step = real(format!("CDELT{n}"))?.or(matrix);
        let pixel = real(format!("CRPIX{n}"))?;
        let (Some(pixel), Some(value), Some(step)) = (pixel, real(format!("CRVAL{n}"))?, step)
        else {
            return Ok(None);
        };
        for other in 1..=AXES {
            let identity = if other == n { 1.0 } else { 0.0 };
            let counts = |term: f64| term.abs() > ROUNDING;
            let rotation = real(format!("PC{n}_{other}"))?.filter(|term| counts(term - identity));
            let skew = real(format!("CD{n}_{other}"))?.filter(|&term| other != n && counts(term));
            if rotation.or(skew).is_some() {
                return Err(malformed(format!(
                    "its coordinate {n} depends on several axes of the image: expected none of the \
                     terms PC{n}_{other} and CD{n}_{other}"
                )));
            }
        }
        let node = |index: usize| value + (index as f64 + 1.0 - pixel) * step;
        Ok(Some((0..length).map(node).collect()))
    }
}

impl<R: Read + Seek> Container for FitsCube<R> {
    fn describe(&mut self, name: Option<&str>) -> Result<Described, GridReadError> {
        let index = self.values_at(name)?;
        let image = self.reader.image(index).map_err(malformed)?;
        let shape = image.metadata().shape.iter().rev().copied().collect();
        Ok(Described { shape, axis_names: Vec::new() })
    }

    fn values(
        &mut self,
        name: Option<&str>,
        selection: &[Option<usize>],
    ) -> Result<Array, GridReadError> {
        self.values = self.values_at(name)?;
        self.image(self.values, selection)
    }

    fn array(&mut self, name: &str) -> Result<Array, GridReadError> {
        let index = self.named(name).ok_or_else(|| self.missing(name))?;
        self.image(index, &[])
    }

    fn nodes(
        &mut self,
        axis: usize,
        names: &[&str],
        place: usize,
        values: &Array,
    ) -> Result<Nodes, GridReadError> {
        let named = names.iter().find_map(|name| Some((*name, self.named(name)?)));
        if let Some((name, index)) = named.or(self.nameless(axis).map(|index| ("", index))) {
            return Nodes::of(name, self.image(index, &[])?);
        }
        let n = AXES - place;
        let linear = self.linear_nodes(n, values.shape[place])?.map(Nodes::plain);
        let name = names.first().copied().unwrap_or_default();
        linear.ok_or_else(|| {
            GridReadError::NoNodes(format!(
                "an image extension `{name}`, or CRPIX{n}, CRVAL{n} and CDELT{n} in the header of \
                 the values"
            ))
        })
    }
}

impl<R: Read + Seek> FitsCube<R> {
    /// The HDU of the values: that of this name, or the first image.
    fn values_at(&self, name: Option<&str>) -> Result<usize, GridReadError> {
        match name {
            Some(name) => self.named(name).ok_or_else(|| self.missing(name)),
            None => match self.reader.images().next() {
                Some(hdu) => Ok(hdu.index),
                None => Err(self.no_image()),
            },
        }
    }

    fn missing(&self, name: &str) -> GridReadError {
        let names = self.reader.images().map(name_of).filter(|name| !name.is_empty());
        let available = names.map(str::to_owned).collect();
        match self.compressed() {
            Some(hdu) if name_of(hdu).eq_ignore_ascii_case(name) => compressed(hdu),
            _ => GridReadError::Missing { name: name.to_owned(), available },
        }
    }

    fn no_image(&self) -> GridReadError {
        self.compressed().map_or_else(|| malformed("it has no image"), compressed)
    }

    /// The first image that is compressed by tiles.
    fn compressed(&self) -> Option<&Hdu> {
        self.reader.hdus().iter().find(|hdu| hdu.kind == HduKind::CompressedImage)
    }
}

fn compressed(hdu: &Hdu) -> GridReadError {
    malformed(format!(
        "its image in HDU {} is compressed by tiles (ZIMAGE = T): expected one that is not, as \
         `funpack` makes it",
        hdu.index
    ))
}

/// The name of an HDU, `PRIMARY` for a primary one without; empty if there is none to be read.
fn name_of(hdu: &Hdu) -> &str {
    let default = if hdu.index == 0 { "PRIMARY" } else { "" };
    hdu.extname().ok().flatten().unwrap_or(default).trim()
}

fn malformed(reason: impl ToString) -> GridReadError {
    GridReadError::malformed(GridFormat::Fits, reason)
}
