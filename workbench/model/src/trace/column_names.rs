//! What the names of columns say.

/// Parts of names of what is wanted rather than measured.
const REFERENCE: [&str; 7] = ["ref", "cmd", "command", "set", "target", "setpoint", "desired"];

/// Words of a name, in lower case.
#[must_use]
pub fn words(name: &str) -> Vec<String> {
    let mut words: Vec<String> = vec![String::new()];
    let mut before = ' ';
    for c in name.chars() {
        let breaks = !c.is_alphanumeric()
            || (c.is_ascii_uppercase() && before.is_ascii_lowercase())
            || (c.is_ascii_digit() && before.is_alphabetic());
        if breaks {
            words.push(String::new());
        }
        if c.is_alphanumeric()
            && let Some(last) = words.last_mut()
        {
            last.extend(c.to_lowercase());
        }
        before = c;
    }
    words.retain(|word| !word.is_empty());
    words
}

/// Whether the name is that of a wanted value rather than a measured one.
#[must_use]
pub fn is_reference(name: &str) -> bool {
    words(name).iter().any(|word| REFERENCE.contains(&word.as_str()))
}
