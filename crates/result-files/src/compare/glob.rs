//! Patterns of names with slashes: `*` is any text without a slash, `**` any text, `?` one
//! character.

/// Whether `name` matches `pattern`, both as a whole.
pub fn matches(pattern: &str, name: &str) -> bool {
    let (pattern, name): (Vec<char>, Vec<char>) = (pattern.chars().collect(), name.chars().collect());
    // reached[j]: the pattern so far matches the first j characters of the name.
    let mut reached = vec![false; name.len() + 1];
    reached[0] = true;
    let mut i = 0;
    while i < pattern.len() {
        if pattern[i] == '*' {
            let is_double = pattern.get(i + 1) == Some(&'*');
            for j in 0..name.len() {
                reached[j + 1] |= reached[j] && (is_double || name[j] != '/');
            }
            i += if is_double { 2 } else { 1 };
        } else {
            for j in (0..name.len()).rev() {
                let fits = pattern[i] == name[j] || (pattern[i] == '?' && name[j] != '/');
                reached[j + 1] = reached[j] && fits;
            }
            reached[0] = false;
            i += 1;
        }
    }
    reached[name.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn star_stops_at_slashes_and_double_star_does_not() {
        let cases = [
            ("energies/total", "energies/total", true),
            ("energies/total", "energies/totals", false),
            ("energies/*", "energies/total", true),
            ("contacts/*/force", "contacts/balls/force", true),
            ("contacts/*", "contacts/balls/force", false),
            ("contacts/**", "contacts/balls/force", true),
            ("**/force", "contacts/balls/force", true),
            ("**/force", "contacts/balls/friction_force", false),
            ("*", "time", true),
            ("**", "a/b/c", true),
            ("bodies/?od/*_velocit*", "bodies/rod/elastic_velocities", true),
            ("a?b", "a/b", false),
            ("", "a", false),
            ("", "", true),
        ];
        for (pattern, name, expected) in cases {
            assert_eq!(matches(pattern, name), expected, "{pattern} on {name}");
        }
    }
}
