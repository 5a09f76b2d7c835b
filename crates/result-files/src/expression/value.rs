//! Values of expressions: a number, a row of components, a series of numbers or of rows.

/// A value.
#[derive(Debug, Clone, PartialEq)]
pub struct Value {
    /// Numbers, row by row.
    pub data: Vec<f64>,
    /// Number of rows; none of a value without.
    pub rows: Option<usize>,
    /// How many numbers each row has; none where a row is a single number.
    pub width: Option<usize>,
    /// Names of the components, if they have any.
    pub labels: Vec<String>,
    /// Unit; empty if it is not known.
    pub unit: String,
    /// Whether the rows are those of the stored instants.
    pub is_over_time: bool,
}

impl Value {
    /// A number.
    pub fn number(x: f64, unit: &str) -> Self {
        Self {
            data: vec![x],
            rows: None,
            width: None,
            labels: Vec::new(),
            unit: unit.to_owned(),
            is_over_time: false,
        }
    }

    /// The number, if it is a single one.
    pub fn single(&self) -> Option<f64> {
        (self.rows.is_none() && self.width.is_none()).then(|| self.data.first().copied()).flatten()
    }

    /// What it is, in words.
    pub fn shown(&self) -> String {
        match (self.rows, self.width) {
            (None, None) => "a number".into(),
            (None, Some(w)) => format!("a row of {w} numbers"),
            (Some(n), None) => format!("a series of {n} numbers"),
            (Some(n), Some(w)) => format!("a series of {n} rows of {w} numbers"),
        }
    }

    /// How many numbers each row has; one if it is a single number.
    fn stride(&self) -> usize {
        self.width.unwrap_or(1)
    }

    /// Names of its components, or how many there are.
    fn components(&self) -> String {
        if self.labels.is_empty() { format!("{} by number", self.stride()) } else { self.labels.join(", ") }
    }

    /// `data` as one row of the same components.
    pub fn row(&self, data: Vec<f64>, unit: &str) -> Self {
        Self { data, rows: None, unit: unit.to_owned(), is_over_time: false, ..self.clone() }
    }

    /// Row `index`, or of a value without rows component `index`; negative ones count from the end.
    ///
    /// # Errors
    /// What there is in its place.
    pub fn index(&self, index: i64) -> Result<Self, String> {
        let of = |n: usize, what: &str| {
            let from_end = if index < 0 { index + n as i64 } else { index };
            let found = usize::try_from(from_end).ok().filter(|i| *i < n);
            found.ok_or_else(|| match n {
                0 => format!("[{index}] is not there, there are no {what}"),
                _ => format!(
                    "[{index}] is not there, {n} {what} are numbered 0 to {}, from the end -1 to -{n}",
                    n - 1
                ),
            })
        };
        match (self.rows, self.width) {
            (Some(n), _) => {
                let (i, stride) = (of(n, "rows")?, self.stride());
                Ok(self.row(self.data[i * stride..(i + 1) * stride].to_vec(), &self.unit))
            }
            (None, Some(w)) => {
                let i = of(w, "components")?;
                Ok(Self::number(self.data[i], &self.unit))
            }
            (None, None) => Err(format!("[{index}] of a single number")),
        }
    }

    /// Rows `from` to before `to`; beyond the ends there are none.
    ///
    /// # Errors
    /// A value without rows.
    pub fn range(&self, from: Option<i64>, to: Option<i64>) -> Result<Self, String> {
        let Some(n) = self.rows else {
            return Err(format!("a range of {}, which has no rows", self.shown()));
        };
        let place = |i: i64| usize::try_from(if i < 0 { i + n as i64 } else { i }).unwrap_or(0).min(n);
        let (from, to) = (from.map_or(0, place), to.map_or(n, place));
        let (to, stride) = (to.max(from), self.stride());
        let data = self.data[from * stride..to * stride].to_vec();
        Ok(Self { data, rows: Some(to - from), is_over_time: false, ..self.clone() })
    }

    /// Component `name` of each row.
    ///
    /// # Errors
    /// What there is in its place.
    pub fn component(&self, name: &str) -> Result<Self, String> {
        let Some(width) = self.width else {
            return Err(format!("\"{name}\" of {}, which has no components", self.shown()));
        };
        let Some(c) = self.labels.iter().position(|label| label == name) else {
            return Err(format!("there is no component \"{name}\", there are {}", self.components()));
        };
        let data = self.data.iter().skip(c).step_by(width).copied().collect();
        Ok(Self { data, width: None, labels: Vec::new(), ..self.clone() })
    }

    /// `of` the rows, a component at a time; of a value without rows of its components.
    ///
    /// # Errors
    /// A value of no rows.
    pub fn reduced(
        &self,
        name: &str,
        of: impl Fn(&mut dyn Iterator<Item = f64>) -> f64,
    ) -> Result<Self, String> {
        if self.data.is_empty() {
            return Err(format!("{name} of {}", self.shown()));
        }
        if self.rows.is_none() {
            return Ok(Self::number(of(&mut self.data.iter().copied()), &self.unit));
        }
        let stride = self.stride();
        let data = (0..stride).map(|c| of(&mut self.data.iter().skip(c).step_by(stride).copied()));
        Ok(self.row(data.collect(), &self.unit))
    }

    /// Length of each row.
    ///
    /// # Errors
    /// A value without components.
    pub fn norm(&self) -> Result<Self, String> {
        let Some(width) = self.width.filter(|w| *w > 0) else {
            return Err(format!("norm of {}, which has no components; abs is its magnitude", self.shown()));
        };
        let data = self.data.chunks(width).map(|row| row.iter().map(|x| x * x).sum::<f64>().sqrt());
        Ok(Self { data: data.collect(), width: None, labels: Vec::new(), ..self.clone() })
    }

    /// `of` every number.
    pub fn mapped(&self, unit: &str, of: impl Fn(f64) -> f64) -> Self {
        Self { data: self.data.iter().map(|x| of(*x)).collect(), unit: unit.to_owned(), ..self.clone() }
    }

    /// `of` the numbers of two values. What has no rows counts for all rows, what has no components
    /// for all components.
    ///
    /// # Errors
    /// Both shapes, if they do not fit.
    pub fn with(&self, other: &Self, unit: &str, of: impl Fn(f64, f64) -> f64) -> Result<Self, String> {
        let one = |a: Option<usize>, b: Option<usize>| match (a, b) {
            (Some(a), Some(b)) if a != b => None,
            _ => Some(a.or(b)),
        };
        let (Some(rows), Some(width)) = (one(self.rows, other.rows), one(self.width, other.width)) else {
            return Err(format!("{} and {} do not fit together", self.shown(), other.shown()));
        };
        let at = |value: &Self, i: usize, c: usize| {
            let row = if value.rows.is_some() { i } else { 0 };
            let component = if value.width.is_some() { c } else { 0 };
            value.data[row * value.stride() + component]
        };
        let (n, w) = (rows.unwrap_or(1), width.unwrap_or(1));
        let pairs = (0..n).flat_map(|i| (0..w).map(move |c| (i, c)));
        let data = pairs.map(|(i, c)| of(at(self, i, c), at(other, i, c))).collect();
        let labels = if self.labels.is_empty() { other.labels.clone() } else { self.labels.clone() };
        // A series that is over time stays so with a series of other rows of the same number only
        // if both are.
        let is_over_time = rows.is_some()
            && (self.rows.is_none() || self.is_over_time)
            && (other.rows.is_none() || other.is_over_time);
        Ok(Self { data, rows, width, labels, unit: unit.to_owned(), is_over_time })
    }
}
