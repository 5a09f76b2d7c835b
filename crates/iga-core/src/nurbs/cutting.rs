//! Patches cut where their functions are only continuous, and where they close on themselves, so
//! that each of these lines is a face between patches
//! (docs/decisions/0051-lines-of-lower-continuity.md, theory section S.3).

use std::collections::{BTreeMap, BTreeSet};

use super::interface::linked::{Linked, linked_directions};
use super::interface::{COINCIDENT, FaceId, FaceNet, coinciding_pairs};
use super::shape::SingularSet;
use super::{Patch, Shape};
use crate::SplineError;
use crate::splines::knots::KnotVector;
use crate::splines::tensor;

/// Where the directions of a class are cut.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
struct Cuts {
    /// Numbers of breaks, in the sense of the first direction of the class.
    breaks: BTreeSet<usize>,
    /// In the middle of the only element.
    middle: bool,
}

/// The parts that a patch is cut into.
struct Parts {
    /// Number along each direction.
    counts: Vec<usize>,
    /// Shares of the range between which each part lies, by direction.
    shares: Vec<Vec<f64>>,
    patches: Vec<Patch>,
}

impl Shape {
    /// The shape with patches cut at knots that stand as often as the degree says or more, and,
    /// where a patch closes on itself without such a knot, at the one nearest the middle. Patches
    /// that share faces are cut alike. Faces and singular sets keep their names; a shape without
    /// such lines stays as it is.
    ///
    /// # Errors
    /// [`SplineError::Knots`] if knots become one by round-off.
    pub fn cut(self) -> Result<Self, SplineError> {
        let links = linked_directions(&self.patches);
        let cuts = cuts(&self.patches, &links);
        if cuts.values().all(|c| *c == Cuts::default()) {
            return Ok(self);
        }
        let of_patch = |(patch, links): (&Patch, &Vec<Linked>)| Parts::new(patch, links, &cuts);
        let parts: Vec<Parts> =
            self.patches.iter().zip(&links).map(of_patch).collect::<Result<_, SplineError>>()?;
        let first: Vec<usize> = parts
            .iter()
            .scan(0, |next, p| {
                *next += p.patches.len();
                Some(*next - p.patches.len())
            })
            .collect();
        let on_parts = |id: &FaceId| {
            let (base, id, parts) = (first[id.patch], *id, &parts[id.patch]);
            let own = parts.on_face(id.direction, id.upper).into_iter();
            own.map(move |part| FaceId { patch: base + part, ..id }).collect::<Vec<_>>()
        };
        let faces = self.faces.iter();
        let faces =
            faces.map(|(name, ids)| (name.clone(), ids.iter().flat_map(on_parts).collect())).collect();
        let singular = self
            .singular
            .iter()
            .flat_map(|set| parts[set.patch].singular(set, &self.patches[set.patch], first[set.patch]))
            .collect();
        let n = self.patches.first().map_or(0, Patch::dimension);
        let least = |d: usize| parts.iter().filter_map(|p| p.counts.get(d)).min().copied().unwrap_or(1);
        let counts = std::array::from_fn(|d| if d < n { self.parts[d] * least(d) } else { 1 });
        let patches = parts.into_iter().flat_map(|p| p.patches).collect();
        Ok(Self { patches, faces, singular, parts: counts, ..self })
    }
}

/// The cuts of each class of directions.
fn cuts(patches: &[Patch], links: &[Vec<Linked>]) -> BTreeMap<usize, Cuts> {
    let mut cuts: BTreeMap<usize, Cuts> = BTreeMap::new();
    for (patch, links) in patches.iter().zip(links) {
        for (knots, link) in patch.knots().iter().zip(links) {
            let (breaks, n) = (knots.breaks(), knots.n_elements());
            let own = cuts.entry(link.group).or_default();
            let lines = (1..n).filter(|i| knots.multiplicity(breaks[*i]) >= knots.degree());
            own.breaks.extend(lines.map(|i| if link.is_reversed { n - i } else { i }));
        }
    }
    let faces = FaceId::all(patches);
    let nets: Vec<FaceNet> = faces.iter().map(|&id| FaceNet::new(patches, id)).collect();
    for (a, b, _) in coinciding_pairs(&nets, COINCIDENT) {
        let (a, b) = (faces[a], faces[b]);
        if a.patch != b.patch || a.direction != b.direction || collapsed(&nets, &faces, a) {
            continue;
        }
        let (knots, link) = (&patches[a.patch].knots()[a.direction], links[a.patch][a.direction]);
        let Some(own) = cuts.get_mut(&link.group).filter(|c| **c == Cuts::default()) else { continue };
        let (breaks, n, (low, high)) = (knots.breaks(), knots.n_elements(), knots.domain());
        let off = |i: &usize| (breaks[*i] - 0.5 * (low + high)).abs();
        match (1..n).min_by(|i, j| off(i).total_cmp(&off(j))) {
            Some(i) => _ = own.breaks.insert(if link.is_reversed { n - i } else { i }),
            None => own.middle = true,
        }
    }
    cuts
}

/// Whether a face is a line or a point, whose two ends are one without that anything closes.
fn collapsed(nets: &[FaceNet], faces: &[FaceId], id: FaceId) -> bool {
    let Some(net) = faces.iter().position(|face| *face == id).map(|i| &nets[i]) else { return true };
    let [m, n] = net.sizes();
    let alike = |i: usize, j: usize| {
        let (p, q) = (&net.points()[i], &net.points()[j]);
        (0..3).map(|c| (p[c] - q[c]).powi(2)).sum::<f64>().sqrt() <= COINCIDENT * net.extent()
    };
    let along_first = m > 1 && (0..n).all(|j| (1..m).all(|i| alike(j * m, j * m + i)));
    let along_second = n > 1 && (0..m).all(|i| (1..n).all(|j| alike(i, j * m + i)));
    along_first || along_second
}

impl Parts {
    fn new(patch: &Patch, links: &[Linked], cuts: &BTreeMap<usize, Cuts>) -> Result<Self, SplineError> {
        let mut whole = patch.clone();
        let mut places = Vec::with_capacity(links.len());
        for (d, link) in links.iter().enumerate() {
            let (knots, own) = (&patch.knots()[d], &cuts[&link.group]);
            let (breaks, n, (low, high)) = (knots.breaks(), knots.n_elements(), knots.domain());
            let at = |i: &usize| breaks[if link.is_reversed { n - i } else { *i }];
            let mut at: Vec<f64> = own.breaks.iter().filter(|i| **i < n).map(at).collect();
            at.extend(own.middle.then_some(0.5 * (low + high)));
            at.sort_by(f64::total_cmp);
            let missing = |u: &f64| vec![*u; knots.degree().saturating_sub(knots.multiplicity(*u))];
            let more: Vec<f64> = at.iter().flat_map(missing).collect();
            if !more.is_empty() {
                whole = whole.insert_knots(d, &more)?;
            }
            places.push([vec![low], at, vec![high]].concat());
        }
        let counts: Vec<usize> = places.iter().map(|p| p.len() - 1).collect();
        let parts = (0..counts.iter().product()).map(|i| {
            let index = tensor::multi_index(&counts, i);
            let ends = |d: usize| [places[d][index[d]], places[d][index[d] + 1]];
            between(&whole, &(0..counts.len()).map(ends).collect::<Vec<_>>())
        });
        let patches = parts.collect::<Result<_, _>>()?;
        let shares = places
            .iter()
            .map(|p| {
                let (low, high) = (p[0], p[p.len() - 1]);
                p.iter().map(|u| (u - low) / (high - low)).collect()
            })
            .collect();
        Ok(Self { counts, shares, patches })
    }

    /// Numbers of the parts that have a part of a face.
    fn on_face(&self, direction: usize, upper: bool) -> Vec<usize> {
        let layer = if upper { self.counts[direction] - 1 } else { 0 };
        let all = 0..self.patches.len();
        all.filter(|&i| tensor::multi_index(&self.counts, i)[direction] == layer).collect()
    }

    /// The pieces of a singular set of `patch` on the parts into which it is cut, whose numbers
    /// begin with `first`.
    fn singular(&self, set: &SingularSet, patch: &Patch, first: usize) -> Vec<SingularSet> {
        const ROUND_OFF: f64 = 1e-12; // of parameters from 0 to 1
        let (low, high) = patch.domain();
        let on_part = |i: usize| {
            let index = tensor::multi_index(&self.counts, i);
            let mut parameters = [None; 3];
            for (d, own) in parameters.iter_mut().enumerate().take(self.counts.len()) {
                let Some(u) = set.parameters[d] else { continue };
                let share = (u - low[d]) / (high[d] - low[d]);
                let [from, to] = [self.shares[d][index[d]], self.shares[d][index[d] + 1]];
                if share < from - ROUND_OFF || share > to + ROUND_OFF {
                    return None;
                }
                *own = Some(((share - from) / (to - from)).clamp(0.0, 1.0));
            }
            Some(SingularSet { patch: first + i, parameters, name: set.name.clone() })
        };
        (0..self.patches.len()).filter_map(on_part).collect()
    }
}

/// The part of a patch between `ends` of each direction, which are ends of its range or knots that
/// stand as often as its degree says, over parameters from 0 to 1.
fn between(patch: &Patch, ends: &[[f64; 2]]) -> Result<Patch, SplineError> {
    let sizes = patch.net_size();
    let (mut knots, mut ranges) = (Vec::with_capacity(ends.len()), Vec::with_capacity(ends.len()));
    for (own, &[low, high]) in patch.knots().iter().zip(ends) {
        let p = own.degree();
        let inner =
            own.knots().iter().copied().filter(|u| *u > low && *u < high).map(|u| (u - low) / (high - low));
        let part = [vec![0.0; p + 1], inner.collect(), vec![1.0; p + 1]].concat();
        // Functions below the lower end: the one that interpolates there is the first.
        let below = own.knots().partition_point(|u| *u < low);
        let start = if below == 0 { 0 } else { below - 1 };
        let part = KnotVector::new(p, part)?;
        ranges.push(start..start + part.n_functions());
        knots.push(part);
    }
    let is_own = |i: &usize| {
        let index = tensor::multi_index(&sizes, *i);
        ranges.iter().zip(index).all(|(range, i)| range.contains(&i))
    };
    let own: Vec<usize> = (0..patch.n_functions()).filter(is_own).collect();
    let points = own.iter().map(|&i| patch.control_points()[i]).collect();
    Patch::new(knots, points, own.iter().map(|&i| patch.weights()[i]).collect())
}
