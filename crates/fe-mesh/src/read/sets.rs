//! Named sets of nodes and elements, whose members a short file can multiply.

use std::collections::HashMap;

use super::text::fail;
use crate::fault::{MeshError, ReadFault};

/// Bytes of a file for each member that its sets have in all: a file has two numbers and more for
/// each node and element, so that each may be in several sets.
const BYTES_A_MEMBER: usize = 4;
/// Members that any file may have.
const FEW: usize = 200;
/// Members that a set counts for by itself, for the memory of its name and place.
const SET: usize = 8;

/// How many members sets have, and may have.
#[derive(Debug)]
pub struct Room {
    used: usize,
    limit: usize,
}

impl Room {
    /// Room for what a file of so many bytes can name.
    pub fn of(bytes: usize) -> Self {
        Self { used: 0, limit: bytes / BYTES_A_MEMBER + FEW }
    }

    /// More of it for a file that is included.
    pub fn widen(&mut self, bytes: usize) {
        self.limit = self.limit.saturating_add(bytes / BYTES_A_MEMBER);
    }

    /// How many further members there may be.
    pub fn left(&self) -> usize {
        self.limit.saturating_sub(self.used)
    }

    /// Takes room for `n` members, named in line `line`.
    ///
    /// # Errors
    /// [`ReadFault::Members`].
    pub fn take(&mut self, line: usize, n: usize) -> Result<(), MeshError> {
        self.used = self.used.saturating_add(n);
        if self.used > self.limit {
            return fail(line, ReadFault::Members { limit: self.limit });
        }
        Ok(())
    }

    /// Takes room for a set.
    ///
    /// # Errors
    /// [`ReadFault::Members`].
    pub fn take_set(&mut self, line: usize) -> Result<(), MeshError> {
        self.take(line, SET)
    }
}

/// Sets of one kind, by name, capitals or not.
#[derive(Debug, Clone, Default)]
pub struct Sets {
    places: HashMap<String, usize>,
    list: Vec<(String, Vec<u32>)>,
}

impl Sets {
    /// The members of a set.
    pub fn get(&self, name: &str) -> Option<&[u32]> {
        self.places.get(&name.to_ascii_uppercase()).map(|&i| self.list[i].1.as_slice())
    }

    /// Adds members to a set, which is made if there is none of that name.
    ///
    /// # Errors
    /// [`ReadFault::Members`] at line `line`.
    pub fn add(&mut self, room: &mut Room, line: usize, name: &str, all: &[u32]) -> Result<(), MeshError> {
        room.take(line, all.len())?;
        let place = match self.places.get(&name.to_ascii_uppercase()) {
            Some(&place) => place,
            None => {
                room.take_set(line)?;
                self.list.push((name.to_owned(), Vec::new()));
                self.places.insert(name.to_ascii_uppercase(), self.list.len() - 1);
                self.list.len() - 1
            }
        };
        self.list[place].1.extend_from_slice(all);
        Ok(())
    }

    /// The sets in the order of the file.
    pub fn into_list(self) -> Vec<(String, Vec<u32>)> {
        self.list
    }
}
