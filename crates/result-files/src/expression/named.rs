//! Expressions with names, as command lines give them.

use std::str::FromStr;

use super::evaluate::evaluate;
use super::fault::ExpressionFault;
use super::parse::{Expression, parse};
use super::source::Source;
use super::value::Value;

/// `NAME=EXPRESSION`, or an expression that is its own name.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedExpression {
    /// What its value is called.
    pub name: String,
    /// The expression.
    pub expression: Expression,
}

impl FromStr for NamedExpression {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, expression) = match text.split_once('=') {
            None => (text.trim(), text),
            Some((name, expression)) => {
                let name = name.trim();
                let is_plain = |c: char| c.is_ascii_alphanumeric() || "._-[]".contains(c);
                if name.is_empty() || !name.chars().all(is_plain) {
                    return Err(
                        "names have letters, digits, \"_\", \"-\" and \".\"; wanted is NAME=EXPRESSION"
                            .into(),
                    );
                }
                (name, expression)
            }
        };
        let expression = parse(expression).map_err(|fault| fault.to_string())?;
        Ok(Self { name: name.to_owned(), expression })
    }
}

/// A named expression that must have a name of its own.
///
/// # Errors
/// As [`NamedExpression::from_str`].
pub fn column(text: &str) -> Result<NamedExpression, String> {
    if !text.contains('=') {
        return Err("wanted is NAME=EXPRESSION, such as v=bodies.ball.velocity[-1].z".into());
    }
    text.parse()
}

impl NamedExpression {
    /// Its value in `source`.
    ///
    /// # Errors
    /// [`ExpressionFault`].
    pub fn value(&self, source: &Source<'_>) -> Result<Value, ExpressionFault> {
        evaluate(&self.expression, source)
    }

    /// Its value as cells of a table, a name each: one number, or the components of a row.
    ///
    /// # Errors
    /// [`ExpressionFault`], also of a series.
    pub fn cells(&self, source: &Source<'_>) -> Result<Vec<Cell>, ExpressionFault> {
        let value = self.value(source)?;
        if value.rows.is_some() {
            let message = format!(
                "{} does not fit a cell; take a row, such as [-1], or a function such as max(…)",
                value.shown()
            );
            return Err(ExpressionFault::new(&self.expression.text, (0, message)));
        }
        let name = |c: usize| match (value.width, value.labels.get(c)) {
            (None, _) => self.name.clone(),
            (Some(_), Some(label)) => format!("{}.{label}", self.name),
            (Some(_), None) => format!("{}[{c}]", self.name),
        };
        let cell = |(c, x): (usize, &f64)| Cell { name: name(c), unit: value.unit.clone(), number: *x };
        Ok(value.data.iter().enumerate().map(cell).collect())
    }
}

/// A number with a name.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// Name of the column.
    pub name: String,
    /// Unit; empty if it is not known.
    pub unit: String,
    /// The number.
    pub number: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stand_before_the_first_equals_sign() {
        let named: NamedExpression = "v.end = time[-1]".parse().expect("right");
        assert_eq!((named.name.as_str(), named.expression.text.as_str()), ("v.end", " time[-1]"));
        assert_eq!("max(time)".parse::<NamedExpression>().expect("right").name, "max(time)");
        for text in ["=time", "a b=time", "v=", "v=time[", "a,b=time"] {
            assert!(text.parse::<NamedExpression>().is_err(), "{text}");
        }
        assert!(column("time").is_err());
    }
}
