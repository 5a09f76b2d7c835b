//! Growing datasets: buffered time series and tables, attributes with units.

use hdf5::types::VarLenUnicode;
use hdf5::{Dataset, Error, Group, H5Type, Location, Result};
use ndarray::{ArrayView1, ArrayView2, s};

use super::disk_space::BYTES_OF_DATASET;
use super::scales;
use crate::scenario::Compression;

/// Rows of a chunk and of a write buffer.
pub const ROWS: usize = 256;
/// Columns of a chunk: tall chunks keep the history of one coordinate cheap to read.
const COLUMNS: usize = 16;

/// `text` as an HDF5 string; NUL bytes, which HDF5 strings cannot hold, are left out.
pub fn unicode(text: &str) -> Result<VarLenUnicode> {
    text.replace('\0', "").parse().map_err(|e| Error::from(format!("{e:?}")))
}

/// Adds or replaces a string attribute.
pub fn text_attribute(target: &Location, name: &str, text: &str) -> Result<()> {
    let attribute = match target.attr(name) {
        Ok(existing) => existing,
        Err(_) => target.new_attr::<VarLenUnicode>().create(name)?,
    };
    attribute.write_scalar(&unicode(text)?)
}

/// Adds the two attributes that every numeric dataset has.
pub fn describe(dataset: &Dataset, unit: &str, description: &str) -> Result<()> {
    text_attribute(dataset, "unit", unit)?;
    text_attribute(dataset, "description", description)
}

/// Writes a string dataset.
pub fn write_text(group: &Group, name: &str, text: &str) -> Result<Dataset> {
    let dataset = group.new_dataset::<VarLenUnicode>().create(name)?;
    dataset.write_scalar(&unicode(text)?)?;
    Ok(dataset)
}

/// Writes the names of components as a dimension scale.
pub fn component_scale(group: &Group, name: &str, labels: &[&str], description: &str) -> Result<Dataset> {
    let texts = labels.iter().map(|l| unicode(l)).collect::<Result<Vec<_>>>()?;
    let dataset = group.new_dataset::<VarLenUnicode>().shape(labels.len()).create(name)?;
    dataset.write(ArrayView1::from(&texts))?;
    text_attribute(&dataset, "description", description)?;
    scales::make_scale(&dataset, name)?;
    Ok(dataset)
}

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
        // Rows come in order: two chunks a column of chunks are enough, the default of a megabyte adds up.
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

    /// Bytes on the disk that writing a full buffer may take: a new row of chunks after one that is begun, and the tree.
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

/// A growing table with one compound entry per row.
pub struct Table {
    dataset: Dataset,
    rows: usize,
}

impl Table {
    /// Creates the table, a dimension scale of its own.
    pub fn create<T: H5Type>(group: &Group, name: &str, units: &str, description: &str) -> Result<Self> {
        let dataset = group.new_dataset::<T>().chunk(16).shape(0..).create(name)?;
        describe(&dataset, units, description)?;
        scales::make_scale(&dataset, name)?;
        Ok(Self { dataset, rows: 0 })
    }

    /// Appends a row.
    pub fn push<T: H5Type>(&mut self, row: T) -> Result<()> {
        self.put(self.rows, row)
    }

    /// Puts a row in place of the one numbered `index`, or at the end if there are no more than `index`.
    pub fn put<T: H5Type>(&mut self, index: usize, row: T) -> Result<()> {
        let index = index.min(self.rows);
        if index == self.rows {
            self.dataset.resize(self.rows + 1)?;
            self.rows += 1;
        }
        self.dataset.write_slice(ArrayView1::from(&[row]), s![index..index + 1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_with_nul_is_stored_without_it() {
        assert_eq!(unicode("a\0b µ").expect("a text").as_str(), "ab µ");
    }
}
