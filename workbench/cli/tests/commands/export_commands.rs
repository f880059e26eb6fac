//! Command-line tests: exported models compile, whatever channels and classes are called.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use model::core::identifiers::identifiers;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::common::succeed;

/// Names of channels: words of the languages, names that an exported model uses itself, and no identifiers at all.
const WORDS: &str = "_ abstract as async await become box break const continue crate do dyn else enum extern false final \
                     fn for gen if impl in let loop macro match mod move mut override priv pub ref return self Self \
                     static struct super trait true try type typeof unsafe unsized use virtual where while yield union \
                     raw safe auto macro_rules usize f32 Some None Ok Err Option Result Box Vec String Default Debug \
                     CHANNELS LAYOUT MODEL FRONT_END FURTHER Drive Sample Place Layout Channel angle \
                     clean channel values position y u1 u2 x core std bearing_watch é ü ß 速度 __ ___ 1 2nd a.b a,b \
                     alignas alignof and asm bitand bool case catch char class compl concept const_cast constexpr \
                     decltype default delete double explicit export float friend goto inline int long mutable \
                     namespace new noexcept not nullptr operator or private protected public register requires \
                     restrict short signed sizeof static_assert switch template this throw typedef typeid typename \
                     unsigned using void volatile wchar_t xor names units limits NAMES main NULL linux";

/// Names of columns with which a model is trained as a user would.
const TRAINED: [[&str; 3]; 4] = [
    ["type", "Self", "_"],
    ["é", "ß", "gen"],
    ["velocity_of_the_output_shaft_behind_the_gear_a", "velocity_of_the_output_shaft_behind_the_gear_b", "names"],
    ["int", "a b", "a.b"],
];

/// Writes four traces of each of two classes with these columns.
fn record(folder: &Path, names: [&str; 3], classes: [&str; 2]) {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let mut labels = String::from("trace,class_name\n");
    for k in 0..8 {
        let mut rows = names.join(",") + "\n";
        let mut y = [0.0_f64; 2];
        let pole = if k % 2 == 0 { 1.2 } else { 1.4 };
        for _ in 0..400 {
            let [u, v, noise] = [0; 3].map(|_| random.random_range(-1.0..1.0));
            y = [pole * y[0] - 0.5 * y[1] + u + 0.5 * v + 0.05 * noise, y[0]];
            let _ = writeln!(rows, "{},{u},{v}", y[0]);
        }
        std::fs::write(folder.join(format!("t{k}.csv")), rows).expect("writable");
        let _ = writeln!(labels, "t{k},\"{}\"", classes[k % 2].replace('"', "\"\""));
    }
    std::fs::write(folder.join("labels.csv"), labels).expect("writable");
}

/// Trains a model, and returns its source and its header.
fn exported(names: [&str; 3], classes: [&str; 2]) -> [String; 2] {
    let folder = tempfile::tempdir().expect("a folder");
    let dir = folder.path();
    record(dir, names, classes);
    let [y, u1, u2] = names;
    let mut command = Command::new(env!("CARGO_BIN_EXE_bearing-watch"));
    command.current_dir(dir).args(["train", "--labels", "labels.csv", "--y", y, "--u1", u1, "--u2", u2]);
    command.args("--order 2,1,1,1,1 --features a,b --model m.bwm --rust m.rs --c m.h".split(' '));
    let Output { status, stderr, .. } = command.arg(".").output().expect("the command starts");
    assert!(status.success(), "{names:?} {}", String::from_utf8_lossy(&stderr));
    ["m.rs", "m.h"].map(|name| std::fs::read_to_string(dir.join(name)).expect("written"))
}

/// Compiles a crate of these sources with a compiled core, one of which `probe` fits.
fn compile(folder: &Path, cores: &[PathBuf], source: &str) -> Result<(), String> {
    let file = folder.join("exported.rs");
    std::fs::write(&file, format!("#![allow(dead_code, unused)]\n{source}")).expect("writable");
    let mut problem = "no compiled core".into();
    for core in cores {
        let mut rustc = Command::new("rustc");
        rustc.args(["--edition", "2024", "--crate-type", "lib", "--emit", "metadata", "--out-dir"]).arg(folder);
        rustc.arg("-L").arg(format!("dependency={}", core.parent().expect("a folder").display()));
        rustc.arg("--extern").arg(format!("bearing_watch={}", core.display())).arg(&file);
        let output = rustc.output().map_err(|error| error.to_string())?;
        if output.status.success() {
            return Ok(());
        }
        problem = String::from_utf8_lossy(&output.stderr).into_owned();
    }
    Err(problem)
}

/// The compiled cores beside this test, the newest first.
fn cores() -> Vec<PathBuf> {
    let own = std::env::current_exe().expect("this test");
    let entries = std::fs::read_dir(own.parent().expect("its folder")).expect("readable");
    let is_core = |path: &PathBuf| {
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        name.starts_with("libbearing_watch-") && name.ends_with(".rlib")
    };
    let mut cores: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).filter(is_core).collect();
    cores.sort_by_key(|path| std::cmp::Reverse(path.metadata().and_then(|about| about.modified()).ok()));
    cores
}

/// The text with this word in place of another one.
fn renamed(text: &str, from: &str, to: &str) -> String {
    let (mut out, mut rest) = (String::new(), text);
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    while let Some(at) = rest.find(from) {
        let (before, behind) = (&rest[..at], &rest[at + from.len()..]);
        let whole = !before.ends_with(is_part) && !behind.starts_with(is_part);
        out.push_str(before);
        out.push_str(if whole { to } else { from });
        rest = behind;
    }
    out + rest
}

#[test]
fn models_compile_whatever_their_channels_are_called() {
    let folder = tempfile::tempdir().expect("a folder");
    let usual = ["current_q", "velocity_q", "torque_q"];
    let [plain, _] = exported(usual, ["healthy", "spall"]);
    let cores = cores();
    let Some(core) = cores.into_iter().find(|core| compile(folder.path(), std::slice::from_ref(core), &plain).is_ok())
    else {
        println!("skipped: rustc or a compiled core is missing");
        return;
    };
    let mut all = String::new();
    let mut add = |source: &str| {
        let number = all.len();
        let _ = writeln!(all, "pub mod m{number} {{\n{source}\n}}");
    };
    for names in TRAINED {
        add(&exported(names, ["healthy", "\u{202e}\"\\"])[0]);
    }
    let words: Vec<&str> = WORDS.split_ascii_whitespace().collect();
    for words in words.chunks(3) {
        let named = usual.iter().zip(identifiers(words.iter().copied()));
        add(&named.fold(plain.clone(), |text, (from, to)| renamed(&text, from, &to)));
    }
    compile(folder.path(), &[core], &all).unwrap_or_else(|problem| panic!("{problem}"));
}

#[test]
fn headers_compile_whatever_their_channels_and_classes_are_called() {
    let folder = tempfile::tempdir().expect("a folder");
    let classes = [["names", "größe 1"], ["a b", "a-b"], ["int", "INT"], ["*/ ??/", "\"\\"]];
    for (names, classes) in TRAINED.into_iter().zip(classes) {
        let [_, header] = exported(names, classes);
        for (compiler, ending) in [("cc", "c"), ("c++", "cpp")] {
            let file = folder.path().join(format!("m.{ending}"));
            // Each name of an enumeration is a number of its own, and no macro.
            let wanted = |prefix: &str| {
                let line = header.lines().find(|line| line.starts_with(&format!("enum {{ {prefix}"))).expect(prefix);
                line.split(['{', ',', '}']).filter(|part| part.contains('=')).fold(String::new(), |out, part| {
                    let (name, value) = part.split_once('=').expect("a value");
                    out + &format!("typedef char t_{}[{} == {value} ? 1 : -1];\n", name.trim(), name.trim())
                })
            };
            let checks = wanted("BW_MODEL_CHANNEL_") + &wanted("BW_MODEL_CLASS_");
            let names = "const char *n[] = BW_MODEL_CHANNEL_NAMES; const char *c[] = BW_MODEL_CLASS_NAMES;";
            std::fs::write(&file, format!("{header}\n{checks}\n{names}\n")).expect("writable");
            let mut command = Command::new(compiler);
            // The header of the library, which that of a model includes.
            command.args(["-I", concat!(env!("CARGO_MANIFEST_DIR"), "/../../c-api/include")]);
            command.args(["-fsyntax-only", "-Wall", "-Wextra", "-Werror", "-Wno-unused"]).arg(&file);
            let Ok(output) = command.output() else {
                println!("skipped: {compiler} is not installed");
                continue;
            };
            assert!(output.status.success(), "{names} {classes:?}\n{}", String::from_utf8_lossy(&output.stderr));
        }
    }
}

/// The names in a model are those of its source, so that the firmware accepts its binary form too.
#[test]
fn names_of_a_model_are_told() {
    let folder = tempfile::tempdir().expect("a folder");
    record(folder.path(), ["type", "é", "u"], ["healthy", "spall"]);
    let options = "--y type --u1 é --u2 u --order 2,1,1,1,1 --features a,b --model m.bwm";
    succeed(folder.path(), &format!("train --labels labels.csv {options} ."));
    let text = succeed(folder.path(), "evaluate --model m.bwm --labels labels.csv .");
    assert!(text.contains("healthy"), "{text}");
}
