//! Compares the lines of a document with new ones.

/// How many lines of a difference are shown.
const SHOWN: usize = 6;

/// The first lines that differ, or none. A number is compared with the one at the same place of the same line, from
/// which it may differ by a part of the larger one; the text between them must be equal, and without tolerance all of
/// it.
pub fn difference(documented: &[String], found: &[String], tolerance: f64) -> Option<String> {
    let mut text = Vec::new();
    for k in 0..documented.len().max(found.len()) {
        let (old, new) = (documented.get(k), found.get(k));
        if !old.zip(new).is_some_and(|(old, new)| alike(old, new, tolerance)) {
            text.extend(old.map(|line| format!("- {line}")));
            text.extend(new.map(|line| format!("+ {line}")));
        }
    }
    let more = text.len().saturating_sub(SHOWN);
    text.truncate(SHOWN);
    text.extend((more > 0).then(|| format!("  … and {more} more lines")));
    (!text.is_empty()).then(|| text.join("\n"))
}

fn alike(old: &str, new: &str, tolerance: f64) -> bool {
    let (old, new) = (pieces(old), pieces(new));
    old.len() == new.len()
        && old.iter().zip(&new).all(|(old, new)| match (old.parse::<f64>(), new.parse::<f64>()) {
            (Ok(a), Ok(b)) if tolerance > 0.0 => (a - b).abs() <= tolerance * a.abs().max(b.abs()),
            _ => old == new,
        })
}

/// Cuts a line into numbers without signs and the text between them. Mantissa and exponent are apart.
fn pieces(line: &str) -> Vec<&str> {
    let (mut pieces, mut rest) = (Vec::new(), line);
    while let Some(first) = rest.chars().next() {
        let is_digit = |own: char| own.is_ascii_digit() || own == '.';
        let end = rest.find(|own| is_digit(own) != is_digit(first)).unwrap_or(rest.len());
        let (piece, after) = rest.split_at(end);
        pieces.push(piece);
        rest = after;
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_a_tolerance_and_text_has_none() {
        let differ = |old: &str, new: &str, tolerance| difference(&[old.into()], &[new.into()], tolerance).is_some();
        let close = 0.05;
        assert!(!differ("| a | 100 |", "| a | 104 |", close) && differ("| a | 100 |", "| a | 106 |", close));
        assert!(!differ("| 1.20e-3 |", "| 1.21e-3 |", close) && differ("| 1.2e-3 |", "| 1.2e-4 |", close));
        assert!(differ("| a | 100 |", "| b | 100 |", close) && differ("| a | 100 |", "| a | 100 | 1 |", close));
        assert!(differ("| a | 100 |", "| a | 104 |", 0.0));
        assert!(!differ("| a | 1.5 ms |", "| a | 27 ms |", 1.0));
        let many: Vec<String> = (0..20).map(|k| format!("line {k}")).collect();
        let text = difference(&many, &[], 0.0).unwrap_or_default();
        assert!(text.starts_with("- line 0\n") && text.ends_with("… and 14 more lines"), "{text}");
    }
}
