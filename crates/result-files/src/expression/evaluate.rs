//! From a tree to a value.

use super::fault::{ExpressionFault, FaultAt};
use super::parse::{Expression, Node, Step, Taken};
use super::source::Source;
use super::value::Value;

/// The value of `expression` in the result `source`.
///
/// # Errors
/// [`ExpressionFault`] with the place of the part that has no value, and why.
pub fn evaluate(expression: &Expression, source: &Source<'_>) -> Result<Value, ExpressionFault> {
    value(&expression.tree, source).map_err(|fault| ExpressionFault::new(&expression.text, fault))
}

fn value(node: &Node, source: &Source<'_>) -> Result<Value, FaultAt> {
    match node {
        Node::Number(x) => Ok(Value::number(*x, "–")),
        Node::Path(steps, _) => {
            let (found, rest) = source.find(steps)?;
            part(found, rest)
        }
        Node::Part(of, steps) => part(value(of, source)?, steps),
        Node::Negative(of) => {
            let found = value(of, source)?;
            Ok(found.mapped(&found.unit, |x| -x))
        }
        Node::Call(function, arguments, at) => {
            let values = arguments.iter().map(|a| value(a, source)).collect::<Result<Vec<_>, FaultAt>>()?;
            function.apply(&values, source.time()).map_err(|reason| (*at, reason))
        }
        Node::Chain(first, rest) => {
            let first = value(first, source)?;
            rest.iter().try_fold(first, |a, (sign, next, at)| {
                joined(*sign, &a, &value(next, source)?).map_err(|reason| (*at, reason))
            })
        }
    }
}

/// Two values with `sign` between them.
fn joined(sign: char, a: &Value, b: &Value) -> Result<Value, String> {
    let of: fn(f64, f64) -> f64 = match sign {
        '+' => |a, b| a + b,
        '-' => |a, b| a - b,
        '*' => |a, b| a * b,
        '/' => |a, b| a / b,
        _ => f64::powf,
    };
    a.with(b, &unit(sign, a, b), of)
}

/// What `steps` take of a value.
fn part(mut value: Value, steps: &[Step]) -> Result<Value, FaultAt> {
    for step in steps {
        let taken = match &step.taken {
            Taken::Name(name) => value.component(name),
            Taken::Index(index) => value.index(*index),
            Taken::Range(from, to) => value.range(*from, *to),
        };
        value = taken.map_err(|reason| (step.at, reason))?;
    }
    Ok(value)
}

/// Unit of a combination where it is known without a calculus of units: that of both terms, that of
/// the factor that has one. Numbers have none, those of the scenario an unknown one.
fn unit(sign: char, a: &Value, b: &Value) -> String {
    let is_plain = |v: &Value| v.unit == "–";
    match sign {
        '+' | '-' if a.unit == b.unit || is_plain(b) => a.unit.clone(),
        '+' | '-' if is_plain(a) => b.unit.clone(),
        _ if a.unit.is_empty() || b.unit.is_empty() => String::new(),
        '*' | '/' if is_plain(b) => a.unit.clone(),
        '*' if is_plain(a) => b.unit.clone(),
        '/' if a.unit == b.unit => "–".into(),
        _ => String::new(),
    }
}
