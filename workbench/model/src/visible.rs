//! Text of files, names and received frames, made harmless for a terminal and for the comments of a source.
//!
//! A control character can move the cursor, change earlier lines and send keys; a control of the direction of writing
//! shows words in another order than they have. Each becomes its number, such as `\u{1b}`.

use std::borrow::Cow;

/// Whether a character acts instead of being shown.
fn acts(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// The text as one line: every character that acts as its number, also line feeds and tabs.
#[must_use]
pub fn line(text: &str) -> Cow<'_, str> {
    replaced(text, |_| false, |c| c.escape_unicode().to_string())
}

/// The same with its line feeds and tabs.
#[must_use]
pub fn lines(text: &str) -> Cow<'_, str> {
    replaced(text, is_layout, |c| c.escape_unicode().to_string())
}

/// The same for the text of a JSON value, in the numbers that JSON has.
#[must_use]
pub fn json(text: &str) -> Cow<'_, str> {
    // All characters that act are in the plane of four digits.
    replaced(text, is_layout, |c| format!("\\u{:04x}", u32::from(c)))
}

const fn is_layout(c: char) -> bool {
    matches!(c, '\n' | '\t')
}

fn replaced(text: &str, stays: fn(char) -> bool, number: fn(char) -> String) -> Cow<'_, str> {
    if !text.contains(|c| acts(c) && !stays(c)) {
        return Cow::Borrowed(text);
    }
    text.chars()
        .fold(String::with_capacity(text.len()), |mut out, c| {
            if acts(c) && !stays(c) {
                out.push_str(&number(c));
            } else {
                out.push(c);
            }
            out
        })
        .into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_acts_becomes_its_number() {
        let text = "a\u{1b}[2J\rb\u{9b}31m\u{7f}\u{202e}c\n\tµ°é\u{2066}\0";
        assert_eq!(line(text), "a\\u{1b}[2J\\u{d}b\\u{9b}31m\\u{7f}\\u{202e}c\\u{a}\\u{9}µ°é\\u{2066}\\u{0}");
        assert_eq!(lines("a\n\tb\u{1b}"), "a\n\tb\\u{1b}");
        assert!(matches!(lines("plain text\n\t°C"), Cow::Borrowed(_)));
        for c in (0..=0x10_FFFF).filter_map(char::from_u32).filter(|c| c.is_control()) {
            assert!(line(&c.to_string()).chars().all(|c| c.is_ascii_graphic()), "{c:?}");
        }
    }

    #[test]
    fn json_stays_json() {
        let value = serde_json::json!({ "name": "a\u{1b}\u{9b}\u{202e}\n\t\"\\b" });
        for text in [value.to_string(), format!("{value:#}")] {
            let shown = json(&text);
            assert!(!shown.contains(|c| acts(c) && c != '\n'), "{shown:?}");
            assert_eq!(serde_json::from_str::<serde_json::Value>(&shown).expect("JSON"), value);
        }
    }
}
