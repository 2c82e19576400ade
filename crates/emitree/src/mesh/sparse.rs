//! Sparse matrices by rows: the weights of a mesh.

use crate::cell::to_u32;
use crate::parallel::prelude::*;

/// The smallest number of rows for a thread.
const ROWS_PER_TASK: usize = 1024;

/// A sparse matrix in compressed rows (CSR): row r has the weights `data[indptr[r]..indptr[r + 1]]` in the
/// columns `indices[indptr[r]..indptr[r + 1]]`, each column at most once.
///
/// ```
/// use emitree::{Canonical, Image, Method, RenderOptions, Session, los::LosOptions};
///
/// let options = RenderOptions::new(Method::Los(LosOptions::default()));
/// let mut session = Session::<Image>::new(&Canonical as &dyn emitree::Projection, [2, 3], &options)?;
/// while let Some(points) = session.ask() {
///     session.tell(&vec![1.0; points.len()])?;
/// }
/// let mesh = session.mesh()?;
/// // A node is a line of sight here, with 64 steps.
/// assert_eq!([mesh.weights().rows(), mesh.weights().columns()], [6, 6 * 64]);
/// assert_eq!(mesh.weights().row(0).count(), 64);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SparseMatrix {
    columns: usize,
    indptr: Vec<usize>,
    indices: Vec<u32>,
    data: Vec<f64>,
}

impl SparseMatrix {
    /// No rows and no columns yet.
    pub(crate) fn new() -> Self {
        Self { columns: 0, indptr: vec![0], indices: Vec::new(), data: Vec::new() }
    }

    /// No rows yet, so many columns.
    pub(crate) fn with_columns(columns: usize) -> Self {
        Self { columns, ..Self::new() }
    }

    /// Adds a row; weights in one column are added up, and the matrix has all columns named.
    pub(crate) fn push(&mut self, mut entries: Vec<(usize, f64)>) {
        entries.sort_by_key(|(column, _)| *column);
        for of_column in entries.chunk_by(|a, b| a.0 == b.0) {
            self.columns = self.columns.max(of_column[0].0 + 1);
            self.indices.push(to_u32(of_column[0].0));
            self.data.push(of_column.iter().map(|(_, weight)| weight).sum());
        }
        self.indptr.push(self.indices.len());
    }

    /// Adds the rows of another matrix, whose columns come after those of this one.
    pub(crate) fn append(&mut self, other: &Self) {
        let (before, columns) = (self.indices.len(), self.columns);
        self.indptr.extend(other.indptr[1..].iter().map(|end| before + end));
        self.indices.extend(other.indices.iter().map(|column| to_u32(columns) + column));
        self.data.extend(&other.data);
        self.columns += other.columns;
    }

    /// The number of rows.
    pub fn rows(&self) -> usize {
        self.indptr.len() - 1
    }

    /// The number of columns.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Where each row begins in [`indices`](Self::indices) and [`data`](Self::data), and the end.
    pub fn indptr(&self) -> &[usize] {
        &self.indptr
    }

    /// The columns of all weights, row after row.
    pub fn indices(&self) -> &[u32] {
        &self.indices
    }

    /// All weights, row after row.
    pub fn data(&self) -> &[f64] {
        &self.data
    }

    /// The columns of one row with their weights.
    ///
    /// # Panics
    ///
    /// If there is no such row.
    pub fn row(&self, row: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let of_row = self.indptr[row]..self.indptr[row + 1];
        let columns = self.indices[of_row.clone()].iter().map(|column| *column as usize);
        columns.zip(self.data[of_row].iter().copied())
    }

    /// The product with a column of numbers.
    ///
    /// # Panics
    ///
    /// If there are not as many numbers as columns.
    pub fn times(&self, values: &[f64]) -> Vec<f64> {
        assert_eq!(values.len(), self.columns, "one number for each column");
        let of_row = |row: usize| self.row(row).map(|(k, weight)| weight * values[k]).sum();
        (0..self.rows()).into_par_iter().with_min_len(ROWS_PER_TASK).map(of_row).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix() -> SparseMatrix {
        let mut matrix = SparseMatrix::new();
        matrix.push(vec![(2, 3.0), (0, 1.0), (2, 0.5)]);
        matrix.push(vec![]);
        matrix.push(vec![(1, -2.0)]);
        matrix
    }

    #[test]
    fn weights_in_one_column_add_up() {
        let matrix = matrix();
        assert_eq!([matrix.rows(), matrix.columns()], [3, 3]);
        assert_eq!(matrix.row(0).collect::<Vec<_>>(), [(0, 1.0), (2, 3.5)]);
        assert_eq!(matrix.times(&[10.0, 100.0, 1000.0]), [3510.0, 0.0, -200.0]);
        assert_eq!((matrix.indptr(), matrix.indices()), (&[0, 2, 2, 3][..], &[0, 2, 1][..]));
    }

    #[test]
    fn matrices_are_appended_along_the_diagonal() {
        let mut both = matrix();
        both.append(&matrix());
        assert_eq!([both.rows(), both.columns()], [6, 6]);
        let values = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        let expected = [matrix().times(&values[..3]), matrix().times(&values[3..])].concat();
        assert_eq!(both.times(&values), expected);
    }
}
