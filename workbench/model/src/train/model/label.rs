//! Names of classes as the core has them, which holds 16 bytes of each.

use std::borrow::Cow;

/// Bytes of the longest name in the core.
const LONGEST: usize = 16;
/// Bytes of a longer name that are kept before its number.
const KEPT: usize = 11;

/// The name of a class in the core: a longer one is cut, and has a number of the whole name behind it. It depends on
/// this name alone, so that training and evaluation agree.
#[must_use]
pub fn label(name: &str) -> Cow<'_, str> {
    if name.len() <= LONGEST {
        return Cow::Borrowed(name);
    }
    let end = (0..=KEPT).rev().find(|end| name.is_char_boundary(*end)).unwrap_or(0);
    // FNV-1a, 32 bits, folded.
    let hash = name.bytes().fold(0x811c_9dc5_u32, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193));
    Cow::Owned(format!("{}~{:04x}", &name[..end], (hash ^ hash >> 16) & 0xffff))
}

/// What there is to say of names that are cut.
pub fn cut(classes: &[String]) -> impl Iterator<Item = String> {
    let long = classes.iter().filter(|name| name.len() > LONGEST);
    long.map(|name| format!("class {name} is {} in the model, whose names have {LONGEST} bytes", label(name)))
}

/// The first two names that are one in the core.
#[must_use]
pub fn alike(classes: &[String]) -> Option<[&str; 2]> {
    let pairs = classes.iter().enumerate().flat_map(|(k, one)| classes[..k].iter().map(move |other| [other, one]));
    pairs.map(|pair| pair.map(String::as_str)).find(|[one, other]| label(one) == label(other))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_names_are_cut_and_stay_different() {
        assert_eq!(label("lackLubrication1"), "lackLubrication1");
        let long = ["spall-and-roughness", "spall-and-roughnest", "größe-des-schadens-ä", "ääääääääääää"];
        for (k, name) in long.iter().enumerate() {
            let cut = label(name);
            assert!(cut.len() <= LONGEST && name.starts_with(cut.split('~').next().expect("a part")), "{cut}");
            assert!(long[..k].iter().all(|other| label(other) != cut), "{cut}");
        }
        assert!(label(long[0]).starts_with("spall-and-r~"));
        let names = |all: &[&str]| all.iter().map(ToString::to_string).collect::<Vec<_>>();
        assert_eq!(cut(&names(&["healthy", long[0]])).count(), 1);
        let short = label(long[0]).into_owned();
        assert_eq!(alike(&names(&[long[0], "x", &short])), Some([long[0], &*short]));
        assert_eq!(alike(&names(&long)), None);
    }
}
