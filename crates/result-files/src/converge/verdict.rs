//! Whether a result holds, and what limits it, in a sentence.

use super::difference::{Difference, Largest, Quantity};
use super::outcome::Outcome;
use super::variant::{Parameter, Variant};
use crate::words::percent::percent;

/// Share of the tolerance below which a parameter does not matter: five such changes together are
/// half of it.
const MATTERS: f64 = 0.1;
/// Share of the joint change that one body must cause to be named alone.
const MOST: f64 = 0.5;

/// A variant with what it changes.
#[derive(Debug, Clone, PartialEq)]
pub struct Compared {
    /// What is varied.
    pub variant: Variant,
    /// What became of its run.
    pub outcome: Outcome,
    /// What it changes; none of a run that is not complete.
    pub difference: Option<Difference>,
}

impl Compared {
    /// The largest change; none of a run that is not complete, or that has nothing to compare.
    pub fn largest(&self) -> Option<Largest> {
        self.difference.as_ref()?.largest()
    }

    fn change(&self) -> f64 {
        self.largest().map_or(0.0, |l| l.relative)
    }
}

/// The judgement.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// Whether all changes are within the tolerance, and all of them are known.
    pub is_converged: bool,
    /// The variant with the largest change, and that change.
    pub limit: Option<(String, Largest)>,
    /// The sentence.
    pub sentence: String,
}

/// Parameters whose change is more than a small part of `tolerance`.
pub fn significant(singles: &[Compared], tolerance: f64) -> Vec<Parameter> {
    let matters = singles.iter().filter(|c| c.change() > MATTERS * tolerance);
    let mut parameters: Vec<Parameter> = matters.flat_map(|c| c.variant.parameters.clone()).collect();
    parameters.sort_unstable();
    parameters
}

/// The single variant with the largest change.
pub fn dominant(singles: &[Compared]) -> Option<&Compared> {
    let known = singles.iter().filter(|c| c.largest().is_some());
    known.reduce(|a, b| if b.change() > a.change() { b } else { a })
}

/// The variants of a study.
#[derive(Debug, Clone, Copy)]
pub struct Variants<'a> {
    /// Of one parameter each.
    pub singles: &'a [Compared],
    /// Of all parameters that mattered, if there are several.
    pub together: Option<&'a Compared>,
    /// Of single bodies or contacts, of the parameter that limits.
    pub split: &'a [Compared],
}

/// Judges the variants of a study.
pub fn judge(variants: Variants<'_>, tolerance: f64) -> Verdict {
    let Variants { singles, together, split } = variants;
    let unknown: Vec<&Compared> = singles.iter().chain(together).filter(|c| c.difference.is_none()).collect();
    let largest = dominant(singles.iter().chain(together).cloned().collect::<Vec<_>>().as_slice())
        .and_then(|c| Some((c.variant.name.clone(), c.largest()?)));
    let limiting = dominant(singles).filter(|c| c.change() > tolerance);
    let joint = together.filter(|c| c.change() > tolerance);
    let mut sentence = match (limiting, joint) {
        (Some(single), _) => limits(single, split, tolerance),
        (None, Some(joint)) => together_limits(joint, tolerance),
        (None, None) => within(largest.as_ref(), singles, tolerance),
    };
    if let Some(single) = limiting {
        sentence += &also(singles, &single.variant.name, tolerance);
    }
    for c in &unknown {
        sentence += &format!("; {} could not be judged: {}", c.variant.name, short(&c.outcome.message));
    }
    let is_converged = limiting.is_none() && joint.is_none() && unknown.is_empty();
    Verdict { is_converged, limit: largest, sentence }
}

/// The first line of a message, without a full stop.
fn short(message: &str) -> &str {
    message.lines().next().unwrap_or_default().trim_end_matches('.')
}

/// What is varied, in words, with the verb that fits.
fn subject(parameter: Parameter, names: &[String]) -> String {
    let quoted = |n: &[String]| n.iter().map(|n| format!("\"{n}\"")).collect::<Vec<_>>().join(", ");
    let bodies = match names {
        [one] => format!("of body \"{one}\""),
        all => format!("of bodies {}", quoted(all)),
    };
    let contacts = match names {
        [one] => format!("of contact \"{one}\""),
        all => format!("of contacts {}", quoted(all)),
    };
    let is_one = names.len() == 1;
    match parameter {
        Parameter::Modes => format!("the number of modes {bodies} limits"),
        Parameter::Mesh if is_one => format!("the mesh {bodies} limits"),
        Parameter::Mesh => format!("the meshes {bodies} limit"),
        Parameter::Zone if is_one => format!("the mesh in the zone {contacts} limits"),
        Parameter::Zone => format!("the meshes in the zones {contacts} limit"),
        Parameter::Tolerance => "the time integration limits".to_owned(),
        Parameter::Penalty if is_one => format!("the penalty factor {contacts} limits"),
        Parameter::Penalty => format!("the penalty factors {contacts} limit"),
    }
}

fn limits(single: &Compared, split: &[Compared], tolerance: f64) -> String {
    let parameter = single.variant.parameters[0];
    let alone = dominant(split).filter(|c| c.change() >= MOST * single.change());
    let names = &alone.unwrap_or(single).variant.subjects;
    format!("{} {}", subject(parameter, names), effect(single, parameter.change(), tolerance))
}

fn together_limits(joint: &Compared, tolerance: f64) -> String {
    let names: Vec<&str> = joint.variant.parameters.iter().map(|p| p.name()).collect();
    let changes: Vec<&str> = joint.variant.parameters.iter().map(|p| p.change()).collect();
    let effect = effect(joint, &changes.join(", "), tolerance);
    format!("{} together limit {effect}", names.join(", "))
}

/// What the largest change of a variant is.
fn effect(compared: &Compared, change: &str, tolerance: f64) -> String {
    let Some(largest) = compared.largest() else { return String::new() };
    let what = format!("the {} {}", largest.quantity.words(), largest.place);
    let counts = compared.difference.iter().flat_map(|d| &d.counts).next();
    match counts.filter(|_| largest.quantity == Quantity::Count) {
        Some(count) => format!("{what}: {} become {} with {change}", count.base, count.variant),
        None => format!(
            "{what}: it changes by {} with {change}, {} is allowed",
            percent(largest.relative),
            percent(tolerance)
        ),
    }
}

/// Further parameters beyond the tolerance.
fn also(singles: &[Compared], but: &str, tolerance: f64) -> String {
    let more = singles.iter().filter(|c| c.variant.name != but && c.change() > tolerance);
    let amount = |c: &Compared| match c.largest() {
        Some(l) if l.quantity == Quantity::Count => "another number of impacts".to_owned(),
        _ => percent(c.change()),
    };
    let more: Vec<String> = more.map(|c| format!("{} ({})", c.variant.name, amount(c))).collect();
    if more.is_empty() { String::new() } else { format!("; beyond it, too: {}", more.join(", ")) }
}

fn within(largest: Option<&(String, Largest)>, singles: &[Compared], tolerance: f64) -> String {
    let limit = percent(tolerance);
    match largest {
        Some((name, l)) => {
            let known = singles.iter().filter(|c| c.difference.is_some()).count();
            let all = if known == singles.len() { "converged" } else { "what could be judged is converged" };
            format!(
                "{all} within {limit}: the largest change is {}, of the {} {} in the variant {name}",
                percent(l.relative),
                l.quantity.words(),
                l.place
            )
        }
        None if singles.iter().any(|c| c.difference.is_some()) => {
            format!("nothing moves and nothing touches: there is no change to compare with {limit}")
        }
        None => "no variant is complete".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::difference::{CountChange, VelocityChange};
    use super::*;

    /// The variant of `parameter` for `subjects`.
    fn variant(parameter: Parameter, subjects: &[&str]) -> Variant {
        let subjects = subjects.iter().map(|subject| (*subject).to_owned()).collect();
        Variant { name: parameter.name().into(), parameters: vec![parameter], subjects, set: Vec::new() }
    }

    /// A variant that changes the velocity of the ball by `relative`.
    fn compared(variant: Variant, relative: f64) -> Compared {
        let (velocity, angular_velocity) = ([0.0; 3], [0.0; 3]);
        let change = VelocityChange { body: "ball".into(), velocity, angular_velocity, relative };
        let difference = Difference { velocities: vec![change], ..Difference::default() };
        Compared { variant, outcome: Outcome::default(), difference: Some(difference) }
    }

    /// Variants of meshes and modes of `bodies` and of the tolerance.
    fn singles(bodies: &[&str], of: impl Fn(Parameter) -> f64) -> Vec<Compared> {
        let all = [(Parameter::Mesh, bodies), (Parameter::Modes, bodies), (Parameter::Tolerance, &[])];
        all.map(|(parameter, subjects)| compared(variant(parameter, subjects), of(parameter))).into()
    }

    #[test]
    fn small_changes_are_converged_and_the_largest_is_named() {
        let all = singles(&["rod"], |p| if p == Parameter::Modes { 3e-3 } else { 1e-4 });
        let verdict = judge(Variants { singles: &all, together: None, split: &[] }, 0.01);
        assert!(verdict.is_converged);
        assert_eq!(
            verdict.sentence,
            "converged within 1.0 %: the largest change is 0.30 %, of the final velocity of body \"ball\" in the variant modes"
        );
    }

    #[test]
    fn the_parameter_that_limits_is_named_with_its_body_and_the_next_ones() {
        let of = |p| match p {
            Parameter::Mesh => 0.013,
            Parameter::Modes => 0.011,
            _ => 0.0,
        };
        let all = singles(&["rod"], of);
        let verdict = judge(Variants { singles: &all, together: None, split: &[] }, 0.01);
        assert!(!verdict.is_converged);
        assert_eq!(
            verdict.sentence,
            "the mesh of body \"rod\" limits the final velocity of body \"ball\": it changes by 1.3 % with twice the elements in each direction, 1.0 % is allowed; beyond it, too: modes (1.1 %)"
        );
        assert_eq!(significant(&all, 0.01), [Parameter::Modes, Parameter::Mesh]);
    }

    #[test]
    fn one_body_of_several_is_named_if_it_causes_most_of_the_change() {
        let all = singles(&["rod", "ball"], |p| if p == Parameter::Mesh { 0.02 } else { 0.0 });
        let split = |of_ball: f64| {
            [("rod", 0.001), ("ball", of_ball)]
                .map(|(body, change)| compared(variant(Parameter::Mesh, &[body]), change))
        };
        let sentence = |of_ball| {
            judge(Variants { singles: &all, together: None, split: &split(of_ball) }, 0.01).sentence
        };
        assert!(sentence(0.019).starts_with("the mesh of body \"ball\" limits"), "{}", sentence(0.019));
        let both = "the meshes of bodies \"rod\", \"ball\" limit";
        assert!(sentence(0.002).starts_with(both), "{}", sentence(0.002));
    }

    #[test]
    fn changes_that_add_up_are_beyond_the_tolerance_together() {
        let all = singles(&["rod"], |p| if p == Parameter::Tolerance { 0.0 } else { 0.008 });
        let parameters = significant(&all, 0.01);
        assert_eq!(parameters, [Parameter::Modes, Parameter::Mesh]);
        let together = Variant { name: "together".into(), parameters, subjects: Vec::new(), set: Vec::new() };
        let verdict =
            judge(Variants { singles: &all, together: Some(&compared(together, 0.015)), split: &[] }, 0.01);
        assert!(!verdict.is_converged);
        assert!(
            verdict.sentence.starts_with("modes, mesh together limit the final velocity"),
            "{}",
            verdict.sentence
        );
    }

    #[test]
    fn a_failed_variant_is_no_proof_of_convergence() {
        let mut all = singles(&["rod"], |_| 1e-4);
        all[0].difference = None;
        all[0].outcome.message = "body \"rod\": out of memory.\nmore".into();
        let verdict = judge(Variants { singles: &all, together: None, split: &[] }, 0.01);
        assert!(!verdict.is_converged);
        let words =
            ["what could be judged is converged", "mesh could not be judged: body \"rod\": out of memory"];
        assert!(words.iter().all(|w| verdict.sentence.contains(w)), "{}", verdict.sentence);
    }

    #[test]
    fn another_number_of_impacts_is_said_in_numbers() {
        let mut all = singles(&["rod"], |_| 0.0);
        let counts = vec![CountChange { contact: "tip".into(), base: 3, variant: 2 }];
        all[1].difference = Some(Difference { counts, ..Difference::default() });
        let verdict = judge(Variants { singles: &all, together: None, split: &[] }, 0.01);
        assert_eq!(
            verdict.sentence,
            "the number of modes of body \"rod\" limits the number of impacts of contact \"tip\": 3 become 2 with twice the modes"
        );
    }

    #[test]
    fn shares_have_as_many_digits_as_say_something() {
        let shown = [0.123, 0.0123, 0.00123, 1.2e-6, 0.0].map(percent);
        assert_eq!(shown, ["12 %", "1.2 %", "0.12 %", "1e-4 %", "0.00 %"]);
    }
}
