//! The language in which the key tables are written: one declaration a key, from which the reader,
//! the JSON schema and the reference page `docs/scenario.md` all follow.

pub(super) mod units;
pub(super) mod column_units;

/// One key of a table.
#[derive(Debug)]
pub struct Key {
    /// Name.
    pub name: &'static str,
    /// Type and allowed values.
    pub kind: Kind,
    /// Unit, "–" for plain numbers, empty for what is not a number.
    pub unit: &'static str,
    /// Whether it must be given.
    pub need: Need,
    /// One sentence.
    pub doc: &'static str,
    /// Whether `<name>_deg` in degrees may be given instead.
    pub degrees: bool,
    /// What must hold, all of it, for the key to have a meaning. Beside it the key is a fault, and
    /// its default is not written.
    pub when: &'static [Condition],
}

impl Key {
    /// A key that must be given and has no unit; what follows says the rest.
    pub const fn new(name: &'static str, kind: Kind) -> Self {
        Self { name, kind, unit: "", need: Need::Required, doc: "", degrees: false, when: &[] }
    }

    /// A key for numbers of `unit`, "–" for plain ones.
    pub const fn measured(name: &'static str, kind: Kind, unit: &'static str) -> Self {
        Self { unit, ..Self::new(name, kind) }
    }

    /// A key that may also be given in degrees as `<name>_deg`.
    pub const fn angle(name: &'static str, kind: Kind, unit: &'static str) -> Self {
        Self { degrees: true, ..Self::measured(name, kind, unit) }
    }

    /// The key must be given.
    pub const fn required(self) -> Self {
        Self { need: Need::Required, ..self }
    }

    /// The key may be left out; `text` says what holds then.
    pub const fn otherwise(self, text: &'static str) -> Self {
        Self { need: Need::Optional(text), ..self }
    }

    /// The same, with a text that is made from the numbers of the program.
    pub const fn derived(self, text: fn() -> String) -> Self {
        Self { need: Need::Derived(text), ..self }
    }

    /// The key has a default, in TOML.
    pub const fn default(self, value: &'static str) -> Self {
        Self { need: Need::Default(value), ..self }
    }

    /// The default is a number of the program.
    pub const fn constant(self, value: f64) -> Self {
        Self { need: Need::Constant(value), ..self }
    }

    /// The key's sentence.
    pub const fn doc(self, doc: &'static str) -> Self {
        Self { doc, ..self }
    }

    /// The key with conditions under which it has a meaning.
    pub const fn when(self, when: &'static [Condition]) -> Self {
        Self { when, ..self }
    }

    /// Its conditions as sentences, each with a space before it.
    pub fn conditions(&self) -> String {
        let sentence = |c: &Condition| format!(" Only {}{}.", c.words, c.behind_comma());
        self.when.iter().map(sentence).collect()
    }
}

/// A condition under which a key has a meaning.
#[derive(Debug, Clone, Copy)]
pub struct Condition {
    /// When it holds, in words that follow "has a meaning" and precede "only", such as
    /// `for bodies with model "rigid"`.
    pub words: &'static str,
    /// What to give instead, or why; empty where the words say enough.
    pub remark: &'static str,
    /// The condition.
    pub test: Test,
}

impl Condition {
    /// A condition in words and as a test.
    pub const fn new(words: &'static str, test: Test) -> Self {
        Self { words, remark: "", test }
    }

    /// The condition with a remark that follows its words.
    pub const fn remark(self, remark: &'static str) -> Self {
        Self { remark, ..self }
    }

    /// The remark behind a comma, empty without one.
    pub fn behind_comma(&self) -> String {
        if self.remark.is_empty() { String::new() } else { format!(", {}", self.remark) }
    }
}

/// What a condition asks. Where an answer depends on a value at fault, the condition counts as
/// holding: one fault is enough.
#[derive(Debug, Clone, Copy)]
pub enum Test {
    /// The key of the table, its default counted, has one of the values. `a.b` is key `b` of the
    /// subtable `a`.
    OneOf(&'static str, &'static [&'static str]),
    /// The key has none of the values, or is not there.
    NoneOf(&'static str, &'static [&'static str]),
    /// The key, `true` or `false`, is `false`.
    IsFalse(&'static str),
    /// The key is given.
    With(&'static str),
    /// The key is not given.
    Without(&'static str),
    /// One of the tests holds.
    Any(&'static [Test]),
    /// All tests hold.
    All(&'static [Test]),
    /// The test holds for the table around this one, a name between them not counted.
    Around(&'static Test),
    /// What follows from several tables, or from a file.
    Fact(Fact),
}

/// Facts on which the meaning of keys depends and that no single table shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fact {
    /// The body of the table is the child of no joint.
    IsChildOfNoJoint,
    /// The body of the table does not come from a file with a reduced body.
    IsNotReduced,
    /// The contact around the table refines its contact zone by itself.
    IsRefined,
    /// The contact around the table raises its penalty factor until the peak force has converged.
    SearchConverges,
    /// Neither body of the contact of the table is of finite elements.
    IsOnSplines,
    /// The contact body of the contact of the table is flexible.
    IsOnFlexible,
}

/// Whether a key must be given.
#[derive(Debug, Clone, Copy)]
pub enum Need {
    /// Must be given.
    Required,
    /// May be left out; the text says what happens then.
    Optional(&'static str),
    /// May be left out; the text, which cites the library's constants, says what happens then.
    Derived(fn() -> String),
    /// Has a default, written as TOML.
    Default(&'static str),
    /// Has a number as default, a constant of the library.
    Constant(f64),
}

impl Need {
    /// What happens if the key is left out, where that is not a default.
    pub fn otherwise(&self) -> Option<String> {
        match self {
            Self::Optional(text) => Some((*text).to_owned()),
            Self::Derived(text) => Some(text()),
            Self::Required | Self::Default(_) | Self::Constant(_) => None,
        }
    }

    /// The default as TOML.
    pub fn default(&self) -> Option<String> {
        match self {
            Self::Default(text) => Some((*text).to_owned()),
            Self::Constant(number) => Some(format!("{number:?}")),
            Self::Required | Self::Optional(_) | Self::Derived(_) => None,
        }
    }
}

/// Interval of allowed numbers. NaN and infinities are never allowed.
#[derive(Debug, Clone, Copy)]
pub struct Range {
    /// Lower bound.
    pub min: Bound,
    /// Upper bound.
    pub max: Bound,
}

/// End of an interval.
#[derive(Debug, Clone, Copy)]
pub enum Bound {
    /// The bound itself is allowed.
    Closed(f64),
    /// The bound itself is not allowed.
    Open(f64),
}

impl Range {
    /// `0 < x <= max`.
    pub const fn positive(max: f64) -> Self {
        Self { min: Bound::Open(0.0), max: Bound::Closed(max) }
    }

    /// `min` to `max`, both allowed.
    pub const fn closed(min: f64, max: f64) -> Self {
        Self { min: Bound::Closed(min), max: Bound::Closed(max) }
    }

    /// `min` to `max`, none of them allowed.
    pub const fn open(min: f64, max: f64) -> Self {
        Self { min: Bound::Open(min), max: Bound::Open(max) }
    }

    /// `-max <= x <= max`.
    pub const fn within(max: f64) -> Self {
        Self::closed(-max, max)
    }

    /// Whether `x` lies inside.
    pub fn contains(&self, x: f64) -> bool {
        let above = match self.min {
            Bound::Closed(b) => x >= b,
            Bound::Open(b) => x > b,
        };
        let below = match self.max {
            Bound::Closed(b) => x <= b,
            Bound::Open(b) => x < b,
        };
        above && below
    }

    /// The same of numbers in another unit, of which this one has `factor`.
    pub fn times(&self, factor: f64) -> Self {
        let scaled = |bound: &Bound| match bound {
            Bound::Closed(b) => Bound::Closed(b * factor),
            Bound::Open(b) => Bound::Open(b * factor),
        };
        Self { min: scaled(&self.min), max: scaled(&self.max) }
    }

    /// In words, such as "> 0 and <= 1e6".
    pub fn words(&self) -> String {
        let low = match self.min {
            Bound::Closed(b) => format!(">= {}", plain(b)),
            Bound::Open(b) => format!("> {}", plain(b)),
        };
        let high = match self.max {
            Bound::Closed(b) => format!("<= {}", plain(b)),
            Bound::Open(b) => format!("< {}", plain(b)),
        };
        format!("{low} and {high}")
    }
}

/// A bound without a superfluous ".0".
pub fn plain(x: f64) -> String {
    let text = format!("{x:?}");
    text.strip_suffix(".0").map(str::to_owned).unwrap_or(text)
}

/// A named value.
#[derive(Debug)]
pub struct Choice {
    /// Name in the scenario.
    pub name: &'static str,
    /// What it means.
    pub doc: &'static str,
    /// What other programs call it, to lead on those who know them.
    pub elsewhere: &'static [&'static str],
}

impl Choice {
    /// A value that other programs call the same, or nothing.
    pub const fn new(name: &'static str, doc: &'static str) -> Self {
        Self { name, doc, elsewhere: &[] }
    }

    /// The same with the words of other programs for it.
    #[must_use]
    pub const fn elsewhere(self, words: &'static [&'static str]) -> Self {
        Self { elsewhere: words, ..self }
    }
}

/// Values of a key that has few names.
pub trait Named: Copy + PartialEq + 'static {
    /// The names, with what they mean, in the order of [`Named::VALUES`].
    const CHOICES: &'static [Choice];
    /// All values.
    const VALUES: &'static [Self];

    /// Name in the scenario.
    fn name(self) -> &'static str;

    /// The value of that name.
    fn named(name: &str) -> Option<Self> {
        Self::VALUES.iter().copied().find(|value| value.name() == name)
    }
}

/// Gives every value of an enumeration its name in the scenario: one that is left out does not
/// compile.
macro_rules! name_values {
    ($kind:ty { $($value:ident: $name:literal, $doc:expr $(, elsewhere $words:expr)?;)* }) => {
        impl $crate::scenario::keys::Named for $kind {
            const CHOICES: &'static [$crate::scenario::keys::Choice] =
                &[$($crate::scenario::keys::Choice::new($name, $doc)$(.elsewhere(&$words))?),*];
            const VALUES: &'static [Self] = &[$(Self::$value),*];

            fn name(self) -> &'static str {
                match self {
                    $(Self::$value => $name,)*
                }
            }
        }
    };
}
pub(crate) use name_values;

/// The same of an enumeration whose values decide on the other keys of their table.
macro_rules! name_variants {
    ($kind:ty { $($value:ident: $name:literal, $doc:expr $(, elsewhere $words:expr)?, keys $keys:expr;)* }) => {
        $crate::scenario::keys::name_values!($kind { $($value: $name, $doc $(, elsewhere $words)?;)* });

        impl $kind {
            /// The values with their keys.
            pub const VARIANTS: &'static [$crate::scenario::keys::Variant] = &[$(
                $crate::scenario::keys::Variant {
                    choice: $crate::scenario::keys::Choice::new($name, $doc)$(.elsewhere(&$words))?,
                    keys: $keys,
                }
            ),*];
        }
    };
}
pub(crate) use name_variants;

/// Type of a key.
#[derive(Debug)]
pub enum Kind {
    /// Any string.
    Text,
    /// A string that names something else in the scenario and is not empty.
    Name,
    /// A number.
    Number(Range),
    /// `true` or `false`.
    Boolean,
    /// One number, or a list of numbers.
    Numbers(Range),
    /// Three principal values or three rows of a symmetric matrix.
    Symmetric(Range),
    /// A number, or a table whose other keys depend on the key `tag`.
    NumberOrVariants {
        /// Range of the number.
        range: Range,
        /// The key that decides.
        tag: &'static str,
        /// Its values with their keys.
        variants: &'static [Variant],
    },
    /// An integer, bounds included.
    Integer(u64, u64),
    /// An integer for all directions or a list with one per direction.
    Counts(u64, u64),
    /// One of a few names.
    Choice(&'static [Choice]),
    /// Some of a few names.
    Choices(&'static [Choice]),
    /// Exactly as many numbers.
    Vector(usize, Range),
    /// A rotation vector (3 numbers) or a quaternion `w x y z` (4 numbers).
    Rotation,
    /// Two or three coordinates.
    Point(Range),
    /// Any number of numbers.
    List(Range),
    /// Lists of numbers.
    Lists(Range),
    /// Points with two or three coordinates.
    Points(Range),
    /// A marker's name or a point.
    Place(Range),
    /// One of a few names or a number.
    ChoiceOrNumber(&'static [Choice], Range),
    /// A table with fixed keys.
    Table(&'static [Key]),
    /// A table whose keys are names that the user gives.
    Named(&'static [Key]),
    /// The same with names that a file gives, of any characters.
    NamedByFile(&'static [Key]),
    /// A table of lists of strings, whose keys are names that the user gives.
    NameLists,
    /// An array of tables.
    Tables(&'static [Key]),
    /// A table whose other keys depend on the key `tag`.
    Variants {
        /// The key that decides.
        tag: &'static str,
        /// Its values with their keys.
        variants: &'static [Variant],
    },
}

/// One form of a [`Kind::Variants`] table.
#[derive(Debug)]
pub struct Variant {
    /// Value of the tag.
    pub choice: Choice,
    /// The other keys.
    pub keys: &'static [Key],
}

impl Kind {
    /// What is allowed, in words that follow "must be".
    pub fn allowed(&self, unit: &str) -> String {
        let unit = if unit.is_empty() || unit == "–" { String::new() } else { format!(" {unit}") };
        match self {
            Self::Text => "a string".into(),
            Self::Name => "a string that is not empty".into(),
            Self::Number(range) => format!("a number {}{unit}", range.words()),
            Self::Boolean => "true or false".into(),
            Self::Numbers(range) => format!("a number {0}{unit}, or a list of such numbers", range.words()),
            Self::Symmetric(range) => format!(
                "3 numbers on a diagonal or 3 rows of 3 numbers, symmetric, each {}{unit}",
                range.words()
            ),
            Self::NumberOrVariants { range, .. } => {
                format!("a number {}{unit}, or a table", range.words())
            }
            Self::Integer(min, max) => format!("an integer >= {min} and <= {max}"),
            Self::Counts(min, max) => {
                format!("an integer >= {min} and <= {max}, or a list of 2 or 3 such integers")
            }
            Self::Choice(choices) => names(choices.iter().map(|c| c.name)),
            Self::Choices(choices) => format!("a list of some of {}", names(choices.iter().map(|c| c.name))),
            Self::Vector(n, range) => format!("a list of {n} numbers {}{unit}", range.words()),
            Self::Rotation => "a rotation vector of 3 numbers or a quaternion [w, x, y, z]".into(),
            Self::Point(range) => format!("a list of 2 or 3 coordinates {}{unit}", range.words()),
            Self::List(range) => format!("a list of numbers {}{unit}", range.words()),
            Self::Lists(range) => {
                format!("a list with one list of numbers per direction, each {}", range.words())
            }
            Self::Points(range) => {
                format!("a list of points with 2 or 3 coordinates {}{unit}", range.words())
            }
            Self::Place(range) => {
                format!("a marker's name or a list of 2 or 3 coordinates {}{unit}", range.words())
            }
            Self::ChoiceOrNumber(choices, range) => {
                format!("{} or a number {}{unit}", names(choices.iter().map(|c| c.name)), range.words())
            }
            Self::Table(_) | Self::Variants { .. } => "a table".into(),
            Self::Named(_) | Self::NamedByFile(_) => "a table of named tables".into(),
            Self::NameLists => "a table of named lists of strings".into(),
            Self::Tables(_) => "an array of tables".into(),
        }
    }
}

/// `"a"`, `"b"` or `"c"`.
pub fn names<'a>(list: impl Iterator<Item = &'a str>) -> String {
    let mut quoted: Vec<String> = list.map(|n| format!("\"{n}\"")).collect();
    // Neighbours that are one: a name of the scenario's own and the standard one.
    quoted.dedup();
    match quoted.split_last() {
        None => "(none)".into(),
        Some((only, [])) => only.clone(),
        Some((last, rest)) => format!("{} or {last}", rest.join(", ")),
    }
}
