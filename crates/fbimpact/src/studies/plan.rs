//! What is varied: one parameter at a time, then together what mattered, then the one that limits
//! body by body.

use adaptive::model::Subjects;
use adaptive::spec::{BodyFactors, ContactFactors, Resolution};
use result_files::converge::variant::{Parameter, Variant};

use crate::scenario::Scenario;

/// Factor on modes, meshes and contact zones.
pub const FACTOR: usize = 2;
/// Factor on the integration tolerance.
pub const TOLERANCE_FACTOR: f64 = 0.1;
/// Factor on penalty factors.
pub const PENALTY_FACTOR: f64 = 10.0;
/// Most bodies or contacts that are varied one by one to find the one that limits a result.
const MOST_SINGLES: usize = 8;
/// Name of the run of the scenario as it is.
pub const BASE: &str = "base";
/// Name of the run with everything that mattered.
pub const TOGETHER: &str = "together";

/// Why a scenario has nothing to vary.
fn absence(parameter: Parameter) -> &'static str {
    match parameter {
        Parameter::Modes => "no body is reduced to a number of modes",
        Parameter::Mesh => "no body has a mesh",
        Parameter::Zone => "no contact has a zone of small elements",
        Parameter::Tolerance => "",
        Parameter::Penalty => "no contact has a penalty factor that could be raised",
    }
}

/// Relative cost of a run, the dearest first.
fn expense(parameter: Parameter) -> u8 {
    match parameter {
        Parameter::Mesh => 0,
        Parameter::Zone => 1,
        Parameter::Modes => 2,
        Parameter::Penalty => 3,
        Parameter::Tolerance => 4,
    }
}

/// What can be varied in a scenario.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan<'a> {
    scenario: &'a Scenario,
    subjects: Subjects,
}

impl<'a> Plan<'a> {
    /// The plan for `scenario`, whose bodies and contacts `subjects` depend on each parameter.
    pub fn new(scenario: &'a Scenario, subjects: Subjects) -> Self {
        Self { scenario, subjects }
    }

    /// Bodies or contacts that `parameter` acts on.
    pub fn subjects(&self, parameter: Parameter) -> &[String] {
        match parameter {
            Parameter::Modes => &self.subjects.modes,
            Parameter::Mesh => &self.subjects.mesh,
            Parameter::Zone => &self.subjects.zone,
            Parameter::Tolerance => &[],
            Parameter::Penalty => &self.subjects.penalty,
        }
    }

    fn has_meaning(&self, parameter: Parameter) -> bool {
        parameter == Parameter::Tolerance || !self.subjects(parameter).is_empty()
    }

    /// Parameters without meaning in the scenario, and why.
    pub fn not_varied(&self) -> Vec<(Parameter, &'static str)> {
        let absent = Parameter::ALL.into_iter().filter(|p| !self.has_meaning(*p));
        absent.map(|p| (p, absence(p))).collect()
    }

    /// One variant a parameter, the dearest first so that it does not end last.
    pub fn singles(&self) -> Vec<Variant> {
        let mut parameters: Vec<Parameter> =
            Parameter::ALL.into_iter().filter(|p| self.has_meaning(*p)).collect();
        parameters.sort_by_key(|p| expense(*p));
        let single = |p: Parameter| Variant {
            name: p.name().to_owned(),
            parameters: vec![p],
            subjects: self.subjects(p).to_vec(),
            set: self.set(p),
        };
        parameters.into_iter().map(single).collect()
    }

    /// The variant of several parameters; none of one or none, which has been run.
    pub fn together(&self, parameters: &[Parameter]) -> Option<Variant> {
        let set = parameters.iter().flat_map(|p| self.set(*p)).collect();
        let (name, parameters) = (TOGETHER.to_owned(), parameters.to_vec());
        (parameters.len() > 1).then_some(Variant { name, parameters, subjects: Vec::new(), set })
    }

    /// Variants of `parameter` for one body or contact each; none if there is only one, or too many
    /// to try.
    pub fn split(&self, parameter: Parameter) -> Vec<Variant> {
        let subjects = self.subjects(parameter);
        if !(2..=MOST_SINGLES).contains(&subjects.len()) {
            return Vec::new();
        }
        let single = |subject: &String| Variant {
            name: format!("{}-{subject}", parameter.name()),
            parameters: vec![parameter],
            subjects: vec![subject.clone()],
            set: vec![self.set_one(parameter, subject)],
        };
        subjects.iter().map(single).collect()
    }

    /// Changes that vary `parameter` everywhere.
    fn set(&self, parameter: Parameter) -> Vec<String> {
        let Resolution { bodies, contacts } = &self.scenario.run.resolution;
        let tolerance = self.scenario.tolerance_factor;
        let key = format!("resolution.{}", parameter.name());
        let is_plain = match parameter {
            Parameter::Tolerance => return vec![format!("{key}={:?}", tolerance * TOLERANCE_FACTOR)],
            Parameter::Modes => bodies.iter().all(|b| b.modes == 1),
            Parameter::Mesh => bodies.iter().all(|b| b.mesh == 1),
            Parameter::Zone => contacts.iter().all(|c| c.zone == 1),
            Parameter::Penalty => contacts.iter().all(|c| *c == ContactFactors { penalty: 1.0, ..*c }),
        };
        match (is_plain, parameter) {
            (true, Parameter::Penalty) => vec![format!("{key}={PENALTY_FACTOR:?}")],
            (true, _) => vec![format!("{key}={FACTOR}")],
            (false, _) => self.subjects(parameter).iter().map(|s| self.set_one(parameter, s)).collect(),
        }
    }

    /// The change that varies `parameter` of one body or contact.
    fn set_one(&self, parameter: Parameter, subject: &str) -> String {
        let run = &self.scenario.run;
        let body = || run.bodies.iter().position(|b| b.name == subject);
        let contact = || run.contacts.iter().position(|c| c.name == subject);
        let of_body = body().map_or(BodyFactors::default(), |i| run.resolution.body(i));
        let of_contact = contact().map_or(ContactFactors::default(), |i| run.resolution.contact(i));
        let (place, value) = match parameter {
            Parameter::Modes => ("bodies", format!("{}", of_body.modes * FACTOR)),
            Parameter::Mesh => ("bodies", format!("{}", of_body.mesh * FACTOR)),
            Parameter::Zone => ("contacts", format!("{}", of_contact.zone * FACTOR)),
            Parameter::Penalty => ("contacts", format!("{:?}", of_contact.penalty * PENALTY_FACTOR)),
            Parameter::Tolerance => return self.set(parameter).concat(),
        };
        format!("resolution.{place}.{subject}.{}={value}", parameter.name())
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::scenario::{self, Override};

    const TEXT: &str = r#"
        simulation = { end_time = 1e-3 }
        [materials.steel]
        youngs_modulus = 210e9
        poissons_ratio = 0.3
        density = 7850.0
        [bodies.rod]
        model = "axisymmetric"
        material = "steel"
        geometry = { shape = "rod", radius = 0.01, length = 0.1 }
        [bodies.ball]
        model = "axisymmetric"
        material = "steel"
        geometry = { shape = "sphere", radius = 0.01 }
        position = [0.0, 0.0, -0.011]
        [contacts.tip]
        contact_body = "ball"
        target_body = "rod"
    "#;

    fn read(changes: &[String]) -> Scenario {
        let changes: Vec<Override> = changes.iter().map(|c| c.parse().expect("KEY=VALUE")).collect();
        scenario::parse(Path::new("test.toml"), TEXT.as_bytes(), &changes).unwrap_or_else(|e| panic!("{e}"))
    }

    fn subjects() -> Subjects {
        let bodies = vec!["rod".to_owned(), "ball".to_owned()];
        let contacts = vec!["tip".to_owned()];
        Subjects { modes: bodies.clone(), mesh: bodies, zone: contacts.clone(), penalty: contacts }
    }

    #[test]
    fn every_variant_is_a_valid_scenario_that_multiplies_its_factor() {
        let scenario = read(&[]);
        let plan = Plan::new(&scenario, subjects());
        let names: Vec<String> = plan.singles().iter().map(|v| v.name.clone()).collect();
        assert_eq!(names, ["mesh", "zone", "modes", "penalty", "tolerance"], "the dearest first");
        let together = plan.together(&Parameter::ALL).expect("five parameters");
        let scenario = read(&together.set);
        let fine = &scenario.run.resolution;
        assert_eq!(fine.bodies, [BodyFactors { modes: 2, mesh: 2 }; 2]);
        assert_eq!(fine.contacts, [ContactFactors { zone: 2, penalty: 10.0 }]);
        assert!((scenario.tolerance_factor - 0.1).abs() < 1e-15);
        // A second study about the finer scenario multiplies again.
        let again = Plan::new(&read(&together.set), subjects()).together(&Parameter::ALL).expect("five");
        let scenario = read(&[together.set, again.set].concat());
        let finer = &scenario.run.resolution;
        assert_eq!(finer.bodies, [BodyFactors { modes: 4, mesh: 4 }; 2]);
        assert_eq!(finer.contacts, [ContactFactors { zone: 4, penalty: 100.0 }]);
        assert!((scenario.tolerance_factor - 0.01).abs() < 1e-15);
    }

    #[test]
    fn parameters_are_varied_for_one_body_alone() {
        let scenario = read(&[]);
        let plan = Plan::new(&scenario, subjects());
        let split = plan.split(Parameter::Mesh);
        assert_eq!(split.iter().map(|v| v.name.as_str()).collect::<Vec<_>>(), ["mesh-rod", "mesh-ball"]);
        let fine = read(&split[1].set).run.resolution;
        assert_eq!(fine.bodies, [BodyFactors { modes: 1, mesh: 1 }, BodyFactors { modes: 1, mesh: 2 }]);
        assert!(plan.split(Parameter::Zone).is_empty(), "there is only one contact");
    }

    #[test]
    fn what_has_no_meaning_is_not_varied_and_said() {
        let scenario = read(&[]);
        let plan = Plan::new(&scenario, Subjects::default());
        assert_eq!(plan.singles().len(), 1);
        assert_eq!(plan.singles()[0].parameters, [Parameter::Tolerance]);
        assert_eq!(plan.not_varied().len(), 4);
        assert_eq!(plan.together(&[Parameter::Tolerance]), None);
    }
}
