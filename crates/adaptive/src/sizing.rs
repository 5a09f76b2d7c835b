//! Mesh and number of modes of bodies for which nobody has given them (theory part N).
//!
//! Four questions, one file each: how fast the forces on a body will change ([`impact_time`]), how
//! many modes follow them ([`mode_count`]), which elements resolve those modes ([`mesh`], from the
//! [`mesh::proportions`] of the body), and which finer ones contacts want that keep one model for
//! the whole run ([`zone`]), and discs that joints and loads hold. The answers depend on shape,
//! material, motion at the start and contacts alone; they are the same in every run and are kept
//! with the other models.

mod extent;
mod held_place;
pub mod impact_time;
mod spectrum;
pub mod mesh;
pub mod mode_count;
mod key;
pub mod of_mesh;
pub mod zone;
pub mod mesh_touch;

use crate::body::splines::{ElasticBody, rigid_motion};
use crate::error::AdaptiveError;
use crate::prepared::Prepared;
use crate::record::work::{self, Work};
use crate::spec::{Accuracy, DiscretisationSpec, ElasticSpec, ReductionSpec, RefinementSpec};
use crate::store::{ModelCache, StoredModel};
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::reduction::Digits;
use iga_core::elasticity::Model;
use impact_time::{ForceTime, TimeScale};
use mesh::ChosenMesh;
use mode_count::{ChosenModes, ModeRange};
use spectrum::FrequencyProblem;
pub use spectrum::Spectrum;

/// What the program shall choose for a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SizeRequest {
    /// Elements per direction; those of the specification do not count then.
    pub elements: bool,
    /// Number of modes; that of the specification does not count then.
    pub modes: bool,
}

/// What the program has chosen for a body.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ChosenSizes {
    /// Elements, if they were to be chosen.
    pub mesh: Option<ChosenMesh>,
    /// Modes, if they were to be chosen.
    pub modes: Option<ChosenModes>,
    /// Zones of fine elements that contacts and held places need, if elements were to be chosen.
    pub zones: Vec<ChosenZone>,
}

/// Chooses what `wishes`, one per body of `run`, ask for: elements and modes of splines, modes of
/// meshes; others get nothing.
///
/// # Errors
/// [`AdaptiveError`] naming a body whose matrices or modes cannot be computed, or joints that do not fit.
pub fn choose(
    run: &Prepared<'_>,
    wishes: &[SizeRequest],
    cache: &ModelCache,
) -> Result<Vec<ChosenSizes>, AdaptiveError> {
    let (spec, touches) = (run.spec(), &run.touches);
    let mut chosen = vec![ChosenSizes::default(); spec.bodies.len()];
    if wishes.iter().all(|wish| *wish == SizeRequest::default()) {
        return Ok(chosen);
    }
    let accuracy = spec.accuracy;
    let mut times = impact_time::shortest(touches);
    times
        .iter_mut()
        .flatten()
        .for_each(|time| time.frequency *= accuracy.frequency(time.scale == TimeScale::Flat));
    for (i, (body, wish)) in spec.bodies.iter().zip(wishes).enumerate() {
        let _work = work::begin(format!("body \"{}\" ({} of {})", body.name, i + 1, spec.bodies.len()));
        let time = times[i].as_ref();
        if let Some(elastic) = body.kind.elastic().filter(|_| *wish != SizeRequest::default()) {
            let candidate = Candidate::new(&body.name, elastic, *wish).with_accuracy(accuracy);
            chosen[i] = sizes(&candidate, time, cache)?;
        }
        if let Some(meshed) = body.kind.meshed().filter(|_| wish.modes) {
            chosen[i].modes = Some(of_mesh::modes(&body.name, meshed, accuracy, time, cache)?);
        }
        chosen[i].warn(&body.name);
        if wish.elements {
            chosen[i].zones = zone::zones(touches, i);
            let elements = chosen[i].mesh.as_ref().map_or(&[][..], |mesh| &mesh.elements);
            let places = held_place::zones(spec, i, elements);
            chosen[i].zones.extend(places);
        }
    }
    Ok(chosen)
}

fn sizes(
    candidate: &Candidate<'_>,
    time: Option<&ForceTime>,
    cache: &ModelCache,
) -> Result<ChosenSizes, AdaptiveError> {
    let Candidate { spec, wish, accuracy, .. } = candidate;
    let range = ModeRange::new(candidate.motion(), spec.flexible.reduction, *accuracy, time);
    let numbers = cache.recent(
        key::sizes_key(spec, *wish, *accuracy, range),
        Numbers::from_stored,
        || Numbers::compute(candidate, range),
        Numbers::stored,
    )?;
    Ok(numbers.with_reason(candidate, time))
}

/// The choice without its reason: what is kept between runs.
#[derive(Debug, Clone, PartialEq)]
struct Numbers {
    elements: Vec<usize>,
    error: f64,
    modes: usize,
    highest: Option<f64>,
}

impl Numbers {
    fn compute(candidate: &Candidate<'_>, range: ModeRange) -> Result<Self, AdaptiveError> {
        let wish = candidate.wish;
        let given = match candidate.spec.flexible.reduction {
            ReductionSpec::Modal { modes } | ReductionSpec::CraigBampton { modes, .. } => modes,
            ReductionSpec::All => candidate.accuracy.modes(mode_count::WITHOUT_FORCES),
        };
        let mut solved = Vec::new();
        let (modes, highest) =
            if wish.modes { mode_count::count(candidate, range, &mut solved)? } else { (given, None) };
        let (elements, error) =
            if wish.elements { mesh::mesh(candidate, modes, solved)? } else { (Vec::new(), 0.0) };
        Ok(Self { elements, error, modes, highest })
    }

    fn stored(&self) -> StoredModel {
        let counts = std::iter::once(self.modes).chain(self.elements.iter().copied());
        let values = std::iter::once(self.error).chain(self.highest).collect();
        StoredModel { counts: counts.map(|n| n as u64).collect(), values }
    }

    fn from_stored(stored: &StoredModel) -> Option<Self> {
        let counts: Vec<usize> =
            stored.counts.iter().map(|n| usize::try_from(*n)).collect::<Result<_, _>>().ok()?;
        let ((modes, elements), (error, highest)) = (counts.split_first()?, stored.values.split_first()?);
        let highest = highest.first().copied();
        Some(Self { elements: elements.to_vec(), error: *error, modes: *modes, highest })
    }

    fn with_reason(self, candidate: &Candidate<'_>, time: Option<&ForceTime>) -> ChosenSizes {
        let (wish, accuracy) = (candidate.wish, candidate.accuracy);
        let Self { elements, error, modes, highest } = self;
        ChosenSizes {
            mesh: wish.elements.then_some(ChosenMesh { elements, error, modes, accuracy }),
            modes: wish.modes.then(|| ChosenModes { modes, highest, carried: None, time: time.cloned() }),
            zones: Vec::new(),
        }
    }
}

/// A zone of fine elements that the program has chosen.
#[derive(Debug, Clone, PartialEq)]
pub struct ChosenZone {
    /// The zone.
    pub refinement: RefinementSpec,
    /// The purpose of the zone, for the comment in the scenario.
    pub reason: String,
}

impl ChosenSizes {
    fn warn(&self, body: &str) {
        if let Some(mesh) = self.mesh.as_ref().filter(|m| m.error > mesh::TOLERANCE.max(m.tolerance())) {
            tracing::warn!("body \"{body}\": {mesh}; give discretisation.elements, or fewer reduction.modes");
        }
        if let Some(modes) = self.modes.as_ref().filter(|m| m.is_cut()) {
            tracing::warn!("body \"{body}\": {modes}; give reduction.modes");
        }
    }
}

/// A body on which sizes are tried: without local refinement, which contacts add to whatever mesh
/// is chosen.
pub struct Candidate<'a> {
    name: &'a str,
    spec: ElasticSpec,
    /// What is to be chosen.
    wish: SizeRequest,
    /// Level of what is chosen.
    accuracy: Accuracy,
    /// What the meshes tried so far have shown of single precision.
    digits: Digits,
}

impl<'a> Candidate<'a> {
    /// The body `name` that is made from `elastic`.
    pub fn new(name: &'a str, elastic: &ElasticSpec, wish: SizeRequest) -> Self {
        let mut spec = elastic.clone();
        let mesh = &elastic.discretisation;
        spec.discretisation = DiscretisationSpec { refine: Vec::new(), ..mesh.clone() };
        if wish.elements {
            spec.discretisation.elements = vec![1; mesh.degrees.len()];
        }
        Self { name, spec, wish, accuracy: Accuracy::default(), digits: Digits::default() }
    }

    /// The same, with what is chosen at a level of accuracy.
    #[must_use]
    pub fn with_accuracy(self, accuracy: Accuracy) -> Self {
        Self { accuracy, ..self }
    }

    fn motion(&self) -> RigidMotion {
        rigid_motion(&self.spec.model)
    }

    /// Degrees of the splines, one per direction.
    pub fn degrees(&self) -> &[usize] {
        &self.spec.discretisation.degrees
    }

    /// Directions that are refined together: patches that share faces turn them into one another.
    fn groups(&self) -> Vec<Vec<usize>> {
        mesh::proportions::groups(&self.spec.shape)
    }

    /// For each direction, the first one that is equivalent to it because a mirror turns the one
    /// into the other.
    fn equivalent_directions(&self) -> Vec<usize> {
        let degrees = self.degrees();
        let is_isotropic =
            self.spec.model != Model::Axisymmetric && self.spec.flexible.rigid_areas.is_empty();
        if !is_isotropic {
            return (0..degrees.len()).collect();
        }
        let equivalent_directions = mesh::proportions::equivalent_directions(&self.spec.shape);
        equivalent_directions
            .iter()
            .enumerate()
            .map(|(d, &of)| if degrees[of] == degrees[d] { of } else { d })
            .collect()
    }

    /// Tells that a mesh is tried.
    fn trial(&self, elements: &[usize]) -> Work {
        work::begin(format!("modes of a mesh with some {} unknowns", self.unknowns(elements)))
    }

    /// The body with `elements`, a number for each direction.
    fn build(&self, elements: &[usize]) -> Result<ElasticBody, AdaptiveError> {
        let mut spec = self.spec.clone();
        spec.discretisation.elements = elements.to_vec();
        ElasticBody::build(self.name, spec)
    }

    /// The `n` lowest eigenfrequencies \[Hz\], or all if there are fewer, with `elements`, a number
    /// for each direction.
    ///
    /// # Errors
    /// [`AdaptiveError`] naming the body.
    pub fn spectrum(&self, elements: &[usize], n: usize) -> Result<Spectrum, AdaptiveError> {
        self.spectrum_below(elements, n, &[])
    }

    /// As [`Self::spectrum`], if a coarser mesh has shown that the frequencies do not exceed
    /// `bounds`.
    fn spectrum_below(
        &self,
        elements: &[usize],
        n: usize,
        bounds: &[f64],
    ) -> Result<Spectrum, AdaptiveError> {
        let _work = self.trial(elements);
        let body = self.build(elements)?;
        let spectrum =
            FrequencyProblem::new(self.name, &body.assembled, &self.digits)?.lowest_below(n, bounds)?;
        Ok(Spectrum { elements: elements.to_vec(), ..spectrum })
    }

    /// Number of unknowns that a mesh has, up to boundaries.
    pub fn unknowns(&self, elements: &[usize]) -> usize {
        // A mesh that cannot be made is told when it is built.
        elements.len() * self.spec.shape.n_functions(self.degrees(), elements).unwrap_or(usize::MAX / 3)
    }
}
