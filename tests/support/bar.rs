//! The aluminium bar of 0.3 × 0.03 × 0.01 m that hangs on its end faces, and what CalculiX finds for its mesh of 20 × 3 × 2 C3D20.

pub const ALUMINIUM: &str = r#"
[materials.aluminium]
youngs_modulus = 70.0e9
poissons_ratio = 0.33
density = 2700.0
"#;

pub const CLAMP: &str = r#"
[joints.clamp]
type = "fixed"
parent = { body = "ground", point = [0.0, 0.0, 0.0] }
child = { body = "beam", face = "x-" }
"#;

pub const HINGE: &str = r#"
[joints.clamp]
type = "revolute"
axis = [0.0, 1.0, 0.0]
parent = { body = "ground", point = [0.0, 0.0, 0.0] }
child = { body = "beam", face = "x-" }
"#;

pub const OTHER_HINGE: &str = r#"
[joints.other]
type = "revolute"
axis = [0.0, 1.0, 0.0]
closes_loop = true
parent = { body = "ground", point = [0.3, 0.0, 0.0] }
child = { body = "beam", face = "x+" }
"#;

/// Clamped on the mean of its face, CalculiX 2.20 (docs/verification.md) \[Hz\]; it prints seven digits.
pub const CLAMPED_BRICKS: [f64; 3] = [91.33328, 272.0491, 570.1875];
/// Hinged about y at both ends \[Hz\].
pub const HINGED_BRICKS: [f64; 2] = [256.1865, 1020.540];

/// The bar of splines, of ten free modes.
pub const OF_SPLINES: &str = r#"
[bodies.beam]
material = "aluminium"
geometry = { shape = "box", size = [0.3, 0.03, 0.01] }
discretisation = { degree = 3, elements = [20, 3, 2] }
reduction = { modes = 10 }
"#;

/// The same of finite elements.
pub const OF_ELEMENTS: &str = r#"
[bodies.beam]
model = "mesh"
file = "bar.msh"
units = "mm"
material = "aluminium"
reduction = { method = "modal", modes = 10 }
"#;

/// The same from the file of another program.
pub const FROM_A_FILE: &str = r#"
[bodies.beam]
model = "imported"
file = "bar.h5"
reduction = { method = "modal", modes = 10 }
"#;
