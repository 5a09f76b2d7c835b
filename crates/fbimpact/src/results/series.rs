//! Time series: datasets that grow, written in blocks.

use hdf5::types::OwnedDynValue;
use hdf5::{Dataset, Error, Group, H5Type, Result};
use ndarray::{ArrayView1, ArrayView2, s};

use super::disk_space::BYTES_OF_DATASET;
use crate::scenario::Compression;

/// Rows of a chunk and of a write buffer.
const ROWS: usize = 256;
/// Datasets from which on chunks have fewer rows, so that a run of many bodies and few states does not store
/// blanks; and the fewest rows that they have.
const MANY: usize = 1000;
const FEWEST_ROWS: usize = 16;
/// The number of [`half_node`] that HDF5 has for itself.
const HALF_NODE: usize = 32;
/// Columns of a chunk: tall chunks keep the history of one coordinate cheap to read.
const COLUMNS: usize = 16;

/// How the series of a file are stored.
#[derive(Debug, Clone, Copy)]
pub struct Storage {
    /// Rows of a chunk and of a write buffer.
    pub rows: usize,
    /// How chunks are compressed.
    pub compression: Compression,
}

impl Storage {
    /// That of a file with `n` series.
    pub fn of(n: usize, compression: Compression) -> Self {
        Self { rows: (ROWS * MANY / n.max(MANY)).max(FEWEST_ROWS), compression }
    }
}

/// Half of the chunks that a node of the trees of chunks has room for, in a file with `n` series: a node is written whole.
pub fn half_node(n: usize) -> u32 {
    (HALF_NODE * MANY / n.max(MANY)).max(2) as u32
}

/// A dataset with one row a stored instant, written in blocks of [`Storage::rows`] rows.
pub struct Series<T> {
    dataset: Dataset,
    /// `None` for one value per row.
    width: Option<usize>,
    /// Rows not yet written.
    pub buffer: Vec<T>,
    written: usize,
    /// Rows of a chunk.
    rows: usize,
    /// The value of which whole chunks are left out, as of contacts that do not touch: HDF5 reads it there.
    blank: Option<T>,
}

/// What a series held before its dataset was there: so many rows of one value.
#[derive(Debug, Clone, Copy, Default)]
pub struct Past<T> {
    /// Rows that others have in their datasets.
    pub written: usize,
    /// Rows that others have in their buffers.
    pub buffered: usize,
    /// The value.
    pub value: T,
}

impl<T: H5Type + Copy + Into<f64>> Series<T> {
    /// Creates the dataset `name` in `group`; `width` is `None` for a one-dimensional dataset. With a past, chunks of its value alone
    /// are not stored.
    pub fn create(
        group: &Group,
        name: &str,
        width: Option<usize>,
        storage: Storage,
        past: Option<Past<T>>,
    ) -> Result<Self> {
        let rows = storage.rows;
        let (written, buffered) = past.map_or((0, 0), |past| (past.written, past.buffered));
        let builder = group.new_dataset::<T>();
        // Rows come in order: two chunks a column of chunks are enough, the default of a megabyte
        // adds up.
        let width_or_one = width.unwrap_or(1).max(1);
        let chunk_bytes = rows * width_or_one * size_of::<T>();
        let builder = builder.chunk_cache(4 * width_or_one.div_ceil(COLUMNS) + 1, 2 * chunk_bytes, 1.0);
        let builder = match storage.compression {
            Compression::None => builder,
            Compression::Gzip => builder.shuffle().deflate(1),
        };
        let builder = match past {
            Some(past) => builder.fill_value(OwnedDynValue::new(past.value)),
            None => builder,
        };
        let dataset = match width {
            None => builder.chunk(rows).shape(written..).create(name)?,
            Some(w) => builder.chunk((rows, w.min(COLUMNS))).shape((written.., w)).create(name)?,
        };
        let mut buffer = Vec::with_capacity(rows * width.unwrap_or(1));
        buffer.extend(past.iter().flat_map(|past| vec![past.value; buffered * width.unwrap_or(1)]));
        Ok(Self { dataset, width, buffer, written, rows, blank: past.map(|past| past.value) })
    }

    /// The dataset.
    pub fn dataset(&self) -> &Dataset {
        &self.dataset
    }

    /// Bytes on the disk that writing a full buffer may take: a new row of chunks after one that is
    /// begun, and the tree.
    pub fn bytes_needed(&self) -> u64 {
        let chunks = self.width.unwrap_or(1).div_ceil(COLUMNS);
        let chunk = self.rows * self.width.unwrap_or(1).min(COLUMNS) * size_of::<T>();
        (chunks * 2 * chunk) as u64 + chunks as u64 * BYTES_OF_DATASET
    }

    /// Bytes on the disk that writing the buffer may take, however full it is.
    pub fn bytes_of_buffer(&self) -> u64 {
        let blocks = self.buffer.len().div_ceil(self.rows * self.width());
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
        // By its bits: a negative zero is no zero.
        let bits = |x: T| Into::<f64>::into(x).to_bits();
        let is_blank = self.blank.is_some_and(|blank| self.buffer.iter().all(|x| bits(*x) == bits(blank)));
        let shape_error = |e: ndarray::ShapeError| Error::from(e.to_string());
        match self.width {
            None => self.dataset.resize(end)?,
            Some(w) => self.dataset.resize((end, w))?,
        }
        match self.width {
            _ if is_blank => {}
            None => self.dataset.write_slice(ArrayView1::from(&self.buffer), s![start..end])?,
            Some(w) => {
                let rows = ArrayView2::from_shape((rows, w), &self.buffer).map_err(shape_error)?;
                self.dataset.write_slice(rows, s![start..end, ..])?;
            }
        }
        self.written = end;
        self.buffer.clear();
        Ok(())
    }
}
