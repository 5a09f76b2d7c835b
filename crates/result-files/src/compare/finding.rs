//! What a comparison finds: deviations of numbers, and differences that are none.

/// The largest deviation of a quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct Deviation {
    /// Path of the dataset, with the component where there are several, or name of the feature.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// The instant \[s\]; `None` for data without time.
    pub time: Option<f64>,
    /// The new value there.
    pub new: f64,
    /// The reference's value there.
    pub reference: f64,
    /// Deviation, less what the interpolation leaves open.
    pub deviation: f64,
    /// Allowed deviation.
    pub allowed: f64,
}

impl Deviation {
    /// Deviation over what is allowed; more than 1 differs.
    pub fn ratio(&self) -> f64 {
        if self.deviation <= 0.0 {
            return 0.0;
        }
        let ratio = self.deviation / self.allowed;
        if ratio.is_nan() { f64::INFINITY } else { ratio }
    }

    /// Whether the deviation is too large.
    pub fn is_difference(&self) -> bool {
        self.ratio() > 1.0
    }
}

/// A difference that is no number: something missing, another shape, another unit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// Path of the dataset or name of the feature.
    pub name: String,
    /// What differs.
    pub what: String,
}

impl Finding {
    /// A finding.
    pub fn new(name: impl Into<String>, what: impl Into<String>) -> Self {
        Self { name: name.into(), what: what.into() }
    }
}
