//! Parts and instances of an input file, and which of them is the body.

use super::super::text::fail;
use super::axes::Movement;
use super::card::Card;
use super::part::Part;
use crate::fault::{MeshError, ReadFault};

/// An instance of a part.
#[derive(Debug, Default)]
struct Instance {
    name: String,
    line: usize,
    /// Name of its part.
    of: String,
    /// Number of the part of its own, if nodes stand in the instance itself.
    own: Option<usize>,
    movement: Movement,
}

/// Where a file stands.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
enum Stage {
    /// There are no parts.
    #[default]
    Flat,
    Part,
    Instance,
    /// Behind a part or instance.
    Outside,
    /// The part is chosen.
    Chosen,
    /// It cannot be.
    Undecided,
}

/// Parts and instances.
#[derive(Debug, Default)]
pub struct Assembly {
    stage: Stage,
    parts: Vec<Part>,
    instances: Vec<Instance>,
    /// What of the name asked for is left to be found in the part.
    rest: Option<String>,
}

/// A part that may be the body.
struct Candidate {
    name: String,
    part: usize,
    instance: Option<usize>,
}

impl Assembly {
    /// `*PART`.
    pub fn begin_part(&mut self, part: &mut Part, card: &Card) {
        self.end(part);
        *part = Part::named(card.get("NAME").unwrap_or_default());
        self.stage = Stage::Part;
    }

    /// `*INSTANCE`.
    pub fn begin_instance(&mut self, part: &mut Part, card: &Card) {
        self.end(part);
        let [name, of] = ["NAME", "PART"].map(|key| card.get(key).unwrap_or_default().to_owned());
        *part = Part::named(&name);
        self.instances.push(Instance { name, of, line: card.line, ..Instance::default() });
        self.stage = Stage::Instance;
    }

    /// The end of a part or instance.
    pub fn end(&mut self, part: &mut Part) {
        let part = std::mem::take(part);
        if !part.is_empty() {
            if self.stage == Stage::Instance
                && let Some(instance) = self.instances.last_mut()
            {
                instance.own = Some(self.parts.len());
            }
            self.parts.push(part);
        }
        if self.stage != Stage::Flat || !self.parts.is_empty() {
            self.stage = Stage::Outside;
        }
    }

    /// Whether what is read stands in no part.
    pub fn is_outside(&self) -> bool {
        matches!(self.stage, Stage::Outside | Stage::Chosen | Stage::Undecided)
    }

    /// Whether there are several parts and none is chosen.
    pub fn is_undecided(&self) -> bool {
        self.stage == Stage::Undecided
    }

    /// A line of data of `*INSTANCE`.
    pub fn data(&mut self, line: usize, text: &str) -> Result<(), MeshError> {
        self.instances.last_mut().map_or(Ok(()), |instance| instance.movement.data(line, text))
    }

    /// All instances, or parts where there are none.
    fn candidates(&self) -> Vec<Candidate> {
        let is = |name: &str, part: &Part| part.name.eq_ignore_ascii_case(name);
        if self.instances.is_empty() {
            let all = self.parts.iter().enumerate();
            return all.map(|(i, p)| Candidate { name: p.name.clone(), part: i, instance: None }).collect();
        }
        let all = self.instances.iter().enumerate().filter_map(|(i, instance)| {
            let part = instance.own.or_else(|| self.parts.iter().position(|p| is(&instance.of, p)))?;
            Some(Candidate { name: instance.name.clone(), part, instance: Some(i) })
        });
        all.collect()
    }

    /// Makes `part` the one called `wanted`, the only one with solid elements if none is asked for;
    /// what else the name may mean is left to be found in it.
    pub fn choose(&mut self, part: &mut Part, wanted: Option<&str>) {
        if self.stage != Stage::Outside {
            return;
        }
        let mut all = self.candidates();
        let called = |name: &str| all.iter().position(|c| c.name.eq_ignore_ascii_case(name));
        let of_part = |name: &str| {
            let mut found =
                (0..all.len()).filter(|&i| self.parts[all[i].part].name.eq_ignore_ascii_case(name));
            found.next().filter(|_| found.next().is_none())
        };
        let within = |name: &str| {
            let dots = name.match_indices('.').map(|(at, _)| at);
            dots.filter_map(|at| Some((called(&name[..at])?, name[at + 1..].to_owned()))).next()
        };
        let only = || {
            let mut solid = (0..all.len()).filter(|&i| self.parts[all[i].part].is_solid());
            solid.next().filter(|_| solid.next().is_none()).or((all.len() == 1).then_some(0))
        };
        let (found, rest) = match wanted {
            None => (only(), None),
            Some(name) => match called(name).or_else(|| of_part(name)) {
                Some(found) => (Some(found), None),
                None => match within(name) {
                    Some((found, rest)) => (Some(found), Some(rest)),
                    None => (only(), Some(name.to_owned())),
                },
            },
        };
        let Some(found) = found else {
            self.stage = Stage::Undecided;
            return;
        };
        let Candidate { name, part: place, instance } = all.swap_remove(found);
        let movement = instance.map(|i| std::mem::take(&mut self.instances[i].movement)).unwrap_or_default();
        let names: Vec<String> = match instance {
            Some(_) => self.instances.iter().map(|i| i.name.clone()).collect(),
            None => self.parts.iter().map(|p| p.name.clone()).collect(),
        };
        *part = std::mem::take(&mut self.parts[place]).placed(&name, names, &movement);
        (self.rest, self.stage) = (rest, Stage::Chosen);
    }

    /// Ends the file with the part that is the body in `part`; what of the name `wanted` is still to
    /// be found in it.
    pub fn finish(mut self, part: &mut Part, wanted: Option<&str>) -> Result<Option<String>, MeshError> {
        if self.stage == Stage::Flat {
            return Ok(wanted.map(str::to_owned));
        }
        if matches!(self.stage, Stage::Part | Stage::Instance) {
            self.end(part);
        }
        for Instance { name, line, of, own, .. } in &self.instances {
            let has_part =
                self.parts.iter().any(|p| p.name.eq_ignore_ascii_case(of)) || self.stage == Stage::Chosen;
            if own.is_none() && !has_part {
                let user = format!("instance \"{name}\"");
                return fail(*line, ReadFault::UnknownSet { user, set: of.clone() });
            }
        }
        self.choose(part, wanted);
        if self.stage == Stage::Chosen {
            return Ok(self.rest);
        }
        let all = self.candidates();
        let names = all.into_iter().filter(|c| self.parts[c.part].is_solid()).map(|c| c.name).collect();
        let line = self.instances.first().map_or(1, |instance| instance.line);
        fail(line, ReadFault::Parts { asked: wanted.map(str::to_owned), names })
    }
}
