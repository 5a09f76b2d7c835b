//! Mesh and modes for bodies whose scenario does not give them: asked of the models, written into
//! the scenario.
//!
//! The chosen numbers take the place of the keys that were left out, in the scenario and in its
//! resolved text, each with its reason in a comment. What reads a result finds them there as if
//! they had been given.

use std::borrow::Cow;
use std::fmt::Write as _;

use adaptive::prepared::Prepared;
use adaptive::sizing::mode_count::WITHOUT_FORCES;
use adaptive::sizing::{ChosenSizes, SizeRequest, choose};
use adaptive::spec::{Accuracy, BodySpec, ImportedSpec, RefinementSpec};
use adaptive::store::ModelCache;
use result_files::stored::chosen_sizes::MARK;

use crate::error::AppError;
use crate::scenario::Scenario;
use crate::simulate::thread_pool::thread_pool;

/// The scenario with every size that it leaves to the program, which runs on `threads` threads;
/// itself if there is none.
///
/// # Errors
/// [`AppError::Model`] naming the body whose sizes cannot be found.
pub fn sized<'a>(
    scenario: &'a Scenario,
    threads: usize,
    cache: &ModelCache,
) -> Result<Cow<'a, Scenario>, AppError> {
    if scenario.wishes.iter().all(|wish| *wish == SizeRequest::default()) {
        return Ok(Cow::Borrowed(scenario));
    }
    sized_for(scenario, &Prepared::new(&scenario.run)?, threads, cache)
}

/// As [`sized`], with what is known of its run.
///
/// # Errors
/// Likewise.
pub fn sized_for<'a>(
    scenario: &'a Scenario,
    run: &Prepared<'_>,
    threads: usize,
    cache: &ModelCache,
) -> Result<Cow<'a, Scenario>, AppError> {
    if scenario.wishes.iter().all(|wish| *wish == SizeRequest::default()) {
        return Ok(Cow::Borrowed(scenario));
    }
    let chosen = thread_pool(threads)?.install(|| choose(run, &scenario.wishes, cache))?;
    let mut scenario = scenario.clone();
    let wishes = std::mem::take(&mut scenario.wishes);
    scenario.wishes = vec![SizeRequest::default(); wishes.len()];
    let accuracy = scenario.run.accuracy;
    scenario.run.frequency_errors =
        chosen.iter().map(|sizes| sizes.mesh.as_ref().map(|mesh| mesh.error)).collect();
    for ((body, wish), chosen) in scenario.run.bodies.iter_mut().zip(wishes).zip(&chosen) {
        apply(body, (wish, accuracy), chosen, &mut scenario.source.resolved);
    }
    Ok(Cow::Owned(scenario))
}

/// Gives a body the sizes that were chosen for it, and writes them into the resolved text.
fn apply(
    body: &mut BodySpec,
    (wish, accuracy): (SizeRequest, Accuracy),
    chosen: &ChosenSizes,
    resolved: &mut String,
) {
    let name = body.name.clone();
    let mut zones = String::new();
    let mut set = |table: &str, line: &str, why: &str| {
        insert(resolved, &format!("[bodies.{name}.{table}]"), &format!("{line}{MARK}{why}"));
    };
    if let Some(elastic) = body.kind.elastic_mut() {
        if let Some(mesh) = &chosen.mesh {
            elastic.discretisation.elements.clone_from(&mesh.elements);
            set("discretisation", &format!("elements = {:?}", mesh.elements), &mesh.to_string());
        }
        for zone in &chosen.zones {
            let RefinementSpec { centre, width, elements, ratio } = zone.refinement;
            elastic.discretisation.refine.push(zone.refinement);
            let point = &centre[..elastic.model.dimension()];
            // Writing to a string cannot fail.
            let _ = write!(
                zones,
                "\n[[bodies.{name}.discretisation.refine]]\npoint = {point:?}\nwidth = {width:?}{MARK}{}\n\
                 elements = {elements}\nratio = {ratio:?}\n",
                zone.reason
            );
        }
    }
    let modes = match body.kind.imported() {
        Some(ImportedSpec::Full { body, .. }) if wish.modes => {
            let body = body.body();
            let n = accuracy.modes(WITHOUT_FORCES).min(body.dofs.len().saturating_sub(body.motion.count()));
            Some((n, format!("{n} modes of a body from a file")))
        }
        _ => chosen.modes.as_ref().map(|modes| (modes.modes, modes.to_string())),
    };
    if let (Some((n, reason)), Some(flexible)) = (modes, body.kind.flexible_mut()) {
        flexible.reduction.set_modes(n);
        set("reduction", &format!("modes = {n}"), &reason);
    }
    resolved.push_str(&zones);
}

/// Puts `line` under the header of a table of `text`, which is added if there is none.
fn insert(text: &mut String, header: &str, line: &str) {
    match text.lines().position(|l| l == header) {
        Some(_) => *text = text.replacen(&format!("{header}\n"), &format!("{header}\n{line}\n"), 1),
        None => text.push_str(&format!("\n{header}\n{line}\n")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use result_files::stored::chosen_sizes::{Note, notes};

    #[test]
    fn chosen_lines_go_to_their_table_and_are_found_again() {
        let mut text =
            "title = \"\"\n\n[bodies.a]\nmodel = \"solid\"\n\n[bodies.a.reduction]\nmethod = \"modal\"\n"
                .to_owned();
        insert(&mut text, "[bodies.a.reduction]", &format!("modes = 20{MARK}no contact"));
        insert(&mut text, "[bodies.a.discretisation]", &format!("elements = [2, 4]{MARK}small"));
        assert!(text.contains("[bodies.a.reduction]\nmodes = 20  #"), "{text}");
        assert!(
            text.ends_with("[bodies.a.discretisation]\nelements = [2, 4]  # chosen by the program: small\n")
        );
        let note = |text: &str| Note { body: "a".into(), text: text.into() };
        assert_eq!(notes(&text), [note("no contact"), note("small")]);
        assert_eq!(notes("title = \"\"\n"), []);
    }
}
