//! Pieces of a mesh that share no node, and the part of a mesh that is a body.

use crate::fault::{MeshFault, shown};
use crate::mesh::raw::{Elements, FaceSource, NO_NODE, RawMesh};

/// What stands before the number of an element that a piece is called by.
const BY_ELEMENT: &str = "element ";

/// Number of the piece of every element, in the order of the elements, and of pieces.
fn pieces(elements: &Elements, n_nodes: usize) -> (Vec<u32>, usize) {
    let mut parent: Vec<u32> = (0..n_nodes as u32).collect();
    fn root(parent: &mut [u32], mut n: u32) -> u32 {
        while parent[n as usize] != n {
            parent[n as usize] = parent[parent[n as usize] as usize];
            n = parent[n as usize];
        }
        n
    }
    for element in elements.iter() {
        let mut first = root(&mut parent, element.nodes[0]);
        for &n in &element.nodes[1..] {
            let other = root(&mut parent, n);
            let (low, high) = (first.min(other), first.max(other));
            parent[high as usize] = low;
            first = low;
        }
    }
    let (mut numbers, mut n) = (vec![NO_NODE; n_nodes], 0);
    let of_element = elements.iter().map(|element| {
        let own = &mut numbers[root(&mut parent, element.nodes[0]) as usize];
        if *own == NO_NODE {
            (*own, n) = (n, n + 1);
        }
        *own
    });
    (of_element.collect(), n as usize)
}

/// Names of the pieces: groups of elements that are one, or "element N" for what hangs together with one; none of a mesh that is
/// one piece.
fn names(elements: &Elements, volumes: &[(String, Vec<u32>)], n_nodes: usize) -> Vec<String> {
    let (of_element, parts) = pieces(elements, n_nodes);
    if parts < 2 {
        return Vec::new();
    }
    let (mut sizes, mut names) = (vec![0; parts], vec![None; parts]);
    of_element.iter().for_each(|&piece| sizes[piece as usize] += 1);
    for (name, all) in volumes {
        let Some(&first) = all.first() else { continue };
        let piece = of_element[first as usize] as usize;
        let is_whole =
            all.len() == sizes[piece] && all.iter().all(|&e| of_element[e as usize] == piece as u32);
        names[piece] = names[piece].take().or_else(|| is_whole.then(|| name.clone()));
    }
    for (element, &piece) in elements.iter().zip(&of_element) {
        names[piece as usize].get_or_insert_with(|| format!("{BY_ELEMENT}{}", element.label));
    }
    names.into_iter().flatten().collect()
}

/// Refuses a mesh of several pieces, which are called by the groups of elements that are one, or by an element.
///
/// # Errors
/// [`MeshFault::Parts`].
pub fn one_piece(
    elements: &Elements,
    volumes: &[(String, Vec<u32>)],
    n_nodes: usize,
) -> Result<(), MeshFault> {
    match names(elements, volumes, n_nodes) {
        names if names.is_empty() => Ok(()),
        names => Err(MeshFault::Parts { parts: names.len(), names: shown(names.iter().map(String::as_str)) }),
    }
}

impl RawMesh {
    /// Names of the pieces that share no node, by which [`RawMesh::part`] knows them; none of a mesh that is one.
    pub fn pieces(&self) -> Vec<String> {
        names(&self.elements, &self.volumes, self.nodes.len())
    }

    /// The elements of the group `name`; "element 7" is all that hangs together with element 7.
    ///
    /// # Errors
    /// [`MeshFault::UnknownGroup`].
    pub fn part(mut self, name: &str) -> Result<Self, MeshFault> {
        let named =
            |is: &dyn Fn(&str) -> bool| self.volumes.iter().find(|(n, _)| is(n)).map(|(_, all)| all.clone());
        let of_group = named(&|n| n == name).or_else(|| named(&|n| n.eq_ignore_ascii_case(name)));
        let of_piece = || {
            let label: u64 = name.strip_prefix(BY_ELEMENT)?.trim().parse().ok()?;
            let (of_element, _) = pieces(&self.elements, self.nodes.len());
            let own = of_element[self.elements.iter().position(|e| e.label == label)?];
            Some((0..of_element.len() as u32).filter(|&e| of_element[e as usize] == own).collect())
        };
        let Some(chosen) = of_group.or_else(of_piece) else {
            let known = shown(self.volumes.iter().map(|(n, _)| n.as_str()));
            return Err(MeshFault::UnknownGroup { what: "elements", name: name.to_owned(), known });
        };
        let all = std::mem::take(&mut self.elements);
        let mut numbers = vec![NO_NODE; all.len()];
        for (new, &e) in (0..).zip(&chosen) {
            let element = all.get(e as usize);
            self.elements.push(element.kind, element.label, element.nodes.iter().copied());
            numbers[e as usize] = new;
        }
        let mut is_own = vec![false; self.nodes.len()];
        self.elements.iter().flat_map(|e| e.nodes).for_each(|&n| is_own[n as usize] = true);
        let others = || all.iter().zip(&numbers).filter(|(_, n)| **n == NO_NODE).map(|(e, _)| e);
        let tied = others().filter(|e| e.nodes.iter().any(|&n| is_own[n as usize])).count();
        if tied > 0 {
            self.notes
                .push(format!("{tied} elements beside part \"{name}\" share nodes with it and are left out"));
        }
        let mut is_foreign = vec![false; self.nodes.len()];
        others().flat_map(|e| e.nodes).for_each(|&n| is_foreign[n as usize] = !is_own[n as usize]);
        for (_, all) in &mut self.volumes {
            *all = all.iter().map(|&e| numbers[e as usize]).filter(|e| *e != NO_NODE).collect();
        }
        self.volumes.retain(|(_, all)| !all.is_empty());
        for (_, source) in &mut self.faces {
            match source {
                FaceSource::Corners(all) => {
                    all.retain(|c| c.iter().all(|&n| n == NO_NODE || !is_foreign[n as usize]));
                }
                FaceSource::Sides(all) => {
                    all.iter_mut().for_each(|(e, _)| *e = numbers[*e as usize]);
                    all.retain(|(e, _)| *e != NO_NODE);
                }
                FaceSource::Nodes(_) => {}
            }
        }
        let mut next = 0..;
        let kept: Vec<u32> =
            is_foreign.iter().map(|is| if *is { NO_NODE } else { next.next().unwrap_or(NO_NODE) }).collect();
        self.keep_nodes(&kept);
        Ok(self)
    }
}
