//! One part of an input file: nodes, elements, sets and surfaces as they come.

use std::collections::HashSet;

use super::super::labels::Labels;
use super::super::sets::{Room, Sets};
use super::super::text::{expected, fail, fields, real};
use super::axes::{Axes, Movement};
use super::card::{Card, Type};
use crate::element::jacobian::{minus, norm};
use crate::element::kind::ElementKind;
use crate::fault::{MeshError, ReadFault};
use crate::mesh::raw::{FaceSource, NO_NODE, RawMesh};

/// Marks the number of an element on the surface among those of solids.
const SIDE: u32 = 1 << 31;
/// Most nodes of an element on the surface.
const SIDE_NODES: usize = 8;
/// Set of the surface elements that are in none.
const UNNAMED: &str = "surface elements";

/// An element that is a side of another, or may be a plane element of the body.
#[derive(Debug)]
struct Flat {
    found: Type,
    label: u64,
    nodes: [u32; SIDE_NODES],
}

impl Flat {
    fn nodes(&self) -> impl Iterator<Item = u32> {
        self.nodes.iter().copied().filter(|n| *n != NO_NODE)
    }

    /// Its corners as those of a side; of a line the two of its nodes that are farthest apart, since programs
    /// differ in where its middle stands.
    fn corners(&self, nodes: &[[f64; 3]]) -> [u32; 4] {
        let n = match self.found {
            Type::Line(_) => {
                let apart = |[a, b]: &[u32; 2]| norm(&minus(&nodes[*a as usize], &nodes[*b as usize]));
                let own: Vec<u32> = self.nodes().collect();
                let pairs = own.iter().flat_map(|a| own.iter().map(move |b| [*a, *b]));
                let ends = pairs.max_by(|a, b| apart(a).total_cmp(&apart(b))).unwrap_or([NO_NODE; 2]);
                return [ends[0], ends[1], NO_NODE, NO_NODE];
            }
            Type::Plane(kind, _) => kind.n_corners(),
            _ if matches!(self.nodes().count(), 4 | 8) => 4,
            _ => 3,
        };
        std::array::from_fn(|i| if i < n { self.nodes[i] } else { NO_NODE })
    }
}

/// A surface.
#[derive(Debug)]
struct Surface {
    name: String,
    is_of_nodes: bool,
    nodes: Vec<u32>,
    sides: Vec<(u32, u8)>,
    /// Surface elements, with the number of a side that plane elements of a body have.
    elements: Vec<(u32, Option<u8>)>,
}

/// Names of the part itself when those of the assembly are read.
#[derive(Debug)]
struct Inner {
    /// Name of the instance.
    instance: String,
    /// Names of all of them.
    instances: Vec<String>,
    sets: [Sets; 2],
    n_surfaces: usize,
}

/// A part.
#[derive(Debug, Default)]
pub struct Part {
    pub name: String,
    mesh: RawMesh,
    node_numbers: Labels,
    is_sorted: bool,
    element_labels: Vec<u64>,
    element_numbers: Labels,
    n_sorted: usize,
    /// Of every element in the order of the file, the place among solids or surface elements.
    ids: Vec<u32>,
    /// Surface elements, plane ones and lines.
    sides: Vec<Flat>,
    /// Sets of nodes and of elements.
    sets: [Sets; 2],
    surfaces: Vec<Surface>,
    inner: Option<Inner>,
}

/// Members that a set can have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Of {
    Nodes,
    Elements,
}

/// Numbers of an element: its own and those of its nodes.
#[derive(Default)]
pub struct Given {
    values: [u64; ElementKind::MAX_NODES + 1],
    /// How many fields there are, which may be more than an element has.
    pub n: usize,
}

impl Given {
    /// Adds those of a line.
    pub fn add(&mut self, text: &str, line: usize) -> Result<(), MeshError> {
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

fn number(field: &str) -> Option<u64> {
    field.parse().ok()
}

/// What a field of a set names.
enum Named<'a> {
    Number(u64),
    Set(&'a [u32]),
    /// Something of another instance, or of the assembly.
    Elsewhere,
}

impl Part {
    /// A part without anything.
    pub fn named(name: &str) -> Self {
        Self { name: name.to_owned(), ..Self::default() }
    }

    /// Whether nothing has been read.
    pub fn is_empty(&self) -> bool {
        self.mesh.nodes.is_empty() && self.ids.is_empty()
    }

    /// Whether it has solid elements.
    pub fn is_solid(&self) -> bool {
        !self.mesh.elements.is_empty() || self.sides.iter().any(|flat| matches!(flat.found, Type::Plane(..)))
    }

    /// The part as `instance`, one of `instances`, moved; sets and surfaces that follow are those of the assembly.
    pub fn placed(mut self, instance: &str, instances: Vec<String>, movement: &Movement) -> Self {
        movement.apply(&mut self.mesh.nodes);
        let (sets, n_surfaces) = (std::mem::take(&mut self.sets), self.surfaces.len());
        self.inner = Some(Inner { instance: instance.to_owned(), instances, sets, n_surfaces });
        self
    }

    /// Makes numbers of nodes known.
    pub fn sort_nodes(&mut self, line: usize) -> Result<(), MeshError> {
        if !self.is_sorted {
            self.node_numbers = match Labels::new(&self.mesh.node_labels) {
                Ok(labels) => labels,
                Err(number) => return fail(line, ReadFault::Twice { what: "node", number }),
            };
            self.is_sorted = true;
        }
        Ok(())
    }

    /// Makes numbers of elements known.
    pub fn sort_elements(&mut self, line: usize) -> Result<(), MeshError> {
        if self.n_sorted < self.ids.len() {
            self.n_sorted = self.ids.len();
            self.element_numbers = match Labels::new(&self.element_labels) {
                Ok(labels) => labels,
                Err(number) => return fail(line, ReadFault::Twice { what: "element", number }),
            };
        }
        Ok(())
    }

    /// A line of `*NODE`.
    pub fn node(
        &mut self,
        (card, room): (&Card, &mut Room),
        (line, text): (usize, &str),
        axes: &mut Axes,
    ) -> Result<(), MeshError> {
        self.is_sorted = false;
        let mut fields = text.split(',').map(str::trim);
        let first = fields.next().unwrap_or_default();
        let Some(label) = number(first) else { return expected(line, "the number of a node", first) };
        let mut at = [0.0; 3];
        // A coordinate that is left out is zero.
        for (x, field) in at.iter_mut().zip(fields).filter(|(_, field)| !field.is_empty()) {
            *x = match real(field) {
                Some(x) => x,
                None => return expected(line, "a coordinate", field),
            };
        }
        let at = axes.place(line, at)?;
        if !at.iter().all(|x: &f64| x.is_finite()) {
            return fail(line, ReadFault::Coordinate { node: label });
        }
        if let Some(set) = card.get("NSET") {
            self.sets[0].add(room, line, set, &[self.mesh.nodes.len() as u32])?;
        }
        self.mesh.nodes.push(at);
        self.mesh.node_labels.push(label);
        Ok(())
    }

    /// An element of `*ELEMENT`, of the type `found` with `n` nodes.
    pub fn element(
        &mut self,
        (card, room): (&Card, &mut Room),
        line: usize,
        (found, n): (Type, usize),
        given: &Given,
    ) -> Result<(), MeshError> {
        let label = given.values[0];
        let mut nodes = [NO_NODE; ElementKind::MAX_NODES];
        for (place, &node) in nodes.iter_mut().zip(&given.values[1..=n]) {
            *place = match self.node_numbers.get(node) {
                Some(place) => place,
                // Lines beside a part may lead anywhere.
                None if matches!(found, Type::Line(_)) => NO_NODE,
                None => {
                    let user = format!("element {label}");
                    return fail(line, ReadFault::UnknownNode { user, node });
                }
            };
        }
        let mut set = card.get("ELSET");
        let id = match found {
            Type::Solid(kind) => {
                if kind == ElementKind::Hex27 {
                    // The centre stands before the middles of the sides.
                    nodes[20..27].rotate_left(1);
                }
                self.mesh.elements.push(kind, label, nodes[..n].iter().copied());
                self.mesh.elements.len() as u32 - 1
            }
            Type::Side(_) | Type::Plane(..) | Type::Line(_) | Type::Other => {
                set = set.or(Some(UNNAMED));
                self.sides.push(Flat { found, label, nodes: std::array::from_fn(|i| nodes[i]) });
                (self.sides.len() as u32 - 1) | SIDE
            }
        };
        self.ids.push(id);
        self.element_labels.push(label);
        match set {
            Some(set) => self.sets[1].add(room, line, set, &[id]),
            None => Ok(()),
        }
    }

    /// What `field` of `card` names; none for a set that is not there.
    fn find(&self, card: &Card, field: &str, of: Of) -> Option<Named<'_>> {
        let Some(Inner { instance, instances, sets, .. }) = &self.inner else {
            return number(field)
                .map(Named::Number)
                .or_else(|| Some(Named::Set(self.sets[of as usize].get(field)?)));
        };
        let is = |a: &str, b: &str| a.eq_ignore_ascii_case(b);
        let divided = |name: &String| {
            let (owner, rest) = field.split_at_checked(name.len())?;
            is(owner, name).then_some((owner, rest.strip_prefix('.')?))
        };
        let (owner, field) = match instances.iter().find_map(divided) {
            Some((owner, rest)) => (Some(owner), rest),
            None => (card.get("INSTANCE"), field),
        };
        match (owner, number(field)) {
            (Some(owner), _) if !is(owner, instance) => Some(Named::Elsewhere),
            // Numbers without an instance are those of reference points.
            (None, Some(_)) => Some(Named::Elsewhere),
            (Some(_), Some(number)) => Some(Named::Number(number)),
            (Some(_), None) => Some(Named::Set(sets[of as usize].get(field)?)),
            (None, None) => Some(Named::Set(self.sets[of as usize].get(field)?)),
        }
    }

    /// Place of the node or element with the number `label`.
    fn labelled(&self, label: u64, of: Of) -> Option<u32> {
        match of {
            Of::Nodes => self.node_numbers.get(label),
            Of::Elements => self.element_numbers.get(label).map(|i| self.ids[i as usize]),
        }
    }

    /// Members that `field` names, at most one more than there is room for, added to `found`.
    fn members(&self, card: &Card, (field, of): (&str, Of), most: usize, found: &mut Vec<u32>) -> bool {
        match self.find(card, field, of) {
            None => return false,
            // Elements that are left out have numbers, too.
            Some(Named::Number(label)) => found.extend(self.labelled(label, of)),
            Some(Named::Set(all)) => found.extend(all.iter().take((most + 1).saturating_sub(found.len()))),
            Some(Named::Elsewhere) => {}
        }
        true
    }

    /// A line of `*NSET` or `*ELSET`: numbers, names of other sets, or first, last and step.
    pub fn set(
        &mut self,
        (card, room): (&Card, &mut Room),
        (line, text): (usize, &str),
        of: Of,
    ) -> Result<(), MeshError> {
        let name = card.get(&card.name).unwrap_or_default();
        let mut found: Vec<u32> = Vec::new();
        if card.get("GENERATE").is_some() {
            let mut values = [0u64, 0, 1];
            for (value, field) in values.iter_mut().zip(fields(text)) {
                let field = field.rsplit('.').next().unwrap_or(field);
                *value = match number(field) {
                    Some(value) => value,
                    None => return expected(line, "first, last and step of a set", field),
                };
            }
            let [first, last, step] = values;
            if let Some(Named::Number(_)) = self.find(card, fields(text).next().unwrap_or_default(), of) {
                let labels = if of == Of::Nodes { &self.node_numbers } else { &self.element_numbers };
                let all = labels.range(first, last.max(first), step).take(room.left() + 1);
                found.extend(all.map(|i| if of == Of::Nodes { i } else { self.ids[i as usize] }));
            }
        } else {
            for field in fields(text) {
                if !self.members(card, (field, of), room.left(), &mut found) {
                    let user = format!("set \"{name}\"");
                    return fail(line, ReadFault::UnknownSet { user, set: field.to_owned() });
                }
            }
        }
        self.sets[of as usize].add(room, line, name, &found)
    }

    /// A set of elements that are left out.
    pub fn name_set(&mut self, name: &str, room: &mut Room, line: usize) -> Result<(), MeshError> {
        self.sets[1].add(room, line, name, &[])
    }

    /// Begins a set, which is there even if it gets no members; that of the nodes of all elements of
    /// another set has them at once.
    pub fn begin_set(&mut self, (card, room): (&Card, &mut Room), of: Of) -> Result<(), MeshError> {
        let name = card.get(&card.name).unwrap_or_default();
        let mut nodes: Vec<u32> = Vec::new();
        if let (Some(elements), Of::Nodes) = (card.get("ELSET"), of) {
            let mut all = Vec::new();
            if !self.members(card, (elements, Of::Elements), usize::MAX - 1, &mut all) {
                let user = format!("set \"{name}\"");
                return fail(card.line, ReadFault::UnknownSet { user, set: elements.to_owned() });
            }
            for id in all {
                match id & SIDE {
                    0 => nodes.extend(self.mesh.elements.get(id as usize).nodes),
                    _ => nodes.extend(self.sides[(id ^ SIDE) as usize].nodes()),
                }
            }
            nodes.sort_unstable();
            nodes.dedup();
        }
        self.sets[of as usize].add(room, card.line, name, &nodes)
    }

    /// Begins a surface.
    pub fn begin_surface(&mut self, card: &Card, room: &mut Room) -> Result<(), MeshError> {
        room.take_set(card.line)?;
        let name = card.get("NAME").unwrap_or_default().to_owned();
        let is_of_nodes = card.get("TYPE").is_some_and(|t| t.eq_ignore_ascii_case("NODE"));
        self.surfaces.push(Surface {
            name,
            is_of_nodes,
            nodes: Vec::new(),
            sides: Vec::new(),
            elements: Vec::new(),
        });
        Ok(())
    }

    /// A line of a surface: an element or a set of them with the number of a side, or nodes.
    pub fn surface(
        &mut self,
        (card, room): (&Card, &mut Room),
        line: usize,
        text: &str,
    ) -> Result<(), MeshError> {
        let mut given = fields(text);
        let (first, side) = (given.next().unwrap_or_default(), given.next().unwrap_or_default());
        let is_of_nodes = self.surfaces.last().is_some_and(|s| s.is_of_nodes);
        let of = if is_of_nodes { Of::Nodes } else { Of::Elements };
        let mut members = Vec::new();
        if !self.members(card, (first, of), room.left(), &mut members) {
            let user = format!("surface \"{}\"", card.get("NAME").unwrap_or_default());
            return fail(line, ReadFault::UnknownSet { user, set: first.to_owned() });
        }
        room.take(line, members.len())?;
        let Some(surface) = self.surfaces.last_mut() else { return Ok(()) };
        if is_of_nodes {
            surface.nodes.extend(members);
            return Ok(());
        }
        let number = side.to_ascii_uppercase().strip_prefix('S').and_then(|s| s.parse::<u8>().ok());
        let number = number.filter(|n| (1..=6).contains(n));
        for id in members {
            match number {
                _ if id & SIDE != 0 => surface.elements.push((id ^ SIDE, number.map(|n| n - 1))),
                Some(number) => surface.sides.push((id, number - 1)),
                None => return expected(line, "the number of a side, S1 to S6,", side),
            }
        }
        Ok(())
    }

    /// Corners of surface elements.
    fn corners(&self, all: impl Iterator<Item = u32>) -> Vec<[u32; 4]> {
        all.map(|id| self.sides[id as usize].corners(&self.mesh.nodes)).collect()
    }

    /// Makes the plane elements those of the body if there are no solids; the place of each of the surface
    /// elements among them.
    fn plane_body(&mut self) -> Vec<Option<u32>> {
        let is_plane = self.mesh.elements.is_empty();
        let mut places = vec![None; self.sides.len()];
        for (flat, place) in self.sides.iter().zip(&mut places).filter(|_| is_plane) {
            let Type::Plane(kind, model) = flat.found else { continue };
            *place = Some(self.mesh.elements.len() as u32);
            self.mesh.stated.get_or_insert(model);
            self.mesh.elements.push(kind, flat.label, flat.nodes().take(kind.n_nodes()));
        }
        places
    }

    /// The mesh. Names of the part that the assembly has as well stand with the instance before them.
    pub fn finish(mut self) -> Result<RawMesh, MeshError> {
        if self.mesh.nodes.is_empty() {
            let fault = ReadFault::Missing { what: "*NODE", remedy: "write the nodes into the file" };
            return fail(1, fault);
        }
        self.sort_nodes(1)?;
        self.sort_elements(1)?;
        let mut sets = std::mem::take(&mut self.sets).map(Sets::into_list);
        if let Some(Inner { instance, sets: of_part, n_surfaces, .. }) = self.inner.take() {
            let outside: HashSet<String> =
                self.surfaces[n_surfaces..].iter().map(|s| s.name.to_ascii_uppercase()).collect();
            let qualified = |name: &mut String, is_taken: bool| {
                if is_taken {
                    *name = format!("{instance}.{name}");
                }
            };
            for surface in &mut self.surfaces[..n_surfaces] {
                let is_taken = outside.contains(&surface.name.to_ascii_uppercase());
                qualified(&mut surface.name, is_taken);
            }
            for (all, of_part) in sets.iter_mut().zip(of_part.map(Sets::into_list)) {
                all.retain(|(_, members)| !members.is_empty());
                let known: HashSet<String> = all.iter().map(|(name, _)| name.to_ascii_uppercase()).collect();
                let inner = of_part.into_iter().map(|(mut name, members)| {
                    let is_taken = known.contains(&name.to_ascii_uppercase());
                    qualified(&mut name, is_taken);
                    (name, members)
                });
                all.extend(inner);
            }
        }
        let [of_nodes, of_elements] = sets;
        let own = self.plane_body();
        let is_plane = self.mesh.stated.is_some();
        let (mut volumes, mut faces) = (Vec::new(), Vec::new());
        for surface in std::mem::take(&mut self.surfaces) {
            let Surface { name, is_of_nodes, nodes, mut sides, mut elements } = surface;
            elements.retain(|(id, number)| match (own[*id as usize], number) {
                (Some(e), Some(number)) => {
                    sides.push((e, *number));
                    false
                }
                (own, _) => own.is_none(),
            });
            if !elements.is_empty() {
                let corners = self.corners(elements.into_iter().map(|(id, _)| id));
                faces.push((name.clone(), FaceSource::Corners(corners)));
            }
            faces.push((name, if is_of_nodes { FaceSource::Nodes(nodes) } else { FaceSource::Sides(sides) }));
        }
        for (name, mut all) in of_elements {
            all.sort_unstable();
            all.dedup();
            let mut sides = all.split_off(all.partition_point(|id| id & SIDE == 0));
            sides.retain(|id| {
                let place = (id ^ SIDE) as usize;
                all.extend(own[place]);
                // Lines are sides of plane elements alone.
                let is_read = is_plane || !matches!(self.sides[place].found, Type::Line(_));
                own[place].is_none() && is_read
            });
            if !sides.is_empty() {
                let corners = self.corners(sides.into_iter().map(|id| id ^ SIDE));
                faces.push((name.clone(), FaceSource::Corners(corners)));
            }
            if !all.is_empty() {
                volumes.push((name, all));
            }
        }
        let known: HashSet<String> = faces.iter().map(|(name, _)| name.clone()).collect();
        let of_nodes = of_nodes.into_iter().filter(|(name, _)| !known.contains(name));
        faces.extend(of_nodes.map(|(name, all)| (name, FaceSource::Nodes(all))));
        Ok(RawMesh { volumes, faces, ..self.mesh })
    }
}
