//! Shapes of rigid bodies that have been integrated: equal ones are integrated once and share their
//! memory.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

use iga_core::SplineError;
use iga_core::elasticity::Model;
use iga_core::elasticity::mass_properties::MassProperties;
use iga_core::nurbs::Shape;

/// Shapes with their integrals, by the hash of their control points.
#[derive(Debug, Default)]
pub struct KnownShapes {
    known: HashMap<u64, Vec<(Arc<Shape>, Model, MassProperties)>>,
}

impl KnownShapes {
    /// The shape, shared with bodies that have the same one, and its integrals.
    ///
    /// # Errors
    /// [`SplineError`] as [`MassProperties::of`].
    pub fn measured(
        &mut self,
        shape: Shape,
        model: &Model,
    ) -> Result<(Arc<Shape>, MassProperties), SplineError> {
        let equal = self.known.entry(hash(&shape)).or_default();
        if let Some((shape, _, properties)) = equal.iter().find(|(s, m, _)| **s == shape && m == model) {
            return Ok((Arc::clone(shape), *properties));
        }
        let properties = MassProperties::of(&shape, model)?;
        let shape = Arc::new(shape);
        equal.push((Arc::clone(&shape), *model, properties));
        Ok((shape, properties))
    }
}

fn hash(shape: &Shape) -> u64 {
    let mut hasher = DefaultHasher::new();
    for x in shape.patches.iter().flat_map(|patch| patch.control_points()).flatten() {
        x.to_bits().hash(&mut hasher);
    }
    hasher.finish()
}

#[cfg(test)]
mod tests {
    use iga_core::nurbs::primitives::solid::cuboid;

    use super::*;

    #[test]
    fn equal_shapes_are_one_and_others_are_not() {
        let mut known = KnownShapes::default();
        let mut of = |size| known.measured(cuboid(size).expect("a box"), &Model::Solid).expect("a volume");
        let (first, first_measures) = of([1.0, 2.0, 3.0]);
        let (second, second_measures) = of([1.0, 2.0, 3.0]);
        let (other, other_measures) = of([1.0, 2.0, 3.5]);
        assert!(Arc::ptr_eq(&first, &second) && !Arc::ptr_eq(&first, &other));
        assert_eq!(first_measures, second_measures);
        assert!(other_measures.volume > first_measures.volume);
    }
}
