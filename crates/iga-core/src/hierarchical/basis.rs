//! Which functions of which level are active (theory Eq. H.3).

use super::domain::SubdomainHierarchy;
use super::index_box::{IndexBox, covers};
use super::neighbours::{self, Neighbours};
use super::ties::PatchTies;
use crate::splines::tensor;

/// The active functions of one level.
#[derive(Debug, Clone)]
struct ActiveLevel {
    sizes: [usize; 3],
    /// Flat net indices of the active functions, rising.
    flat: Vec<usize>,
    /// Number of the first of them.
    first: u32,
    /// Functions whose own support lies in the region, though the support of a function that they
    /// are tied to does not; in ascending order.
    held: Vec<usize>,
}

/// Functions on shared faces that the regions of the other patches keep from being refined, level
/// by level: flat net indices in ascending order.
#[derive(Debug, Clone, Default)]
struct Withheld {
    /// Supports that lie in the region of the level here, but not everywhere.
    from_level: Vec<Vec<usize>>,
    /// Supports that are refined here, but not everywhere.
    from_next: Vec<Vec<usize>>,
}

/// The hierarchical B-spline basis of a subdomain hierarchy: of each level `l` the functions whose
/// support lies in `Ω^l` but not in `Ω^(l+1)`. Numbered by level, then by net index.
#[derive(Debug, Clone)]
pub struct HierarchicalBasis {
    hierarchy: SubdomainHierarchy,
    levels: Vec<ActiveLevel>,
}

impl HierarchicalBasis {
    /// Selects the active functions.
    pub fn new(hierarchy: SubdomainHierarchy) -> Self {
        let none = vec![Vec::new(); hierarchy.levels().len()];
        Self::without(hierarchy, Withheld { from_level: none.clone(), from_next: none })
    }

    /// The same for patches with shared faces, whose `hierarchies` have the same levels: functions
    /// that are one across patches have one support, which lies in a region if it does so in every
    /// patch (H.9).
    pub(super) fn of_patches(
        hierarchies: Vec<SubdomainHierarchy>,
        neighbours: &Neighbours,
        ties: &[PatchTies],
    ) -> Vec<Self> {
        let withheld = |patch| Withheld::new(patch, &hierarchies, neighbours, ties);
        let all: Vec<Withheld> = (0..hierarchies.len()).map(withheld).collect();
        hierarchies
            .into_iter()
            .zip(all)
            .map(|(hierarchy, withheld)| Self::without(hierarchy, withheld))
            .collect()
    }

    fn without(hierarchy: SubdomainHierarchy, withheld: Withheld) -> Self {
        let (mut levels, mut first) = (Vec::new(), 0);
        let Withheld { from_level, from_next } = withheld;
        for ((level, held), stays) in hierarchy.levels().iter().zip(from_level).zip(from_next) {
            let sizes = level.net_size();
            let mut flat = Vec::new();
            for b in level.region() {
                for f in level.functions_on(b).elements() {
                    let support = level.support(&f);
                    let number = f[0] + sizes[0] * (f[1] + sizes[1] * f[2]);
                    if covers(level.region(), &support)
                        && held.binary_search(&number).is_err()
                        && (!covers(level.refined(), &support) || stays.binary_search(&number).is_ok())
                    {
                        flat.push(number);
                    }
                }
            }
            flat.sort_unstable();
            flat.dedup(); // a support that spans several boxes was met in each of them
            let n = flat.len() as u32;
            levels.push(ActiveLevel { sizes, flat, first, held });
            first += n;
        }
        Self { hierarchy, levels }
    }

    /// Whether the support of tensor-product function `index` of a level lies in the region of the
    /// level, in all patches.
    pub(super) fn is_inside(&self, level: usize, index: &[usize; 3]) -> bool {
        let (of, own) = (&self.hierarchy.levels()[level], &self.levels[level]);
        let is_held = || own.held.binary_search(&tensor::flat_index(&own.sizes, index)).is_ok();
        covers(of.region(), &of.support(index)) && (own.held.is_empty() || !is_held())
    }

    /// Number of the active function with net index `index` of a level.
    pub(super) fn number(&self, level: usize, index: &[usize; 3]) -> Option<u32> {
        let own = &self.levels[level];
        let at = own.flat.binary_search(&tensor::flat_index(&own.sizes, index)).ok()?;
        Some(own.first + at as u32)
    }

    /// The levels and regions below.
    pub fn hierarchy(&self) -> &SubdomainHierarchy {
        &self.hierarchy
    }

    /// Number of active functions of all levels.
    pub fn n_functions(&self) -> usize {
        self.levels.iter().map(|l| l.flat.len()).sum()
    }

    /// Flat net indices of the active functions of a level, rising.
    pub fn active_on_level(&self, level: usize) -> &[usize] {
        &self.levels[level].flat
    }

    /// Level and net multi-index of function `f`.
    pub fn function(&self, f: u32) -> (usize, [usize; 3]) {
        let level = self.levels.partition_point(|l| l.first <= f) - 1;
        // Levels without functions share their first number with the next one, which is the later
        // one.
        let l = &self.levels[level];
        (level, crate::splines::tensor::multi_index(&l.sizes, l.flat[(f - l.first) as usize]))
    }

    /// Calls `found(position, function)` for every active function of `level` in a box of net
    /// indices; positions count the box's entries, first direction fastest.
    pub fn active_in(&self, level: usize, functions: &IndexBox, mut found: impl FnMut(usize, u32)) {
        let l = &self.levels[level];
        let n = functions.sizes();
        for k in 0..n[2] {
            for j in 0..n[1] {
                let row = l.sizes[0] * (functions.lower[1] + j + l.sizes[1] * (functions.lower[2] + k));
                let (start, end) = (row + functions.lower[0], row + functions.upper[0]);
                let at = l.flat.partition_point(|&f| f < start);
                for (offset, &f) in l.flat[at..].iter().enumerate().take_while(|&(_, &f)| f < end) {
                    found(f - start + n[0] * (j + n[1] * k), l.first + (at + offset) as u32);
                }
            }
        }
    }
}

impl Withheld {
    /// What holds for the functions of patch `patch`.
    fn new(
        patch: usize,
        hierarchies: &[SubdomainHierarchy],
        neighbours: &Neighbours,
        ties: &[PatchTies],
    ) -> Self {
        let mut withheld = Self::default();
        for (l, own) in hierarchies[patch].levels().iter().enumerate() {
            let sizes: Vec<[usize; 3]> = hierarchies.iter().map(|h| h.levels()[l].net_size()).collect();
            let level = neighbours::Level { neighbours, ties, sizes: &sizes };
            let (mut from_level, mut from_next) = (Vec::new(), Vec::new());
            let candidates = own.region().iter().flat_map(|b| own.functions_on(b).elements());
            for index in candidates.filter(|index| level.is_shared(patch, index)) {
                let support = own.support(&index);
                if !covers(own.region(), &support) {
                    continue;
                }
                let group = level.group(patch, index);
                let everywhere = |is_in: &dyn Fn(&super::domain::Level, &IndexBox) -> bool| {
                    group.iter().all(|(p, i)| {
                        let there = &hierarchies[*p].levels()[l];
                        is_in(there, &there.support(i))
                    })
                };
                let flat = tensor::flat_index(&sizes[patch], &index);
                if !everywhere(&|level, support| covers(level.region(), support)) {
                    from_level.push(flat);
                } else if covers(own.refined(), &support)
                    && !everywhere(&|level, support| covers(level.refined(), support))
                {
                    from_next.push(flat);
                }
            }
            for list in [&mut from_level, &mut from_next] {
                list.sort_unstable();
                list.dedup();
            }
            withheld.from_level.push(from_level);
            withheld.from_next.push(from_next);
        }
        withheld
    }
}
