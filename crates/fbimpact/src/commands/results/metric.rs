//! `fbimpact metric`: values of expressions over a result, as JSON.

use std::path::Path;

use result_files::expression::named::NamedExpression;
use result_files::expression::source::Source;
use result_files::expression::value::Value;
use result_files::stored::Stored;
use serde_json::{Map, Value as Json, json};

use crate::commands::print;
use crate::error::{AppError, CommandFault};

/// Prints an object with an entry for each expression, by its name.
///
/// # Errors
/// [`AppError::Io`] if the file cannot be read, [`AppError::Command`] for an expression that has no value.
pub fn metric(file: &Path, expressions: &[NamedExpression]) -> Result<(), AppError> {
    let stored = Stored::open(file)?;
    let source = Source::new(&stored);
    let mut object = Map::new();
    for expression in expressions {
        let found = expression
            .value(&source)
            .map_err(|fault| CommandFault::Expression { option: "metric", fault })?;
        if object.insert(expression.name.clone(), entry(&found)).is_some() {
            return Err(CommandFault::column_twice(&expression.name).into());
        }
    }
    print(&format!("{:#}\n", Json::Object(object)))
}

/// Value, unit and names of components; what is no number is null.
fn entry(value: &Value) -> Json {
    let row = |row: &[f64]| match value.width {
        None => json!(row[0]),
        Some(_) => json!(row),
    };
    let stride = value.width.unwrap_or(1).max(1);
    let shown = match value.rows {
        None => row(&value.data),
        Some(_) => Json::Array(value.data.chunks(stride).map(row).collect()),
    };
    let mut entry = Map::from_iter([("value".to_owned(), shown)]);
    if !value.unit.is_empty() {
        entry.insert("unit".into(), json!(value.unit));
    }
    if !value.labels.is_empty() {
        entry.insert("components".into(), json!(value.labels));
    }
    Json::Object(entry)
}
