//! Command-line tests of what all commands share: help, completions, `-q`, `-v`, drive.toml of the
//! folder, and JSON with errors and names of forms.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::common::{refuse, run, succeed};
use crate::form::{fit, schema};

/// The commands, with those below another one.
const COMMANDS: [&str; 25] = [
    "init",
    "audit",
    "simulate",
    "identify",
    "structure",
    "grey-box",
    "grey-box motor",
    "grey-box electrical",
    "grey-box linear",
    "grey-box cogging",
    "validate",
    "sign",
    "train",
    "features",
    "train-features",
    "evaluate",
    "replay",
    "confirm",
    "view",
    "listen",
    "demo-drive",
    "dbc",
    "convert",
    "schema",
    "completions",
];

const CHANNELS: &str = "--y current_a --u1 velocity_ref_rad_s --u2 load_torque_nm --order 2,1,2,1,1";

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn standard_error(folder: &Path, arguments: &str) -> String {
    String::from_utf8_lossy(&run(folder, arguments).stderr).into_owned()
}

/// A folder with recordings in `runs`.
fn recordings() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("folder");
    succeed(folder.path(), "simulate --class healthy,spall --count 12 --seed 5 --out runs");
    folder
}

#[test]
fn the_short_help_fits_a_screen() {
    let here = Path::new(".");
    let long = succeed(here, "train --help");
    for command in COMMANDS.into_iter().chain([""]) {
        let help = succeed(here, &format!("{command} -h"));
        assert!(help.lines().count() <= 40, "{command} -h has {} lines\n{help}", help.lines().count());
        let all = succeed(here, &format!("{command} --help"));
        assert!(all.lines().count() >= help.lines().count() && all.contains("--save"), "{command}\n{all}");
    }
    let short = succeed(here, "train -h");
    for heading in ["Recordings", "Channels", "Bearing", "Model", "Alarm", "Output"] {
        let heads = |help: &str| help.lines().any(|line| line.starts_with(heading) && line.ends_with(':'));
        assert!(heads(&short) && heads(&long), "{heading}\n{short}");
    }
    for (option, is_short) in [("--false-alarm", true), ("--bearing", true), ("--handover", false), ("--folds", false)]
    {
        assert_eq!((short.contains(option), long.contains(option)), (is_short, true), "{option}\n{short}");
    }
    assert!(long.contains("Validation ([validation] of drive.toml):"), "{long}");
}

/// The commands above are all commands.
#[test]
fn no_command_is_left_out() {
    let help = succeed(Path::new("."), "--help");
    let (_, list) = help.split_once("Commands:\n").expect("a list");
    let (list, _) = list.split_once("\n\n").expect("an end");
    for line in list.lines() {
        let name = line.split_whitespace().next().expect("a name");
        assert!(COMMANDS.contains(&name) || name == "help", "{name}");
    }
}

#[test]
fn completions_of_each_shell() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = succeed(dir, &format!("completions {shell}"));
        for word in ["train-features", "false-alarm"] {
            assert!(script.contains(word), "{shell}: no {word}");
        }
    }
    std::fs::write(dir.join("own.bash"), succeed(dir, "completions bash")).expect("writable");
    let words = "source own.bash; COMP_WORDS=(bearing-watch train --false-a); COMP_CWORD=2; \
                 _bearing__watch bearing-watch --false-a train; echo ${COMPREPLY[@]}";
    let shell = Command::new("bash").current_dir(dir).args(["-c", words]).output().expect("bash starts");
    assert_eq!(String::from_utf8_lossy(&shell.stdout).trim(), "--false-alarm");
}

#[test]
fn quiet_and_verbose() {
    let folder = recordings();
    let dir = folder.path();
    let identify = "identify runs/healthy_5_000.csv --y current_a --u1 velocity_ref_rad_s --u2 load_torque_nm \
                    --order 2,1,2,1,1 --offset";
    let usual = standard_error(dir, identify);
    assert!(usual.contains("warning: the residuals of 1 of 1 models are coloured"), "{usual}");
    assert_eq!(standard_error(dir, &format!("{identify} -q")), "");
    assert_eq!(standard_error(dir, &format!("--quiet {identify}")), "");
    let verbose = standard_error(dir, &format!("{identify} -v"));
    let read = "read runs/healthy_5_000.csv: traces 1, rows 5000, time by column t_s";
    assert!(verbose.contains(read) && verbose.contains("warning: "), "{verbose}");
    let train = format!("train --labels runs/labels.csv {CHANNELS} --model m.bwm");
    let said = standard_error(dir, &format!("{train} -v"));
    for words in [
        "read runs/spall_5_011.csv: traces 1",
        "training: 24 traces of the classes healthy, spall",
        "segments: 5000 samples, the longest training trace",
        "healthy class: healthy, by its name",
        "features: 5 of ",
    ] {
        assert!(said.contains(words), "{words} in\n{said}");
    }
    let said =
        standard_error(dir, &format!("{train} --verbose --segment 2500 --angle angle_rad --bearing 9,3,17,0.17"));
    for words in ["segments: 2500 samples, as given", "velocity: the differences of the angle", "lags: current "] {
        assert!(said.contains(words), "{words} in\n{said}");
    }
    refuse(dir, &format!("{train} -q -v"), &["--quiet", "--verbose"]);
    refuse(dir, "train -q --labels absent.csv --y a --u1 b --order 1,1,0,1,1 --model m.bwm", &["absent.csv"]);
}

#[test]
fn the_drive_file_of_the_folder_is_found() {
    let folder = recordings();
    let dir = folder.path();
    succeed(dir, "init runs --out drive.toml");
    let note = "drive file: drive.toml of this folder";
    let said = standard_error(dir, "train --model found.bwm");
    assert!(said.contains(note), "{said}");
    succeed(dir, "train drive.toml --model named.bwm");
    assert!(!standard_error(dir, "train drive.toml --model named.bwm").contains(note));
    let model = |name: &str| std::fs::read(dir.join(name)).expect("a model");
    assert_eq!(model("found.bwm"), model("named.bwm"));
    // Without it the settings are missing again.
    refuse(dir, "train --no-drive --model m.bwm", &["--labels"]);
    let options = format!("train --labels runs/labels.csv {CHANNELS} --model flags.bwm --no-drive");
    assert!(!standard_error(dir, &options).contains(note));
    assert!(!String::from_utf8_lossy(&model("flags.bwm")).contains("[channels]"), "no text of a drive file");
    assert!(succeed(dir, "evaluate -q --model found.bwm").contains("healthy"));
    assert_eq!(standard_error(dir, "identify -q"), "");
    // Commands that take no drive file do not look for it.
    for command in ["simulate --class healthy --count 1 --out other", "schema", "completions bash"] {
        assert_eq!(standard_error(dir, command), "", "{command}");
    }
    let written = standard_error(dir, "init runs --out second.toml");
    assert!(!written.contains(note), "{written}");
    std::fs::write(dir.join("drive.toml"), "[data]\nlabel = 3\n").expect("writable");
    refuse(dir, "train --model m.bwm", &["drive.toml, line 2", "--no-drive leaves it out"]);
    assert!(succeed(dir, "train -h").contains("Usage"));
}

#[test]
fn errors_are_json_too() {
    let folder = recordings();
    let dir = folder.path();
    let fails = |arguments: &str| {
        let output = run(dir, arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments}");
        let value = json(&String::from_utf8_lossy(&output.stdout));
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(value["format"], "bearing-watch/error");
        let message = value["error"]["message"].as_str().expect("a message").to_owned();
        assert!(error.contains(&message) && !message.contains('\n'), "{error}\n{message}");
        (value["error"]["kind"].as_str().expect("a kind").to_owned(), message)
    };
    let kind = |arguments: &str| fails(arguments).0;
    assert_eq!(kind("train --json"), "usage");
    assert_eq!(kind("trian --json"), "usage");
    assert_eq!(kind("replay --model absent.bwm runs/healthy_5_000.csv --json"), "file");
    std::fs::write(dir.join("words.csv"), "t_s,y,u\n0,1,2\n1,one,2\n").expect("writable");
    let (kind, message) = fails("identify words.csv --y y --u1 u --order 1,1,0,1,1 --json");
    assert_eq!(kind, "content");
    assert!(message.contains("words.csv, line 3, column y"), "{message}");
    assert_eq!(
        fails(&format!("train --labels runs/labels.csv {CHANNELS} --features d --model m.bwm --json")).0,
        "usage"
    );
    // Without --json there is nothing on standard output.
    refuse(dir, "replay --model absent.bwm runs/healthy_5_000.csv", &["absent.bwm"]);
}

#[test]
fn json_has_the_form_that_its_schema_describes() {
    let folder = recordings();
    let dir = folder.path();
    let train = format!("train --labels runs/labels.csv {CHANNELS} --model m.bwm --json");
    fit(&schema("train"), &json(&succeed(dir, &format!("{train} --rank"))));
    fit(&schema("train"), &json(&succeed(dir, &format!("{train} --method instruments --discriminant shrunk"))));
    let evaluate = "evaluate --model m.bwm --labels runs/labels.csv --json";
    fit(&schema("evaluate"), &json(&succeed(dir, evaluate)));
    fit(&schema("evaluate"), &json(&succeed(dir, &format!("{evaluate} --group seed"))));
    let replay = "replay --model m.bwm runs/spall_5_000.csv --json";
    fit(&schema("replay"), &json(&succeed(dir, replay)));
    fit(&schema("replay"), &json(&succeed(dir, &format!("{replay} --bearing 9,3,17,10"))));
    let output = run(dir, "replay --model absent.bwm runs --json");
    fit(&schema("error"), &json(&String::from_utf8_lossy(&output.stdout)));
    let fits = |form: &str, command: &str| fit(&schema(form), &json(&succeed(dir, &format!("{command} --json"))));
    let traces = "runs/healthy_5_000.csv runs/spall_5_000.csv";
    fits("identify", &format!("identify runs {CHANNELS}"));
    fits("identify", &format!("identify {traces} {CHANNELS} --method armax"));
    fits("validate", &format!("validate {traces} {CHANNELS}"));
    let signals = CHANNELS.split(" --order").next().expect("the signals");
    fits("structure", &format!("structure {traces} {signals} --max 2,2,2,1,1"));
    fits("structure", &format!("structure {traces} {signals} --max 2,2,2,1,1 --compare 2,1,1,1,1"));
    fits("audit", "audit runs");
    let motor = "--current current_a --velocity velocity_rad_s --load load_torque_nm";
    fits("grey-box", &format!("grey-box motor {traces} {motor}"));
    fits("cogging", "grey-box cogging runs");
    fits("features", &format!("features --labels runs/labels.csv {CHANNELS} --out f.parquet"));
    fits("train-features", "train-features f.parquet --features a --model f.bwm");
    let rows = json(&succeed(dir, &format!("identify runs {CHANNELS} --json")));
    assert_eq!((&rows[1]["format"], &rows[1]["version"]), (&"bearing-watch/identify".into(), &1.into()));
}
