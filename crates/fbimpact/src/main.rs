//! Thin entry point: parse, call, map to an exit code.
fn main() {}
