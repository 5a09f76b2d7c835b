//! The place of a smooth touch on the shapes on which the nodes of meshes lie (docs/theory.md Eq. C.114).
//!
//! Sides that are long beside the radii of a part touch elsewhere than the part: their kinks stand out.

use ffr_dynamics::body::RigidMotion;
use nalgebra::{Matrix2, Vector2, Vector3};

use crate::touch::detection::Nearest;
use crate::touch::parts::line::site;
use crate::touch::parts::side::Moved;

/// Steps of Newton's method for the place at most; from a few degrees away it takes five.
const STEPS: usize = 20;
/// Length for differences of the gap, as a share of a side: of its second ones round-off leaves 1e-7.
const DIFFERENCE: f64 = 1e-3;
/// Step after which the place is known, as a share of a side.
const FOUND: f64 = 1e-6;
/// Distance of a place on a shape from the sides that stand for it, as a share of a side: triangles over two radians of a tube have 0.06.
const OFF_SIDES: f64 = 0.1;

/// The places of a smooth touch with the normal `normal`, from the target to the contact body, where the shapes of the parts
/// are nearest; none if a shape is not known, or ends before, as on splines, which are exact. A plane has its own.
pub fn nearest_of_shapes(
    (surface, pose): Moved<'_>,
    other: Option<Moved<'_>>,
    nearest: &Nearest,
    normal: &Vector3<f64>,
) -> Option<Nearest> {
    if surface.motion() != RigidMotion::Spatial {
        return None;
    }
    let here = surface.place(nearest.contact.face, &nearest.contact.xi);
    let (part, reach) = surface.primitive_at(&here)?;
    let facing = match (other, &nearest.target) {
        (Some((target, at)), Some(there)) => {
            let (part, reach) = target.primitive_at(&target.place(there.face, &there.xi))?;
            Some((part, reach, (target, at)))
        }
        _ => None,
    };
    let outward = pose.rotation.inverse_transform_vector(&-normal);
    let across = outward.cross(&Vector3::ith(outward.iamin(), 1.0)).try_normalize(0.0)?;
    let axes = [across, outward.cross(&across)];
    let on_part =
        |u: &Vector2<f64>| part.onto(&(Vector3::from(here.point) + u[0] * axes[0] + u[1] * axes[1]));
    let gap = |u: &Vector2<f64>| {
        let point = pose.position + pose.rotation * on_part(u);
        facing.map_or_else(
            || point.dot(normal),
            |(part, _, (_, at))| part.height(&at.rotation.inverse_transform_vector(&(point - at.position))).0,
        )
    };
    let place = |(surface, pose): Moved<'_>, point: &Vector3<f64>, reach: f64, outward: &Vector3<f64>| {
        let foot = surface.nearest(point.as_ref()).filter(|foot| foot.distance <= OFF_SIDES * reach)?;
        Some(site(&surface.turned_to(&foot.place, &pose.rotation.inverse_transform_vector(outward)), pose))
    };
    let found = on_part(&lowest(gap, reach)?);
    let contact = place((surface, pose), &found, reach, &-normal)?;
    let target = match facing {
        None => nearest.target,
        Some((part, reach, (target, at))) => {
            let point = pose.position + pose.rotation * found;
            let there = part.onto(&at.rotation.inverse_transform_vector(&(point - at.position)));
            Some(place((target, at), &there, reach, normal)?)
        }
    };
    Some(Nearest { contact, target, ..*nearest })
}

/// Where `value` has its minimum, no farther than `reach` from zero, by Newton's method with differences; none if it has
/// none there, or along a line.
fn lowest(value: impl Fn(&Vector2<f64>) -> f64, reach: f64) -> Option<Vector2<f64>> {
    let h = DIFFERENCE * reach;
    let (u, v) = (Vector2::new(h, 0.0), Vector2::new(0.0, h));
    let mut place = Vector2::zeros();
    for _ in 0..STEPS {
        let at = |step: Vector2<f64>| value(&(place + step));
        let (middle, [a, b, c, d]) = (at(Vector2::zeros()), [u, -u, v, -v].map(at));
        let mixed = 0.25 * (at(u + v) - at(u - v) - at(v - u) + at(-u - v));
        let slope = Vector2::new(0.5 * (a - b), 0.5 * (c - d)) / h;
        let bend = Matrix2::new(a - 2.0 * middle + b, mixed, mixed, c - 2.0 * middle + d) / (h * h);
        let step = bend.cholesky()?.solve(&-slope);
        place += step;
        if place.norm().is_nan() || place.norm() > reach {
            return None;
        }
        if step.norm() <= FOUND * reach {
            return Some(place);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lowest_place_of_a_bowl_is_found_and_none_of_a_trough_or_beyond_reach() {
        let bowl = |x: &Vector2<f64>| {
            let from = x - Vector2::new(0.3, -0.2);
            (1.0 + 2.0 * from[0] * from[0] + 0.5 * from[0] * from[1] + from[1] * from[1]).sqrt()
        };
        let found = lowest(bowl, 1.0).unwrap();
        // Central differences of steps of 1e-3 miss the slope of the fourth order by their square.
        assert!((found - Vector2::new(0.3, -0.2)).norm() < 2e-6, "{found}");
        assert_eq!(lowest(bowl, 0.3), None);
        assert_eq!(lowest(|x| x[0] * x[0], 1.0), None);
        assert_eq!(lowest(|x| x[0] * x[0] - x[1] * x[1], 1.0), None);
    }
}
