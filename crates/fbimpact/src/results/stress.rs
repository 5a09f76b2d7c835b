//! Stresses along a line: `/stress/<name>`.

use adaptive::record::StressRecord;
use hdf5::{File, Group, Result};
use iga_core::elasticity::Model;
use ndarray::{ArrayView1, ArrayView2};
use result_files::dataset::scales::{self, Scale};
use result_files::dataset::{component_scale, describe};

/// Names of the six components of stress and strain in the axes of a body.
pub fn tensor_labels(is_axisymmetric: bool) -> [&'static str; 6] {
    match is_axisymmetric {
        true => ["rr", "zz", "tt", "rz", "-", "-"],
        false => ["xx", "yy", "zz", "xy", "yz", "zx"],
    }
}

/// The scale `component` of tensors in `group`.
pub fn tensor_scale(group: &Group, is_axisymmetric: bool) -> Result<Scale> {
    let about = "Components of stress and strain; tt is the hoop.";
    component_scale(group, "component", &tensor_labels(is_axisymmetric), about)
}

/// Writes a record; one of the same name is replaced. `model` decides what the components are
/// called.
pub fn write_stress(file: &File, record: &StressRecord, model: Option<Model>) -> Result<()> {
    let parent =
        if file.link_exists("stress") { file.group("stress")? } else { file.create_group("stress")? };
    if parent.link_exists(&record.name) {
        parent.unlink(&record.name)?;
    }
    let group = parent.create_group(&record.name)?;
    group.new_attr::<f64>().create("time")?.write_scalar(&record.time)?;
    let axisymmetric = matches!(model, Some(Model::Axisymmetric));
    let points = if axisymmetric { ["r", "z", "-"] } else { ["x", "y", "z"] };
    let distances = distances(&record.points);
    let distance = group.new_dataset::<f64>().shape(distances.len()).create("distance")?;
    distance.write(ArrayView1::from(&distances))?;
    describe(&distance, "m", "Distance from the first point.")?;
    let distance = Scale::new(distance, "distance")?;
    let coordinates = component_scale(&group, "coordinate", &points, "Coordinates of the body's model.")?;
    let components = tensor_scale(&group, axisymmetric)?;
    let rows = |values: &[f64], second: (&Scale, &str), name: &str, unit: &str, text: &str| -> Result<()> {
        let shape = (values.len() / second.0.size(), second.0.size());
        let dataset = group.new_dataset::<f64>().shape(shape).create(name)?;
        let view = ArrayView2::from_shape(shape, values).map_err(|e| hdf5::Error::from(e.to_string()))?;
        dataset.write(view)?;
        describe(&dataset, unit, text)?;
        dataset.new_attr::<f64>().create("time")?.write_scalar(&record.time)?;
        scales::attach(&dataset, &[(&distance, "distance"), second])
    };
    let points = record.points.as_flattened();
    rows(points, (&coordinates, "coordinate"), "points", "m", "Undeformed points, in the body's frame.")?;
    let stress = record.stress.as_flattened();
    rows(stress, (&components, "component"), "stress", "Pa", "Components of stress.")?;
    let von_mises = group.new_dataset::<f64>().shape(record.von_mises.len()).create("von_mises")?;
    von_mises.write(ArrayView1::from(&record.von_mises))?;
    describe(&von_mises, "Pa", "Von Mises stress.")?;
    von_mises.new_attr::<f64>().create("time")?.write_scalar(&record.time)?;
    scales::attach(&von_mises, &[(&distance, "distance")])?;
    [distance, coordinates, components].iter().try_for_each(Scale::finish)
}

fn distances(points: &[[f64; 3]]) -> Vec<f64> {
    let from = points.first().copied().unwrap_or_default();
    points.iter().map(|p| (0..3).map(|i| (p[i] - from[i]).powi(2)).sum::<f64>().sqrt()).collect()
}
