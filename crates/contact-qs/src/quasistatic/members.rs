//! Lists with the places of their members.

/// Numbers in the order in which they came, and the place of each among them.
pub(crate) struct Members {
    list: Vec<usize>,
    /// `usize::MAX`: no member.
    places: Vec<usize>,
}

impl Members {
    /// None of the numbers below `n` yet.
    pub fn new(n: usize) -> Self {
        Self { list: Vec::with_capacity(n), places: vec![usize::MAX; n] }
    }

    pub fn list(&self) -> &[usize] {
        &self.list
    }

    pub fn contains(&self, i: usize) -> bool {
        self.places[i] != usize::MAX
    }

    /// The place of the member `i`.
    pub fn place(&self, i: usize) -> usize {
        self.places[i]
    }

    /// Makes `i` the last member, unless it is one, and returns its place.
    pub fn add(&mut self, i: usize) -> usize {
        if !self.contains(i) {
            self.places[i] = self.list.len();
            self.list.push(i);
        }
        self.places[i]
    }

    pub fn clear(&mut self) {
        self.list.drain(..).for_each(|i| self.places[i] = usize::MAX);
    }

    /// Leaves the members `list` alone.
    pub fn set(&mut self, list: impl IntoIterator<Item = usize>) {
        self.clear();
        list.into_iter().for_each(|i| {
            self.add(i);
        });
    }

    /// Sorts the members from the place `first` on.
    pub fn sort_from(&mut self, first: usize, order: impl FnMut(&usize, &usize) -> std::cmp::Ordering) {
        self.list[first..].sort_unstable_by(order);
        self.list.iter().enumerate().skip(first).for_each(|(place, &i)| self.places[i] = place);
    }
}
