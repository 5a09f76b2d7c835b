//! Points with a frame on a flexible body.
