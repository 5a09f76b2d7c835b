//! Which deviation is allowed for which quantity: defaults, command line, tolerance file.

use std::path::Path;
use std::sync::Arc;

use super::glob::matches;
use crate::error::ResultError;
use crate::file::fault::Access;
use crate::file::plain_file;
use crate::toml_text::document::{Entry, Node, Origin, SourceText, Value, parse_toml};
use crate::toml_text::fault::{Fault, Faults, nearest};

/// The default tolerance file.
pub const DEFAULTS: &str = include_str!("defaults.toml");

/// Keys of the file and of an entry.
const FILE_KEYS: [&str; 4] = ["rtol", "atol", "datasets", "features"];
const ENTRY_KEYS: [&str; 5] = ["rtol", "atol", "scale", "compare", "steps"];

/// What is allowed for one quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Relative to the scale of the quantity.
    pub rtol: f64,
    /// Absolute, in the unit of the quantity.
    pub atol: f64,
    /// Whether the quantity is compared at all.
    pub is_compared: bool,
    /// Whether the quantity changes in steps: then a value of a neighbouring instant is as good.
    pub is_stepwise: bool,
    /// Whether the scale is the largest value with the same unit in the reference, not in the
    /// quantity itself.
    pub has_unit_scale: bool,
    /// Whether `rtol` was chosen by the user, as opposed to the defaults.
    pub is_chosen: bool,
}

/// What an entry of the file says, as far as it says something.
#[derive(Debug, Clone, PartialEq)]
struct Rule {
    pattern: String,
    is_feature: bool,
    is_default: bool,
    rtol: Option<f64>,
    atol: Option<f64>,
    compare: Option<bool>,
    steps: Option<bool>,
    unit_scale: Option<bool>,
}

/// All tolerances.
#[derive(Debug, Clone, PartialEq)]
pub struct Rules {
    rtol: f64,
    atol: f64,
    is_chosen: bool,
    rules: Vec<Rule>,
}

impl Rules {
    /// The defaults, then the file, then the command line's numbers for what no pattern says
    /// otherwise.
    ///
    /// # Errors
    /// [`ResultError::Tolerances`] for a file with faults, all of them with their lines; [`ResultError::File`] if it cannot be read.
    pub fn read(file: Option<&Path>, rtol: Option<f64>, atol: Option<f64>) -> Result<Self, ResultError> {
        let mut rules = Self { rtol: 0.0, atol: 0.0, is_chosen: false, rules: Vec::new() };
        rules.add("defaults.toml", DEFAULTS, true)?;
        if let Some(path) = file {
            let text = plain_file::text(path).map_err(|e| ResultError::system(path, Access::Read, e))?;
            rules.add(&path.display().to_string(), &text, false)?;
        }
        if let Some(rtol) = rtol {
            (rules.rtol, rules.is_chosen) = (rtol, true);
        }
        rules.atol = atol.unwrap_or(rules.atol);
        Ok(rules)
    }

    /// The tolerance of the dataset `name`.
    pub fn dataset(&self, name: &str) -> Tolerance {
        self.apply(false, name, self.base())
    }

    /// The tolerance of the feature `name`; that of the final value of a dataset starts from the
    /// dataset's.
    pub fn feature(&self, name: &str) -> Tolerance {
        let base = name.strip_prefix("final/").map_or_else(|| self.base(), |dataset| self.dataset(dataset));
        self.apply(true, name, base)
    }

    /// Patterns of the user that match none of the names.
    pub fn unused<'a>(&'a self, datasets: &[&str], features: &[&str]) -> Vec<&'a str> {
        let is_unused = |rule: &&Rule| {
            let names = if rule.is_feature { features } else { datasets };
            !rule.is_default && !names.iter().any(|name| matches(&rule.pattern, name))
        };
        self.rules.iter().filter(is_unused).map(|rule| rule.pattern.as_str()).collect()
    }

    fn base(&self) -> Tolerance {
        let (rtol, atol, is_chosen) = (self.rtol, self.atol, self.is_chosen);
        Tolerance { rtol, atol, is_compared: true, is_stepwise: false, has_unit_scale: false, is_chosen }
    }

    fn apply(&self, is_feature: bool, name: &str, mut tolerance: Tolerance) -> Tolerance {
        for rule in self.rules.iter().filter(|r| r.is_feature == is_feature && matches(&r.pattern, name)) {
            if let Some(rtol) = rule.rtol {
                (tolerance.rtol, tolerance.is_chosen) = (rtol, !rule.is_default);
            }
            tolerance.atol = rule.atol.unwrap_or(tolerance.atol);
            tolerance.is_compared = rule.compare.unwrap_or(tolerance.is_compared);
            tolerance.has_unit_scale = rule.unit_scale.unwrap_or(tolerance.has_unit_scale);
            tolerance.is_stepwise = rule.steps.unwrap_or(tolerance.is_stepwise);
        }
        tolerance
    }

    fn add(&mut self, name: &str, text: &str, is_default: bool) -> Result<(), ResultError> {
        let source = Arc::new(SourceText { name: name.to_owned(), text: text.to_owned() });
        let root = parse_toml(&source).map_err(Faults::new)?;
        let mut reader = Reader { faults: Vec::new() };
        for entry in reader.table(&root, "") {
            match entry.key.as_str() {
                "rtol" => {
                    if let Some(rtol) = reader.number(&entry.key, &entry.node) {
                        (self.rtol, self.is_chosen) = (rtol, !is_default);
                    }
                }
                "atol" => self.atol = reader.number(&entry.key, &entry.node).unwrap_or(self.atol),
                "datasets" | "features" => {
                    let rules = reader.rules(entry, is_default);
                    self.rules.extend(rules);
                }
                _ => reader.unknown(entry, "", &FILE_KEYS),
            }
        }
        if reader.faults.is_empty() { Ok(()) } else { Err(Faults::new(reader.faults).into()) }
    }
}

/// Reads values and gathers faults.
struct Reader {
    faults: Vec<Fault>,
}

impl Reader {
    fn rules(&mut self, table: &Entry, is_default: bool) -> Vec<Rule> {
        let is_feature = table.key == "features";
        let entries = self.table(&table.node, &table.key);
        entries.iter().map(|entry| self.rule(entry, &table.key, is_feature, is_default)).collect()
    }

    fn rule(&mut self, entry: &Entry, table: &str, is_feature: bool, is_default: bool) -> Rule {
        let path = format!("{table}.\"{}\"", entry.key);
        let pattern = entry.key.trim_start_matches('/').to_owned();
        let (rtol, atol, compare, steps, unit_scale) = (None, None, None, None, None);
        let mut rule = Rule { pattern, is_feature, is_default, rtol, atol, compare, steps, unit_scale };
        for item in self.table(&entry.node, &path) {
            let key = format!("{path}.{}", item.key);
            match item.key.as_str() {
                "rtol" => rule.rtol = self.number(&key, &item.node),
                "atol" => rule.atol = self.number(&key, &item.node),
                "scale" => rule.unit_scale = self.scale(&key, &item.node),
                "compare" => rule.compare = self.boolean(&key, &item.node),
                "steps" => rule.steps = self.boolean(&key, &item.node),
                _ => self.unknown(item, &path, &ENTRY_KEYS),
            }
        }
        rule
    }

    fn table<'a>(&mut self, node: &'a Node, key: &str) -> &'a [Entry] {
        if let Value::Table(entries) = &node.value {
            return entries;
        }
        self.fault(key, node, "must be a table such as { rtol = 1e-3, atol = 0.0 }");
        &[]
    }

    fn number(&mut self, key: &str, node: &Node) -> Option<f64> {
        let value = match node.value {
            Value::Float(x) => x,
            Value::Integer(i) => i as f64,
            _ => f64::NAN,
        };
        if value.is_finite() && value >= 0.0 {
            return Some(value);
        }
        self.fault(key, node, "must be a number >= 0");
        None
    }

    /// Whether the scale is that of the unit.
    fn scale(&mut self, key: &str, node: &Node) -> Option<bool> {
        match &node.value {
            Value::Text(text) if text == "own" => Some(false),
            Value::Text(text) if text == "unit" => Some(true),
            _ => {
                self.fault(key, node, "must be \"own\" or \"unit\"");
                None
            }
        }
    }

    fn boolean(&mut self, key: &str, node: &Node) -> Option<bool> {
        if let Value::Boolean(value) = node.value {
            return Some(value);
        }
        self.fault(key, node, "must be true or false");
        None
    }

    fn unknown(&mut self, entry: &Entry, table: &str, known: &[&str]) {
        let place = if table.is_empty() { String::new() } else { format!(" in {table}") };
        self.faults.push(Fault {
            location: entry.origin.location(&Origin::Default),
            key: String::new(),
            value: None,
            message: format!("unknown key \"{}\"{place}", entry.key),
            suggestion: nearest(&entry.key, known.iter().copied()),
            known: format!("known are {}", known.join(", ")),
        });
    }

    fn fault(&mut self, key: &str, node: &Node, message: &str) {
        self.faults.push(Fault {
            location: node.origin.location(&Origin::Default),
            key: key.to_owned(),
            value: Some(node.shown()),
            message: message.to_owned(),
            suggestion: None,
            known: String::new(),
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rules(text: &str, rtol: Option<f64>) -> Result<Rules, ResultError> {
        let mut rules = Rules::read(None, None, None)?;
        rules.add("t.toml", text, false)?;
        if let Some(rtol) = rtol {
            (rules.rtol, rules.is_chosen) = (rtol, true);
        }
        Ok(rules)
    }

    #[test]
    fn later_patterns_override_earlier_ones_key_by_key() {
        let text = "atol = 2.0\n[datasets]\n\"contacts/**\" = { atol = 1.0 }\n\"contacts/*/force\" = { rtol = 0.5 }\n";
        let rules = rules(text, Some(0.25)).expect("valid");
        let force = rules.dataset("contacts/a/force");
        assert_eq!((force.rtol, force.atol, force.is_chosen), (0.5, 1.0, true));
        let area = rules.dataset("contacts/a/contact_area");
        assert_eq!((area.rtol, area.atol, area.is_stepwise, area.is_chosen), (0.05, 1.0, true, false));
        let total = rules.dataset("energies/total");
        assert_eq!((total.rtol, total.atol), (0.25, 2.0));
        assert_eq!(rules.feature("final/contacts/a/force"), force);
        assert!(!rules.dataset("timings/output").is_compared);
        assert_eq!(rules.unused(&["contacts/a/force"], &[]), Vec::<&str>::new());
        assert_eq!(rules.unused(&["energies/total"], &[]), ["contacts/**", "contacts/*/force"]);
    }

    #[test]
    fn faults_are_reported_together_with_their_lines() {
        let text = "rtol = -1\nrtool = 1\n[datasets]\n\"a\" = { atl = 1.0 }\n\"b\" = 3\n\"c\" = { compare = 1, scale = 1 }\n";
        let error = rules(text, None).expect_err("faults").to_string();
        for part in [
            "t.toml:1:8: rtol = -1: must be a number >= 0",
            "t.toml:2:1: unknown key \"rtool\", did you mean \"rtol\"? Known are rtol, atol, datasets, features",
            "t.toml:4:9: unknown key \"atl\" in datasets.\"a\"",
            "t.toml:5:7: datasets.\"b\" = 3: must be a table",
            "t.toml:6:19: datasets.\"c\".compare = 1: must be true or false",
            "t.toml:6:30: datasets.\"c\".scale = 1: must be \"own\" or \"unit\"",
            "6 faults found",
        ] {
            assert!(error.contains(part), "{part} is in {error}");
        }
        assert!(rules("rtol = = 1", None).is_err());
    }
}
