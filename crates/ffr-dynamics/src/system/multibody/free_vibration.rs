//! Bodies whose elastic coordinates vibrate by themselves, each for itself (docs/theory.md
//! Eq. T.9).
//!
//! In a Buckens frame modes move no momentum, so that the frame's motion and the coordinates do not
//! know of each other but for gyroscopic terms. A joint on a marker that the deformation moves
//! couples them.

use crate::body::{ModalDamping, ModalMass, StandardInputData};
use crate::integration::Oscillator;
use crate::kinematics::Marker;
use crate::system::model::{MultibodyModel, TreeBody};

/// Coupling of a mode with the frame's motion, as a share of the root of its mass that moves along,
/// below which it is round-off: its square is what the mode's inertia lacks.
const COUPLING: f64 = 1e-6;

/// Elastic coordinates of `model` that vibrate for themselves.
pub(super) fn oscillators(model: &MultibodyModel) -> Vec<Oscillator> {
    let bodies = model
        .bodies
        .iter()
        .enumerate()
        .filter(|(i, body)| body.data.n_modes() > 0 && vibrates_alone(model, *i));
    bodies.flat_map(|(_, body)| of_body(body)).collect()
}

/// Whether the elastic coordinates of body `i` know nothing of other motions.
pub(in crate::system) fn vibrates_alone(model: &MultibodyModel, i: usize) -> bool {
    is_uncoupled(&model.bodies[i].data) && joined_markers(model, i).all(Marker::is_still)
}

/// Markers of body `i` that joints hold.
fn joined_markers(model: &MultibodyModel, i: usize) -> impl Iterator<Item = &Marker> {
    let children = model.children[i].iter().map(|&child| &model.bodies[child].joint.parent);
    let ends = model.loops.iter().flat_map(|joint| [&joint.parent, &joint.child]);
    let sites = children.chain(ends.filter(move |site| site.body == Some(i)));
    sites.map(|site| &site.marker).chain([&model.bodies[i].joint.child])
}

/// Whether the modes are orthonormal and know nothing of the frame's motion (D.5).
fn is_uncoupled(data: &StandardInputData) -> bool {
    let (root_mass, root_inertia) = (data.mass.sqrt(), data.inertia().trace().sqrt());
    data.modal_mass == ModalMass::Identity
        && (0..data.n_modes()).all(|j| {
            data.coupling_translation[j].norm() <= COUPLING * root_mass
                && data.coupling_rotation_at_rest(j).norm() <= COUPLING * root_inertia
        })
}

fn of_body(body: &TreeBody) -> Vec<Oscillator> {
    let TreeBody { data, layout, .. } = body;
    let oscillator = |j: usize| {
        let damping = match &data.modal_damping {
            ModalDamping::None => 0.0,
            ModalDamping::PerMode(coefficients) => coefficients[j],
            ModalDamping::Full(_) => return None,
        };
        let oscillator = Oscillator {
            position: layout.elastic().start + j,
            velocity: layout.elastic_rates().start + j,
            squared_frequency: data.modal_stiffness[j],
            damping,
        };
        oscillator.vibrates().then_some(oscillator)
    };
    (0..data.n_modes()).filter_map(oscillator).collect()
}
