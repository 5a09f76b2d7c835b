//! Checks a document against the key tables: unknown and missing keys, types, ranges. Collects
//! every fault.

use std::borrow::Cow;
use std::path::PathBuf;

use result_files::toml_text::document::{Entry, Node, Origin, Value, parse_value};
use result_files::toml_text::fault::{Fault, meant, nearest};

use super::keys::units;
use super::keys::{Choice, Key, Kind, Need, Range, Variant, names};
use super::section::{Checked, FaultList, Item, NamedSections, Section, join};

/// A degree \[rad\].
const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// Longest name of a body, material, contact or output.
const MAX_NAME: usize = 64;

/// Ends of the paths of keys that earlier versions knew, and what to do instead.
const FORMER: &[(&str, &str)] = &[
    ("interval.max_levels", "as many levels are made as the interval needs, leave it out"),
    (
        "interval.max_knots_per_level",
        "levels halve the elements; leave it out, or write interval.division = \"printed\" for Algorithm 3 with ten knots",
    ),
    (
        "interval.min_utilisation",
        "an interval is too wide below five sevenths of target_utilisation, leave it out",
    ),
    ("penalty.value", "write initial, with search = \"fixed\" where the factor shall stay"),
    ("friction_stiffness_ratio", "points that stick have the normal penalty factor, leave it out"),
    ("free.velocity_floor", "motion is resolved down to 1e-6 m/s, leave it out"),
    ("impact.velocity_floor", "motion is resolved down to 1e-6 m/s, leave it out"),
    (
        "reduction.joint_interface",
        "bases have the static answers to joints and loads by default, whatever the method; leave it out",
    ),
];

/// A word of other programs.
struct Foreign {
    words: &'static [&'static str],
    /// The key that stands for it here; none if nothing does.
    key: Option<&'static str>,
    /// What to know of it.
    remark: &'static str,
    /// Where that key stands.
    place: &'static str,
}

const FOREIGN: &[Foreign] = &[
    Foreign {
        words: &["restitution", "coefficient_of_restitution", "restitution_coefficient", "cor"],
        key: None,
        remark: ": restitution is a result and no setting, it follows from waves, damping and friction (`fbimpact info` prints it); for losses see damping of bodies and joints",
        place: "",
    },
    Foreign {
        words: &["diameter", "d"],
        key: Some("radius"),
        remark: ": half of the diameter is given",
        place: "the geometry of a body",
    },
    Foreign {
        words: &["master", "master_body", "master_surface"],
        key: Some("target_body"),
        remark: ": the master is the target",
        place: "[contacts.NAME]",
    },
    Foreign {
        words: &["slave", "slave_body", "slave_surface"],
        key: Some("contact_body"),
        remark: ": the slave carries the contact points",
        place: "[contacts.NAME]",
    },
    Foreign {
        words: &["E", "young", "modulus", "elastic_modulus"],
        key: Some("youngs_modulus"),
        remark: "",
        place: "[materials.NAME]",
    },
    Foreign { words: &["nu", "poisson"], key: Some("poissons_ratio"), remark: "", place: "[materials.NAME]" },
    Foreign { words: &["rho"], key: Some("density"), remark: "", place: "[materials.NAME]" },
    Foreign {
        words: &["mu", "friction_coefficient", "coefficient_of_friction"],
        key: Some("friction"),
        remark: "",
        place: "[contacts.NAME]",
    },
    Foreign {
        words: &["dt", "time_step", "step_size", "timestep"],
        key: Some("max_step"),
        remark: ": steps are chosen by the program, the largest may be given",
        place: "[simulation.impact] or [simulation.free]",
    },
    Foreign {
        words: &["t_end", "duration", "stop_time", "end"],
        key: Some("end_time"),
        remark: "",
        place: "[simulation]",
    },
];

/// Collects faults while tables are checked.
#[derive(Debug, Default)]
pub struct Checker {
    /// Tables of numbers that the scenario names, each with what it is.
    pub files: Vec<(PathBuf, String)>,
    /// Faults so far.
    pub faults: FaultList,
    /// Unit of the quantity over time whose table is checked.
    quantity: &'static str,
}

impl Checker {
    /// Adds a fault at `origin`.
    pub fn fault(&mut self, origin: &Origin, key: String, value: Option<String>, message: String) {
        self.faults.tell(origin, key, value, message);
    }

    /// Checks `entries` against `keys`; `skip` is a key that has been dealt with.
    pub fn section(
        &mut self,
        keys: &'static [Key],
        entries: &[Entry],
        path: &str,
        origin: &Origin,
        skip: Option<&str>,
    ) -> Section {
        for entry in entries.iter().filter(|e| Some(e.key.as_str()) != skip) {
            if !keys.iter().any(|k| matches_key(k, &entry.key)) {
                self.unknown_key(keys, entry, path, skip);
            }
        }
        let items = keys.iter().filter_map(|key| self.item(key, entries, path, origin)).collect();
        Section {
            path: path.to_owned(),
            origin: origin.clone(),
            items,
            quantity: "",
            faults: self.faults.clone(),
        }
    }

    fn unknown_key(&mut self, keys: &[Key], entry: &Entry, path: &str, skip: Option<&str>) {
        let former = FORMER.iter().find(|(key, _)| join(path, &entry.key).ends_with(key));
        if let Some((_, remedy)) = former {
            let message = format!("is no key any more: {remedy}");
            return self.fault(&entry.origin, join(path, &entry.key), Some(entry.node.shown()), message);
        }
        let known: Vec<&str> = skip.into_iter().chain(keys.iter().map(|k| k.name)).collect();
        let location = entry.origin.location(&Origin::Default);
        let listed = format!("known here are {}", names(known.iter().copied()));
        let foreign = FOREIGN.iter().find(|foreign| foreign.words.contains(&entry.key.as_str()));
        let nearest = |known| nearest(&entry.key, known);
        let (message, suggestion) = match foreign {
            Some(Foreign { key: None, remark, .. }) => (format!("unknown key{remark}"), None),
            Some(Foreign { key: Some(key), remark, .. }) if known.contains(key) => {
                (format!("unknown key{remark}"), Some((*key).to_owned()))
            }
            Some(Foreign { key: Some(key), remark, place, .. }) => match nearest(known) {
                Some(near) => ("unknown key".to_owned(), Some(near)),
                None => (format!("unknown key{remark}; {key} stands in {place}"), None),
            },
            None => ("unknown key".to_owned(), nearest(known)),
        };
        self.faults.push(Fault {
            location,
            key: join(path, &entry.key),
            value: Some(entry.node.shown()),
            message,
            suggestion,
            known: listed,
        });
    }

    fn item(&mut self, key: &'static Key, entries: &[Entry], path: &str, table: &Origin) -> Option<Item> {
        let mut found = entries.iter().filter(|e| matches_key(key, &e.key));
        if let Some(entry) = found.next() {
            if let Some(second) = found.next() {
                let message = format!("the same quantity is given as \"{}\" already, keep one", entry.key);
                self.fault(&second.origin, join(path, &second.key), Some(second.node.shown()), message);
            }
            let full = join(path, &entry.key);
            let in_degrees = entry.key != key.name;
            let value = self.value(key, &entry.node, &full, in_degrees);
            let units = units::given(&entry.node, &self.unit(key));
            let origin = entry.node.origin.clone();
            return Some(Item {
                value,
                origin,
                shown: entry.node.shown(),
                units,
                given: true,
                in_degrees,
                ..invalid(key, table)
            });
        }
        if matches!(key.need, Need::Required) {
            let what = format!("required key is missing: {} ({})", key.kind.allowed(key.unit), key.doc);
            self.fault(table, join(path, key.name), None, what);
            return Some(invalid(key, table));
        }
        let node = parse_value(&key.need.default()?, table)
            .expect("defaults of the key tables are TOML, a test reads them");
        let value = self.value(key, &node, &join(path, key.name), false);
        Some(Item { value, shown: node.shown(), ..invalid(key, table) })
    }

    /// Unit of `key`; of a key in the table of a quantity over time that of the quantity.
    fn unit(&self, key: &Key) -> Cow<'static, str> {
        match key.unit {
            "U" => self.quantity.into(),
            "U/s" => self
                .quantity
                .split(", ")
                .map(|unit| format!("{unit}/s"))
                .collect::<Vec<_>>()
                .join(", ")
                .into(),
            unit => unit.into(),
        }
    }

    fn value(&mut self, key: &'static Key, node: &Node, path: &str, in_degrees: bool) -> Checked {
        if !takes_units(&key.kind, node) {
            return self.plain_value(key, node, path, in_degrees);
        }
        let unit = if in_degrees { "".into() } else { self.unit(key) };
        match units::converted(node, &unit) {
            Ok(converted) => self.plain_value(key, converted.as_ref().unwrap_or(node), path, in_degrees),
            Err(message) => {
                self.fault(&node.origin, path.to_owned(), Some(node.shown()), message);
                Checked::Invalid
            }
        }
    }

    /// A value whose numbers are in the unit of the key, or in degrees.
    fn plain_value(&mut self, key: &'static Key, node: &Node, path: &str, in_degrees: bool) -> Checked {
        let scale = if in_degrees { DEGREE } else { 1.0 };
        let before = self.faults.len();
        let value = match (&key.kind, &node.value) {
            (Kind::Table(keys), Value::Table(entries)) => {
                return Checked::Table(self.section(keys, entries, path, &node.origin, None));
            }
            (Kind::Variants { tag, variants }, Value::Table(entries)) => {
                return self.variant(tag, variants, entries, path, &node.origin);
            }
            (Kind::Named(_) | Kind::NamedByFile(_), Value::Table(entries)) => {
                let list = entries.iter().filter_map(|e| self.named(key, e, path)).collect();
                return Checked::Named(NamedSections::new(list));
            }
            (Kind::NameLists, Value::Table(entries)) => {
                return Checked::NameLists(entries.iter().filter_map(|e| self.name_list(e, path)).collect());
            }
            (Kind::Tables(keys), Value::Array(nodes)) => {
                let list = nodes.iter().enumerate().filter_map(|(i, n)| {
                    let path = format!("{path}[{i}]");
                    match &n.value {
                        Value::Table(entries) => Some(self.section(keys, entries, &path, &n.origin, None)),
                        _ => {
                            self.wrong(n, &path, "must be a table");
                            None
                        }
                    }
                });
                return Checked::Tables(list.collect());
            }
            (Kind::Text, Value::Text(s)) => Some(Checked::Text(s.clone())),
            (Kind::Name, Value::Text(s)) if !s.trim().is_empty() => Some(Checked::Text(s.clone())),
            (Kind::Choice(choices), Value::Text(s)) => self.choice(choices, s, node, path),
            (Kind::Choices(choices), Value::Array(items)) => self.choices(choices, items, path),
            (Kind::ChoiceOrNumber(choices, _), Value::Text(s)) => self.choice(choices, s, node, path),
            (Kind::Place(_), Value::Text(s)) if !s.trim().is_empty() => Some(Checked::Text(s.clone())),
            (Kind::Number(range) | Kind::ChoiceOrNumber(_, range), _) => {
                number_in(node, range, scale).map(Checked::Number)
            }
            (Kind::Boolean, Value::Boolean(b)) => Some(Checked::Boolean(*b)),
            (Kind::Numbers(range) | Kind::Symmetric(range), Value::Array(items))
                if matches!(key.kind, Kind::Numbers(_)) && !items.is_empty()
                    || items.len() == 3 && items.iter().all(|n| number(n).is_some()) =>
            {
                self.numbers(key, items, range, path, scale)
            }
            (Kind::Symmetric(range), Value::Array(rows)) if rows.len() == 3 => {
                self.lists(key, rows, range, path)
            }
            (Kind::NumberOrVariants { tag, variants, .. }, Value::Table(entries)) => {
                self.quantity = key.unit;
                return self.variant(tag, variants, entries, path, &node.origin).of_quantity(key.unit);
            }
            (Kind::Numbers(range), _) => number_in(node, range, scale).map(|x| Checked::Numbers(vec![x])),
            (Kind::NumberOrVariants { range, .. }, _) => number_in(node, range, scale).map(Checked::Number),
            (Kind::Integer(min, max), _) => integer_in(node, *min, *max).map(Checked::Integer),
            (Kind::Counts(min, max), _) => self.counts(key, node, path, *min, *max),
            (Kind::Vector(n, range), Value::Array(items)) if items.len() == *n => {
                self.numbers(key, items, range, path, scale)
            }
            (Kind::Rotation, Value::Array(items))
                if items.len() == 3 || (items.len() == 4 && !in_degrees) =>
            {
                self.numbers(key, items, &Range::within(1e6), path, scale)
            }
            (Kind::Point(range) | Kind::Place(range), Value::Array(items))
                if matches!(items.len(), 2 | 3) =>
            {
                self.numbers(key, items, range, path, scale)
            }
            (Kind::List(range), Value::Array(items)) => self.numbers(key, items, range, path, scale),
            (Kind::Lists(range) | Kind::Points(range), Value::Array(rows)) => {
                self.lists(key, rows, range, path)
            }
            _ => None,
        };
        if value.is_none() && self.faults.len() == before {
            let allowed = allowed(key, &self.unit(key), in_degrees || is_in_degrees(node));
            self.wrong(node, path, &format!("must be {allowed}"));
        }
        value.unwrap_or(Checked::Invalid)
    }

    fn wrong(&mut self, node: &Node, path: &str, message: &str) {
        // A number is seen to be one; what it should be has been said.
        let message = match node.value {
            Value::Integer(_) | Value::Float(_) | Value::Measured(..) => message.to_owned(),
            _ => format!("{message}, found {}", node.type_name()),
        };
        self.fault(&node.origin, path.to_owned(), Some(node.shown()), message);
    }

    /// The name of an entry that the user has named, or that a file has.
    fn name(&mut self, entry: &Entry, of_file: bool, path: &str) -> Option<String> {
        let name = &entry.key;
        let plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        let message = if of_file {
            let is_wrong = name.is_empty() || name.contains(char::is_control);
            is_wrong
                .then(|| "a name must have one character at least, none of them a control character".into())
        } else {
            let is_wrong = name.is_empty() || name.len() > MAX_NAME || !name.chars().all(plain);
            is_wrong.then(|| {
                format!(
                    "a name must have 1 to {MAX_NAME} characters out of letters, digits, \"_\" and \"-\", \
                     for it becomes a path in the result file"
                )
            })
        };
        if let Some(message) = message {
            self.fault(&entry.origin, format!("{path}.{name:?}"), None, message);
            return None;
        }
        Some(name.clone())
    }

    fn named(&mut self, key: &'static Key, entry: &Entry, path: &str) -> Option<(String, Section)> {
        let (Kind::Named(keys) | Kind::NamedByFile(keys)) = key.kind else { return None };
        let name = self.name(entry, matches!(key.kind, Kind::NamedByFile(_)), path)?;
        let full = join(path, &name);
        let Value::Table(entries) = &entry.node.value else {
            self.wrong(&entry.node, &full, "must be a table");
            return None;
        };
        Some((name, self.section(keys, entries, &full, &entry.node.origin, None)))
    }

    fn name_list(&mut self, entry: &Entry, path: &str) -> Option<(String, Vec<String>)> {
        let name = self.name(entry, false, path)?;
        let texts = match &entry.node.value {
            Value::Array(nodes) => nodes.iter().map(text).collect(),
            _ => None,
        };
        let texts = texts.filter(|texts: &Vec<String>| !texts.is_empty());
        if texts.is_none() {
            self.wrong(&entry.node, &join(path, &name), "must be a list of names in quotes, one at least");
        }
        Some((name, texts?))
    }

    fn variant(
        &mut self,
        tag: &'static str,
        variants: &'static [Variant],
        entries: &[Entry],
        path: &str,
        origin: &Origin,
    ) -> Checked {
        let known = || variants.iter().map(|v| v.choice.name);
        let full = join(path, tag);
        let Some(entry) = entries.iter().find(|e| e.key == tag) else {
            self.fault(origin, full, None, format!("required key is missing: {}", names(known())));
            return Checked::Invalid;
        };
        let Value::Text(name) = &entry.node.value else {
            self.wrong(&entry.node, &full, &format!("must be {}", names(known())));
            return Checked::Invalid;
        };
        let Some(variant) = variants.iter().find(|v| v.choice.name == name) else {
            self.fault(&entry.node.origin, full, Some(entry.node.shown()), format!("unknown {tag}"));
            self.faults.amend_last(|fault| {
                fault.suggestion = meant(name, variants.iter().map(|v| (v.choice.name, v.choice.elsewhere)));
                fault.known = format!("known are {}", names(known()));
            });
            return Checked::Invalid;
        };
        let mut section = self.section(variant.keys, entries, path, origin, Some(tag));
        let (value, origin, shown) =
            (Checked::Text(name.clone()), entry.node.origin.clone(), entry.node.shown());
        section.items.insert(0, Item { given: true, ..Item::new(tag, value, origin, shown) });
        Checked::Table(section)
    }

    fn choice(&mut self, choices: &[Choice], word: &str, node: &Node, path: &str) -> Option<Checked> {
        if choices.iter().any(|c| c.name == word) {
            return Some(Checked::Text(word.to_owned()));
        }
        let message = format!("must be {}", names(choices.iter().map(|c| c.name)));
        self.fault(&node.origin, path.to_owned(), Some(node.shown()), message);
        self.faults.amend_last(|fault| {
            fault.suggestion = meant(word, choices.iter().map(|c| (c.name, c.elsewhere)));
        });
        None
    }

    fn choices(&mut self, choices: &[Choice], items: &[Node], path: &str) -> Option<Checked> {
        let mut chosen: Vec<String> = Vec::with_capacity(items.len());
        for (i, item) in items.iter().enumerate() {
            let path = format!("{path}[{i}]");
            let Value::Text(word) = &item.value else {
                self.wrong(item, &path, "must be a string");
                return None;
            };
            let Checked::Text(word) = self.choice(choices, word, item, &path)? else { return None };
            if chosen.contains(&word) {
                self.fault(&item.origin, path, Some(item.shown()), "stands in the list already".into());
                return None;
            }
            chosen.push(word);
        }
        Some(Checked::Names(chosen))
    }

    fn counts(&mut self, key: &Key, node: &Node, path: &str, min: u64, max: u64) -> Option<Checked> {
        let Value::Array(items) = &node.value else {
            return integer_in(node, min, max).map(|i| Checked::Counts(vec![i]));
        };
        if !matches!(items.len(), 2 | 3) {
            return None;
        }
        let good: Vec<u64> = items.iter().filter_map(|n| integer_in(n, min, max)).collect();
        for (i, n) in items.iter().enumerate().filter(|(_, n)| integer_in(n, min, max).is_none()) {
            self.wrong(n, &format!("{path}[{i}]"), &format!("must be {}", key.kind.allowed("")));
        }
        (good.len() == items.len()).then_some(Checked::Counts(good))
    }

    fn numbers(
        &mut self,
        key: &Key,
        items: &[Node],
        range: &Range,
        path: &str,
        scale: f64,
    ) -> Option<Checked> {
        self.row(key, items, range, path, scale).map(Checked::Numbers)
    }

    fn row(&mut self, key: &Key, items: &[Node], range: &Range, path: &str, scale: f64) -> Option<Vec<f64>> {
        let mut good = Vec::with_capacity(items.len());
        for (i, n) in items.iter().enumerate() {
            match number_in(n, range, scale) {
                Some(x) => good.push(x),
                None => {
                    let unit = self.unit(key);
                    let message = allowed_number(range, &unit, scale < 1.0 || is_in_degrees(n));
                    self.wrong(n, &format!("{path}[{i}]"), &format!("must be {message}"));
                }
            }
        }
        (good.len() == items.len()).then_some(good)
    }

    fn lists(&mut self, key: &Key, rows: &[Node], range: &Range, path: &str) -> Option<Checked> {
        let mut good = Vec::with_capacity(rows.len());
        for (i, row) in rows.iter().enumerate() {
            let path = format!("{path}[{i}]");
            let fits = |n: usize| match key.kind {
                Kind::Points(_) => matches!(n, 2 | 3),
                Kind::Symmetric(_) => n == 3,
                _ => true,
            };
            match &row.value {
                Value::Array(items) if fits(items.len()) => {
                    good.extend(self.row(key, items, range, &path, 1.0));
                }
                _ => self.wrong(row, &path, &format!("must be part of {}", key.kind.allowed(key.unit))),
            }
        }
        (good.len() == rows.len()).then_some(Checked::Lists(good))
    }
}

/// Whether `node` holds numbers of this kind, which may have a unit; a text alone may be a name.
fn takes_units(kind: &Kind, node: &Node) -> bool {
    let is_text = matches!(node.value, Value::Text(_));
    match kind {
        Kind::Number(_) | Kind::Numbers(_) | Kind::NumberOrVariants { .. } | Kind::ChoiceOrNumber(..) => true,
        Kind::Vector(..) | Kind::Point(_) | Kind::List(_) | Kind::Lists(_) | Kind::Points(_) => true,
        Kind::Symmetric(_) | Kind::Rotation | Kind::Place(_) => !is_text,
        _ => false,
    }
}

fn matches_key(key: &Key, name: &str) -> bool {
    name == key.name || (key.degrees && name.strip_suffix("_deg") == Some(key.name))
}

/// What is allowed of `key`, whose unit is `unit`, in words that follow "must be".
fn allowed(key: &Key, unit: &str, in_degrees: bool) -> String {
    match (&key.kind, in_degrees) {
        (Kind::Rotation, true) => "a rotation vector of 3 numbers in degrees".into(),
        (Kind::Number(range), _) => allowed_number(range, unit, in_degrees),
        (kind, true) => kind.allowed(&unit.replace("rad", "deg")),
        (kind, false) => kind.allowed(unit),
    }
}

/// A number in `range` of the unit `unit`, in degrees where the number at fault is.
fn allowed_number(range: &Range, unit: &str, in_degrees: bool) -> String {
    match in_degrees {
        true => Kind::Number(range.times(1.0 / DEGREE)).allowed(&unit.replace("rad", "deg")),
        false => Kind::Number(*range).allowed(unit),
    }
}

/// Whether the number at `node` was given in degrees.
fn is_in_degrees(node: &Node) -> bool {
    matches!(&node.value, Value::Measured(_, text) if text.contains("deg") || text.contains('°'))
}

fn invalid(key: &Key, origin: &Origin) -> Item {
    Item { when: key.when, ..Item::new(key.name, Checked::Invalid, origin.clone(), String::new()) }
}

fn text(node: &Node) -> Option<String> {
    match &node.value {
        Value::Text(text) => Some(text.clone()),
        _ => None,
    }
}

fn number(node: &Node) -> Option<f64> {
    match node.value {
        // Integers beyond 2^53 lose digits that no physical quantity has.
        #[expect(clippy::cast_precision_loss, reason = "no scenario number has 16 digits")]
        Value::Integer(i) => Some(i as f64),
        Value::Float(x) | Value::Measured(x, _) => Some(x),
        _ => None,
    }
}

fn number_in(node: &Node, range: &Range, scale: f64) -> Option<f64> {
    number(node).map(|x| x * scale).filter(|x| x.is_finite() && range.contains(*x))
}

fn integer_in(node: &Node, min: u64, max: u64) -> Option<u64> {
    match node.value {
        Value::Integer(i) => u64::try_from(i).ok().filter(|i| (min..=max).contains(i)),
        _ => None,
    }
}
