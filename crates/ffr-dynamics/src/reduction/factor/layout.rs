//! Where the entries of a supernodal factor stand, and which supernode changes which (Eq. R.4).
//!
//! Wide supernodes are cut into panels of at most [`PANEL`] columns. A panel is stored by columns:
//! its own rows first, then those of the later panels of its supernode, then the pattern. Offsets
//! are `usize`, so that factors of more than 4e9 entries can be counted.

use super::supernodes::{NONE, Supernodes};

/// Most columns of a panel: products of panels add up at most so many terms in a row, which no
/// processor splits by the size of its cache.
pub(super) const PANEL: usize = 256;

/// Columns `first..end` of one supernode.
#[derive(Debug, Clone, Copy)]
pub(in crate::reduction) struct Panel {
    pub first: usize,
    pub end: usize,
    /// Where its entries begin.
    pub values: usize,
    /// Rows from its first column on.
    pub n_rows: usize,
}

impl Panel {
    /// Number of columns.
    pub fn width(&self) -> usize {
        self.end - self.first
    }

    /// Number of entries, those above the diagonal included.
    pub fn n_values(&self) -> usize {
        self.width() * self.n_rows
    }
}

/// Part of the pattern of supernode `source` that lies in the columns of another one.
#[derive(Debug, Clone, Copy)]
pub(in crate::reduction) struct Update {
    pub source: u32,
    pub begin: u32,
    pub end: u32,
}

/// Supernodes, panels and updates of a factor.
#[derive(Debug)]
pub(in crate::reduction) struct Layout {
    pub supernodes: Supernodes,
    panels: Vec<Panel>,
    panel_start: Vec<usize>,
    updates: Vec<Update>,
    update_start: Vec<usize>,
    /// First supernode of the subtree of each one.
    pub first_descendant: Vec<u32>,
    child_start: Vec<usize>,
    children: Vec<u32>,
    /// Multiplications and additions of the subtree of each supernode.
    pub work: Vec<f64>,
    /// Stored entries of the subtree of each supernode.
    pub subtree_values: Vec<usize>,
    /// For every row of a pattern its place among the columns and rows of the parent.
    pub in_parent: Vec<u32>,
}

impl Layout {
    /// Panels and updates of `supernodes`.
    pub fn new(supernodes: Supernodes) -> Self {
        let n = supernodes.len();
        let (mut panels, mut panel_start, mut values) = (Vec::new(), vec![0], 0);
        let mut work = vec![0.0; n];
        for s in 0..n {
            let columns = supernodes.columns(s);
            let n_panels = columns.len().div_ceil(PANEL);
            let width = columns.len().div_ceil(n_panels).next_multiple_of(8);
            let below = supernodes.pattern(s).len();
            for first in columns.clone().step_by(width) {
                let end = (first + width).min(columns.end);
                let panel = Panel { first, end, values, n_rows: columns.end - first + below };
                values += panel.n_values();
                panels.push(panel);
            }
            panel_start.push(panels.len());
            let (c, r) = (columns.len() as f64, below as f64);
            work[s] += c * c * c / 3.0 + c * c * r + c * r * r;
            if supernodes.parent[s] != NONE {
                work[supernodes.parent[s] as usize] += work[s];
            }
        }
        let (update_start, updates) = updates(&supernodes);
        let (child_start, children, first_descendant) = families(&supernodes);
        let start = |s: usize| panels.get(panel_start[s]).map_or(values, |p: &Panel| p.values);
        let subtree_values = (0..n).map(|s| start(s + 1) - start(first_descendant[s] as usize)).collect();
        let in_parent = in_parent(&supernodes);
        Self {
            panels,
            panel_start,
            updates,
            update_start,
            first_descendant,
            child_start,
            children,
            work,
            subtree_values,
            in_parent,
            supernodes,
        }
    }

    /// Stored entries.
    pub fn n_values(&self) -> usize {
        self.panels.last().map_or(0, |p| p.values + p.n_values())
    }

    /// Panels of supernode `s`.
    pub fn panels(&self, s: usize) -> &[Panel] {
        &self.panels[self.panel_start[s]..self.panel_start[s + 1]]
    }

    /// All panels.
    pub fn all_panels(&self) -> &[Panel] {
        &self.panels
    }

    /// The supernodes that contribute to supernode `s`, in ascending order.
    pub fn updates(&self, s: usize) -> &[Update] {
        &self.updates[self.update_start[s]..self.update_start[s + 1]]
    }

    /// Children of supernode `s`, ascending.
    pub fn children(&self, s: usize) -> &[u32] {
        &self.children[self.child_start[s]..self.child_start[s + 1]]
    }

    /// Supernodes without parent, ascending.
    pub fn roots(&self) -> Vec<u32> {
        (0..self.supernodes.len() as u32).filter(|&s| self.supernodes.parent[s as usize] == NONE).collect()
    }

    /// Place of the first entry of supernode `s` among those of the factor.
    pub fn values_of(&self, s: usize) -> usize {
        self.panels[self.panel_start[s]].values
    }
}

/// For every supernode the parts of patterns in its columns: where its list begins, and all lists.
fn updates(supernodes: &Supernodes) -> (Vec<usize>, Vec<Update>) {
    let n = supernodes.len();
    let mut owner = vec![0_u32; supernodes.order.len()];
    (0..n).for_each(|s| owner[supernodes.columns(s)].fill(s as u32));
    let visit = |call: &mut dyn FnMut(usize, Update)| {
        for s in 0..n {
            let pattern = supernodes.pattern(s);
            let mut begin = 0;
            while begin < pattern.len() {
                let target = owner[pattern[begin] as usize] as usize;
                let limit = supernodes.first[target + 1];
                let end = begin + pattern[begin..].partition_point(|&row| row < limit);
                call(target, Update { source: s as u32, begin: begin as u32, end: end as u32 });
                begin = end;
            }
        }
    };
    let mut start = vec![0; n + 1];
    visit(&mut |target, _| start[target + 1] += 1);
    (0..n).for_each(|s| start[s + 1] += start[s]);
    let mut next = start.clone();
    let mut all = vec![Update { source: 0, begin: 0, end: 0 }; start[n]];
    visit(&mut |target, update| {
        all[next[target]] = update;
        next[target] += 1;
    });
    (start, all)
}

/// Children of every supernode, where the list of each begins first, and the first supernode of
/// every subtree.
fn families(supernodes: &Supernodes) -> (Vec<usize>, Vec<u32>, Vec<u32>) {
    let n = supernodes.len();
    let mut start = vec![0; n + 1];
    let mut first_descendant: Vec<u32> = (0..n as u32).collect();
    for (s, &parent) in supernodes.parent.iter().enumerate().filter(|&(_, &p)| p != NONE) {
        start[parent as usize + 1] += 1;
        first_descendant[parent as usize] = first_descendant[parent as usize].min(first_descendant[s]);
    }
    (0..n).for_each(|s| start[s + 1] += start[s]);
    let mut next = start.clone();
    let mut children = vec![0; start[n]];
    for (s, &parent) in supernodes.parent.iter().enumerate().filter(|&(_, &p)| p != NONE) {
        children[next[parent as usize]] = s as u32;
        next[parent as usize] += 1;
    }
    (start, children, first_descendant)
}

/// Places of all rows below supernodes among the columns and rows of the parents.
fn in_parent(supernodes: &Supernodes) -> Vec<u32> {
    let mut positions = Vec::new();
    for s in 0..supernodes.len() {
        let parent = supernodes.parent[s];
        if parent == NONE {
            continue;
        }
        let columns = supernodes.columns(parent as usize);
        let mut below = supernodes.pattern(parent as usize).iter();
        let mut at = columns.len() as u32;
        for &row in supernodes.pattern(s) {
            positions.push(if (row as usize) < columns.end {
                row - columns.start as u32
            } else {
                at += below.by_ref().take_while(|&&r| r != row).count() as u32 + 1;
                at - 1
            });
        }
    }
    positions
}
