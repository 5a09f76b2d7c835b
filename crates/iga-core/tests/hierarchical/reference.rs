//! Active functions, values and integrals against independently computed ones.

use std::collections::HashMap;

use iga_core::hierarchical::truncation::{OperatorBuilder, Truncation};
use iga_core::hierarchical::{HierarchicalBasis, IndexBox, SubdomainHierarchy};
use iga_core::splines::basis::basis_derivatives;
use iga_core::splines::knots::KnotVector;

/// The file gives fifteen decimals.
const VALUE_TOL: f64 = 2e-15;
/// Gauss sums over up to 200 elements.
const INTEGRAL_TOL: f64 = 1e-15;

#[derive(Default)]
struct Case {
    name: String,
    numbers: HashMap<String, Vec<Vec<f64>>>,
}

impl Case {
    fn lines(&self, key: &str) -> &[Vec<f64>] {
        self.numbers.get(key).map_or(&[], Vec::as_slice)
    }

    fn counts(&self, key: &str) -> Vec<usize> {
        self.lines(key)[0].iter().map(|&x| x as usize).collect()
    }
}

fn cases() -> Vec<Case> {
    let mut cases: Vec<Case> = Vec::new();
    for line in include_str!("../data/hierarchical_reference.txt").lines().filter(|l| !l.starts_with('#')) {
        let mut words = line.split_whitespace();
        let key = words.next().unwrap();
        if key == "case" {
            cases.push(Case { name: words.next().unwrap().into(), ..Case::default() });
            continue;
        }
        let numbers = words.filter(|w| *w != "-").map(|w| w.parse().unwrap()).collect();
        cases.last_mut().unwrap().numbers.entry(key.into()).or_default().push(numbers);
    }
    cases
}

fn basis_of(case: &Case) -> HierarchicalBasis {
    let knots: Vec<KnotVector> = case
        .counts("degrees")
        .iter()
        .zip(case.counts("elements"))
        .map(|(&p, n)| KnotVector::uniform(p, n).unwrap())
        .collect();
    let mut hierarchy = SubdomainHierarchy::new(&knots);
    for (b, &parts) in case.lines("box").iter().zip(&case.counts("split")) {
        let counts = hierarchy.levels().last().unwrap().element_counts();
        let place = |u: f64, d: usize| (u * counts[d] as f64).round() as usize;
        let lower = [place(b[0], 0), place(b[2], 1), 0];
        let upper = [place(b[1], 0), place(b[3], 1), 1];
        hierarchy.refine([parts, parts, 1], &[IndexBox { lower, upper }]).unwrap();
    }
    HierarchicalBasis::new(hierarchy)
}

/// Values of all functions at a point of leaf `e`.
fn values(basis: &HierarchicalBasis, e: usize, xi: &[f64], kind: Truncation) -> Vec<f64> {
    let leaf = basis.hierarchy().leaves().nth(e).unwrap();
    let knots = basis.hierarchy().levels()[leaf.level].knots();
    let mut tables = vec![Vec::new(); 2];
    for d in 0..2 {
        tables[d] = vec![0.0; knots[d].degree() + 1];
        basis_derivatives(&knots[d], leaf.index[d], xi[d], 0, &mut tables[d]);
    }
    let local: Vec<f64> = tables[1].iter().flat_map(|b| tables[0].iter().map(move |a| a * b)).collect();
    let mut builder = OperatorBuilder::default();
    let operator = builder.build(basis, &leaf, kind);
    let mut all = vec![0.0; basis.n_functions()];
    for (r, &f) in operator.functions.iter().enumerate() {
        all[f as usize] = match operator.rows.get(r * local.len()..(r + 1) * local.len()) {
            Some(row) => row.iter().zip(&local).map(|(a, b)| a * b).sum(),
            None => local[r],
        };
    }
    all
}

#[test]
fn active_functions_and_leaves_equal_the_reference() {
    let cases = cases();
    assert_eq!(cases.len(), 4);
    for case in &cases {
        let basis = basis_of(case);
        assert_eq!(basis.hierarchy().levels().len(), 3);
        for (l, expected) in case.lines("active").iter().enumerate() {
            let found: Vec<f64> = basis.active_on_level(l).iter().map(|&f| f as f64).collect();
            assert_eq!(&found, expected, "{} level {l}", case.name);
        }
        if let Some(&n) = case.lines("leaves")[0].first() {
            assert_eq!(basis.hierarchy().n_leaves(), n as usize, "{}", case.name);
        }
    }
}

#[test]
fn values_equal_the_reference() {
    for case in &cases() {
        let basis = basis_of(case);
        for (key, kind) in [("hb", Truncation::Plain), ("thb", Truncation::Truncated)] {
            for (q, point) in case.lines("point").iter().enumerate() {
                let (_, e) = basis.hierarchy().find_leaf(&[point[0], point[1], 0.0]);
                let found = values(&basis, e, point, kind);
                let mut expected = vec![0.0; found.len()];
                for entry in case.lines(key).iter().filter(|l| l[1] as usize == q) {
                    expected[entry[0] as usize] = entry[2];
                }
                for (f, (a, b)) in found.iter().zip(&expected).enumerate() {
                    assert!((a - b).abs() < VALUE_TOL, "{} {key} {f} at point {q}: {a} {b}", case.name);
                }
            }
        }
    }
}

#[test]
fn integrals_equal_the_reference() {
    // Four Gauss points: exact to degree 7.
    let nodes: [(f64, f64); 4] = [
        (-0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
        (-0.339_981_043_584_856_3, 0.652_145_154_862_546_2),
        (0.339_981_043_584_856_3, 0.652_145_154_862_546_2),
        (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
    ];
    for case in &cases() {
        let basis = basis_of(case);
        for (key, kind) in [("hb_integrals", Truncation::Plain), ("thb_integrals", Truncation::Truncated)] {
            let mut sums = vec![0.0; basis.n_functions()];
            for (e, leaf) in basis.hierarchy().leaves().enumerate() {
                let knots = basis.hierarchy().levels()[leaf.level].knots();
                let ((a0, b0), (a1, b1)) = (knots[0].element(leaf.index[0]), knots[1].element(leaf.index[1]));
                for (x, wx) in nodes {
                    for (y, wy) in nodes {
                        let at = [a0 + 0.5 * (x + 1.0) * (b0 - a0), a1 + 0.5 * (y + 1.0) * (b1 - a1)];
                        let w = 0.25 * wx * wy * (b0 - a0) * (b1 - a1);
                        for (s, v) in sums.iter_mut().zip(values(&basis, e, &at, kind)) {
                            *s += w * v;
                        }
                    }
                }
            }
            for (f, (a, b)) in sums.iter().zip(&case.lines(key)[0]).enumerate() {
                assert!((a - b).abs() < INTEGRAL_TOL, "{} {key} {f}: {a} {b}", case.name);
            }
        }
    }
}

#[test]
fn number_of_truncated_functions_equals_the_reference() {
    for case in &cases() {
        let basis = basis_of(case);
        let mut is_truncated = vec![false; basis.n_functions()];
        for leaf in basis.hierarchy().leaves() {
            let mut builders = [OperatorBuilder::default(), OperatorBuilder::default()];
            let [of_plain, of_short] = &mut builders;
            let plain = of_plain.build(&basis, &leaf, Truncation::Plain);
            let short = of_short.build(&basis, &leaf, Truncation::Truncated);
            let n = basis.hierarchy().levels()[0].knots().iter().map(|k| k.degree() + 1).product::<usize>();
            for (r, &f) in plain.functions.iter().enumerate() {
                let row = |o: &iga_core::hierarchical::truncation::ElementOperator, r: usize| -> Vec<f64> {
                    if o.rows.is_empty() {
                        (0..n).map(|c| f64::from(u8::from(c == r))).collect()
                    } else {
                        o.rows[r * n..(r + 1) * n].to_vec()
                    }
                };
                let same = short.functions.iter().position(|&g| g == f).map(|s| row(short, s));
                is_truncated[f as usize] |= same != Some(row(plain, r));
            }
        }
        let count = is_truncated.iter().filter(|t| **t).count();
        assert_eq!(count, case.counts("truncated")[0], "{}", case.name);
    }
}
