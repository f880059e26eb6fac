//! Escapes text for use inside HTML and SVG elements and quoted attributes.

/// Replaces the five characters with a special meaning in markup, and control characters, which HTML does not allow.
#[must_use]
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            '\n' | '\t' => out.push(c),
            c if c.is_control() => out.push('\u{FFFD}'),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::escape;

    #[test]
    fn markup_and_control_characters_are_neutralised() {
        assert_eq!(escape(r#"<a href="x" id='y'>&amp;"#), "&lt;a href=&quot;x&quot; id=&#39;y&#39;&gt;&amp;amp;");
        assert_eq!(escape("a\0b\nc"), "a\u{FFFD}b\nc");
    }

    #[test]
    fn ordinary_text_is_untouched() {
        assert_eq!(escape("ω in rad·s⁻¹, 5 µm"), "ω in rad·s⁻¹, 5 µm");
    }
}
