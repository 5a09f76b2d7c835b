//! JSON schema (draft 2020-12) of the scenario file, from the key tables, so that editors complete
//! and check it.

use serde_json::{Map, Value, json};

use crate::scenario::keys::units;
use crate::scenario::keys::{Bound, Choice, Key, Kind, Need, Range, Test, Variant};
use crate::scenario::tables::SCENARIO;

/// The schema.
pub fn schema() -> Value {
    let mut root = table(SCENARIO);
    let extra = json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "fbimpact scenario",
        "description": "Impacts in flexible multibody systems. SI units and radians; keys that end in _deg are in degrees.",
    });
    if let (Value::Object(root), Value::Object(extra)) = (&mut root, extra) {
        root.extend(extra);
    }
    root
}

/// The schema as indented text with a final newline.
pub fn text() -> String {
    format!("{:#}\n", schema())
}

fn table(keys: &[Key]) -> Value {
    object(keys, None)
}

fn object(keys: &[Key], tag: Option<(&str, &Variant)>) -> Value {
    let mut properties = Map::new();
    let mut required: Vec<&str> = Vec::new();
    if let Some((tag, variant)) = tag {
        properties.insert(
            tag.to_owned(),
            json!({ "const": variant.choice.name, "description": variant.choice.doc }),
        );
        required.push(tag);
    }
    for key in keys {
        properties.insert(key.name.to_owned(), property(key, ""));
        if key.degrees {
            properties.insert(format!("{}_deg", key.name), property(key, " In degrees."));
        }
        if matches!(key.need, Need::Required) {
            required.push(key.name);
        }
    }
    let mut object = json!({
        "type": "object", "properties": properties, "required": required, "additionalProperties": false,
    });
    let conditions = conditions(keys);
    if let (false, Value::Object(object)) = (conditions.is_empty(), &mut object) {
        object.insert("allOf".into(), conditions.into());
    }
    object
}

/// Forbids keys where their conditions do not hold, as far as the table itself shows it; keys with
/// the same condition together.
fn conditions(keys: &[Key]) -> Vec<Value> {
    let mut groups: Vec<(Value, Map<String, Value>)> = Vec::new();
    for key in keys {
        for condition in key.when.iter().filter_map(|condition| test(&condition.test, keys)) {
            let group = match groups.iter().position(|(known, _)| *known == condition) {
                Some(group) => group,
                None => {
                    groups.push((condition, Map::new()));
                    groups.len() - 1
                }
            };
            let names = [Some(key.name.to_owned()), key.degrees.then(|| format!("{}_deg", key.name))];
            groups[group].1.extend(names.into_iter().flatten().map(|name| (name, false.into())));
        }
    }
    let rule = |(condition, keys)| json!({ "if": condition, "else": { "properties": Value::Object(keys) } });
    groups.into_iter().map(rule).collect()
}

/// The schema of tables for which a test holds; none for what other tables decide.
fn test(condition: &Test, keys: &[Key]) -> Option<Value> {
    let all = |tests: &[Test]| tests.iter().map(|t| test(t, keys)).collect::<Option<Vec<_>>>();
    Some(match condition {
        Test::OneOf(key, values) => one_of(key, values, keys),
        Test::NoneOf(key, values) => json!({ "not": one_of(key, values, keys) }),
        Test::IsFalse(key) => json!({ "properties": { *key: { "const": false } } }),
        Test::With(key) => json!({ "required": [key] }),
        Test::Without(key) => json!({ "not": { "required": [key] } }),
        Test::Any(tests) => json!({ "anyOf": all(tests)? }),
        Test::All(tests) => json!({ "allOf": all(tests)? }),
        Test::Around(_) | Test::Fact(_) => return None,
    })
}

/// The schema of tables whose key has one of the values, by its default where it is left out.
fn one_of(key: &str, values: &[&str], keys: &[Key]) -> Value {
    if let Some((table, name)) = key.split_once('.') {
        return json!({ "properties": { table: one_of(name, values, &[]) }, "required": [table] });
    }
    let default = keys.iter().find(|k| k.name == key).and_then(|k| k.need.default());
    let is_default = default.is_some_and(|text| values.contains(&text.trim_matches('"')));
    let required: &[&str] = if is_default { &[] } else { &[key] };
    json!({ "properties": { key: { "enum": values } }, "required": required })
}

fn property(key: &Key, note: &str) -> Value {
    let units: Vec<&str> = match key.unit {
        // Of whatever quantity it is.
        "U" | "U/s" => units::all().flatten().collect(),
        unit if note.is_empty() => units::of(unit).into_iter().map(|(name, _)| name).collect(),
        _ => Vec::new(),
    };
    let mut value = with_units(kind(&key.kind), &units);
    let unit = match key.unit {
        "" | "–" => String::new(),
        unit if note.is_empty() => format!(" [{unit}]"),
        unit => format!(" [{}]", unit.replace("rad", "deg")),
    };
    let mut description = format!("{}{unit}{note}{}", key.doc, key.conditions());
    if let Some(text) = key.need.otherwise() {
        description.push_str(&format!(" Without it: {text}."));
    }
    let Value::Object(map) = &mut value else { unreachable!("a schema is an object") };
    map.insert("description".into(), description.into());
    if let Some(text) = key.need.default()
        && note.is_empty()
        && let Ok(default) = format!("x = {text}").parse::<toml::Table>()
        && let Some(default) = default.get("x")
        && let Ok(default) = serde_json::to_value(default)
    {
        map.insert("default".into(), default);
    }
    value
}

/// The schema with texts such as `10 mm` admitted where it asks for numbers, tables left out.
fn with_units(schema: Value, units: &[&str]) -> Value {
    let Value::Object(mut map) = schema else { return schema };
    if units.is_empty() || map.contains_key("properties") {
        return Value::Object(map);
    }
    if map.get("type").is_some_and(|kind| kind == "number") {
        let pattern = format!("^[-+0-9.eE]+ +({})$", units.join("|"));
        return json!({ "anyOf": [map, { "type": "string", "pattern": pattern }] });
    }
    for key in ["items", "anyOf", "oneOf"] {
        match map.remove(key) {
            Some(Value::Array(forms)) => {
                map.insert(key.into(), forms.into_iter().map(|form| with_units(form, units)).collect());
            }
            Some(other) => {
                map.insert(key.into(), with_units(other, units));
            }
            None => {}
        }
    }
    Value::Object(map)
}

fn kind(kind: &Kind) -> Value {
    match kind {
        Kind::Text => json!({ "type": "string" }),
        Kind::Name => json!({ "type": "string", "minLength": 1 }),
        Kind::Number(range) => number(range),
        Kind::Boolean => json!({ "type": "boolean" }),
        Kind::Numbers(range) => json!({ "anyOf": [number(range), array(&number(range), 1, None)] }),
        Kind::Symmetric(range) => {
            let row = array(&number(range), 3, Some(3));
            json!({ "anyOf": [row, array(&row, 3, Some(3))] })
        }
        Kind::NumberOrVariants { range, tag, variants } => {
            let mut forms = vec![number(range)];
            forms.extend(variants.iter().map(|v| object(v.keys, Some((tag, v)))));
            json!({ "oneOf": forms })
        }
        Kind::Integer(min, max) => integer(*min, *max),
        Kind::Counts(min, max) => {
            let item = integer(*min, *max);
            json!({ "anyOf": [item, array(&item, 2, Some(3))] })
        }
        Kind::Choice(choices) => names(choices),
        Kind::Choices(choices) => {
            json!({ "type": "array", "items": names(choices), "minItems": 1, "uniqueItems": true })
        }
        Kind::Vector(n, range) => array(&number(range), *n, Some(*n)),
        Kind::Rotation => array(&json!({ "type": "number" }), 3, Some(4)),
        Kind::Point(range) => array(&number(range), 2, Some(3)),
        Kind::List(range) => array(&number(range), 0, None),
        Kind::Lists(range) => array(&array(&number(range), 0, None), 2, Some(3)),
        Kind::Points(range) => array(&array(&number(range), 2, Some(3)), 1, None),
        Kind::Place(range) => {
            json!({ "anyOf": [{ "type": "string", "minLength": 1 }, array(&number(range), 2, Some(3))] })
        }
        Kind::ChoiceOrNumber(choices, range) => json!({ "anyOf": [names(choices), number(range)] }),
        Kind::NameLists => json!({
            "type": "object",
            "additionalProperties": { "type": "array", "items": { "type": "string" }, "minItems": 1 },
        }),
        Kind::Table(keys) => table(keys),
        Kind::Named(keys) => json!({
            "type": "object",
            "propertyNames": { "pattern": "^[A-Za-z0-9_-]{1,64}$" },
            "additionalProperties": table(keys),
        }),
        Kind::NamedByFile(keys) => json!({ "type": "object", "additionalProperties": table(keys) }),
        Kind::Tables(keys) => array(&table(keys), 0, None),
        Kind::Variants { tag, variants } => {
            let forms: Vec<Value> = variants.iter().map(|v| object(v.keys, Some((tag, v)))).collect();
            json!({ "type": "object", "oneOf": forms })
        }
    }
}

fn names(choices: &[Choice]) -> Value {
    let names: Vec<&str> = choices.iter().map(|c| c.name).collect();
    json!({ "type": "string", "enum": names })
}

fn integer(min: u64, max: u64) -> Value {
    json!({ "type": "integer", "minimum": min, "maximum": max })
}

fn number(range: &Range) -> Value {
    let (low, min) = match range.min {
        Bound::Closed(b) => ("minimum", b),
        Bound::Open(b) => ("exclusiveMinimum", b),
    };
    let (high, max) = match range.max {
        Bound::Closed(b) => ("maximum", b),
        Bound::Open(b) => ("exclusiveMaximum", b),
    };
    json!({ "type": "number", low: min, high: max })
}

fn array(item: &Value, min: usize, max: Option<usize>) -> Value {
    let mut value = json!({ "type": "array", "items": item, "minItems": min });
    if let (Some(max), Value::Object(map)) = (max, &mut value) {
        map.insert("maxItems".into(), max.into());
    }
    value
}
