//! What the names of columns say.

/// Parts of names of what is wanted rather than measured.
const REFERENCE: [&str; 12] = [
    "ref",
    "reference",
    "cmd",
    "command",
    "commanded",
    "demand",
    "set",
    "target",
    "setpoint",
    "desired",
    "sollwert",
    "consigne",
];
/// How words of wanted values begin in German, and what they have in Japanese and Chinese.
const WANTED: [&str; 5] = ["soll", "指令", "目標", "目标", "给定"];

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
    let is_wanted =
        |word: &str| WANTED.iter().any(|own| word.starts_with(own) || !own.is_ascii() && word.contains(own));
    words(name).iter().any(|word| REFERENCE.contains(&word.as_str()) || is_wanted(word))
}
