//! Command-line tests of several motors in one file or folder, of numbers without their sign, and of columns that lack
//! most rows: asked, or converted with a word, and never one of them in silence.

use std::fmt::Write as _;
use std::path::Path;

use crate::common::{refuse, run, succeed};

/// The columns time, current, velocity and angle of each trace of a folder.
fn traces(dir: &Path, folder: &str) -> Vec<[Vec<f64>; 4]> {
    let mut all: Vec<_> = std::fs::read_dir(dir.join(folder)).expect("a folder").filter_map(Result::ok).collect();
    all.sort_by_key(std::fs::DirEntry::file_name);
    let files = all.into_iter().map(|entry| entry.path()).filter(|path| !path.ends_with("labels.csv"));
    let each = |path: std::path::PathBuf| {
        let text = std::fs::read_to_string(path).expect("a trace");
        let (head, rows) = text.split_once('\n').expect("a heading");
        ["t_s", "current_a", "velocity_rad_s", "angle_rad"].map(|name| {
            let place = head.split(',').position(|own| own == name).expect("a column");
            rows.lines().map(|row| row.split(',').nth(place).expect("a cell").parse().expect("a number")).collect()
        })
    };
    files.map(each).collect()
}

/// Writes columns under names.
fn write(file: &Path, columns: &[(String, Vec<String>)]) {
    std::fs::create_dir_all(file.parent().expect("a folder")).expect("writable");
    let names: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
    let mut text = names.join(",") + "\n";
    for row in 0..columns[0].1.len() {
        let cells: Vec<&str> = columns.iter().map(|(_, cells)| cells[row].as_str()).collect();
        writeln!(text, "{}", cells.join(",")).expect("writable");
    }
    std::fs::write(file, text).expect("writable");
}

fn cells(values: &[f64], factor: f64) -> Vec<String> {
    values.iter().map(|x| format!("{:.6}", factor * x)).collect()
}

fn rig(count: usize) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("folder");
    succeed(
        folder.path(),
        &format!("simulate --class healthy --count {count} --seed 5 --mix --angle-bits 16 --out rig"),
    );
    folder
}

/// What an audit prints.
fn audited(dir: &Path, what: &str) -> String {
    String::from_utf8_lossy(&run(dir, &format!("audit {what}")).stdout).into_owned()
}

#[test]
fn of_several_motors_in_one_file_the_user_is_asked() {
    let folder = rig(24);
    let dir = folder.path();
    let all = traces(dir, "rig");
    for (k, (names, answer)) in [
        (["axis{}_iq_A", "axis{}_velocity_rad_s", "axis{}_angle_rad"], ["1", "2"]),
        (["iq_{} [A]", "speed_{} [rad/s]", "theta_{} [rad]"], ["L", "R"]),
        (["/motor_{}/iq_a", "/motor_{}/w_rad_s", "/motor_{}/pos_rad"], ["a", "b"]),
    ]
    .into_iter()
    .enumerate()
    {
        for (n, pair) in all.chunks(2).enumerate() {
            let mut columns = vec![("t_s".to_string(), cells(&pair[0][0], 1.0))];
            for (own, part) in pair.iter().zip(answer) {
                let column = |(values, name): (&Vec<f64>, &str)| (name.replace("{}", part), cells(values, 1.0));
                columns.extend(own[1..].iter().zip(names).map(column));
            }
            write(&dir.join(format!("m{k}/rec{n:02}.csv")), &columns);
        }
        let told = succeed(dir, &format!("init -q m{k}"));
        let list = answer.join(", ");
        assert!(told.contains(&format!("several motors move: which one has the bearing, {list}?")), "{told}");
        let file = dir.join(format!("m{k}/drive.toml"));
        let text = std::fs::read_to_string(&file).expect("a drive file");
        assert!(text.contains(&format!("angle = \"{}\"", names[2].replace("{}", "?"))), "{text}");
        assert!(audited(dir, &format!("m{k}/drive.toml")).contains("several motors move"));
        refuse(dir, &format!("train m{k}/drive.toml --model m.bwm"), &["is a question: write a column of the motor"]);
        // The second one.
        let answered: Vec<String> = text
            .lines()
            .map(|line| if line.starts_with('#') { line.to_string() } else { line.replace('?', answer[1]) })
            .collect();
        std::fs::write(&file, answered.join("\n")).expect("writable");
        succeed(dir, &format!("train m{k}/drive.toml --model m.bwm"));
        assert!(!audited(dir, &format!("m{k}/drive.toml")).contains("several motors move"));
    }
}

#[test]
fn of_files_of_several_motors_the_user_is_asked() {
    let folder = rig(24);
    let dir = folder.path();
    let all = traces(dir, "rig");
    for (k, (pattern, motors)) in [
        ("{}/rec{n}.csv", ["axis1", "axis2"]),
        ("healthy_{n}_{}.csv", ["J1", "J4"]),
        ("healthy/{}_{n}.csv", ["motor_a", "motor_b"]),
    ]
    .into_iter()
    .enumerate()
    {
        for (n, own) in all.iter().enumerate() {
            let names = ["t_s", "current_a", "velocity_rad_s", "angle_rad"];
            let columns: Vec<_> = names.iter().zip(own).map(|(name, x)| ((*name).to_string(), cells(x, 1.0))).collect();
            let name = pattern.replace("{}", motors[n % 2]).replace("{n}", &(n / 2).to_string());
            write(&dir.join(format!("f{k}")).join(name), &columns);
        }
        let told = succeed(dir, &format!("init -q f{k}"));
        assert!(told.contains(&format!("which one has the bearing, {}?", motors.join(", "))), "{told}");
        let file = dir.join(format!("f{k}/drive.toml"));
        let text = std::fs::read_to_string(&file).expect("a drive file");
        let train = format!("train f{k}/drive.toml --model m.bwm");
        refuse(dir, &train, &[&format!("where axis=? is a question: write one of {}", motors.join(", "))]);
        std::fs::write(&file, text.replace("axis=?", &format!("axis={}", motors[0]))).expect("writable");
        succeed(dir, &train);
        // Labels that are kept ask again.
        assert!(succeed(dir, &format!("init -q --force f{k}")).contains("which one has the bearing"));
    }
}

#[test]
fn numbers_without_their_sign_are_decoded_with_a_word() {
    let folder = rig(24);
    let dir = folder.path();
    let all = traces(dir, "rig");
    let magnitude = |x: f64, half: f64| if x < 0.0 { half - x } else { x };
    let codings: [(&str, &dyn Fn(f64) -> f64); 3] = [
        ("signed16", &|x: f64| x.rem_euclid(65_536.0)),
        ("magnitude16", &|x: f64| magnitude(x, 32_768.0)),
        ("signed24", &|x: f64| x.rem_euclid(16_777_216.0)),
    ];
    for (word, coded) in codings {
        let written = |x: &[f64], factor: f64| x.iter().map(|x| coded((factor * x).round()).to_string()).collect();
        for (n, own) in all.iter().enumerate() {
            let columns = [
                ("t_s".to_string(), cells(&own[0], 1.0)),
                ("iq_mA".to_string(), written(&own[1], 1e3)),
                ("speed [0.01 rad/s]".to_string(), written(&own[2], 100.0)),
                ("angle_rad".to_string(), cells(&own[3], 1.0)),
            ];
            write(&dir.join(word).join(format!("rec{n:02}.csv")), &columns);
        }
        let described = run(dir, &format!("init {word}"));
        let told = String::from_utf8_lossy(&described.stderr).into_owned();
        assert!(told.contains(&format!("take {word}(iq_mA)")), "{told}");
        let text = std::fs::read_to_string(dir.join(word).join("drive.toml")).expect("a drive file");
        assert!(text.contains(&format!("velocity = \"{word}(speed [0.01 rad/s])\"")), "{text}");
        succeed(dir, &format!("train {word}/drive.toml --model m.bwm"));
        let report = audited(dir, &format!("{word}/drive.toml"));
        assert!(!report.contains("times as far") && !report.contains("stuck"), "{report}");
        // Taken as they are, they are named.
        assert!(audited(dir, word).contains(&format!("take {word}(speed [0.01 rad/s])")));
        let plain = text.replace(&format!("{word}(speed [0.01 rad/s])"), "speed [0.01 rad/s]");
        std::fs::write(dir.join(word).join("plain.toml"), plain).expect("writable");
        let trained = run(dir, &format!("train {word}/plain.toml --model m.bwm"));
        let told = String::from_utf8_lossy(&trained.stderr).into_owned();
        assert!(told.contains(&format!("take {word}(speed [0.01 rad/s])")), "{told}");
    }
}

#[test]
fn columns_that_lack_most_rows_are_named_and_not_taken() {
    let folder = rig(24);
    let dir = folder.path();
    let all = traces(dir, "rig");
    for (name, every) in [("load_torque_nm", 6), ("Lastmoment [Nm]", 3), ("brake_torque_nm", 50)] {
        let place = name.split([' ', '_']).next().expect("a word");
        for (n, own) in all.iter().enumerate() {
            let blank = |(k, x): (usize, &f64)| if k % every == 0 { format!("{:.6}", 0.1 * x) } else { String::new() };
            let columns = [
                ("t_s".to_string(), cells(&own[0], 1.0)),
                ("current_a".to_string(), cells(&own[1], 1.0)),
                ("velocity_rad_s".to_string(), cells(&own[2], 1.0)),
                ("angle_rad".to_string(), cells(&own[3], 1.0)),
                (name.to_string(), own[2].iter().enumerate().map(blank).collect()),
            ];
            write(&dir.join(place).join(format!("rec{n:02}.csv")), &columns);
        }
        let described = run(dir, &format!("init {place}"));
        let told = String::from_utf8_lossy(&described.stderr).into_owned();
        assert!(described.status.success() && told.contains(&format!("column {name} has no number in ")), "{told}");
        let text = std::fs::read_to_string(dir.join(place).join("drive.toml")).expect("a drive file");
        assert!(text.lines().all(|line| line.starts_with('#') || !line.contains(name)), "{text}");
        succeed(dir, &format!("train {place}/drive.toml --model m.bwm"));
        assert!(audited(dir, &format!("{place}/drive.toml")).contains(&format!("column {name}: no number in")));
    }
}
