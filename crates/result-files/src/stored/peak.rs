//! The largest value of a series at all accepted time steps, which attributes of its dataset hold: of
//! vectors their length, of positions the distance from the first one.

use hdf5::{Dataset, Result};

/// Names of the attributes that hold it and its time.
const ATTRIBUTES: [&str; 2] = ["peak", "peak_time"];

/// Writes `value` and its `time` \[s\].
///
/// # Errors
/// Those of HDF5.
pub fn write_peak(dataset: &Dataset, value: f64, time: f64) -> Result<()> {
    for (name, number) in ATTRIBUTES.into_iter().zip([value, time]) {
        if dataset.attr_names()?.iter().any(|there| there == name) {
            dataset.delete_attr(name)?;
        }
        dataset.new_attr::<f64>().create(name)?.write_scalar(&number)?;
    }
    Ok(())
}

/// Value and time \[s\]; none in files of earlier versions and small copies, and while a run goes on.
pub fn read_peak(dataset: &Dataset) -> Option<(f64, f64)> {
    let names = dataset.attr_names().ok()?;
    // Ask before opening: HDF5 says on its own why an attribute is missing.
    let read = |name: &str| {
        let is_there = names.iter().any(|there| there == name);
        is_there
            .then(|| dataset.attr(name).and_then(|attribute| attribute.read_scalar::<f64>()).ok())
            .flatten()
    };
    Some((read(ATTRIBUTES[0])?, read(ATTRIBUTES[1])?))
}
