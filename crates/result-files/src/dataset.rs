//! Datasets with units and descriptions, texts, and tables that grow.

pub mod scales;

use hdf5::types::VarLenUnicode;
use hdf5::{Dataset, Error, Group, H5Type, Location, Result};
use ndarray::{ArrayView1, s};

use scales::Scale;

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

/// Adds the two attributes that every numeric dataset has to one that has neither.
pub fn describe(dataset: &Dataset, unit: &str, description: &str) -> Result<()> {
    // To look for an attribute that is not there takes longer than to create it.
    [("unit", unit), ("description", description)].into_iter().try_for_each(|(name, text)| {
        dataset.new_attr::<VarLenUnicode>().create(name)?.write_scalar(&unicode(text)?)
    })
}

/// Writes a string dataset.
pub fn write_text(group: &Group, name: &str, text: &str) -> Result<Dataset> {
    let dataset = group.new_dataset::<VarLenUnicode>().create(name)?;
    dataset.write_scalar(&unicode(text)?)?;
    Ok(dataset)
}

/// Writes the names of components as a dimension scale.
pub fn component_scale(group: &Group, name: &str, labels: &[&str], description: &str) -> Result<Scale> {
    let texts = labels.iter().map(|l| unicode(l)).collect::<Result<Vec<_>>>()?;
    let dataset = group.new_dataset::<VarLenUnicode>().shape(labels.len()).create(name)?;
    dataset.write(ArrayView1::from(&texts))?;
    text_attribute(&dataset, "description", description)?;
    Scale::new(dataset, name)
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

    /// Puts a row in place of the one numbered `index`, or at the end if there are no more than
    /// `index`.
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
