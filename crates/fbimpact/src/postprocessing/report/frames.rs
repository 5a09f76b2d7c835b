//! Which stored states a report shows in motion.

/// States at most.
pub const MOST: usize = 600;

/// Numbers of the stored states to be shown, at most `most`: all of short phases, evenly spaced
/// ones of long phases, with `always` among them and the first and last of every phase.
pub fn chosen(phases: &[u32], always: &[usize], most: usize) -> Vec<usize> {
    let n = phases.len();
    let mut spans: Vec<(usize, usize)> = Vec::new();
    for i in 0..n {
        match spans.last_mut() {
            Some((_, end)) if phases[i] == phases[*end - 1] => *end = i + 1,
            _ => spans.push((i, i + 1)),
        }
    }
    let room = most.saturating_sub(always.len()).max(1);
    let mut left = room;
    // Short phases first: what they do not need is for the long ones.
    spans.sort_by_key(|(start, end)| end - start);
    let mut all: Vec<usize> = always.iter().copied().filter(|i| *i < n).collect();
    for (k, &(start, end)) in spans.iter().enumerate() {
        let wanted = (end - start).min(left / (spans.len() - k));
        left -= wanted;
        all.extend(evenly(start, end, wanted));
    }
    all.extend([0, n.saturating_sub(1)].into_iter().filter(|_| n > 0));
    all.sort_unstable();
    all.dedup();
    all
}

/// `wanted` of the numbers from `start` to before `end`, the first and the last among them.
fn evenly(start: usize, end: usize, wanted: usize) -> impl Iterator<Item = usize> {
    let last = end - start - 1;
    (0..wanted).map(move |k| if wanted < 2 { start } else { start + k * last / (wanted - 1) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_phases_stay_whole_and_what_must_be_there_is_there() {
        let phases: Vec<u32> = (0..3000)
            .map(|i| {
                if i < 1000 {
                    0
                } else if i < 1100 {
                    1
                } else {
                    2
                }
            })
            .collect();
        let all = chosen(&phases, &[1555, 2222], 600);
        assert!(all.len() <= 602 && all.len() > 590, "{}", all.len());
        assert!((1000..1100).all(|i| all.contains(&i)));
        for i in [0, 999, 1100, 1555, 2222, 2999] {
            assert!(all.contains(&i), "{i}");
        }
        assert_eq!(chosen(&[0, 0, 1], &[], 600), [0, 1, 2]);
        assert!(chosen(&[], &[], 600).is_empty());
        // More phases than there is room for.
        assert!(chosen(&(0..5000).collect::<Vec<u32>>(), &[7], 600).len() <= 602);
    }
}
