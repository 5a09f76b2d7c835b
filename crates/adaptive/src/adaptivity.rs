//! How zones and penalty factors are found, without bodies and without time: intervals and their
//! change (Algorithm 2), division of elements (Algorithm 3), the search for the penalty factor
//! (Fig. 3). Knows numbers and parameters of faces; knows no body, no contact and no run.
pub mod interval;
pub mod lattice;
pub mod overlap;
pub mod penalty_search;
pub mod subdivision;
pub mod wanted_interval;
