//! Assembly of stiffness and mass. `cargo bench -p iga-core --bench assembly`.
//!
//! Steel cylinder, one NURBS patch of degree 3; 16 x 16 x 16 elements have 20,577 unknowns.

#[path = "../tests/bodies/mod.rs"]
#[expect(dead_code, reason = "tests use the rest")]
mod bodies;

use divan::{Bencher, black_box};
use iga_core::elasticity::assembly::assemble;
use iga_core::elasticity::{Material, Model};
use iga_core::space::PatchSpace;

fn main() {
    divan::main();
}

fn steel() -> Material {
    Material::new(210e9, 0.3, 7850.0).expect("constants of steel")
}

fn cylinder(n: [usize; 3]) -> PatchSpace {
    PatchSpace::new(vec![bodies::uniform(&bodies::cylinder(0.01, 0.02), 3, &n)]).expect("one patch")
}

#[divan::bench(args = [[8, 8, 8], [8, 8, 16], [8, 16, 16], [16, 16, 16]], sample_count = 5, sample_size = 1)]
fn cylinder_stiffness_and_mass(bencher: Bencher, n: [usize; 3]) {
    let space = cylinder(n);
    bencher.bench(|| assemble(black_box(&space), &Model::Solid, &steel()));
}

#[divan::bench(args = [16, 32], sample_count = 5, sample_size = 2)]
fn plane_disc_stiffness_and_mass(bencher: Bencher, n: usize) {
    let patch = bodies::uniform(&bodies::disc(0.1), 3, &[n, n]);
    let space = PatchSpace::new(vec![patch]).expect("one patch");
    bencher.bench(|| assemble(black_box(&space), &Model::PlaneStrain { thickness: 1.0 }, &steel()));
}
