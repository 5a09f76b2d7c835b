//! What a file joins, for who makes joints of it.

use std::sync::Arc;

/// What moves together in a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tie {
    /// The card, with its name and place.
    pub card: Arc<str>,
    /// Whether what it names moves like a rigid body; by its mean motion otherwise.
    pub is_rigid: bool,
    /// What it joins, two things at least.
    pub joined: Vec<Joined>,
}

/// One of the things that a tie joins, by the name that the file has for it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Joined {
    /// A surface or a set of nodes.
    Group(String),
    /// A node, with its instance if it has one.
    Node(String),
}

impl std::fmt::Display for Joined {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Group(name) => write!(f, "\"{name}\""),
            Self::Node(name) => write!(f, "node {name}"),
        }
    }
}

impl std::fmt::Display for Tie {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let names: Vec<String> = self.joined.iter().map(Joined::to_string).collect();
        write!(f, "{}: {}", self.card, names.join(" to "))
    }
}
