//! A beam as another finite element program might write it.

use std::path::Path;

use hdf5::types::VarLenUnicode;
use ndarray::{Array1, Array2, arr1};

/// Length \[m\].
pub const LENGTH: f64 = 2.0;
/// Number of elements.
pub const ELEMENTS: usize = 20;
/// Bending stiffness [N m²].
pub const BENDING: f64 = 40.0;
/// Mass a length [kg/m].
pub const LINE_MASS: f64 = 1.5;

fn attribute(at: &hdf5::Location, name: &str, text: &str) {
    let value: VarLenUnicode = text.parse().unwrap();
    at.new_attr::<VarLenUnicode>().create(name).unwrap().write_scalar(&value).unwrap();
}

/// Bernoulli beam with cubic shapes, as another program might write it: full COO matrices, unknowns sorted by component.
pub fn write_beam(path: &Path) {
    let h = LENGTH / ELEMENTS as f64;
    let n = 3 * (ELEMENTS + 1);
    let (mut k, mut m) = (Array2::<f64>::zeros((n, n)), Array2::<f64>::zeros((n, n)));
    let b = BENDING / h.powi(3);
    let bending = [
        [12.0 * b, 6.0 * b * h, -12.0 * b, 6.0 * b * h],
        [6.0 * b * h, 4.0 * b * h * h, -6.0 * b * h, 2.0 * b * h * h],
        [-12.0 * b, -6.0 * b * h, 12.0 * b, -6.0 * b * h],
        [6.0 * b * h, 2.0 * b * h * h, -6.0 * b * h, 4.0 * b * h * h],
    ];
    let c = LINE_MASS * h / 420.0;
    let inertia = [
        [156.0 * c, 22.0 * c * h, 54.0 * c, -13.0 * c * h],
        [22.0 * c * h, 4.0 * c * h * h, 13.0 * c * h, -3.0 * c * h * h],
        [54.0 * c, 13.0 * c * h, 156.0 * c, -22.0 * c * h],
        [-13.0 * c * h, -3.0 * c * h * h, -22.0 * c * h, 4.0 * c * h * h],
    ];
    let number = |node: usize, component: usize| component * (ELEMENTS + 1) + node;
    for e in 0..ELEMENTS {
        let bent = [number(e, 1), number(e, 2), number(e + 1, 1), number(e + 1, 2)];
        let along = [number(e, 0), number(e + 1, 0)];
        for i in 0..4 {
            for j in 0..4 {
                k[(bent[i], bent[j])] += bending[i][j];
                m[(bent[i], bent[j])] += inertia[i][j];
            }
        }
        for i in 0..2 {
            for j in 0..2 {
                k[(along[i], along[j])] += if i == j { 1e6 / h } else { -1e6 / h };
                m[(along[i], along[j])] += LINE_MASS * h * if i == j { 1.0 / 3.0 } else { 1.0 / 6.0 };
            }
        }
    }
    let file = hdf5::File::create(path).unwrap();
    attribute(&file, "format", "fbimpact-body");
    file.new_attr::<i64>().create("format_version").unwrap().write_scalar(&1i64).unwrap();
    attribute(&file, "kind", "full");
    attribute(&file, "model", "plane");
    let nodes = Array2::from_shape_fn((ELEMENTS + 1, 3), |(i, c)| if c == 0 { h * i as f64 } else { 0.0 });
    file.new_dataset_builder().with_data(&nodes).create("nodes").unwrap();
    let dofs = Array2::from_shape_fn(
        (n, 2),
        |(k, c)| if c == 0 { k % (ELEMENTS + 1) } else { k / (ELEMENTS + 1) } as i64,
    );
    file.new_dataset_builder().with_data(&dofs).create("dofs").unwrap();
    for (name, matrix) in [("stiffness", k), ("mass", m)] {
        let group = file.create_group(name).unwrap();
        attribute(&group, "layout", "coo");
        attribute(&group, "triangle", "full");
        if name == "mass" {
            attribute(&group, "rows_are", "unknowns");
        }
        let entries: Vec<_> = matrix.indexed_iter().filter(|(_, v)| **v != 0.0).collect();
        let rows: Array1<i64> = entries.iter().map(|e| e.0.0 as i64).collect();
        let columns: Array1<i64> = entries.iter().map(|e| e.0.1 as i64).collect();
        group.new_dataset_builder().with_data(&rows).create("rows").unwrap();
        group.new_dataset_builder().with_data(&columns).create("columns").unwrap();
        let values: Array1<f64> = entries.iter().map(|e| *e.1).collect();
        group.new_dataset_builder().with_data(&values).create("values").unwrap();
    }
    let markers = file.create_group("markers").unwrap();
    for (name, node) in [("hinge", 0), ("tip", ELEMENTS)] {
        let marker = markers.create_group(name).unwrap();
        let position = arr1(&[h * node as f64, 0.0, 0.0]);
        marker.new_dataset_builder().with_data(&position).create("position").unwrap();
        marker.new_dataset_builder().with_data(&arr1(&[node as i64])).create("nodes").unwrap();
    }
}
