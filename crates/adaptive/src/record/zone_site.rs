//! Where the fine model of a contact lies on a body, and how large it is.

use serde::{Deserialize, Serialize};

/// What a zone covers of the surface of its body.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum ZoneSize {
    /// A part of it about a place.
    Interval {
        /// Its widths \[m\].
        widths: [f64; 2],
        /// How many times as many elements it has in a direction as intervals of the contact have:
        /// more than one where contact moves along it.
        finer: f64,
    },
    /// The whole surface with its edges.
    Whole,
}

impl Default for ZoneSize {
    fn default() -> Self {
        Self::usual([0.0; 2])
    }
}

impl ZoneSize {
    /// An interval of these `widths` with as many elements as others of its contact \[m\].
    pub fn usual(widths: [f64; 2]) -> Self {
        Self::Interval { widths, finer: 1.0 }
    }

    /// How many times as many elements an interval has as others of its contact; 1 for a whole
    /// surface.
    pub fn finer(self) -> f64 {
        match self {
            Self::Interval { finer, .. } => finer,
            Self::Whole => 1.0,
        }
    }

    /// Widths in a result, where those of the whole surface are infinite \[m\].
    const OF_WHOLE: [f64; 2] = [f64::INFINITY; 2];

    /// Widths of an interval; none of the whole surface \[m\].
    pub fn widths(self) -> Option<[f64; 2]> {
        match self {
            Self::Interval { widths, .. } => Some(widths),
            Self::Whole => None,
        }
    }

    /// Its widths as results have them \[m\].
    pub fn in_result(self) -> [f64; 2] {
        self.widths().unwrap_or(Self::OF_WHOLE)
    }

    /// The size of the `widths` \[m\] of a result, `finer` than usual; none of widths that no zone
    /// has. Results of earlier versions have no `finer`, which is zero then.
    pub fn of_result(widths: [f64; 2], finer: f64) -> Option<Self> {
        if widths.iter().all(|w| w.is_finite() && *w > 0.0) {
            let finer = if finer.is_finite() { finer.max(1.0) } else { 1.0 };
            return Some(Self::Interval { widths, finer });
        }
        (widths == Self::OF_WHOLE).then_some(Self::Whole)
    }
}

/// Where the fine model of a contact lies on one of its bodies: all it takes to build it again.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct ZoneSite {
    /// Number of the body's face, counted through its patches.
    pub face: u32,
    /// Parameters of the interval's centre in the face's patch.
    pub centre: [f64; 3],
    /// What of the surface it covers.
    pub size: ZoneSize,
    /// The place on an edge or a corner of the target that the centre meets, or on the target that an own edge about the centre meets, if
    /// there is one (theory Eqs. C.63, C.98).
    pub meets: Option<TargetPlace>,
    /// The part of a whole surface to which the zone is confined, if it is; of an interval the flat face of the
    /// target about which it lies.
    pub part: Option<TouchedPart>,
    /// Further places about which it lies where the bodies touch at several at once: faces and parameters as of
    /// the first one (theory section A.12).
    pub others: [Option<(u32, [f64; 3])>; MOST_TOUCHES - 1],
    /// Direction of the first width, a unit vector in the components of the model, on a surface that has no directions of its own
    /// and is touched along a line; zero of others.
    pub across: [f64; 3],
}

/// Touches of one pair of bodies at once for which zones are laid at most.
pub const MOST_TOUCHES: usize = 8;

/// The part of a surface with edges that may press at a touch: about its place, as far down and
/// aside as given (theory Eq. C.91).
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct TouchedPart {
    /// The place, in the components of the model \[m\].
    pub origin: [f64; 3],
    /// Unit vector towards the partner.
    pub outward: [f64; 3],
    /// How far from the plane of the touch, which is across it, the part goes on \[m\].
    pub depth: f64,
    /// How far in this plane \[m\].
    pub radius: f64,
}

/// A place on an edge or a corner of a target, or of a target that an edge of the contact body presses, with the normal of the contact
/// there.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct TargetPlace {
    /// Number of the target's face, counted through its patches.
    pub face: u32,
    /// Parameters in the face's patch.
    pub xi: [f64; 3],
    /// Unit normal towards the contact body, in the target's frame.
    pub normal: [f64; 3],
    /// Half of the straight edge that lies along a face of the contact body and has this place in its
    /// middle, in the frames of the contact body and of the target (theory Eq. C.97); zero of a place
    /// alone \[m\].
    pub along: [[f64; 3]; 2],
    /// Half of the width over which a face is pressed along that edge or, in the plane, by a corner (theory Eq. C.98) \[m\].
    pub spread: f64,
    /// Unit vector out of a body whose own edge, in the plane its corner, presses here, in the components of its model; zero where that is
    /// one of its partner.
    pub outward: [f64; 3],
}

impl TargetPlace {
    /// The direction `outward` of an edge of the body itself; none of one of its partner.
    pub fn own_outward(&self) -> Option<[f64; 3]> {
        self.outward.iter().any(|x| x.abs() > 0.0).then_some(self.outward)
    }
}

impl ZoneSite {
    /// The whole surface of a body, about no place on it.
    pub const WHOLE: Self = Self {
        face: 0,
        centre: [0.0; 3],
        size: ZoneSize::Whole,
        meets: None,
        part: None,
        others: [None; MOST_TOUCHES - 1],
        across: [0.0; 3],
    };

    /// A zone of the size `size` about the parameters `centre` of face `face`.
    pub fn about((face, centre): (u32, [f64; 3]), size: ZoneSize) -> Self {
        Self { face, centre, size, ..Self::WHOLE }
    }

    /// The places about which it lies, the first one first.
    pub fn places(&self) -> impl Iterator<Item = (u32, [f64; 3])> {
        std::iter::once((self.face, self.centre)).chain(self.others.into_iter().flatten())
    }

    /// The flat face of the target about which an interval lies, whose edges press as well; none of other zones.
    pub fn flat_face(&self) -> Option<TouchedPart> {
        self.part.filter(|_| self.size != ZoneSize::Whole)
    }

    /// The place about which a whole surface has additional contact points, or a point that meets
    /// an edge or a corner of the target: number of the face and parameters. None for the first
    /// corner of a patch, where a point stands anyhow.
    pub fn place(&self) -> Option<(u32, [f64; 3])> {
        let is_place = self.meets.is_some() || self.centre.iter().any(|u| u.abs() > 0.0);
        (self.size == ZoneSize::Whole && is_place).then_some((self.face, self.centre))
    }
}
