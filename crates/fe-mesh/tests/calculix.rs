//! Matrices of single distorted elements against CalculiX, entry by entry. `scripts/mesh_calculix.py` makes the references.

use std::path::Path;

use crate::blocks::steel;
use faer::sparse::SparseColMat;
use fe_mesh::MeshSpace;
use fe_mesh::element::rules::MassRule;
use fe_mesh::read::read;
use iga_core::elasticity::Model;
use iga_core::elasticity::assembly::assemble;

fn entry(matrix: &SparseColMat<u32, f64>, row: usize, column: usize) -> f64 {
    let range = matrix.symbolic().col_range(column);
    let rows = &matrix.row_idx()[range.clone()];
    rows.binary_search(&(row as u32)).map_or(0.0, |at| matrix.val()[range.start + at])
}

/// Largest difference of an entry from the reference, as a share of the root of its diagonal entries.
fn deviation(matrix: &SparseColMat<u32, f64>, reference: &[(usize, usize, f64)]) -> f64 {
    let n = matrix.ncols();
    assert_eq!(reference.len(), n * (n + 1) / 2, "every entry is compared");
    let scale = |i: usize, j: usize| (entry(matrix, i, i) * entry(matrix, j, j)).sqrt();
    reference
        .iter()
        .map(|&(i, j, value)| (entry(matrix, i, j) - value).abs() / scale(i, j))
        .fold(0.0, f64::max)
}

fn deviations(name: &str) -> [f64; 2] {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/fe-mesh/tests/calculix");
    let mesh =
        read(&std::fs::read(folder.join(format!("{name}.inp"))).expect("readable"), 1.0).expect("a mesh");
    let matrices = assemble(&MeshSpace::new(mesh.clone(), MassRule::AsStiffness), &Model::Solid, &steel());
    let matrices = matrices.expect("matrices");
    let text = std::fs::read_to_string(folder.join(format!("{name}.ref"))).expect("readable");
    let entries = |letter: &str, share: usize| -> Vec<(usize, usize, f64)> {
        let fields = text.lines().map(|l| l.split(' ').collect::<Vec<_>>()).filter(|f| f[0] == letter);
        let number = |s: &str| s.parse::<usize>().expect("a number") / share;
        fields.map(|f| (number(f[1]), number(f[2]), f[3].parse().expect("a number"))).collect()
    };
    [deviation(&matrices.stiffness, &entries("k", 1)), deviation(&matrices.mass, &entries("m", 3))]
}

#[test]
fn elements_are_those_of_calculix() {
    for name in ["c3d10", "c3d20", "c3d15", "c3d8"] {
        let [stiffness, mass] = deviations(name);
        // The reference has fourteen digits; its points and weights of quadrature fourteen to fifteen.
        assert!(stiffness < 1e-9 && mass < 1e-9, "{name}: K {stiffness:e}, M {mass:e}");
    }
}
