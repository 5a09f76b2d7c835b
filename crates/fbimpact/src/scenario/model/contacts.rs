//! Contacts.

use adaptive::spec::DivisionRule;
use adaptive::spec::HandOver;
use contact_qs::law::Friction;

/// A contact between two bodies.
#[derive(Debug, Clone, PartialEq)]
pub struct Contact {
    /// Name in the scenario.
    pub name: String,
    /// Index of the body that carries the contact points.
    pub contact_body: usize,
    /// Index of the body whose surface they meet.
    pub target_body: usize,
    /// How the two resist each other.
    pub law: ContactLaw,
    /// Overlap of the bodies at the start that is allowed \[m\].
    pub initial_overlap: f64,
}

/// How contact is resisted.
#[derive(Debug, Clone, PartialEq)]
pub enum ContactLaw {
    /// Points on a flexible body's surface against a plane or the surface of another flexible body.
    Surface(SurfaceContact),
    /// Hertz's law between two spheres or a sphere and a plane.
    Hertz,
}

/// Settings of contact points on a surface.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceContact {
    /// Contact model.
    pub model: ContactModel,
    /// How penetration is resisted.
    pub constraint: Constraint,
    /// Where the contact points are.
    pub points: ContactPoints,
    /// Solver of the quasistatic state.
    pub solver: ContactSolver,
    /// Friction; `None`: frictionless.
    pub friction: Option<Friction>,
    /// Contact interval.
    pub interval: Interval,
    /// Modes of fine models, and how states come to them.
    pub hand_over: HandOver,
}

/// Contact models.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ContactModel {
    /// Refined by the program; high-frequency modes follow statically.
    Adaptive,
    /// High-frequency modes follow statically.
    Quasistatic,
    /// Every mode is dynamic, high-frequency ones damped critically.
    Damped,
    /// Every mode is dynamic.
    Dynamic,
    /// The modes of the free body alone.
    Coarse,
}

/// How penetration is resisted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Constraint {
    /// Pressure proportional to penetration.
    Penalty {
        /// Pressure per penetration [N/m³]; `None`: predicted from the compliance.
        value: Option<f64>,
        /// How it is adapted.
        search: PenaltySearch,
    },
    /// No penetration.
    Exact,
}

/// How a penalty factor is adapted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PenaltySearch {
    /// Not at all.
    Fixed,
    /// Raised until the peak force changes by less than this share.
    UntilConverged {
        /// Relative change.
        tolerance: f64,
    },
    /// Raised until the solver fails, then lowered.
    UntilError,
}

/// Contact points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ContactPoints {
    /// Greville abscissae of the surface.
    Greville,
    /// Gauss points of the surface elements.
    Gauss,
}

/// Solvers of the quasistatic state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ContactSolver {
    /// Primal active-set method.
    ActiveSet,
    /// \[A\] Algorithm 1.
    Broyden,
}

/// The part of the contact body's surface that carries contact points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Width along the surface about the point of first contact \[m\]; `None`: predicted, or the refined zone there.
    pub width: Option<f64>,
    /// Elements across the width; `None`: 16, or the elements that the discretisation has there.
    pub elements: Option<usize>,
    /// Share of the elements that shall touch.
    pub target_utilisation: f64,
    /// How the elements around it are divided.
    pub division: DivisionRule,
}
