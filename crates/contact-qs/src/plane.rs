//! Contact of one body with a rigid plane, as a force element.
