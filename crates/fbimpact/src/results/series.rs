//! Time series: datasets that grow, written in blocks.

use hdf5::{Dataset, Error, Group, H5Type, Result};
use ndarray::{ArrayView1, ArrayView2, s};

use super::disk_space::BYTES_OF_DATASET;
use crate::scenario::Compression;

/// Rows of a chunk and of a write buffer.
pub const ROWS: usize = 256;
/// Columns of a chunk: tall chunks keep the history of one coordinate cheap to read.
const COLUMNS: usize = 16;

/// A dataset with one row a stored instant, written in blocks of [`ROWS`] rows.
pub struct Series<T> {
    dataset: Dataset,
    /// `None` for one value per row.
    width: Option<usize>,
    /// Rows not yet written.
    pub buffer: Vec<T>,
    written: usize,
}

impl<T: H5Type + Copy> Series<T> {
    /// Creates the dataset `name` in `group`; `width` is `None` for a one-dimensional dataset.
    pub fn create(group: &Group, name: &str, width: Option<usize>, compression: Compression) -> Result<Self> {
        let builder = group.new_dataset::<T>();
        // Rows come in order: two chunks a column of chunks are enough, the default of a megabyte
        // adds up.
        let chunk_bytes = ROWS * width.unwrap_or(1).max(1) * size_of::<T>();
        let builder = builder.chunk_cache(101, 2 * chunk_bytes, 1.0);
        let builder = match compression {
            Compression::None => builder,
            Compression::Gzip => builder.shuffle().deflate(1),
        };
        let dataset = match width {
            None => builder.chunk(ROWS).shape(0..).create(name)?,
            Some(w) => builder.chunk((ROWS, w.min(COLUMNS))).shape((0.., w)).create(name)?,
        };
        Ok(Self { dataset, width, buffer: Vec::with_capacity(ROWS * width.unwrap_or(1)), written: 0 })
    }

    /// The dataset.
    pub fn dataset(&self) -> &Dataset {
        &self.dataset
    }

    /// Bytes on the disk that writing a full buffer may take: a new row of chunks after one that is
    /// begun, and the tree.
    pub fn bytes_needed(&self) -> u64 {
        let chunks = self.width.unwrap_or(1).div_ceil(COLUMNS);
        let chunk = ROWS * self.width.unwrap_or(1).min(COLUMNS) * size_of::<T>();
        (chunks * 2 * chunk) as u64 + chunks as u64 * BYTES_OF_DATASET
    }

    /// Bytes on the disk that writing the buffer may take, however full it is.
    pub fn bytes_of_buffer(&self) -> u64 {
        let blocks = self.buffer.len().div_ceil(ROWS * self.width());
        blocks as u64 * self.bytes_needed()
    }

    /// How many numbers each row has.
    pub fn width(&self) -> usize {
        self.width.unwrap_or(1)
    }

    /// Appends the buffered rows to the dataset.
    pub fn write(&mut self) -> Result<()> {
        let rows = self.buffer.len() / self.width();
        if rows == 0 {
            return Ok(());
        }
        let (start, end) = (self.written, self.written + rows);
        let shape_error = |e: ndarray::ShapeError| Error::from(e.to_string());
        match self.width {
            None => {
                self.dataset.resize(end)?;
                self.dataset.write_slice(ArrayView1::from(&self.buffer), s![start..end])?;
            }
            Some(w) => {
                self.dataset.resize((end, w))?;
                let rows = ArrayView2::from_shape((rows, w), &self.buffer).map_err(shape_error)?;
                self.dataset.write_slice(rows, s![start..end, ..])?;
            }
        }
        self.written = end;
        self.buffer.clear();
        Ok(())
    }
}
