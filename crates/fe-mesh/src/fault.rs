//! What can be wrong with a mesh or its file.

use thiserror::Error;

/// Names that a message lists before it ends.
const LISTED: usize = 20;

/// Names in quotes for a message.
pub(crate) fn shown<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let mut names: Vec<String> = names.take(LISTED + 1).map(|name| format!("\"{name}\"")).collect();
    if names.is_empty() {
        return "none".to_owned();
    }
    if names.len() > LISTED {
        names[LISTED] = "…".to_owned();
    }
    names.join(", ")
}

/// Where in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// Line of a text, from 1.
    Line(usize),
    /// Byte of a file with binary parts, from 0.
    Byte(usize),
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Byte(byte) => write!(f, "byte {byte}"),
        }
    }
}

/// Errors of reading and checking meshes. Texts are fragments that read after "FILE: ".
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum MeshError {
    /// The file cannot be understood.
    #[error("{place}: {fault}")]
    Read {
        /// Where.
        place: Place,
        /// What is wrong.
        fault: ReadFault,
    },
    /// The mesh makes no body.
    #[error(transparent)]
    Mesh(#[from] MeshFault),
}

/// What is wrong in a file.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ReadFault {
    /// Neither of the formats.
    #[error(
        "{found}; read are MSH of Gmsh, input files of Abaqus and CalculiX, bulk data of Nastran: {remedy}"
    )]
    Format {
        /// What the file seems to be.
        found: &'static str,
        /// The command that makes another of it.
        remedy: &'static str,
    },
    /// A version of Gmsh's format that is not read.
    #[error("MSH version {found} is not read; write 4.1: gmsh PART.msh -save -format msh41 -o NEW.msh")]
    Version {
        /// As it stands there.
        found: String,
    },
    /// The file ends too early.
    #[error("the file ends within {section}; write it again")]
    End {
        /// Name of the section or card.
        section: String,
    },
    /// Something else was expected.
    #[error("{expected} expected, found \"{found}\"")]
    Expected {
        /// What should stand there.
        expected: String,
        /// What stands there.
        found: String,
    },
    /// A section without which there is no mesh.
    #[error("no {what}; {remedy}")]
    Missing {
        /// Name of the section or card.
        what: &'static str,
        /// What to do.
        remedy: &'static str,
    },
    /// A node that an element or set names and that does not exist.
    #[error("{user} names node {node}, which the file does not have")]
    UnknownNode {
        /// "element 7", "set \"A\"".
        user: String,
        /// Its number in the file.
        node: u64,
    },
    /// A number given twice.
    #[error("{what} {number} stands in the file twice; renumber it")]
    Twice {
        /// "node" or "element".
        what: &'static str,
        /// Its number in the file.
        number: u64,
    },
    /// A coordinate that is no number.
    #[error("node {node} has a coordinate that is not a finite number")]
    Coordinate {
        /// Its number in the file.
        node: u64,
    },
    /// Elements that are not computed.
    #[error("element {element} is a {found}; {remedy}")]
    Element {
        /// Its number in the file.
        element: u64,
        /// Type as the file names it.
        found: String,
        /// What to do.
        remedy: &'static str,
    },
    /// Something that the format knows and this program does not.
    #[error("{what} is not supported; {remedy}")]
    Unsupported {
        /// Section, card or parameter.
        what: String,
        /// What to do.
        remedy: &'static str,
    },
    /// A file that cannot be included.
    #[error("\"{file}\" cannot be included: {reason}")]
    Include {
        /// As the file names it.
        file: String,
        /// Why.
        reason: String,
    },
    /// A fault of a file that is included.
    #[error("in \"{file}\", {place}: {fault}")]
    Included {
        /// As the file names it.
        file: String,
        /// Where in it.
        place: Place,
        /// What is wrong.
        fault: Box<ReadFault>,
    },
    /// Several parts, none of which is chosen.
    #[error(
        "{} the file has the parts {}; choose one by its name, as part = \"NAME\" in the table of the body",
        asked.as_ref().map_or("several parts:".to_owned(), |name| format!("no part \"{name}\":")),
        shown(names.iter().map(String::as_str))
    )]
    Parts {
        /// The name asked for.
        asked: Option<String>,
        /// Those that there are.
        names: Vec<String>,
    },
    /// A set that names nothing that exists.
    #[error("{user} names the set \"{set}\", which the file does not have above")]
    UnknownSet {
        /// "surface \"A\"".
        user: String,
        /// Name.
        set: String,
    },
    /// Sets and groups that are too large for their file.
    #[error(
        "sets and groups have more than {limit} members, more than a file of this size has room for; leave out what no body uses"
    )]
    Members {
        /// Limit.
        limit: usize,
    },
}

/// What is wrong with a mesh.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum MeshFault {
    /// No elements.
    #[error(
        "no solid or plane elements; Gmsh saves elements without physical group only with Mesh.SaveAll = 1, or give the volume, or the surface of a plane model, a physical group"
    )]
    NoElements,
    /// A unit of length that is none.
    #[error("unit of length {unit} m, must be positive and finite")]
    Unit {
        /// The number given \[m\].
        unit: f64,
    },
    /// Linear and quadratic elements in one mesh.
    #[error(
        "element {} is a {}, element {} a {}: sides of linear and quadratic elements do not fit together; choose one order",
        first.0, first.1, second.0, second.1
    )]
    MixedOrders {
        /// Number and kind of a linear element.
        first: (u64, &'static str),
        /// Number and kind of a quadratic element.
        second: (u64, &'static str),
    },
    /// Plane elements that lie in no plane.
    #[error(
        "the file has plane elements alone, and node {node} is {distance:.3e} units of the file off their plane; plane and axisymmetric models lie in \
         z = 0, as (x, y) or (r, z); of a solid mesh the volume (gmsh -3, with a physical group of the volume)"
    )]
    NotPlane {
        /// Its number in the file.
        node: u64,
        /// Distance from the plane of the first node.
        distance: f64,
    },
    /// Elements of another dimension than the model of their body.
    #[error(
        "{}",
        if *is_plane {
            "its elements are plane; choose the model \"plane-stress\", \"plane-strain\" or \"axisymmetric\" (\"fbimpact new\" and \"drop\": --section), or mesh the volume (gmsh -3, with a physical group of the volume)"
        } else {
            "its elements are solids; choose model = \"mesh\", or mesh a section in the plane z = 0 (gmsh -2)"
        }
    )]
    Dimension {
        /// Whether the elements are plane.
        is_plane: bool,
    },
    /// A node on the other side of the axis.
    #[error(
        "node {node} has the radius x = {radius:.4e} m; an axisymmetric section lies at x >= 0 beside its axis y, with x the radius"
    )]
    BeyondAxis {
        /// Its number in the file.
        node: u64,
        /// Its radius \[m\].
        radius: f64,
    },
    /// An element that names a node twice.
    #[error("element {element} names node {node} twice; mesh the part again")]
    Collapsed {
        /// Number of the element.
        element: u64,
        /// Number of the node.
        node: u64,
    },
    /// An element with negative volume somewhere.
    #[error(
        "element {element} ({kind}) is inside out at ({:.4e}, {:.4e}, {:.4e}) m, Jacobian determinant {determinant:.3e}; {remedy}",
        point[0], point[1], point[2]
    )]
    Inverted {
        /// Number of the element.
        element: u64,
        /// Its kind.
        kind: &'static str,
        /// Where \[m\].
        point: [f64; 3],
        /// The determinant.
        determinant: f64,
        /// What to do.
        remedy: &'static str,
    },
    /// A side with more than two elements.
    #[error("elements {}, {} and {} share one side; the part is meshed twice, or elements overlap", elements[0], elements[1], elements[2])]
    SharedSide {
        /// Numbers of the elements.
        elements: [u64; 3],
    },
    /// Two elements that share the corners of a side and not its other nodes.
    #[error(
        "elements {} and {} share the corners of a side but not its other nodes, along which the part would tear; merge coincident nodes (Coherence Mesh in Gmsh), or mesh again",
        elements[0], elements[1]
    )]
    TornSide {
        /// Numbers of the elements.
        elements: [u64; 2],
    },
    /// Every side is shared by two elements.
    #[error("the mesh has no surface: every element is there twice; save each once")]
    NoSurface,
    /// Parts that are not connected.
    #[error(
        "the mesh has {parts} parts that share no node: {names}; choose one by its name, as part = \"NAME\" in the table of the body, or merge coincident nodes (Coherence Mesh in Gmsh)"
    )]
    Parts {
        /// How many.
        parts: usize,
        /// Their names: groups of elements, or "element N" for what hangs together with one.
        names: String,
    },
    /// A side without a normal somewhere, which nothing can touch.
    #[error(
        "the side of element {element} at ({:.4e}, {:.4e}, {:.4e}) m has no area there, so that nothing can touch it; mesh finer there, or move the middle nodes of its edges",
        point[0], point[1], point[2]
    )]
    FlatSide {
        /// Number of the element.
        element: u64,
        /// Where \[m\].
        point: [f64; 3],
    },
    /// A group that does not exist.
    #[error("no group \"{name}\" of {what}, the mesh has {known}")]
    UnknownGroup {
        /// "faces" or "elements".
        what: &'static str,
        /// Name asked for.
        name: String,
        /// Names that there are.
        known: String,
    },
    /// A group without a side of the surface.
    #[error(
        "group \"{name}\" has no side on the surface, to which the axis of a section does not belong; name a physical surface (of a plane mesh a physical curve), *SURFACE, or a set with all nodes of a side"
    )]
    NoSides {
        /// Its name.
        name: String,
    },
    /// Elements without a material, or with two.
    #[error("element {element} is in {found} of the groups that have a material; name every element once")]
    Materials {
        /// Number of the element.
        element: u64,
        /// Count.
        found: usize,
    },
    /// A point outside the mesh.
    #[error("point ({}, {}, {}) m is not in the body, nearest distance {distance:.3e} m", point[0], point[1], point[2])]
    PointNotFound {
        /// The point asked for \[m\].
        point: [f64; 3],
        /// Distance to the nearest point of the surface \[m\].
        distance: f64,
    },
    /// A disc or ball that leaves the body.
    #[error(
        "the {kind} of radius {radius} m about ({}, {}, {}) m reaches beyond the body; choose a smaller radius, another point, or a face",
        point[0], point[1], point[2]
    )]
    BeyondBody {
        /// "disc" or "ball".
        kind: &'static str,
        /// Its radius \[m\].
        radius: f64,
        /// Its centre \[m\].
        point: [f64; 3],
    },
    /// A place that would take too many pieces of elements.
    #[error(
        "elements would have to be halved more than {levels} times, into more than {cells} pieces, where {most} are possible; mesh finer there, or ask for a wider zone with fewer elements"
    )]
    TooFine {
        /// How often elements are halved so far.
        levels: u8,
        /// Pieces so far.
        cells: usize,
        /// Most that are possible.
        most: usize,
    },
    /// An element whose pieces would be of another kind.
    #[error(
        "element {element} ({kind}) at ({:.4e}, {:.4e}, {:.4e}) m would have to be divided, and its pieces would be no pyramids alone; have no pyramids near the touch, or keep the contact on the mesh (model = \"quasistatic\")",
        point[0], point[1], point[2]
    )]
    Undivided {
        /// Number of the element.
        element: u64,
        /// Its kind.
        kind: &'static str,
        /// Mean of its nodes \[m\].
        point: [f64; 3],
    },
}
