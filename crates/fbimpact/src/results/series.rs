//! Time series: datasets that grow, written in blocks.

use hdf5::types::OwnedDynValue;
use hdf5::{Dataset, Error, Extents, Group, H5Type, Result, SimpleExtents};
use ndarray::{ArrayView1, ArrayView2, ArrayView3, s};

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
/// Columns of a chunk, or members of one that holds those of many: tall chunks keep the history of one coordinate cheap to read.
const COLUMNS: usize = 16;
/// Rows of a chunk of many members.
const ROWS_OF_MEMBERS: usize = 8;

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
    /// Lengths of a row: none for one value, the number of columns, or the numbers of members and of their columns.
    row: Vec<usize>,
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
    /// Creates the dataset `name` in `group`, with `row` for the lengths of a row: none for one value, the number of columns, or the numbers
    /// of members and of their columns. With a past, chunks of its value alone are not stored.
    pub fn create(
        group: &Group,
        name: &str,
        row: &[usize],
        storage: Storage,
        past: Option<Past<T>>,
    ) -> Result<Self> {
        let rows = if row.len() > 1 { ROWS_OF_MEMBERS.min(storage.rows) } else { storage.rows };
        let (written, buffered) = past.map_or((0, 0), |past| (past.written, past.buffered));
        let width = row.iter().product::<usize>();
        let mut chunk = [&[rows], row].concat();
        chunk.iter_mut().skip(1).take(1).for_each(|n| *n = (*n).min(COLUMNS));
        // Rows come in order: two chunks a column of chunks are enough, the default of a megabyte
        // adds up.
        let chunk_bytes = rows * width.max(1) * size_of::<T>();
        let builder = group.new_dataset::<T>();
        let columns = row.first().unwrap_or(&1).div_ceil(COLUMNS).max(1);
        let builder = builder.chunk_cache(4 * columns + 1, 2 * chunk_bytes, 1.0);
        let builder = match storage.compression {
            Compression::None => builder,
            Compression::Gzip => builder.shuffle().deflate(1),
        };
        let builder = match past {
            Some(past) => builder.fill_value(OwnedDynValue::new(past.value)),
            None => builder,
        };
        let fixed = row.iter().map(|n| hdf5::Extent::fixed(*n));
        let shape: Vec<_> = std::iter::once(hdf5::Extent::resizable(written)).chain(fixed).collect();
        let dataset = builder.chunk(chunk).shape(Extents::Simple(SimpleExtents::from(shape))).create(name)?;
        let mut buffer = Vec::with_capacity(rows * width);
        buffer.extend(past.iter().flat_map(|past| vec![past.value; buffered * width]));
        Ok(Self { dataset, row: row.to_vec(), buffer, written, rows, blank: past.map(|past| past.value) })
    }

    /// The dataset.
    pub fn dataset(&self) -> &Dataset {
        &self.dataset
    }

    /// Bytes on the disk that writing a full buffer may take: a new row of chunks after one that is
    /// begun, and the tree.
    pub fn bytes_needed(&self) -> u64 {
        let columns = *self.row.first().unwrap_or(&1);
        let chunk = self.rows * columns.min(COLUMNS) * self.row.get(1).unwrap_or(&1) * size_of::<T>();
        let chunks = columns.div_ceil(COLUMNS);
        (chunks * 2 * chunk) as u64 + chunks as u64 * BYTES_OF_DATASET
    }

    /// Bytes on the disk that writing the buffer may take, however full it is.
    pub fn bytes_of_buffer(&self) -> u64 {
        let blocks = self.buffer.len().div_ceil(self.rows * self.width());
        blocks as u64 * self.bytes_needed()
    }

    /// How many numbers each row has.
    pub fn width(&self) -> usize {
        self.row.iter().product()
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
        let blank = self.blank.map(bits);
        let is_blank = |x: &T| Some(bits(*x)) == blank;
        let shape_error = |e: ndarray::ShapeError| Error::from(e.to_string());
        self.dataset.resize([&[end], self.row.as_slice()].concat())?;
        match *self.row {
            [n, w] => {
                let all = ArrayView3::from_shape((rows, n, w), &self.buffer).map_err(shape_error)?;
                for first in (0..n).step_by(COLUMNS) {
                    let members = first..(first + COLUMNS).min(n);
                    let part = all.slice(s![.., members.clone(), ..]);
                    if !part.iter().all(is_blank) {
                        self.dataset.write_slice(&part.to_owned(), s![start..end, members, ..])?;
                    }
                }
            }
            _ if self.buffer.iter().all(is_blank) => {}
            [w] => {
                let rows = ArrayView2::from_shape((rows, w), &self.buffer).map_err(shape_error)?;
                self.dataset.write_slice(rows, s![start..end, ..])?;
            }
            _ => self.dataset.write_slice(ArrayView1::from(&self.buffer), s![start..end])?,
        }
        self.written = end;
        self.buffer.clear();
        Ok(())
    }
}
