use core::f32::consts::TAU;

use super::*;
use crate::signal::Angle;

const SETTINGS: RotorSettings = RotorSettings { slowest_rad_s: 0.5, memory: u16::MAX };

/// A line of this amplitude and phase.
fn line(order: u16, amplitude_a: f32, phase_rad: f32) -> RotorLine {
    let (sine_a, cosine_a) = (amplitude_a * phase_rad.sin(), amplitude_a * phase_rad.cos());
    RotorLine { order, cosine_a, sine_a, deviation_a: 0.002 }
}

/// These lines at angles that are `slip_rad` more than before.
fn slipped(lines: &[RotorLine], slip_rad: f32) -> std::vec::Vec<RotorLine> {
    let turn = |line_before: &RotorLine| {
        let phase_rad = line_before.phase_rad() + f32::from(line_before.order) * slip_rad;
        line(line_before.order, line_before.amplitude_a(), phase_rad)
    };
    lines.iter().map(turn).collect()
}

/// A map of `turns` in each direction, of this residual at an angle and a sign of the motion.
fn learned<const BINS: usize>(turns: u32, residual_a: impl Fn(Angle, f32) -> f32) -> RotorMap<BINS> {
    let mut map = RotorMap::new();
    // Seven samples a bin, not at the same places in all of them.
    let samples = 7 * BINS as u32 + 1;
    for sign in [1.0, -1.0] {
        for k in 0..turns * samples {
            let angle = Angle::from_radians(sign * TAU * (k % samples) as f32 / samples as f32);
            map.push(&SETTINGS, angle, residual_a(angle, sign), 3.0 * sign);
        }
    }
    map
}

#[test]
fn a_line_is_that_of_the_residual_without_friction() {
    let map = learned::<96>(3, |angle, sign| 0.1 * (12.0 * angle.radians() - 1.0).cos() + 0.3 * sign + 0.05);
    let learned = map.line(12).expect("all bins are passed");
    // A bin is not passed at the same seven places in each turn: an eighth of a sample of its 7 is off by 0.1 · 0.1.
    assert!((learned.amplitude_a() - 0.1).abs() < 1e-3 && (learned.phase_rad() - 1.0).abs() < 0.02, "{learned:?}");
    for order in [1, 5, 24] {
        assert!(map.line(order).expect("all bins").amplitude_a() < 1e-3, "{order}");
    }
    assert_eq!((map.line(0), map.line(48)), (None, None));
}

#[test]
fn a_table_is_a_straight_line_between_its_entries_without_mean() {
    let mut entries = [1.0; 8];
    entries[0] = 9.0;
    let table = table::RotorTable::of(entries);
    let at = |eighths: f32| table.at(Angle::from_radians(eighths * TAU / 8.0));
    // The mean is 2: entries of 7 at half an eighth, of −1 elsewhere. Angles are rounded to 2⁻²³ of a turn.
    for (eighths, expected) in [(0.5, 7.0), (1.0, 3.0), (1.5, -1.0), (0.0, 3.0), (7.5, -1.0), (7.75, 1.0), (4.2, -1.0)]
    {
        assert!((at(eighths) - expected).abs() < 1e-4, "{eighths}: {}", at(eighths));
    }
}

#[test]
fn bad_samples_are_skipped_and_counted() {
    let mut map = learned::<16>(2, |angle, _| angle.sin_cos().cos);
    let before = map.clone();
    for (residual, velocity) in
        [(f32::NAN, 3.0), (f32::INFINITY, 3.0), (f32::NEG_INFINITY, -3.0), (1.0, 0.4), (1.0, f32::NAN)]
    {
        map.push(&SETTINGS, Angle::ZERO, residual, velocity);
    }
    assert_eq!((map.skipped(), map.line(1)), (5, before.line(1)));
}

#[test]
fn there_is_no_line_of_one_direction() {
    let mut map = RotorMap::<16>::new();
    for k in 0..64 {
        map.push(&SETTINGS, Angle::from_counts(k, 4), 0.1, 3.0);
    }
    assert_eq!((map.missing(), map.table(), map.line(1)), (16, None, None));
}

#[test]
fn a_short_memory_follows_and_a_long_one_averages() {
    let at = |memory: u16| {
        let settings = RotorSettings { memory, ..SETTINGS };
        let mut map = RotorMap::<8>::new();
        for turn in 0..20 {
            for sign in [1.0, -1.0] {
                for k in 0..8 {
                    let amplitude = if turn < 10 { 0.1 } else { 0.2 };
                    let angle = Angle::from_counts(2 * k + 1, 4);
                    map.push(&settings, angle, amplitude * angle.sin_cos().cos, 3.0 * sign);
                }
            }
        }
        // All samples are in the middle of their bins.
        let sinc = (TAU / 16.0).sin() / (TAU / 16.0);
        map.line(1).expect("all bins").amplitude_a() * sinc
    };
    // The last pass of each direction may still be open. Nine to ten passes of 0.2 at a quarter each leave 0.1 · 0.75⁹.
    assert!((at(u16::MAX) - 0.15).abs() < 0.004 && (at(4) - 0.2).abs() < 0.01, "{} {}", at(u16::MAX), at(4));
}

#[test]
fn changes_are_told_apart() {
    let usual = RotorLimits::USUAL;
    let before =
        [line(1, 0.12, 0.4), line(2, 0.06, -2.0), line(6, 0.06, 1.0), line(12, 0.12, 3.0), line(24, 0.08, 0.0)];
    assert_eq!(RotorChange::between(&before, &before, &usual), RotorChange::Unchanged);
    for degrees in [3.0_f32, -3.0, 17.0, 90.0, -170.0] {
        let slip_rad = degrees.to_radians();
        let change = RotorChange::between(&before, &slipped(&before, slip_rad), &usual);
        let RotorChange::Slipped { angle_rad, deviation_rad } = change else { panic!("{degrees}: {change:?}") };
        // Without noise; single precision of the 24th order.
        assert!((angle_rad - slip_rad).abs() < 1e-4 && deviation_rad < 0.01, "{degrees}: {change:?}");
    }
    let mut heavy = before;
    heavy[0] = line(1, 0.24, 0.4);
    let RotorChange::Unbalance { before_a, now_a } = RotorChange::between(&before, &heavy, &usual) else {
        panic!("unbalance")
    };
    assert!((before_a - 0.12).abs() < 1e-6 && (now_a - 0.24).abs() < 1e-6);
    let mut other = before;
    other[3] = line(12, 0.2, 3.0);
    assert_eq!(RotorChange::between(&before, &other, &usual), RotorChange::Other { order: 12 });
    other[3].cosine_a = f32::NAN;
    assert!(matches!(RotorChange::between(&before, &other, &usual), RotorChange::Other { .. }));
}

/// Orders 6 and 12 are the same after a sixth of a turn.
#[test]
fn of_slips_that_explain_the_same_the_smallest_is_returned() {
    let before = [line(6, 0.06, 1.0), line(12, 0.12, 3.0)];
    for (degrees, expected) in
        [(7.0_f32, 7.0_f32), (67.0, 7.0), (-175.0, 5.0), (-7.0, -7.0), (53.0, -7.0), (173.0, -7.0)]
    {
        let now = slipped(&before, degrees.to_radians());
        let change = RotorChange::between(&before, &now, &RotorLimits::USUAL);
        let RotorChange::Slipped { angle_rad, .. } = change else { panic!("{degrees}: {change:?}") };
        assert!((angle_rad.to_degrees() - expected).abs() < 0.01, "{degrees}: {angle_rad}");
    }
}

#[test]
fn only_lines_of_the_same_order_are_compared_and_only_a_grown_first_order_is_an_unbalance() {
    let before = [line(1, 0.2, 0.4), line(6, 0.06, 1.0), line(12, 0.12, 3.0)];
    let with = |place: usize, line: RotorLine| {
        let mut now = before;
        now[place] = line;
        RotorChange::between(&before, &now, &RotorLimits::USUAL)
    };
    assert_eq!(with(0, line(2, 0.9, 0.4)), RotorChange::Unchanged, "of another order");
    assert_eq!(with(0, line(1, 0.1, 0.4)), RotorChange::Other { order: 1 }, "less than before");
    assert!(matches!(with(0, line(1, 0.4, 0.4)), RotorChange::Unbalance { .. }));
    let both = [line(1, 0.4, 0.4), line(6, 0.16, 1.0), line(12, 0.12, 3.0)];
    let change = RotorChange::between(&before, &both, &RotorLimits::USUAL);
    assert!(matches!(change, RotorChange::Other { .. }), "{change:?}");
}

/// A disturbance that lasts for several bins is known worse than its passes alone tell, whichever way the rotor turns.
#[test]
fn a_slow_disturbance_widens_a_line_alike_in_both_directions() {
    let deviation_a = |disturbed: f32| {
        let mut map = RotorMap::<64>::new();
        let (mut state, mut slow) = (1_u32, 0.0);
        for (turns, sign) in [(1, 1.0), (1, -1.0), (40, disturbed)] {
            for k in 0..turns * 64 {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                slow = 0.9 * slow + f32::from((state >> 16) as i16) / 3e5;
                let middle = Angle::from_counts(2 * k + 1, 7);
                let angle = if sign > 0.0 { middle } else { middle.negated() };
                map.push(&SETTINGS, angle, if turns > 1 { slow } else { 0.0 }, 3.0 * sign);
            }
        }
        map.line(1).expect("all bins are passed").deviation_a
    };
    let (forward, backward) = (deviation_a(1.0), deviation_a(-1.0));
    assert!(forward > 0.0 && (backward / forward - 1.0).abs() < 0.02, "{forward} {backward}");
}
