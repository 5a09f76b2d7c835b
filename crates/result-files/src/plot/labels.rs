//! What legends call results: their files, or the values of the scenario in which they differ.

use std::collections::BTreeSet;

use crate::stored::scenario_values::Values;

/// How results are told apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum Labels {
    /// Names of the files.
    #[default]
    Names,
    /// Values of the scenarios that differ; names where none does.
    Values,
}

/// Characters of a label, which legends break into lines.
pub const LONGEST: usize = 160;

/// Labels by the values in which `scenarios` differ, `names` where they do not or where two would
/// have the same one.
pub fn by_values(scenarios: &[Values], names: &[String]) -> Vec<String> {
    let all: BTreeSet<&String> = scenarios.iter().flat_map(Values::keys).collect();
    let differs = |key: &&String| scenarios.windows(2).any(|w| w[0].get(*key) != w[1].get(*key));
    // Titles are words about the same difference.
    let mut keys: Vec<&str> =
        all.into_iter().filter(differs).map(String::as_str).filter(|k| *k != "title").collect();
    // Lists and tables are long, and often follow from a word: what the program chose for another
    // model.
    let is_long =
        |key: &&str| scenarios.iter().filter_map(|s| s.get(*key)).any(|value| value.starts_with(['[', '{']));
    keys.sort_by_key(|key| is_long(key));
    if keys.is_empty() {
        return names.to_vec();
    }
    let value = |scenario: &Values, key: &str| {
        format!("{} = {}", short(key, &keys), scenario.get(key).map_or("–", String::as_str))
    };
    let label = |scenario: &Values| {
        let full = keys.iter().map(|key| value(scenario, key)).collect::<Vec<_>>().join(", ");
        let n = full.chars().count();
        if n <= LONGEST { full } else { full.chars().take(LONGEST - 1).chain(['…']).collect() }
    };
    let labels: Vec<String> = scenarios.iter().map(label).collect();
    let is_shared = |label: &String| labels.iter().filter(|other| *other == label).count() > 1;
    labels
        .iter()
        .zip(names)
        .map(|(label, name)| if is_shared(label) { name.clone() } else { label.clone() })
        .collect()
}

/// The end of `key` that no other one of `keys` has, from a dot on.
fn short<'a>(key: &'a str, keys: &[&str]) -> &'a str {
    let ends = key.rmatch_indices('.').map(|(dot, _)| &key[dot + 1..]);
    let is_own = |end: &&str| {
        keys.iter().filter(|other| **other == *end || other.ends_with(&format!(".{end}"))).count() == 1
    };
    ends.chain([key]).find(is_own).unwrap_or(key)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stored::scenario_values::read;

    fn labels(texts: &[&str]) -> Vec<String> {
        let names: Vec<String> = (0..texts.len()).map(|i| format!("run-{i}")).collect();
        by_values(&texts.iter().map(|t| read(t)).collect::<Vec<_>>(), &names)
    }

    #[test]
    fn shortest_key_that_tells_values_apart() {
        assert_eq!(labels(&["a.v = 1\nb.v = 2", "a.v = 1\nb.v = 3"]), ["v = 2", "v = 3"]);
        assert_eq!(
            labels(&["a.v = 1\nb.v = 2", "a.v = 2\nb.v = 3"]),
            ["a.v = 1, b.v = 2", "a.v = 2, b.v = 3"]
        );
        assert_eq!(labels(&["a.v = [0.0, 1.5]", "a.w = 1"]), ["w = –, v = [0, 1.5]", "w = 1, v = –"]);
    }

    #[test]
    fn names_stay_where_values_do_not_tell() {
        assert_eq!(labels(&["title = \"x\"", "title = \"y\""]), ["run-0", "run-1"]);
        assert_eq!(labels(&["a.v = 1", "a.v = 1", "a.v = 2"]), ["run-0", "run-1", "v = 2"]);
        let long = format!("a.v = \"{}\"", "x".repeat(300));
        assert_eq!(labels(&[&long, "a.v = 1"])[0].chars().count(), LONGEST);
    }
}
