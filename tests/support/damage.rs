//! Files damaged at random, for readers.

/// Overwrites, cuts and doubles pieces of `text` as the bytes say; `letters` are some that the format knows.
pub fn mutated(text: &[u8], bytes: &[u8], letters: &[u8]) -> Vec<u8> {
    let mut out = text.to_vec();
    let mut bytes = bytes.iter().copied().cycle();
    let mut next = move || usize::from(bytes.next().unwrap_or(0));
    for _ in 0..=next() % 6 {
        if out.is_empty() {
            break;
        }
        let (at, n) = ((next() * 256 + next()) % out.len(), next() % 24);
        let end = (at + n).min(out.len());
        match next() % 4 {
            0 => out[at..end].iter_mut().for_each(|b| *b = next() as u8),
            1 => drop(out.drain(at..end)),
            2 => {
                let piece = out[at..end].to_vec();
                let to = next() % out.len();
                out.splice(to..to, piece);
            }
            _ => out[at] = letters[next() % letters.len()],
        }
    }
    out
}
