//! Hierarchies over several patches: continuous, complete, and the same space as over one patch where that can be had.

use iga_core::ParameterBox;
use iga_core::SplineError;
use iga_core::elasticity::assembly::assemble;
use iga_core::elasticity::{Material, Model};
use iga_core::hierarchical::{
    HierarchicalSpace, IndexBox, Neighbours, PatchTies, Prolongation, SubdomainHierarchy, elements_around,
};
use iga_core::nurbs::Face;
use iga_core::nurbs::Patch;
use iga_core::nurbs::primitives::sphere::{SphereNet, sphere};
use iga_core::space::{PatchSpace, Space, SplineSpace};

use faer::sparse::SparseColMat;

use super::nets::{PLACES, inside, noise, ring, split};

/// Value of `Σ R_i c_i` at parameters of a patch.
fn value(space: &dyn SplineSpace, coefficients: &[[f64; 3]], patch: usize, xi: &[f64; 3]) -> [f64; 3] {
    let functions = space.functions_at(space.find_element(patch, xi), xi);
    functions
        .iter()
        .fold([0.0; 3], |sum, &(f, r)| [0, 1, 2].map(|c| sum[c] + r * coefficients[f as usize][c]))
}

fn apart(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f64::max)
}

/// The quarter ring turned by 90 degrees about z: the second quarter of the half ring.
fn second_quarter(elements: &[usize]) -> Patch {
    let first = ring(3, 1, 0.3, elements);
    let points = first.control_points().iter().map(|[x, y, z]| [-y, *x, *z]).collect();
    Patch::new(first.knots().to_vec(), points, first.weights().to_vec()).unwrap()
}

/// A patch with its directions in the order `order`, and `order`'s place of each direction of the patch.
fn permuted(patch: &Patch, order: [usize; 3]) -> Patch {
    let sizes = patch.net_size();
    let knots = order.map(|d| patch.knots()[d].clone()).to_vec();
    let (mut points, mut weights) = (Vec::new(), Vec::new());
    for k in 0..sizes[order[2]] {
        for j in 0..sizes[order[1]] {
            for i in 0..sizes[order[0]] {
                let mut index = [0; 3];
                (index[order[0]], index[order[1]], index[order[2]]) = (i, j, k);
                let flat = index[0] + sizes[0] * (index[1] + sizes[1] * index[2]);
                points.push(patch.control_points()[flat]);
                weights.push(patch.weights()[flat]);
            }
        }
    }
    Patch::new(knots, points, weights).unwrap()
}

/// How the second quarter is described.
struct Turned {
    order: [usize; 3],
    reversed: [bool; 3],
}

impl Turned {
    fn patch(&self, elements: &[usize]) -> Patch {
        let mut patch = second_quarter(elements);
        for d in (0..3).filter(|&d| self.reversed[d]) {
            patch = patch.reversed(d).unwrap();
        }
        permuted(&patch, self.order)
    }

    /// A box of elements of the quarter with its own directions, of so many elements.
    fn index_box(&self, b: IndexBox, n: [usize; 3]) -> IndexBox {
        let end = |d: usize, i: [usize; 3]| i[d];
        let mut own = b;
        for d in (0..3).filter(|&d| self.reversed[d]) {
            (own.lower[d], own.upper[d]) = (n[d] - end(d, b.upper), n[d] - end(d, b.lower));
        }
        IndexBox { lower: self.order.map(|d| own.lower[d]), upper: self.order.map(|d| own.upper[d]) }
    }

    fn xi(&self, xi: [f64; 3]) -> [f64; 3] {
        let turned: [f64; 3] = std::array::from_fn(|d| if self.reversed[d] { 1.0 - xi[d] } else { xi[d] });
        self.order.map(|d| turned[d])
    }

    fn parts(&self, parts: [usize; 3]) -> [usize; 3] {
        self.order.map(|d| parts[d])
    }
}

const TURNS: [Turned; 4] = [
    Turned { order: [0, 1, 2], reversed: [false; 3] },
    Turned { order: [1, 2, 0], reversed: [false; 3] },
    Turned { order: [1, 0, 2], reversed: [true, false, false] },
    Turned { order: [2, 1, 0], reversed: [false, true, true] },
];

/// Adds a level with `parts` of every element of `knots` of the last one in `boxes`, which may be none.
fn follow(hierarchy: &mut SubdomainHierarchy, parts: [usize; 3], boxes: &[IndexBox]) {
    let last = hierarchy.levels().last().unwrap();
    let knots = last.knots().iter().zip(parts).map(|(k, n)| split(k, n)).collect();
    hierarchy.follow_knots(knots, boxes).unwrap();
}

/// The functions that a space has, by level and place.
fn functions(space: &HierarchicalSpace) -> Vec<(usize, [i64; 3])> {
    let place = |x: f64| (x * 1e9).round() as i64;
    let mut list: Vec<_> = (0..space.n_functions() as u32)
        .map(|f| (space.level_and_index(f).0, space.control_points()[f as usize].map(place)))
        .collect();
    list.sort_unstable();
    list
}

#[test]
fn two_quarters_are_the_half_ring_however_they_are_described() {
    let elements = [4, 3, 3];
    // Boxes in the angle of the half ring, of eight elements: over the middle, up to it from either side, beyond it by one element, and a second
    // level within the first.
    let levels: [[[usize; 2]; 2]; 5] =
        [[[2, 6], [6, 10]], [[1, 4], [4, 8]], [[4, 8], [8, 12]], [[1, 5], [4, 9]], [[0, 7], [5, 8]]];
    for (case, turn) in TURNS.iter().enumerate() {
        for around in levels {
            let whole = ring(3, 2, 0.3, &elements);
            let patches = [ring(3, 1, 0.3, &elements), turn.patch(&elements)];
            let mut one = SubdomainHierarchy::new(whole.knots());
            let mut two = patches.each_ref().map(|p| SubdomainHierarchy::new(p.knots()));
            let mut n = [4, 3, 3];
            for (level, [lower, upper]) in around.into_iter().enumerate() {
                let across = IndexBox { lower: [lower, 0, level], upper: [upper, n[1], n[2]] };
                follow(&mut one, [2, 1, 2], &[across]);
                let part = |first: usize| {
                    let within = |i: usize| i.clamp(first, first + n[0]) - first;
                    let mut b = across;
                    (b.lower[0], b.upper[0]) = (within(lower), within(upper));
                    if b.is_empty() { Vec::new() } else { vec![b] }
                };
                follow(&mut two[0], [2, 1, 2], &part(0));
                let second: Vec<IndexBox> = part(n[0]).iter().map(|b| turn.index_box(*b, n)).collect();
                follow(&mut two[1], turn.parts([2, 1, 2]), &second);
                n = [2 * n[0], n[1], 2 * n[2]];
            }
            let one = HierarchicalSpace::new(&whole, one).unwrap();
            let two = HierarchicalSpace::of_patches(&patches, two.to_vec()).unwrap();
            assert_eq!(functions(&one), functions(&two), "turn {case}, {around:?}");
            assert_eq!(one.n_elements(), two.n_elements());
            // The same field: coefficients by level and place, from a smooth function of the place and the level.
            let coefficients = |space: &HierarchicalSpace| -> Vec<[f64; 3]> {
                let of = |f: u32| {
                    let [x, y, z] = space.control_points()[f as usize];
                    let level = space.level_and_index(f).0 as f64;
                    [(3.0 * x + level).sin(), (5.0 * y - level).cos(), x * z + level]
                };
                (0..space.n_functions() as u32).map(of).collect()
            };
            let (u, v) = (coefficients(&one), coefficients(&two));
            for e in 0..one.n_elements() {
                let xi = inside(&one.element(e), PLACES[e % 2]);
                let (patch, there) = match xi[0] < 0.5 {
                    true => (0, [2.0 * xi[0], xi[1], xi[2]]),
                    false => (1, turn.xi([2.0 * xi[0] - 1.0, xi[1], xi[2]])),
                };
                // Round-off of sums of 27 terms.
                let difference = apart(&value(&one, &u, 0, &xi), &value(&two, &v, patch, &there));
                assert!(difference < 1e-13, "turn {case}, {around:?}, {xi:?}: {difference:e}");
            }
        }
    }
}

/// The ball of a cube and six shells, of radius 1, with two elements per direction.
pub fn ball() -> Vec<Patch> {
    let shape = sphere(1.0, SphereNet::Shells).unwrap();
    let shape = shape.refined(&[4, 4, 4], &[2, 2, 2], &[]).unwrap();
    shape.patches
}

/// Three levels of halves about `regions` of patches.
pub fn refined_about(patches: &[Patch], regions: &[Vec<ParameterBox>], by: usize) -> HierarchicalSpace {
    let ties: Vec<PatchTies> = patches.iter().map(PatchTies::detect).collect();
    let neighbours = Neighbours::detect(patches, &ties);
    let mut hierarchies: Vec<_> = patches.iter().map(|p| SubdomainHierarchy::new(p.knots())).collect();
    for _ in 0..3 {
        let by = vec![[by; 3]; patches.len()];
        let boxes = elements_around(&hierarchies, regions, &by, (&ties, &neighbours)).unwrap();
        hierarchies.iter_mut().zip(&boxes).for_each(|(h, b)| follow(h, [2, 2, 2], b));
    }
    HierarchicalSpace::of_patches(patches, hierarchies).unwrap()
}

/// Regions of the ball's first shell: inside, at a seam, at a triple point.
pub fn regions(patches: &[Patch]) -> Vec<Vec<Vec<ParameterBox>>> {
    let region = |u: f64, v: f64| {
        let mut all = vec![Vec::new(); patches.len()];
        all[2] = vec![ParameterBox { lower: [u, v, 0.97], upper: [u + 0.03, v + 0.03, 1.0] }];
        all
    };
    vec![region(0.6, 0.3), region(0.97, 0.4), region(0.97, 0.97)]
}

#[test]
fn fields_on_a_ball_of_seven_patches_are_continuous_and_hold_the_coarse_ones() {
    let patches = ball();
    let coarse = HierarchicalSpace::plain_patches(&patches).unwrap();
    for (case, regions) in regions(&patches).iter().enumerate() {
        let fine = refined_about(&patches, regions, 1);
        // Patches that are refined: the shell alone, with its neighbour, with both that meet it there.
        let deepest = |patch: usize| {
            let hierarchy = fine.basis(patch).hierarchy();
            hierarchy.leaves().map(|l| l.level).max().unwrap()
        };
        let refined = (0..7).filter(|&p| deepest(p) == 3).count();
        assert_eq!(refined, 1 + case, "{case}: {:?}", [0, 1, 2, 3, 4, 5, 6].map(deepest));
        let prolongation = Prolongation::between(&coarse, &fine).unwrap();
        let (u, w) = (noise(coarse.n_functions()), noise(fine.n_functions()));
        let v = prolongation.apply(&u);
        for e in 0..fine.n_elements() {
            let element = fine.element(e);
            let xi = inside(&element, PLACES[e % 2]);
            let sum: f64 = fine.functions_at(e, &xi).iter().map(|f| f.1).sum();
            assert!((sum - 1.0).abs() < 1e-13, "partition of unity: {sum}");
            let x = value(&fine, fine.control_points(), element.patch, &xi);
            assert!(apart(&x, &patches[element.patch].point(&xi)) < 1e-13, "geometry");
            let (x, y) = (value(&coarse, &u, element.patch, &xi), value(&fine, &v, element.patch, &xi));
            assert!(apart(&x, &y) < 1e-13, "prolongation: {x:?} {y:?}");
        }
        assert_is_continuous(&patches, &fine, &w);
    }
}

/// Places on shared faces, found from either side by their position.
fn assert_is_continuous(patches: &[Patch], space: &HierarchicalSpace, coefficients: &[[f64; 3]]) {
    let mut n_compared = 0;
    for (patch, shape) in patches.iter().enumerate() {
        for face in space.neighbours().of(patch) {
            for e in (0..space.n_elements()).filter(|&e| space.element(e).patch == patch) {
                let element = space.element(e);
                let (d, end) = (face.own.direction, f64::from(u8::from(face.own.upper)));
                if (element.lower[d] - end).abs() > 0.0 && (element.upper[d] - end).abs() > 0.0 {
                    continue;
                }
                let mut xi = inside(&element, PLACES[e % 2]);
                xi[d] = end;
                let point = shape.point(&xi);
                let mut there = [0.0; 3];
                there[face.other.direction] = f64::from(u8::from(face.other.upper));
                for (along, u) in xi.iter().enumerate() {
                    if let Some((other, is_reversed)) = face.direction(along) {
                        there[other] = if is_reversed { 1.0 - u } else { *u };
                    }
                }
                assert!(apart(&point, &patches[face.other.patch].point(&there)) < 1e-12, "one face");
                let (a, b) = (
                    value(space, coefficients, patch, &xi),
                    value(space, coefficients, face.other.patch, &there),
                );
                assert!(apart(&a, &b) < 1e-12, "{face:?} {xi:?}: {a:?} {b:?}");
                n_compared += 1;
            }
        }
    }
    assert!(n_compared > 100);
}

#[test]
fn a_hierarchy_refined_everywhere_is_the_refined_body() {
    let patches = ball();
    let mut hierarchies: Vec<_> = patches.iter().map(|p| SubdomainHierarchy::new(p.knots())).collect();
    for hierarchy in &mut hierarchies {
        let whole = IndexBox::whole(hierarchy.levels()[0].element_counts());
        follow(hierarchy, [2, 2, 2], &[whole]);
    }
    let space = HierarchicalSpace::of_patches(&patches, hierarchies).unwrap();
    let refined = patches.iter().map(|p| {
        let knots = p.knots().iter().map(|k| split(k, 2)).collect();
        super::nets::refined(p, knots)
    });
    let plain = PatchSpace::new(refined.collect()).unwrap();
    assert_eq!(space.n_functions(), plain.n_functions());
    for (a, b) in space.control_points().iter().zip(plain.control_points()) {
        assert!(apart(a, b) < 1e-12, "{a:?} {b:?}");
    }
}

/// The product of a symmetric matrix, of which the entries on and below the diagonal are kept, with a vector.
fn product(k: &SparseColMat<u32, f64>, u: &[f64]) -> Vec<f64> {
    let mut f = vec![0.0; u.len()];
    for t in k.triplet_iter() {
        f[t.row] += t.val * u[t.col];
        if t.row != t.col {
            f[t.col] += t.val * u[t.row];
        }
    }
    f
}

/// Forces of the displacements `gradient · x` of a body, by function.
fn forces(space: &HierarchicalSpace, gradient: [[f64; 3]; 3]) -> Vec<[f64; 3]> {
    let material = Material::new(1.0, 0.3, 1.0).unwrap();
    let k = assemble(space, &Model::Solid, &material).unwrap().stiffness;
    // What is linear in the place has the displacements of the control points as coefficients.
    let u: Vec<f64> = space
        .control_points()
        .iter()
        .flat_map(|x| gradient.map(|row| row[0] * x[0] + row[1] * x[1] + row[2] * x[2]))
        .collect();
    product(&k, &u).chunks_exact(3).map(|f| [f[0], f[1], f[2]]).collect()
}

fn largest(forces: &[[f64; 3]]) -> f64 {
    forces.iter().flatten().fold(0.0, |m, f| m.max(f.abs()))
}

#[test]
fn rigid_motions_take_no_force() {
    take_no_force(0..1);
}

#[test]
#[ignore = "second tier: half a dozen seconds"]
fn rigid_motions_take_no_force_wherever_patches_are_refined() {
    take_no_force(1..usize::MAX);
}

fn take_no_force(numbers: std::ops::Range<usize>) {
    let patches = ball();
    for (_, regions) in regions(&patches).into_iter().enumerate().filter(|(k, _)| numbers.contains(k)) {
        let space = refined_about(&patches, &regions, 2);
        let force = forces(&space, [[0.0, 1.0, -0.5], [-1.0, 0.0, 0.7], [0.5, -0.7, 0.0]]);
        // Round-off of sums over hundreds of entries of size 1.
        assert!(largest(&force) < 1e-12, "{:e}", largest(&force));
    }
}

/// The unit cube moved by whole numbers.
fn cube(x: f64, y: f64) -> Patch {
    let patch = super::nets::unit_patch(&[2, 2, 2], &[2, 2, 2]);
    let points = patch.control_points().iter().map(|p| [p[0] + x, p[1] + y, p[2]]).collect();
    Patch::new(patch.knots().to_vec(), points, patch.weights().to_vec()).unwrap()
}

#[test]
fn constant_strain_passes_through_refined_patches() {
    // Three cubes about an edge, of which one has its directions in another order, refined at the edge's end.
    let patches = [cube(0.0, 0.0), permuted(&cube(1.0, 0.0), [1, 2, 0]), cube(1.0, 1.0)];
    let mut regions = vec![Vec::new(); 3];
    regions[0] = vec![ParameterBox { lower: [0.9, 0.95, 0.93], upper: [1.0; 3] }];
    let space = refined_about(&patches, &regions, 1);
    for patch in 0..3 {
        assert!(space.basis(patch).hierarchy().leaves().any(|l| l.level == 3), "{patch}");
    }
    let mut on_surface = vec![false; space.n_functions()];
    for face in Face::outer(&patches, false) {
        space.greville(face.id).iter().for_each(|(f, _)| on_surface[*f as usize] = true);
    }
    for gradient in [
        [[1.0, 0.2, 0.0], [0.2, -0.4, 0.3], [0.0, 0.3, 0.8]],
        [[0.0, 0.9, 0.0], [0.0, 0.0, 0.0], [-0.3, 0.0, 0.0]],
    ] {
        let force = forces(&space, gradient);
        // Forces of the surface, of the size of its stress and areas of functions; none inside but for round-off.
        let inside: Vec<[f64; 3]> =
            force.iter().zip(&on_surface).filter(|(_, s)| !**s).map(|(f, _)| *f).collect();
        assert!(largest(&inside) < 1e-14 && largest(&force) > 1e-3, "{:e}", largest(&inside));
        assert!(inside.len() > 20);
    }
}

#[test]
fn levels_that_do_not_fit_are_refused() {
    let patches = ball();
    let plain = || -> Vec<_> { patches.iter().map(|p| SubdomainHierarchy::new(p.knots())).collect() };
    let mut hierarchies = plain();
    follow(&mut hierarchies[2], [2, 2, 2], &[]);
    let text = HierarchicalSpace::of_patches(&patches, hierarchies).unwrap_err().to_string();
    assert!(text.contains("patch 2 has 2 levels, the first one has 1"), "{text}");
    let mut hierarchies = plain();
    for (patch, hierarchy) in hierarchies.iter_mut().enumerate() {
        follow(hierarchy, if patch == 2 { [3, 2, 2] } else { [2, 2, 2] }, &[]);
    }
    let text = HierarchicalSpace::of_patches(&patches, hierarchies).unwrap_err().to_string();
    assert!(text.contains("other knots on level 1 along the face that they share"), "{text}");
    // Two cubes that meet at an edge.
    let fault = HierarchicalSpace::plain_patches(&[cube(0.0, 0.0), cube(1.0, 1.0)]).unwrap_err();
    assert!(matches!(fault, SplineError::Levels(_)), "{fault}");
    assert!(fault.to_string().contains("meet at an edge"), "{fault}");
    assert!(HierarchicalSpace::plain_patches(&[cube(0.0, 0.0), cube(1.0, 0.0), cube(1.0, 1.0)]).is_ok());
}
