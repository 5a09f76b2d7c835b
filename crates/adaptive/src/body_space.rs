//! The spline space of a body: a plain one, or a hierarchical one over its only patch.

use iga_core::SplineError;
use iga_core::hierarchical::HierarchicalSpace;
use iga_core::nurbs::Patch;
use iga_core::space::{PatchSpace, Space};
use iga_core::surface::{
    CollocationPoint, Face, gauss_points, greville_points, hierarchical_greville_points,
};

/// Either kind of space. Everything that both can do goes through [`Space`], to which it dereferences.
#[derive(Debug, Clone)]
pub enum BodySpace {
    /// The functions of the patches themselves.
    Plain(PatchSpace),
    /// Local refinement over one patch.
    Hierarchical(Box<HierarchicalSpace>),
}

impl BodySpace {
    /// The space of the patches themselves.
    ///
    /// # Errors
    /// As [`PatchSpace::new`].
    pub fn plain(patches: &[Patch]) -> Result<Self, SplineError> {
        Ok(Self::Plain(PatchSpace::new(patches.to_vec())?))
    }

    /// Whatever it is, as the trait.
    pub fn as_space(&self) -> &(dyn Space + 'static) {
        match self {
            Self::Plain(space) => space,
            Self::Hierarchical(space) => &**space,
        }
    }

    /// Diagonal of the box around the control points \[m\].
    pub fn size(&self) -> f64 {
        let points = self.as_space().control_points();
        let mut sum = 0.0;
        for c in 0..3 {
            let range = points.iter().map(|p| p[c]);
            let (least, most) =
                range.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
            sum += (most - least).powi(2);
        }
        sum.sqrt()
    }

    /// Greville points of the functions on faces of `patches`, which are those of the space or of its coarsest level.
    pub fn greville_points(&self, patches: &[Patch], faces: &[Face]) -> Vec<CollocationPoint> {
        match self {
            Self::Plain(space) => greville_points(space, patches, faces),
            Self::Hierarchical(space) => hierarchical_greville_points(space, &patches[0], faces),
        }
    }

    /// Gauss points of the elements on faces, as many as the elements' matrices take.
    pub fn gauss_points(&self, patches: &[Patch], faces: &[Face]) -> Vec<CollocationPoint> {
        gauss_points(self.as_space(), patches, faces, None)
    }
}

impl std::ops::Deref for BodySpace {
    type Target = dyn Space;

    fn deref(&self) -> &Self::Target {
        self.as_space()
    }
}
