//! A table after the check against its keys: defaults filled in, every value of the right type or
//! marked as invalid.

use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::ops::{Deref, DerefMut};
use std::rc::Rc;
use std::sync::Arc;

use result_files::toml_text::document::Origin;
use result_files::toml_text::fault::{Fault, nearest};

use super::body_source::{BodySource, MeshSource, SplineSource};
use super::keys::{Condition, Named, names};

/// Faults of a scenario in the order in which they were found, one list for all its tables.
#[derive(Debug, Clone, Default)]
pub struct FaultList(Rc<RefCell<Vec<Fault>>>);

impl FaultList {
    /// Adds `fault`.
    pub fn push(&self, fault: Fault) {
        self.0.borrow_mut().push(fault);
    }

    /// Adds a fault at `origin`.
    pub fn tell(&self, origin: &Origin, key: String, value: Option<String>, message: String) {
        let location = origin.location(&Origin::Default);
        self.push(Fault { location, key, value, message, suggestion: None, known: String::new() });
    }

    /// Says more of the last one.
    pub fn amend_last(&self, more: impl FnOnce(&mut Fault)) {
        if let Some(last) = self.0.borrow_mut().last_mut() {
            more(last);
        }
    }

    /// Their number.
    pub fn len(&self) -> usize {
        self.0.borrow().len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.borrow().is_empty()
    }

    /// Moves the first `count` of those behind the first `from` to the end.
    pub fn move_back(&self, from: usize, count: usize) {
        self.0.borrow_mut()[from..].rotate_left(count);
    }

    /// All of them, which leaves none.
    pub fn take(&self) -> Vec<Fault> {
        self.0.take()
    }
}

/// A checked table.
#[derive(Debug, Clone)]
pub struct Section {
    /// Dotted path; empty for the top level.
    pub path: String,
    /// Where the table stands.
    pub origin: Origin,
    /// Its items, in the order of the key table.
    pub items: Vec<Item>,
    /// Unit of the quantity over time that the table describes; empty of other tables.
    pub quantity: &'static str,
    /// Where its faults go.
    pub faults: FaultList,
}

/// A checked value.
#[derive(Debug, Clone)]
pub struct Item {
    /// Key.
    pub name: &'static str,
    /// What must hold for the key to have a meaning.
    pub when: &'static [Condition],
    /// Value.
    pub value: Checked,
    /// Where it stands; for defaults, where their table stands.
    pub origin: Origin,
    /// The value as written, for messages.
    pub shown: String,
    /// Units of keys in which its numbers were given, by their places, where the unit of the key
    /// depends on another key.
    pub units: Vec<(usize, &'static str)>,
    /// Whether the user gave it.
    pub given: bool,
    /// Whether in degrees, under the key with that ending.
    pub in_degrees: bool,
    /// Whether it was asked for.
    pub asked: Cell<bool>,
}

impl Item {
    /// The value of key `name` that holds in any case and that nobody gave, from `origin`.
    pub fn new(name: &'static str, value: Checked, origin: Origin, shown: String) -> Self {
        Self {
            name,
            when: &[],
            value,
            origin,
            shown,
            units: Vec::new(),
            given: false,
            in_degrees: false,
            asked: Cell::default(),
        }
    }
}

/// Named tables in the order of the file, found by name as fast among thousands as among two.
#[derive(Debug, Clone)]
pub struct NamedSections {
    list: Vec<(String, Section)>,
    places: HashMap<String, usize>,
}

impl NamedSections {
    /// Tables with names that differ.
    pub fn new(list: Vec<(String, Section)>) -> Self {
        let places = list.iter().enumerate().map(|(place, (name, _))| (name.clone(), place)).collect();
        Self { list, places }
    }
}

impl Deref for NamedSections {
    type Target = [(String, Section)];

    fn deref(&self) -> &Self::Target {
        &self.list
    }
}

impl DerefMut for NamedSections {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.list
    }
}

/// A value whose type has been checked.
#[derive(Debug, Clone)]
pub enum Checked {
    /// String.
    Text(String),
    /// `true` or `false`.
    Boolean(bool),
    /// Number.
    Number(f64),
    /// Non-negative integer.
    Integer(u64),
    /// Numbers.
    Numbers(Vec<f64>),
    /// Lists of numbers.
    Lists(Vec<Vec<f64>>),
    /// One integer, or one per direction.
    Counts(Vec<u64>),
    /// Table.
    Table(Section),
    /// Named tables.
    Named(NamedSections),
    /// Array of tables.
    Tables(Vec<Section>),
    /// Path of a body file that has been read.
    BodyFile {
        /// The path as given.
        text: String,
        /// What is in the file.
        source: Arc<BodySource>,
    },
    /// Path of a mesh that has been read.
    MeshFile {
        /// The path as given.
        text: String,
        /// What is in the file.
        source: Arc<MeshSource>,
    },
    /// Path of a file of splines that has been read.
    SplineFile {
        /// The path as given.
        text: String,
        /// What is in the file.
        source: Arc<SplineSource>,
    },
    /// Some of a few names.
    Names(Vec<String>),
    /// Lists of names, by names.
    NameLists(Vec<(String, Vec<String>)>),
    /// Not usable; the fault has been reported.
    Invalid,
}

impl Checked {
    /// The same, a table being that of a quantity over time of the unit `unit`.
    pub fn of_quantity(self, unit: &'static str) -> Self {
        match self {
            Self::Table(table) => Self::Table(Section { quantity: unit, ..table }),
            other => other,
        }
    }

    /// The tables in it, with their names; the name of a single table and of those of an array is
    /// empty.
    pub fn subtables(&self) -> Vec<(&str, &Section)> {
        match self {
            Self::Table(section) => vec![("", section)],
            Self::Tables(list) => list.iter().map(|section| ("", section)).collect(),
            Self::Named(list) => list.iter().map(|(name, section)| (name.as_str(), section)).collect(),
            _ => Vec::new(),
        }
    }
}

/// What is given and cannot be used; the fault has been reported.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AtFault;

impl Section {
    /// Adds a fault at item `name`, or at the section if it has no such item.
    pub fn fault(&self, name: &str, message: impl Into<String>) {
        let (origin, value) = match self.item(name) {
            Some(item) => (&item.origin, Some(item.shown.clone())),
            None => (&self.origin, None),
        };
        self.faults.tell(origin, self.path_of(name), value, message.into());
    }

    /// The same of the whole section.
    pub fn fault_here(&self, message: impl Into<String>) {
        self.faults.tell(&self.origin, self.path.clone(), None, message.into());
    }

    /// A fault with which nothing can be made of the key.
    pub fn refuse<T>(&self, name: &str, message: impl Into<String>) -> Option<T> {
        self.fault(name, message);
        None
    }

    /// A fault unless the key `name` is there, which is `what`.
    pub fn require(&self, name: &str, what: &str) -> Option<()> {
        match self.item(name) {
            Some(_) => Some(()),
            None => self.refuse(name, format!("required key is missing: {what}")),
        }
    }

    /// Adds a fault for a name that is not among `known`.
    pub fn unknown_name(&self, name: &str, what: &str, known: &[&str]) {
        let Some(word) = self.text(name) else { return };
        self.fault(name, format!("unknown {what}"));
        self.faults.amend_last(|fault| {
            fault.suggestion = nearest(word, known.iter().copied());
            fault.known = format!("known are {}", names(known.iter().copied()));
        });
    }

    /// What `read` makes of the key `name`; none if the key is not there.
    ///
    /// # Errors
    /// [`AtFault`] if it makes nothing of it.
    pub fn optional<T>(
        &self,
        name: &str,
        read: impl FnOnce(&Self, &str) -> Option<T>,
    ) -> Result<Option<T>, AtFault> {
        match self.item(name) {
            Some(_) => read(self, name).map(Some).ok_or(AtFault),
            None => Ok(None),
        }
    }

    /// The item `name`, if it was given or has a default.
    pub fn item(&self, name: &str) -> Option<&Item> {
        self.items.iter().find(|i| i.name == name).inspect(|i| i.asked.set(true))
    }

    /// Keys that the user gave and nobody asked for, with their tables.
    pub fn unasked(&self) -> Vec<(&Self, &'static str)> {
        let (asked, unasked): (Vec<_>, Vec<_>) = self.items.iter().partition(|item| item.asked.get());
        let own = unasked.into_iter().filter(|item| item.given).map(|item| (self, item.name));
        let inner = asked.into_iter().flat_map(|item| item.value.subtables()).flat_map(|(_, t)| t.unasked());
        own.chain(inner).collect()
    }

    /// Whether the user gave `name`, valid or not.
    pub fn given(&self, name: &str) -> bool {
        self.item(name).is_some_and(|i| i.given)
    }

    /// Dotted path of `name` in this table, as it was given.
    pub fn path_of(&self, name: &str) -> String {
        let in_degrees = self.items.iter().any(|item| item.name == name && item.in_degrees);
        join(&self.path, &if in_degrees { format!("{name}_deg") } else { name.to_owned() })
    }

    /// A string.
    pub fn text(&self, name: &str) -> Option<&str> {
        match &self.item(name)?.value {
            Checked::Text(s)
            | Checked::BodyFile { text: s, .. }
            | Checked::MeshFile { text: s, .. }
            | Checked::SplineFile { text: s, .. } => Some(s),
            _ => None,
        }
    }

    /// One of a few names.
    pub fn choice<T: Named>(&self, name: &str) -> Option<T> {
        T::named(self.text(name)?)
    }

    /// Some of a few names.
    pub fn names(&self, name: &str) -> Option<&[String]> {
        match &self.item(name)?.value {
            Checked::Names(names) => Some(names),
            _ => None,
        }
    }

    /// A boolean.
    pub fn boolean(&self, name: &str) -> Option<bool> {
        match self.item(name)?.value {
            Checked::Boolean(b) => Some(b),
            _ => None,
        }
    }

    /// A number.
    pub fn number(&self, name: &str) -> Option<f64> {
        match self.item(name)?.value {
            Checked::Number(x) => Some(x),
            _ => None,
        }
    }

    /// An integer.
    pub fn integer(&self, name: &str) -> Option<usize> {
        match self.item(name)?.value {
            Checked::Integer(i) => usize::try_from(i).ok(),
            _ => None,
        }
    }

    /// Numbers.
    pub fn numbers(&self, name: &str) -> Option<&[f64]> {
        match &self.item(name)?.value {
            Checked::Numbers(v) => Some(v),
            _ => None,
        }
    }

    /// Exactly `N` numbers.
    pub fn vector<const N: usize>(&self, name: &str) -> Option<[f64; N]> {
        self.numbers(name)?.try_into().ok()
    }

    /// Lists of numbers.
    pub fn lists(&self, name: &str) -> Option<&[Vec<f64>]> {
        match &self.item(name)?.value {
            Checked::Lists(v) => Some(v),
            _ => None,
        }
    }

    /// One integer, or one per direction.
    pub fn counts(&self, name: &str) -> Option<Vec<usize>> {
        match &self.item(name)?.value {
            Checked::Counts(v) => v.iter().map(|&i| usize::try_from(i).ok()).collect(),
            _ => None,
        }
    }

    /// What is in the body file of key `file`.
    pub fn body_file(&self) -> Option<&Arc<BodySource>> {
        match &self.item("file")?.value {
            Checked::BodyFile { source, .. } => Some(source),
            _ => None,
        }
    }

    /// What is in the mesh of key `file`.
    pub fn mesh_file(&self) -> Option<&Arc<MeshSource>> {
        match &self.item("file")?.value {
            Checked::MeshFile { source, .. } => Some(source),
            _ => None,
        }
    }

    /// What is in the file of splines of key `file`.
    pub fn spline_file(&self) -> Option<&Arc<SplineSource>> {
        match &self.item("file")?.value {
            Checked::SplineFile { source, .. } => Some(source),
            _ => None,
        }
    }

    /// Lists of names, by names; none if there is no such key.
    pub fn name_lists(&self, name: &str) -> &[(String, Vec<String>)] {
        match self.item(name).map(|i| &i.value) {
            Some(Checked::NameLists(lists)) => lists,
            _ => &[],
        }
    }

    /// A table.
    pub fn table(&self, name: &str) -> Option<&Section> {
        match &self.item(name)?.value {
            Checked::Table(t) => Some(t),
            _ => None,
        }
    }

    /// Named tables; none if there is no such key.
    pub fn named(&self, name: &str) -> &[(String, Section)] {
        match self.item(name).map(|i| &i.value) {
            Some(Checked::Named(list)) => list,
            _ => &[],
        }
    }

    /// Place of the table `name` among the named tables of `key`.
    pub fn place_of(&self, key: &str, name: &str) -> Option<usize> {
        match &self.item(key)?.value {
            Checked::Named(list) => list.places.get(name).copied(),
            _ => None,
        }
    }

    /// The table `name` among the named tables of `key`.
    pub fn one_of(&self, key: &str, name: &str) -> Option<&Section> {
        let place = self.place_of(key, name)?;
        self.named(key).get(place).map(|(_, section)| section)
    }

    /// Array of tables; none if there is no such key.
    pub fn tables(&self, name: &str) -> &[Section] {
        match self.item(name).map(|i| &i.value) {
            Some(Checked::Tables(list)) => list,
            _ => &[],
        }
    }
}

/// `path.name`, or `name` at the top level; names of other characters than those of keys stand in quotes.
pub fn join(path: &str, name: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    let name = if !name.is_empty() && name.chars().all(is_plain) {
        name.to_owned()
    } else {
        format!("\"{}\"", name.replace('\\', "\\\\").replace('"', "\\\""))
    };
    if path.is_empty() { name } else { format!("{path}.{name}") }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use result_files::toml_text::document::{self, SourceText, Value};

    use super::super::check::Checker;
    use super::super::keys::{Key, Kind, Range};

    const fn number(name: &'static str) -> Key {
        Key::measured(name, Kind::Number(Range::within(9.0)), "m")
    }
    const INNER: &[Key] = &[number("d"), number("e")];
    const KEYS: &[Key] = &[
        number("a"),
        number("b"),
        number("c").default("3.0"),
        Key::new("inner", Kind::Table(INNER)),
        Key::new("each", Kind::Named(INNER)),
    ];

    #[test]
    fn given_keys_that_nobody_asks_for_are_told() {
        let text = "a = 1.0\nb = 2.0\ninner = { d = 1.0, e = 2.0 }\neach.x = { d = 1.0, e = 2.0 }\n";
        let source = Arc::new(SourceText { name: "s.toml".to_owned(), text: text.to_owned() });
        let document = document::parse_toml(&source).unwrap();
        let Value::Table(entries) = &document.value else { unreachable!("a TOML document is a table") };
        let mut checker = Checker::default();
        let section = checker.section(KEYS, entries, "", &document.origin, None);
        assert!(checker.faults.is_empty());

        let told = || section.unasked().iter().map(|(table, key)| table.path_of(key)).collect::<Vec<_>>();
        assert_eq!(
            told(),
            ["a", "b", "inner", "each"],
            "of a table that nobody asks for its keys are not told"
        );
        section.number("b").unwrap();
        section.table("inner").unwrap().number("d").unwrap();
        let x = &section.named("each")[0].1;
        assert_eq!(told(), ["a", "inner.e", "each.x.d", "each.x.e"]);
        x.number("d").unwrap();
        x.number("e").unwrap();
        section.number("a").unwrap();
        section.table("inner").unwrap().number("e").unwrap();
        assert_eq!(told(), [""; 0], "nobody gave c");
    }
}
