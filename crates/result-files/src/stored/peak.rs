//! The largest values of series at all accepted time steps, which attributes of their datasets hold: of vectors their length, of
//! positions the distance from the first one.

use hdf5::types::VarLenUnicode;
use hdf5::{Dataset, File, Result};
use nalgebra::Vector3;
use serde_json::{Map, Value};

use crate::file::hdf5_integrity;

/// Names of the attributes that hold it, its time and its band.
const ATTRIBUTES: [&str; 3] = ["peak", "peak_time", "peak_uncertainty"];
/// That of what the band is mostly made of, or why there is none.
const NOTE: &str = "uncertainty";

/// The largest value of a series.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SeriesPeak {
    /// The value, in the unit of the series.
    pub value: f64,
    /// When \[s\].
    pub time: f64,
    /// By how much it may be off; NaN where that is not known.
    pub band: f64,
    /// What that is mostly made of, or why there is none.
    pub note: String,
}

/// Writes `peak`.
///
/// # Errors
/// Those of HDF5.
pub fn write_peak(dataset: &Dataset, peak: &SeriesPeak) -> Result<()> {
    let there = dataset.attr_names()?;
    for name in ATTRIBUTES.into_iter().chain([NOTE]).filter(|name| there.iter().any(|other| other == name)) {
        dataset.delete_attr(name)?;
    }
    for (name, number) in ATTRIBUTES.into_iter().zip([peak.value, peak.time, peak.band]) {
        dataset.new_attr::<f64>().create(name)?.write_scalar(&number)?;
    }
    let note: VarLenUnicode = peak.note.parse().map_err(|_| "a text with a NUL character")?;
    dataset.new_attr::<VarLenUnicode>().create(NOTE)?.write_scalar(&note)
}

/// The largest value; none in files of earlier versions and small copies, and while a run goes on.
pub fn read_peak(dataset: &Dataset) -> Option<SeriesPeak> {
    let names = dataset.attr_names().ok()?;
    // Ask before opening: HDF5 says on its own why an attribute is missing.
    let has = |name: &str| names.iter().any(|there| there == name);
    let read = |name: &str| has(name).then(|| dataset.attr(name)?.read_scalar::<f64>()).and_then(Result::ok);
    let note = has(NOTE).then(|| dataset.attr(NOTE)?.read_scalar::<VarLenUnicode>()).and_then(Result::ok);
    Some(SeriesPeak {
        value: read(ATTRIBUTES[0])?,
        time: read(ATTRIBUTES[1])?,
        band: read(ATTRIBUTES[2]).unwrap_or(f64::NAN),
        note: note.map(|note| note.as_str().to_owned()).unwrap_or_default(),
    })
}

/// A quantity whose largest values are told.
#[derive(Debug, PartialEq)]
pub struct Quantity {
    /// Group of the things that have it.
    pub group: &'static str,
    /// Its series.
    pub series: &'static str,
    /// Name of the largest value.
    pub name: &'static str,
    /// What it is, for people.
    pub words: &'static str,
    /// Unit.
    pub unit: &'static str,
}

const fn quantity(
    group: &'static str,
    series: &'static str,
    name: &'static str,
    words: &'static str,
    unit: &'static str,
) -> Quantity {
    Quantity { group, series, name, words, unit }
}

/// All of them.
pub static QUANTITIES: [Quantity; 5] = [
    quantity("joints", "reaction_force", "peak_force", "force", "N"),
    quantity("joints", "reaction_moment", "peak_moment", "moment", "N m"),
    quantity("points", "position", "peak_displacement", "displacement", "m"),
    quantity("points", "velocity", "peak_speed", "speed", "m/s"),
    quantity("points", "von_mises", "peak_von_mises", "von Mises stress", "Pa"),
];

/// A largest value at a place.
#[derive(Debug, Clone, PartialEq)]
pub struct Peak {
    /// Name of the joint or point.
    pub place: String,
    /// What it is of.
    pub quantity: &'static Quantity,
    /// The value.
    pub peak: SeriesPeak,
}

/// Those of all joints and points, of stored instants where a file of an earlier version or a small copy has no others.
///
/// # Errors
/// As [`hdf5_integrity::rows`].
pub fn peaks(file: &File, time: &[f64]) -> Result<Vec<Peak>> {
    let mut all = Vec::new();
    let mut group = (None, "");
    for quantity in &QUANTITIES {
        if group.1 != quantity.group {
            group = (file.group(quantity.group).ok(), quantity.group);
        }
        let Some(group) = &group.0 else { continue };
        for place in group.member_names()? {
            // Ask before opening: HDF5 says on its own why a link is missing.
            if group.group(&place)?.link_exists(quantity.series) {
                let peak = largest(&group.dataset(&format!("{place}/{}", quantity.series))?, quantity, time)?;
                all.push(Peak { place, quantity, peak });
            }
        }
    }
    all.sort_by(|a, b| (a.quantity.group, &a.place).cmp(&(b.quantity.group, &b.place)));
    Ok(all)
}

/// The largest value of `quantity` in `dataset`.
fn largest(dataset: &Dataset, quantity: &Quantity, time: &[f64]) -> Result<SeriesPeak> {
    if let Some(peak) = read_peak(dataset) {
        return Ok(peak);
    }
    let values = sizes(&hdf5_integrity::rows::<f64>(dataset)?, quantity);
    let first = (0.0, time.first().copied().unwrap_or(0.0));
    let (value, time) = values
        .into_iter()
        .zip(time.iter().copied())
        .fold(first, |most, now| if now.0 > most.0 { now } else { most });
    Ok(SeriesPeak { value, time, band: f64::NAN, note: String::new() })
}

/// What is looked at of the rows `values` of a series: lengths of vectors, distances of positions from the first one.
fn sizes(values: &[f64], quantity: &Quantity) -> Vec<f64> {
    let (rows, _) = values.as_chunks::<3>();
    let length = |v: [f64; 3]| Vector3::from(v).norm();
    match quantity.series {
        "von_mises" => values.to_vec(),
        "position" => rows.iter().map(|row| length(std::array::from_fn(|k| row[k] - rows[0][k]))).collect(),
        _ => rows.iter().map(|row| length(*row)).collect(),
    }
}

/// The peaks of the things of `group` as JSON, for programs: an object per thing.
pub fn json(peaks: &[Peak], group: &str) -> Map<String, Value> {
    let mut all = Map::new();
    for Peak { place, quantity, peak } in peaks.iter().filter(|peak| peak.quantity.group == group) {
        if let Value::Object(map) = all.entry(place.clone()).or_insert_with(|| Map::new().into()) {
            let name = quantity.name;
            map.insert(name.into(), peak.value.into());
            map.insert(format!("{name}_time"), peak.time.into());
            map.insert(format!("{name}_uncertainty"), peak.band.into());
            if !peak.note.is_empty() {
                map.insert(format!("{name}_note"), peak.note.clone().into());
            }
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_displacement_counts_from_the_first_instant_and_may_be_over_at_the_end() {
        let positions = [[1.0, 0.0, 0.0], [1.0, 3.0, 4.0], [1.0, 0.0, 0.0]];
        assert_eq!(sizes(positions.as_flattened(), &QUANTITIES[2]), [0.0, 5.0, 0.0]);
        assert!(sizes(&[], &QUANTITIES[2]).is_empty());
    }
}
