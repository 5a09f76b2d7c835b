//! What an input file joins: `*TIE`, `*COUPLING`, `*KINEMATIC COUPLING`, `*RIGID BODY` and beams of `*MPC`.

use std::collections::HashSet;

use super::super::text::fields;
use super::card::Card;
use crate::mesh::tie::{Joined, Tie};

/// Ties as they are read.
#[derive(Debug, Default)]
pub struct Ties {
    list: Vec<Tie>,
}

impl Ties {
    /// Begins a card, at `place`; `false` if it joins nothing.
    pub fn begin(&mut self, card: &Card, place: String) -> bool {
        let tie = |name: Option<&str>, is_rigid: bool, joined: Vec<Joined>| {
            let name =
                name.filter(|name| !name.is_empty()).map(|name| format!(" \"{name}\"")).unwrap_or_default();
            Tie { card: format!("*{}{name} ({place})", card.name).into(), is_rigid, joined }
        };
        let node = || card.get("REF NODE").map(|node| Joined::Node(node.to_owned()));
        let set = |key: &str| card.get(key).map(|set| Joined::Group(set.to_owned()));
        match card.name.as_str() {
            // Sectors that repeat are no parts of one body.
            "TIE" if ["CYCLIC SYMMETRY", "MULTISTAGE"].iter().any(|key| card.get(key).is_some()) => {
                return false;
            }
            // Both faces deform, alike.
            "TIE" => self.list.push(tie(card.get("NAME"), false, Vec::new())),
            "MPC" => self.list.push(tie(None, true, Vec::new())),
            "COUPLING" => {
                let joined = set("SURFACE").into_iter().chain(node()).collect();
                self.list.push(tie(card.get("CONSTRAINT NAME"), true, joined));
            }
            "KINEMATIC COUPLING" => self.list.push(tie(None, true, node().into_iter().collect())),
            "RIGID BODY" => {
                let sets = ["NSET", "TIE NSET", "PIN NSET"].iter().find_map(|key| set(key));
                self.list.push(tie(None, true, sets.into_iter().chain(node()).collect()));
            }
            // What kind of coupling the one before is.
            "KINEMATIC" | "DISTRIBUTING" => {
                if let Some(last) = self.list.last_mut() {
                    last.is_rigid = card.name == "KINEMATIC";
                }
            }
            _ => return false,
        }
        true
    }

    /// A line of data of a card that joins something.
    pub fn data(&mut self, card: &Card, text: &str) {
        let mut all = fields(text).map(str::to_owned);
        let Some(last) = self.list.last_mut() else { return };
        let again = |last: &Tie| Tie { joined: Vec::new(), ..last.clone() };
        match card.name.as_str() {
            "TIE" => {
                let (Some(slave), Some(master)) = (all.next(), all.next()) else { return };
                let joined = vec![Joined::Group(slave), Joined::Group(master)];
                let tie = Tie { joined, ..again(last) };
                self.list.push(tie);
            }
            "MPC" => {
                let kind = all.next().unwrap_or_default().to_ascii_uppercase();
                let joined: Vec<Joined> = all.map(named).collect();
                if matches!(kind.as_str(), "BEAM" | "TIE") && joined.len() == 2 {
                    let tie = Tie { joined, ..again(last) };
                    self.list.push(tie);
                }
            }
            "KINEMATIC COUPLING" => {
                if let Some(set) = all.next().filter(|_| last.joined.len() < 2) {
                    last.joined.push(named(set));
                }
            }
            _ => {}
        }
    }

    /// Those that join two things, and the cards, with their places, of which none does.
    pub fn finish(self) -> (Vec<Tie>, Vec<String>) {
        let (ties, rest): (Vec<Tie>, Vec<Tie>) = self.list.into_iter().partition(|tie| tie.joined.len() > 1);
        let known: HashSet<&str> = ties.iter().map(|tie| &*tie.card).collect();
        let left =
            rest.iter().filter(|tie| !known.contains(&*tie.card)).map(|tie| tie.card.to_string()).collect();
        (ties, left)
    }
}

/// A node by its number, a set by its name.
fn named(field: String) -> Joined {
    match field.parse::<u64>() {
        Ok(_) => Joined::Node(field),
        Err(_) => Joined::Group(field),
    }
}
