//! Text in TOML or JSON whose values know where they stand, and faults that name the place.

mod blank_lines;
pub mod fault;
pub mod document;
