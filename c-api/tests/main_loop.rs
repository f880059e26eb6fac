//! The main loop of the README in C, on the host: samples that were lost while the lower interrupt did not run are
//! counted, and then everything goes on; what ends the diagnosis is told in words; and a wrong wiring has no verdict.
#![allow(clippy::expect_used, clippy::panic, reason = "a test fails by a panic")]

use std::path::{Path, PathBuf};
use std::process::Command;

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

/// The static library of this source, which is beside the test: the last that was built, of any set of features.
fn library() -> PathBuf {
    let own = std::env::current_exe().expect("a test is a file");
    let files = own.parent().expect("target/PROFILE/deps").read_dir().expect("a folder").flatten();
    let built = files.filter(|file| {
        let name = file.file_name().to_string_lossy().into_owned();
        name.starts_with("libbearing_watch_c-") && name.ends_with(".a")
    });
    built.max_by_key(|file| file.metadata().and_then(|data| data.modified()).ok()).expect("a library").path()
}

/// Builds the program with the header of a model, and returns what it prints; `None` without a compiler.
fn prints(model: &str, word: &str) -> Option<String> {
    prints_of("main", model, word)
}

/// The same of another program.
fn prints_of(name: &str, model: &str, word: &str) -> Option<String> {
    let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}_{model}_{word}"));
    let mut compiler = Command::new("cc");
    compiler.args(["-std=c99", "-Wall", "-Wextra", "-Werror", "-D_DEFAULT_SOURCE", "-o"]).arg(&program);
    compiler.arg(format!("-I{ROOT}/c-api/include")).arg(format!("-I{ROOT}/examples/support/{model}"));
    compiler.arg(format!("{ROOT}/c-api/tests/main_loop/{name}.c")).arg(library()).args(["-lm", "-lpthread", "-ldl"]);
    let Ok(built) = compiler.output() else {
        println!("skipped: no C compiler");
        return None;
    };
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    let run = Command::new(&program).arg(word).output().expect("it runs");
    assert!(run.status.success(), "{run:?}");
    Some(String::from_utf8_lossy(&run.stdout).into_owned())
}

#[test]
fn a_queue_that_was_full_is_collected_again() {
    // Twelve clean samples come while nothing is collected: four wait, and one before them. A front end makes room with
    // its next reading; signals of the drive's own come with the next sample, before which one more is lost.
    for (model, reports, lost) in [("actuator", 6, 7), ("standard_rig", 3, 8)] {
        let Some(out) = prints(model, "blocked") else { return };
        assert!(out.contains(&format!("{reports} reports, {lost} lost, ")), "{model}: {out}");
    }
}

#[test]
fn a_unit_that_flushes_to_zero_is_told_in_words() {
    if !cfg!(target_arch = "x86_64") {
        return;
    }
    let Some(out) = prints("actuator", "flushed") else { return };
    assert!(out.starts_with("the chip computes otherwise than the host of the training\n0 reports, "), "{out}");
}

#[test]
fn no_verdict_comes_of_exchanged_phases() {
    let Some(right) = prints("actuator", "right") else { return };
    // BW_ALIGNMENT_ALIGNED, and a reason of the signals at most: they are not those of the model.
    assert!(right.starts_with("6 reports, 0 lost, alignment 1, ") && !right.contains("reason 12 16"), "{right}");
    let exchanged = prints("actuator", "exchanged").expect("a compiler");
    assert_eq!(exchanged, "6 reports, 0 lost, alignment 2, reason 12 16\n", "BW_REASON_IMPLAUSIBLE, wiring");
}

/// Each motor prints what it prints alone.
#[test]
fn two_motors_with_two_models_run_in_one_program() {
    let Some(both) = prints_of("two_motors", "actuator", "both") else { return };
    for (motor, reports) in [("first", 10), ("second", 2)] {
        let alone = prints_of("two_motors", "actuator", motor).expect("a compiler");
        let beside: String = both.split_inclusive('\n').filter(|line| line.starts_with(motor)).collect();
        assert!(alone == beside && alone.lines().count() == reports, "{motor}: {alone}{both}");
    }
}
