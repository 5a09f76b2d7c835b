//! A solid bar as another finite element program might write it: bricks of twenty nodes (CalculiX's C3D20), its end faces held on the mean.

use std::collections::BTreeMap;
use std::path::Path;

use hdf5::types::VarLenUnicode;
use ndarray::{Array1, Array2, arr1};

/// Length, width and height of the bar \[m\].
pub const SIZE: [f64; 3] = [0.3, 0.03, 0.01];
/// Aluminium: Young's modulus \[Pa\], Poisson's ratio, density [kg/m³].
const MATERIAL: (f64, f64, f64) = (70e9, 0.33, 2700.0);
/// Gauss' points and weights for quintic functions.
const GAUSS: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];

/// Nodes of a brick: -1, 0 or 1 along each direction, at most one of them 0.
fn brick() -> Vec<[i32; 3]> {
    let all = (0..27).map(|k| [k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1]);
    all.filter(|n| n.iter().filter(|c| **c == 0).count() < 2).collect()
}

/// Value and gradient of the function of the node `n` in the brick's own coordinates.
fn function(n: [i32; 3], x: [f64; 3]) -> (f64, [f64; 3]) {
    let at = n.map(f64::from);
    // A factor for each direction with its derivative, and for corners the sum that vanishes on the middles of edges.
    let factor = [0, 1, 2]
        .map(|d| if n[d] == 0 { (1.0 - x[d] * x[d], -2.0 * x[d]) } else { (1.0 + at[d] * x[d], at[d]) });
    let product = factor[0].0 * factor[1].0 * factor[2].0;
    let slope = [0, 1, 2].map(|d| factor[d].1 * factor[(d + 1) % 3].0 * factor[(d + 2) % 3].0);
    if n.contains(&0) {
        return (0.25 * product, slope.map(|s| 0.25 * s));
    }
    let sum = (0..3).map(|d| at[d] * x[d]).sum::<f64>() - 2.0;
    (0.125 * product * sum, [0, 1, 2].map(|d| 0.125 * (slope[d] * sum + product * at[d])))
}

/// Every point of the rule in three directions with its weight.
fn rule() -> Vec<([f64; 3], f64)> {
    let points = (0..27).map(|k| [GAUSS[k % 3], GAUSS[k / 3 % 3], GAUSS[k / 9]]);
    points.map(|p| (p.map(|q| q.0), p.iter().map(|q| q.1).product())).collect()
}

/// Stiffness (60 × 60, by node and direction) and mass (20 × 20) of one brick of the size `h`.
fn matrices(h: [f64; 3]) -> (Array2<f64>, Array2<f64>) {
    let (young, nu, density) = MATERIAL;
    let (lame, shear) = (young * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), young / (2.0 * (1.0 + nu)));
    let (mut k, mut m) = (Array2::zeros((60, 60)), Array2::zeros((20, 20)));
    let nodes = brick();
    for (x, weight) in rule() {
        let volume = weight * h[0] * h[1] * h[2] / 8.0;
        let values: Vec<_> = nodes.iter().map(|n| function(*n, x)).collect();
        let gradient = |a: usize| [0, 1, 2].map(|d| values[a].1[d] * 2.0 / h[d]);
        for (a, b) in (0..20).flat_map(|a| (0..20).map(move |b| (a, b))) {
            m[(a, b)] += density * volume * values[a].0 * values[b].0;
            let (p, q) = (gradient(a), gradient(b));
            let all = p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
            for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
                let equal = if i == j { all } else { 0.0 };
                k[(3 * a + i, 3 * b + j)] += volume * (lame * p[i] * q[j] + shear * (p[j] * q[i] + equal));
            }
        }
    }
    (k, m)
}

fn attribute(at: &hdf5::Location, name: &str, text: &str) {
    let value: VarLenUnicode = text.parse().unwrap();
    at.new_attr::<VarLenUnicode>().create(name).unwrap().write_scalar(&value).unwrap();
}

/// Nodes of the mesh by their places on a grid of half elements, and the nodes of its bricks.
fn mesh(elements: [usize; 3]) -> (BTreeMap<[usize; 3], usize>, Vec<Vec<usize>>) {
    let [nx, ny, nz] = elements;
    let bricks = (0..nx * ny * nz).map(|e| [e % nx, e / nx % ny, e / (nx * ny)]);
    let places = bricks.map(|first| {
        let place = |n: &[i32; 3]| [0, 1, 2].map(|d| 2 * first[d] + (n[d] + 1) as usize);
        brick().iter().map(place).collect::<Vec<_>>()
    });
    let places: Vec<_> = places.collect();
    let mut nodes: BTreeMap<[usize; 3], usize> = places.iter().flatten().map(|p| (*p, 0)).collect();
    nodes.values_mut().enumerate().for_each(|(i, number)| *number = i);
    let numbers = places.iter().map(|p| p.iter().map(|p| nodes[p]).collect()).collect();
    (nodes, numbers)
}

/// Mean motion of an end face: unknowns of its nodes, and displacement and rotation by a unit of each.
fn mean_motion(
    elements: [usize; 3],
    nodes: &BTreeMap<[usize; 3], usize>,
    x: usize,
) -> (Vec<i64>, Vec<[f64; 6]>) {
    let [_, width, height] = SIZE;
    let h = [width / elements[1] as f64, height / elements[2] as f64];
    let mut weights: BTreeMap<usize, [f64; 3]> = BTreeMap::new();
    for (j, k) in (0..elements[1]).flat_map(|j| (0..elements[2]).map(move |k| (j, k))) {
        for ((s, v), (t, w)) in GAUSS.iter().flat_map(|p| GAUSS.iter().map(move |q| (*p, *q))) {
            let y = h[0] * (j as f64 + 0.5 + 0.5 * s) - 0.5 * width;
            let z = h[1] * (k as f64 + 0.5 + 0.5 * t) - 0.5 * height;
            for node in brick().into_iter().filter(|n| n[0] == 1) {
                let share = function(node, [1.0, s, t]).0 * 0.25 * v * w * h[0] * h[1];
                let place = [x, 2 * j + (node[1] + 1) as usize, 2 * k + (node[2] + 1) as usize];
                let sums = weights.entry(nodes[&place]).or_default();
                sums.iter_mut().zip([1.0, y, z]).for_each(|(sum, arm)| *sum += share * arm);
            }
        }
    }
    let area = width * height;
    let (about_y, about_z) = (area * height * height / 12.0, area * width * width / 12.0);
    let about_x = about_y + about_z;
    let (mut unknowns, mut rows) = (Vec::new(), Vec::new());
    for (node, [sum, y, z]) in weights {
        let mean = sum / area;
        unknowns.extend((0..3).map(|c| (3 * node + c) as i64));
        rows.push([mean, 0.0, 0.0, 0.0, z / about_y, -y / about_z]);
        rows.push([0.0, mean, 0.0, -z / about_x, 0.0, 0.0]);
        rows.push([0.0, 0.0, mean, y / about_x, 0.0, 0.0]);
    }
    (unknowns, rows)
}

fn write_matrix(file: &hdf5::File, name: &str, rows_are: &str, entries: &[(usize, usize, f64)]) {
    let group = file.create_group(name).unwrap();
    for (key, text) in [("layout", "coo"), ("triangle", "full"), ("rows_are", rows_are)] {
        attribute(&group, key, text);
    }
    let rows: Array1<i64> = entries.iter().map(|e| e.0 as i64).collect();
    let columns: Array1<i64> = entries.iter().map(|e| e.1 as i64).collect();
    let values: Array1<f64> = entries.iter().map(|e| e.2).collect();
    group.new_dataset_builder().with_data(&rows).create("rows").unwrap();
    group.new_dataset_builder().with_data(&columns).create("columns").unwrap();
    group.new_dataset_builder().with_data(&values).create("values").unwrap();
}

/// Writes the bar of `elements` bricks along its directions, with the markers `foot` and `tip` that follow the mean motions of its ends.
pub fn write_bar(path: &Path, elements: [usize; 3]) {
    let h = [0, 1, 2].map(|d| SIZE[d] / elements[d] as f64);
    let (nodes, bricks) = mesh(elements);
    let (own_stiffness, own_mass) = matrices(h);
    let (mut stiffness, mut mass) = (Vec::new(), Vec::new());
    for brick in &bricks {
        for ((a, b), value) in own_mass.indexed_iter() {
            mass.push((brick[a], brick[b], *value));
        }
        for ((i, j), value) in own_stiffness.indexed_iter() {
            stiffness.push((3 * brick[i / 3] + i % 3, 3 * brick[j / 3] + j % 3, *value));
        }
    }
    let file = hdf5::File::create(path).unwrap();
    attribute(&file, "format", "fbimpact-body");
    file.new_attr::<i64>().create("format_version").unwrap().write_scalar(&1i64).unwrap();
    attribute(&file, "kind", "full");
    attribute(&file, "model", "solid");
    let places: Vec<[usize; 3]> = nodes.keys().copied().collect();
    let positions = Array2::from_shape_fn((places.len(), 3), |(i, d)| 0.5 * h[d] * places[i][d] as f64);
    file.new_dataset_builder().with_data(&positions).create("nodes").unwrap();
    let dofs =
        Array2::from_shape_fn((3 * places.len(), 2), |(k, c)| if c == 0 { k / 3 } else { k % 3 } as i64);
    file.new_dataset_builder().with_data(&dofs).create("dofs").unwrap();
    write_matrix(&file, "stiffness", "unknowns", &stiffness);
    write_matrix(&file, "mass", "nodes", &mass);
    let markers = file.create_group("markers").unwrap();
    for (name, x) in [("foot", 0), ("tip", 2 * elements[0])] {
        let marker = markers.create_group(name).unwrap();
        let (unknowns, weights) = mean_motion(elements, &nodes, x);
        let position = arr1(&[0.5 * h[0] * x as f64, 0.5 * SIZE[1], 0.5 * SIZE[2]]);
        marker.new_dataset_builder().with_data(&position).create("position").unwrap();
        marker.new_dataset_builder().with_data(&Array1::from(unknowns)).create("unknowns").unwrap();
        let weights = Array2::from_shape_fn((weights.len(), 6), |(i, c)| weights[i][c]);
        marker.new_dataset_builder().with_data(&weights).create("weights").unwrap();
    }
}
