//! Matrices of other finite element programs, as text: Matrix Market, Abaqus, CalculiX, Nastran.
//! What a matrix belongs to, nodes and the order of unknowns, stands in files of its own.
//!
//! Counts that a file claims are not trusted: memory grows with what is there.

mod fault;
mod matrix;
mod words;
mod dmig;
mod entries;
mod nodes;
mod assemble;
mod read;

pub use assemble::{AssemblyFault, Parts, Report, assemble};
pub use fault::{MatrixError, MatrixFault};
pub use matrix::{Entries, Matrix, Row, Unknown};
pub use nodes::{NodeTable, read_map, read_nodes};
pub use read::read_matrix;
