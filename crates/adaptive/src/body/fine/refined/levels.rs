//! The levels of a plan: knots and boxes of elements, patch by patch (theory section A.2).

use iga_core::ParameterBox;
use iga_core::SplineError;
use iga_core::hierarchical::{IndexBox, Neighbours, PatchTies, SubdomainHierarchy, elements_around};
use iga_core::nurbs::Patch;
use iga_core::nurbs::interface::linked::{Linked, linked_directions};
use iga_core::nurbs::jet::norm;
use iga_core::nurbs::patch::PointBasis;
use iga_core::splines::knots::KnotVector;

use super::{Division, FineSettings, LinkedLattice, RefinementPlan, Region};
use crate::adaptivity::lattice::DirectionLattice;

/// Elements by which the coarser levels of a lattice reach beyond the interval at least.
const COARSE_REACH: usize = 2;
/// Distance from a knot, relative to the element, within which an end of a region counts as lying
/// on it.
const ON_KNOT: f64 = 1e-9;

/// Elements by which a level that splits elements into `parts` reaches beyond an interval. A
/// function of the finer level that is not zero on the interval ends within the degree divided by
/// `parts` elements of the coarser one.
pub(super) fn growth(knots: &KnotVector, parts: usize, settings: &FineSettings) -> usize {
    let degree = knots.degree();
    let own = if parts == 1 { degree } else { degree.div_ceil(2) };
    settings.growth.map_or(own, |g| g.min(degree))
}

/// Elements of those that it splits by which level `level` (0: the finest) of a lattice reaches
/// beyond the interval at least.
fn least_elements(level: usize) -> usize {
    if level == 0 { 1 } else { COARSE_REACH }
}

/// Length by which level `level` reaches beyond the interval in every direction at least \[m\]
/// (theory Eq. A.5), if elements of the finest level are as long as `shortest`: that of its
/// [`least_elements`], which are twice as long as those that it makes. Elements of the body may be
/// shorter in one direction; counted in those, a level that divides the other directions would end
/// beside the interval, and leave long elements below it.
fn least_reach(level: usize, shortest: f64) -> f64 {
    least_elements(level) as f64 * shortest * 2f64.powi(level as i32 + 1)
}

/// The levels of a plan, for every patch.
pub(super) fn refined(
    patches: &[Patch],
    plan: &RefinementPlan,
    settings: &FineSettings,
) -> Result<Vec<SubdomainHierarchy>, SplineError> {
    let mut levels = Levels::new(patches, &plan.regions);
    match &plan.division {
        Division::Lattice(lattices) => levels.add_lattices(lattices, settings)?,
        Division::Parts(parts) => levels.add_parts(parts, settings)?,
    }
    Ok(levels.hierarchies)
}

/// Which directions are divided together: of one patch each by itself.
pub(super) fn links(patches: &[Patch]) -> Vec<Vec<Linked>> {
    match patches {
        [only] => {
            vec![(0..only.dimension()).map(|group| Linked { group, is_reversed: false }).collect()]
        }
        _ => linked_directions(patches),
    }
}

/// Hierarchies of all patches as levels are added.
struct Levels {
    hierarchies: Vec<SubdomainHierarchy>,
    regions: Vec<Vec<ParameterBox>>,
    ties: Vec<PatchTies>,
    neighbours: Neighbours,
    linked: Vec<Vec<Linked>>,
    /// Metres a unit of parameter at the middle of a patch's first region.
    speeds: Vec<[f64; 3]>,
}

impl Levels {
    fn new(patches: &[Patch], regions: &[Region]) -> Self {
        let ties: Vec<PatchTies> = patches.iter().map(PatchTies::detect).collect();
        let mut of_patch = vec![Vec::new(); patches.len()];
        regions.iter().for_each(|r| of_patch[r.patch].push(r.bounds));
        let speeds = patches.iter().zip(&of_patch).map(|(patch, regions)| speeds(patch, regions)).collect();
        Self {
            speeds,
            hierarchies: patches.iter().map(|p| SubdomainHierarchy::new(p.knots())).collect(),
            regions: of_patch,
            neighbours: Neighbours::detect(patches, &ties),
            ties,
            linked: links(patches),
        }
    }

    /// Knots of the last level of a patch.
    fn knots(&self, patch: usize) -> &[KnotVector] {
        let levels = self.hierarchies[patch].levels();
        levels[levels.len() - 1].knots()
    }

    /// Boxes around the regions, grown by as many elements of the last level as `by` says for each
    /// direction of each patch, and by the length `reach` \[m\] where those elements are shorter.
    fn boxes(
        &self,
        reach: f64,
        by: impl Fn(usize, usize) -> usize,
    ) -> Result<Vec<Vec<IndexBox>>, SplineError> {
        let grow = |patch: usize| {
            let n = self.knots(patch).len();
            std::array::from_fn(|d| if d < n { by(patch, d) } else { 0 })
        };
        let by: Vec<[usize; 3]> = (0..self.hierarchies.len()).map(grow).collect();
        let widen = |patch: usize, region: &ParameterBox| {
            let mut wide = *region;
            for (d, knots) in self.knots(patch).iter().enumerate() {
                let (by, reach) = (by[patch][d] as i64, reach / self.speeds[patch][d]);
                let is_seam = self.ties[patch].seams[d];
                wide.lower[d] = moved(knots, region.lower[d], (-1, by, reach), is_seam);
                wide.upper[d] = moved(knots, region.upper[d], (1, by, reach), is_seam);
            }
            wide
        };
        let widened = |(patch, regions): (usize, &Vec<ParameterBox>)| {
            regions.iter().map(|region| widen(patch, region)).collect()
        };
        let regions: Vec<Vec<ParameterBox>> = self.regions.iter().enumerate().map(widened).collect();
        elements_around(&self.hierarchies, &regions, &by, (&self.ties, &self.neighbours))
    }

    /// Length of the shortest element of the finest level of lattices \[m\].
    fn shortest(&self, lattices: &[LinkedLattice]) -> f64 {
        let of_regions = lattices.iter().filter(|l| !self.regions[l.patch].is_empty());
        let length = |l: &LinkedLattice| l.lattice.spacing * self.speeds[l.patch][l.direction];
        of_regions.map(length).fold(f64::INFINITY, f64::min)
    }

    /// Adds a level.
    fn add(&mut self, knots: Vec<Vec<KnotVector>>, boxes: &[Vec<IndexBox>]) -> Result<(), SplineError> {
        if let [only] = &mut self.hierarchies[..] {
            return knots
                .into_iter()
                .zip(boxes)
                .try_for_each(|(knots, boxes)| only.refine_knots(knots, boxes));
        }
        for ((hierarchy, knots), boxes) in self.hierarchies.iter_mut().zip(knots).zip(boxes) {
            hierarchy.follow_knots(knots, boxes)?;
        }
        Ok(())
    }

    /// The levels of Algorithm 3, which is for bodies of one patch.
    fn add_parts(&mut self, levels: &[[usize; 3]], settings: &FineSettings) -> Result<(), SplineError> {
        for &parts in levels.iter().filter(|p| p.iter().any(|&n| n > 1)) {
            let boxes = self.boxes(0.0, |patch, d| growth(&self.knots(patch)[d], parts[d], settings))?;
            let split = |(d, k): (usize, &KnotVector)| {
                split_inside(k, parts[d], |e| boxes[0].iter().any(|b| (b.lower[d]..b.upper[d]).contains(&e)))
            };
            let knots = self.knots(0).iter().enumerate().map(split).collect::<Result<Vec<_>, _>>()?;
            self.add(vec![knots], &boxes)?;
        }
        Ok(())
    }

    /// The levels of lattices.
    fn add_lattices(
        &mut self,
        lattices: &[LinkedLattice],
        settings: &FineSettings,
    ) -> Result<(), SplineError> {
        let n_levels = lattices.iter().map(|l| l.lattice.n_skipped + l.lattice.n_levels).max().unwrap_or(0);
        let shortest = self.shortest(lattices);
        for level in (0..n_levels).rev() {
            // Levels beyond the finest reach out further: their elements then grow with the
            // distance from the contact.
            let reach = |patch: usize, d: usize| {
                let knots = &self.knots(patch)[d];
                let lattice = self.lattice_of(lattices, patch, d);
                let divides = lattice.is_some_and(|l| l.divides(level));
                let own = growth(knots, if divides { 2 } else { 1 }, settings);
                // Finer levels that leave the direction as it is reach out by its degree. Elements
                // of this one hold two of those, but for two at a knot of the coarse model.
                let finer = if divides && lattice.is_some_and(|l| l.n_skipped > 0) {
                    knots.degree().div_ceil(2) + 1
                } else {
                    0
                };
                own.max(finer).max(least_elements(level))
            };
            let boxes = self.boxes(least_reach(level, shortest), reach)?;
            let new =
                lattices.iter().map(|l| self.new_knots(l, level, &boxes)).collect::<Result<Vec<_>, _>>()?;
            if new.iter().all(Vec::is_empty) {
                continue;
            }
            let knots = (0..self.hierarchies.len()).map(|patch| self.finer(patch, lattices, &new));
            let knots = knots.collect::<Result<Vec<_>, _>>()?;
            self.add(knots, &boxes)?;
        }
        Ok(())
    }

    /// The lattice of the direction, or of one that is divided together with it.
    fn lattice_of<'a>(
        &self,
        lattices: &'a [LinkedLattice],
        patch: usize,
        d: usize,
    ) -> Option<&'a DirectionLattice> {
        let group = self.linked[patch][d].group;
        let found = lattices.iter().find(|l| self.linked[l.patch][l.direction].group == group);
        found.map(|l| &l.lattice)
    }

    /// Points of a lattice on a level that the last one has not, in elements that some patch
    /// refines.
    fn new_knots(
        &self,
        of: &LinkedLattice,
        level: usize,
        boxes: &[Vec<IndexBox>],
    ) -> Result<Vec<f64>, SplineError> {
        let coarse = &self.knots(of.patch)[of.direction];
        let (n, leader) = (coarse.n_elements(), self.linked[of.patch][of.direction]);
        let mut is_wanted = vec![false; n];
        for (links, boxes) in self.linked.iter().zip(boxes) {
            for (d, link) in links.iter().enumerate().filter(|(_, link)| link.group == leader.group) {
                for b in boxes {
                    for e in b.lower[d]..b.upper[d] {
                        let is_against = link.is_reversed != leader.is_reversed;
                        is_wanted[if is_against { n - 1 - e } else { e }] = true;
                    }
                }
            }
        }
        Ok(of.lattice.new_knots(coarse, level, |e| is_wanted[e]))
    }

    /// The knots of the next level of a patch: those of the last one and, in directions divided
    /// together with a lattice, the `new` ones of it.
    fn finer(
        &self,
        patch: usize,
        lattices: &[LinkedLattice],
        new: &[Vec<f64>],
    ) -> Result<Vec<KnotVector>, SplineError> {
        let mut knots = self.knots(patch).to_vec();
        for (d, knots) in knots.iter_mut().enumerate() {
            let own = self.linked[patch][d];
            for (lattice, new) in lattices.iter().zip(new) {
                let leader = self.linked[lattice.patch][lattice.direction];
                if leader.group == own.group {
                    let mirror = mirror(knots, own.is_reversed != leader.is_reversed);
                    *knots = knots.with_knots(&new.iter().map(|u| mirror(*u)).collect::<Vec<_>>())?;
                }
            }
        }
        Ok(knots)
    }
}

/// Metres a unit of parameter in the directions of a patch, at the middle of the first of its
/// regions; ones if it has none.
fn speeds(patch: &Patch, regions: &[ParameterBox]) -> [f64; 3] {
    let Some(ParameterBox { lower, upper }) = regions.first() else { return [1.0; 3] };
    let middle = std::array::from_fn(|d| 0.5 * (lower[d] + upper[d]));
    patch.jet(&middle, 1, &mut PointBasis::default()).first.map(|tangent| norm(&tangent))
}

/// The end of a region in one direction, moved outwards (`sign` 1 or -1) into the nearest element
/// beyond which `by` further ones end no nearer to the end than `reach`, in parameters; the end
/// itself if it lies in that element. Stops at an end of the patch, but for a seam.
fn moved(knots: &KnotVector, end: f64, (sign, by, reach): (i64, i64, f64), is_seam: bool) -> f64 {
    let n = knots.n_elements() as i64;
    let (first, last) = knots.domain();
    let element = |e: i64| {
        let (a, b) = knots.element(e.rem_euclid(n) as usize);
        let turns = e.div_euclid(n) as f64 * (last - first);
        (a + turns, b + turns)
    };
    if !(first <= end && end <= last) {
        return end;
    }
    let (a, b) = knots.element(knots.find_element(end));
    // The element on the region's side of a knot.
    let own = knots.find_element((end - sign as f64 * ON_KNOT * (b - a)).clamp(first, last)) as i64;
    let is_short = |e: &i64| {
        let outer = e + sign * by;
        let (a, b) = element(outer);
        let covered = if sign > 0 { b - end } else { end - a };
        covered < (1.0 - ON_KNOT) * reach && (is_seam || (0 < outer && outer < n - 1))
    };
    let found = (0..n).map(|i| own + sign * i).find(|e| !is_short(e)).unwrap_or(own);
    if found == own {
        return end;
    }
    let (a, b) = element(found);
    0.5 * (a + b)
}

/// What turns a parameter of a direction into that of one that runs against it, if it does, over
/// the same range.
pub(super) fn mirror(knots: &KnotVector, is_against: bool) -> impl Fn(f64) -> f64 + use<> {
    let (first, last) = knots.domain();
    move |u| if is_against { first + (last - u) } else { u }
}

/// Splits the elements that are `wanted` into `parts` equal ones. Elsewhere the next level is not
/// used and needs no knots, of which a long body would have many.
fn split_inside(
    coarse: &KnotVector,
    parts: usize,
    wanted: impl Fn(usize) -> bool,
) -> Result<KnotVector, SplineError> {
    let mut new = Vec::new();
    for e in (0..coarse.n_elements()).filter(|&e| wanted(e)) {
        let (a, b) = coarse.element(e);
        new.extend((1..parts).map(|k| a + (b - a) * (k as f64 / parts as f64)));
    }
    coarse.with_knots(&new)
}
