//! `--set KEY=VALUE`: changes a document before it is checked.

use result_files::toml_text::document::{Entry, Node, Origin, Value, parse_value};
use result_files::toml_text::fault::{Fault, Location};

/// Deepest key; scenarios have six levels.
const MAX_DEPTH: usize = 16;

/// One `--set` argument.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Override {
    text: String,
    path: Vec<String>,
    value: String,
}

impl std::str::FromStr for Override {
    type Err = String;

    /// Splits `a.b[0].c=value` into key and value.
    fn from_str(text: &str) -> Result<Self, String> {
        let (key, value) =
            text.split_once('=').ok_or("expected KEY=VALUE, such as simulation.end_time=1e-3")?;
        let path: Vec<String> = key
            .trim()
            .replace('[', ".")
            .replace(']', "")
            .split('.')
            .map(|part| part.trim().trim_matches('"').to_owned())
            .collect();
        if path.iter().any(String::is_empty) {
            return Err(format!("the key \"{key}\" has an empty part"));
        }
        if path.len() > MAX_DEPTH {
            return Err(format!("the key has {} parts, at most {MAX_DEPTH} make sense", path.len()));
        }
        Ok(Self { text: text.to_owned(), path, value: value.trim().to_owned() })
    }
}

impl Override {
    /// The argument as given, `KEY=VALUE`.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Applies the override to the top-level table of a document.
    ///
    /// # Errors
    /// A fault if the key leads through something that is no table or past the end of an array.
    pub fn apply(&self, root: &mut Node) -> Result<(), Box<Fault>> {
        let origin = Origin::Override(self.text.as_str().into());
        // A value that is not TOML is a bare string, so that no shell quoting is needed for names.
        let value = parse_value(&self.value, &origin)
            .unwrap_or_else(|| Node { value: Value::Text(self.value.clone()), origin: origin.clone() });
        let mut node = root;
        for (depth, part) in self.path.iter().enumerate() {
            let done = self.path[..depth].join(".");
            let fault = |node: &Node, message: String| self.fault(&done, node, message);
            if let Value::Array(items) = &node.value {
                let n = items.len();
                match part.parse::<usize>() {
                    Ok(i) if i < n => {}
                    Ok(i) => return Err(fault(node, format!("has {n} entries, there is no index {i}"))),
                    Err(_) => return Err(fault(node, format!("is an array, \"{part}\" is not an index"))),
                }
            } else if !matches!(node.value, Value::Table(_)) {
                return Err(fault(node, format!("is {}, it has no key \"{part}\"", node.type_name())));
            }
            node = child(node, part, &origin);
        }
        *node = value;
        Ok(())
    }

    fn fault(&self, path: &str, node: &Node, message: String) -> Box<Fault> {
        Box::new(Fault {
            location: Location::Override(self.text.clone()),
            key: path.to_owned(),
            value: Some(node.shown()),
            message,
            suggestion: None,
            known: String::new(),
        })
    }
}

/// The child `part` of a table, made if there is none, or of an array that is long enough.
fn child<'a>(node: &'a mut Node, part: &str, origin: &Origin) -> &'a mut Node {
    match &mut node.value {
        Value::Array(items) => {
            let i: usize = part.parse().expect("the caller has checked the index");
            &mut items[i]
        }
        Value::Table(entries) => {
            // The same quantity in degrees or radians gives way, but for another change.
            let is_twin = |e: &Entry| {
                let is_other =
                    e.key.strip_suffix("_deg") == Some(part) || part.strip_suffix("_deg") == Some(&e.key);
                is_other && !matches!(e.node.origin, Origin::Override(_))
            };
            let is_it = |e: &Entry| e.key == part || is_twin(e) && !matches!(e.node.value, Value::Table(_));
            let i = entries.iter().position(is_it).unwrap_or_else(|| {
                let node = Node { value: Value::Table(Vec::new()), origin: origin.clone() };
                entries.push(Entry { key: part.to_owned(), origin: origin.clone(), node });
                entries.len() - 1
            });
            part.clone_into(&mut entries[i].key);
            &mut entries[i].node
        }
        _ => unreachable!("the caller has checked that the node has children"),
    }
}
