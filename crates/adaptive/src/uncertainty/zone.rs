//! What points and elements across a contact leave of its force (docs/theory/uncertainty.md Eqs. U.5, U.6).

use crate::spec::ContactLaw;
use crate::touch::parts::TouchKind;

/// How the yield at a touch is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ZoneEstimate {
    /// From the number of points across that carry the peak.
    Points,
    /// By a law that is taken as it stands: what it leaves out belongs to the model.
    Law,
    /// Not at all.
    Unknown,
}

impl ZoneEstimate {
    /// Of a contact by `law`.
    pub fn of(law: &ContactLaw) -> Self {
        match law.surface() {
            None => Self::Law,
            Some(surface) if surface.treatment.has_fine_zone() => Self::Points,
            Some(_) => Self::Unknown,
        }
    }
}

/// Relative errors of a contact zone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ZoneError {
    /// Of the approach at a force, as a whole.
    pub approach: f64,
    /// Of the force at an approach, as the points at the rim come and go one by one; it is gone from the
    /// mean.
    pub force: f64,
    /// Whether peak force and duration follow the elements without a limit.
    pub has_no_limit: bool,
}

/// Constants of the square of the number of points across (Eq. U.5), found with interval.elements from 8 to
/// 64 in axisymmetric balls on planes and rods and in discs; not measured in three dimensions.
const APPROACH: f64 = 0.04;
const FORCE: f64 = 0.25;
/// Constant of the inverse of the number of points across a flat face narrower than the elements: axisymmetric and plane ones have 0.1 to 0.2,
/// a disc over a square lattice, on which the number of points under it goes up and down, up to 0.4.
const UNDER_FACE: f64 = 0.4;
/// Share of the approach by which points along a line miss it: peaks of rollers on blocks and bars were off by 0.3 to 1.4 %, that of a
/// cylinder with elements of seven tenths of its radius by 2.8 %, which is twice as much of the approach.
const ON_LINE: f64 = 0.06;
/// Share of the yield below an edge or a corner that elements half as long change.
const BELOW_EDGES: f64 = 0.5;

/// The errors of a zone of `across` points in each direction under the peak, where surfaces touch as said;
/// none where it is not known.
pub fn error(estimate: ZoneEstimate, touch: TouchKind, across: f64) -> Option<ZoneError> {
    let by_points = |constant: f64| (constant / (across * across)).min(1.0);
    let of_points = ZoneError { approach: by_points(APPROACH), force: by_points(FORCE), has_no_limit: false };
    match estimate {
        ZoneEstimate::Unknown => None,
        ZoneEstimate::Law => Some(ZoneError { approach: 0.0, force: 0.0, has_no_limit: false }),
        ZoneEstimate::Points => Some(match touch {
            TouchKind::Smooth | TouchKind::Line => of_points,
            TouchKind::Narrow => {
                ZoneError { approach: (UNDER_FACE / across).min(1.0), force: 0.0, has_no_limit: false }
            }
            // All points of a face press from the beginning.
            TouchKind::Flat => ZoneError { force: 0.0, ..of_points },
            TouchKind::LineOfPoints => ZoneError { approach: ON_LINE, force: 0.0, has_no_limit: false },
            TouchKind::Edge | TouchKind::BetweenPoints => {
                ZoneError { approach: BELOW_EDGES, force: 0.0, has_no_limit: true }
            }
        }),
    }
}
