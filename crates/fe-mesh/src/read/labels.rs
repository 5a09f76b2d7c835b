//! Numbers of nodes and elements in a file and their places in the lists.

/// From numbers of a file to places, sorted.
#[derive(Debug, Default)]
pub struct Labels {
    sorted: Vec<(u64, u32)>,
}

impl Labels {
    /// The places of `labels`.
    ///
    /// # Errors
    /// The first number that is there twice.
    pub fn new(labels: &[u64]) -> Result<Self, u64> {
        let mut sorted: Vec<(u64, u32)> = labels.iter().enumerate().map(|(i, &l)| (l, i as u32)).collect();
        sorted.sort_unstable();
        match sorted.windows(2).find(|w| w[0].0 == w[1].0) {
            Some(pair) => Err(pair[0].0),
            None => Ok(Self { sorted }),
        }
    }

    /// The place of `label`.
    pub fn get(&self, label: u64) -> Option<u32> {
        // Most files number without gaps.
        if let Some(first) = self.sorted.first()
            && let Some(&(l, place)) =
                usize::try_from(label.wrapping_sub(first.0)).ok().and_then(|i| self.sorted.get(i))
            && l == label
        {
            return Some(place);
        }
        self.sorted.binary_search_by_key(&label, |e| e.0).ok().map(|i| self.sorted[i].1)
    }

    /// Places of the numbers from `first` to `last` in steps of `step`, as far as they exist.
    pub fn range(&self, first: u64, last: u64, step: u64) -> impl Iterator<Item = u32> {
        let begin = self.sorted.partition_point(|e| e.0 < first);
        let all = self.sorted[begin..].iter().take_while(move |e| e.0 <= last);
        all.filter(move |e| (e.0 - first).is_multiple_of(step.max(1))).map(|e| e.1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_found_with_and_without_gaps() {
        let labels = Labels::new(&[5, 6, 7, 20, 3]).unwrap();
        assert_eq!(labels.get(20), Some(3));
        assert_eq!(labels.get(3), Some(4));
        assert_eq!(labels.get(6), Some(1));
        assert_eq!(labels.get(8), None);
        assert_eq!(labels.get(0), None);
        assert_eq!(labels.range(3, 1_000_000_000_000, 2).collect::<Vec<_>>(), [4, 0, 2]);
        assert_eq!(Labels::new(&[1, 2, 1]).unwrap_err(), 1);
    }
}
