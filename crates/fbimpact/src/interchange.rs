//! Bodies of other programs, and for them: body files, and matrices as text.

pub mod body_file;
pub mod matrix_files;
