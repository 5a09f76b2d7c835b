//! A body's exact geometry: patches, named points, singular lines.

pub mod lengths;
pub mod symmetry;

use std::collections::BTreeMap;

use super::Patch;
use super::interface::FaceId;
use super::jet::dot;
use super::patch::PointBasis;
use crate::SplineError;
use crate::nurbs::Face;
use symmetry::Symmetry;

/// Where a parametrisation is singular: all parameter points of `patch` whose fixed parameters
/// agree.
#[derive(Debug, Clone, PartialEq)]
pub struct SingularSet {
    /// Index of the patch.
    pub patch: usize,
    /// Fixed value per direction, `None` where it runs freely.
    pub parameters: [Option<f64>; 3],
    /// Name for messages, such as "pole z = +r".
    pub name: String,
}

impl SingularSet {
    /// Whether the closed parameter box `[lower, upper]` touches the set.
    pub fn touches(&self, lower: &[f64; 3], upper: &[f64; 3]) -> bool {
        let margin = |d: usize| 1e-12 * (1.0 + lower[d].abs().max(upper[d].abs())); // round-off of parameters
        self.parameters
            .iter()
            .enumerate()
            .all(|(d, p)| p.is_none_or(|v| lower[d] - margin(d) <= v && v <= upper[d] + margin(d)))
    }
}

/// Exact geometry of a body in its own frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// The patches; neighbours share coincident control points.
    pub patches: Vec<Patch>,
    /// Named points \[m\], in the model's components (`(r, z)` for axisymmetric shapes).
    pub markers: BTreeMap<String, [f64; 3]>,
    /// Named parts of the surface, each made of faces of the patches; bars have their end faces
    /// under "start" and "end" as well.
    pub faces: BTreeMap<String, Vec<FaceId>>,
    /// Singular points, lines and faces of the parametrisation.
    pub singular: Vec<SingularSet>,
    /// Rotations that leave the body as it is, if any are known.
    pub symmetry: Option<Symmetry>,
    /// Number of patches per direction into which each one that was given is cut ([`Shape::cut`]),
    /// the least of all of them.
    pub parts: [usize; 3],
}

impl Shape {
    /// A shape from patches given point by point: no markers, singular sets found by
    /// [`singular_sets`]. The outer faces are called `xi-`, `xi+`, `eta-` … after the parameter
    /// that is at an end of its range; a face of several patches is made of those of each.
    ///
    /// # Errors
    /// [`SplineError::Folded`] if a patch is inside out or folded.
    pub fn from_patches(patches: Vec<Patch>) -> Result<Self, SplineError> {
        let singular = patches.iter().enumerate().flat_map(|(i, p)| singular_sets(i, p)).collect();
        let faces = parametric_faces(&patches);
        let shape =
            Self { patches, markers: BTreeMap::new(), faces, singular, symmetry: None, parts: [1; 3] };
        shape.check_orientation()?;
        Ok(shape)
    }

    /// The singular set that a contact window touches, if any: `[lower, upper]` is a closed box in
    /// the parameters of patch `patch`; on a face the fixed direction has equal ends.
    pub fn singular_in(&self, patch: usize, lower: &[f64; 3], upper: &[f64; 3]) -> Option<&SingularSet> {
        self.singular.iter().find(|s| s.patch == patch && s.touches(lower, upper))
    }

    /// The shape turned by the matrix `rotation` (rows) about the origin of its frame, a rotation
    /// or another map that its symmetry has; singular sets and faces keep names.
    ///
    /// # Errors
    /// As [`Patch::new`], for a matrix that is not finite.
    pub fn rotated(&self, rotation: &[[f64; 3]; 3]) -> Result<Self, SplineError> {
        let turn = |p: &[f64; 3]| rotation.map(|row| dot(&row, p));
        Ok(Self {
            patches: self.patches.iter().map(|patch| patch.rotated(rotation)).collect::<Result<_, _>>()?,
            markers: self.markers.iter().map(|(name, p)| (name.clone(), turn(p))).collect(),
            faces: self.faces.clone(),
            singular: self.singular.clone(),
            symmetry: self.symmetry.as_ref().and_then(|s| s.rotated(rotation)),
            parts: self.parts,
        })
    }

    /// Checks that no patch is folded or inside out.
    ///
    /// # Errors
    /// As [`Patch::check_orientation`].
    pub fn check_orientation(&self) -> Result<(), SplineError> {
        self.patches.iter().try_for_each(Patch::check_orientation)
    }
}

impl Patch {
    /// The patch turned by the rotation matrix `rotation` (rows) about the origin of its frame.
    ///
    /// # Errors
    /// As [`Patch::new`], for a matrix that is not finite.
    pub fn rotated(&self, rotation: &[[f64; 3]; 3]) -> Result<Self, SplineError> {
        let points = self.control_points().iter().map(|p| rotation.map(|row| dot(&row, p)));
        Self::new(self.knots().to_vec(), points.collect(), self.weights().to_vec())
    }

    /// Checks that no element is folded or inside out, by the sign of `det ∂x/∂ξ` at interior
    /// points of each element.
    ///
    /// # Errors
    /// [`SplineError::Folded`] with the first place found.
    pub fn check_orientation(&self) -> Result<(), SplineError> {
        let mut scratch = PointBasis::default();
        let n = self.dimension();
        for e in 0..self.n_elements() {
            let (lower, upper) = self.element(e);
            for sample in 0..3usize.pow(n as u32) {
                let mut parameters = [0.0; 3];
                for (d, u) in parameters.iter_mut().enumerate().take(n) {
                    let s = [0.02, 0.5, 0.98][sample / 3usize.pow(d as u32) % 3];
                    *u = lower[d] + s * (upper[d] - lower[d]);
                }
                let determinant = self.jet_on(e, &parameters, 1, &mut scratch).determinant(n);
                if determinant.is_nan() || determinant <= 0.0 {
                    return Err(SplineError::Folded { determinant, parameters });
                }
            }
        }
        Ok(())
    }
}

/// Names of the ends of the parametric directions.
const PARAMETRIC: [[&str; 2]; 3] = [["xi-", "xi+"], ["eta-", "eta+"], ["zeta-", "zeta+"]];

/// The outer faces by the parameter that is fixed on them.
fn parametric_faces(patches: &[Patch]) -> BTreeMap<String, Vec<FaceId>> {
    let mut faces: BTreeMap<String, Vec<FaceId>> = BTreeMap::new();
    for face in Face::outer(patches, false) {
        let name = PARAMETRIC[face.id.direction][usize::from(face.id.upper)];
        faces.entry(name.to_owned()).or_default().push(face.id);
    }
    faces
}

/// Corners, edges and faces of a patch's parameter box on which `det ∂x/∂ξ` vanishes throughout,
/// the largest ones only.
pub fn singular_sets(index: usize, patch: &Patch) -> Vec<SingularSet> {
    let (lower, upper) = patch.domain();
    let n = patch.dimension();
    let scale = determinant_scale(patch);
    let mut found: Vec<SingularSet> = Vec::new();
    // Each direction is at its lower end, at its upper end, or free; sets with few fixed directions
    // come first.
    let mut candidates: Vec<[usize; 3]> = (0..3usize.pow(n as u32))
        .map(|c| [c % 3, c / 3 % 3, c / 9].map(|v| 2 - v))
        .filter(|c| c[..n].iter().any(|&v| v != 2))
        .collect();
    candidates.sort_by_key(|c| c[..n].iter().filter(|&&v| v != 2).count());
    for candidate in candidates {
        let mut parameters = [None; 3];
        for d in 0..n {
            parameters[d] = [Some(lower[d]), Some(upper[d]), None][candidate[d]];
        }
        let inside =
            |s: &SingularSet| (0..3).all(|d| s.parameters[d].is_none() || s.parameters[d] == parameters[d]);
        if !found.iter().any(inside) && vanishes(patch, &parameters, scale) {
            let text: Vec<String> =
                parameters[..n].iter().map(|p| p.map_or("·".into(), |v| v.to_string())).collect();
            let name = format!("singular set at parameters ({})", text.join(", "));
            found.push(SingularSet { patch: index, parameters, name });
        }
    }
    found
}

/// Product of the largest tangents found at sample points.
fn determinant_scale(patch: &Patch) -> f64 {
    let mut largest = [0.0f64; 3];
    for xi in samples(patch, &[None; 3]) {
        let jet = patch.jet(&xi, 1, &mut PointBasis::default());
        for (m, t) in largest.iter_mut().zip(&jet.first) {
            *m = m.max(super::jet::norm(t));
        }
    }
    largest[..patch.dimension()].iter().product()
}

fn vanishes(patch: &Patch, parameters: &[Option<f64>; 3], scale: f64) -> bool {
    let mut scratch = PointBasis::default();
    // Determinants of exact singular points come out at round-off, some 1e-16 of the scale.
    samples(patch, parameters)
        .iter()
        .all(|xi| patch.jet(xi, 1, &mut scratch).determinant(patch.dimension()).abs() < 1e-12 * scale)
}

fn samples(patch: &Patch, parameters: &[Option<f64>; 3]) -> Vec<[f64; 3]> {
    const SHARES: [f64; 5] = [0.07, 0.23, 0.41, 0.66, 0.91];
    let (lower, upper) = patch.domain();
    let mut points = vec![[0.0; 3]];
    for d in 0..patch.dimension() {
        let values = match parameters[d] {
            Some(v) => vec![v],
            None => SHARES.iter().map(|s| lower[d] + s * (upper[d] - lower[d])).collect(),
        };
        points = points
            .iter()
            .flat_map(|p| {
                values.iter().map(|&v| {
                    let mut q = *p;
                    q[d] = v;
                    q
                })
            })
            .collect();
    }
    points
}
