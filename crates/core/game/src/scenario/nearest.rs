//! Guesses what a misspelt name was meant to be.

/// Returns the known name that takes the fewest edits, at most a third of the name's characters (but at least one);
/// of several the first. `None` where all are further away.
pub(super) fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let edits_max = (name.chars().count() / 3).max(1);
    known
        .into_iter()
        .map(|candidate| (edits(name, candidate), candidate))
        .filter(|&(edits, _)| edits <= edits_max)
        .min_by_key(|&(edits, _)| edits)
        .map(|(_, candidate)| candidate)
}

/// Returns the known name nearest to the unknown one of a parser's message.
///
/// The message puts names between backticks, first the unknown one, then those that it expected.
pub(super) fn nearest_in_message(message: &str) -> Option<&str> {
    if !message.starts_with("unknown ") {
        return None;
    }
    let mut names = message.split('`').skip(1).step_by(2);
    let unknown = names.next()?;
    nearest(unknown, names)
}

/// Returns the number of characters to insert, delete, replace or swap with a neighbour that turn `a` into `b`:
/// the restricted distance of Damerau (1964), row by row.
fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut above: Vec<usize> = Vec::new();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    let mut before = None;
    for (i, letter) in a.chars().enumerate() {
        let mut next = vec![i + 1];
        for (j, &other) in b.iter().enumerate() {
            let replaced = row[j] + usize::from(letter != other);
            let mut least = replaced.min(row[j + 1] + 1).min(next[j] + 1);
            if j > 0 && before == Some(other) && b[j - 1] == letter {
                least = least.min(above[j - 1] + 1);
            }
            next.push(least);
        }
        before = Some(letter);
        above = std::mem::replace(&mut row, next);
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_of_the_fingers_is_recognised() {
        let known = ["length_seconds", "name", "rate", "seat", "seed"];
        let check = |name, expected| assert_eq!(nearest(name, known), expected, "{name}");
        check("lenght_seconds", Some("length_seconds"));
        check("Name", Some("name"));
        check("rat", Some("rate"));
        check("seeds", Some("seed"));
        check("colour", None);
        check("", None);
    }

    #[test]
    fn edits_are_counted() {
        let check = |a, b, expected| assert_eq!(edits(a, b), expected, "{a} {b}");
        check("", "", 0);
        check("", "abc", 3);
        check("abc", "", 3);
        check("scuot", "scout", 1);
        check("tank", "tanks", 1);
        check("kitten", "sitting", 3);
    }
}
