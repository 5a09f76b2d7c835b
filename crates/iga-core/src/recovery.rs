//! Strain, stress and von Mises stress at parameter points.
