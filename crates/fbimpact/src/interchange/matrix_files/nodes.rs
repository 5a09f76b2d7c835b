//! Nodes and the order of unknowns.

use std::collections::BTreeMap;

use super::fault::{MatrixError, MatrixFault};
use super::matrix::Unknown;
use super::words::{Words, component, number, real};

/// Nodes with their positions.
pub type NodeTable = BTreeMap<u64, [f64; 3]>;

/// Reads nodes: lines of number, x, y and z with commas or spaces between them, alone or in the
/// section `*NODE` of an input file.
///
/// # Errors
/// [`MatrixError`] with the line.
pub fn read_nodes(text: &str) -> Result<NodeTable, MatrixError> {
    let mut nodes = NodeTable::new();
    let mut is_inside = true;
    for (i, content) in text.lines().enumerate() {
        let (line, content) = (i + 1, content.trim());
        if content.starts_with('*') {
            let card = content.split(',').next().unwrap_or("").trim();
            is_inside = card.eq_ignore_ascii_case("*NODE") || content.starts_with("**") && is_inside;
            continue;
        }
        let words = Words::new(content, |c| c == ',' || c == ';' || c.is_whitespace());
        let words = words.first();
        // A first line of titles, comments and what other sections hold.
        let is_title = nodes.is_empty() && words.first().is_some_and(|w| w.parse::<f64>().is_err());
        if !is_inside || words.is_empty() || content.starts_with('#') || is_title {
            continue;
        }
        let [node, x, y, z] = *words else {
            let found = content.chars().take(40).collect();
            let expected = "a node's number, x, y and z";
            return Err(MatrixError { line, fault: MatrixFault::Expected { expected, found } });
        };
        let node = number(line, node, "a node's number")?;
        let point = [real(line, x)?, real(line, y)?, real(line, z)?];
        if nodes.insert(node, point).is_some() {
            return Err(MatrixError { line, fault: MatrixFault::Twice { what: format!("node {node}") } });
        }
    }
    if nodes.is_empty() {
        let remedy = "write lines of number, x, y and z, or name an input file with *NODE";
        return Err(MatrixError { line: 1, fault: MatrixFault::Missing { what: "nodes", remedy } });
    }
    Ok(nodes)
}

/// Reads the order of unknowns: a line `node.component` (CalculiX), or node and component with a
/// comma or spaces between them, for each row.
///
/// # Errors
/// [`MatrixError`] with the line.
pub fn read_map(text: &str) -> Result<Vec<Unknown>, MatrixError> {
    let mut map = Vec::new();
    let mut known = std::collections::BTreeSet::new();
    for (i, content) in text.lines().enumerate() {
        let (line, content) = (i + 1, content.trim());
        if content.is_empty() || content.starts_with(['#', '*']) {
            continue;
        }
        let words = Words::new(content, |c| c == ',' || c == '.' || c.is_whitespace());
        let [node, axis] = *words.first() else {
            let found = content.chars().take(40).collect();
            let expected = "node.component, or node and component";
            return Err(MatrixError { line, fault: MatrixFault::Expected { expected, found } });
        };
        let unknown = Unknown { node: number(line, node, "a node")?, component: component(line, axis)? };
        if !known.insert(unknown) {
            let what = format!("component {} of node {}", unknown.component + 1, unknown.node);
            return Err(MatrixError { line, fault: MatrixFault::Twice { what } });
        }
        map.push(unknown);
    }
    if map.is_empty() {
        let remedy = "write a line node.component for each row";
        return Err(MatrixError { line: 1, fault: MatrixFault::Missing { what: "unknowns", remedy } });
    }
    Ok(map)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_of_tables_and_input_files() {
        let plain = read_nodes("id, x, y, z\n7, 1., 2., 3.\n9 4 5 6e0\n").expect("nodes");
        let card = read_nodes(
            "*HEADING\nno node\n*NODE, NSET=A\n7, 1., 2., 3.\n** note\n9, 4, 5, 6\n*ELEMENT, TYPE=C3D4\n1, 7, 9, 7, 9\n",
        );
        assert_eq!(plain, card.expect("nodes"));
        assert_eq!(read_map("10.1\n10.3\n").expect("a map"), read_map("10, 1\n10 3\n").expect("a map"));
    }

    #[test]
    fn faults_name_the_line() {
        for (text, words) in [
            ("1, 0, 0\n", &["line 1", "x, y and z"][..]),
            ("1, 0, 0, 0\n1, 0, 0, 1\n", &["line 2", "node 1 is given twice"]),
            ("*ELEMENT\n1, 2, 3, 4\n", &["no nodes", "*NODE"]),
            ("1, 0, zero, 0\n", &["line 1", "a number expected", "zero"]),
        ] {
            let text = read_nodes(text).expect_err(text).to_string();
            assert!(words.iter().all(|w| text.contains(w)), "{words:?}: {text}");
        }
        for (text, words) in [
            ("1.1\n1.7\n", &["line 2", "1 to 6"][..]),
            ("1.1\n1.1\n", &["line 2", "component 1 of node 1 is given twice"]),
            ("1\n", &["line 1", "node.component"]),
        ] {
            let text = read_map(text).expect_err(text).to_string();
            assert!(words.iter().all(|w| text.contains(w)), "{words:?}: {text}");
        }
    }
}
