//! Command-line tests of `bearing-watch simulate --rig ema`.

use std::path::Path;

use crate::common::{refuse, succeed};

const HEADER: &str = "t_s,position_ref_m,position_m,velocity_ref_rad_s,velocity_rad_s,current_a,current_d_a,\
                      current_ref_a,phase_a_a,phase_b_a,phase_c_a,resolver_counts,angle_rad,load_n,load_torque_nm,\
                      voltage_d_v,voltage_q_v";

fn text(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn column(text: &str, name: &str) -> Vec<f64> {
    let place = HEADER.split(',').position(|own| own == name).expect("known column");
    text.lines().skip(1).map(|line| line.split(',').nth(place).expect("cell").parse().expect("number")).collect()
}

#[test]
fn traces_and_labels_of_both_rigs_live_in_one_folder() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    let classes = "--class healthy,spall-and-roughness --count 1 --seed 3 --out t";
    succeed(dir, &format!("simulate {classes}"));
    assert!(succeed(dir, &format!("simulate --rig ema {classes}")).starts_with("2 traces"));
    succeed(dir, &format!("simulate --rig ema --condition moog-2-mix --severity 0.5 --race outer {classes}"));
    let labels = text(&dir.join("t/labels.csv"));
    let labels: Vec<&str> = labels.lines().collect();
    assert_eq!(
        labels,
        [
            "trace,class_name,severity,seed,condition,waveform",
            "healthy_3_000.csv,healthy,0,3,standard,sine",
            "spall-and-roughness_3_000.csv,spall-and-roughness,1,3,standard,sine",
            "ema_healthy_3_000.csv,healthy,0,3,standard,sine",
            "ema_spall-and-roughness_3_000.csv,spall-and-roughness,1,3,standard,sine",
            "ema_healthy_moog-2-mix_3_000.csv,healthy,0,3,moog-2-mix,triangle",
            "ema-outer_spall-and-roughness_0.5_moog-2-mix_3_000.csv,spall-and-roughness,0.5,3,moog-2-mix,triangle",
        ]
    );
    for row in &labels[3..] {
        let trace = text(&dir.join("t").join(row.split(',').next().expect("name")));
        assert_eq!(trace.lines().next(), Some(HEADER));
        assert_eq!(trace.lines().count(), 12_001);
        // Counts are integers of 14 bits.
        assert!(column(&trace, "resolver_counts").iter().all(|x| x.fract() == 0.0 && (0.0..16_384.0).contains(x)));
        let held = column(&trace, "current_a").chunks_exact(3).filter(|x| x[0] == x[1] && x[1] == x[2]).count();
        assert_eq!(held == 4000, row.contains("moog"), "{row} {held}");
    }
}

#[test]
fn the_rate_of_recording_changes_the_rows_and_nothing_else() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    for options in ["--out usual", "--out slow --log-every 100"] {
        succeed(dir, &format!("simulate --rig ema --class spall --count 1 {options}"));
    }
    let [usual, slow] = ["usual", "slow"].map(|out| text(&dir.join(out).join("ema_spall_1_000.csv")));
    let every_tenth: Vec<&str> = usual.lines().skip(1).step_by(10).collect();
    assert_eq!(slow.lines().skip(1).collect::<Vec<_>>(), every_tenth);
    assert_eq!(every_tenth.len(), 1200);
}

#[test]
fn options_of_the_other_rig_are_refused() {
    let folder = tempfile::tempdir().expect("folder");
    for (options, words) in [
        ("--rig ema --class healthy --waveform sine", ["--waveform", "--condition"]),
        ("--rig ema --class healthy --angle-bits 12", ["--angle-bits", "14 bits"]),
        ("--rig ema --class healthy --condition square", ["--condition square", "moog-1-mix"]),
        ("--rig ema --class healthy --condition field-any", ["DC-motor rig", "rit-mix"]),
        ("--rig ema --class healthy --log-every 0", ["--log-every 0", "at least 1"]),
        ("--rig ema --class spall --severity -1", ["defect.inner_spall", "negative"]),
        ("--rig ema --class weak-magnet --severity 20", ["actuator.flux_wb", "positive"]),
        ("--class healthy --condition moog-1", ["--condition moog-1", "--rig ema"]),
        ("--class healthy --race outer", ["--race", "--rig ema"]),
        ("--class healthy --log-every 10", ["--log-every", "--rig ema"]),
        ("--rig hydraulic --class healthy", ["'hydraulic'", "ema"]),
    ] {
        refuse(folder.path(), &format!("simulate {options} --out s"), &words);
    }
}
