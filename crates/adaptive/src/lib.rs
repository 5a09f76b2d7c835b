//! Impacts of flexible bodies: builds models, switches between phases, reports every step to an
//! observer.
//!
//! The crate knows no file format and no terminal. Its rooms stand here in the order of their
//! layers; each names those before it and no other:
//!
//! | room | knows |
//! |---|---|
//! | [`adaptivity`] | how zones and penalty factors are found, as numbers |
//! | [`spec`] | what a run is made from |
//! | [`store`] | models that are kept between runs, by what they are made from |
//! | [`record`] | what comes out of it: samples, impacts, trials, warnings, what is wrong with a result |
//! | [`error`] | why there is no model or no result |
//! | [`surface`] | undeformed surfaces of bodies |
//! | [`touch`] | where and how two bodies are going to meet |
//! | [`uncertainty`] | by how much the numbers of an impact may be off |
//! | [`state`] | all that the future of a run depends on |
//! | [`body`] | flexible bodies before their reduction, reduced, refined about a contact, with contact zones |
//! | [`paper`] | variants of \[A\] for comparison |
//! | [`system`] | the bodies of a run, rigid and from files among them, joined to a multibody system |
//! | [`prepared`] | what is known of a run before any model is built: poses, first touches, plans of contacts |
//! | [`sizing`] | mesh and modes that the program chooses |
//! | [`impact`] | contacts that get fine models for an impact |
//! | [`model`] | a run that is built |
//! | [`checks`] | what no result may do, and what makes one doubtful |
//! | [`run`] | the driver, and who is told |

pub mod adaptivity;
pub mod spec;
pub mod store;
pub mod record;
pub mod error;
pub mod surface;
pub mod touch;
pub mod uncertainty;
pub mod state;
pub mod body;
pub mod paper;
pub mod system;
pub mod prepared;
pub mod sizing;
pub mod impact;
pub mod model;
pub mod checks;
pub mod run;

#[cfg(test)]
#[expect(dead_code, reason = "tests of contact-qs use the rest")]
#[path = "../../contact-qs/tests/hertz_impact/mod.rs"]
mod hertz_impact;

pub use error::AdaptiveError;
