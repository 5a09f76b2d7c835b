//! Friction of a plane contact: tangents, slips, history of every point.
//!
//! The slip of a point is measured from its stick reference (docs/theory.md Eq. F.2). Within a step
//! the references stay, so that forces are functions of time and state alone; those found at the
//! last evaluation become the references when the integrator saves the state before its next step
//! (docs/decisions/0005-friction.md).

use ffr_dynamics::body::RigidMotion;
use nalgebra::{UnitQuaternion, Vector3};

use crate::law::Friction;
use crate::quasistatic::PointState;
use crate::quasistatic::problem::dot;
use crate::quasistatic::stick_slip::StickSlip;

/// Friction of one plane contact.
pub(super) struct PlaneFriction {
    pub stick_slip: StickSlip,
    pub n_t: usize,
    motion: RigidMotion,
    /// Tangents in the inertial frame; zero for rings, whose tangent is radial.
    pub world: [Vector3<f64>; 2],
    /// Tangents of the last evaluation in the model's components.
    pub tangents: [[f64; 3]; 2],
    /// Tangential coordinates of the points without quasistatic displacement \[m\].
    pub coordinates: Vec<f64>,
    /// Their distances from the references \[m\].
    pub slips: Vec<f64>,
    references: Vec<f64>,
    candidates: Vec<f64>,
    has_references: bool,
    has_candidates: bool,
}

impl PlaneFriction {
    pub fn new(
        law: Friction,
        motion: RigidMotion,
        n_points: usize,
        normal: &Vector3<f64>,
        has_compliance: bool,
    ) -> Self {
        let nc = motion.n_components();
        let n_t = nc - 1;
        let n = n_t * n_points;
        Self {
            stick_slip: StickSlip::new(law, n_points, n_t, has_compliance),
            n_t,
            motion,
            world: world_tangents(motion, normal),
            tangents: [[0.0; 3]; 2],
            coordinates: vec![0.0; n],
            slips: vec![0.0; n],
            references: vec![0.0; n],
            candidates: vec![0.0; n],
            has_references: false,
            has_candidates: false,
        }
    }

    /// Turns the tangents into the model's components.
    pub fn turn(&mut self, rotation: &UnitQuaternion<f64>) {
        for (tangent, world) in self.tangents.iter_mut().zip(&self.world) {
            *tangent = match self.motion {
                RigidMotion::Axial => [1.0, 0.0, 0.0],
                _ => rotation.inverse_transform_vector(world).into(),
            };
        }
    }

    /// Slips at the coordinates just found. The first evaluation of all sets the references.
    pub fn measure(&mut self) {
        if !self.has_references {
            self.references.copy_from_slice(&self.coordinates);
            self.has_references = true;
        }
        for ((slip, x), reference) in self.slips.iter_mut().zip(&self.coordinates).zip(&self.references) {
            *slip = x - reference;
        }
    }

    /// Notes the references that the last solution would leave: those of sticking points stay,
    /// others move by the slip increment (Eq. F.8).
    pub fn note(&mut self) {
        let (states, increments) = (self.stick_slip.states(), self.stick_slip.increments());
        for (k, candidate) in self.candidates.iter_mut().enumerate() {
            let is_held = states[k / self.n_t] == PointState::Stick;
            *candidate = self.references[k] + if is_held { 0.0 } else { increments[k] };
        }
        self.has_candidates = true;
    }

    /// Has the references of open points follow them, which are displaced by `displacements`.
    pub fn follow_open(&mut self, displacements: &[f64]) {
        let (n_t, nc) = (self.n_t, self.motion.n_components());
        let Self { stick_slip, slips, tangents, .. } = self;
        stick_slip.set_open_increments(|i, a| {
            slips[n_t * i + a] + dot(&displacements[nc * i..nc * (i + 1)], &tangents[a])
        });
    }

    pub fn save(&mut self) {
        if self.has_candidates {
            std::mem::swap(&mut self.references, &mut self.candidates);
            self.has_candidates = false;
        }
        self.stick_slip.save();
    }

    pub fn restore(&mut self) {
        self.has_candidates = false;
        self.stick_slip.restore();
    }

    /// Number of sliding points.
    pub fn n_sliding(&self) -> usize {
        self.stick_slip.states().iter().filter(|s| **s == PointState::Slip).count()
    }

    /// Friction forces of the points in the inertial frame, of rings along their radius as the first component \[N\].
    pub fn vectors(&self) -> Vec<Vector3<f64>> {
        let directions = self.directions();
        let forces = self.stick_slip.forces().chunks_exact(self.n_t);
        forces.map(|point| point.iter().zip(&directions).map(|(f, t)| t * *f).sum()).collect()
    }

    /// The friction forces are those `wanted` from now on; none: the references move so that they stay as they are (Eq. A.41).
    pub fn prescribe(&mut self, wanted: Option<&[Vector3<f64>]>) {
        let directions = self.directions();
        let components = |wanted: &[Vector3<f64>]| {
            wanted.iter().flat_map(|w| directions[..self.n_t].iter().map(|t| t.dot(w))).collect()
        };
        let is_over = wanted.is_none();
        let shifts = self.stick_slip.prescribe(wanted.map(components));
        if is_over {
            self.references.iter_mut().zip(shifts).for_each(|(reference, shift)| *reference -= shift);
            self.has_candidates = false;
        }
    }

    fn directions(&self) -> [Vector3<f64>; 2] {
        if self.motion == RigidMotion::Axial { [Vector3::x(), Vector3::zeros()] } else { self.world }
    }

    /// Sum of the tangential forces `forces` in the inertial frame \[N\].
    pub fn resultant(&self, forces: &[f64]) -> Vector3<f64> {
        forces.chunks_exact(self.n_t).fold(Vector3::zeros(), |sum, point| {
            point.iter().zip(&self.world).fold(sum, |sum, (f, t)| sum + t * *f)
        })
    }
}

/// Tangents of the plane with normal `normal`, in the inertial frame.
fn world_tangents(motion: RigidMotion, normal: &Vector3<f64>) -> [Vector3<f64>; 2] {
    match motion {
        RigidMotion::Axial => [Vector3::zeros(); 2],
        RigidMotion::Planar => [Vector3::z().cross(normal).normalize(), Vector3::zeros()],
        RigidMotion::Spatial => {
            // The axis farthest from the normal.
            let axis = Vector3::ith(normal.iamin(), 1.0);
            let first = normal.cross(&axis).normalize();
            [first, normal.cross(&first)]
        }
    }
}
