use super::*;
use std::vec::Vec;

/// Takes so many runs of variance 1, with reference 0.
fn course(runs: u32, mean: impl Fn(u32) -> f32) -> Course {
    let mut course = Course::new(1.0);
    for run in 0..runs {
        course.pass(1.0, 0.0);
        course.take(mean(run) + jitter(run), 1.0);
    }
    course
}

/// A fixed sequence without trend, of variance near 1.
fn jitter(run: u32) -> f32 {
    [1.2, -0.9, 0.3, -1.4, 0.8, 1.1, -1.0, -0.1][run as usize % 8]
}

fn left(course: &Course, named: f32) -> Interval {
    course.growth(0.0, 0.02, named).left.unwrap()
}

#[test]
fn one_run_by_hand() {
    let mut course = Course::new(3.0);
    course.pass(1.0, 0.0);
    // P = [3 + 0.0004, 0.0004; 0.0004, 0.0004] and q.
    assert!((course.variance - 3.0004).abs() < 1e-5 && (course.joint - 4e-4).abs() < 1e-6, "{course:?}");
    course.take(2.0, 1.0);
    // S = 4.0004: gain 3/4, and 1e-4 for the slope.
    assert!((course.level - 1.500_05).abs() < 1e-4 && (course.slope - 2e-4).abs() < 1e-6, "{course:?}");
    assert!((course.variance - 0.750_02).abs() < 1e-4 && (course.joint - 1e-4).abs() < 1e-6, "{course:?}");
}

#[test]
fn the_interval_is_the_ratio_of_distance_and_slope() {
    // Nearly known: g = 10, v = 0.5, and L = 20: D = 10 (2^0.9 − 1)/0.9.
    let known =
        Course { level: 10.0, slope: 0.5, variance: 1e-6, slope_variance: 1e-6, age: 100.0, ..Course::new(1.0) };
    let distance = 10.0 * (2.0_f32.powf(0.9) - 1.0) / 0.9;
    let Interval { value, low, high } = left(&known, 20.0);
    assert!((value - distance / 0.5).abs() < 1e-3, "{value}");
    // Of the bend: from κ = −0.5 to 0.7; of the turns: ζ ln 2/3.
    let ends = [1.5_f32, 0.3].map(|a| 10.0 * (2.0_f32.powf(a) - 1.0) / a);
    let known_level = known.growth(0.0, 0.0, 20.0).left.unwrap();
    let spread = (0.25 * (ends[0] - ends[1]).powi(2) + 0.35 * distance.powi(2) * 2.0_f32.ln() / 3.0).sqrt();
    let half = 1.645 * spread / 0.5;
    assert!(((known_level.high - known_level.low) / 2.0 - half).abs() < 0.01 * half, "{known_level:?} {half}");
    assert!(low <= known_level.low && high >= known_level.high, "an unknown reference widens it");
    assert_eq!(left(&known, 10.0), Interval::default(), "the size is reached");
    assert_eq!(known.growth(0.0, 0.0, f32::NAN).left, None);
    // (11): 9 in 5 runs, of which 0.6 is too soon for the other end.
    let sudden = left(&Course { age: 5.0, ..known }, 20.0);
    assert!((sudden.low - 0.6 * 10.0 * 5.0 / 9.0).abs() < 1e-3 && sudden.high == high, "{sudden:?}");
}

#[test]
fn a_healthy_drive_does_not_grow() {
    for runs in 1..1000 {
        let growth = course(runs, |_| 0.0).growth(0.0, 0.02, 12.0);
        assert!(!growth.is_growing() && growth.slope.low <= 0.0, "{runs}: {growth:?}");
    }
}

#[test]
fn a_line_grows_at_its_slope_and_the_end_is_within_the_interval() {
    for (slope, half) in [(0.05_f32, 200_u16), (0.2, 50), (0.625, 16)] {
        let course = course(40 + u32::from(half), |run| slope * run.saturating_sub(40) as f32);
        let growth = course.growth(0.0, 0.02, 20.0);
        assert!(growth.slope.low < slope && slope < growth.slope.high, "{slope}: {growth:?}");
        assert!(growth.size.low < 10.0 && growth.size.high > 9.0, "{slope}: {growth:?}");
        let Interval { value, low, high } = growth.left.unwrap();
        let half = f32::from(half);
        assert!(low < half && half < high && value > 0.5 * half && value < 1.5 * half, "{slope}: {growth:?}");
        assert!(high - low < 2.5 * half, "{slope}: {growth:?}");
    }
}

#[test]
fn a_chip_raises_the_level_and_a_wild_run_does_not() {
    let chip = course(60, |run| if run < 40 { 0.0 } else { 15.0 }).growth(0.0, 0.02, 30.0);
    assert!((chip.size.value - 15.0).abs() < 1.0 && chip.size.low > 13.0 && !chip.is_growing(), "{chip:?}");
    for wild in [9.0, 1e3, 1e18, f32::MAX, f32::NAN, f32::INFINITY] {
        let growth = course(60, |run| if run == 40 { wild } else { 0.0 }).growth(0.0, 0.02, 30.0);
        assert!(growth.size.value.abs() < 1.5 && !growth.is_growing(), "{wild}: {growth:?}");
    }
}

#[test]
fn a_repaired_bearing_starts_anew() {
    let grown = |run: u32| if run < 80 { 0.25 * run as f32 } else { 0.0 };
    let before = course(80, grown).growth(0.0, 0.02, 30.0);
    assert!(before.is_growing(), "{before:?}");
    for runs in 82..120 {
        let after = course(runs, grown).growth(0.0, 0.02, 30.0);
        assert!(!after.is_growing() && after.size.value < 3.0, "{runs}: {after:?}");
    }
}

#[test]
fn time_without_a_value_passes_and_runs_count_by_their_length() {
    let mut one = course(60, |run| 0.3 * run as f32);
    let mut other = one;
    one.pass(3.0, 0.0);
    (0..3).for_each(|_| other.pass(1.0, 0.0));
    assert!((one.level - other.level).abs() < 0.05 && one.level > 17.5, "{one:?} {other:?}");
    other.pass(f32::NAN, 0.0);
    other.pass(f32::INFINITY, 0.0);
    assert!(other.level.is_finite() && other.variance.is_finite(), "{other:?}");
}

#[test]
fn words_are_those_of_the_course_and_checked() {
    let kept = course(60, |run| 0.3 * run as f32);
    let mut words = Vec::new();
    kept.save(&mut |word| words.push(word));
    assert_eq!(words.len(), WORDS);
    let of = |words: &[u32]| {
        let mut words = words.iter().copied();
        Course::restore(&mut || words.next())
    };
    assert_eq!(of(&words), Some(kept));
    assert_eq!(of(&words[..7]), None);
    for (index, bad) in
        [(0, f32::NAN), (2, 0.0), (2, -1.0), (4, 0.0), (5, 8.0), (5, -1.0), (6, f32::INFINITY), (7, -1.0)]
    {
        let mut changed = words.clone();
        changed[index] = bad.to_bits();
        assert_eq!(of(&changed), None, "{index} {bad}");
    }
}

#[test]
fn hours_are_those_of_a_usual_run() {
    let unit = Interval { value: 10.0, low: 5.0, high: 20.0 };
    let growth = Growth { slope: unit, left: Some(unit), run_hours: 0.5, ..Growth::default() };
    assert_eq!(growth.left_hours().map(|left| left.high), Some(10.0));
    assert_eq!(growth.slope_per_hour().low, 10.0);
}

#[test]
fn an_offset_that_lasts_is_no_growth() {
    // It rises over fifty runs by one and a half deviations of a run, of which many runs leave a small error.
    let risen = |run: u32| 0.03 * run.min(50) as f32;
    for runs in 30..120 {
        let growth = course(runs, risen).growth(0.0, 0.001, 17.0);
        assert!(!growth.is_growing(), "{runs}: {growth:?}");
    }
    assert!(course(120, |run| 0.03 * run as f32).growth(0.0, 0.001, 17.0).is_growing());
}

#[test]
fn the_age_counts_from_the_last_time_that_the_size_was_below_its_start() {
    let mut course = Course { level: 5.0, age: 40.0, ..Course::new(1.0) };
    course.pass(2.0, 0.0);
    assert_eq!(course.age, 42.0);
    course.pass(1.0, 4.5);
    assert_eq!(course.age, 0.0, "half a deviation above the reference");
    course.pass(3.0, 0.0);
    assert_eq!(course.age, 3.0);
    // A repaired bearing.
    course.take(-50.0, 1.0);
    assert_eq!((course.age, course.slope), (0.0, 0.0));
}

#[test]
fn a_jump_forgets_the_drift_before_it() {
    let drifting = Course { level: 3.0, drift: 6.9, drift_runs: 20.0, ..Course::new(1.0) };
    for jump in [60.0, -60.0] {
        let mut course = drifting;
        course.take(jump, 1.0);
        assert_eq!((course.drift, course.drift_runs), (0.0, 0.0), "{jump}");
    }
    let mut course = drifting;
    course.take(4.0, 1.0);
    assert_eq!(course.drift_runs, 0.0, "beyond the limit it has its effect");
    assert!(course.slope_variance > 0.001, "{course:?}");
}

#[test]
fn a_run_counts_for_sixteen_usual_ones_at_most() {
    let passed = |runs: f32| {
        let mut course = Course { level: 9.0, slope: 0.1, ..Course::new(1.0) };
        course.pass(runs, 0.0);
        course
    };
    assert_eq!(passed(1000.0), passed(16.0));
    assert!(passed(15.0).level < passed(16.0).level);
}

#[test]
fn there_is_no_time_left_to_a_size_that_is_none() {
    let grown = course(80, |run| 0.25 * run as f32);
    assert!(grown.growth(0.0, 0.02, 30.0).is_growing());
    for named in [0.0, -30.0, f32::NAN] {
        assert!(!grown.growth(0.0, 0.02, named).is_growing(), "{named}");
    }
}

/// (7): c = 6.25 + 2 − 1/4 over n = 10 runs, so b = 2 (8 + 10/4)/10² = 0.21, and b² [25, 5; 5, 1] is added to P.
#[test]
fn a_drift_beyond_its_limit_by_hand() {
    let before = Course { joint: 0.01, drift: 6.25, drift_runs: 9.0, ..Course::new(1.0) };
    let mut course = before;
    course.follow(2.0);
    let added =
        [course.variance - before.variance, course.joint - before.joint, course.slope_variance - before.slope_variance];
    for (added, expected) in added.into_iter().zip([1.1025, 0.2205, 0.0441]) {
        assert!((added - expected).abs() < 1e-6, "{course:?}");
    }
}
