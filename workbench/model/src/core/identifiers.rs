//! Names of columns → identifiers of Rust, C and C++, which name the channels of a model.
//!
//! Each has at most 32 letters, digits and underscores, is no word of these languages and no name that an exported
//! model uses itself, and differs from the others. The same names in the same order give the same identifiers.

/// Longest name of a channel, bytes.
const LONGEST: usize = 32;

/// Words of Rust, of all editions and reserved ones, and names in the scopes in which an exported model names channels.
const RUST: &str = "_ abstract as async await become box break const continue crate do dyn else enum extern false final \
                    fn for gen if impl in let loop macro match mod move mut override priv pub ref return self Self \
                    static struct super trait true try type typeof union unsafe unsized use virtual where while yield \
                    Some None Ok Err CHANNELS LAYOUT MODEL FRONT_END FURTHER Drive Sample Place angle \
                    clean channel values position";

/// Words of C and C++ that are none of Rust.
const C: &str = "alignas alignof and and_eq asm auto bitand bitor bool case catch char char8_t char16_t char32_t class \
                 co_await co_return co_yield compl concept consteval constexpr constinit const_cast decltype default \
                 delete double dynamic_cast explicit export float friend goto inline int long mutable namespace new \
                 noexcept not not_eq nullptr operator or or_eq private protected public register reinterpret_cast \
                 requires restrict short signed sizeof static_assert static_cast switch template this thread_local \
                 throw typedef typeid typename typeof_unqual unsigned using void volatile wchar_t xor xor_eq";

/// The identifiers of names.
pub fn identifiers<'n>(names: impl IntoIterator<Item = &'n str>) -> Vec<String> {
    let mut taken: Vec<String> = Vec::new();
    for name in names {
        let plain = identifier(name);
        let numbered = |k: usize| if k == 1 { plain.clone() } else { ended(&plain, &format!("_{k}")) };
        taken.extend((1..).map(numbered).find(|one| !taken.contains(one)));
    }
    taken
}

/// The identifier of one name, whatever the others are.
fn identifier(name: &str) -> String {
    let each = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' });
    let text: String = each.take(LONGEST).collect();
    let is_reserved = || [RUST, C].iter().any(|words| words.split_ascii_whitespace().any(|word| word == text));
    if !text.contains(|c: char| c.is_ascii_alphanumeric()) {
        "channel_1".into()
    } else if text.starts_with(|c: char| c.is_ascii_digit()) {
        format!("_{text}").chars().take(LONGEST).collect()
    } else if is_reserved() {
        ended(&text, "_")
    } else {
        text
    }
}

/// A name with this ending, shortened for it.
fn ended(name: &str, ending: &str) -> String {
    name.chars().take(LONGEST.saturating_sub(ending.len())).chain(ending.chars()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stay_if_they_can_and_differ_always() {
        let long = "velocity_of_the_output_shaft_behind_the_gear";
        let other = format!("{long}_2");
        let names = ["current_a", "1st", "type", "type_", "é", "ü", "", "T °C", long, &other, "a b", "a-b", "a_b"];
        let all = identifiers(names);
        assert_eq!(all[..6], ["current_a", "_1st", "type_", "type__2", "channel_1", "channel_1_2"]);
        assert_eq!(all[6..8], ["channel_1_3", "T__C"]);
        assert_eq!(all[8..10], ["velocity_of_the_output_shaft_beh", "velocity_of_the_output_shaft_b_2"]);
        assert_eq!(all[10..], ["a_b", "a_b_2", "a_b_3"]);
        assert!(all.iter().all(|own| (1..=LONGEST).contains(&own.len())));
        assert_eq!(identifiers(names), all);
    }
}
