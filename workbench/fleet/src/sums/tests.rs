use serde_json::json;

use super::*;

/// A plan, of which only the text counts here.
fn plan() -> Plan {
    let plan = json!({
        "version": 1, "features": ["a", "b"], "usual": [0.0, 0.0], "classes": [], "unit": null, "group": null,
        "y": "i", "u1": "w", "u2": "t", "shaft": null, "further": [], "time": null, "rate_hz": null,
        "front_end": null, "block_mean": 1, "decimate": 1, "recorded_interval_s": 0.0, "interval_s": 0.0,
        "segment_samples": 1, "segment_given": false, "order": [1, 1, 1, 1, 1], "offset": false, "park": null,
        "memory": null, "nominal": 0, "orders": [], "velocity_from_angle": false, "load": false, "core": "",
    });
    serde_json::from_value(plan).expect("all keys")
}

fn sums() -> Sums {
    Sums::new(&plan(), [&["a", "b"].map(String::from), &[]], &[]).expect("two features")
}

/// A run of healthy rows with both features.
fn run(name: &str, values: &[f64]) -> ((String, String), Group) {
    let mut rows = Group::new(2);
    values.iter().for_each(|value| rows.add(&[*value, -value]));
    (("healthy".to_string(), name.to_string()), rows)
}

/// Sums of a drive that is complete.
fn closed(drive: &str) -> Sums {
    let mut sums = sums();
    sums.close(drive, &[run("1", &[1.0])], true).expect("the first");
    sums
}

#[test]
fn rows_are_counted_by_the_features_that_they_have() {
    let (mut one, mut other) = (sums(), sums());
    one.add_partial("healthy", &[f64::NAN, f64::NAN], &[0.0, 0.0]).expect("few patterns");
    one.add_partial("healthy", &[3.0, f64::NAN], &[0.5, 0.0]).expect("few patterns");
    other.add_partial("healthy", &[5.0, f64::NAN], &[1.5, 0.0]).expect("few patterns");
    one.merge(other).expect("the same plan");
    assert_eq!(one.rows, 3);
    let class = one.of_class("healthy").expect("rows");
    assert_eq!((class.empty, class.count()), (1, 2));
    let [pattern] = &class.patterns(&[0, 1])[..] else { panic!("one pattern") };
    assert_eq!((pattern.mask, pattern.rows.mean.as_slice(), &pattern.excess[..]), (1, &[4.0][..], &[1.0][..]));
}

#[test]
fn a_drive_has_the_rows_of_all_its_runs() {
    let mut sums = sums();
    sums.close("drive", &[run("1", &[1.0, 3.0]), run("2", &[8.0]), run("3", &[])], true).expect("one drive");
    let class = sums.of_class("healthy").expect("rows");
    assert_eq!((class.runs.count, class.runs.rows, class.runs.longest, class.runs.single), (2, 3, 2, 1));
    assert_eq!((class.units.count, class.units.rows, class.units.longest), (1, 3, 3));
    // Means: of runs 2 and 8, of the drive 12/3.
    assert_eq!((class.runs.means().mean[0], class.units.means().mean[0]), (5.0, 4.0));
}

#[test]
fn a_drive_counts_once() {
    let open = || {
        let mut sums = sums();
        sums.keep("drive 1".to_string(), vec![run("2", &[2.0])]);
        sums
    };
    let twice = |mut one: Sums, other: Sums| one.merge(other).expect_err("twice").to_string();
    assert!(twice(closed("drive 1"), closed("drive 1")).contains("is in several sums"));
    assert!(twice(closed("drive 1"), open()).contains("drive drive 1 is in"));
    assert!(twice(open(), closed("drive 1")).contains("drive drive 1 is in"));
    assert!(closed("drive 1").merge(closed("drive 2")).is_ok());
    let mut both = open();
    both.merge(open()).expect("rows of an open drive may come later");
    assert_eq!(both.finish().expect("one drive").of_class("healthy").expect("rows").units.rows, 2);
}

#[test]
fn damaged_bytes_are_told_by_their_checksum() {
    let mut bytes = closed("drive 1").to_bytes().expect("bytes");
    let last = bytes.len() - 1;
    bytes[last] ^= 1;
    assert!(Sums::from_bytes(&bytes).expect_err("damaged").contains("checksum differs"));
}
