//! Whether a key has a meaning where it stands: the conditions of its declaration, asked of the
//! checked tables.

use super::build::{ContactFacts, inboard_joint};
use super::keys::{Condition, Fact, Test};
use super::section::{Checked, Item, Section};
use super::tables::Search;
use crate::interchange::body_file::BodyFile;

/// A table in its surroundings.
#[derive(Debug, Clone, Copy)]
pub struct Scope<'a> {
    /// The whole scenario.
    pub root: &'a Section,
    /// The table.
    pub section: &'a Section,
    /// The table around it; none around the whole scenario.
    pub around: Option<&'a Section>,
}

/// Reports keys that are given where they have no meaning.
pub fn check(scope: Scope<'_>) {
    for item in &scope.section.items {
        match scope.unmet(item) {
            Some(condition) if item.given => {
                let found = scope.found(&condition.test).map_or(String::new(), |found| format!("; {found}"));
                let message =
                    format!("has a meaning {} only{}{found}", condition.words, condition.behind_comma());
                scope.section.fault(item.name, message);
            }
            Some(_) => {}
            None => item.value.subtables().into_iter().for_each(|(_, t)| check(scope.inner(t))),
        }
    }
}

impl<'a> Scope<'a> {
    /// The whole scenario.
    pub fn of(root: &'a Section) -> Self {
        Self { root, section: root, around: None }
    }

    /// A table in this one.
    pub fn inner(self, section: &'a Section) -> Self {
        Self { root: self.root, section, around: Some(self.section) }
    }

    /// The first condition of `item` that does not hold.
    pub fn unmet(self, item: &Item) -> Option<&'static Condition> {
        item.when.iter().find(|condition| !self.holds(&condition.test))
    }

    fn holds(self, test: &Test) -> bool {
        match *test {
            Test::OneOf(key, values) => match self.item(key).map(|item| &item.value) {
                Some(Checked::Text(value)) => values.contains(&value.as_str()),
                Some(_) => true,
                None => false,
            },
            Test::NoneOf(key, values) => match self.item(key).map(|item| &item.value) {
                Some(Checked::Text(value)) => !values.contains(&value.as_str()),
                _ => true,
            },
            Test::IsFalse(key) => self.section.boolean(key) != Some(true),
            Test::With(key) => self.section.given(key),
            Test::Without(key) => !self.section.given(key),
            Test::Any(tests) => tests.iter().any(|test| self.holds(test)),
            Test::All(tests) => tests.iter().all(|test| self.holds(test)),
            Test::Around(test) => self.outer().is_none_or(|outer| outer.holds(test)),
            Test::Fact(fact) => self.is_fact(fact),
        }
    }

    fn is_fact(self, fact: Fact) -> bool {
        let contact = || self.around.and_then(|contact| ContactFacts::of(self.root, contact));
        match fact {
            Fact::IsChildOfNoJoint => self.joint().is_none(),
            Fact::IsNotReduced => {
                !self.section.body_file().is_some_and(|file| matches!(file.body, BodyFile::Reduced(_)))
            }
            Fact::IsRefined => contact().is_none_or(|facts| facts.is_refined()),
            Fact::IsOnSplines => {
                !ContactFacts::of(self.root, self.section).is_some_and(|facts| facts.has_mesh)
            }
            Fact::IsOnFlexible => {
                !ContactFacts::of(self.root, self.section).is_some_and(|facts| facts.is_rigid)
            }
            Fact::SearchConverges => {
                contact().is_none_or(|facts| facts.search == Some(Search::UntilConverged))
            }
        }
    }

    /// What the test met in place of what it asks for, where that tells something.
    fn found(self, test: &Test) -> Option<String> {
        match *test {
            Test::OneOf(key, _) | Test::NoneOf(key, _) => match &self.item(key)?.value {
                Checked::Text(value) => Some(format!("here {key} = {value:?}")),
                _ => None,
            },
            Test::Around(test) => self.outer()?.found(test),
            Test::Fact(Fact::IsChildOfNoJoint) => {
                Some(format!("this one is the child of joint \"{}\"", self.joint()?))
            }
            _ => None,
        }
    }

    /// The table around this one, as far as tests need its surroundings.
    fn outer(self) -> Option<Self> {
        Some(Self { section: self.around?, around: None, ..self })
    }

    /// The item at `key`, a name or that of a subtable and a name in it.
    fn item(self, key: &str) -> Option<&'a Item> {
        match key.split_once('.') {
            Some((table, name)) => self.section.table(table)?.item(name),
            None => self.section.item(key),
        }
    }

    /// Name of the joint whose child the body of the table is.
    fn joint(self) -> Option<&'a str> {
        inboard_joint(self.root, self.section.path.strip_prefix("bodies.")?)
    }
}
