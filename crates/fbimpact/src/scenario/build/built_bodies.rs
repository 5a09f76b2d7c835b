//! Bodies that are free of faults, as other tables refer to them: by name, with their places.

use adaptive::sizing::SizeRequest;
use adaptive::spec::{BodySpec, FrameSpec, Place};
use contact_qs::Plane;
use ffr_dynamics::body::RigidMotion;
use nalgebra::UnitQuaternion;

use super::super::body_places::{BodyPlaces, GivenPlace, PlaceError};
use super::super::section::Section;
use super::super::types::{FileBody, FileOfBody};

/// A body of the run, as far as its own table says.
#[derive(Debug)]
pub struct Moving {
    /// What it is and how it starts.
    pub spec: BodySpec,
    /// What else is known of it.
    pub facts: MovingFacts,
}

/// What the specification of a body does not hold.
#[derive(Debug, Default)]
pub struct MovingFacts {
    /// Its named places.
    pub places: BodyPlaces,
    /// Sizes that the program shall choose.
    pub wish: SizeRequest,
    /// Its body file, if it is from one.
    pub file: Option<FileOfBody>,
    /// Whether its frame follows the place where the joint holds it whose child it is.
    pub follows_joint: bool,
}

/// A body that is free of faults.
#[derive(Debug)]
pub enum Built {
    /// A body of the run.
    Moving(Box<Moving>),
    /// A plane.
    Plane(Plane),
}

/// All bodies of the file.
#[derive(Debug)]
pub struct BuiltBodies {
    /// In the order of the file; none for one at fault.
    list: Vec<Option<Built>>,
    /// How many of those before each are no planes.
    before: Vec<usize>,
}

/// How a body finds the place that a table names.
pub type Find = fn(&BodyPlaces, &GivenPlace) -> Result<Place, PlaceError>;

impl BuiltBodies {
    /// The bodies `list` in the order of the file; none for one at fault.
    pub fn new(list: Vec<Option<Built>>) -> Self {
        let is_plane = |body: &Option<Built>| matches!(body, Some(Built::Plane(_)));
        let before = list.iter().scan(0, |count, body| {
            let before = *count;
            *count += usize::from(!is_plane(body));
            Some(before)
        });
        Self { before: before.collect(), list }
    }

    /// Bodies that move and are free of faults.
    pub fn moving_mut(&mut self) -> impl Iterator<Item = &mut Moving> {
        self.list.iter_mut().filter_map(|body| match body {
            Some(Built::Moving(moving)) => Some(moving.as_mut()),
            Some(Built::Plane(_)) | None => None,
        })
    }

    /// Whether all bodies are free of faults.
    pub fn is_complete(&self) -> bool {
        self.list.iter().all(Option::is_some)
    }

    /// Body `body` of the file, if it moves and is free of faults.
    pub fn moving(&self, body: usize) -> Option<&Moving> {
        match self.list.get(body)?.as_ref()? {
            Built::Moving(moving) => Some(moving),
            Built::Plane(_) => None,
        }
    }

    /// Body `body` of the file, if it is a plane and free of faults.
    pub fn plane(&self, body: usize) -> Option<&Plane> {
        match self.list.get(body)?.as_ref()? {
            Built::Plane(plane) => Some(plane),
            Built::Moving(_) => None,
        }
    }

    /// Number among the bodies of the run of body `body` of the file; none of planes and bodies at
    /// fault.
    pub fn index(&self, body: usize) -> Option<usize> {
        self.moving(body)?;
        Some(self.before[body])
    }

    /// Rotation to space of body `body` at the start, or with all joint coordinates at zero.
    pub fn rotation(&self, body: usize) -> Option<UnitQuaternion<f64>> {
        Some(self.moving(body)?.spec.motion.rotation)
    }

    /// A place on body `body` given in table `section`: by [`BodyPlaces::held`] where a joint or
    /// load takes hold, by [`BodyPlaces::observed`] where the body is observed.
    pub fn place(&self, section: &Section, body: usize, at: &GivenPlace, find: Find) -> Option<Place> {
        let key = ["marker", "face", "point"].into_iter().find(|key| section.given(key)).unwrap_or("marker");
        let places = &self.moving(body)?.facts.places;
        find(places, at).map_err(|error| section.fault(key, error.to_string())).ok()
    }

    /// The motions that each body can make, by name; none of planes.
    pub fn motions<'a>(
        &self,
        names: impl Iterator<Item = &'a str>,
    ) -> impl Iterator<Item = (&'a str, Option<RigidMotion>)> {
        names.zip(&self.list).filter_map(|(name, body)| match body.as_ref()? {
            Built::Moving(moving) => Some((name, Some(moving.spec.kind.motion()))),
            Built::Plane(_) => Some((name, None)),
        })
    }

    /// The bodies of the run with the sizes that it shall choose, and those of the file with their
    /// `names`.
    pub fn split<'a>(
        self,
        names: impl Iterator<Item = &'a str>,
    ) -> (Vec<BodySpec>, Vec<SizeRequest>, Vec<FileBody>) {
        let (mut specs, mut wishes, mut of_file) = (Vec::new(), Vec::new(), Vec::new());
        for (name, body) in names.zip(self.list) {
            let plane =
                FileBody { name: name.to_owned(), index: None, places: BodyPlaces::default(), file: None };
            of_file.push(match body {
                Some(Built::Moving(moving)) => {
                    let Moving { spec, facts } = *moving;
                    specs.push(spec);
                    wishes.push(facts.wish);
                    let index = Some(specs.len() - 1);
                    FileBody { index, places: facts.places, file: facts.file, ..plane }
                }
                Some(Built::Plane(_)) | None => plane,
            });
        }
        (specs, wishes, of_file)
    }
}

impl Moving {
    /// Lets the frame follow `place` where it follows a joint, which holds the body there.
    pub fn follow(&mut self, place: &Place) {
        if let Some(flexible) = self.spec.kind.flexible_mut().filter(|_| self.facts.follows_joint) {
            flexible.frame = FrameSpec::Tangent(place.clone());
        }
    }
}
