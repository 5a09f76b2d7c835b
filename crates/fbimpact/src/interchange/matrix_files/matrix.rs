//! A matrix as it stands in a file.

/// An unknown: a component of a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Unknown {
    /// Number of the node in the other program.
    pub node: u64,
    /// Displacement along x, y, z: 0 to 2; rotation about them: 3 to 5.
    pub component: u8,
}

/// A row or column; two words, for large files have many.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Row {
    /// By its number, from 1.
    Number(u64),
    /// By node and component, as [`Unknown`] has them.
    Unknown {
        /// Number of the node in the other program.
        node: u64,
        /// Displacement or rotation.
        component: u8,
    },
}

const _: () = assert!(size_of::<Row>() == 16, "what a file takes in memory is measured with this");

/// Entries of a matrix.
pub type Entries = Vec<(Row, Row, f64)>;

/// A matrix as it stands in a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Matrix {
    /// Name of its format.
    pub format: &'static str,
    /// Entries of one triangle or of both.
    pub entries: Entries,
    /// Number of rows, if the file says it.
    pub n_rows: Option<u64>,
}
