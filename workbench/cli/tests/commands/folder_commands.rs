//! Command-line tests of folders in folders: every command finds the same files, with the same names.

use std::path::Path;

use crate::common::{run, succeed};

/// Simulates recordings of two classes, and moves each to the place that its class and number give.
fn arranged(dir: &Path, count: usize, place: impl Fn(&str, usize) -> String) {
    succeed(dir, &format!("simulate --class healthy,spall --count {count} --seed 6 --out made"));
    for class in ["healthy", "spall"] {
        for k in 0..count {
            let to = dir.join(place(class, k));
            std::fs::create_dir_all(to.parent().expect("a folder")).expect("made");
            std::fs::rename(dir.join(format!("made/{class}_6_{k:03}.csv")), to).expect("moved");
        }
    }
    std::fs::remove_dir_all(dir.join("made")).expect("removed");
}

fn read(dir: &Path, name: &str) -> String {
    std::fs::read_to_string(dir.join(name)).expect("written")
}

/// Standard output and error of a command that does its work, whatever it finds.
fn said(dir: &Path, arguments: &str) -> String {
    let output = run(dir, arguments);
    let all = String::from_utf8_lossy(&output.stderr).into_owned() + &String::from_utf8_lossy(&output.stdout);
    assert!(output.status.code().is_some_and(|code| code < 2), "{arguments}\n{all}");
    all
}

/// Writes what lies beside recordings.
fn litter(dir: &Path, folder: &str) {
    let good = "t_s,current_a\n0,1\n";
    for (name, text) in [
        (".trash/old.csv", good),
        ("results/m.bwm", "x"),
        ("results/table.csv", good),
        ("deep/er/labels.csv", "trace,class_name\nx,healthy\n"),
        ("parameters.csv", "parameter,value\nr_ohm,0.5\nl_h,0.001\n"),
    ] {
        let file = dir.join(folder).join(name);
        std::fs::create_dir_all(file.parent().expect("a folder")).expect("made");
        std::fs::write(file, text).expect("written");
    }
}

#[test]
fn every_command_finds_the_files_below_with_the_names_of_the_labels() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    // Equal names in different folders, and one file at the top.
    arranged(dir, 12, |class, k| match (class, k) {
        ("healthy", 0) => "bench/healthy_top.csv".into(),
        _ => format!("bench/{class}/run_{}/{k}/rec.csv", k / 3),
    });
    litter(dir, "bench");
    let told = said(dir, "init bench");
    assert!(told.contains("bench/drive.toml: 24 files") && told.contains("classes by the folders"), "{told}");
    for line in [
        "left out 1 file: bench/.trash: hidden",
        "left out 1 file: bench/results: a folder of results, for it has the model m.bwm",
        "left out 1 file: bench/deep/er/labels.csv: labels, no recording",
        "left out bench/parameters.csv: ",
    ] {
        assert!(told.contains(line), "{line} in {told}");
    }
    let labels = read(dir, "bench/labels.csv");
    assert!(labels.starts_with("trace,class_name,run,folder2\n"), "{labels}");
    for row in ["healthy_top,healthy,", "healthy/run_1/3/rec,healthy,run_1,3\n", "spall/run_1/3/rec,spall,run_1,3\n"] {
        assert!(labels.contains(&format!("\n{row}")), "{row} in {labels}");
    }
    assert!(read(dir, "bench/drive.toml").contains("\ntraces = [\".\"]\n"), "the folder is named as it was given");
    let audited = said(dir, "audit bench/drive.toml");
    assert!(audited.contains("24 traces") && !audited.contains("have no label"), "{audited}");
    assert!(succeed(dir, "train bench/drive.toml --model m.bwm").contains("12 healthy, 12 spall"));
    succeed(dir, "evaluate bench/drive.toml --model m.bwm");
    let replayed = succeed(dir, "replay --no-drive --model m.bwm bench/spall");
    assert!(replayed.contains("\n11/rec.csv  "), "{replayed}");
    succeed(dir, "convert bench --no-drive --columns current_a --out plain");
    assert!(dir.join("plain/spall/run_1/3/rec.csv").is_file() && dir.join("plain/healthy_top.csv").is_file());
    // A folder above finds them too, under names that tell them apart.
    let above = said(dir, "audit . --no-drive");
    assert!(above.contains("traces"), "{above}");
}

#[test]
fn labels_name_files_by_any_part_of_their_paths() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    arranged(dir, 6, |class, k| format!("data/class_{class}/run_{}/x{k}.csv", k / 2));
    let model = "--y current_a --u1 velocity_ref_rad_s-velocity_rad_s --order 2,2,0,1,1 --novelty none --model m.bwm";
    type Name = fn(&str, usize) -> String;
    let ways: [(&str, Name); 4] = [
        ("relative", |class, k| format!("class_{class}/run_{}/x{k}.csv", k / 2)),
        ("backslashes", |class, k| format!("class_{class}\\run_{}\\x{k}", k / 2)),
        ("beyond", |class, k| format!("../data/class_{class}/run_{}/x{k}.csv", k / 2)),
        ("of Parquet files once", |class, k| format!("./class_{class}/run_{}/x{k}.parquet", k / 2)),
    ];
    for (way, name) in ways {
        let row = |class: &str, k: usize| format!("{},{class},{}\n", name(class, k), k / 2);
        let rows: String = (0..6).flat_map(|k| [row("healthy", k), row("spall", k)]).collect();
        std::fs::write(dir.join("data/labels.csv"), format!("trace,class_name,run\n{rows}")).expect("written");
        let trained = said(dir, &format!("train --labels data/labels.csv {model}"));
        assert!(trained.contains("6 healthy, 6 spall") && !trained.contains("no label"), "{way}: {trained}");
        let evaluated = said(dir, "evaluate --labels data/labels.csv --model m.bwm --where class_name=spall");
        assert!(!evaluated.contains("no label"), "{way}: {evaluated}");
    }
    // The last part alone names two files.
    let rows = "x0,healthy\nx1,healthy\n";
    std::fs::write(dir.join("data/labels.csv"), format!("trace,class_name\n{rows}")).expect("written");
    let refused = run(dir, &format!("train --labels data/labels.csv {model}"));
    let error = String::from_utf8_lossy(&refused.stderr);
    assert!(
        !refused.status.success() && error.contains("comes twice, in ") && error.contains("the folders"),
        "{error}"
    );
}

#[test]
fn records_without_a_label_are_counted() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    arranged(dir, 10, |class, k| format!("data/{class}/{class} {k}.csv"));
    let row = |class: &str, k: usize| format!("{class} {k}.csv,{class}\n");
    let rows: String = (0..7).flat_map(|k| [row("healthy", k), row("spall", k)]).collect();
    // The names have blanks, and the labels another name than usual.
    std::fs::write(dir.join("data/classes.csv"), format!("trace,class_name\n{rows}")).expect("written");
    let model = "--y current_a --u1 velocity_ref_rad_s-velocity_rad_s --order 2,2,0,1,1 --novelty none --model m.bwm";
    let trained = said(dir, &format!("train --labels data/classes.csv {model}"));
    let line =
        "6 records have no label: healthy 7.csv, healthy 8.csv, healthy 9.csv, spall 7.csv, spall 8.csv and 1 more";
    assert!(trained.contains(line) && trained.contains("they are left out"), "{trained}");
    assert!(trained.contains("7 healthy, 7 spall") && !trained.contains("classes.csv: line"), "{trained}");
    let evaluated = said(dir, "evaluate --labels data/classes.csv --model m.bwm");
    assert!(evaluated.contains(line), "{evaluated}");
    // A record that a condition leaves out has a label.
    let some = said(dir, "evaluate --labels data/classes.csv --model m.bwm --where class_name=healthy");
    assert!(some.contains("6 records have no label"), "{some}");
    let audited = said(dir, "audit --labels data/classes.csv data");
    let bare = line.replace(".csv", "");
    assert!(audited.contains(&bare) && audited.contains("audited without a class"), "{audited}");
    let inits = said(dir, "init data --labels data/classes.csv");
    assert!(!inits.contains("cells where the header has"), "{inits}");
}

#[test]
fn names_are_equal_in_every_form_of_unicode() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    let (two, one) = ("pru\u{308}fstand", "pr\u{fc}fstand");
    arranged(dir, 6, |class, k| format!("data/{class}_{two}_{k}.csv"));
    for entry in std::fs::read_dir(dir.join("data")).expect("a folder") {
        let path = entry.expect("one").path();
        let text = std::fs::read_to_string(&path).expect("a trace").replacen("current_a", "strom_fu\u{308}hler_a", 1);
        std::fs::write(path, text).expect("written");
    }
    let row = |class: &str, k: usize| format!("{class}_{one}_{k}.csv,{class}\n");
    let rows: String = (0..6).flat_map(|k| [row("healthy", k), row("spall", k)]).collect();
    let labels = format!("trace,class_name\n{rows}").replace(",spall", ",sch\u{e4}den");
    std::fs::write(dir.join("data/labels.csv"), labels).expect("written");
    let model = "--u1 velocity_ref_rad_s-velocity_rad_s --order 2,2,0,1,1 --novelty none --model m.bwm";
    let asked = "--y strom_f\u{fc}hler_a --classes healthy,scha\u{308}den";
    let trained = said(dir, &format!("train --labels data/labels.csv {asked} {model}"));
    assert!(trained.contains("6 healthy, 6 sch\u{e4}den"), "{trained}");
    let evaluated = said(dir, "evaluate --labels data/labels.csv --model m.bwm --where class_name=scha\u{308}den");
    assert!(!evaluated.contains("no label"), "{evaluated}");
}
