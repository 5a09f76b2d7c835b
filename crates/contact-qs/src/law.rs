//! Contact laws: the penalty law of a surface point, Coulomb's friction, and Hertz's closed forms.

pub mod penalty;
pub mod coulomb;
pub mod hertz;
pub mod ellipse;
pub mod line;
pub mod touch;
pub(crate) mod sliding_work;

pub use coulomb::Friction;
pub use ellipse::HertzEllipse;
pub use hertz::{HertzPair, Solid};
pub use line::LineLaw;
pub use touch::TouchLaw;
