//! Names, texts and numbers → pieces of C.

use std::fmt::Write as _;

/// Adds a line.
pub(crate) fn line(out: &mut String, text: &str) {
    let _ = writeln!(out, "{text}");
}

/// Names that headers define themselves with the prefixes of enumerations.
const HEADERS: [&str; 3] = ["NAMES", "UNITS", "LIMITS"];

/// Adds an enumeration of these names from 0 on, which have this prefix.
pub(crate) fn enumeration(out: &mut String, prefix: &str, names: &[&str]) {
    let of_headers = HEADERS.map(|name| format!("{prefix}{name}"));
    let mut used: Vec<String> = Vec::new();
    for name in names {
        let plain = format!("{prefix}{}", identifier(name));
        // Names that differ only in what an identifier cannot have.
        let own = (1..).map(|k| if k == 1 { plain.clone() } else { format!("{plain}_{k}") });
        used.extend(own.into_iter().find(|own| ![&used[..], &of_headers].concat().contains(own)));
    }
    let places: Vec<String> = used.iter().enumerate().map(|(place, own)| format!("{own} = {place}")).collect();
    line(out, &format!("enum {{ {} }};", places.join(", ")));
}

fn identifier(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_uppercase() } else { '_' }).collect()
}

/// Words of C and C++ that a channel could be called by.
const WORDS: [&str; 40] = [
    "and", "auto", "bool", "break", "case", "char", "class", "const", "continue", "default", "delete", "do", "double",
    "else", "enum", "extern", "float", "for", "goto", "if", "inline", "int", "long", "new", "not", "operator", "or",
    "private", "public", "register", "return", "short", "signed", "static", "struct", "switch", "this", "union",
    "void", "while",
];

/// Names of the fields of a structure for these names, of which some are `taken`.
pub(crate) fn fields(names: &[&str], taken: &[&str]) -> Vec<String> {
    let mut used: Vec<String> = taken.iter().map(ToString::to_string).collect();
    for name in names {
        let plain = identifier(name).to_ascii_lowercase();
        let refused = plain.is_empty() || plain.starts_with(|c: char| c.is_ascii_digit()) || plain.starts_with('_');
        let plain = if refused || WORDS.contains(&plain.as_str()) { format!("channel_{plain}") } else { plain };
        let candidates = (1..).map(|k| if k == 1 { plain.clone() } else { format!("{plain}_{k}") });
        used.extend(candidates.into_iter().find(|field| !used.contains(field)));
    }
    used.split_off(taken.len())
}

/// Returns the initializer of an array of texts.
pub(crate) fn texts(names: &[&str]) -> String {
    format!("{{ {} }}", names.iter().map(|name| literal(name)).collect::<Vec<_>>().join(", "))
}

/// A string literal in ASCII: other bytes in octal, which ends after three digits.
fn literal(text: &str) -> String {
    let byte = |byte: u8| match byte {
        b'"' | b'\\' | b'?' | 0..=0x1F | 0x7F.. => format!("\\{byte:03o}"),
        _ => char::from(byte).to_string(),
    };
    format!("\"{}\"", text.bytes().map(byte).collect::<String>())
}

/// Returns the shortest decimal that a C compiler reads as the same `float`.
pub(crate) fn number(x: f32) -> String {
    format!("{x:?}f")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_become_identifiers_and_literals() {
        let mut out = String::new();
        enumeration(&mut out, "P_", &["spall 1", "spall-1", "größe"]);
        assert_eq!(out, "enum { P_SPALL_1 = 0, P_SPALL_1_2 = 1, P_GR__E = 2 };\n");
        let mut out = String::new();
        enumeration(&mut out, "P_", &["names", "Names 2", "names"]);
        assert_eq!(out, "enum { P_NAMES_2 = 0, P_NAMES_2_2 = 1, P_NAMES_3 = 2 };\n", "P_NAMES is a macro");
        let named = fields(&["Iq A", "iq-a", "int", "1x", "angle", ""], &["angle"]);
        assert_eq!(named, ["iq_a", "iq_a_2", "channel_int", "channel_1x", "angle_2", "channel_"]);
        assert_eq!(literal("a\"\\?\n°C1"), r#""a\042\134\077\012\302\260C1""#);
    }
}
