//! The table as CSV and as HDF5.

use std::path::Path;

use hdf5::File;
use hdf5::types::VarLenUnicode;
use ndarray::ArrayView1;

use super::format::TABLE_FORMAT;
use super::table::{Column, Table, Values};
use crate::dataset::unicode;
use crate::file::whole_file;

/// The table as CSV (RFC 4180): a line of names, then one per row; what is not there is empty.
pub fn csv(table: &Table) -> String {
    let mut out = line(table.columns.iter().map(|c| c.name.clone()));
    for row in 0..table.n_rows {
        out += &line(table.columns.iter().map(|c| cell(c, row)));
    }
    out
}

fn cell(column: &Column, row: usize) -> String {
    match &column.values {
        Values::Texts(texts) => texts[row].clone(),
        Values::Numbers(numbers) => numbers[row].map_or_else(String::new, number),
    }
}

/// As short as possible without loss; counts without a point.
fn number(x: f64) -> String {
    let x = x + 0.0; // no sign of zero
    // 2^53: from here on not every whole number is one.
    if x.fract() == 0.0 && x.abs() < 9e15 { format!("{x}") } else { format!("{x:?}") }
}

fn line(cells: impl Iterator<Item = String>) -> String {
    let quoted = cells.map(|cell| {
        if cell.contains(['"', ',', '\n', '\r']) {
            format!("\"{}\"", cell.replace('"', "\"\""))
        } else {
            cell
        }
    });
    quoted.collect::<Vec<_>>().join(",") + "\n"
}

/// Writes the table to a new HDF5 file: a dataset a column in the group `/runs`, NaN for numbers
/// that are not there.
///
/// # Errors
/// That of the HDF5 library.
pub fn hdf5(table: &Table, path: &Path) -> hdf5::Result<()> {
    let file = File::with_options().with_fapl(|p| p.file_locking(false)).create(path)?;
    file.new_attr::<VarLenUnicode>().create("format")?.write_scalar(&unicode(TABLE_FORMAT)?)?;
    let group = file.create_group("runs")?;
    for column in &table.columns {
        let dataset = match &column.values {
            Values::Numbers(numbers) => {
                let values: Vec<f64> = numbers.iter().map(|x| x.unwrap_or(f64::NAN)).collect();
                let dataset = group.new_dataset::<f64>().shape(values.len()).create(column.name.as_str())?;
                dataset.write_raw(&values)?;
                dataset
            }
            Values::Texts(texts) => {
                let values = texts.iter().map(|t| unicode(t)).collect::<hdf5::Result<Vec<_>>>()?;
                let builder = group.new_dataset::<VarLenUnicode>().shape(values.len());
                let dataset = builder.create(column.name.as_str())?;
                dataset.write(ArrayView1::from(&values))?;
                dataset
            }
        };
        let unit = unicode(&column.unit)?;
        dataset.new_attr::<VarLenUnicode>().create("unit")?.write_scalar(&unit)?;
    }
    drop(group);
    whole_file::close(file)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_with_commas_quotes_and_line_ends_are_quoted() {
        let column = |name: &str, values| Column { name: name.into(), unit: String::new(), values };
        let table = Table {
            n_rows: 3,
            columns: vec![
                column("a", Values::Texts(vec!["x, \"y\"".into(), "line\nend".into(), String::new()])),
                column("b", Values::Numbers(vec![Some(1.5e-7), Some(3.0), None])),
            ],
        };
        assert_eq!(csv(&table), "a,b\n\"x, \"\"y\"\"\",1.5e-7\n\"line\nend\",3\n,\n");
    }
}
