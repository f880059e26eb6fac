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

/// A header, and the files with its public items in its order; one with modules stands for theirs, too.
struct Header {
    name: &'static str,
    guard: &'static str,
    head: &'static str,
    sources: &'static [&'static str],
}

/// That which a drive includes, and that of its service.
const HEADERS: [Header; 2] = [
    Header {
        name: "bearing_watch.h",
        guard: "BEARING_WATCH_H",
        head: HEAD,
        sources: &[
            "code",
            "memory",
            "state",
            "sampling",
            "main_loop",
            "report",
            "alarm",
            "saved",
            "front_end/mod",
            "front_end/constants",
            "front_end/faults",
            "front_end/sample",
            "angle",
            "names",
        ],
    },
    Header {
        name: "bearing_watch_service.h",
        guard: "BEARING_WATCH_SERVICE_H",
        head: SERVICE,
        sources: &[
            "plan",
            "values",
            "about",
            "growth",
            "calibration",
            "wiring",
            "recorder",
            "telemetry",
            "can",
            "flash",
            "signature",
        ],
    },
];

const HEAD: &str = "\
/* The C interface of bearing-watch. Made by cbindgen from c-api/src: do not edit. README.md has an example.
 *
 * Every function may be called with any pointer that is NULL or fulfils its \"Safety\" section; it returns a code,
 * BW_CODE_OK or above if it did what it says, and below 0 if it did nothing; BwCode names three exceptions. */";

const SERVICE: &str = "\
/* The C interface of bearing-watch, second part: numbers behind a report, growth of a defect, commissioning, telemetry,
 * flash, signed models. Made by cbindgen from c-api/src: do not edit. */";

const MUST_CHECK: &str = "
/* Before a function whose result matters: compilers warn where it is not used. */
#if defined(__GNUC__) || defined(__clang__)
#define BW_MUST_CHECK __attribute__((warn_unused_result))
#else
#define BW_MUST_CHECK
#endif

/* What a library for one plan needs is in bearing_watch_plan.h, which export.sh writes beside it. */
#if defined(__has_include)
#if __has_include(\"bearing_watch_plan.h\")
#include \"bearing_watch_plan.h\"
#endif
#endif
#ifndef BW_PLAN_STATE_SIZE
#define BW_PLAN_STATE_SIZE BW_STATE_SIZE
#define BW_PLAN_FRONT_END_SIZE BW_FRONT_END_SIZE
#endif";

/// The public names of a file.
fn names(root: &Path, source: &str) -> Vec<String> {
    let text = fs::read_to_string(root.join("src").join(source).with_extension("rs")).expect("a source");
    let own = |line: &str| {
        let item = line.strip_prefix("pub ")?;
        let starts = ["struct ", "enum ", "const ", "type ", "unsafe extern \"C\" fn ", "extern \"C\" fn "];
        let rest = starts.iter().find_map(|start| item.strip_prefix(start))?;
        rest.split(|c: char| !c.is_alphanumeric() && c != '_').next().map(String::from)
    };
    text.lines().filter_map(own).collect()
}

fn made(root: &Path, header: &Header) -> String {
    let others = HEADERS.iter().filter(|other| other.name != header.name).flat_map(|other| other.sources);
    let is_first = header.name == HEADERS[0].name;
    let config = Config {
        language: Language::C,
        cpp_compat: true,
        include_guard: Some(header.guard.into()),
        header: Some(header.head.into()),
        sys_includes: if is_first { ["stdbool.h", "stddef.h", "stdint.h"].map(String::from).to_vec() } else { vec![] },
        includes: if is_first { vec![] } else { vec![HEADERS[0].name.into()] },
        no_includes: true,
        usize_is_size_t: true,
        documentation_style: DocumentationStyle::C99,
        line_length: 120,
        // A code that is not looked at hides that nothing is watched.
        after_includes: is_first.then(|| MUST_CHECK.into()),
        function: FunctionConfig { must_use: Some("BW_MUST_CHECK".into()), ..FunctionConfig::default() },
        // Functions of a library that was built with the feature.
        defines: [("feature = signature".into(), "BEARING_WATCH_SIGNATURE".into())].into(),
        export: ExportConfig {
            // Functions take their values as numbers.
            include: if is_first { vec!["BwPark".into(), "BwPosition".into()] } else { vec!["BwValues".into()] },
            exclude: others.flat_map(|source| names(root, source)).chain(["RATE_HZ".into()]).collect(),
            ..ExportConfig::default()
        },
        enumeration: EnumConfig { rename_variants: RenameRule::QualifiedScreamingSnakeCase, ..EnumConfig::default() },
        ..Config::default()
    };
    let mut builder = Builder::new().with_config(config);
    let others = HEADERS.iter().filter(|other| other.name != header.name).flat_map(|other| other.sources);
    for source in header.sources.iter().chain(others) {
        builder = builder.with_src(root.join("src").join(source).with_extension("rs"));
    }
    let mut bytes = Vec::new();
    builder.generate().expect("the source parses").write(&mut bytes);
    compact(&String::from_utf8(bytes).expect("text"))
}

/// A comment of one line stands behind its field or value, if there is room. An enumeration is one of C and of C++
/// alike, and its type is `int`: that has 32 bits too, but `%d` prints it everywhere, and newlib's `int32_t` is
/// `long`.
fn compact(text: &str) -> String {
    let mut lines: Vec<String> = Vec::new();
    // The end of what is left out, whether an enumeration is open, and comments in a row.
    let (mut left_out, mut in_enum, mut comments) = (None, false, 0);
    for line in text.lines() {
        if let Some(end) = left_out {
            left_out = (line != end).then_some(end);
            continue;
        }
        if let Some(name) = line.strip_prefix("enum ") {
            lines.extend([format!("typedef int {name};"), "enum {".into()]);
            (left_out, in_enum) = (Some(" {"), true);
            continue;
        }
        if line == "};" && core::mem::take(&mut in_enum) {
            left_out = Some("#endif // __cplusplus");
        }
        let within = line.starts_with("  ");
        let item = within && comments == 1 && line.ends_with([',', ';']);
        match lines.last().filter(|_| item).map(|comment| format!("{line} {}", comment.trim())) {
            Some(joined) if joined.chars().count() <= 120 => {
                lines.pop();
                lines.push(joined);
            }
            _ => lines.push(line.into()),
        }
        comments = if within && line.trim_start().starts_with("//") { comments + 1 } else { 0 };
    }
    lines.join("\n") + "\n"
}

#[test]
fn the_headers_are_those_of_the_source() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for header in &HEADERS {
        let (path, made) = (root.join("include").join(header.name), made(root, header));
        if env::var_os(WRITE).is_some() {
            fs::write(&path, made).expect("writable");
            continue;
        }
        let committed = fs::read_to_string(&path).expect("the header is there");
        let differ = made.lines().zip(committed.lines()).find(|(made, committed)| made != committed);
        let way_out = format!("{WRITE}=1 cargo test -p bearing-watch-c --test header");
        assert!(made == committed, "{} is old, first at {differ:?}; write it anew: {way_out}", header.name);
    }
}
