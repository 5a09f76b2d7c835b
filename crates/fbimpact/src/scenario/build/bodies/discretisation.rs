//! Discretisation and reduction of flexible bodies.

use adaptive::sizing::mode_count::WITHOUT_FORCES;
use adaptive::spec::{DiscretisationSpec, ReductionSpec, RefinementSpec};
use iga_core::nurbs::Shape;

use crate::scenario::body_places::BodyPlaces;
use crate::scenario::build::places::{BodyFacts, marker_or_point, single};
use crate::scenario::files::spline_nets::per_direction;
use crate::scenario::section::Section;
use crate::scenario::tables::ReductionMethod;

/// Elements per direction in the specification of a body for which the program still has to choose
/// them.
const FIRST_ELEMENTS: usize = 8;

/// A reduced basis, and what the scenario leaves open of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Basis {
    /// The basis, with some number of modes where the program chooses it.
    pub spec: ReductionSpec,
    /// Whether it has the static answers to joints and loads; to all modes they add nothing.
    pub static_answers: bool,
    /// Whether the program shall choose the number of modes.
    pub wants_modes: bool,
}

/// The spline space of a body with the places `places`, and whether the program shall choose its
/// elements.
pub fn discretisation(
    section: &Section,
    body: &BodyFacts<'_>,
    places: Option<&BodyPlaces>,
) -> Option<(DiscretisationSpec, bool)> {
    let directions = body.components.dimension();
    let degree = per_direction(section, "degree", directions);
    let elements = per_direction(section, "elements", directions);
    if elements.is_none() && section.item("elements").is_some() {
        return None;
    }
    let given_knots = section.item("knots").is_some();
    let knots = if given_knots { Some(knots(section, directions, degree.as_deref())?) } else { None };
    let list = section.tables("refine");
    let refine: Vec<RefinementSpec> = list.iter().filter_map(|r| refinement(r, body, places)).collect();
    if refine.len() != list.len() {
        return None;
    }
    let is_open = elements.is_none() && knots.is_none();
    let (shape, _) = places?.shape()?;
    for key in ["knots", "refine"] {
        if shape.patches.len() > 1 && section.given(key) {
            return section.refuse(key, "is for shapes of one patch, give several more \"elements\"");
        }
    }
    // Elements are those of a patch as it was given.
    let of_parts = |n: Vec<usize>| n.iter().zip(shape.parts).map(|(n, parts)| n.div_ceil(parts)).collect();
    let spec = DiscretisationSpec {
        degrees: raised(&degree?, shape),
        elements: elements.map_or_else(|| vec![FIRST_ELEMENTS; directions], of_parts),
        knots,
        refine,
    };
    Some((spec, is_open))
}

/// The wanted degrees, raised to those of the exact geometry where they are lower.
fn raised(degrees: &[usize], shape: &Shape) -> Vec<usize> {
    let own = |d: usize| shape.patches.iter().map(|p| p.knots()[d].degree()).max().unwrap_or(1);
    degrees.iter().enumerate().map(|(d, &p)| p.max(own(d))).collect()
}

fn knots(section: &Section, directions: usize, degree: Option<&[usize]>) -> Option<Vec<Vec<f64>>> {
    let lists = section.lists("knots")?;
    if lists.len() != directions {
        let message = format!("{} lists, the model has {directions} directions", lists.len());
        return section.refuse("knots", message);
    }
    for (i, list) in lists.iter().enumerate() {
        if let Some(pair) = list.windows(2).find(|w| w[0] > w[1]) {
            let message = format!("knots of direction {i} fall from {} to {}", pair[0], pair[1]);
            return section.refuse("knots", message);
        }
        let p = degree?[i];
        let same = |w: &&[f64]| w[0].total_cmp(&w[p]).is_eq();
        if let Some(run) = list.windows(p + 1).find(same) {
            let message = format!("knot {} of direction {i} stands more than {p} times, its degree", run[0]);
            return section.refuse("knots", message);
        }
    }
    Some(lists.to_vec())
}

fn refinement(
    section: &Section,
    body: &BodyFacts<'_>,
    places: Option<&BodyPlaces>,
) -> Option<RefinementSpec> {
    let key = if section.item("point").is_some() { "point" } else { "marker" };
    let at = marker_or_point(section, body).and_then(|_| single(section, key, body));
    let centre = places?.inside(&at?).map_err(|e| section.fault(key, e.to_string())).ok()?;
    Some(RefinementSpec {
        centre,
        width: section.number("width")?,
        elements: section.integer("elements")?,
        ratio: section.number("ratio")?,
    })
}

/// The reduced basis of a body.
pub fn reduction(section: &Section) -> Option<Basis> {
    let method: ReductionMethod = section.choice("method")?;
    if method == ReductionMethod::All {
        return Some(Basis { spec: ReductionSpec::All, static_answers: false, wants_modes: false });
    }
    let given = section.optional("modes", Section::integer).ok()?;
    let (modes, wants_modes) = (given.unwrap_or(WITHOUT_FORCES), given.is_none());
    let static_answers = section.boolean("static_answers")?;
    if method == ReductionMethod::Modal {
        return Some(Basis { spec: ReductionSpec::Modal { modes }, static_answers, wants_modes });
    }
    let fixed_interface_modes = section.optional("fixed_interface_modes", Section::integer).ok()?;
    if let (Some(modes), Some(fixed)) = (given, fixed_interface_modes)
        && fixed < modes
    {
        let message = format!("must be at least \"modes\", which is {modes}");
        section.fault("fixed_interface_modes", message);
    }
    let spec = ReductionSpec::CraigBampton { modes, fixed_interface_modes };
    Some(Basis { spec, static_answers, wants_modes })
}
