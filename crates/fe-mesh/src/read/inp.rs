//! Input files of Abaqus and CalculiX: flat, or with parts and instances of them.

mod card;
mod axes;
mod part;
mod assembly;
mod ties;

use self::assembly::Assembly;
use self::axes::Axes;
use self::card::{Card, Type, element_type};
use self::part::{Given, Of, Part};
use self::ties::Ties;
use super::Wanted;
use super::sets::Room;
use super::skipped::{LISTED, Skipped};
use super::text::{expected, fail, refuse};
use crate::fault::{MeshError, ReadFault};
use crate::mesh::raw::RawMesh;
use crate::mesh::tie::Tie;

/// Cards whose data say nothing of the mesh, left out without a word.
const SILENT: &[&str] = &["HEADING", "PREPRINT", "RESTART", "INCLUDE", "END STEP"];
/// Cards that make nodes and elements, or move them.
const MAKERS: &[&str] =
    &["NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "IMPERFECTION", "SYMMETRIC MODEL GENERATION"];
/// What to do about them.
const MAKE: &str = "write a file in which every node and element stands with its numbers";
/// Files that may include each other, one within the other, and includes in all.
const MOST_INCLUDED: [usize; 2] = [16, 1000];

struct Reader<'a, 'b> {
    wanted: &'a mut Wanted<'b>,
    card: Card,
    /// Whether the data of the card are read.
    is_read: bool,
    /// Whether the mesh is complete: before the first step.
    is_over: bool,
    /// The part that is read, or the chosen one while names of the assembly are.
    part: Part,
    assembly: Assembly,
    axes: Axes,
    ties: Ties,
    room: Room,
    /// The included file that is read, how deep it stands, and includes so far.
    file: Option<String>,
    depth: usize,
    included: usize,
    cards: Skipped,
    elements: Skipped,
    /// The first reduced or mixed element type of solids and of plane elements, and types of lines.
    reduced: [Option<(String, String)>; 2],
    lines: Vec<(String, String)>,
    surplus: Option<String>,
}

/// Reads a file; what of the part's name is still to be found in its mesh comes with it.
pub fn read(bytes: &[u8], wanted: &mut Wanted<'_>) -> Result<(RawMesh, Option<String>), MeshError> {
    let mut reader = Reader {
        wanted,
        card: Card::default(),
        is_read: false,
        is_over: false,
        part: Part::default(),
        assembly: Assembly::default(),
        axes: Axes::default(),
        ties: Ties::default(),
        room: Room::of(bytes.len()),
        file: None,
        depth: 0,
        included: 0,
        cards: Skipped::default(),
        elements: Skipped::default(),
        reduced: [None, None],
        lines: Vec::new(),
        surplus: None,
    };
    reader.lines(bytes)?;
    reader.finish()
}

impl Reader<'_, '_> {
    /// Reads the lines of a file; data at its beginning belong to the last card of the one that includes it.
    fn lines(&mut self, bytes: &[u8]) -> Result<(), MeshError> {
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let mut lines = bytes.split(|b| *b == b'\n').map(|l| l.trim_ascii()).zip(1..).peekable();
        while let Some((bytes, line)) = lines.next().filter(|_| !self.is_over) {
            let text = String::from_utf8_lossy(bytes);
            if text.is_empty() || text == "*" || text.starts_with("**") {
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
                let card = Card::new(&text, line);
                // What is included goes on with the data of the card before.
                if card.name != "INCLUDE" {
                    self.card = card.clone();
                    self.begin()?;
                }
                self.include(&card)?;
                continue;
            }
            // What stands before the first card says nothing.
            if !self.is_read {
                continue;
            }
            let Some((found, n)) = self.element_type().filter(|_| self.card.name == "ELEMENT") else {
                self.data(line, &text)?;
                continue;
            };
            let mut given = Given::default();
            given.add(&text, line)?;
            while given.n < n + 1 {
                while lines.next_if(|(next, _)| next.starts_with(b"**") || next.is_empty()).is_some() {}
                let Some((next, at)) = lines.next_if(|(next, _)| !next.starts_with(b"*")) else {
                    return fail(line, ReadFault::End { section: "an element".into() });
                };
                given.add(&String::from_utf8_lossy(next), at)?;
            }
            if given.n > n + 1 && self.surplus.is_none() {
                self.surplus = Some(self.place(line));
            }
            self.part.element((&self.card, &mut self.room), line, (found, n), &given)?;
        }
        Ok(())
    }

    /// Reads the file that a card includes.
    fn include(&mut self, card: &Card) -> Result<(), MeshError> {
        let wants = card.name == "INCLUDE" || self.is_read;
        let given = card.get("INPUT").or(card.get("FILE").filter(|_| card.name != "INCLUDE"));
        let Some(name) = given.filter(|_| wants) else {
            return match card.name.as_str() {
                "INCLUDE" => expected(card.line, "*INCLUDE with INPUT=", ""),
                _ => Ok(()),
            };
        };
        let (line, file) = (card.line, name.to_owned());
        let cannot = |reason: String| ReadFault::Include { file: file.clone(), reason };
        self.included += 1;
        let [depth, most] = MOST_INCLUDED;
        if self.depth == depth || self.included > most {
            return fail(line, cannot(format!("{depth} files within each other, {most} in all, are read")));
        }
        let bytes = (self.wanted.include)(name).or_else(|reason| fail(line, cannot(reason)))?;
        self.room.widen(bytes.len());
        let outer = self.file.replace(file.clone());
        self.depth += 1;
        let outcome = self.lines(&bytes);
        self.depth -= 1;
        self.file = outer;
        outcome.or_else(|error| match error {
            MeshError::Read { place, fault } => {
                fail(line, ReadFault::Included { file, place, fault: Box::new(fault) })
            }
            other @ MeshError::Mesh(_) => Err(other),
        })
    }

    /// A line of the file that is read, for a note.
    fn place(&self, line: usize) -> String {
        match &self.file {
            Some(file) => format!("line {line} of {file}"),
            None => format!("line {line}"),
        }
    }

    /// Type and number of nodes of the elements of the card; none if they are left out.
    fn element_type(&self) -> Option<(Type, usize)> {
        let found = element_type(&self.card.get("TYPE")?.to_ascii_uppercase())?;
        match found {
            Type::Solid(kind) | Type::Plane(kind, _) => Some((found, kind.n_nodes())),
            Type::Side(n) | Type::Line(n) => Some((found, n)),
            Type::Other => None,
        }
    }

    /// Begins the card.
    fn begin(&mut self) -> Result<(), MeshError> {
        let line = self.card.line;
        self.is_read = true;
        match self.card.name.as_str() {
            "PART" => {
                self.axes = Axes::default();
                self.assembly.begin_part(&mut self.part, &self.card)
            }
            "INSTANCE" => {
                self.axes = Axes::default();
                self.assembly.begin_instance(&mut self.part, &self.card)
            }
            "END PART" | "END INSTANCE" => self.assembly.end(&mut self.part),
            "ASSEMBLY" | "END ASSEMBLY" => self.is_read = false,
            "NODE" | "ELEMENT" if self.assembly.is_outside() => {
                self.cards.note(&format!("*{} of the assembly", self.card.name), self.place(line));
                self.is_read = false;
            }
            name if MAKERS.contains(&name) => return refuse(line, &format!("*{name}"), MAKE),
            "STEP" => self.is_over = true,
            "SYSTEM" => self.axes.begin(line),
            "NODE" | "ELEMENT" | "NSET" | "ELSET" | "SURFACE" => return self.begin_mesh(),
            name => {
                let place = self.place(line);
                if self.ties.begin(&self.card, place.clone()) {
                    return Ok(());
                }
                if !SILENT.contains(&name) {
                    self.cards.note(&format!("*{name}"), place);
                }
                self.is_read = false;
            }
        }
        Ok(())
    }

    fn begin_mesh(&mut self) -> Result<(), MeshError> {
        let line = self.card.line;
        let required = match self.card.name.as_str() {
            "ELEMENT" => "TYPE",
            "NSET" => "NSET",
            "ELSET" => "ELSET",
            "SURFACE" => "NAME",
            _ => return self.axes.of_nodes(&self.card),
        };
        let Some(value) = self.card.get(required) else {
            return expected(line, &format!("*{} with {required}=", self.card.name), "");
        };
        if self.card.name == "ELEMENT" {
            let name = value.to_ascii_uppercase();
            self.part.sort_nodes(line)?;
            match element_type(&name) {
                None => {
                    let remedy = "computed are C3D4, C3D10, C3D8, C3D20, C3D27, C3D6, C3D15, C3D5, C3D13";
                    return refuse(line, &format!("element type {name}"), remedy);
                }
                Some(Type::Other) => {
                    self.elements.note(&name, self.place(line));
                    self.is_read = false;
                    // Their set is there, even though it has no members.
                    let set = self.card.get("ELSET");
                    return set.map_or(Ok(()), |set| self.part.name_set(set, &mut self.room, line));
                }
                Some(Type::Line(_)) => {
                    let place = self.place(line);
                    self.lines.push((name, place));
                }
                Some(found @ (Type::Solid(_) | Type::Plane(..)))
                    if name.ends_with(|c: char| c.is_ascii_alphabetic()) =>
                {
                    let place = self.place(line);
                    self.reduced[usize::from(matches!(found, Type::Plane(..)))].get_or_insert((name, place));
                }
                Some(_) => {}
            }
            return Ok(());
        }
        if self.assembly.is_outside() {
            self.assembly.choose(&mut self.part, self.wanted.part);
        }
        if self.assembly.is_undecided() {
            self.is_read = false;
            return Ok(());
        }
        self.part.sort_nodes(line)?;
        self.part.sort_elements(line)?;
        match self.card.name.as_str() {
            "NSET" => self.part.begin_set((&self.card, &mut self.room), Of::Nodes),
            "ELSET" => self.part.begin_set((&self.card, &mut self.room), Of::Elements),
            _ => {
                let kind = self.card.get("TYPE").unwrap_or("ELEMENT").to_ascii_uppercase();
                if self.card.get("COMBINE").is_some() || !matches!(kind.as_str(), "ELEMENT" | "NODE") {
                    self.cards.note("*SURFACE made of others or by its geometry", self.place(line));
                    self.is_read = false;
                    return Ok(());
                }
                self.part.begin_surface(&self.card, &mut self.room)
            }
        }
    }

    /// A line of data that is no element.
    fn data(&mut self, line: usize, text: &str) -> Result<(), MeshError> {
        let with = (&self.card, &mut self.room);
        match self.card.name.as_str() {
            "NODE" => self.part.node(with, (line, text), &mut self.axes),
            "SYSTEM" => self.axes.data(line, text),
            "NSET" => self.part.set(with, (line, text), Of::Nodes),
            "ELSET" => self.part.set(with, (line, text), Of::Elements),
            "SURFACE" => self.part.surface(with, line, text),
            "INSTANCE" => self.assembly.data(line, text),
            _ => {
                self.ties.data(&self.card, text);
                Ok(())
            }
        }
    }

    fn finish(mut self) -> Result<(RawMesh, Option<String>), MeshError> {
        let rest = self.assembly.finish(&mut self.part, self.wanted.part)?;
        let mut mesh = self.part.finish()?;
        if mesh.elements.is_empty() {
            let remedy = "C3D10 and its like make a body, CPS6, CPE6, CAX6 and theirs one in the plane; shells and beams do not";
            return fail(1, ReadFault::Missing { what: "solid or plane elements", remedy });
        }
        let is_plane = mesh.stated.is_some();
        for (name, place) in self.lines.iter().filter(|_| !is_plane) {
            self.elements.note(name, place);
        }
        let (ties, none) = self.ties.finish();
        mesh.ties = ties;
        for (card, place) in none.iter().filter_map(|card| card.strip_suffix(')')?.rsplit_once(" (")) {
            self.cards.note(card, place);
        }
        let left: Vec<String> = [
            self.cards.list().map(|all| format!("cards that are not read: {all}")),
            self.elements.list().map(|all| format!("elements that are left out: {all}")),
        ]
        .into_iter()
        .flatten()
        .collect();
        if !left.is_empty() {
            mesh.notes.push(format!(
                "{}; material, supports, springs, masses and couplings are those of the scenario",
                left.join("; ")
            ));
        }
        let mut tied: Vec<String> = mesh.ties.iter().take(LISTED + 1).map(Tie::to_string).collect();
        if !tied.is_empty() {
            if tied.len() > LISTED {
                tied[LISTED] = "…".to_owned();
            }
            mesh.notes.push(format!("what the file ties is for joints of the scenario: {}", tied.join("; ")));
        }
        let [of_solids, of_plane] = self.reduced;
        if let Some((name, place)) = if is_plane { of_plane } else { of_solids } {
            mesh.notes.push(format!(
                "element type {name} ({place}) is computed with full integration and displacements alone"
            ));
        }
        if let Some(place) = self.surplus {
            mesh.notes.push(format!("elements have more numbers than nodes ({place}): the first are taken"));
        }
        Ok((mesh, rest))
    }
}
