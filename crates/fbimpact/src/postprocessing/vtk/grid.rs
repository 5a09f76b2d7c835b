//! An unstructured grid with its fields, as VTK has them.

pub mod order;
pub mod marks;
pub mod xml;

/// How a body is deformed, in the values that it is drawn by.
#[derive(Debug, Clone, Copy)]
pub struct Deformation<'a> {
    /// Displacements \[m\].
    pub displacement: &'a [f64],
    /// Their rates [m/s].
    pub rate: &'a [f64],
}

/// Fields of contact points.
#[derive(Debug, Clone, Default)]
pub struct ContactFields {
    /// Contact pressure \[Pa\].
    pub pressure: Vec<[f64; 1]>,
    /// Tributary area of each point \[m²\].
    pub area: Vec<[f64; 1]>,
}

/// Points, cells and fields.
#[derive(Debug, Clone, Default)]
pub struct Grid {
    /// Points in space \[m\].
    pub points: Vec<[f64; 3]>,
    /// Points of all cells, one cell after the other.
    pub connectivity: Vec<i64>,
    /// End of each cell in `connectivity`.
    pub offsets: Vec<i64>,
    /// Type of each cell.
    pub types: Vec<u8>,
    /// Degrees of each higher-order cell; empty if there are none.
    pub degrees: Vec<[f64; 3]>,
    /// Weights of the points; empty if there are no rational cells.
    pub weights: Vec<f64>,
    /// Elastic displacement \[m\]; empty where nothing is displaced.
    pub displacement: Vec<[f64; 3]>,
    /// Velocity [m/s]; empty where nothing moves.
    pub velocity: Vec<[f64; 3]>,
    /// Von Mises stress \[Pa\]; empty for rigid bodies.
    pub von_mises: Vec<[f64; 1]>,
    /// Stress in space, `XX, YY, ZZ, XY, YZ, XZ` \[Pa\]; empty for rigid bodies.
    pub stress: Vec<[f64; 6]>,
    /// Fields of contact points; none on bodies.
    pub contact: Option<ContactFields>,
    /// Names of the points; empty if they have none.
    pub labels: Vec<String>,
    /// More numbers at points, by name with unit.
    pub scalars: Vec<(String, Vec<[f64; 1]>)>,
    /// More vectors at points, by name with unit.
    pub vectors: Vec<(String, Vec<[f64; 3]>)>,
}

impl Grid {
    /// Adds a cell of type `kind` through points `first + node`.
    pub fn add_cell(&mut self, kind: u8, first: usize, nodes: &[usize]) {
        self.connectivity.extend(nodes.iter().map(|n| (first + n) as i64));
        self.offsets.push(self.connectivity.len() as i64);
        self.types.push(kind);
    }
}
