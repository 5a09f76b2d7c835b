//! MFEM's NURBS meshes, versions 1.0 and 1.1: a mesh of patches, then the patches themselves or
//! knots, weights and nodes.

use std::fmt::Write as _;

use super::fault::{ReadError, ReadFault};
use super::mfem_topology::{Topology, corners};
use super::words::Words;
use super::{SplineFile, in_unit, net_size};
use crate::nurbs::interface::{COINCIDENT, FaceNet, coinciding_pairs};
use crate::nurbs::{FaceId, Patch};
use crate::splines::knots::KnotVector;
use crate::splines::tensor;

/// Reads all patches.
pub fn read(text: &str) -> Result<SplineFile, ReadError> {
    let mut words = Words::new(text, 1, true, "the header");
    words.next();
    let title = words.end_of_line().trim();
    let is_newer = title.ends_with("v1.1");
    if !title.starts_with("NURBS mesh") || !(is_newer || title.ends_with("v1.0")) {
        let what = format!("\"MFEM {title}\"");
        let remedy =
            "\"MFEM NURBS mesh v1.0\" and \"v1.1\" are; patches that meet in whole faces can be saved so";
        return words.fail(ReadFault::Unsupported { what, remedy });
    }
    let topology = Topology::read(&mut words)?;
    let mut notes = Vec::new();
    let patches = match words.word()? {
        "patches" => (0..topology.n_patches())
            .map(|i| patch(&mut words, i, topology.dimension))
            .collect::<Result<_, _>>()?,
        "knotvectors" => {
            let knots = knot_vectors(&mut words)?;
            if is_newer {
                skip_spacing(&mut words, &mut notes)?;
            }
            from_nodes(&mut words, &topology, &knots)?
        }
        found => return words.unexpected("\"patches\" or \"knotvectors\"", found),
    };
    let faces = topology.boundary_faces(&mut notes);
    Ok(SplineFile { patches, joined: topology.joined(), faces, notes })
}

fn knot_vector(words: &mut Words) -> Result<KnotVector, ReadError> {
    let degree: usize = words.number("a degree")?;
    let n = words.count()?;
    let line = words.line();
    let knots = words.reals(n.saturating_add(degree).saturating_add(1))?;
    KnotVector::new(degree, knots).map_err(|e| ReadError { line, fault: e.into() })
}

fn knot_vectors(words: &mut Words) -> Result<Vec<KnotVector>, ReadError> {
    "the knot vectors".clone_into(&mut words.section);
    let n = words.count()?;
    (0..n).map(|_| knot_vector(words)).collect()
}

/// A patch in the section "patches".
fn patch(words: &mut Words, number: usize, dimension: usize) -> Result<Patch, ReadError> {
    words.section = format!("patch {number}");
    words.keyword("knotvectors")?;
    let line = words.line();
    let n: usize = words.number("a count")?;
    if n != dimension {
        let what = format!("knot vectors of patch {number}");
        return words.fail(ReadFault::Count { what, found: n, expected: dimension });
    }
    let knots = (0..n).map(|_| knot_vector(words)).collect::<Result<Vec<_>, _>>()?;
    words.keyword("dimension")?;
    let space: usize = words.number("a dimension")?;
    if space != dimension {
        let what = format!("a patch of {dimension} directions with {space} coordinates");
        let remedy = "solids lie in space, surfaces of plane models in the plane";
        return words.fail(ReadFault::Unsupported { what, remedy });
    }
    let is_homogeneous = match words.word()? {
        "controlpoints" | "controlpoints_homogeneous" => true,
        "controlpoints_cartesian" => false,
        found => return words.unexpected("\"controlpoints\" or \"controlpoints_cartesian\"", found),
    };
    let n = net_size(&knots);
    let numbers = words.reals(n.saturating_mul(dimension + 1))?;
    let (mut points, mut weights) = (Vec::with_capacity(n), Vec::with_capacity(n));
    for row in numbers.chunks_exact(dimension + 1) {
        let w = row[dimension];
        let scale = if is_homogeneous { 1.0 / w } else { 1.0 };
        points.push(std::array::from_fn(|c| if c < dimension { scale * row[c] } else { 0.0 }));
        weights.push(w);
    }
    // A weight that is none makes points that are none: the weight is to be named.
    if weights.iter().any(|w| !(w.is_finite() && *w > 0.0)) {
        points.fill([0.0; 3]);
    }
    Patch::new(knots, points, weights).map_err(|e| ReadError { line, fault: e.into() })
}

/// What version 1.1 says of later refinement.
fn skip_spacing(words: &mut Words, notes: &mut Vec<String>) -> Result<(), ReadError> {
    "the spacing of knots".clone_into(&mut words.section);
    match words.word()? {
        "spacing" => {}
        "refinements" | "knotvector_refinements" => {
            let what = "a refinement that is still to be made".into();
            return words.fail(ReadFault::Unsupported { what, remedy: "save the mesh refined" });
        }
        found => return words.unexpected("\"spacing\"", found),
    }
    for _ in 0..words.count()? {
        let (_, _): (u64, u64) = (words.number("a knot vector")?, words.number("a kind")?);
        let (integers, reals) = (words.count()?, words.count()?);
        for _ in 0..integers {
            words.number::<i64>("an integer")?;
        }
        words.reals(reals)?;
    }
    notes.push("left out: spacing of knots, which says how MFEM would refine".to_owned());
    Ok(())
}

/// Patches from weights and a finite element space of nodes.
fn from_nodes(words: &mut Words, topology: &Topology, knots: &[KnotVector]) -> Result<Vec<Patch>, ReadError> {
    let line = words.line();
    // A patch has hardly more knots than functions, whose coordinates take several characters of
    // the rest.
    let knots = topology.patch_knots(knots, words.n_left()).map_err(|fault| ReadError { line, fault })?;
    let sizes: Vec<Vec<usize>> =
        knots.iter().map(|patch| patch.iter().map(KnotVector::n_functions).collect()).collect();
    // Each function has a weight or two coordinates at least and is shared by eight patches on
    // average at most.
    let entries = knots.iter().map(|k| net_size(k)).fold(0, usize::saturating_add);
    if !words.can_hold(entries) {
        "the weights".clone_into(&mut words.section);
        return words.fail(ReadFault::End { section: words.section.clone() });
    }
    let numbering = topology.numbering(&sizes).map_err(|fault| ReadError { line, fault })?;
    "the weights".clone_into(&mut words.section);
    let weights = match words.word()? {
        "weights" => words.reals(numbering.n)?,
        "unitweights" | "autoweights" => vec![1.0; numbering.n],
        "mesh_elements" => {
            let remedy = "save the mesh with all its elements";
            return words
                .fail(ReadFault::Unsupported { what: "a mesh of some elements only".into(), remedy });
        }
        "periodic" => {
            let remedy =
                "save the mesh without that section; faces that lie on one another are joined anyway";
            return words.fail(ReadFault::Unsupported { what: "the section \"periodic\"".into(), remedy });
        }
        found => return words.unexpected("\"weights\"", found),
    };
    "the nodes".clone_into(&mut words.section);
    let points = nodes(words, numbering.n, topology.dimension, &knots)?;
    let build = |(knots, dofs): (Vec<KnotVector>, &Vec<usize>)| {
        let own = dofs.iter().map(|&i| points[i]).collect();
        Patch::new(knots, own, dofs.iter().map(|&i| weights[i]).collect())
            .map_err(|e| ReadError { line, fault: e.into() })
    };
    knots.into_iter().zip(&numbering.patches).map(build).collect()
}

/// The section "FiniteElementSpace": a vector for each of `n` functions.
fn nodes(
    words: &mut Words,
    n: usize,
    dimension: usize,
    knots: &[Vec<KnotVector>],
) -> Result<Vec<[f64; 3]>, ReadError> {
    // Spaces whose degrees differ by direction have a form of their own, with an end.
    let has_end = match words.word()? {
        "FiniteElementSpace" => false,
        "MFEM" => {
            words.keyword("FiniteElementSpace")?;
            words.keyword("v1.0")?;
            true
        }
        found => return words.unexpected("\"FiniteElementSpace\"", found),
    };
    words.keyword("FiniteElementCollection:")?;
    let collection = words.word()?;
    let order = collection.strip_prefix("NURBS");
    let is_own = order.is_some_and(|o| {
        o.is_empty() || o.parse().is_ok_and(|o: usize| knots.iter().flatten().all(|k| k.degree() == o))
    });
    if !is_own {
        let what = format!("nodes in a space \"{collection}\" with other degrees than the knots");
        return words
            .fail(ReadFault::Unsupported { what, remedy: "save the nodes in the space of the mesh" });
    }
    words.keyword("VDim:")?;
    let given: usize = words.number("a dimension")?;
    if given != dimension {
        let what = format!("a mesh of {dimension} directions with {given} coordinates");
        let remedy = "solids lie in space, surfaces of plane models in the plane";
        return words.fail(ReadFault::Unsupported { what, remedy });
    }
    words.keyword("Ordering:")?;
    let ordering: usize = words.number("0 or 1")?;
    if has_end {
        for word in ["End:", "MFEM", "FiniteElementSpace", "v1.0"] {
            words.keyword(word)?;
        }
    }
    let values = words.reals(n.saturating_mul(dimension))?;
    let place = |i: usize, c: usize| if ordering == 1 { dimension * i + c } else { n * c + i };
    let point = |i: usize| std::array::from_fn(|c| if c < dimension { values[place(i, c)] } else { 0.0 });
    Ok((0..n).map(point).collect())
}

/// The patches as a mesh of version 1.0 with its section "patches", in a unit of `unit` metres.
pub fn write(patches: &[Patch], unit: f64) -> String {
    let dimension = patches.first().map_or(3, Patch::dimension);
    let (solid, side) = if dimension == 3 { (5, 3) } else { (3, 1) };
    let vertices = vertices(patches);
    let mut out = format!("MFEM NURBS mesh v1.0\n\ndimension\n{dimension}\n\nelements\n{}\n", patches.len());
    let list = |v: &[usize]| v.iter().map(usize::to_string).collect::<Vec<_>>().join(" ");
    for own in &vertices {
        let _ = writeln!(out, "1 {solid} {}", list(own));
    }
    let outer = outer_faces(patches);
    let _ = writeln!(out, "\nboundary\n{}", outer.len());
    for (i, id) in outer.iter().enumerate() {
        let own: Vec<usize> = super::mfem_topology::face_corners(dimension, id.direction, id.upper)
            .iter()
            .map(|&c| vertices[id.patch][c])
            .collect();
        let _ = writeln!(out, "{} {side} {}", i + 1, list(&own));
    }
    // Without edges MFEM finds them, and which knots belong to them.
    let n = vertices.iter().flatten().max().map_or(0, |m| m + 1);
    let _ = writeln!(out, "\nedges\n0\n\nvertices\n{n}\n\npatches");
    for (patch, points) in in_unit(patches, unit) {
        let _ = writeln!(out, "\nknotvectors\n{dimension}");
        let numbers = |v: &[f64]| v.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(" ");
        for knots in patch.knots() {
            let _ = writeln!(out, "{} {} {}", knots.degree(), knots.n_functions(), numbers(knots.knots()));
        }
        let _ = writeln!(out, "\ndimension\n{dimension}\n\ncontrolpoints_cartesian");
        for (p, w) in points.iter().zip(patch.weights()) {
            let _ = writeln!(out, "{} {w:?}", numbers(&p[..dimension]));
        }
    }
    out
}

fn outer_faces(patches: &[Patch]) -> Vec<FaceId> {
    crate::nurbs::Face::outer(patches, false).iter().map(|face| face.id).collect()
}

/// Vertices of each patch in MFEM's order: corners of shared faces are one. A patch keeps corners
/// apart that its own seam joins, as MFEM's patches must.
fn vertices(patches: &[Patch]) -> Vec<Vec<usize>> {
    let faces = FaceId::all(patches);
    let nets: Vec<FaceNet> = faces.iter().map(|&id| FaceNet::new(patches, id)).collect();
    let n_corners = 1 << patches.first().map_or(3, Patch::dimension);
    let mut parents: Vec<usize> = (0..n_corners * patches.len()).collect();
    let root = |parents: &[usize], mut i: usize| {
        while parents[i] != i {
            i = parents[i];
        }
        i
    };
    for (i, j, way) in coinciding_pairs(&nets, COINCIDENT) {
        let (a, b) = (faces[i], faces[j]);
        if a.patch == b.patch {
            continue;
        }
        let dimension = patches[a.patch].dimension();
        let others: Vec<usize> = b.tangents(dimension).collect();
        for corner in 0..1usize << (dimension - 1) {
            let (mut one, mut other) =
                (usize::from(a.upper) << a.direction, usize::from(b.upper) << b.direction);
            for (along, d) in a.tangents(dimension).enumerate() {
                let (partner, is_reversed) = way.direction(along);
                let is_end = corner >> along & 1 == 1;
                one |= usize::from(is_end) << d;
                other |= usize::from(is_end != is_reversed) << others[partner];
            }
            let (p, q) =
                (root(&parents, n_corners * a.patch + one), root(&parents, n_corners * b.patch + other));
            parents[p.max(q)] = p.min(q);
        }
    }
    let mut numbers = std::collections::BTreeMap::new();
    let mut number = |i: usize| {
        let next = numbers.len();
        *numbers.entry(root(&parents, i)).or_insert(next)
    };
    let order = corners(patches.first().map_or(3, Patch::dimension));
    (0..patches.len())
        .map(|p| {
            order.iter().map(|c| number(n_corners * p + tensor::flat_index(&[2; 3][..c.len()], c))).collect()
        })
        .collect()
}
