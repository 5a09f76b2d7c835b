//! Which parts of two bodies touch, at given motions: smooth faces, a line of them, flat faces,
//! edges (docs/theory.md Eqs. C.60, C.61).

pub(crate) mod side;
mod line;
mod narrow;
mod shapes;

use contact_qs::search::SurfaceSite;
use nalgebra::Vector3;

use crate::record::TouchedPart;
use crate::surface::SurfacePlace;
use crate::touch::detection::Nearest;
pub use line::TouchLine;
use line::{middle_of_line, site};
use narrow::narrow_face;
use shapes::nearest_of_shapes;
use side::{EdgeOver, Moved, Side, slack, touch_direction};

/// Which parts of two surfaces touch first: smooth faces, flat faces, edges or lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TouchKind {
    /// Smooth parts of both surfaces, as Hertz's theory has it.
    Smooth,
    /// Smooth parts along a whole straight line of a curved face, such as that of a cylinder that
    /// lies on a plane.
    Line,
    /// The same of a mesh whose elements are not divided for it, by points along the line.
    LineOfPoints,
    /// Plane faces that lie on each other.
    Flat,
    /// The same, that of the target narrower than the elements under it.
    Narrow,
    /// An edge, a rim or a corner of one of the bodies or of both.
    Edge,
    /// A curved edge of the target that lies along a face of the contact body, where no contact points
    /// stand but perhaps at its ends.
    BetweenPoints,
}

/// What a contact has as its zone where two bodies touch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TouchZone {
    /// An interval of its surfaces about the nearest places.
    Interval,
    /// The whole surfaces.
    Whole,
    /// None: no contact points stand there.
    Unseen,
}

/// The reason for which Hertz's law does not hold where a relative curvature is zero or negative.
pub const NO_ELLIPSE: &str = "surfaces touch along a line or lie in each other";

// Every property of a touch is a match over all kinds.
impl TouchKind {
    /// What a contact whose zone nobody has given has as its zone.
    pub fn zone(self) -> TouchZone {
        match self {
            Self::Smooth | Self::Line | Self::Narrow => TouchZone::Interval,
            Self::Flat | Self::Edge | Self::LineOfPoints => TouchZone::Whole,
            Self::BetweenPoints => TouchZone::Unseen,
        }
    }

    /// Whether zones that are whole surfaces have contact points of their own about the nearest
    /// places, beside those of the elements.
    pub fn adds_points(self) -> bool {
        match self {
            Self::Edge | Self::LineOfPoints => true,
            Self::Smooth | Self::Line | Self::Flat | Self::Narrow | Self::BetweenPoints => false,
        }
    }

    /// Whether the force jumps as soon as the bodies touch: under a narrow face it rises as the zone about
    /// it yields.
    pub fn is_jump(self) -> bool {
        match self {
            Self::Flat => true,
            Self::Smooth
            | Self::Line
            | Self::LineOfPoints
            | Self::Narrow
            | Self::Edge
            | Self::BetweenPoints => false,
        }
    }

    /// Whether the pressure has a limit when elements shrink; under edges, rims and corners it has
    /// none.
    pub fn bounds_pressure(self) -> bool {
        match self {
            Self::Smooth | Self::Line | Self::Flat | Self::Narrow => true,
            Self::Edge | Self::LineOfPoints | Self::BetweenPoints => false,
        }
    }

    /// The parts that touch, in words that follow "touch with".
    pub fn parts(self) -> &'static str {
        match self {
            Self::Smooth | Self::Line | Self::LineOfPoints => "smooth faces",
            Self::Flat | Self::Narrow => "flat faces",
            Self::Edge | Self::BetweenPoints => "an edge or a corner",
        }
    }

    /// Why Hertz's law of points does not hold; none of smooth faces, whose curvatures decide.
    pub fn no_hertz_point(self) -> Option<&'static str> {
        match self {
            Self::Smooth => None,
            Self::Line | Self::LineOfPoints => Some(NO_ELLIPSE),
            Self::Flat | Self::Narrow => Some("flat faces touch"),
            Self::Edge | Self::BetweenPoints => Some("an edge, a rim or a corner touches"),
        }
    }
}

/// How two bodies touch.
#[derive(Debug, Clone, Copy)]
pub struct Touch {
    /// The places that touch: the nearest ones or, of a whole straight line or edge of them, those at
    /// its middle.
    pub nearest: Nearest,
    /// What touches there.
    pub kind: TouchKind,
    /// Unit normal of the touch in space, from the target to the contact body (Eq. C.62).
    pub normal: Vector3<f64>,
    /// Extents of what touches of a narrow face, along the face of the contact body \[m\].
    pub extents: [f64; 2],
    /// The line, if points along it hold a touch of smooth faces.
    pub line: Option<TouchLine>,
}

impl Touch {
    /// The touch of a contact body and a target, surfaces with their motions (a plane without the
    /// latter), that are nearest at the places `nearest`. Faces and lines that are inclined by no
    /// more than the angle `parallel` \[rad\] lie on each other as a whole.
    pub fn at(own: Moved<'_>, other: Option<Moved<'_>>, nearest: &Nearest, parallel: f64) -> Self {
        let middle = middle_of_line(own, other, nearest, parallel);
        let touch = Self::at_places(own, other, &middle.unwrap_or(*nearest), parallel);
        match (touch.kind, middle) {
            (TouchKind::Smooth, Some(_)) => Self { kind: TouchKind::Line, ..touch },
            (TouchKind::Smooth, None) => {
                let of_shapes = nearest_of_shapes(own, other, nearest, &touch.normal);
                of_shapes.map_or(touch, |nearest| Self { nearest, ..touch })
            }
            _ => touch,
        }
    }

    /// The same at the places `nearest` themselves, even if they belong to a line.
    pub fn at_places(own: Moved<'_>, other: Option<Moved<'_>>, nearest: &Nearest, parallel: f64) -> Self {
        let (side, target) = (Side::new(own), other.map(Side::new));
        let normal = touch_direction(&side, target.as_ref(), nearest);
        let (side, target) = (side.facing(&-normal), target.map(|side| side.facing(&normal)));
        let kind = kind_at(&side, target.as_ref(), nearest, parallel);
        let mut touch = Self { nearest: *nearest, kind, normal, extents: [0.0; 2], line: None };
        if let (TouchKind::Edge, Some(target), Some(other), Some(there)) =
            (kind, &target, other, &nearest.target)
        {
            touch.take_edge((&side, own), (target, other), there, slack(&side, target, parallel));
        }
        touch
    }

    /// This touch of flat faces about the middle of what touches, if the target's face is narrower in a
    /// direction than `least` says of the place; else the touch as it is (Eq. C.102).
    #[must_use]
    pub fn narrower_than(
        self,
        own: Moved<'_>,
        other: Option<Moved<'_>>,
        parallel: f64,
        least: impl FnOnce(&SurfacePlace) -> Option<[f64; 2]>,
    ) -> Self {
        let is_flat = self.kind == TouchKind::Flat;
        let narrow =
            other.filter(|_| is_flat).and_then(|other| narrow_face(own, other, &self, parallel, least));
        narrow.map_or(self, |(nearest, extents)| Self { nearest, kind: TouchKind::Narrow, extents, ..self })
    }

    /// Takes the middle of an edge of the target that lies along a face of the contact body, no farther
    /// from it than `slack` \[m\], as the place of the touch (Eq. C.97).
    fn take_edge(
        &mut self,
        (side, own): (&Side<'_>, Moved<'_>),
        (target, other): (&Side<'_>, Moved<'_>),
        there: &SurfaceSite,
        slack: f64,
    ) {
        let places = [side.place(&self.nearest.contact).point, target.place(there).point];
        match side.edge_over(&places[0], &self.normal, target, &places[1], slack) {
            Some(EdgeOver::Straight([from, to])) => {
                let way = other.1.rotation * (0.5 * (from + to));
                let moved = |(surface, pose): Moved<'_>, point: [f64; 3]| {
                    let place = Vector3::from(point) + pose.rotation.inverse_transform_vector(&way);
                    Some(site(&surface.nearest(&place.into())?.place, pose))
                };
                if let (Some(contact), there @ Some(_)) = (moved(own, places[0]), moved(other, places[1])) {
                    self.nearest = Nearest { contact, target: there, ..self.nearest };
                }
            }
            Some(EdgeOver::Bent) => self.kind = TouchKind::BetweenPoints,
            None => {}
        }
    }
}

/// The parts of the surfaces of contact body and target that may press where their places `at` touch
/// with the normal `normal`, from the target to the contact body: what lies within `depth` \[m\] of
/// the plane of the touch, no farther aside than both do (Eq. C.91). None of a plane, and of a
/// surface that is a zone as a whole.
pub fn pressed_parts(
    moved: [Option<Moved<'_>>; 2],
    at: [Option<[f64; 3]>; 2],
    normal: &Vector3<f64>,
    depth: f64,
) -> [Option<TouchedPart>; 2] {
    let mut parts = [None; 2];
    for ((part, (moved, origin)), outward) in
        parts.iter_mut().zip(moved.into_iter().zip(at)).zip([-normal, *normal])
    {
        *part =
            moved.zip(origin).map(|(moved, origin)| Side::new(moved).facing(&outward).part(origin, depth));
    }
    let spreads = [0, 1].map(|b| Some(moved[b]?.0.spread(parts[b].as_ref()?)));
    let spread = spreads.into_iter().flatten().fold(f64::INFINITY, f64::min);
    [0, 1].map(|b| {
        spreads[b].filter(|spread| spread.is_finite())?;
        Some(TouchedPart { radius: (spread + depth).min(moved[b]?.0.length()), ..parts[b]? })
    })
}

/// The kind of touch at the places `nearest` of the sides `own` of a contact body and `target` of
/// its target, none of a plane. Flat faces meet as a whole if they are inclined by no more than the
/// angle `parallel` \[rad\].
fn kind_at(own: &Side<'_>, target: Option<&Side<'_>>, nearest: &Nearest, parallel: f64) -> TouchKind {
    let own_point = own.place(&nearest.contact).point;
    let target_point = target.zip(nearest.target).map(|(side, site)| side.place(&site).point);
    let both = || std::iter::once((own, own_point)).chain(target.zip(target_point));
    if both().all(|(side, point)| side.is_flat(&point, parallel)) {
        TouchKind::Flat
    } else if both().all(|(side, point)| side.is_smooth(&point)) {
        TouchKind::Smooth
    } else {
        TouchKind::Edge
    }
}
