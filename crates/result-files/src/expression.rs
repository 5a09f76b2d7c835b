//! Expressions over the datasets of a result: `max(norm(bodies.ball.velocity))`.
//!
//! ```text
//! expression = term { ("+" | "-") term }
//! term       = factor { ("*" | "/") factor }
//! factor     = "-" factor | power
//! power      = postfix [ "^" factor ]
//! postfix    = atom { "." NAME | "[" index "]" }
//! index      = INTEGER | [ INTEGER ] ":" [ INTEGER ]
//! NAME       = letters, digits, "_", "-" between two of them; any letters in double quotes
//! atom       = NUMBER | "(" expression ")" | FUNCTION "(" expression { "," expression } ")" | NAME
//! ```
//!
//! Names lead from group to group to a dataset, the columns of a table, or the components of a row.
//! Indices count from 0, negative ones from the end; the first one is that of the row, the next
//! that of the component.

pub mod fault;
pub mod token;
pub mod value;
pub mod function;
pub mod parse;
pub mod source;
pub mod evaluate;
pub mod named;
