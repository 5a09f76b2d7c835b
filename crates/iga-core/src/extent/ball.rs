//! Balls inside a body, in two dimensions discs: rules in polar coordinates about the centre.

use super::{Around, ExtentPoint, composite, directions};
use crate::SplineError;
use crate::elasticity::Model;
use crate::nurbs::PatchSearch;

/// Parts of the radius beyond which a ball is not divided further: 32 × 32 × 64 points.
const MOST_PARTS: usize = 8;
/// The same of a disc: 64 × 256 points.
const MOST_PARTS_PLANE: usize = 16;
/// Part of the radius within which a centre counts as lying on the axis.
const ON_AXIS: f64 = 1e-9;

/// Points of the ball.
///
/// # Errors
/// [`SplineError::PointNotFound`] if the centre lies outside the body, [`SplineError::ExtentBeyondBody`] if the ball leaves it.
pub fn points(body: &Around<'_>) -> Result<Vec<ExtentPoint>, SplineError> {
    body.shape.locate(&body.point)?;
    let searches: Vec<PatchSearch> =
        body.shape.patches.iter().map(|p| PatchSearch::new(p, [None; 3])).collect();
    let coarse = located(body, &searches, super::LEAST_PARTS)?;
    let most = if body.space.dimension() == 2 { MOST_PARTS_PLANE } else { MOST_PARTS };
    let parts = body.parts(body.smallest_element(&coarse), most);
    let points = if parts == super::LEAST_PARTS { coarse } else { located(body, &searches, parts)? };
    Ok(points.into_iter().map(|(p, _)| p).collect())
}

fn located(
    body: &Around<'_>,
    searches: &[PatchSearch],
    parts: usize,
) -> Result<Vec<(ExtentPoint, Option<usize>)>, SplineError> {
    let limit = body.slack();
    let mut last = None;
    let mut points = Vec::new();
    for (offset, weight) in rule(body, parts) {
        let target = [0, 1, 2].map(|c| body.point[c] + offset[c]);
        let is_beyond_axis = *body.model == Model::Axisymmetric && target[0] < 0.0;
        let near = last.map(|(patch, xi): (usize, [f64; 3])| {
            (patch, searches[patch].closest_from(&body.shape.patches[patch], &target, &xi))
        });
        let again = || {
            let found = searches.iter().enumerate();
            let found = found.map(|(i, s)| (i, s.closest(&body.shape.patches[i], &target)));
            found.min_by(|a, b| a.1.measure.total_cmp(&b.1.measure))
        };
        let found = near.filter(|(_, l)| l.measure <= limit).or_else(again);
        match found {
            Some((patch, located)) if located.measure <= limit && !is_beyond_axis => {
                points.push((body.at(patch, located.xi, weight), None));
                last = Some((patch, located.xi));
            }
            _ => return Err(body.leaves("ball")),
        }
    }
    Ok(points)
}

/// Offsets from the centre with their measures.
fn rule(body: &Around<'_>, parts: usize) -> Vec<([f64; 3], f64)> {
    let mut points = Vec::new();
    let radii = composite(0.0, body.radius, parts);
    if body.space.dimension() == 3 {
        let n = 8 * parts;
        let share = std::f64::consts::TAU / n as f64;
        for &(rho, w) in &radii {
            for (height, v) in composite(-1.0, 1.0, parts) {
                let ring = rho * (1.0 - height * height).sqrt();
                let weight = rho * rho * w * v * share;
                points
                    .extend(directions(n).map(|(cos, sin)| ([ring * cos, ring * sin, rho * height], weight)));
            }
        }
    } else if *body.model == Model::Axisymmetric && body.point[0] <= ON_AXIS * body.radius {
        // Half a disc, which turned about the axis is a ball.
        for &(rho, w) in &radii {
            let angles = composite(-std::f64::consts::FRAC_PI_2, std::f64::consts::FRAC_PI_2, 2 * parts);
            points
                .extend(angles.into_iter().map(|(a, v)| ([rho * a.cos(), rho * a.sin(), 0.0], rho * w * v)));
        }
    } else {
        let n = 16 * parts;
        let share = std::f64::consts::TAU / n as f64;
        for &(rho, w) in &radii {
            points.extend(directions(n).map(|(cos, sin)| ([rho * cos, rho * sin, 0.0], rho * w * share)));
        }
    }
    points
}
