//! Shapes of the catalogue beyond ball, rod and box: volume, area, centre and inertia in closed form, exact surfaces, patches that join,
//! over proportions from slender to stout.

use std::collections::BTreeSet;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::measures::{Measures, integral, measures};
use iga_core::SplineError;
use iga_core::nurbs::Face;
use iga_core::nurbs::joining::join;
use iga_core::nurbs::patch::PointBasis;
use iga_core::nurbs::primitives::profile;
use iga_core::nurbs::primitives::round::{self, Round};
use iga_core::nurbs::primitives::rounded_box::rounded_box;
use iga_core::nurbs::{FaceId, Shape};

/// Measures of a body of revolution from the arcs of its meridian, each `(from, to, angle ↦ (r, z))`, run through upwards.
type Arc = (f64, f64, Box<dyn Fn(f64) -> [f64; 2]>);

fn revolution(arcs: &[Arc], flat: f64) -> Measures {
    let mut sums = Measures { area: flat, ..Measures::default() };
    for (from, to, place) in arcs {
        let slope = |t: f64| {
            // Differences of order 6 of functions that vary over the whole range: error (1e-2)^6, round-off 1e-16 over the step.
            let h = 1e-2 * (to - from);
            let d = |k: f64| {
                let ([r0, z0], [r1, z1]) = (place(t - k * h), place(t + k * h));
                [r1 - r0, z1 - z0]
            };
            let (a, b, c) = (d(1.0), d(2.0), d(3.0));
            [0, 1].map(|i| (45.0 * a[i] - 9.0 * b[i] + c[i]) / (60.0 * h))
        };
        let over = |f: &dyn Fn(f64, f64) -> f64| {
            integral(*from, *to, |t| {
                let ([r, z], [_, dz]) = (place(t), slope(t));
                f(r, z) * dz
            })
        };
        sums.volume += over(&|r, _| PI * r * r);
        sums.centre[2] += over(&|r, z| PI * r * r * z);
        sums.second[0] += over(&|r, _| 0.25 * PI * r.powi(4));
        sums.second[2] += over(&|r, z| PI * r * r * z * z);
        sums.area += integral(*from, *to, |t| {
            let ([r, _], [dr, dz]) = (place(t), slope(t));
            TAU * r * dr.hypot(dz)
        });
    }
    sums.second[1] = sums.second[0];
    sums.centre[2] /= sums.volume;
    sums
}

fn arc(from: f64, to: f64, place: impl Fn(f64) -> [f64; 2] + 'static) -> Arc {
    (from, to, Box::new(place))
}

/// Boxes `[lower, upper]` added to one another.
fn boxes(parts: &[[[f64; 3]; 2]], area: f64) -> Measures {
    let mut sums = Measures { area, ..Measures::default() };
    for [lower, upper] in parts {
        let volume: f64 = (0..3).map(|d| upper[d] - lower[d]).product();
        sums.volume += volume;
        for d in 0..3 {
            let (a, b) = (lower[d], upper[d]);
            sums.centre[d] += volume * 0.5 * (a + b);
            sums.second[d] += volume * (a * a + a * b + b * b) / 3.0;
        }
    }
    sums.centre = sums.centre.map(|m| m / sums.volume);
    sums
}

/// A shape with what is known of it: whether it is axisymmetric, its measures, and the distance of a point from its surface.
struct Case {
    name: String,
    shape: Shape,
    is_axisymmetric: bool,
    exact: Measures,
    distance: Box<dyn Fn([f64; 3]) -> f64>,
}

fn both(round: Round, exact: Measures, distance: impl Fn(f64, f64) -> f64 + Clone + 'static) -> [Case; 2] {
    let around = distance.clone();
    let solid = Case {
        name: format!("solid {round:?}"),
        shape: round.solid().unwrap(),
        is_axisymmetric: false,
        exact,
        distance: Box::new(move |[x, y, z]| around(x.hypot(y), z)),
    };
    let section = Case {
        name: format!("axisymmetric {round:?}"),
        shape: round.axisymmetric().unwrap(),
        is_axisymmetric: true,
        exact,
        distance: Box::new(move |[r, z, _]| distance(r, z)),
    };
    [solid, section]
}

fn cones() -> impl Iterator<Item = Case> {
    [[1.0, 0.5, 2.0], [0.2, 1.0, 0.1], [1.0, 1.0, 30.0], [1.0, 0.01, 1.0]].into_iter().flat_map(
        |[a, b, l]| {
            let side = arc(0.0, 1.0, move |t| [a + t * (b - a), t * l]);
            let exact = revolution(&[side], PI * (a * a + b * b));
            let slant = (a - b).hypot(l);
            both(Round::Cone { radius: a, end_radius: b, length: l }, exact, move |r, z| {
                let jacket = ((r - a) * l - (b - a) * z) / slant;
                jacket.abs().min(z.abs()).min((z - l).abs())
            })
        },
    )
}

fn capsules() -> impl Iterator<Item = Case> {
    [[1.0, 2.2], [1.0, 5.0], [0.3, 12.0]].into_iter().flat_map(|[r, l]| {
        let lower = arc(0.0, FRAC_PI_2, move |t| [r * t.sin(), r * (1.0 - t.cos())]);
        let upper = arc(0.0, FRAC_PI_2, move |t| [r * t.cos(), l - r * (1.0 - t.sin())]);
        let exact = revolution(&[lower, arc(r, l - r, move |z| [r, z]), upper], 0.0);
        both(Round::Capsule { radius: r, length: l }, exact, move |x, z| x.hypot(z - z.clamp(r, l - r)) - r)
    })
}

fn rounded_cylinders() -> impl Iterator<Item = Case> {
    let list = [
        (1.0, 3.0, Some(2.0), Some(0.2)),
        (1.0, 0.4, Some(20.0), Some(0.05)),
        (1.0, 40.0, Some(1.2), Some(0.9)),
        (1.0, 1.3, None, Some(0.5)),
        (1.0, 2.0, Some(5.0), None),
        (1.0, 3.0, Some(1.0), None),
        (1.0, 1.0, None, None),
    ];
    list.into_iter().flat_map(|(r, l, crown, fillet)| {
        let f = fillet.unwrap_or(0.0);
        let c: f64 = crown.unwrap_or(f64::INFINITY);
        // Height of the fillet's centre, and half the opening of the crown.
        let (height, opening) = match crown {
            Some(c) => (c - ((c - f).powi(2) - (r - f).powi(2)).sqrt(), ((r - f) / (c - f)).asin()),
            None => (f, 0.0),
        };
        let mut arcs = vec![arc(height, l, move |z| [r, z])];
        if crown.is_some() {
            arcs.push(arc(0.0, opening, move |t| [c * t.sin(), c * (1.0 - t.cos())]));
        }
        if f > 0.0 {
            arcs.push(arc(opening, FRAC_PI_2, move |t| [r - f + f * t.sin(), height - f * t.cos()]));
        }
        let flat = if crown.is_some() { PI * r * r } else { PI * (r * r + (r - f).powi(2)) };
        let exact = revolution(&arcs, flat);
        let round =
            Round::RoundedCylinder { radius: r, length: l, crown_radius: crown, fillet_radius: fillet };
        both(round, exact, move |x, z| {
            let end = if crown.is_some() { (x.hypot(z - c) - c).abs() } else { z.abs() };
            let jacket = (x - r).abs().min((z - l).abs());
            end.min((x - r + f).hypot(z - height) - f).abs().min(jacket)
        })
    })
}

fn tori() -> Vec<Case> {
    let mut cases = Vec::new();
    for (a, b) in [(1.0, 0.05), (1.0, 0.4), (1.0, 0.95)] {
        let volume = 2.0 * PI * PI * a * b * b;
        let across = volume * (0.5 * a * a + 0.375 * b * b);
        let exact = Measures {
            volume,
            area: 4.0 * PI * PI * a * b,
            centre: [0.0; 3],
            second: [across, across, 0.25 * volume * b * b],
        };
        let distance = move |r: f64, z: f64| (r - a).hypot(z) - b;
        let name = |kind: &str| format!("{kind} torus {a} {b}");
        cases.push(Case {
            name: name("solid"),
            shape: round::torus(a, b).unwrap(),
            is_axisymmetric: false,
            exact,
            distance: Box::new(move |[x, y, z]| distance(x.hypot(y), z)),
        });
        cases.push(Case {
            name: name("axisymmetric"),
            shape: round::axisymmetric_torus(a, b).unwrap(),
            is_axisymmetric: true,
            exact,
            distance: Box::new(move |[r, z, _]| distance(r, z)),
        });
    }
    cases
}

fn solid(name: String, shape: Shape, exact: Measures, distance: impl Fn([f64; 3]) -> f64 + 'static) -> Case {
    Case { name, shape, is_axisymmetric: false, exact, distance: Box::new(distance) }
}

fn sectors() -> impl Iterator<Item = Case> {
    let list =
        [(0.5, 1.0, 0.7, 1.0), (0.9, 1.0, 0.01, PI), (0.1, 1.0, 20.0, 6.2), (1.0, 1.5, 1.0, FRAC_PI_2)];
    list.into_iter().map(|(a, b, l, angle): (f64, f64, f64, f64)| {
        let (half, volume) = (0.5 * angle, 0.5 * angle * (b * b - a * a) * l);
        let polar = (b.powi(4) - a.powi(4)) / 8.0 * l;
        let exact = Measures {
            volume,
            area: angle * (a + b) * l + 2.0 * (b - a) * l + angle * (b * b - a * a),
            centre: [2.0 / 3.0 * (b.powi(3) - a.powi(3)) / (b * b - a * a) * half.sin() / half, 0.0, 0.5 * l],
            second: [polar * (angle + angle.sin()), polar * (angle - angle.sin()), volume * l * l / 3.0],
        };
        let shape = profile::tube_sector(a, b, l, angle).unwrap();
        solid(format!("sector {a} {b} {l} {angle}"), shape, exact, move |[x, y, z]| {
            let (r, phi) = (x.hypot(y), y.atan2(x).abs());
            [r - a, r - b, z, z - l, r * (phi - half).sin()].into_iter().fold(1.0, |d, v: f64| d.min(v.abs()))
        })
    })
}

fn plates() -> Vec<Case> {
    let mut cases = Vec::new();
    for [w, h, r, t] in
        [[2.0, 2.0, 0.1, 0.1], [6.0, 2.0, 0.9, 1.0], [2.0, 2.4, 0.5, 0.3], [1.0, 20.0, 0.2, 0.05]]
    {
        let hole = PI * r * r;
        let round = Measures { volume: hole, second: [0.25 * hole * r * r; 3], ..Measures::default() };
        let plate = boxes(&[[[-0.5 * w, -0.5 * h, -0.5 * t], [0.5 * w, 0.5 * h, 0.5 * t]]], 0.0);
        let in_plane = |d: usize| plate.second[d] - t * round.second[d];
        let volume = plate.volume - t * hole;
        let exact = Measures {
            volume,
            area: 2.0 * (w * h - hole) + t * (2.0 * (w + h) + TAU * r),
            centre: [0.0; 3],
            second: [in_plane(0), in_plane(1), volume * t * t / 12.0],
        };
        let sides = move |x: f64, y: f64| {
            (x.abs() - 0.5 * w).abs().min((y.abs() - 0.5 * h).abs()).min((x.hypot(y) - r).abs())
        };
        let name = format!("plate {w} {h} {r} {t}");
        let shape = profile::solid_plate_with_hole([w, h], r, t).unwrap();
        cases.push(solid(name.clone(), shape, exact, move |[x, y, z]| {
            sides(x, y).min((z.abs() - 0.5 * t).abs())
        }));
        let plane = Measures {
            volume: volume / t,
            area: 2.0 * (w + h) + TAU * r,
            second: [exact.second[0] / t, exact.second[1] / t, 0.0],
            ..exact
        };
        let shape = profile::plate_with_hole([w, h], r).unwrap();
        cases.push(solid(format!("plane {name}"), shape, plane, move |[x, y, _]| sides(x, y)));
    }
    cases
}

fn beams() -> Vec<Case> {
    let mut cases = Vec::new();
    for [w, h, t, s, l] in [[1.0, 2.0, 0.2, 0.3, 10.0], [1.0, 0.5, 0.4, 0.9, 0.3]] {
        let exact = boxes(
            &[[[0.0; 3], [w, t, l]], [[0.0, t, 0.0], [t, h, l]]],
            2.0 * (w + h) * l + 2.0 * t * (w + h - t),
        );
        let shape = profile::l_beam(w, h, t, l).unwrap();
        cases.push(solid(format!("L {w} {h} {t} {l}"), shape, exact, move |[x, y, z]| {
            [x, y, z, x - w, y - h, z - l, x - t, y - t].into_iter().fold(1.0, |d, v: f64| d.min(v.abs()))
        }));
        let (u, v) = (0.5 * s, 0.5 * w);
        let exact = boxes(
            &[[[-v, -t, 0.0], [v, 0.0, l]], [[-u, -h, 0.0], [u, -t, l]]],
            2.0 * (w + h) * l + 2.0 * (w * t + s * (h - t)),
        );
        let shape = profile::t_beam(w, h, t, s, l).unwrap();
        cases.push(solid(format!("T {w} {h} {t} {s} {l}"), shape, exact, move |[x, y, z]| {
            let x = x.abs();
            [y, z, x - v, y + h, z - l, x - u, y + t].into_iter().fold(1.0, |d, v: f64| d.min(v.abs()))
        }));
    }
    cases
}

fn rounded_boxes() -> impl Iterator<Item = Case> {
    [([1.0, 1.0, 1.0], 0.1), ([1.0, 2.0, 3.0], 0.45), ([0.1, 1.0, 4.0], 0.01)].into_iter().map(|(size, f)| {
        let straight = size.map(|s| s - 2.0 * f);
        let [a, b, c] = straight;
        let (pairs, sum) = (a * b + b * c + c * a, a + b + c);
        // ∫ x² over sections across x: rectangles with round corners, at the ends of the radius of the ball there.
        let second = |d: usize| {
            let (p, q) = (straight[(d + 1) % 3], straight[(d + 2) % 3]);
            let section = |r: f64| p * q + 2.0 * r * (p + q) + PI * r * r;
            let h = 0.5 * straight[d];
            let end = integral(0.0, FRAC_PI_2, |t: f64| {
                (h + f * t.sin()).powi(2) * section(f * t.cos()) * f * t.cos()
            });
            2.0 * (h.powi(3) / 3.0 * section(f) + end)
        };
        let exact = Measures {
            volume: a * b * c + 2.0 * f * pairs + PI * f * f * sum + 4.0 / 3.0 * PI * f.powi(3),
            area: 2.0 * pairs + TAU * f * sum + 4.0 * PI * f * f,
            centre: [0.0; 3],
            second: [second(0), second(1), second(2)],
        };
        solid(format!("rounded box {size:?} {f}"), rounded_box(size, f).unwrap(), exact, move |p| {
            let beyond = [0, 1, 2].map(|d| (p[d].abs() - 0.5 * straight[d]).max(0.0));
            beyond.iter().map(|v| v * v).sum::<f64>().sqrt() - f
        })
    })
}

fn cases() -> Vec<Case> {
    let mut all: Vec<Case> = cones().chain(capsules()).chain(rounded_cylinders()).chain(tori()).collect();
    all.extend(sectors().chain(plates()).chain(beams()).chain(rounded_boxes()));
    all
}

#[test]
fn volume_area_centre_and_inertia_are_those_of_closed_forms() {
    for case in cases() {
        let found = measures(&case.shape, case.is_axisymmetric);
        let Measures { volume, area, centre, second } = case.exact;
        // Sums of some thousand products of round-off.
        let near = |what: &str, found: f64, exact: f64, scale: f64| {
            assert!(
                (found - exact).abs() < 1e-12 * scale,
                "{}: {what} {found} instead of {exact}",
                case.name
            );
        };
        near("volume", found.volume, volume, volume);
        near("area", found.area, area, area);
        let size = second.iter().sum::<f64>();
        for d in 0..3 {
            near("centre", found.centre[d], centre[d], (size / volume).sqrt());
            near("second moment", found.second[d], second[d], size);
        }
    }
}

/// A closed grid of `n + 1` values per direction on the unit box.
fn grid(dimension: usize, n: usize) -> impl Iterator<Item = [f64; 3]> {
    (0..(n + 1).pow(dimension as u32)).map(move |q| {
        let mut xi = [0.0; 3];
        for (d, u) in xi.iter_mut().enumerate().take(dimension) {
            *u = (q / (n + 1).pow(d as u32) % (n + 1)) as f64 / n as f64;
        }
        xi
    })
}

#[test]
fn determinants_are_positive_but_on_declared_circles() {
    for case in cases() {
        case.shape.check_orientation().unwrap();
        let mut scratch = PointBasis::default();
        for (index, patch) in case.shape.patches.iter().enumerate() {
            let n = patch.dimension();
            for xi in grid(n, 12) {
                // Against the product of the tangents: the sine of their angles, whatever the proportions.
                let jet = patch.jet(&xi, 1, &mut scratch);
                let length = |t: &[f64; 3]| t.iter().map(|x| x * x).sum::<f64>().sqrt();
                let sine = jet.determinant(n) / jet.first[..n].iter().map(length).product::<f64>();
                match case.shape.singular_in(index, &xi, &xi) {
                    // Round-off of control points by the size of an element.
                    Some(_) => assert!(sine.abs() < 1e-9, "{}: {sine} at {xi:?} of {index}", case.name),
                    None => assert!(sine > 0.01, "{}: {sine} at {xi:?} of {index}", case.name),
                }
            }
        }
    }
}

#[test]
fn outer_faces_have_names_and_lie_on_the_surface() {
    for case in cases() {
        let named: BTreeSet<FaceId> = case.shape.faces.values().flatten().copied().collect();
        let outer = Face::outer(&case.shape.patches, case.is_axisymmetric);
        assert_eq!(named, outer.iter().map(|face| face.id).collect(), "{}", case.name);
        let size = case
            .shape
            .patches
            .iter()
            .flat_map(|p| p.control_points())
            .flatten()
            .fold(0.0, |s: f64, x| s.max(x.abs()));
        for face in outer {
            let patch = &case.shape.patches[face.id.patch];
            for xi in grid(patch.dimension(), 12) {
                let point = patch.point(&face.on_face(&xi));
                let distance = (case.distance)(point).abs();
                // Sums of 27 products.
                assert!(distance < 1e-14 * size, "{}: {distance} at {point:?}", case.name);
            }
        }
        for (name, point) in &case.shape.markers {
            let nearest =
                case.shape.patches.iter().any(|p| iga_core::nurbs::locate::locate(p, point).is_ok());
            assert!(nearest, "{}: marker {name} is not in the material", case.name);
        }
    }
}

#[test]
fn patches_join_by_their_geometry_without_notes() {
    for case in cases() {
        let joined = join(&case.shape.patches, &[]).unwrap_or_else(|fault| panic!("{}: {fault}", case.name));
        assert!(joined.notes.is_empty(), "{}: {:?}", case.name, joined.notes);
        assert_eq!(joined.shape.singular.len(), case.shape.singular.len(), "{}", case.name);
    }
}

#[test]
fn sizes_that_do_not_fit_are_refused_by_name() {
    let rounded = |crown_radius, fillet_radius, length| Round::RoundedCylinder {
        radius: 1.0,
        length,
        crown_radius,
        fillet_radius,
    };
    let refused = |name: &str, result: Result<Shape, SplineError>| {
        let Err(SplineError::Dimension { name: found, .. }) = result else { panic!("{name}: {result:?}") };
        assert_eq!(found, name);
    };
    for v in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        refused("radius", Round::Cone { radius: v, end_radius: 1.0, length: 1.0 }.solid());
        refused("end_radius", Round::Cone { radius: 1.0, end_radius: v, length: 1.0 }.axisymmetric());
        refused("length", Round::Capsule { radius: 1.0, length: v }.solid());
        refused("crown_radius", rounded(Some(v), None, 1.0).solid());
        refused("fillet_radius", rounded(None, Some(v), 1.0).axisymmetric());
        refused("tube_radius", round::torus(1.0, v));
        refused("hole_radius", profile::plate_with_hole([1.0, 1.0], v));
        refused("thickness", profile::solid_plate_with_hole([1.0, 1.0], 0.1, v));
        refused("thickness", profile::l_beam(1.0, 1.0, v, 1.0));
        refused("web_thickness", profile::t_beam(1.0, 1.0, 0.1, v, 1.0));
        refused("fillet_radius", rounded_box([1.0; 3], v));
    }
    refused("length", Round::Capsule { radius: 1.0, length: 2.0 }.solid());
    refused("crown_radius", rounded(Some(0.99), None, 3.0).solid());
    refused("crown_radius", rounded(Some(1.0), Some(0.1), 3.0).solid());
    refused("radius", rounded(None, Some(1.0), 3.0).solid());
    refused("length", rounded(Some(1.0), None, 1.0).solid());
    refused("radius", round::torus(1.0, 1.0));
    refused("angle", profile::tube_sector(0.5, 1.0, 1.0, TAU));
    refused("hole_radius", profile::plate_with_hole([1.0, 2.0], 0.5));
    refused("thickness", profile::l_beam(1.0, 0.5, 0.5, 1.0));
    refused("web_thickness", profile::t_beam(1.0, 1.0, 0.1, 1.0, 1.0));
    refused("flange_thickness", profile::t_beam(1.0, 1.0, 1.0, 0.1, 1.0));
    refused("fillet_radius", rounded_box([1.0, 2.0, 3.0], 0.5));
}
