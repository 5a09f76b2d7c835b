//! Strain-displacement relations of plane, axisymmetric and solid models.
