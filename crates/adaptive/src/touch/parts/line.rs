//! Touches along a whole straight line of a curved face, such as that of a cylinder that lies on a
//! plane (docs/theory.md Eqs. C.66, C.67).
//!
//! The search for the nearest places finds any place of such a line, often its end, where an edge
//! seems to touch. The interval of the contact lies about the middle of the line and is as long as
//! the face.

use contact_qs::search::SurfaceSite;
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::force::BodyState;
use nalgebra::Vector3;

use crate::record::TargetPlace;
use crate::surface::{ALONG_LINE, Foot, StraightLine, SurfacePlace, least_at};
use crate::touch::detection::Nearest;
use crate::touch::hertz::local_surface::SurfaceView;
use crate::touch::parts::Touch;
use crate::touch::parts::side::{EdgeOver, Moved, Side, slack, touch_direction};
use crate::touch::tolerances::{ACROSS_LINE, FLAT, SHORTEST_LINE};

/// Halvings of a line in the search for the end of a body over it.
const HALVINGS: usize = 30;
/// Steps of the search for the nearest place across a line, each of which leaves 0.62 of the way: the gap, quadratic about the place,
/// tells half of the digits.
const STEPS: usize = 30;

/// The touch `nearest` of a contact body and a target, surfaces with their motions (a plane without
/// the latter), at the middle of the straight line of a face of either along which they touch;
/// `None` if they do not. Lines may be inclined by the angle `parallel` \[rad\].
pub fn middle_of_line(
    own: Moved<'_>,
    other: Option<Moved<'_>>,
    nearest: &Nearest,
    parallel: f64,
) -> Option<Nearest> {
    if own.0.motion() != RigidMotion::Spatial {
        return None;
    }
    let (side, target) = (Side::new(own), other.map(Side::new));
    let normal = touch_direction(&side, target.as_ref(), nearest);
    let touch = LineTouch { size: side.size(), slack: parallel * side.size(), gap: nearest.gap.abs() };
    let along = touch.along((own, &nearest.contact), other, &-normal);
    let over = |other: Moved<'_>| {
        let (target, contact, way) = touch.over((other, nearest.target.as_ref()?), own, &normal)?;
        Some((contact, Some(target), way))
    };
    let (mut contact, mut target, way) = along.or_else(|| over(other?))?;
    if let Some(place) = nearest_across((own, &contact), other, (&-normal, &way)) {
        contact = site(&place, own.1);
        target = other.and_then(|other| Some(site(&nearest_on(other, &contact.point)?.place, other.1)));
    } else if let Some((other, there)) = other.zip(target.as_ref())
        && let Some(place) = nearest_across((other, there), Some(own), (&normal, &way))
    {
        let there = site(&place, other.1);
        (target, contact) = (Some(there), site(&nearest_on(own, &there.point)?.place, own.1));
    }
    Some(Nearest { contact, target: target.or(nearest.target), ..*nearest })
}

/// Lengths by which a line of touch is recognised.
struct LineTouch {
    /// Size of the contact body \[m\].
    size: f64,
    /// Largest deviation of the line from the surface that it touches \[m\].
    slack: f64,
    /// Distance of the bodies \[m\].
    gap: f64,
}

impl LineTouch {
    /// The middle of a straight line of the surface `first` through the place `here` along which it
    /// touches `second` (a plane without one) in the direction `outward` of space, the place of
    /// that which is nearest to it, and the line's direction in space.
    fn along(
        &self,
        ((first, pose), here): (Moved<'_>, &SurfaceSite),
        second: Option<Moved<'_>>,
        outward: &Vector3<f64>,
    ) -> Option<(SurfaceSite, Option<SurfaceSite>, Vector3<f64>)> {
        let place = first.place(here.face, &here.xi);
        let (start, in_body) = (Vector3::from(place.point), pose.rotation.inverse_transform_vector(outward));
        for line in first.lines_through(&place.point) {
            let is_touched = line.points.iter().all(|p| (p - start).dot(&in_body).abs() <= self.slack);
            let view = is_touched.then(|| SurfaceView::new(first, 1.0, &pose.rotation, &line.middle));
            let Some(view) = view.flatten().filter(|view| (view.outward - outward).norm() <= ACROSS_LINE)
            else {
                continue;
            };
            let (middle, way) = (in_space(&line, pose), pose.rotation * line.way());
            let Some((surface, at)) = second else {
                return self.is_curved(&view).then_some((middle, None, way));
            };
            let on_second =
                |point: &Vector3<f64>| nearest_on((surface, at), &(pose.position + pose.rotation * point));
            let is_along = |point: &Vector3<f64>| {
                on_second(point).is_some_and(|foot| (foot.distance - self.gap).abs() <= self.slack)
            };
            if line.points.iter().all(is_along) {
                let there = on_second(&line.points[ALONG_LINE.len() / 2])?.place;
                let facing = SurfaceView::new(surface, 1.0, &at.rotation, &there)?;
                let is_line = self.is_curved(&view) || self.is_curved(&facing);
                return is_line.then(|| (middle, Some(site(&there, at)), way));
            }
        }
        None
    }

    /// The middle of the part of a straight line of the surface `first` through the place `here`
    /// that lies over `second` in the direction `outward` of space, where that may end before the
    /// line does, the place of `second` there, and the line's direction in space.
    fn over(
        &self,
        ((first, pose), here): (Moved<'_>, &SurfaceSite),
        (second, at): Moved<'_>,
        outward: &Vector3<f64>,
    ) -> Option<(SurfaceSite, SurfaceSite, Vector3<f64>)> {
        let place = first.place(here.face, &here.xi);
        let start = Vector3::from(place.point);
        let on_second =
            |point: &Vector3<f64>| nearest_on((second, at), &(pose.position + pose.rotation * point));
        let is_over = |point: &Vector3<f64>| {
            on_second(point).is_some_and(|foot| (foot.distance - self.gap).abs() <= self.slack)
        };
        for line in first.lines_through(&place.point) {
            let ends = [line.points[0], line.points[ALONG_LINE.len() - 1]].map(|end| {
                let [mut inside, mut outside] = if is_over(&end) { [1.0; 2] } else { [0.0, 1.0] };
                for _ in 0..HALVINGS {
                    let middle = 0.5 * (inside + outside);
                    if is_over(&(start + middle * (end - start))) {
                        inside = middle
                    } else {
                        outside = middle
                    }
                }
                start + inside * (end - start)
            });
            let points = ALONG_LINE.map(|share| ends[0] + share * (ends[1] - ends[0]));
            if (ends[1] - ends[0]).norm() <= SHORTEST_LINE * self.size || !points.iter().all(is_over) {
                continue;
            }
            let middle = first.nearest(&points[ALONG_LINE.len() / 2].into())?.place;
            let middle = first.turned_to(&middle, &pose.rotation.inverse_transform_vector(outward));
            let view = SurfaceView::new(first, 1.0, &pose.rotation, &middle)?;
            if (view.outward - outward).norm() <= ACROSS_LINE && self.is_curved(&view) {
                let there = on_second(&Vector3::from(middle.point))?.place;
                let there = second.turned_to(&there, &at.rotation.inverse_transform_vector(&-outward));
                return Some((site(&middle, pose), site(&there, at), pose.rotation * line.way()));
            }
        }
        None
    }

    fn is_curved(&self, view: &SurfaceView) -> bool {
        view.surface.curvatures.iter().any(|c| c.abs() * self.size > FLAT)
    }
}

/// A place of a body in the motion `pose` as a search finds it.
pub fn site(place: &SurfacePlace, pose: &BodyState) -> SurfaceSite {
    let point = pose.position + pose.rotation * Vector3::from(place.point);
    SurfaceSite { face: place.face, xi: place.xi, point }
}

/// The middle of a line of a body in the motion `pose`.
fn in_space(line: &StraightLine, pose: &BodyState) -> SurfaceSite {
    let point = pose.position + pose.rotation * line.points[ALONG_LINE.len() / 2];
    SurfaceSite { point, ..site(&line.middle, pose) }
}

/// The place of the surface `first` across the direction `way` from the place `here` where the part that its faces stand for is nearest to
/// `second` (a plane without one) in the direction `outward`, both in space; none if no shape of that part is known. Sides of a
/// mesh are farther from the part than this from a surface that nearly fits it.
fn nearest_across(
    ((first, pose), here): (Moved<'_>, &SurfaceSite),
    second: Option<Moved<'_>>,
    (outward, way): (&Vector3<f64>, &Vector3<f64>),
) -> Option<SurfacePlace> {
    let place = first.place(here.face, &here.xi);
    let (part, reach) = first.primitive_at(&place)?;
    let across = pose.rotation.inverse_transform_vector(&way.cross(outward)).try_normalize(0.0)?;
    let at = |share: f64| part.onto(&(Vector3::from(place.point) + share * reach * across));
    let gap = |share: f64| {
        let point = pose.position + pose.rotation * at(share);
        let Some(second) = second else { return -point.dot(outward) };
        let Some(foot) = nearest_on(second, &point) else { return f64::INFINITY };
        let there = second.1.rotation.inverse_transform_vector(&(point - second.1.position));
        match second.0.primitive_at(&foot.place) {
            Some((part, _)) => part.height(&there).0,
            None => (there - Vector3::from(foot.place.point)).dot(&foot.normal),
        }
    };
    let foot = first.nearest(&at(least_at([-1.0, 1.0], STEPS, gap)).into())?;
    Some(first.turned_to(&foot.place, &pose.rotation.inverse_transform_vector(outward)))
}

/// A line along which two bodies touch: where its middle lies on the contact body, and what that meets of the target.
#[derive(Debug, Clone, Copy)]
pub struct TouchLine {
    /// The place on the contact body.
    pub place: SurfaceSite,
    /// That on the target, with half of the line.
    pub meets: TargetPlace,
}

impl Touch {
    /// The part of the line through its places in the direction `way` of space that lies on the surfaces of contact body and target (a plane
    /// without one), inclined by the angle `parallel` \[rad\] at most; none if there is none.
    pub fn line(
        &self,
        own: Moved<'_>,
        other: Option<Moved<'_>>,
        (way, parallel): (&Vector3<f64>, f64),
    ) -> Option<TouchLine> {
        let start = self.nearest.contact.point;
        if way.dot(&self.normal).abs() > parallel {
            return None;
        }
        let other = other.map(|other| Some((other, self.nearest.target?.point)));
        // Without a place on the target there is no touch.
        let other = if let Some(there) = other { Some(there?) } else { None };
        let size = other.map_or(own.0.length(), |(there, _)| own.0.length().min(there.0.length()));
        let is_near = |moved: Moved<'_>, point: &Vector3<f64>| {
            nearest_on(moved, point).is_some_and(|foot| foot.distance <= parallel * size)
        };
        let is_on = |way: &Vector3<f64>| {
            is_near(own, &(start + way)) && other.is_none_or(|(there, point)| is_near(there, &(point + way)))
        };
        let end = |sign: f64| {
            let [mut inside, mut outside] = [0.0, sign * size];
            for _ in 0..HALVINGS {
                let middle = 0.5 * (inside + outside);
                if is_on(&(middle * way)) { inside = middle } else { outside = middle }
            }
            inside
        };
        let ends = [end(-1.0), end(1.0)].map(|share| share * way);
        let is_long = 0.5 * (ends[1] - ends[0]).norm() > SHORTEST_LINE * size;
        if is_long { self.line_between(own, other.map(|(there, _)| there), ends) } else { None }
    }

    /// The edge of the contact body, in the plane its corner, that presses a smooth part of the target (a plane without one), inclined
    /// by the angle `parallel` \[rad\] at most; none where another part of it touches, or a face beside the edge lies nearly on the target.
    pub fn own_edge(&self, own: Moved<'_>, other: Option<Moved<'_>>, parallel: f64) -> Option<TouchLine> {
        let side = Side::new(own).facing(&-self.normal);
        let point = side.place(&self.nearest.contact).point;
        let target = other.map(Side::new).zip(self.nearest.target);
        let target = target.map(|(target, there)| (target.place(&there).point, target));
        // Of an edge all along the target a search finds an end.
        let edge = match &target {
            _ if own.0.motion() != RigidMotion::Spatial => Some(EdgeOver::Straight([Vector3::zeros(); 2])),
            Some((there, target)) => {
                target.edge_over(there, &-self.normal, &side, &point, slack(&side, target, parallel))
            }
            None => {
                let slack = slack(&side, &side, parallel);
                let over = |way: &Vector3<f64>| (way.dot(&self.normal).abs() <= slack).then_some(true);
                side.edge_where(&point, (side.size(), slack), over)
            }
        };
        let Some(EdgeOver::Straight(ends)) = edge else { return None };
        let mut line = self.line_between(own, other, ends.map(|end| own.1.rotation * end))?;
        let met = |(surface, _): Moved<'_>| surface.place(line.meets.face, &line.meets.xi).point;
        let is_smooth = other.is_none_or(|other| other.0.parts_at(&met(other)).len() == 1);
        line.meets.outward = side.outward();
        (is_smooth && side.is_tip(&side.place(&line.place).point)).then_some(line)
    }

    /// The line between two `ends`, given in space from the places of this touch \[m\].
    fn line_between(
        &self,
        own: Moved<'_>,
        other: Option<Moved<'_>>,
        [from, to]: [Vector3<f64>; 2],
    ) -> Option<TouchLine> {
        let (half, aside) = (0.5 * (to - from), 0.5 * (from + to));
        let place = |moved: Moved<'_>, start: Vector3<f64>| Some(nearest_on(moved, &(start + aside))?.place);
        let of = |pose: &BodyState, x: &Vector3<f64>| pose.rotation.inverse_transform_vector(x).into();
        let mut meets = TargetPlace { normal: self.normal.into(), ..TargetPlace::default() };
        if let Some(there) = other {
            let place = place(there, self.nearest.target?.point)?;
            (meets.face, meets.xi, meets.normal) = (place.face, place.xi, of(there.1, &self.normal));
            meets.along[1] = of(there.1, &half);
        }
        meets.along[0] = of(own.1, &half);
        Some(TouchLine { place: site(&place(own, self.nearest.contact.point)?, own.1), meets })
    }
}

/// The place of a surface in its motion that is nearest to a point of space.
fn nearest_on((surface, pose): Moved<'_>, point: &Vector3<f64>) -> Option<Foot> {
    surface.nearest(&pose.rotation.inverse_transform_vector(&(point - pose.position)).into())
}
