//! The committed header is the one that cbindgen makes from the source.
#![allow(
    clippy::cast_possible_truncation,
    clippy::expect_used,
    clippy::float_cmp,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::unwrap_used,
    reason = "a test fails by a panic"
)]

use std::path::Path;
use std::{env, fs};

use cbindgen::{Builder, Config, DocumentationStyle, EnumConfig, ExportConfig, FunctionConfig, Language, RenameRule};

/// If set, the test writes the header instead of comparing it.
const WRITE: &str = "BEARING_WATCH_WRITE_HEADER";

/// The files with public items, in the order of the header; one with modules stands for theirs, too.
const SOURCES: [&str; 23] = [
    "code",
    "plan",
    "signature",
    "memory",
    "state",
    "sampling",
    "below",
    "angle",
    "solving",
    "clock",
    "report",
    "alarm",
    "growth",
    "saved",
    "flash",
    "front_end/mod",
    "calibration",
    "wiring",
    "recorder",
    "telemetry",
    "can",
    "about",
    "names",
];

const HEAD: &str = "\
/* The C interface of bearing-watch. Made by cbindgen from c-api/src: do not edit. README.md has an example.
 *
 * Every function may be called with any pointer that is NULL or fulfils its \"Safety\" section; it returns a code,
 * BW_CODE_OK or above if it did what it says, and below 0 if it did nothing; BwCode names three exceptions. */";

const MUST_CHECK: &str = "
/* Before a function whose result matters: compilers warn where it is not used. */
#if defined(__GNUC__) || defined(__clang__)
#define BW_MUST_CHECK __attribute__((warn_unused_result))
#else
#define BW_MUST_CHECK
#endif";

fn header(root: &Path) -> String {
    let config = Config {
        language: Language::C,
        cpp_compat: true,
        include_guard: Some("BEARING_WATCH_H".into()),
        header: Some(HEAD.into()),
        sys_includes: ["stdbool.h", "stddef.h", "stdint.h"].map(String::from).to_vec(),
        no_includes: true,
        usize_is_size_t: true,
        documentation_style: DocumentationStyle::C99,
        line_length: 120,
        // A code that is not looked at hides that nothing is watched.
        after_includes: Some(MUST_CHECK.into()),
        function: FunctionConfig { must_use: Some("BW_MUST_CHECK".into()), ..FunctionConfig::default() },
        // Functions of a library that was built with the feature.
        defines: [("feature = signature".into(), "BEARING_WATCH_SIGNATURE".into())].into(),
        // Functions take its values as numbers.
        export: ExportConfig { include: vec!["BwValues".into(), "BwPosition".into()], ..ExportConfig::default() },
        enumeration: EnumConfig { rename_variants: RenameRule::QualifiedScreamingSnakeCase, ..EnumConfig::default() },
        ..Config::default()
    };
    let mut builder = Builder::new().with_config(config);
    for name in SOURCES {
        builder = builder.with_src(root.join("src").join(name).with_extension("rs"));
    }
    let mut bytes = Vec::new();
    builder.generate().expect("the source parses").write(&mut bytes);
    // `int` has 32 bits too, but `%d` prints it everywhere: newlib's `int32_t` is `long`.
    String::from_utf8(bytes)
        .expect("text")
        .replace(": int32_t", ": int")
        .replace("typedef int32_t Bw", "typedef int Bw")
}

#[test]
fn the_header_is_that_of_the_source() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (path, made) = (root.join("include/bearing_watch.h"), header(root));
    if env::var_os(WRITE).is_some() {
        fs::write(&path, made).expect("writable");
        return;
    }
    let committed = fs::read_to_string(&path).expect("the header is there");
    let differ = made.lines().zip(committed.lines()).find(|(made, committed)| made != committed);
    let way_out = format!("{WRITE}=1 cargo test -p bearing-watch-c --test header");
    assert!(made == committed, "the header is old, first at {differ:?}; write it anew: {way_out}");
}
