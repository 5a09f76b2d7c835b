//! Stages of a run whose wall time a result tells.

/// Names in `/timings`, in the order of a run; a result of an earlier version has not all of them.
pub const STAGES: [&str; 9] =
    ["preparation", "sizes", "assembly", "reduction", "search", "contact", "integration", "output", "rest"];
