//! Gear teeth: the flank against the involute, measures against an independent quadrature, faces, orientation, sizes that make no tooth.

use std::collections::BTreeSet;
use std::f64::consts::{FRAC_PI_4, PI};

use crate::measures::{Measures, integral, measures};
use iga_core::SplineError;
use iga_core::nurbs::Face;
use iga_core::nurbs::joining::join;
use iga_core::nurbs::patch::PointBasis;
use iga_core::nurbs::primitives::gear_tooth::GearTooth;
use iga_core::nurbs::{FaceId, Shape};

/// Deviation of the flank from the involute that the documents state, over the module.
const DEVIATION: f64 = 1e-6;

/// Pinions and wheels, a rack nearly, steep and flat flanks, roots inside and outside of the base circle.
pub fn teeth() -> Vec<GearTooth> {
    let gear = |teeth: usize, degrees: f64, rim: f64| {
        let pitch = 0.5 * teeth as f64;
        GearTooth {
            module: 1.0,
            teeth,
            pressure_angle: f64::to_radians(degrees),
            addendum: 1.0,
            dedendum: 1.25,
            inner_radius: pitch - 1.25 - rim,
        }
    };
    let stub = GearTooth { addendum: 0.8, dedendum: 1.0, ..gear(10, 25.0, 1.5) };
    vec![
        gear(17, 20.0, 1.0),
        gear(20, 20.0, 3.0),
        gear(42, 20.0, 2.0),
        gear(60, 14.5, 2.0),
        gear(400, 20.0, 4.0),
        stub,
    ]
}

/// Half the angle that the tooth takes at the radius `r`, by the involute function of the pressure angle there, which the shape does not use.
fn half_angle(gear: &GearTooth, r: f64) -> f64 {
    let base = 0.5 * gear.module * gear.teeth as f64 * gear.pressure_angle.cos();
    let involute = |cosine: f64| cosine.acos().tan() - cosine.acos();
    let at_pitch = PI / (2.0 * gear.teeth as f64);
    let polar = |r: f64| at_pitch + involute(gear.pressure_angle.cos()) - involute(base / r);
    let start = base * (1.0f64 + 0.05 * 0.05).sqrt();
    if r >= start {
        return polar(r);
    }
    // Below: the tangent at the start, which makes the pressure angle there with the radius.
    let angle = (base / start).acos();
    let beside = start * angle.sin(); // distance of the line from the axis
    polar(start) - (beside / start).asin() + (beside / r).asin()
}

/// Area, centre and second moments of tooth and rim about the axis by circles.
fn exact(gear: &GearTooth) -> Measures {
    let pitch = 0.5 * gear.module * gear.teeth as f64;
    let (root, tip) = (pitch - gear.dedendum, pitch + gear.addendum);
    let base = pitch * gear.pressure_angle.cos() * (1.0f64 + 0.05 * 0.05).sqrt();
    let mut sums = Measures::default();
    let sector = PI / gear.teeth as f64;
    let mut breaks = vec![root];
    if base > root {
        breaks.extend([base, base + 0.05 * (tip - base)]);
    }
    breaks.push(tip);
    let mut add = |from: f64, to: f64, half: &dyn Fn(f64) -> f64| {
        sums.volume += integral(from, to, |r| 2.0 * r * half(r));
        sums.centre[0] += integral(from, to, |r| 2.0 * r * r * half(r).sin());
        sums.second[0] += integral(from, to, |r| r.powi(3) * (half(r) + half(r).sin() * half(r).cos()));
        sums.second[1] += integral(from, to, |r| r.powi(3) * (half(r) - half(r).sin() * half(r).cos()));
    };
    add(gear.inner_radius, root, &|_| sector);
    for part in breaks.windows(2) {
        add(part[0], part[1], &|r| half_angle(gear, r));
    }
    sums.centre[0] /= sums.volume;
    sums
}

#[test]
fn flanks_follow_the_involute_with_its_curvature() {
    for gear in teeth() {
        let shape = gear.plane().unwrap();
        let (patch, mut scratch) = (&shape.patches[0], PointBasis::default());
        let mut largest = 0.0f64;
        for i in 0..=400 {
            for end in [0.0, 1.0] {
                let xi = [f64::from(i) / 400.0, end, 0.0];
                let [x, y, _] = patch.point(&xi);
                let r = x.hypot(y);
                // Across the flank, which is inclined to the radius by less than 45 degrees.
                largest = largest.max((y.atan2(x).abs() - half_angle(&gear, r)).abs() * r);
                let start = gear.base_radius() * 1.00125;
                if r < start * 1.001 {
                    continue;
                }
                let jet = patch.jet(&xi, 2, &mut scratch);
                let ([u, v, _], [a, b, _]) = (jet.first[0], jet.second[0]);
                let radius = u.hypot(v).powi(3) / (u * b - v * a).abs();
                // Fourth power of a span over 384 and the like, of a curve that bends with the roll angle.
                let exact = (r * r - gear.base_radius().powi(2)).sqrt();
                assert!((radius / exact - 1.0).abs() < 1e-3, "{gear:?}: {radius} instead of {exact} at {r}");
                assert!((gear.flank_radius(r) / exact - 1.0).abs() < 1e-12);
            }
        }
        assert!(largest < DEVIATION * gear.module, "{gear:?}: {largest:e}");
        // Tooth and gap are equal on the pitch circle.
        let [x, y, _] = shape.markers["last-flank"];
        assert!((x.hypot(y) - gear.pitch_radius()).abs() < DEVIATION);
        assert!((y.atan2(x) * 2.0 * gear.teeth as f64 / PI - 1.0).abs() < DEVIATION * gear.teeth as f64);
    }
}

#[test]
fn area_centre_and_second_moments_are_those_of_a_quadrature_over_circles() {
    for gear in teeth() {
        let exact = exact(&gear);
        let plane = measures(&gear.plane().unwrap(), false);
        let size = exact.second[0] + exact.second[1];
        let near = |what: &str, found: f64, wanted: f64, scale: f64| {
            // The flank's deviation over the thickness of a tooth, twice.
            assert!(
                (found - wanted).abs() < 2.0 * DEVIATION * scale,
                "{gear:?}: {what} {found} instead of {wanted}"
            );
        };
        near("area", plane.volume, exact.volume, exact.volume);
        near("centre", plane.centre[0], exact.centre[0], exact.centre[0]);
        near("second moment", plane.second[0], exact.second[0], size);
        near("second moment", plane.second[1], exact.second[1], exact.second[1]);
        assert!(plane.centre[1].abs() < 1e-12 * exact.centre[0]);
        let (width, solid) = (0.7, measures(&gear.solid(0.7).unwrap(), false));
        // Sums of some thousand products of round-off.
        assert!((solid.volume / (width * plane.volume) - 1.0).abs() < 1e-12);
        assert!((solid.centre[2] / (0.5 * width) - 1.0).abs() < 1e-12);
        assert!((solid.area / (width * plane.area + 2.0 * plane.volume) - 1.0).abs() < 1e-12);
    }
}

fn grid(dimension: usize) -> impl Iterator<Item = [f64; 3]> {
    (0..13usize.pow(dimension as u32)).map(move |q| {
        std::array::from_fn(
            |d| if d < dimension { (q / 13usize.pow(d as u32) % 13) as f64 / 12.0 } else { 0.0 },
        )
    })
}

#[test]
fn patches_are_regular_and_join_and_all_faces_have_names() {
    for gear in teeth() {
        for (shape, n) in [(gear.plane().unwrap(), 2), (gear.solid(0.5).unwrap(), 3)] {
            shape.check_orientation().unwrap();
            let mut scratch = PointBasis::default();
            for (index, patch) in shape.patches.iter().enumerate() {
                for xi in grid(n) {
                    let jet = patch.jet(&xi, 1, &mut scratch);
                    let length = |t: &[f64; 3]| t.iter().map(|x| x * x).sum::<f64>().sqrt();
                    let sine = jet.determinant(n) / jet.first[..n].iter().map(length).product::<f64>();
                    assert!(sine > 0.1, "{gear:?}: {sine} at {xi:?} of {index}");
                }
            }
            let named: BTreeSet<FaceId> = shape.faces.values().flatten().copied().collect();
            assert_eq!(named, Face::outer(&shape.patches, false).iter().map(|face| face.id).collect());
            let joined = join(&shape.patches, &[]).unwrap();
            assert!(joined.notes.is_empty(), "{:?}", joined.notes);
            for (name, point) in &shape.markers {
                assert!(shape.locate(point).is_ok(), "{gear:?}: {name} is outside");
            }
        }
    }
}

#[test]
fn sizes_that_make_no_tooth_are_refused_by_name() {
    let refused = |name: &str, gear: GearTooth| {
        let result: Result<Shape, SplineError> = gear.plane();
        let Err(SplineError::Dimension { name: found, .. }) = result else { panic!("{name}: {result:?}") };
        assert_eq!(found, name);
    };
    let good = teeth()[0];
    refused("module", GearTooth { module: f64::NAN, ..good });
    refused("teeth", GearTooth { teeth: 5, ..good });
    refused("pressure_angle", GearTooth { pressure_angle: FRAC_PI_4, ..good });
    refused("pressure_angle", GearTooth { pressure_angle: 0.04, ..good });
    refused("addendum", GearTooth { addendum: 2.0, ..good }); // pointed
    refused("dedendum", GearTooth { dedendum: -1.0, ..good });
    refused("dedendum", GearTooth { dedendum: 6.0, inner_radius: 0.1, ..good });
    refused("inner_radius", GearTooth { inner_radius: 7.25, ..good });
    assert!(matches!(good.solid(0.0), Err(SplineError::Dimension { name: "width", .. })));
}
