//! Command-line tests of units that the names of the columns do not tell.

use std::f64::consts::TAU;
use std::path::Path;

use crate::common::{refuse, run, succeed};

/// Columns of angle and velocity in some unit, and what `init` makes of them.
struct Drive {
    /// Names of the angle and the velocity.
    names: [&'static str; 2],
    /// Of rad and rad/s.
    factors: [f64; 2],
    /// Whether the angle is whole numbers.
    whole: bool,
    /// Where the angle begins anew.
    turn: Option<f64>,
    /// The channels that `init` writes, and those of the answers.
    written: [&'static str; 2],
    answers: [&'static str; 2],
}

const RPM: f64 = 60.0 / TAU;

const DRIVES: [Drive; 6] = [
    Drive {
        names: ["position", "velocity"],
        factors: [1.0 / TAU, 1.0 / TAU],
        whole: false,
        turn: None,
        written: ["position[?]", "velocity[?]"],
        answers: ["position[turn]", "velocity[turn/s]"],
    },
    Drive {
        names: ["theta", "Drehzahl in 1/min"],
        factors: [360.0 / TAU, RPM],
        whole: false,
        turn: Some(360.0),
        written: ["theta[deg]", "Drehzahl in 1/min"],
        answers: ["theta[deg]", "Drehzahl in 1/min"],
    },
    Drive {
        names: ["encoder", "speed"],
        factors: [65_536.0 / TAU, RPM],
        whole: true,
        turn: Some(65_536.0),
        written: ["encoder[turn/65536]", "speed[rpm]"],
        answers: ["encoder[turn/65536]", "speed[rpm]"],
    },
    Drive {
        names: ["theta_e", "omega_e"],
        factors: [7.0, 7.0],
        whole: false,
        turn: Some(TAU),
        written: ["(unwrap(theta_e[rad]) rad)/?", "(omega_e[rad/s] rad/s)/?"],
        answers: ["(unwrap(theta_e[rad]) rad)/7", "(omega_e[rad/s] rad/s)/7"],
    },
    Drive {
        names: ["phi_elec", "velocity_rad_s"],
        factors: [4.0, 1.0],
        whole: false,
        turn: Some(TAU),
        written: ["(unwrap(phi_elec[rad]) rad)/4", "velocity_rad_s"],
        answers: ["(unwrap(phi_elec[rad]) rad)/4", "velocity_rad_s"],
    },
    Drive {
        names: ["pos", "erpm"],
        factors: [1.0 / TAU, 5.0 * RPM],
        whole: false,
        turn: Some(1.0),
        written: ["pos[turn]", "(erpm[rpm] rad/s)/5"],
        answers: ["pos[turn]", "(erpm[rpm] rad/s)/5"],
    },
];

/// Writes the trace of a rig in the units of a drive.
fn rewrite(from: &Path, to: &Path, drive: &Drive) {
    let text = std::fs::read_to_string(from).expect("a trace");
    let (head, rows) = text.split_once('\n').expect("a heading");
    let places = ["t_s", "current_a", "velocity_rad_s", "angle_rad"]
        .map(|name| head.split(',').position(|own| own == name).expect("a column"));
    let mut written = format!("t_s,current_a,{},{}\n", drive.names[1], drive.names[0]);
    for line in rows.lines() {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().expect("a number")).collect();
        let [time, current, velocity, angle] = places.map(|place| cells[place]);
        let angle = angle * drive.factors[0];
        let angle = drive.turn.map_or(angle, |turn| angle.rem_euclid(turn));
        let angle = if drive.whole { angle.floor() } else { angle };
        written += &format!("{time},{current},{},{angle}\n", velocity * drive.factors[1]);
    }
    std::fs::write(to, written).expect("writable");
}

/// Writes the traces of a rig in the units of a drive.
fn rewrite_all(dir: &Path, from: &str, to: &str, drive: &Drive) {
    std::fs::create_dir_all(dir.join(to)).expect("writable");
    for entry in std::fs::read_dir(dir.join(from)).expect("a folder") {
        let path = entry.expect("an entry").path();
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        if name != "labels.csv" {
            rewrite(&path, &dir.join(to).join(name), drive);
        }
    }
    std::fs::copy(dir.join(from).join("labels.csv"), dir.join(to).join("labels.csv")).expect("labels");
}

/// What an audit prints, which fails if it finds something.
fn audited(dir: &Path, what: &str) -> String {
    let output = run(dir, &format!("audit {what}"));
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

/// Records of spalls that are novel.
fn spalls_found(dir: &Path, folder: &str, model: &str) -> usize {
    let told = succeed(dir, &format!("replay --model {model} --json {folder}"));
    let report: serde_json::Value = serde_json::from_str(&told).expect("JSON");
    report.as_array().expect("segments").iter().filter(|segment| segment["verdict"] == "novel").count()
}

#[test]
fn a_spall_is_found_whatever_the_unit_and_what_nothing_tells_is_asked() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy --count 40 --seed 5 --mix --angle-bits 16 --out rad");
    succeed(dir, "simulate --class spall --count 10 --severity 2 --seed 9 --mix --angle-bits 16 --out rad_spall");
    for (k, drive) in DRIVES.iter().enumerate() {
        let (healthy, spall) = (format!("d{k}"), format!("s{k}"));
        rewrite_all(dir, "rad", &healthy, drive);
        rewrite_all(dir, "rad_spall", &spall, drive);
        // What is asked is said although notes are not.
        let told = succeed(dir, &format!("init -q {healthy}"));
        let file = dir.join(&healthy).join("drive.toml");
        let text = std::fs::read_to_string(&file).expect("a drive file");
        let [angle, velocity] = drive.written;
        for line in [format!("angle = \"{angle}\""), format!("velocity = \"{velocity}\"")] {
            assert!(text.contains(&line), "{line} in\n{text}");
        }
        let asks = drive.written != drive.answers;
        let asked = told.contains("Questions: ") && (told.contains("not known") || told.contains("pole pairs"));
        assert_eq!(asked, asks, "{told}");
        let audited = audited(dir, &format!("{healthy}/drive.toml"));
        let train = format!("train {healthy}/drive.toml --orders outer=3.71794 --features orders --model m{k}.bwm");
        if asks {
            assert!(audited.contains("not known") || audited.contains("how many pole pairs"), "{audited}");
            refuse(dir, &train, &["is a question: write"]);
            let answered = text.replace(angle, drive.answers[0]).replace(velocity, drive.answers[1]);
            std::fs::write(&file, answered).expect("writable");
        }
        succeed(dir, &train);
        assert_eq!(spalls_found(dir, &spall, &format!("m{k}.bwm")), 10, "{angle}");
    }
}

#[test]
fn an_angle_in_another_unit_than_its_velocity_is_refused_on_both_sides() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy --count 12 --seed 5 --mix --angle-bits 16 --out rad");
    for factor in [0.001, 1.0 / TAU, 0.4, -1.0, 2.5, 7.0, 57.295_78] {
        let names = ["angle_rad", "velocity_rad_s"];
        let drive = Drive { names, factors: [factor, 1.0], whole: false, turn: None, written: names, answers: names };
        rewrite_all(dir, "rad", "other", &drive);
        let audited = audited(dir, "other");
        let named = ["times as far as the velocity says", "runs against the velocity"];
        assert!(named.iter().any(|words| audited.contains(words)), "{factor}: {audited}");
        let train = "train --labels other/labels.csv --current current_a --velocity velocity_rad_s --angle angle_rad \
                     --orders outer=3.71794 --features orders --false-alarm 0.1 --model m.bwm";
        refuse(dir, train, &["times as far as the velocity says", "Another unit"]);
        let described = run(dir, "init other");
        let told =
            String::from_utf8_lossy(&described.stderr).into_owned() + &String::from_utf8_lossy(&described.stdout);
        assert!(told.contains("the velocity"), "{factor}: {told}");
        std::fs::remove_dir_all(dir.join("other")).expect("a folder");
    }
    // A gain of the velocity is named, and segments with it have no verdict.
    let names = ["angle_rad", "velocity_rad_s"];
    let drive = Drive { names, factors: [1.0, 0.7153], whole: false, turn: None, written: names, answers: names };
    rewrite_all(dir, "rad", "gain", &drive);
    let audited = audited(dir, "gain");
    assert!(audited.contains("1.39") && audited.contains("times as far as the velocity says"), "{audited}");
}
