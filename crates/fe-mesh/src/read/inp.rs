//! Input files of Abaqus and CalculiX: flat, or with one part and one instance of it.

mod card;
mod axes;

use std::collections::{HashMap, HashSet};

use self::axes::Axes;
use self::card::{Card, Type, element_type};
use super::labels::Labels;
use super::skipped::Skipped;
use crate::element::kind::ElementKind;
use crate::fault::{MeshError, Place, ReadFault};
use crate::mesh::raw::{FaceSource, NO_NODE, RawMesh};

/// Cards whose data say nothing of the mesh, left out without a word.
const SILENT: &[&str] = &["HEADING", "PREPRINT", "RESTART"];
/// Cards that delimit the part of the file that has the mesh.
const FRAMES: &[&str] = &["ASSEMBLY", "END ASSEMBLY", "END STEP"];
/// Cards that make nodes and elements, or move them.
const MAKERS: &[&str] =
    &["NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "IMPERFECTION", "SYMMETRIC MODEL GENERATION"];
/// What to do about them.
const MAKE: &str = "write a file in which every node and element stands with its numbers";
/// Characters of a wrong field that a message shows.
const SHOWN: usize = 40;
/// Bytes of the file for each member that its sets have in all: a file has two numbers and more for
/// each node and element, so that each may be in several sets.
const BYTES_A_MEMBER: usize = 4;
/// Members that any file may have.
const FEW: usize = 200;
/// Members that a set counts for by itself, for the memory of its name and place.
const SET: usize = 8;

/// Sets of one kind, by name in capitals.
#[derive(Default)]
struct Sets {
    places: HashMap<String, usize>,
    list: Vec<(String, Vec<u32>)>,
}

impl Sets {
    fn get(&self, name: &str) -> Option<&[u32]> {
        self.places.get(&name.to_ascii_uppercase()).map(|&i| self.list[i].1.as_slice())
    }

    /// The members of a set, which is made if there is none of that name.
    fn of(&mut self, name: &str) -> &mut Vec<u32> {
        let list = &mut self.list;
        let place = *self.places.entry(name.to_ascii_uppercase()).or_insert_with(|| {
            list.push((name.to_owned(), Vec::new()));
            list.len() - 1
        });
        &mut self.list[place].1
    }
}

#[derive(Default)]
struct Reader {
    mesh: RawMesh,
    node_numbers: Labels,
    element_numbers: Labels,
    /// Numbers of all elements, of solids first their place; sides count behind them.
    node_sets: Sets,
    element_sets: Sets,
    /// Surface elements by set.
    side_sets: Vec<(String, Vec<[u32; 4]>)>,
    skipped: Skipped,
    reduced: Option<(String, usize)>,
    /// Whether elements were left out.
    has_other: bool,
    is_sorted: bool,
    /// Elements whose numbers are known.
    n_sorted: usize,
    /// Whether the part or instance with the mesh has ended: what follows are reference points and
    /// the like.
    is_closed: bool,
    members: usize,
    limit: usize,
    parts: usize,
    instances: usize,
    axes: Axes,
}

/// Reads a file.
pub fn read(bytes: &[u8]) -> Result<RawMesh, MeshError> {
    let mut reader = Reader { limit: bytes.len() / BYTES_A_MEMBER + FEW, ..Reader::default() };
    let mut lines = bytes.split(|b| *b == b'\n').map(|l| l.trim_ascii()).zip(1..).peekable();
    let mut card = Card::default();
    while let Some((bytes, line)) = lines.next() {
        let text = String::from_utf8_lossy(bytes);
        if text.is_empty() || text.starts_with("**") {
            continue;
        }
        if text.starts_with('*') {
            let mut text = text.into_owned();
            // A card goes on where its line ends with a comma.
            while text.ends_with(',') {
                while lines.next_if(|(next, _)| next.starts_with(b"**")).is_some() {}
                match lines.next_if(|(next, _)| !next.starts_with(b"*")) {
                    Some((next, _)) => text.push_str(&String::from_utf8_lossy(next)),
                    None => break,
                }
            }
            card = Card::new(&text, line);
            reader.begin(&card)?;
            if card.name == "STEP" {
                break; // the mesh is complete before the first step
            }
            continue;
        }
        if card.name.is_empty() {
            return fail(line, ReadFault::Format);
        }
        if reader.is_closed && matches!(card.name.as_str(), "NODE" | "ELEMENT") {
            continue;
        }
        if card.name == "ELEMENT" && card.get("TYPE").is_some() {
            let mut given = Given::default();
            let wanted = reader.nodes_wanted(&card, line)?;
            if wanted.is_some() {
                given.add(&text, line)?;
            }
            while wanted.is_some_and(|n| given.n < n + 1) {
                while lines.next_if(|(next, _)| next.starts_with(b"**") || next.is_empty()).is_some() {}
                let Some((next, at)) = lines.next_if(|(next, _)| !next.starts_with(b"*")) else {
                    return fail(line, ReadFault::End { section: "an element".into() });
                };
                given.add(&String::from_utf8_lossy(next), at)?;
            }
            reader.element(&card, line, &given)?;
        } else {
            reader.data(&card, line, &text)?;
        }
    }
    reader.finish()
}

fn fail<T>(line: usize, fault: ReadFault) -> Result<T, MeshError> {
    Err(MeshError::Read { place: Place::Line(line), fault })
}

fn fields(text: &str) -> impl Iterator<Item = &str> {
    text.split(',').map(str::trim).filter(|f| !f.is_empty())
}

fn expected<T>(line: usize, expected: &str, found: &str) -> Result<T, MeshError> {
    let found = found.chars().take(SHOWN).collect();
    fail(line, ReadFault::Expected { expected: expected.to_owned(), found })
}

/// A number of a node or element; the name of an instance may stand before it.
fn number(field: &str) -> Option<u64> {
    field.rsplit('.').next().unwrap_or(field).parse().ok()
}

/// Numbers of an element: its own and those of its nodes.
#[derive(Default)]
struct Given {
    values: [u64; ElementKind::MAX_NODES + 1],
    /// How many fields there are, which may be more than an element has.
    n: usize,
}

impl Given {
    fn add(&mut self, text: &str, line: usize) -> Result<(), MeshError> {
        // A line that goes on ends with a comma; no other field may be empty.
        for field in text.strip_suffix(',').unwrap_or(text).split(',').map(str::trim) {
            if let Some(value) = self.values.get_mut(self.n) {
                *value = match number(field) {
                    Some(value) => value,
                    None => return expected(line, "the number of a node or element", field),
                };
            }
            self.n += 1;
        }
        Ok(())
    }
}

impl Reader {
    fn begin(&mut self, card: &Card) -> Result<(), MeshError> {
        let line = card.line;
        let refuse =
            |what: &str, remedy| fail(line, ReadFault::Unsupported { what: what.to_owned(), remedy });
        match card.name.as_str() {
            "PART" => {
                self.parts += 1;
                if self.parts > 1 {
                    return refuse("a second *PART", "write each part into a file of its own");
                }
                Ok(())
            }
            "INSTANCE" => {
                self.instances += 1;
                if self.instances > 1 {
                    return refuse("a second *INSTANCE", "write each part into a file of its own");
                }
                Ok(())
            }
            "END PART" | "END INSTANCE" => {
                self.is_closed |= !self.mesh.nodes.is_empty();
                Ok(())
            }
            "NODE" | "ELEMENT" if self.is_closed => {
                self.skipped.note(&format!("*{} of the assembly", card.name), Place::Line(line));
                Ok(())
            }
            "INCLUDE" => refuse("*INCLUDE", "put the mesh into one file"),
            name if MAKERS.contains(&name) => refuse(&format!("*{name}"), MAKE),
            "STEP" => Ok(()),
            "SYSTEM" => {
                self.axes.begin(line);
                Ok(())
            }
            "NODE" | "ELEMENT" | "NSET" | "ELSET" | "SURFACE" => self.begin_mesh(card),
            name if FRAMES.contains(&name) || SILENT.contains(&name) => Ok(()),
            name => {
                self.skipped.note(&format!("*{name}"), Place::Line(line));
                Ok(())
            }
        }
    }

    fn begin_mesh(&mut self, card: &Card) -> Result<(), MeshError> {
        let line = card.line;
        let missing = |what: &str| {
            fail(
                line,
                ReadFault::Expected { expected: format!("*{} with {what}", card.name), found: String::new() },
            )
        };
        match card.name.as_str() {
            _ if ["INPUT", "FILE"].iter().any(|key| card.get(key).is_some()) => {
                let what = format!("*{} with data in another file", card.name);
                fail(line, ReadFault::Unsupported { what, remedy: "put the mesh into one file" })
            }
            "NODE" => self.axes.of_nodes(card),
            "ELEMENT" => {
                let Some(name) = card.get("TYPE") else { return missing("TYPE=") };
                self.sort_nodes(line)?;
                let Some(found) = element_type(&name.to_ascii_uppercase()) else {
                    let what = format!("element type {name}");
                    let remedy = "computed are C3D4, C3D10, C3D8, C3D20, C3D27, C3D6, C3D15, C3D5, C3D13";
                    return fail(line, ReadFault::Unsupported { what, remedy });
                };
                let has_letter = name.ends_with(|c: char| c.is_ascii_alphabetic());
                if matches!(found, Type::Solid(_)) && has_letter && self.reduced.is_none() {
                    self.reduced = Some((name.to_owned(), line));
                }
                Ok(())
            }
            "NSET" if card.get("NSET").is_none() => missing("NSET="),
            "ELSET" if card.get("ELSET").is_none() => missing("ELSET="),
            "SURFACE" if card.get("NAME").is_none() => missing("NAME="),
            "NSET" => {
                self.sort_nodes(line)?;
                match card.get("ELSET") {
                    Some(elements) => self.nodes_of(card, elements),
                    None => Ok(()),
                }
            }
            "ELSET" | "SURFACE" => {
                self.sort_nodes(line)?;
                self.sort_elements(line)?;
                if card.name == "SURFACE" {
                    let name = card.get("NAME").unwrap_or_default().to_owned();
                    let is_nodes = card.get("TYPE").is_some_and(|t| t.eq_ignore_ascii_case("NODE"));
                    let source =
                        if is_nodes { FaceSource::Nodes(Vec::new()) } else { FaceSource::Sides(Vec::new()) };
                    self.count(line, SET)?;
                    self.mesh.faces.push((name, source));
                }
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// Makes the set of the nodes of all elements of another set.
    fn nodes_of(&mut self, card: &Card, elements: &str) -> Result<(), MeshError> {
        let name = card.get("NSET").unwrap_or_default();
        let Some(all) = self.element_sets.get(elements) else {
            let user = format!("set \"{name}\"");
            return fail(card.line, ReadFault::UnknownSet { user, set: elements.to_owned() });
        };
        let mut nodes: Vec<u32> =
            all.iter().flat_map(|&e| self.mesh.elements.get(e as usize).nodes).copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        self.count(card.line, nodes.len() + SET)?;
        self.node_sets.of(name).extend(nodes);
        Ok(())
    }

    /// Makes numbers of nodes known.
    fn sort_nodes(&mut self, line: usize) -> Result<(), MeshError> {
        if !self.is_sorted {
            self.node_numbers = match Labels::new(&self.mesh.node_labels) {
                Ok(labels) => labels,
                Err(number) => return fail(line, ReadFault::Twice { what: "node", number }),
            };
            self.is_sorted = true;
        }
        Ok(())
    }

    fn sort_elements(&mut self, line: usize) -> Result<(), MeshError> {
        if self.n_sorted == self.mesh.elements.len() {
            return Ok(());
        }
        self.n_sorted = self.mesh.elements.len();
        let labels: Vec<u64> = self.mesh.elements.iter().map(|e| e.label).collect();
        self.element_numbers = match Labels::new(&labels) {
            Ok(labels) => labels,
            Err(number) => return fail(line, ReadFault::Twice { what: "element", number }),
        };
        Ok(())
    }

    fn nodes_wanted(&self, card: &Card, line: usize) -> Result<Option<usize>, MeshError> {
        let name = card.get("TYPE").unwrap_or_default().to_ascii_uppercase();
        match element_type(&name) {
            Some(Type::Solid(kind)) => Ok(Some(kind.n_nodes())),
            Some(Type::Side(_, n)) => Ok(Some(n)),
            Some(Type::Other) => Ok(None),
            None => expected(line, "an element type", &name),
        }
    }

    fn element(&mut self, card: &Card, line: usize, given: &Given) -> Result<(), MeshError> {
        let name = card.get("TYPE").unwrap_or_default().to_ascii_uppercase();
        let set = card.get("ELSET");
        let n = match element_type(&name) {
            Some(Type::Solid(kind)) => kind.n_nodes(),
            Some(Type::Side(_, n)) => n,
            _ => {
                self.has_other = true;
                return Ok(());
            }
        };
        let Given { values, n: found } = given;
        if *found != n + 1 {
            let found = format!("{found} numbers");
            return expected(line, &format!("an element {name} with its number and {n} nodes"), &found);
        }
        let label = values[0];
        let mut nodes = [NO_NODE; ElementKind::MAX_NODES];
        for (place, &node) in nodes.iter_mut().zip(&values[1..=n]) {
            *place = match self.node_numbers.get(node) {
                Some(place) => place,
                None => {
                    let user = format!("element {label}");
                    return fail(line, ReadFault::UnknownNode { user, node });
                }
            };
        }
        match element_type(&name) {
            Some(Type::Solid(kind)) => {
                let e = self.mesh.elements.len() as u32;
                if kind == ElementKind::Hex27 {
                    // The centre stands before the middles of the sides.
                    nodes[20..27].rotate_left(1);
                }
                self.mesh.elements.push(kind, label, nodes[..n].iter().copied());
                if let Some(set) = set {
                    self.count_set(line, set, false)?;
                    self.element_sets.of(set).push(e);
                }
            }
            Some(Type::Side(n_corners, _)) => {
                let corners = std::array::from_fn(|i| if i < n_corners { nodes[i] } else { NO_NODE });
                let name = set.unwrap_or("surface elements");
                match self.side_sets.iter_mut().find(|(n, _)| n.eq_ignore_ascii_case(name)) {
                    Some((_, all)) => all.push(corners),
                    None => {
                        self.side_sets.push((name.to_owned(), vec![corners]));
                        self.count(line, SET)?;
                    }
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// Counts members of sets, which a short file can multiply.
    fn count(&mut self, line: usize, n: usize) -> Result<(), MeshError> {
        self.members = self.members.saturating_add(n);
        if self.members > self.limit {
            return fail(line, ReadFault::Members { limit: self.limit });
        }
        Ok(())
    }

    /// Counts a member of the set `name` and, if there is none yet, the set.
    fn count_set(&mut self, line: usize, name: &str, is_nodes: bool) -> Result<(), MeshError> {
        let sets = if is_nodes { &self.node_sets } else { &self.element_sets };
        self.count(line, if sets.get(name).is_some() { 1 } else { 1 + SET })
    }

    fn data(&mut self, card: &Card, line: usize, text: &str) -> Result<(), MeshError> {
        match card.name.as_str() {
            "NODE" => self.node(card, line, text),
            "SYSTEM" => self.axes.data(line, text),
            "NSET" => self.set(card, line, text, true),
            "ELSET" => self.set(card, line, text, false),
            "SURFACE" => self.surface(card, line, text),
            "INSTANCE" => {
                let is_moved = fields(text).any(|f| f.parse::<f64>().is_ok_and(|x| x != 0.0));
                if is_moved {
                    let what = "an *INSTANCE that is moved or turned".to_owned();
                    let remedy = "leave it where it is; `position` and `orientation` of the body move it";
                    return fail(line, ReadFault::Unsupported { what, remedy });
                }
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn node(&mut self, card: &Card, line: usize, text: &str) -> Result<(), MeshError> {
        self.is_sorted = false;
        let mut fields = text.split(',').map(str::trim);
        let first = fields.next().unwrap_or_default();
        let Some(label) = number(first) else { return expected(line, "the number of a node", first) };
        let mut at = [0.0; 3];
        // A coordinate that is left out is zero.
        for (x, field) in at.iter_mut().zip(fields).filter(|(_, field)| !field.is_empty()) {
            *x = match axes::real(field) {
                Some(x) => x,
                None => return expected(line, "a coordinate", field),
            };
        }
        let at = self.axes.place(line, at)?;
        if !at.iter().all(|x: &f64| x.is_finite()) {
            return fail(line, ReadFault::Coordinate { node: label });
        }
        if let Some(set) = card.get("NSET") {
            self.count_set(line, set, true)?;
            let place = self.mesh.nodes.len() as u32;
            self.node_sets.of(set).push(place);
        }
        self.mesh.nodes.push(at);
        self.mesh.node_labels.push(label);
        Ok(())
    }

    /// Members of a set: numbers, names of other sets, or first, last and step.
    fn set(&mut self, card: &Card, line: usize, text: &str, is_nodes: bool) -> Result<(), MeshError> {
        let name = card.get(&card.name).unwrap_or_default().to_owned();
        let labels = if is_nodes { &self.node_numbers } else { &self.element_numbers };
        let sets = if is_nodes { &self.node_sets } else { &self.element_sets };
        let mut found: Vec<u32> = Vec::new();
        let room = self.limit.saturating_sub(self.members);
        if card.get("GENERATE").is_some() {
            let mut values = [0u64, 0, 1];
            for (value, field) in values.iter_mut().zip(fields(text)) {
                *value = match number(field) {
                    Some(value) => value,
                    None => return expected(line, "first, last and step of a set", field),
                };
            }
            let [first, last, step] = values;
            found.extend(labels.range(first, last.max(first), step).take(room + 1));
        } else {
            for field in fields(text) {
                match number(field) {
                    // Elements that are left out have numbers, too.
                    Some(label) => found.extend(labels.get(label)),
                    None => match sets.get(field) {
                        Some(all) => found.extend(all.iter().take((room + 1).saturating_sub(found.len()))),
                        None => {
                            let user = format!("set \"{name}\"");
                            return fail(line, ReadFault::UnknownSet { user, set: field.to_owned() });
                        }
                    },
                }
            }
        }
        let is_new = sets.get(&name).is_none();
        self.count(line, found.len() + if is_new { SET } else { 0 })?;
        (if is_nodes { &mut self.node_sets } else { &mut self.element_sets }).of(&name).extend(found);
        Ok(())
    }

    /// A line of a surface: an element or a set of them with the number of a side, or nodes.
    fn surface(&mut self, card: &Card, line: usize, text: &str) -> Result<(), MeshError> {
        let name = card.get("NAME").unwrap_or_default().to_owned();
        let user = || format!("surface \"{name}\"");
        let mut given = fields(text);
        let first = given.next().unwrap_or_default();
        let side = given.next();
        let is_nodes = matches!(self.mesh.faces.last(), Some((_, FaceSource::Nodes(_))));
        let (labels, sets) = if is_nodes {
            (&self.node_numbers, &self.node_sets)
        } else {
            (&self.element_numbers, &self.element_sets)
        };
        let members: Vec<u32> = match number(first) {
            Some(label) => labels.get(label).into_iter().collect(),
            None => match sets.get(first) {
                Some(all) => {
                    let room = self.limit.saturating_sub(self.members);
                    all.iter().copied().take(room + 1).collect()
                }
                None => return fail(line, ReadFault::UnknownSet { user: user(), set: first.to_owned() }),
            },
        };
        self.count(line, members.len())?;
        match self.mesh.faces.last_mut() {
            Some((_, FaceSource::Nodes(all))) => all.extend(members),
            Some((_, FaceSource::Sides(all))) => {
                let number = side.and_then(|s| s.to_ascii_uppercase().strip_prefix('S')?.parse::<u8>().ok());
                let Some(number) = number.filter(|n| (1..=6).contains(n)) else {
                    return expected(line, "the number of a side, S1 to S6,", side.unwrap_or_default());
                };
                all.extend(members.into_iter().map(|e| (e, number - 1)));
            }
            _ => {}
        }
        Ok(())
    }

    fn finish(mut self) -> Result<RawMesh, MeshError> {
        if self.mesh.nodes.is_empty() {
            let fault = ReadFault::Missing { what: "*NODE", remedy: "write the nodes into the file" };
            return fail(1, fault);
        }
        self.sort_nodes(1)?;
        self.sort_elements(1)?;
        let (volumes, faces) = (&mut self.mesh.volumes, &mut self.mesh.faces);
        volumes.extend(self.element_sets.list.into_iter().filter(|(_, all)| !all.is_empty()).map(
            |(name, mut all)| {
                all.sort_unstable();
                all.dedup();
                (name, all)
            },
        ));
        faces.extend(self.side_sets.into_iter().map(|(name, all)| (name, FaceSource::Corners(all))));
        let known: HashSet<String> = faces.iter().map(|(name, _)| name.clone()).collect();
        let nodes = self.node_sets.list.into_iter().filter(|(name, _)| !known.contains(name));
        faces.extend(nodes.map(|(name, all)| (name, FaceSource::Nodes(all))));
        if let Some(all) = self.skipped.list() {
            self.mesh.notes.push(format!(
                "cards that are not read: {all}; material and supports are those of the scenario"
            ));
        }
        if let Some((name, line)) = self.reduced {
            self.mesh.notes.push(format!(
                "element type {name} (line {line}) is computed with full integration and displacements alone"
            ));
        }
        if self.has_other {
            self.mesh.notes.push("trusses and beams are left out".to_owned());
        }
        Ok(self.mesh)
    }
}
