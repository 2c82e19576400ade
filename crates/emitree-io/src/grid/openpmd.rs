//! Meshes of the openPMD standard (version 1.1, doi:10.5281/zenodo.591699) in HDF5: their axes and units are attributes.
//!
//! `gridSpacing`, `gridGlobalOffset`, `gridUnitSI`, `axisLabels` and `dataOrder` are those of the mesh: of the
//! dataset itself if it is a scalar, of its group if it is a component of a vector. `position` and `unitSI`
//! are those of the dataset.

use netcdf_reader::{NcAttrValue, NcFile};

/// A mesh, its axes in the order of the dimensions in the file.
pub(super) struct Mesh {
    /// The names of the axes.
    pub(super) labels: Vec<String>,
    spacing: Vec<f64>,
    offset: Vec<f64>,
    /// Where in a cell the values are, from 0 to 1.
    position: Vec<f64>,
    /// Of lengths.
    grid_unit_si: f64,
    /// Of the values.
    pub(super) unit_si: f64,
}

impl Mesh {
    /// The mesh whose values are a dataset; `None` of one that has not the attributes of a mesh.
    pub(super) fn of(file: &NcFile, dataset: &str) -> Option<Self> {
        let variable = file.variable(dataset).ok()?;
        let group = dataset.rsplit_once('/').and_then(|(group, _)| file.group(group).ok());
        let own = |name: &str| variable.attribute(name).map(|attribute| &attribute.value);
        let of_mesh = |name: &str| {
            let of_group =
                || group.and_then(|group| group.attributes.iter().find(|a| a.name == name));
            own(name).or_else(|| of_group().map(|attribute| &attribute.value))
        };
        let numbers = |value: Option<&NcAttrValue>| value.and_then(NcAttrValue::as_f64_vec);
        let count = variable.ndim();
        let mut spacing = numbers(of_mesh("gridSpacing"))?;
        let mut offset = numbers(of_mesh("gridGlobalOffset"))?;
        let mut labels = match of_mesh("axisLabels")? {
            NcAttrValue::Strings(labels) => labels.clone(),
            // Labels of one letter each may be one text.
            NcAttrValue::Chars(text) => {
                text.chars().filter(|c| *c != '\0').map(String::from).collect()
            }
            _ => return None,
        };
        let mut position = numbers(own("position")).unwrap_or_else(|| vec![0.0; count]);
        let lists = [&spacing, &offset, &position];
        if labels.len() != count || lists.iter().any(|list| list.len() != count) {
            return None;
        }
        let order = of_mesh("dataOrder").and_then(NcAttrValue::as_string);
        if order.is_some_and(|order| order.starts_with('F')) {
            labels.reverse();
            [&mut spacing, &mut offset, &mut position].into_iter().for_each(|list| list.reverse());
        }
        let number =
            |value: Option<&NcAttrValue>| value.and_then(NcAttrValue::as_f64).unwrap_or(1.0);
        let (grid_unit_si, unit_si) = (number(of_mesh("gridUnitSI")), number(own("unitSI")));
        let labels =
            labels.into_iter().map(|label| label.trim_end_matches('\0').to_owned()).collect();
        Some(Self { labels, spacing, offset, position, grid_unit_si, unit_si })
    }

    /// The places of `count` values along the axis that has one of these names, in metres.
    pub(super) fn nodes(&self, names: &[&str], count: usize) -> Option<Vec<f64>> {
        let is_named = |label: &String| names.contains(&label.to_lowercase().as_str());
        let axis = self.labels.iter().position(is_named)?;
        let place = |index: usize| {
            let cells = index as f64 + self.position[axis];
            self.grid_unit_si * (self.offset[axis] + cells * self.spacing[axis])
        };
        Some((0..count).map(place).collect())
    }
}
