//! Contacts: pairs of surfaces or spheres, and how they are modelled.

use contact_qs::ContactError;
pub use contact_qs::Target;
use contact_qs::law::penalty::from_weight;
use contact_qs::law::{Friction, Solid};
use contact_qs::quasistatic::Method;

use super::accuracy::Accuracy;
use super::body::Place;
use crate::adaptivity::interval::{TARGET_UTILISATION, least_utilisation};
use crate::adaptivity::penalty_search::PEAK_TOLERANCE;

/// A contact between a body and a target.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactSpec {
    /// Name.
    pub name: String,
    /// Index of the contact body, which carries the contact points.
    pub body: usize,
    /// The target, whose surface it meets.
    pub target: Target,
    /// The law of the contact force.
    pub law: ContactLaw,
    /// Growth of its force per closing speed [s/m].
    pub damping: f64,
    /// Overlap of the bodies at the start that is allowed \[m\].
    pub initial_overlap: f64,
}

impl ContactSpec {
    /// The bodies that meet: the contact body, and the target if that is one.
    pub fn bodies(&self) -> impl Iterator<Item = usize> + use<> {
        [Some(self.body), self.target.body()].into_iter().flatten()
    }

    /// What Hertz's law has spheres for: the one of the contact body and, with its body, that of the
    /// target, unless it is a plane; none where other surfaces or another law meet.
    pub fn spheres(&self) -> Option<(&HertzSphere, Target<(usize, &HertzSphere)>)> {
        let law = self.law.hertz()?;
        let other = |body: usize| law.target.sphere.as_ref().map(|other| (body, other)).ok_or(());
        Some((law.contact.sphere.as_ref()?, self.target.try_map(other).ok()?))
    }

    /// Whether it acts on body `index`.
    pub fn acts_on(&self, index: usize) -> bool {
        self.bodies().any(|body| body == index)
    }
}

/// How contact is resisted.
#[derive(Debug, Clone, PartialEq)]
pub enum ContactLaw {
    /// Points on the surface of the contact body against the surface of the target.
    Surface(SurfaceLaw),
    /// Hertz's force between smooth surfaces that are curved against each other.
    Hertz(HertzSpec),
}

impl ContactLaw {
    /// What displacement, strain and stress of the bodies hold of its forces.
    pub fn local_field(&self) -> LocalField {
        match self {
            Self::Hertz(_) => LocalField::ModesAlone,
            Self::Surface(law) => law.treatment.local_field(),
        }
    }

    /// Whether there is friction.
    pub fn has_friction(&self) -> bool {
        match self {
            Self::Hertz(law) => law.friction > 0.0,
            Self::Surface(law) => law.friction.is_some(),
        }
    }

    /// The law of points on surfaces, if it is one.
    pub fn surface(&self) -> Option<&SurfaceLaw> {
        match self {
            Self::Surface(law) => Some(law),
            Self::Hertz(_) => None,
        }
    }

    /// The same to change it.
    pub fn surface_mut(&mut self) -> Option<&mut SurfaceLaw> {
        match self {
            Self::Surface(law) => Some(law),
            Self::Hertz(_) => None,
        }
    }

    /// Hertz's law, if it is that.
    pub fn hertz(&self) -> Option<&HertzSpec> {
        match self {
            Self::Surface(_) => None,
            Self::Hertz(law) => Some(law),
        }
    }
}

/// What displacement, strain and stress at a point of a body hold of the forces of a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LocalField {
    /// What the modes make of them and what follows them statically: all.
    Static,
    /// All, in coordinates that vibrate: the body's own, or those of a zone that is refined at a
    /// touch.
    Vibrating,
    /// What the modes make of them. How the bodies yield at the touch is a law of its own, or left
    /// out.
    ModesAlone,
}

/// Contact by Hertz's law.
#[derive(Debug, Clone, PartialEq)]
pub struct HertzSpec {
    /// The part of the contact body that touches.
    pub contact: HertzPartner,
    /// The part of the target that touches.
    pub target: HertzPartner,
    /// Coefficient of friction, of stick and slip alike.
    pub friction: f64,
    /// Yield strength of the weaker material, infinite if none is known \[Pa\].
    pub yield_strength: f64,
}

impl HertzSpec {
    /// Elastic constants of both partners.
    pub fn solids(&self) -> [Solid; 2] {
        [self.contact.solid, self.target.solid]
    }
}

/// A partner of a Hertz contact: the surface of the body's shape, or a plane.
#[derive(Debug, Clone, PartialEq)]
pub struct HertzPartner {
    /// Elastic constants.
    pub solid: Solid,
    /// Where its surface is a sphere: which.
    pub sphere: Option<HertzSphere>,
    /// Of a body that moves in a plane \[m\].
    pub thickness: Option<f64>,
}

/// A sphere of a Hertz contact.
#[derive(Debug, Clone, PartialEq)]
pub struct HertzSphere {
    /// Place of its centre on the body.
    pub centre: Place,
    /// Radius \[m\].
    pub radius: f64,
}

impl SurfaceLaw {
    /// The penalty factor to begin with: the one given, or [`SurfaceLaw::stiffness_ratio`] over the `weight`
    /// `max(A_ii w_i)` of the points that are going to touch (Eq. A.25) [N/m³].
    ///
    /// # Errors
    /// [`ContactError::NoCompliance`] if none is given and none of these points yields.
    pub fn first_penalty(&self, weight: Option<f64>) -> Result<f64, ContactError> {
        self.penalty.map_or_else(|| from_weight(self.stiffness_ratio, weight.unwrap_or(0.0)), Ok)
    }
}

/// Contact of surfaces.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceLaw {
    /// How the modes of the contact zone are treated, and whether the program refines it.
    pub treatment: Treatment,
    /// Penalty factor, infinite for the exact constraint; `None`: predicted [N/m³].
    pub penalty: Option<f64>,
    /// Product of a predicted penalty factor and the compliance of the contact (Eq. A.25).
    pub stiffness_ratio: f64,
    /// How the penalty factor is found.
    pub search: PenaltySearch,
    /// Contact points.
    pub points: PointRule,
    /// Solver of the quasistatic problem.
    pub method: Method,
    /// Friction; `None`: frictionless.
    pub friction: Option<Friction>,
    /// Contact interval.
    pub interval: IntervalSpec,
    /// Modes of fine models, and how states come to them.
    pub transfer: TransferSpec,
}

impl SurfaceLaw {
    /// Whether the program may choose any zone, the sides of a mesh as they are among others: nobody has
    /// given one, and its points do not vibrate.
    pub fn leaves_zone_open(&self) -> bool {
        let given = self.interval.width.is_some() || self.interval.elements.is_some();
        !self.treatment.is_vibrating() && !given
    }

    /// Whether nothing yields between the surfaces: no penetration, no springs.
    pub fn is_exact(&self) -> bool {
        self.penalty == Some(f64::INFINITY)
    }
}

/// Low-frequency modes of the fine models that the program builds, and how the state is transferred
/// to them and back (\[A\] 4.4; theory section A.6).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TransferSpec {
    /// The modes.
    pub modes: LowModes,
    /// The maps; prolonged modes need none.
    pub method: TransferMethod,
}

/// Treatments of the contact zone (\[A\] section 6: the models compared; theory section A.8).
///
/// All but [`Treatment::Adaptive`] use the penalty factor as given, or as predicted (Eq. A.25),
/// without a search. Pairs are refined where they touch, for the time of the impact, as long as an
/// interval is given or a body is not refined by its own discretisation at the place where the
/// undeformed bodies are nearest at the start. Otherwise, with a plane unless they are quasistatic and
/// nobody has given a zone, and in coarse contacts one model about that place serves the whole run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Treatment {
    /// Refined by the program during the run; high-frequency modes follow statically.
    Adaptive,
    /// Refined as given; high-frequency modes follow statically. Without penetration (an infinite
    /// penalty factor) it is the model with a massless boundary of Monjaraz-Tec, Gross and Krack
    /// (2022) with MacNeal's modes (theory Eq. A.34).
    Quasistatic,
    /// Refined as given; every Craig-Bampton mode is dynamic, high-frequency ones damped critically
    /// on top of the body's own damping. Time steps of an explicit method are those of the finest
    /// elements (Eq. A.33).
    Damped,
    /// Refined as given; every Craig-Bampton mode is dynamic and undamped.
    Dynamic,
    /// No refinement and no static part: the body's low-frequency modes alone, on the contact
    /// points of its own mesh within the given width, or on the whole face.
    Coarse,
}

/// How a body has the modes that an interface adds to the low-frequency ones (\[A\] sections 2.4
/// and 6).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum InterfaceModes {
    /// Statically: a residual flexibility takes their place.
    Quasistatic,
    /// As dynamic coordinates.
    #[default]
    Dynamic,
    /// As dynamic coordinates with critical damping, on top of the body's own damping (Eq. F.28).
    Damped,
}

impl InterfaceModes {
    /// As scenarios call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Quasistatic => "quasistatic",
            Self::Dynamic => "dynamic",
            Self::Damped => "damped",
        }
    }

    /// Whether they need modes with bounds at the interface, those of Craig and Bampton.
    pub fn need_bounds(self) -> bool {
        self != Self::Dynamic
    }
}

/// What makes the elements of a contact zone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ZoneRule {
    /// The program, which finds width and penalty factor.
    Searched,
    /// The scenario, or the program as it says.
    Given,
    /// The body's own mesh.
    Own,
}

impl Treatment {
    /// All that a contact is asked of its treatment.
    const fn answers(self) -> (LocalField, ZoneRule, Option<InterfaceModes>) {
        match self {
            Self::Adaptive => (LocalField::Static, ZoneRule::Searched, None),
            Self::Quasistatic => (LocalField::Static, ZoneRule::Given, Some(InterfaceModes::Quasistatic)),
            Self::Damped => (LocalField::Vibrating, ZoneRule::Given, Some(InterfaceModes::Damped)),
            Self::Dynamic => (LocalField::Vibrating, ZoneRule::Given, Some(InterfaceModes::Dynamic)),
            Self::Coarse => (LocalField::ModesAlone, ZoneRule::Own, None),
        }
    }

    /// As [`ContactLaw::local_field`].
    pub fn local_field(self) -> LocalField {
        self.answers().0
    }

    /// Whether high-frequency modes are dynamic.
    pub fn is_vibrating(self) -> bool {
        self.local_field() == LocalField::Vibrating
    }

    /// Whether high-frequency modes follow statically.
    pub fn is_static(self) -> bool {
        self.local_field() == LocalField::Static
    }

    /// Whether the contact has a zone of small elements.
    pub fn has_fine_zone(self) -> bool {
        self.answers().1 != ZoneRule::Own
    }

    /// Whether the program finds zone and penalty factor.
    pub fn is_searched(self) -> bool {
        self.answers().1 == ZoneRule::Searched
    }

    /// The modes that a zone from the start adds to its bodies; none where low-frequency modes are
    /// enough.
    pub fn interface_modes(self) -> Option<InterfaceModes> {
        self.answers().2
    }
}

/// How the penalty factor is found (\[A\] Fig. 3).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PenaltySearch {
    /// The given one is used.
    Fixed,
    /// Raised until the peak force no longer changes.
    UntilConverged {
        /// Relative change of the peak force that counts as none.
        tolerance: f64,
    },
    /// Raised until the solver fails, as printed.
    UntilError,
}

impl PenaltySearch {
    /// Until the peak force changes by less than [`PEAK_TOLERANCE`].
    pub const CONVERGED: Self = Self::UntilConverged { tolerance: PEAK_TOLERANCE };
}

/// Where contact points stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PointRule {
    /// Greville abscissae of the surface functions (\[A\]).
    Greville,
    /// Gauss points of the surface elements (\[B\]).
    Gauss,
}

/// Contact interval and its adaptation (\[A\] 4.2, 4.3).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IntervalSpec {
    /// Width about the point of first contact, measured as [`super::RefinementSpec::width`] \[m\];
    /// `None`: the refined zone there, or predicted.
    pub width: Option<f64>,
    /// Elements across the interval; `None`: those that the discretisation has there, or
    /// [`crate::body::fine::refined::ELEMENTS`] if the program refines.
    pub elements: Option<usize>,
    /// Share of the elements that shall touch.
    pub target_utilisation: f64,
    /// Share below which the interval is too wide.
    pub min_utilisation: f64,
    /// How the elements around it are divided.
    pub division: DivisionRule,
    /// Level of the number of elements where none is given.
    pub accuracy: Accuracy,
}

impl IntervalSpec {
    /// Elements across the interval where the program refines and would take the `usual` number.
    pub fn elements_or(&self, usual: usize) -> usize {
        self.elements.unwrap_or_else(|| self.accuracy.zone_elements(usual))
    }
}

impl Default for IntervalSpec {
    fn default() -> Self {
        Self {
            width: None,
            elements: None,
            target_utilisation: TARGET_UTILISATION,
            min_utilisation: least_utilisation(TARGET_UTILISATION),
            division: DivisionRule::Graded,
            accuracy: Accuracy::Normal,
        }
    }
}

/// How levels are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DivisionRule {
    /// Lattices through the ends of the interval, their spacing doubled from level to level: as
    /// many levels as it takes (`docs/decisions/0019-levels-of-a-zone.md`). Several intervals of
    /// one body share a division by Algorithm 3.
    #[default]
    Graded,
    /// Algorithm 3 of \[A\] with its limits of five levels and ten knots per element and level.
    Printed,
}

/// Low-frequency modes of a fine model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LowModes {
    /// Those of the coarse model, prolonged: the state is transferred without loss.
    #[default]
    Prolonged,
    /// The fine model's own, as in \[A\].
    Fine,
}

/// How states are transferred.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TransferMethod {
    /// Mass-orthogonal projection: the best approximation in kinetic energy, keeps the momenta
    /// (Eqs. A.28, A.29).
    #[default]
    MassOrthogonal,
    /// As printed: \[A\] (10), (11) to the fine model, (12) to (17) back.
    Printed,
}
