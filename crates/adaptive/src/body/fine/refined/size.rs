//! Memory that a fine model would take, estimated before anything of it is built.

use ffr_dynamics::memory;
use iga_core::hierarchical::SubdomainHierarchy;
use iga_core::nurbs::Patch;

use super::measures::speeds;
use super::plan::faces;
use super::{RefinementPlan, WantedInterval};
use crate::adaptivity::subdivision::SubdivisionError;

/// Memory of one fine model at most \[GB\]: what a large workstation has to give for one of two
/// bodies of one contact.
const MOST_GIGABYTES: f64 = 16.0;
/// Dense matrices of the size of the compliance that live at the same time: flexibility,
/// compliance, the contact's own.
const DENSE: f64 = 3.0;
/// Entries of the factor over `N^(4/3)` of `N` unknowns of a solid, and over `N log2 N` of a body
/// of two directions (George 1973: nested dissection). The constants are orders of magnitude and
/// not measured: they tell gigabytes from hundreds of them.
const FILL: [f64; 2] = [60.0, 30.0];

/// Memory of one fine model at most, less if the process may not take as much \[GB\].
pub fn most_gigabytes() -> f64 {
    memory::most().map_or(MOST_GIGABYTES, |limit| MOST_GIGABYTES.min(1e-9 * limit as f64))
}

/// Memory that a fine model in so many directions takes \[GB\].
pub fn gigabytes(dimension: usize, unknowns: f64, interface: f64) -> f64 {
    let fill = match dimension {
        3 => FILL[0] * unknowns.powf(4.0 / 3.0),
        _ => FILL[1] * unknowns * unknowns.log2(),
    };
    8e-9 * (DENSE * interface * interface + fill)
}

/// Refuses the `plan` of a fine model that no memory holds.
///
/// Every function is counted as one per element, which holds but for the degree. Takes time in
/// proportion to the number of levels.
///
/// # Errors
/// [`SubdivisionError::TooLarge`] with the sizes in metres.
pub(super) fn check_size(
    patches: &[Patch],
    hierarchies: &[SubdomainHierarchy],
    wanted: &[WantedInterval],
    plan: &RefinementPlan,
) -> Result<(), SubdivisionError> {
    let dimension = patches[0].dimension();
    let n = dimension as f64;
    let unknowns = n * hierarchies.iter().map(SubdomainHierarchy::n_leaves).sum::<usize>() as f64;
    let (mut interface, mut finest) = (0.0, (f64::INFINITY, 1, 0.0));
    for (part, bounds) in faces(wanted, plan) {
        let WantedInterval { face, widths, .. } = &part;
        let levels = hierarchies[face.id.patch].levels();
        let knots = levels[levels.len() - 1].knots();
        let mut functions = 1.0;
        for ((d, width), speed) in face.directions().zip(widths).zip(speeds(&patches[face.id.patch], &part)) {
            let first = knots[d].find_element(bounds.lower[d]);
            let across = (knots[d].find_element(bounds.upper[d]) - first).max(1);
            functions *= (across + knots[d].degree()) as f64;
            let element = (bounds.upper[d] - bounds.lower[d]) * speed / across as f64;
            if element < finest.0 {
                finest = (element, across, *width);
            }
        }
        interface += n * functions;
    }
    let gigabytes = gigabytes(dimension, unknowns, interface);
    let most = most_gigabytes();
    if gigabytes <= most {
        return Ok(());
    }
    let (element, across, width) = finest;
    Err(SubdivisionError::TooLarge { width, across, element, unknowns, interface, gigabytes, most })
}
