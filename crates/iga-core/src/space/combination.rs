//! Functions of many elements as combinations of raw ones that have one number on all of them.

use faer::sparse::SparseColMat;

use super::Space;

/// Elements of a space on which its functions are `R_i = Σ_m B_im Q_m` with raw functions `Q_m` and
/// coefficients that are the same on all of them (theory Eq. H.10).
pub struct Combination<'a> {
    /// The elements, rising.
    pub elements: Vec<usize>,
    /// Space of the raw functions; its elements are these, in their order, of the same parameters
    /// and rules.
    pub raw: Box<dyn Space + 'a>,
    /// Numbers of the functions that do not vanish on these elements, rising.
    pub functions: Vec<u32>,
    /// `B`: a row for each of these functions, a column for each raw one.
    pub coefficients: SparseColMat<u32, f64>,
}
