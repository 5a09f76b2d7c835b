//! Which functions of which level are active (theory Eq. H.3).

use super::domain::SubdomainHierarchy;
use super::index_box::{IndexBox, covers};

/// The active functions of one level.
#[derive(Debug, Clone)]
struct ActiveLevel {
    sizes: [usize; 3],
    /// Flat net indices of the active functions, rising.
    flat: Vec<usize>,
    /// Number of the first of them.
    first: u32,
}

/// The hierarchical B-spline basis of a subdomain hierarchy: of each level `l` the functions whose support lies in `Ω^l`
/// but not in `Ω^(l+1)`. Numbered by level, then by net index.
#[derive(Debug, Clone)]
pub struct HierarchicalBasis {
    hierarchy: SubdomainHierarchy,
    levels: Vec<ActiveLevel>,
}

impl HierarchicalBasis {
    /// Selects the active functions.
    pub fn new(hierarchy: SubdomainHierarchy) -> Self {
        let (mut levels, mut first) = (Vec::new(), 0);
        for level in hierarchy.levels() {
            let sizes = level.net_size();
            let mut flat = Vec::new();
            for b in level.region() {
                for f in level.functions_on(b).elements() {
                    let support = level.support(&f);
                    if covers(level.region(), &support) && !covers(level.refined(), &support) {
                        flat.push(f[0] + sizes[0] * (f[1] + sizes[1] * f[2]));
                    }
                }
            }
            flat.sort_unstable();
            flat.dedup(); // a support that spans several boxes was met in each of them
            let n = flat.len() as u32;
            levels.push(ActiveLevel { sizes, flat, first });
            first += n;
        }
        Self { hierarchy, levels }
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
        // Levels without functions share their first number with the next one, which is the later one.
        let l = &self.levels[level];
        (level, crate::tensor::multi_index(&l.sizes, l.flat[(f - l.first) as usize]))
    }

    /// Calls `found(position, function)` for every active function of `level` in a box of net indices; positions count
    /// the box's entries, first direction fastest.
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
