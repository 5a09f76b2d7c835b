//! Gmsh's MSH 4.1, 4.0 and 2.2 (Gmsh reference manual, "Gmsh file formats").

use std::collections::{BTreeMap, HashMap, HashSet};

use super::labels::Labels;
use super::numbers::{Encoding, Numbers};
use super::skipped::Skipped;
use crate::element::kind::ElementKind;
use crate::fault::{MeshError, ReadFault};
use crate::mesh::raw::{Elements, FaceSource, NO_NODE, RawMesh};

/// What an element type of Gmsh is here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Type {
    /// An element of a body, or the side of one.
    Of(ElementKind),
    /// A line of this many nodes.
    Line(usize),
    /// A point, left out.
    Point,
}

const ORDER: &str = "only elements of the orders 1 and 2 are computed: gmsh -order 2";

/// Nodes of Gmsh's elements in the order of [`ElementKind`]: entry `i` is the place in Gmsh's list.
fn order(kind: ElementKind) -> Option<&'static [usize]> {
    match kind {
        ElementKind::Tet10 => Some(&[0, 1, 2, 3, 4, 5, 6, 7, 9, 8]),
        ElementKind::Hex20 => Some(&[0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15]),
        ElementKind::Hex27 => Some(&[
            0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15, 20, 25, 21, 23, 24, 22, 26,
        ]),
        ElementKind::Wedge15 => Some(&[0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11]),
        ElementKind::Wedge18 => Some(&[0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11, 15, 17, 16]),
        ElementKind::Pyramid13 => Some(&[0, 1, 2, 3, 4, 5, 8, 10, 6, 7, 9, 11, 12]),
        ElementKind::Pyramid14 => Some(&[0, 1, 2, 3, 4, 5, 8, 10, 6, 7, 9, 11, 12, 13]),
        ElementKind::Tet4 | ElementKind::Hex8 | ElementKind::Wedge6 | ElementKind::Pyramid5 => None,
        ElementKind::Tri3
        | ElementKind::Tri6
        | ElementKind::Quad4
        | ElementKind::Quad8
        | ElementKind::Quad9 => None,
    }
}

/// Number of an element type in Gmsh.
fn number(kind: ElementKind) -> i32 {
    match kind {
        ElementKind::Tet4 => 4,
        ElementKind::Tet10 => 11,
        ElementKind::Hex8 => 5,
        ElementKind::Hex20 => 17,
        ElementKind::Hex27 => 12,
        ElementKind::Wedge6 => 6,
        ElementKind::Wedge15 => 18,
        ElementKind::Wedge18 => 13,
        ElementKind::Pyramid5 => 7,
        ElementKind::Pyramid13 => 19,
        ElementKind::Pyramid14 => 14,
        ElementKind::Tri3 => 2,
        ElementKind::Tri6 => 9,
        ElementKind::Quad4 => 3,
        ElementKind::Quad8 => 16,
        ElementKind::Quad9 => 10,
    }
}

fn element_type(of_file: i32) -> Result<Type, (String, &'static str)> {
    if let Some(kind) = ElementKind::ALL.into_iter().find(|kind| number(*kind) == of_file) {
        return Ok(Type::Of(kind));
    }
    Ok(match of_file {
        15 => Type::Point,
        1 => Type::Line(2),
        8 => Type::Line(3),
        _ => return Err((format!("type {of_file} of Gmsh"), ORDER)),
    })
}

/// Physical group: dimension and number.
type Physical = (i32, i32);

/// Version of the format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Version {
    V22,
    V40,
    V41,
}

/// Elements of one dimension.
#[derive(Default)]
struct Layer {
    elements: Elements,
    groups: BTreeMap<i32, Vec<u32>>,
    /// Elements of version 2.2 by their first four nodes, with their group: an element stands there
    /// again for each further one.
    known: HashMap<[u32; 4], (u32, i32)>,
    /// Further groups of elements.
    further: HashSet<(u32, i32)>,
}

/// What has been read.
struct Reader {
    version: Version,
    mesh: RawMesh,
    labels: Labels,
    has_nodes: bool,
    has_elements: bool,
    names: HashMap<Physical, String>,
    /// Physical groups of geometric entities, by dimension and number.
    of_entity: HashMap<(i32, i32), Vec<i32>>,
    /// Plane elements, which are sides where there are solids, and solids.
    layers: [Layer; 2],
    /// Ends of lines by their physical group.
    lines: BTreeMap<i32, Vec<[u32; 4]>>,
    /// How often elements are in groups, and how often they may be: a short list of groups
    /// multiplies what is in them.
    members: usize,
    limit: usize,
    skipped: Skipped,
}

/// Bytes of the file for each group that elements are in: binary elements take 28 and more, so that
/// each may be in several; lists of them grow by doubling.
const BYTES_A_MEMBER: usize = 8;
/// Members that the groups of any file may have.
const FEW: usize = 200;

/// Reads a file.
pub fn read(bytes: &[u8]) -> Result<RawMesh, MeshError> {
    let mut numbers = Numbers::new(bytes);
    let version = format(&mut numbers)?;
    let mut reader = Reader {
        version,
        mesh: RawMesh::default(),
        labels: Labels::default(),
        has_nodes: false,
        has_elements: false,
        names: HashMap::new(),
        of_entity: HashMap::new(),
        layers: Default::default(),
        lines: BTreeMap::new(),
        members: 0,
        limit: bytes.len() / BYTES_A_MEMBER + FEW,
        skipped: Skipped::default(),
    };
    while let Some(word) = numbers.word() {
        let name = String::from_utf8_lossy(word.strip_prefix(b"$").unwrap_or(word)).into_owned();
        if !word.starts_with(b"$") {
            let fault = ReadFault::Expected { expected: "a section, $NAME,".into(), found: name };
            return numbers.fail(fault);
        }
        numbers.section = format!("${name}");
        reader.section(&mut numbers, &name)?;
    }
    numbers.section = "the file".into();
    if !reader.has_nodes {
        return numbers
            .fail(ReadFault::Missing { what: "$Nodes", remedy: "save the mesh, not the geometry" });
    }
    if !reader.has_elements {
        let remedy = "mesh in three dimensions (gmsh -3) and save the mesh";
        return numbers.fail(ReadFault::Missing { what: "$Elements", remedy });
    }
    Ok(reader.finish())
}

/// Reads the header.
fn format(numbers: &mut Numbers<'_>) -> Result<Version, MeshError> {
    match numbers.word() {
        Some(b"$MeshFormat") => {}
        Some(b"$Comments") => {
            numbers.leave("Comments")?;
            return format(numbers);
        }
        word => {
            let found = String::from_utf8_lossy(word.unwrap_or_default()).into_owned();
            return numbers.fail(ReadFault::Expected { expected: "$MeshFormat".into(), found });
        }
    }
    let version = String::from_utf8_lossy(numbers.word().unwrap_or_default()).into_owned();
    let known = match version.as_str() {
        "4.1" => Version::V41,
        "4.0" | "4" => Version::V40,
        "2.2" => Version::V22,
        _ => return numbers.fail(ReadFault::Version { found: version }),
    };
    let (is_binary, width) = (numbers.int()?, numbers.int()?);
    if width != 8 {
        let what = format!("a width of {width} bytes");
        return numbers.fail(ReadFault::Unsupported { what, remedy: "write it on a 64-bit machine" });
    }
    if is_binary == 1 {
        numbers.skip_line_break();
        numbers.encoding = Encoding::LittleEndian;
        match numbers.int()? {
            1 => {}
            0x0100_0000 => numbers.encoding = Encoding::BigEndian,
            other => {
                let (expected, found) = ("the integer 1 behind the header".into(), other.to_string());
                return numbers.fail(ReadFault::Expected { expected, found });
            }
        }
    }
    numbers.close("MeshFormat")?;
    Ok(known)
}

impl Reader {
    fn section(&mut self, numbers: &mut Numbers<'_>, name: &str) -> Result<(), MeshError> {
        let refuse = |remedy| ReadFault::Unsupported { what: format!("section ${name}"), remedy };
        let is_new = self.version != Version::V22;
        match name {
            "PhysicalNames" => self.physical_names(numbers)?,
            "Entities" if is_new => {
                numbers.skip_line_break();
                self.entities(numbers)?;
            }
            "Nodes" => {
                if std::mem::replace(&mut self.has_nodes, true) {
                    return numbers.fail(refuse("write one section of nodes"));
                }
                if is_new {
                    numbers.skip_line_break();
                    self.nodes_new(numbers)?;
                } else {
                    self.nodes_old(numbers)?;
                }
                self.labels = match Labels::new(&self.mesh.node_labels) {
                    Ok(labels) => labels,
                    Err(number) => return numbers.fail(ReadFault::Twice { what: "node", number }),
                };
            }
            "Elements" => {
                if !self.has_nodes {
                    let remedy = "write the nodes before the elements";
                    return numbers.fail(ReadFault::Missing { what: "$Nodes", remedy });
                }
                self.has_elements = true;
                if is_new {
                    numbers.skip_line_break();
                    self.elements_new(numbers)?;
                } else {
                    self.elements_old(numbers)?;
                }
            }
            "ParametricNodes" => return numbers.fail(refuse("switch Mesh.SaveParametric off")),
            "PartitionedEntities" => {
                return numbers.fail(refuse("save without partitions (Mesh.NbPartitions = 0)"));
            }
            _ => {
                if name != "Comments" {
                    self.skipped.note(&format!("${name}"), numbers.place());
                }
                return numbers.leave(name);
            }
        }
        numbers.close(name)
    }

    fn physical_names(&mut self, numbers: &mut Numbers<'_>) -> Result<(), MeshError> {
        // The names are text in binary files, too.
        for _ in 0..numbers.text_number()? {
            let mut number = || Ok::<_, MeshError>(i32::try_from(numbers.text_number()?).unwrap_or(i32::MAX));
            let group = (number()?, number()?);
            // Names that come from MED are filled up with blanks.
            let name = numbers.quoted()?.trim_end().to_owned();
            self.names.insert(group, name);
        }
        Ok(())
    }

    fn entities(&mut self, numbers: &mut Numbers<'_>) -> Result<(), MeshError> {
        let counts = [numbers.size()?, numbers.size()?, numbers.size()?, numbers.size()?];
        for (dimension, count) in (0i32..).zip(counts) {
            for _ in 0..count {
                let tag = numbers.int()?;
                for _ in 0..if dimension == 0 && self.version == Version::V41 { 3 } else { 6 } {
                    numbers.real()?;
                }
                for _ in 0..numbers.size()? {
                    let group = numbers.int()?;
                    self.of_entity.entry((dimension, tag)).or_default().push(group.saturating_abs());
                }
                if dimension > 0 {
                    for _ in 0..numbers.size()? {
                        numbers.int()?;
                    }
                }
            }
        }
        Ok(())
    }

    fn node(&mut self, numbers: &Numbers<'_>, node: u64, at: [f64; 3]) -> Result<(), MeshError> {
        if !at.iter().all(|x| x.is_finite()) {
            return numbers.fail(ReadFault::Coordinate { node });
        }
        self.mesh.nodes.push(at);
        self.mesh.node_labels.push(node);
        Ok(())
    }

    /// Number of blocks of nodes or elements.
    fn blocks(&self, numbers: &mut Numbers<'_>) -> Result<u64, MeshError> {
        let blocks = numbers.size()?;
        for _ in 0..if self.version == Version::V41 { 3 } else { 1 } {
            numbers.size()?;
        }
        Ok(blocks)
    }

    /// Dimension and number of the entity of a block, and the integer behind them.
    fn block(&self, numbers: &mut Numbers<'_>) -> Result<(i32, i32, i32), MeshError> {
        let (first, second, third) = (numbers.int()?, numbers.int()?, numbers.int()?);
        Ok(if self.version == Version::V41 { (first, second, third) } else { (second, first, third) })
    }

    fn nodes_new(&mut self, numbers: &mut Numbers<'_>) -> Result<(), MeshError> {
        let mut tags = Vec::new();
        for _ in 0..self.blocks(numbers)? {
            let (dimension, _, is_parametric) = self.block(numbers)?;
            let count = numbers.size()?;
            tags.clear();
            for _ in 0..if self.version == Version::V41 { count } else { 0 } {
                tags.push(numbers.size()?);
            }
            for i in 0..count {
                let tag = match tags.get(i as usize) {
                    Some(&tag) => tag,
                    None => Self::old_label(numbers)?,
                };
                let at = [numbers.real()?, numbers.real()?, numbers.real()?];
                self.node(numbers, tag, at)?;
                for _ in 0..if is_parametric == 0 { 0 } else { dimension.clamp(0, 3) } {
                    numbers.real()?;
                }
            }
        }
        Ok(())
    }

    fn nodes_old(&mut self, numbers: &mut Numbers<'_>) -> Result<(), MeshError> {
        let count = numbers.text_number()?;
        numbers.skip_line_break();
        for _ in 0..count {
            let tag = Self::old_label(numbers)?;
            let at = [numbers.real()?, numbers.real()?, numbers.real()?];
            self.node(numbers, tag, at)?;
        }
        Ok(())
    }

    /// Number of a node or element: before version 4.1 a small integer.
    fn old_label(numbers: &mut Numbers<'_>) -> Result<u64, MeshError> {
        let number = numbers.int()?;
        match u64::try_from(number) {
            Ok(label) => Ok(label),
            Err(_) => {
                let (expected, found) = ("the number of a node or element".into(), number.to_string());
                numbers.fail(ReadFault::Expected { expected, found })
            }
        }
    }

    fn elements_new(&mut self, numbers: &mut Numbers<'_>) -> Result<(), MeshError> {
        let is_long = self.version == Version::V41;
        let label = |n: &mut Numbers<'_>| if is_long { n.size() } else { Self::old_label(n) };
        for _ in 0..self.blocks(numbers)? {
            let (dimension, entity, number) = self.block(numbers)?;
            let count = numbers.size()?;
            let groups = self.of_entity.get(&(dimension, entity)).cloned().unwrap_or_default();
            for _ in 0..count {
                let own = label(numbers)?;
                self.element(numbers, (number, own), &groups, label)?;
            }
        }
        Ok(())
    }

    fn elements_old(&mut self, numbers: &mut Numbers<'_>) -> Result<(), MeshError> {
        let count = numbers.text_number()?;
        numbers.skip_line_break();
        let is_text = numbers.encoding == Encoding::Text;
        let node = |n: &mut Numbers<'_>| n.int().map(|i| u64::try_from(i).unwrap_or(u64::MAX));
        let mut done = 0;
        while done < count {
            if is_text {
                let (label, number, n_tags) = (Self::old_label(numbers)?, numbers.int()?, numbers.int()?);
                let groups = tags(numbers, n_tags)?;
                self.element(numbers, (number, label), &groups, node)?;
                done += 1;
                continue;
            }
            let (number, following, n_tags) = (numbers.int()?, numbers.int()?, numbers.int()?);
            for _ in 0..following {
                let label = Self::old_label(numbers)?;
                let groups = tags(numbers, n_tags)?;
                self.element(numbers, (number, label), &groups, node)?;
            }
            done += u64::try_from(following).unwrap_or(0).max(1);
        }
        Ok(())
    }

    /// Reads the nodes of an element of Gmsh's type `number` and keeps it.
    fn element(
        &mut self,
        numbers: &mut Numbers<'_>,
        (number, label): (i32, u64),
        groups: &[i32],
        mut next: impl FnMut(&mut Numbers<'_>) -> Result<u64, MeshError>,
    ) -> Result<(), MeshError> {
        let found = match element_type(number) {
            Ok(found) => found,
            Err((found, remedy)) => {
                return numbers.fail(ReadFault::Element { element: label, found, remedy });
            }
        };
        let n_nodes = match found {
            Type::Of(kind) => kind.n_nodes(),
            Type::Line(n) => n,
            Type::Point => 1,
        };
        let mut nodes = [NO_NODE; ElementKind::MAX_NODES];
        for place in &mut nodes[..n_nodes] {
            let node = next(numbers)?;
            *place = match self.labels.get(node) {
                Some(place) => place,
                None => {
                    let user = format!("element {label}");
                    return numbers.fail(ReadFault::UnknownNode { user, node });
                }
            };
        }
        if found != Type::Point {
            self.members = self.members.saturating_add(groups.len());
            if self.members > self.limit {
                return numbers.fail(ReadFault::Members { limit: self.limit });
            }
        }
        match found {
            Type::Of(kind) => {
                let layer = &mut self.layers[kind.dimension() - 2];
                if let (Version::V22, &[group]) = (self.version, groups)
                    && let Some(e) = layer.again(kind, &nodes, group)
                {
                    layer.groups.entry(group).or_default().push(e);
                    return Ok(());
                }
                let e = layer.elements.len() as u32;
                match order(kind) {
                    Some(order) => layer.elements.push(kind, label, order.iter().map(|&i| nodes[i])),
                    None => layer.elements.push(kind, label, nodes[..n_nodes].iter().copied()),
                }
                groups.iter().for_each(|group| layer.groups.entry(*group).or_default().push(e));
            }
            Type::Line(_) => {
                let ends = [nodes[0], nodes[1], NO_NODE, NO_NODE];
                groups.iter().for_each(|group| self.lines.entry(*group).or_default().push(ends));
            }
            Type::Point => {}
        }
        Ok(())
    }

    fn finish(self) -> RawMesh {
        let Self { mut mesh, names, layers: [plane, solid], lines, skipped, .. } = self;
        let name = |dimension, group: i32| {
            names.get(&(dimension, group)).cloned().unwrap_or_else(|| group.to_string())
        };
        let dimension = if solid.elements.is_empty() { 2 } else { 3 };
        let (own, faces) = if dimension == 2 { (plane, lines) } else { (solid, plane.sides()) };
        mesh.elements = own.elements;
        for (group, elements) in own.groups {
            let name = name(dimension, group);
            match mesh.volumes.iter_mut().find(|(n, _)| *n == name) {
                Some((_, all)) => all.extend(elements),
                None => mesh.volumes.push((name, elements)),
            }
        }
        for (_, elements) in &mut mesh.volumes {
            elements.sort_unstable();
            elements.dedup();
        }
        for (group, corners) in faces {
            mesh.faces.push((name(dimension - 1, group), FaceSource::Corners(corners)));
        }
        if let Some(all) = skipped.list() {
            mesh.notes.push(format!("sections that are not read: {all}"));
        }
        mesh
    }
}

impl Layer {
    /// The element of kind `kind` with the nodes `nodes` of Gmsh's list if it has been read, in
    /// another group than `group`.
    fn again(&mut self, kind: ElementKind, nodes: &[u32], group: i32) -> Option<u32> {
        let next = self.elements.len() as u32;
        let key = std::array::from_fn(|i| nodes[i]);
        let &mut (e, first) = self.known.entry(key).or_insert((next, group));
        if e == next || first == group {
            return None;
        }
        let known = self.elements.get(e as usize);
        let is_same = match order(kind) {
            Some(order) => order.iter().map(|&i| nodes[i]).eq(known.nodes.iter().copied()),
            None => nodes[..kind.n_nodes()] == *known.nodes,
        };
        (is_same && known.kind == kind && self.further.insert((e, group))).then_some(e)
    }

    /// The groups as sides, by their corners.
    fn sides(&self) -> BTreeMap<i32, Vec<[u32; 4]>> {
        let corners = |&e: &u32| self.elements.get(e as usize).corners();
        self.groups.iter().map(|(group, all)| (*group, all.iter().map(corners).collect())).collect()
    }
}

/// Tags of an element of version 2.2, of which the first is its physical group; 0 is none.
fn tags(numbers: &mut Numbers<'_>, n: i32) -> Result<Vec<i32>, MeshError> {
    let mut groups = Vec::new();
    for i in 0..n {
        let tag = numbers.int()?;
        if i == 0 && tag != 0 {
            groups.push(tag.saturating_abs());
        }
        if i == 2 && tag > 1 {
            let what = "a partitioned mesh".into();
            let remedy = "save without partitions (Mesh.NbPartitions = 0)";
            return numbers.fail(ReadFault::Unsupported { what, remedy });
        }
    }
    Ok(groups)
}
