//! The names of codes are those of the header, and each verdict and reason of the header has a text.

use std::collections::BTreeSet;
use std::ffi::{CStr, c_char};

use bearing_watch_c::{bw_code_name, bw_reason_name, bw_verdict_name};

const HEADER: &str = include_str!("../include/bearing_watch.h");

/// The constants of the header with a prefix, and their numbers.
fn constants(prefix: &str) -> Vec<(&'static str, i32)> {
    let constant = |line: &'static str| {
        let (name, number) = line.trim().split_once(',')?.0.split_once(" = ")?;
        Some((name, number.parse().ok().filter(|_| name.starts_with(prefix))?))
    };
    HEADER.lines().filter_map(constant).collect()
}

fn text(name: *const c_char) -> &'static str {
    // SAFETY: every name is a text that lives as long as the program.
    unsafe { CStr::from_ptr(name) }.to_str().unwrap_or_default()
}

#[test]
fn codes_have_the_names_of_the_header() {
    let codes = constants("BW_CODE_");
    assert!(codes.contains(&("BW_CODE_NO_REPORT", -7)), "{codes:?}");
    for number in -200..200 {
        let known = codes.iter().find(|(_, code)| *code == number).map_or("unknown", |(name, _)| name);
        assert_eq!(text(bw_code_name(number)), known, "{number}");
    }
}

#[test]
fn verdicts_and_reasons_have_texts_of_their_own() {
    type Name = extern "C" fn(i32) -> *const c_char;
    let lists: [(&str, Name, usize); 2] = [("BW_VERDICT_", bw_verdict_name, 4), ("BW_REASON_", bw_reason_name, 17)];
    for (prefix, name, number) in lists {
        let texts: BTreeSet<&str> = constants(prefix).iter().map(|(_, value)| text(name(*value))).collect();
        assert_eq!(texts.len(), number, "{texts:?}");
        assert!(!texts.contains("unknown") && !texts.contains(""), "{texts:?}");
        assert_eq!(text(name(-1)), "unknown");
        assert_eq!(text(name(i32::MAX)), "unknown");
    }
}
