//! Command-line tests of `bearing-watch simulate`: classes, severities, conditions and waveforms.

use std::path::Path;

use crate::common::{refuse, run, succeed};

/// The first six columns of a trace: time, reference, velocity, current, load, angle.
fn trace(path: &Path) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let mut columns = vec![Vec::new(); 6];
    for line in text.lines().skip(1) {
        for (column, cell) in columns.iter_mut().zip(line.split(',')) {
            column.push(cell.parse().expect("number"));
        }
    }
    columns
}

fn labels(folder: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(folder.join("labels.csv")).expect("labels");
    text.lines().map(String::from).collect()
}

fn rms(x: &[f64]) -> f64 {
    (x.iter().map(|v| v * v).sum::<f64>() / x.len() as f64).sqrt()
}

#[test]
fn every_class_has_its_traces_and_labels() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    let classes = "healthy,spall,roughness,coulomb,spall-and-roughness,weak-magnet";
    let said = succeed(dir, &format!("simulate --class {classes} --count 2 --seed 3 --out t"));
    assert!(said.starts_with("12 traces"), "{said}");
    let labels = labels(&dir.join("t"));
    assert_eq!(labels[0], "trace,class_name,severity,seed,condition,waveform");
    assert_eq!(labels[1], "healthy_3_000.csv,healthy,0,3,standard,sine");
    assert_eq!(labels[10], "spall-and-roughness_3_001.csv,spall-and-roughness,1,3,standard,sine");
    assert_eq!(labels[12], "weak-magnet_3_001.csv,weak-magnet,1,3,standard,sine");
    // Each class has its own seed, so the first load value of each class is different.
    let firsts: Vec<f64> = labels[1..]
        .iter()
        .map(|line| trace(&dir.join("t").join(line.split(',').next().expect("name")))[4][0])
        .collect();
    assert!(firsts.iter().enumerate().all(|(k, load)| !firsts[..k].contains(load)), "{firsts:?}");
}

#[test]
fn conditions_severities_and_waveforms_live_in_one_folder() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    for options in [
        "--class healthy",
        "--class spall --severity 0.125",
        "--class spall --condition amplitude-2",
        "--class healthy --condition square",
        "--class healthy --mix --waveform triangle",
        "--class healthy --condition noise-10-db",
        "--class healthy --waveform sine",
    ] {
        succeed(dir, &format!("simulate {options} --count 1 --seed 9 --out t"));
    }
    let labels = labels(&dir.join("t"));
    let expected = [
        "trace,class_name,severity,seed,condition,waveform",
        "spall_0.125_9_000.csv,spall,0.125,9,standard,sine",
        "spall_amplitude-2_9_000.csv,spall,1,9,amplitude-2,sine",
        "healthy_square_9_000.csv,healthy,0,9,square,square",
        "healthy_mix_triangle_9_000.csv,healthy,0,9,mix,triangle",
        "healthy_noise-10-db_9_000.csv,healthy,0,9,noise-10-db,sine",
        // The last run repeats the first one, and replaces its entry.
        "healthy_9_000.csv,healthy,0,9,standard,sine",
    ];
    assert_eq!(labels, expected);

    let read = |name: &str| trace(&dir.join("t").join(name));
    let standard = read("healthy_9_000.csv");
    // Five hundred samples are a fifth of a period at 0.2 Hz; files contain nine digits.
    assert!((standard[1][500] - 40.0 * (std::f64::consts::TAU * 0.2).sin()).abs() < 1e-6);
    let square = read("healthy_square_9_000.csv");
    assert!((0..5000).all(|k| square[1][k] == if (k / 1250) % 2 == 0 { 40.0 } else { -40.0 }));
    assert_eq!(square[4], standard[4], "the same seed has the same load");
    let double = read("spall_amplitude-2_9_000.csv");
    assert!((double[1][500] - 2.0 * standard[1][500]).abs() < 1e-6);
    // The corners of a triangle are the only bends in its reference; their position depends on the drawn frequency.
    let triangle = &read("healthy_mix_triangle_9_000.csv")[1];
    let bends = triangle.windows(3).filter(|w| (w[0] - 2.0 * w[1] + w[2]).abs() > 1e-6).count();
    assert!((2..=16).contains(&bends), "{bends}");
    // The control error of the standard trace is 4 rad/s rms; 8.58 rad/s of noise (10 dB below 27.14) increase it to
    // √(4² + 8.58²) = 9.5, and slightly more because the loop follows the noise.
    let error = |t: &[Vec<f64>]| rms(&t[1].iter().zip(&t[2]).map(|(r, w)| r - w).collect::<Vec<_>>());
    let (noisy, quiet) = (error(&read("healthy_noise-10-db_9_000.csv")), error(&standard));
    assert!((9.0..10.8).contains(&noisy) && (3.5..4.7).contains(&quiet), "{noisy} {quiet}");
}

#[test]
fn conditions_of_the_field_have_their_columns_and_labels() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    for condition in ["standard", "no-load-sensor", "missing-periodic", "duty-trapezoids", "field-any"] {
        succeed(dir, &format!("simulate --class healthy --condition {condition} --count 1 --seed 4 --out t"));
    }
    let text = |condition: &str| {
        let name =
            if condition == "standard" { "healthy_4_000.csv".into() } else { format!("healthy_{condition}_4_000.csv") };
        std::fs::read_to_string(dir.join("t").join(name)).expect("trace")
    };
    let header = "t_s,velocity_ref_rad_s,velocity_rad_s,current_a,load_torque_nm,angle_rad,voltage_v";
    for condition in ["standard", "missing-periodic", "duty-trapezoids"] {
        assert_eq!(text(condition).lines().next(), Some(header));
    }
    // A record whose grease and winding warm has their temperature too.
    let warm = format!("{header},temperature_c");
    assert_eq!(text("field-any").lines().next(), Some(warm.as_str()));
    let unloaded = text("no-load-sensor");
    assert_eq!(unloaded.lines().next().map(|line| line.contains("load")), Some(false));
    assert!(unloaded.lines().all(|line| line.split(',').count() == 6));
    let gaps = text("missing-periodic");
    let lost: Vec<&str> = gaps.lines().filter(|line| line.contains("NaN")).collect();
    assert_eq!(lost.len(), 50);
    assert!(lost.iter().all(|line| line.ends_with(",NaN,NaN,NaN,NaN,NaN,NaN") && !line.starts_with("NaN")));
    let labels = labels(&dir.join("t"));
    assert_eq!(labels[4], "healthy_duty-trapezoids_4_000.csv,healthy,0,4,duty-trapezoids,trapezoids");
    let drawn = labels[5].split(',').next_back().expect("waveform");
    assert!(
        ["sine", "random-steps", "trapezoids", "set-points", "one-way", "constant-speed"].contains(&drawn),
        "{drawn}"
    );
}

#[test]
fn parts_of_an_axis_combine_and_say_what_the_axis_was() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    for options in [
        "--condition gravity,gear,brake,cycle --ratio 100 --weight 0.2",
        "--condition bad-load-sensor,belt,any-cycle",
        "--rig ema --condition gravity,belt,cycle",
    ] {
        succeed(dir, &format!("simulate --class healthy --count 1 --seed 4 {options} --out t"));
    }
    let lines = |name: &str| {
        let text = std::fs::read_to_string(dir.join("t").join(name)).expect("trace");
        let head: Vec<String> = text.lines().next().expect("head").split(',').map(String::from).collect();
        let rows: Vec<Vec<f64>> = text
            .lines()
            .skip(1)
            .map(|line| line.split(',').map(|cell| cell.parse().expect("number")).collect())
            .collect();
        (head, rows)
    };
    let (head, rows) = lines("healthy_gravity+gear+brake+cycle_4_000.csv");
    let motor = "t_s,velocity_ref_rad_s,velocity_rad_s,current_a,angle_rad,voltage_v";
    assert_eq!(head.join(","), format!("{motor},ratio,axis_rad,weight_nm,payload,brake_closed"));
    let column = |name: &str| head.iter().position(|own| own == name).expect("column");
    let [ratio, axis, weight, payload] = ["ratio", "axis_rad", "weight_nm", "payload"].map(column);
    for row in &rows {
        assert_eq!(row[ratio], 100.0);
        // Nine digits in files.
        let expected = 0.2 * (row[payload] - 0.3) * row[axis].sin();
        assert!((row[weight] - expected).abs() < 1e-8 && (0.7..1.3).contains(&row[payload]), "{row:?}");
    }
    // A sensor with errors stays, and this axis has no weight.
    let (head, rows) = lines("healthy_bad-load-sensor+belt+any-cycle_4_000.csv");
    assert!(head.contains(&"load_torque_nm".into()));
    assert!(rows.iter().all(|row| row[head.len() - 3] == 0.0), "weight");
    let (head, _) = lines("ema_healthy_gravity+belt+cycle_4_000.csv");
    assert!(head.iter().all(|name| !name.starts_with("load_") && name != "axis_rad"), "{head:?}");
    assert!(head.ends_with(&["ratio", "weight_nm", "payload", "brake_closed"].map(String::from)), "{head:?}");
    let labels = labels(&dir.join("t"));
    assert_eq!(labels[1], "healthy_gravity+gear+brake+cycle_4_000.csv,healthy,0,4,gravity+gear+brake+cycle,cycle");
    assert_eq!(labels[3], "ema_healthy_gravity+belt+cycle_4_000.csv,healthy,0,4,gravity+belt+cycle,cycle");
}

#[test]
fn help_has_examples_and_every_name() {
    let folder = tempfile::tempdir().expect("folder");
    let help = succeed(folder.path(), "simulate --help");
    for words in [
        "Examples:",
        "temperature",
        "field-any",
        "spall-and-roughness",
        "weak-magnet",
        "frequency-0.5",
        "noise-20-db",
        "triangle",
        "payload-steps",
        "--ratio",
    ] {
        assert!(help.contains(words), "{words}\n{help}");
    }
}

#[test]
fn what_cannot_be_simulated_is_one_line() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    for (options, words) in [
        ("--class rust --out s", ["'rust'", "weak-magnet"]),
        ("--class healthy --condition warm --out s", ["'warm'", "resistance-1.1"]),
        ("--class healthy --waveform saw --out s", ["'saw'", "triangle"]),
        ("--class healthy --condition square --waveform sine --out s", ["--condition square", "--waveform"]),
        ("--class healthy --condition duty-any --waveform sine --out s", ["--condition duty-any", "--waveform"]),
        ("--class healthy --condition square --mix --out s", ["--mix", "cannot be used"]),
        ("--class weak-magnet --severity 20 --out s", ["kt_nm_per_a", "positive"]),
        ("--class healthy --condition mix,temperature --out s", ["only the parts of an axis combine", "leave out one"]),
        ("--class healthy --condition gear,gear --out s", ["names gear twice", "--condition"]),
        ("--class healthy --condition cycle,any-cycle --out s", ["one motion", "leave out one"]),
        ("--class healthy --condition duty-steps,cycle --out s", ["--condition duty-steps", "leave out the cycle"]),
        ("--class healthy --condition cycle --waveform sine --out s", ["--condition cycle", "--waveform"]),
        ("--class healthy --condition axis-0.4,gear --out s", ["axis-0.4 is an axis already", "leave out"]),
        ("--class healthy --condition gear --ratio 200 --out s", ["axis.ratio", "between 1 and 160"]),
        ("--class healthy --condition mix --ratio 5 --out s", ["--ratio", "for example gear"]),
        ("--class healthy --condition gear --weight 1 --out s", ["--weight", "add gravity"]),
        ("--class healthy --condition gravity --weight -1 --out s", ["axis.gravity.weight_nm", "negative"]),
        ("--class healthy --count 0 --out s", ["--count 0", "at least 1"]),
    ] {
        refuse(dir, &format!("simulate {options}"), &words);
    }
    std::fs::create_dir(dir.join("old")).expect("folder");
    std::fs::write(dir.join("old/labels.csv"), "trace,class_name,severity,seed\n").expect("file");
    let old = run(dir, "simulate --class healthy --count 1 --out old");
    assert_eq!(old.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&old.stderr).contains("choose another --out"));
}
