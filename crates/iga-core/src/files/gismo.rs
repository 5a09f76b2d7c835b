//! G+Smo's XML: `Geometry` of tensor splines, `MultiPatch`.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use roxmltree::{Document, Node, ParsingOptions};

use super::fault::{ReadError, ReadFault};
use super::words::Words;
use super::{SplineFile, in_unit, net_size};
use crate::nurbs::{FaceId, Patch};
use crate::splines::knots::KnotVector;

/// Bytes of a file for each node of the tree that it may make: a node takes some eighty bytes.
const BYTES_A_NODE: usize = 20;
/// Bytes of a file for each of its attributes, of which one takes some seventy.
const BYTES_AN_ATTRIBUTE: usize = 24;
/// Nodes and attributes that any file may have, and attributes of one tag: their names are compared
/// in pairs.
const FEW: usize = 100;

/// Reads all patches.
pub fn read(text: &str) -> Result<SplineFile, ReadError> {
    let text = without_declaration(text);
    // Room for all of them is made before the first is read.
    for (sign, bytes, what) in [(b'<', BYTES_A_NODE, "tags"), (b'=', BYTES_AN_ATTRIBUTE, "attributes")] {
        let most = text.len() / bytes + FEW;
        if text.bytes().filter(|b| *b == sign).count() > most {
            let reason = format!("it has more than {most} {what}, more than splines of that size need");
            return Err(ReadError { line: 1, fault: ReadFault::Xml { reason } });
        }
    }
    if let Some(line) = crowded_tag(&text) {
        let reason = format!("a tag has more than {FEW} attributes, those of splines have less than ten");
        return Err(ReadError { line, fault: ReadFault::Xml { reason } });
    }
    let nodes_limit = u32::try_from(text.len() / BYTES_A_NODE + FEW).unwrap_or(u32::MAX);
    let options = ParsingOptions { nodes_limit, ..ParsingOptions::default() };
    let document = Document::parse_with_options(&text, options).map_err(|e| ReadError {
        line: e.pos().row as usize,
        fault: ReadFault::Xml { reason: e.to_string() },
    })?;
    let mut notes = Vec::new();
    let named = |name: &'static str| document.descendants().filter(move |n| n.has_tag_name(name));
    let multi: Vec<Node> = named("MultiPatch").collect();
    if let Some(second) = multi.get(1) {
        let remedy = "a file has one body; write the other to a file of its own";
        return fail(second, ReadFault::Unsupported { what: "a second MultiPatch".into(), remedy });
    }
    let geometries: Vec<Node> = named("Geometry").collect();
    let Some(multi) = multi.first() else {
        let (tensor, others): (Vec<Node>, Vec<Node>) = geometries.iter().partition(|n| is_tensor(n));
        note_others(&others, &mut notes);
        let patches = tensor.iter().map(geometry).collect::<Result<Vec<_>, _>>()?;
        if patches.is_empty() {
            let remedy = "a body is of type TensorNurbs3, TensorBSpline3, or 2 of plane models";
            return Err(ReadError {
                line: 1,
                fault: ReadFault::Missing { what: "Geometry of a tensor spline", remedy },
            });
        }
        return Ok(SplineFile { patches, joined: Vec::new(), faces: Vec::new(), notes });
    };
    let mut by_id = BTreeMap::new();
    for node in &geometries {
        if let Some(id) = node.attribute("id").and_then(|id| id.trim().parse::<i64>().ok())
            && by_id.insert(id, *node).is_some()
        {
            return fail(
                node,
                ReadFault::Unsupported {
                    what: format!("a second Geometry with id {id}"),
                    remedy: "number them anew",
                },
            );
        }
    }
    let ids = patch_ids(multi, &by_id)?;
    let patches = ids.iter().map(|(_, node)| geometry(node)).collect::<Result<Vec<_>, _>>()?;
    let used: Vec<_> = ids.iter().map(|(_, node)| *node).collect();
    let others: Vec<Node> = geometries.into_iter().filter(|n| !used.contains(n)).collect();
    note_others(&others, &mut notes);
    let places: BTreeMap<i64, usize> = ids.iter().enumerate().map(|(place, (id, _))| (*id, place)).collect();
    let joined = interfaces(multi, &places, &patches)?;
    Ok(SplineFile { patches, joined, faces: Vec::new(), notes })
}

/// The text with spaces in place of an XML declaration that does not stand at the beginning, where
/// strict readers refuse it.
fn without_declaration(text: &str) -> String {
    let text = text.replace('\u{feff}', " ");
    match text.find("<?xml ").and_then(|start| Some(start..start + text[start..].find("?>")? + 2)) {
        Some(range) if range.start > 0 => {
            let blank =
                text[range.clone()].chars().map(|c| if c == '\n' { c } else { ' ' }).collect::<String>();
            text[..range.start].to_owned() + &blank + &text[range.end..]
        }
        _ => text,
    }
}

/// Line of the first tag with more than [`FEW`] attributes; signs in quotes, in comments and
/// between tags count for nothing.
fn crowded_tag(text: &str) -> Option<usize> {
    let mut rest = text;
    while let Some(open) = rest.find('<') {
        let at = text.len() - rest.len() + open;
        rest = &rest[open + 1..];
        if let Some(comment) = rest.strip_prefix("!--") {
            rest = &comment[comment.find("-->")?..];
            continue;
        }
        let (mut quote, mut count, mut end) = (None, 0, rest.len());
        for (i, byte) in rest.bytes().enumerate() {
            match (quote, byte) {
                (Some(open), _) if byte == open => quote = None,
                (None, b'"' | b'\'') => quote = Some(byte),
                (None, b'=') => count += 1,
                (None, b'>') => {
                    end = i;
                    break;
                }
                _ => {}
            }
        }
        if count > FEW {
            return Some(text[..at].matches('\n').count() + 1);
        }
        rest = &rest[end..];
    }
    None
}

fn line(node: &Node) -> usize {
    node.document().text_pos_at(node.range().start).row as usize
}

fn fail<T>(node: &Node, fault: ReadFault) -> Result<T, ReadError> {
    Err(ReadError { line: line(node), fault })
}

fn is_tensor(node: &Node) -> bool {
    ["TensorNurbs2", "TensorNurbs3", "TensorBSpline2", "TensorBSpline3"]
        .contains(&node.attribute("type").unwrap_or(""))
}

fn note_others(others: &[Node], notes: &mut Vec<String>) {
    if let Some(first) = others.first() {
        let kind = first.attribute("type").unwrap_or("no type");
        notes.push(format!(
            "left out: {} Geometry of no body, the first on line {} of type {kind}",
            others.len(),
            line(first)
        ));
    }
}

/// The texts of a node, with the line on which they begin.
fn words<'a>(node: &Node<'a, '_>, what: &str) -> Result<Words<'a>, ReadError> {
    if let Some(format) = node.attribute("format").filter(|f| !f.eq_ignore_ascii_case("ascii")) {
        let what = format!("the format {format}");
        return fail(node, ReadFault::Unsupported { what, remedy: "write the file as ASCII text" });
    }
    let inside = node.first_child().filter(Node::is_text);
    let at = inside.map_or_else(|| line(node), |t| line(&t));
    let text = inside.and_then(|t| t.text()).unwrap_or("");
    if inside.is_some_and(|t| t.next_sibling().is_some()) {
        let remedy = "take comments and other elements out of it";
        return fail(
            node,
            ReadFault::Unsupported { what: format!("what stands between the numbers of {what}"), remedy },
        );
    }
    Ok(Words::new(text, at, false, what))
}

fn child<'a, 'i>(
    node: &Node<'a, 'i>,
    name: &'static str,
    remedy: &'static str,
) -> Result<Node<'a, 'i>, ReadError> {
    match node.children().find(|n| n.has_tag_name(name)) {
        Some(child) => Ok(child),
        None => fail(node, ReadFault::Missing { what: name, remedy }),
    }
}

/// A patch.
fn geometry(node: &Node) -> Result<Patch, ReadError> {
    let kind = node.attribute("type").unwrap_or("");
    if !is_tensor(node) {
        let remedy = "a patch is of type TensorNurbs3, TensorBSpline3, or 2 of plane models";
        return fail(node, ReadFault::Unsupported { what: format!("a Geometry of type \"{kind}\""), remedy });
    }
    let dimension = if kind.ends_with('2') { 2 } else { 3 };
    let remedy = "write the geometry with its basis";
    let outer = child(node, "Basis", remedy)?;
    let weights = outer.children().find(|n| n.has_tag_name("weights"));
    let is_rational = kind.starts_with("TensorNurbs");
    let tensor = if is_rational { child(&outer, "Basis", remedy)? } else { outer };
    let mut bases: Vec<Node> = tensor.children().filter(|n| n.has_tag_name("Basis")).collect();
    if bases.len() != dimension {
        let what = format!("bases of a {kind}");
        return fail(&tensor, ReadFault::Count { what, found: bases.len(), expected: dimension });
    }
    bases.sort_by_key(|n| n.attribute("index").and_then(|i| i.trim().parse::<u32>().ok()).unwrap_or(0));
    let knots = bases.iter().map(knot_vector).collect::<Result<Vec<_>, _>>()?;
    let n = net_size(&knots);
    let coefs = child(node, "coefs", "write the control points")?;
    let given = coefs.attribute("geoDim").unwrap_or("");
    if given.trim() != dimension.to_string() {
        let what = format!("a {kind} with geoDim = \"{given}\"");
        return fail(
            &coefs,
            ReadFault::Unsupported {
                what,
                remedy: "solids lie in space, surfaces of plane models in the plane",
            },
        );
    }
    let (points, found) = words(&coefs, "coefs")?.all_points(n, dimension)?;
    let expected = n.saturating_mul(dimension);
    if found != expected {
        let what = "numbers in coefs".to_owned();
        return fail(&coefs, ReadFault::Count { what, found, expected });
    }
    let weights = match weights {
        Some(weights) if is_rational => words(&weights, "weights")?.all_reals()?,
        None if is_rational => {
            return fail(
                &outer,
                ReadFault::Missing { what: "weights", remedy: "write them, or a TensorBSpline" },
            );
        }
        _ => vec![1.0; n],
    };
    Patch::new(knots, points, weights).or_else(|e| fail(node, e.into()))
}

fn knot_vector(basis: &Node) -> Result<KnotVector, ReadError> {
    let node = child(basis, "KnotVector", "a basis of a direction has one")?;
    let degree = node.attribute("degree").unwrap_or("");
    let Ok(degree) = degree.trim().parse() else {
        let (expected, section, found) = ("a degree", "KnotVector".to_owned(), degree.to_owned());
        return fail(&node, ReadFault::Expected { expected, section, found });
    };
    let knots = words(&node, "KnotVector")?.all_reals()?;
    KnotVector::new(degree, knots).or_else(|e| fail(&node, e.into()))
}

/// The geometries of a body in the order of its patches, with their ids.
fn patch_ids<'a, 'i>(
    multi: &Node<'a, 'i>,
    by_id: &BTreeMap<i64, Node<'a, 'i>>,
) -> Result<Vec<(i64, Node<'a, 'i>)>, ReadError> {
    let node = child(multi, "patches", "name the geometries of the body")?;
    let mut words = words(&node, "patches")?;
    let mut ids: Vec<i64> = Vec::new();
    match node.attribute("type") {
        Some("id_range") => {
            let (first, last): (i64, i64) = (words.number("an id")?, words.number("an id")?);
            ids.extend(by_id.range(first..=last.max(first)).map(|(id, _)| *id));
            let wanted = last.saturating_sub(first).saturating_add(1);
            if usize::try_from(wanted).ok() != Some(ids.len()) {
                let missing = (first..=last).find(|id| !by_id.contains_key(id)).unwrap_or(first);
                let user = "MultiPatch".to_owned();
                return fail(
                    &node,
                    ReadFault::Unknown { user, what: "the geometry", number: missing.to_string() },
                );
            }
        }
        _ => {
            while let Some(word) = words.next() {
                ids.push(word.parse().or_else(|_| words.unexpected("an id", word))?);
            }
        }
    }
    let find = |id: i64| match by_id.get(&id) {
        Some(found) => Ok((id, *found)),
        None => {
            let user = "MultiPatch".to_owned();
            fail(&node, ReadFault::Unknown { user, what: "the geometry", number: id.to_string() })
        }
    };
    let found: Vec<(i64, Node)> = ids.into_iter().map(find).collect::<Result<_, _>>()?;
    let mut known = BTreeSet::new();
    match found.iter().find(|(id, _)| !known.insert(*id)) {
        Some((id, _)) => {
            let what = format!("a MultiPatch with geometry {id} twice");
            fail(&node, ReadFault::Unsupported { what, remedy: "name each of its patches once" })
        }
        None => Ok(found),
    }
}

/// Pairs of faces that are joined: a patch and a side of each, then how their directions lie, which
/// geometry shows as well.
fn interfaces(
    multi: &Node,
    places: &BTreeMap<i64, usize>,
    patches: &[Patch],
) -> Result<Vec<[FaceId; 2]>, ReadError> {
    let Some(node) = multi.children().find(|n| n.has_tag_name("interfaces")) else { return Ok(Vec::new()) };
    let mut words = words(&node, "interfaces")?;
    let mut joined = Vec::new();
    while let Some(word) = words.next() {
        let mut first = Some(word);
        let mut pair = [FaceId { patch: 0, direction: 0, upper: false }; 2];
        let mut dimension = 0;
        for face in &mut pair {
            let id: i64 = match first.take() {
                Some(word) => word.parse().or_else(|_| words.unexpected("an id", word))?,
                None => words.number("an id")?,
            };
            let side: usize = words.number("a side")?;
            // Patches are named by their ids, or counted from 0.
            let counted = usize::try_from(id).ok().filter(|i| *i < patches.len());
            let Some(patch) = places.get(&id).copied().or(counted) else {
                let user = "an interface".to_owned();
                return words.fail(ReadFault::Unknown { user, what: "the patch", number: id.to_string() });
            };
            dimension = patches[patch].dimension();
            if !(1..=2 * dimension).contains(&side) {
                let user = "an interface".to_owned();
                return words.fail(ReadFault::Unknown { user, what: "the side", number: side.to_string() });
            }
            *face = FaceId { patch, direction: (side - 1) / 2, upper: side.is_multiple_of(2) };
        }
        for _ in 0..2 * dimension {
            words.number::<i64>("a direction or orientation")?;
        }
        joined.push(pair);
    }
    Ok(joined)
}

/// The patches as G+Smo's XML, in a unit of `unit` metres; several as a `MultiPatch` with its
/// interfaces.
pub fn write(patches: &[Patch], unit: f64) -> String {
    let mut out = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<xml>\n");
    for (id, (patch, points)) in in_unit(patches, unit).enumerate() {
        let n = patch.dimension();
        let list = |v: &[f64]| v.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(" ");
        let _ = writeln!(
            out,
            " <Geometry type=\"TensorNurbs{n}\" id=\"{id}\">\n  <Basis type=\"TensorNurbsBasis{n}\">"
        );
        let _ = writeln!(out, "   <Basis type=\"TensorBSplineBasis{n}\">");
        for (d, knots) in patch.knots().iter().enumerate() {
            let _ = writeln!(
                out,
                "    <Basis type=\"BSplineBasis\" index=\"{d}\">\n     <KnotVector degree=\"{}\">{}</KnotVector>\n    </Basis>",
                knots.degree(),
                list(knots.knots())
            );
        }
        let weights = list(patch.weights());
        let _ = writeln!(
            out,
            "   </Basis>\n   <weights>{weights}</weights>\n  </Basis>\n  <coefs geoDim=\"{n}\">"
        );
        for p in &points {
            let _ = writeln!(out, "{}", list(&p[..n]));
        }
        out.push_str("  </coefs>\n </Geometry>\n");
    }
    if patches.len() > 1 {
        multi_patch(patches, &mut out);
    }
    out + "</xml>\n"
}

fn multi_patch(patches: &[Patch], out: &mut String) {
    use crate::nurbs::Face;
    use crate::nurbs::interface::{COINCIDENT, FaceNet, coinciding_pairs};
    let n = patches.len();
    let mut faces = FaceId::all(patches);
    faces.retain(|&id| !Face::new(patches, id, false).is_collapsed(&patches[id.patch]));
    let nets: Vec<FaceNet> = faces.iter().map(|&id| FaceNet::new(patches, id)).collect();
    let side = |id: FaceId| 2 * id.direction + 1 + usize::from(id.upper);
    let _ = writeln!(
        out,
        " <MultiPatch parDim=\"{}\" id=\"{n}\">\n  <patches type=\"id_range\">0 {}</patches>\n  <interfaces>",
        patches[0].dimension(),
        n - 1
    );
    let mut is_shared = vec![false; faces.len()];
    for (i, j, way) in coinciding_pairs(&nets, COINCIDENT) {
        (is_shared[i], is_shared[j]) = (true, true);
        let (a, b) = (faces[i], faces[j]);
        let dimension = patches[a.patch].dimension();
        // Where each direction of the first lies in the second, and whether in the same sense:
        // across the face, ends look at each other.
        let others: Vec<usize> = b.tangents(dimension).collect();
        let (mut map, mut same) = (vec![b.direction; dimension], vec![a.upper != b.upper; dimension]);
        for (along, d) in a.tangents(dimension).enumerate() {
            let (partner, is_reversed) = way.direction(along);
            (map[d], same[d]) = (others[partner], !is_reversed);
        }
        let text = |v: &[usize]| v.iter().map(usize::to_string).collect::<Vec<_>>().join(" ");
        let same: Vec<usize> = same.into_iter().map(usize::from).collect();
        let _ =
            writeln!(out, "{} {} {} {} {} {}", a.patch, side(a), b.patch, side(b), text(&map), text(&same));
    }
    out.push_str("  </interfaces>\n  <boundary>\n");
    for (face, _) in faces.iter().zip(is_shared).filter(|(_, shared)| !shared) {
        let _ = writeln!(out, "{} {}", face.patch, side(*face));
    }
    out.push_str("  </boundary>\n </MultiPatch>\n");
}
