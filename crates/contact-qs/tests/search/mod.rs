//! Detection of contact: distances in closed form and by brute force, signs, certificates, first touching times.

mod bodies;
mod closed_forms;
mod general;
mod touching;
