//! Writers of the files that the readers are tested with, from the documents of the formats.

use std::fmt::Write;

use fe_mesh::element::kind::ElementKind;
use fe_mesh::mesh::raw::{Element, FaceSource, RawMesh};

/// Version and encoding of a Gmsh file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    Text41,
    Binary41,
    BigEndian41,
    Text40,
    Binary40,
    Text22,
    Binary22,
}

/// Gmsh's type of an element and, for each node of Gmsh's list, the ends of its edge or the corners of its side (Gmsh reference manual,
/// "Node ordering").
fn layout(kind: ElementKind) -> (i32, Vec<Vec<u8>>) {
    let corners = |n: u8| (0..n).map(|i| vec![i]).collect::<Vec<_>>();
    let with = |n: u8, more: &[&[u8]]| {
        let mut all = corners(n);
        all.extend(more.iter().map(|m| m.to_vec()));
        all
    };
    let hex: [&[u8]; 12] = [
        &[0, 1],
        &[0, 3],
        &[0, 4],
        &[1, 2],
        &[1, 5],
        &[2, 3],
        &[2, 6],
        &[3, 7],
        &[4, 5],
        &[4, 7],
        &[5, 6],
        &[6, 7],
    ];
    let wedge: [&[u8]; 9] = [&[0, 1], &[0, 2], &[0, 3], &[1, 2], &[1, 4], &[2, 5], &[3, 4], &[3, 5], &[4, 5]];
    let pyramid: [&[u8]; 8] = [&[0, 1], &[0, 3], &[0, 4], &[1, 2], &[1, 4], &[2, 3], &[2, 4], &[3, 4]];
    let ring: [&[u8]; 4] = [&[0, 1], &[1, 2], &[2, 3], &[0, 3]];
    match kind {
        ElementKind::Tet4 => (4, corners(4)),
        ElementKind::Hex8 => (5, corners(8)),
        ElementKind::Wedge6 => (6, corners(6)),
        ElementKind::Tet10 => (11, with(4, &[&[0, 1], &[1, 2], &[0, 2], &[0, 3], &[2, 3], &[1, 3]])),
        ElementKind::Hex20 => (17, with(8, &hex)),
        ElementKind::Hex27 => {
            let sides: [&[u8]; 7] = [
                &[0, 1, 2, 3],
                &[0, 1, 4, 5],
                &[0, 3, 4, 7],
                &[1, 2, 5, 6],
                &[2, 3, 6, 7],
                &[4, 5, 6, 7],
                &[0, 1, 2, 3, 4, 5, 6, 7],
            ];
            (12, with(8, &[&hex[..], &sides].concat()))
        }
        ElementKind::Tri3 => (2, corners(3)),
        ElementKind::Quad4 => (3, corners(4)),
        ElementKind::Tri6 => (9, with(3, &[&[0, 1], &[1, 2], &[0, 2]])),
        ElementKind::Quad8 => (16, with(4, &ring)),
        ElementKind::Quad9 => (10, with(4, &[&ring[..], &[&[0, 1, 2, 3]]].concat())),
        ElementKind::Pyramid5 => (7, corners(5)),
        ElementKind::Pyramid13 => (19, with(5, &pyramid)),
        ElementKind::Pyramid14 => (14, with(5, &[&pyramid[..], &[&[0, 1, 2, 3]]].concat())),
        ElementKind::Wedge15 => (18, with(6, &wedge)),
        ElementKind::Wedge18 => {
            let sides: [&[u8]; 3] = [&[0, 1, 3, 4], &[0, 2, 3, 5], &[1, 2, 4, 5]];
            (13, with(6, &[&wedge[..], &sides].concat()))
        }
    }
}

/// Which local node lies in the middle of the given corners.
fn between(kind: ElementKind, of: &[u8]) -> usize {
    let corners = kind.corners();
    let middle = [0, 1, 2].map(|d| of.iter().map(|&c| corners[c as usize][d]).sum::<f64>() / of.len() as f64);
    let near = |p: &[f64; 3]| (0..3).all(|d| (p[d] - middle[d]).abs() < 1e-12);
    kind.node_parameters().iter().position(near).expect("a node")
}

/// Numbers as text or bytes.
struct Out {
    bytes: Vec<u8>,
    form: Form,
}

impl Out {
    fn is_text(&self) -> bool {
        matches!(self.form, Form::Text41 | Form::Text40 | Form::Text22)
    }

    /// Whether numbers of nodes and elements are short, and blocks begin otherwise.
    fn is_40(&self) -> bool {
        matches!(self.form, Form::Text40 | Form::Binary40)
    }

    /// Number of a node or element.
    fn label(&mut self, value: u64) {
        if self.is_40() { self.int(value as i32) } else { self.size(value) }
    }

    /// The beginning of the nodes or elements.
    fn counts(&mut self, blocks: u64, n: u64) {
        let all = [blocks, n, 1, n];
        all[..if self.is_40() { 2 } else { 4 }].iter().for_each(|v| self.size(*v));
        self.line();
    }

    /// The beginning of a block of `n`.
    fn block(&mut self, [dimension, entity, third]: [i32; 3], n: u64) {
        let all = if self.is_40() { [entity, dimension, third] } else { [dimension, entity, third] };
        all.iter().for_each(|v| self.int(*v));
        self.size(n);
        self.line();
    }

    fn raw(&mut self, bytes: &[u8]) {
        let mut bytes = bytes.to_vec();
        if self.form == Form::BigEndian41 {
            bytes.reverse();
        }
        self.bytes.extend(bytes);
    }

    fn int(&mut self, value: i32) {
        if self.is_text() { self.text(&format!("{value} ")) } else { self.raw(&value.to_le_bytes()) }
    }

    fn size(&mut self, value: u64) {
        if self.is_text() { self.text(&format!("{value} ")) } else { self.raw(&value.to_le_bytes()) }
    }

    fn real(&mut self, value: f64) {
        if self.is_text() { self.text(&format!("{value:e} ")) } else { self.raw(&value.to_le_bytes()) }
    }

    fn text(&mut self, text: &str) {
        self.bytes.extend_from_slice(text.as_bytes());
    }

    fn line(&mut self) {
        if self.is_text() {
            self.text("\n");
        }
    }
}

/// Corners of the sides of a mesh whose nodes are all in a set.
fn sides(raw: &RawMesh, set: &[u32]) -> Vec<Vec<u32>> {
    let mut found = Vec::new();
    for element in raw.elements.iter() {
        for side in element.kind.sides() {
            let nodes: Vec<u32> = side.iter().map(|&c| element.nodes[c as usize]).collect();
            if nodes.iter().all(|n| set.contains(n)) {
                found.push(nodes);
            }
        }
    }
    found
}

/// A Gmsh file with one volume group and a group for each set of nodes, of linear surface elements.
pub fn gmsh(raw: &RawMesh, form: Form) -> Vec<u8> {
    let is_new = !matches!(form, Form::Text22 | Form::Binary22);
    let dimension = dimension(raw);
    let mut out = Out { bytes: Vec::new(), form };
    let binary = i32::from(!out.is_text());
    out.text(&format!(
        "$MeshFormat\n{} {binary} 8\n",
        match form {
            Form::Text22 | Form::Binary22 => "2.2",
            Form::Text40 | Form::Binary40 => "4.0",
            _ => "4.1",
        }
    ));
    if binary == 1 {
        out.raw(&1i32.to_le_bytes());
        out.text("\n");
    }
    out.text("$EndMeshFormat\n$PhysicalNames\n");
    out.text(&format!("{}\n{dimension} 1 \"all\"\n", raw.faces.len() + 1));
    for (i, (name, _)) in raw.faces.iter().enumerate() {
        out.text(&format!("{} {} \"{name}\"\n", dimension - 1, i + 1));
    }
    out.text("$EndPhysicalNames\n");
    let faces: Vec<Vec<Vec<u32>>> = raw
        .faces
        .iter()
        .map(|(_, source)| match source {
            FaceSource::Nodes(nodes) => sides(raw, nodes),
            _ => Vec::new(),
        })
        .collect();
    if is_new {
        entities(&mut out, dimension, faces.len());
    }
    out.text("$Nodes\n");
    let n = raw.nodes.len() as u64;
    if is_new {
        out.counts(1, n);
        out.block([dimension, 1, 0], n);
        for label in raw.node_labels.iter().filter(|_| !matches!(form, Form::Text40 | Form::Binary40)) {
            out.size(*label);
            out.line();
        }
    } else {
        out.text(&format!("{n}\n"));
    }
    for (label, place) in raw.node_labels.iter().zip(&raw.nodes) {
        if !is_new || out.is_40() {
            out.int(*label as i32);
        }
        place.iter().for_each(|x| out.real(*x));
        out.line();
    }
    out.text("\n$EndNodes\n$Elements\n");
    elements(&mut out, raw, &faces, is_new);
    out.text("\n$EndElements\n");
    out.bytes
}

/// Dimension of the elements.
fn dimension(raw: &RawMesh) -> i32 {
    raw.elements.get(0).kind.dimension() as i32
}

fn entities(out: &mut Out, dimension: i32, n_faces: usize) {
    out.text("$Entities\n");
    let all = if dimension == 2 { [1, n_faces as u64, 1, 0] } else { [1, 0, n_faces as u64, 1] };
    all.iter().for_each(|v| out.size(*v));
    out.line();
    out.int(1);
    (0..if out.is_40() { 6 } else { 3 }).for_each(|_| out.real(0.0));
    out.size(0);
    out.line();
    let mut entity = |tag: i32, n_bounds: u64| {
        out.int(tag);
        (0..6).for_each(|_| out.real(0.5));
        out.size(1);
        out.int(tag);
        out.size(n_bounds);
        (0..n_bounds).for_each(|_| out.int(1));
        out.line();
    };
    (0..n_faces).for_each(|i| entity(i as i32 + 1, 0));
    entity(1, n_faces as u64);
    out.text("\n$EndEntities\n");
}

fn elements(out: &mut Out, raw: &RawMesh, faces: &[Vec<Vec<u32>>], is_new: bool) {
    let label = |n: u32| raw.node_labels[n as usize];
    let runs = runs(raw);
    let n = raw.elements.len() as u64;
    let total = n + faces.iter().map(Vec::len).sum::<usize>() as u64;
    if is_new {
        // A block has one type; wedges have two types of sides.
        let blocks: usize =
            faces.iter().map(|f| [2, 3, 4].iter().filter(|k| f.iter().any(|s| s.len() == **k)).count()).sum();
        out.counts((blocks + runs.len()) as u64, total);
    } else {
        out.text(&format!("{total}\n"));
    }
    let mut next = 1000;
    for (i, all) in faces.iter().enumerate() {
        for corners in [2, 3, 4] {
            let some: Vec<&Vec<u32>> = all.iter().filter(|s| s.len() == corners).collect();
            if some.is_empty() {
                continue;
            }
            let list = some.iter().map(|s| s.iter().map(|&n| label(n)).collect::<Vec<u64>>());
            let labels: Vec<u64> = (next..next + some.len() as u64).collect();
            next += some.len() as u64;
            let on = dimension(raw) - 1;
            put(out, is_new, (on, i as i32 + 1, corners as i32 - 1), &labels, &list.collect::<Vec<_>>());
        }
    }
    for run in runs {
        let kind = run[0].kind;
        let (number, layout) = layout(kind);
        let list = run
            .iter()
            .map(|e| layout.iter().map(|of| label(e.nodes[between(kind, of)])).collect::<Vec<u64>>());
        let labels: Vec<u64> = run.iter().map(|e| e.label).collect();
        put(out, is_new, (dimension(raw), 1, number), &labels, &list.collect::<Vec<_>>());
    }
}

/// Elements of one kind that follow each other.
fn runs(raw: &RawMesh) -> Vec<Vec<Element<'_>>> {
    let mut runs: Vec<Vec<Element<'_>>> = Vec::new();
    for element in raw.elements.iter() {
        match runs.last_mut().filter(|run| run[0].kind == element.kind) {
            Some(run) => run.push(element),
            None => runs.push(vec![element]),
        }
    }
    runs
}

/// One block of elements of one type on one entity.
fn put(
    out: &mut Out,
    is_new: bool,
    (dimension, entity, number): (i32, i32, i32),
    labels: &[u64],
    nodes: &[Vec<u64>],
) {
    let n = labels.len();
    if is_new {
        out.block([dimension, entity, number], n as u64);
    } else if !out.is_text() {
        [number, n as i32, 2].iter().for_each(|v| out.int(*v));
    }
    for (label, nodes) in labels.iter().zip(nodes) {
        if is_new {
            out.label(*label);
            nodes.iter().for_each(|n| out.label(*n));
        } else {
            out.int(*label as i32);
            if out.is_text() {
                [number, 2].iter().for_each(|v| out.int(*v));
            }
            [entity, entity].iter().for_each(|v| out.int(*v));
            nodes.iter().for_each(|n| out.int(*n as i32));
        }
        out.line();
    }
}

/// A flat input file; the groups are sets of nodes.
pub fn inp(raw: &RawMesh) -> String {
    let mut text = String::from("** a comment\n*NODE, NSET=everything\n");
    for (label, [x, y, z]) in raw.node_labels.iter().zip(&raw.nodes) {
        writeln!(text, "{label}, {x:e}, {y:e}, {z:e}").expect("a line");
    }
    for run in runs(raw) {
        let kind = run[0].kind;
        let family = if kind.dimension() == 2 { "CPE" } else { "C3D" };
        writeln!(text, "*ELEMENT, TYPE={family}{},\nELSET=all", kind.n_nodes()).expect("a line");
        for element in run {
            let mut nodes = element.nodes.to_vec();
            if kind == ElementKind::Hex27 {
                nodes[20..].rotate_right(1);
            }
            let mut line = element.label.to_string();
            for (i, &n) in nodes.iter().enumerate() {
                line += if i % 15 == 14 { ",\n" } else { ", " };
                line += &raw.node_labels[n as usize].to_string();
            }
            text += &line;
            text.push('\n');
        }
    }
    for (name, source) in &raw.faces {
        if let FaceSource::Nodes(nodes) = source {
            writeln!(text, "*Nset, nset={name}").expect("a line");
            for n in nodes {
                writeln!(text, "{},", raw.node_labels[*n as usize]).expect("a line");
            }
        }
    }
    text
}

/// Fields of Nastran's bulk data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fields {
    Short,
    Large,
    Free,
}

/// An entry of bulk data.
fn entry(name: &str, all: &[String], fields: Fields) -> String {
    let (mut text, most) = (String::new(), if fields == Fields::Large { 4 } else { 8 });
    for (i, line) in all.chunks(most).enumerate() {
        text += &match (fields, i) {
            (Fields::Free, 0) => name.to_owned(),
            (Fields::Free, _) => String::new(),
            (Fields::Large, 0) => format!("{:<8}", format!("{name}*")),
            (Fields::Large, _) => "*       ".to_owned(),
            (Fields::Short, 0) => format!("{name:<8}"),
            (Fields::Short, _) => "+       ".to_owned(),
        };
        for field in line {
            text += &match fields {
                Fields::Free => format!(",{field}"),
                Fields::Large => format!("{field:<16}"),
                Fields::Short => format!("{field:<8}"),
            };
        }
        text.push('\n');
    }
    text
}

/// Bulk data of Nastran: the groups of faces are shells with the properties 1, 2, …, the elements have the property 7 of material 9.
pub fn nastran(raw: &RawMesh, fields: Fields) -> String {
    let mut text =
        String::from("$ a comment\nSOL 101\nCEND\nBEGIN BULK\nMAT1,9,2.1+11,,0.3,7850.\nPSOLID,7,9\n");
    let whole = |all: &mut dyn Iterator<Item = u64>| all.map(|n| n.to_string()).collect::<Vec<_>>();
    // Grid points may stand behind the elements.
    for element in raw.elements.iter() {
        let name = match element.kind.linear() {
            ElementKind::Tet4 => "CTETRA",
            ElementKind::Hex8 => "CHEXA",
            ElementKind::Wedge6 => "CPENTA",
            _ => "CPYRAM",
        };
        let kind = element.kind;
        let mut middles: Vec<usize> = (kind.n_corners()..kind.n_nodes()).collect();
        let base = kind.n_corners() / 2;
        if matches!(kind, ElementKind::Hex20 | ElementKind::Wedge15) {
            middles[base..].rotate_left(base);
        }
        let nodes = (0..kind.n_corners()).chain(middles).map(|i| raw.node_labels[element.nodes[i] as usize]);
        text += &entry(name, &whole(&mut [element.label, 7].into_iter().chain(nodes)), fields);
    }
    let mut next = 1000;
    for (i, (_, source)) in raw.faces.iter().enumerate() {
        let FaceSource::Nodes(nodes) = source else { continue };
        for side in sides(raw, nodes) {
            next += 1;
            let name = if side.len() == 3 { "CTRIA3" } else { "CQUAD4" };
            let nodes = side.iter().map(|&n| raw.node_labels[n as usize]);
            text += &entry(name, &whole(&mut [next, i as u64 + 1].into_iter().chain(nodes)), fields);
        }
    }
    for (label, place) in raw.node_labels.iter().zip(&raw.nodes) {
        let number = |x: &f64| {
            if fields == Fields::Short { format!("{x:.5}") } else { format!("{x:.12e}").replace('e', "D") }
        };
        let mut all = vec![label.to_string(), String::new()];
        all.extend(place.iter().map(number));
        text += &entry("GRID", &all, fields);
    }
    text + "CBAR,9000,1,1,2\nENDDATA\nnothing is read here\n"
}
