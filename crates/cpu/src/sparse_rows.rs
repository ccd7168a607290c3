//! Rows of a distance matrix in a sparse format.

/// Rows of a distance matrix with the distances within a radius, in compressed sparse row format (CSR), as in SciPy's
/// `csr_array`.
///
/// The entries of row r are those from `indptr[r]` to before `indptr[r + 1]`. Columns are grid points in
/// row-major order. A row includes its own point, at distance 0. The row of a hole is empty.
#[derive(Clone, Debug, PartialEq)]
pub struct SparseRows {
    /// Number of columns, which is the number of grid points.
    pub cols: usize,
    /// The first entry of each row, and the number of all entries.
    pub indptr: Vec<usize>,
    /// The column of each entry, ascending in each row.
    pub indices: Vec<u32>,
    /// The distance of each entry.
    pub data: Vec<f32>,
}

impl SparseRows {
    /// Creates an empty matrix with `cols` columns and no rows yet.
    pub fn with_cols(cols: usize) -> Self {
        Self { cols, indptr: vec![0], indices: Vec::new(), data: Vec::new() }
    }

    /// Appends a row, given its columns in ascending order and their distances.
    pub fn push(&mut self, row: Vec<(usize, f32)>) {
        self.indices.extend(row.iter().map(|&(column, _)| column as u32));
        self.data.extend(row.iter().map(|&(_, distance)| distance));
        self.indptr.push(self.data.len());
    }

    /// Returns the number of rows.
    pub fn rows(&self) -> usize {
        self.indptr.len() - 1
    }

    /// Returns the columns and the distances of a row.
    ///
    /// # Panics
    /// If there is no such row.
    pub fn row(&self, row: usize) -> impl Iterator<Item = (usize, f32)> {
        let entries = self.indptr[row]..self.indptr[row + 1];
        let columns = self.indices[entries.clone()].iter().map(|&column| column as usize);
        columns.zip(self.data[entries].iter().copied())
    }
}
