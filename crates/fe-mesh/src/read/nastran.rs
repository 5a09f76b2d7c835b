//! Bulk data of Nastran (MSC Nastran Quick Reference Guide, "Bulk Data Entries"): grid points in coordinates of
//! any system, solid elements, elements on the surface.

mod fields;
mod included;

use std::collections::{BTreeMap, HashMap};

use self::fields::{Entry, entries};
use self::included::Lines;
use super::Wanted;
use super::labels::Labels;
use super::skipped::Skipped;
use super::text::{expected, fail, real, refuse};
use crate::element;
use crate::element::jacobian::{cross, dot, minus, norm};
use crate::element::kind::ElementKind;
use crate::fault::{MeshError, ReadFault};
use crate::mesh::raw::{FaceSource, NO_NODE, RawMesh};

/// Coordinate systems that may stand within each other.
const MOST_WITHIN: usize = 100;

/// Coordinates of a system: rectangular, or an angle \[°\] in the second place, or in the last two.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Form {
    Rectangular,
    Cylindrical,
    Spherical,
}

/// A system of coordinates by three points in another one.
#[derive(Debug, Clone, Copy)]
struct System {
    line: usize,
    form: Form,
    within: u64,
    /// Origin, on the axis z, beside it in the plane of x and z.
    points: [[f64; 3]; 3],
}

/// The same in basic coordinates: origin and axes.
#[derive(Debug, Clone, Copy)]
struct Frame {
    form: Form,
    origin: [f64; 3],
    axes: [[f64; 3]; 3],
}

impl Frame {
    /// A point with the coordinates `x` in basic ones.
    fn place(&self, [a, b, c]: [f64; 3]) -> [f64; 3] {
        let ((sb, cb), (sc, cc)) = (b.to_radians().sin_cos(), c.to_radians().sin_cos());
        let own = match self.form {
            Form::Rectangular => [a, b, c],
            Form::Cylindrical => [a * cb, a * sb, c],
            Form::Spherical => [a * sb * cc, a * sb * sc, a * cb],
        };
        std::array::from_fn(|d| self.origin[d] + (0..3).map(|i| own[i] * self.axes[i][d]).sum::<f64>())
    }
}

/// What has been read; elements may stand before their grid points.
#[derive(Default)]
struct Reader<'a> {
    mesh: RawMesh,
    systems: HashMap<u64, System>,
    /// Line and number of the coordinates of each grid point.
    of_points: Vec<(usize, u64)>,
    elements: Vec<Entry<'a>>,
    /// Materials of properties.
    materials: HashMap<u64, u64>,
    skipped: Skipped,
}

/// What an entry is.
enum Element {
    /// A solid, linear or quadratic.
    Solid([ElementKind; 2]),
    /// Corners of an element on the surface, and most nodes.
    Side(usize, usize),
}

/// Reads a file.
pub fn read(bytes: &[u8], wanted: &mut Wanted<'_>) -> Result<RawMesh, MeshError> {
    let mut lines = Lines::default();
    let text = lines.expanded(String::from_utf8_lossy(bytes), wanted);
    let mesh = text.and_then(|text| {
        let mut reader = Reader::default();
        entries(&text, |entry| reader.entry(entry, &lines))?;
        reader.finish()
    });
    mesh.map_err(|error| lines.told(error))
}

/// What the entry `name` is, if it is an element that is read.
fn element_type(name: &str) -> Option<Element> {
    use ElementKind as Kind;
    Some(match name {
        "CTETRA" => Element::Solid([Kind::Tet4, Kind::Tet10]),
        "CHEXA" => Element::Solid([Kind::Hex8, Kind::Hex20]),
        "CPENTA" => Element::Solid([Kind::Wedge6, Kind::Wedge15]),
        "CPYRAM" | "CPYRA" => Element::Solid([Kind::Pyramid5, Kind::Pyramid13]),
        // Behind the corners stand angles and thicknesses.
        "CTRIA3" | "CTRIAR" => Element::Side(3, 3),
        "CQUAD4" | "CQUADR" => Element::Side(4, 4),
        "CTRIA6" => Element::Side(3, 6),
        "CQUAD8" => Element::Side(4, 8),
        _ => return None,
    })
}

/// Nodes of Nastran's elements in the order of [`ElementKind`]: middles of upright edges stand before those above.
fn order(kind: ElementKind) -> Option<&'static [usize]> {
    match kind {
        ElementKind::Hex20 => Some(&[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 16, 17, 18, 19, 12, 13, 14, 15]),
        ElementKind::Wedge15 => Some(&[0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 14, 9, 10, 11]),
        _ => None,
    }
}

/// How many corners the first side has.
fn base(kind: ElementKind) -> usize {
    if matches!(kind.form(), element::kind::Form::Tetrahedron | element::kind::Form::Wedge) { 3 } else { 4 }
}

/// Where the nodes of an element stand in one whose corners turn the other way.
fn mirrored(kind: ElementKind) -> Vec<usize> {
    let (n, base) = (kind.n_corners(), base(kind));
    let corner = |i: usize| match i {
        _ if i < base => (base - i) % base,
        _ if n == 2 * base => base + (2 * base - i) % base,
        _ => i,
    };
    let turned = |edge: &[u8; 2]| {
        let [a, b] = edge.map(|c| corner(c as usize) as u8);
        n + kind.edges().iter().position(|e| *e == [a, b] || *e == [b, a]).unwrap_or(0)
    };
    (0..n).map(corner).chain(kind.edges().iter().map(turned)).take(kind.n_nodes()).collect()
}

/// A number of an entry; 0 where it is left out.
fn whole(entry: &Entry<'_>, i: usize) -> Result<u64, MeshError> {
    let field = entry.field(i);
    match field.parse() {
        Ok(number) => Ok(number),
        Err(_) if field.is_empty() => Ok(0),
        Err(_) => expected(entry.line, &format!("a number in field {} of {}", i + 2, entry.name), field),
    }
}

/// A coordinate of an entry; zero where it is left out.
fn coordinate(entry: &Entry<'_>, i: usize) -> Result<f64, MeshError> {
    let field = entry.field(i);
    match real(field).or(field.is_empty().then_some(0.0)) {
        Some(x) if x.is_finite() => Ok(x),
        _ => expected(entry.line, &format!("a coordinate in field {} of {}", i + 2, entry.name), field),
    }
}

/// Nodes of an element that has so many corners and so many nodes at most, and how many there are beside the corners.
fn nodes(
    entry: &Entry<'_>,
    labels: &Labels,
    [corners, most]: [usize; 2],
) -> Result<([u32; ElementKind::MAX_NODES], usize), MeshError> {
    let mut nodes = [NO_NODE; ElementKind::MAX_NODES];
    for (i, place) in nodes[..most].iter_mut().enumerate() {
        let node = whole(entry, i + 2)?;
        *place = match labels.get(node) {
            Some(place) => place,
            None if node == 0 && i >= corners => continue,
            None => {
                let user = format!("element {}", whole(entry, 0)?);
                return fail(entry.line, ReadFault::UnknownNode { user, node });
            }
        };
    }
    let further = nodes[corners..most].iter().filter(|n| **n != NO_NODE).count();
    Ok((nodes, further))
}

impl<'a> Reader<'a> {
    fn entry(&mut self, entry: Entry<'a>, lines: &Lines) -> Result<(), MeshError> {
        let line = entry.line;
        match entry.name.as_str() {
            "GRID" => {
                let at = [coordinate(&entry, 2)?, coordinate(&entry, 3)?, coordinate(&entry, 4)?];
                self.mesh.nodes.push(at);
                self.mesh.node_labels.push(whole(&entry, 0)?);
                self.of_points.push((line, whole(&entry, 1)?));
            }
            "CORD2R" => self.system(&entry, Form::Rectangular)?,
            "CORD2C" => self.system(&entry, Form::Cylindrical)?,
            "CORD2S" => self.system(&entry, Form::Spherical)?,
            "PSOLID" => {
                self.materials.insert(whole(&entry, 0)?, whole(&entry, 1)?);
            }
            "MAT1" | "PSHELL" => {}
            "INCLUDE" => return expected(line, "INCLUDE with the name of a file", ""),
            name if element_type(name).is_some() => self.elements.push(entry),
            name => self.skipped.note(name, lines.place(line)),
        }
        Ok(())
    }

    fn system(&mut self, entry: &Entry<'_>, form: Form) -> Result<(), MeshError> {
        let mut points = [[0.0; 3]; 3];
        for (i, value) in points.iter_mut().flatten().enumerate() {
            *value = coordinate(entry, i + 2)?;
        }
        let system = System { line: entry.line, form, within: whole(entry, 1)?, points };
        self.systems.insert(whole(entry, 0)?, system);
        Ok(())
    }

    /// System `number`, named in line `line`, in basic coordinates, `depth` systems within each other.
    fn frame(&self, number: u64, line: usize, depth: usize) -> Result<Frame, MeshError> {
        let Some(&System { line, form, within, points }) = self.systems.get(&number) else {
            let what = format!("coordinate system {number}");
            return refuse(line, &what, "write basic coordinates, CORD2R, CORD2C or CORD2S");
        };
        let points = match within {
            0 => points,
            _ if depth == MOST_WITHIN => {
                return refuse(line, "a coordinate system within itself", "give it in basic coordinates");
            }
            _ => {
                let outer = self.frame(within, line, depth + 1)?;
                points.map(|point| outer.place(point))
            }
        };
        let [origin, on_axis, beside] = points;
        let along = minus(&on_axis, &origin);
        let up = cross(&along, &minus(&beside, &origin));
        if norm(&up) == 0.0 {
            let what = "a coordinate system whose points lie on a line";
            return refuse(line, what, "give three points that do not");
        }
        let (z, y) = (along.map(|c| c / norm(&along)), up.map(|c| c / norm(&up)));
        Ok(Frame { form, origin, axes: [cross(&y, &z), y, z] })
    }

    /// Brings all grid points into basic coordinates.
    fn place(&mut self) -> Result<(), MeshError> {
        let mut frames: HashMap<u64, Frame> = HashMap::new();
        for i in 0..self.of_points.len() {
            let (line, system) = self.of_points[i];
            if system == 0 {
                continue;
            }
            let frame = match frames.get(&system) {
                Some(frame) => *frame,
                None => self.frame(system, line, 0)?,
            };
            frames.insert(system, frame);
            self.mesh.nodes[i] = frame.place(self.mesh.nodes[i]);
        }
        Ok(())
    }

    /// Whether the corners of an element turn left-handed, which Nastran allows.
    fn is_turned(&self, kind: ElementKind, nodes: &[u32]) -> bool {
        let at = |i: usize| self.mesh.nodes[nodes[i] as usize];
        let (base, n) = (base(kind), kind.n_corners());
        let mean = |range: std::ops::Range<usize>| {
            let share = 1.0 / range.len() as f64;
            [0, 1, 2].map(|d| range.clone().map(|i| share * at(i)[d]).sum::<f64>())
        };
        let (below, above) = (mean(0..base), mean(base..n));
        let area = |i: usize| cross(&minus(&at(i), &below), &minus(&at((i + 1) % base), &below));
        (0..base).map(|i| dot(&area(i), &minus(&above, &below))).sum::<f64>() < 0.0
    }

    /// Adds a solid.
    fn solid(
        &mut self,
        entry: &Entry<'_>,
        labels: &Labels,
        kinds: [ElementKind; 2],
    ) -> Result<(), MeshError> {
        let [linear, quadratic] = kinds;
        let wanted = kinds.map(ElementKind::n_nodes);
        let (mut nodes, further) = nodes(entry, labels, wanted)?;
        let kind = if further == 0 { linear } else { quadratic };
        if further > 0 && wanted[0] + further < wanted[1] {
            let found = format!("{} grid points", wanted[0] + further);
            return expected(
                entry.line,
                &format!("{} with {} or {} grid points", entry.name, wanted[0], wanted[1]),
                &found,
            );
        }
        let turned = |nodes: [u32; ElementKind::MAX_NODES], order: &[usize]| {
            std::array::from_fn(|i| order.get(i).map_or(NO_NODE, |&i| nodes[i]))
        };
        if let Some(order) = order(kind) {
            nodes = turned(nodes, order);
        }
        if self.is_turned(kind, &nodes) {
            nodes = turned(nodes, &mirrored(kind));
        }
        let label = whole(entry, 0)?;
        self.mesh.elements.push(kind, label, nodes[..kind.n_nodes()].iter().copied());
        Ok(())
    }

    fn finish(mut self) -> Result<RawMesh, MeshError> {
        self.place()?;
        let labels = Labels::new(&self.mesh.node_labels)
            .or_else(|number| fail(1, ReadFault::Twice { what: "grid point", number }))?;
        let mut volumes: BTreeMap<u64, Vec<u32>> = BTreeMap::new();
        let mut faces: BTreeMap<u64, Vec<[u32; 4]>> = BTreeMap::new();
        for entry in std::mem::take(&mut self.elements) {
            let property = whole(&entry, 1)?;
            match element_type(&entry.name) {
                Some(Element::Side(corners, most)) => {
                    let (nodes, _) = nodes(&entry, &labels, [corners, most])?;
                    let all = std::array::from_fn(|i| if i < corners { nodes[i] } else { NO_NODE });
                    faces.entry(property).or_default().push(all);
                }
                Some(Element::Solid(kinds)) => {
                    volumes.entry(property).or_default().push(self.mesh.elements.len() as u32);
                    self.solid(&entry, &labels, kinds)?;
                }
                None => {}
            }
        }
        let mut of_material: BTreeMap<u64, Vec<u32>> = BTreeMap::new();
        for (property, all) in volumes {
            if let Some(&material) = self.materials.get(&property) {
                of_material.entry(material).or_default().extend(&all);
            }
            self.mesh.volumes.push((format!("PSOLID {property}"), all));
        }
        for (material, mut all) in of_material {
            all.sort_unstable();
            self.mesh.volumes.push((format!("MAT1 {material}"), all));
        }
        let faces = faces.into_iter();
        self.mesh
            .faces
            .extend(faces.map(|(property, all)| (format!("PSHELL {property}"), FaceSource::Corners(all))));
        if let Some(all) = self.skipped.list() {
            self.mesh.notes.push(format!(
                "entries that are not read: {all}; material, supports, springs, masses and couplings are those of the scenario"
            ));
        }
        Ok(self.mesh)
    }
}
