#![expect(clippy::cast_sign_loss, reason = "a positive fraction of a turn")]

use super::*;

impl CurrentBalance {
    /// Takes the phase currents, A, at an electrical angle with its sine and cosine; a sample that is not finite is
    /// left out. Returns whether this sample closed a window.
    fn push(&mut self, currents: Abc, electrical: Angle, turn: SinCos) -> bool {
        self.gather(currents, electrical, turn);
        let full = self.is_full();
        if full {
            self.close();
        }
        full
    }
}

const LIMITS: BalanceLimits = BalanceLimits { noise_a: 0.1, offset_a: 0.2, gain_tolerance: 0.02, window: 320 };

/// One finding after `turns` electrical turns of currents of `amplitude_a`, with normal noise of 0.05 A a sensor.
fn finding(
    amplitude_a: f64,
    turns: f64,
    gains: [f64; 3],
    currents: impl Fn(f64, f64) -> [f64; 3],
) -> Option<Imbalance> {
    let mut balance = CurrentBalance::new(LIMITS);
    let mut state = 3_u32;
    let mut noise = || {
        let mut uniform = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / 16_777_216.0
        };
        0.05 * ((0..12).map(|_| uniform()).sum::<f64>() - 6.0)
    };
    for k in 0..20_000 {
        let turn = turns * f64::from(k) / 20_000.0;
        let mut i = currents(amplitude_a, core::f64::consts::TAU * turn);
        i.iter_mut().zip(gains).for_each(|(i, gain)| *i = gain * *i + noise());
        let [a, b, c] = i.map(|i| i as f32);
        let electrical = Angle::from_bits((turn.fract() * 4_294_967_296.0) as u32);
        let _ = balance.push(Abc { a, b, c }, electrical, electrical.sin_cos());
    }
    assert_eq!(balance.unbalanced_windows() > 0, balance.imbalance().is_some());
    balance.imbalance()
}

fn three(amplitude: f64, angle: f64) -> [f64; 3] {
    [0.0, 1.0, 2.0].map(|k| amplitude * (angle - k * core::f64::consts::TAU / 3.0).sin())
}

#[test]
fn balanced_currents_are_balanced_with_any_amplitude_and_tolerated_gains() {
    for amplitude in [0.0, 0.3, 10.0, 50.0] {
        assert_eq!(finding(amplitude, 100.0, [1.0; 3], three), None, "{amplitude} A");
    }
    assert_eq!(finding(50.0, 100.0, [1.015, 0.99, 1.01], three), None);
}

#[test]
fn gain_errors_are_named_and_measured() {
    for (index, phase) in Phase::ALL.into_iter().enumerate() {
        for error in [0.1_f64, -0.2] {
            let mut gains = [1.0; 3];
            gains[index] += error;
            let Some(Imbalance::Gain { phase: named, error: measured }) = finding(10.0, 100.0, gains, three) else {
                panic!("{phase:?} {error}");
            };
            // Noise of 0.09 A in 320 samples of a current of 7 A rms: 0.0007.
            assert!(named == phase && (f64::from(measured) - error).abs() < 0.004, "{phase:?} {error} {measured}");
        }
    }
}

#[test]
fn a_gain_error_below_the_noise_of_the_sum_is_named() {
    // ⟨s²⟩ is 0.0075 A² of noise and 0.02 A² of the gain, half of the limit of (2).
    let Some(Imbalance::Gain { phase: Phase::B, error }) = finding(1.0, 100.0, [1.0, 1.2, 1.0], three) else {
        panic!("not named");
    };
    // Noise of 0.09 A in 320 samples of a current of 0.7 A rms: 0.007, and each sensor's own noise 0.005.
    assert!((error - 0.2).abs() < 0.03, "{error}");
    assert_eq!(finding(1.0, 100.0, [1.015, 0.99, 1.01], three), None);
}

#[test]
fn clipped_phases_and_half_waves_are_named() {
    for (index, phase) in Phase::ALL.into_iter().enumerate() {
        let changed = |change: fn(f64) -> f64| {
            finding(10.0, 100.0, [1.0; 3], |amplitude, angle| {
                let mut i = three(amplitude, angle);
                i[index] = change(i[index]);
                i
            })
        };
        let clipped: [fn(f64) -> f64; 3] = [|i| i.clamp(-6.0, 6.0), |i| i.min(7.0), |i| i.max(-4.0)];
        assert_eq!(clipped.map(changed), [Some(Imbalance::Clipped(phase)); 3]);
        let halves: [fn(f64) -> f64; 2] = [|i| i.max(0.0), |i| i.min(0.0)];
        assert_eq!(halves.map(changed), [Some(Imbalance::HalfWave(phase)); 2]);
    }
}

#[test]
fn an_open_winding_differs_from_a_silent_sensor() {
    for (index, phase) in Phase::ALL.into_iter().enumerate() {
        let mut gains = [1.0; 3];
        gains[index] = 0.0;
        assert_eq!(finding(10.0, 100.0, gains, three), Some(Imbalance::Silent(phase)));
        let open = |amplitude: f64, angle: f64| {
            let mut i = [0.0; 3];
            i[(index + 1) % 3] = amplitude * angle.sin();
            i[(index + 2) % 3] = -amplitude * angle.sin();
            i
        };
        assert_eq!(finding(10.0, 100.0, [1.0; 3], open), Some(Imbalance::Open(phase)));
    }
}

#[test]
fn a_silent_sensor_has_no_gain_error_at_a_current_too_small_to_name_it() {
    let limits = BalanceLimits { noise_a: 1.0, ..LIMITS };
    let mut balance = CurrentBalance::new(limits);
    for k in 0..20_000 {
        let angle = core::f64::consts::TAU * f64::from(k) / 200.0;
        let [a, b, _] = three(5.0, angle).map(|i| i as f32);
        let electrical = Angle::from_bits((f64::from(k % 200) / 200.0 * 4_294_967_296.0) as u32);
        let _ = balance.push(Abc { a, b, c: 0.0 }, electrical, electrical.sin_cos());
    }
    // 12.5 A² are less than 50 times the square of the noise.
    assert_eq!(balance.imbalance(), Some(Imbalance::Unnamed));
}

#[test]
fn an_offset_is_named_and_measured_beyond_those_that_are_removed() {
    for (index, phase) in Phase::ALL.into_iter().enumerate() {
        let offset = |by: f64| {
            let shifted = move |amplitude: f64, angle: f64| {
                let mut i = three(amplitude, angle);
                i[index] += by;
                i
            };
            finding(10.0, 100.0, [1.0; 3], shifted)
        };
        let Some(Imbalance::Offset { phase: named, offset_a }) = offset(-0.4) else { panic!("{phase:?}") };
        // Noise of 0.05 A in 320 samples: 0.003 A. The window is not one of whole turns: (4) accounts for it.
        assert!(named == phase && (offset_a + 0.4).abs() < 0.01, "{phase:?}: {named:?} {offset_a}");
        assert_eq!(offset(0.15), None, "below 2 σ");
    }
    // Current to earth, or offsets of all phases.
    let all = finding(10.0, 100.0, [1.0; 3], |amplitude, angle| three(amplitude, angle).map(|i| i + 0.1));
    assert!(matches!(all, Some(Imbalance::Offset { offset_a, .. }) if (offset_a - 0.1).abs() < 0.01), "{all:?}");
}

/// Offsets that are left, and those that were removed, after windows of a drive that removes them.
fn removed(offsets: [f64; 3], current: impl Fn(f64) -> f64) -> ([f64; 3], CurrentBalance) {
    let mut balance = CurrentBalance::new(LIMITS);
    let mut left = offsets;
    for k in 0..40_000_u32 {
        let turn = f64::from(k) / 200.0;
        let i = three(current(turn), core::f64::consts::TAU * turn);
        let [a, b, c] = core::array::from_fn(|x| (i[x] + left[x]) as f32);
        let electrical = Angle::from_bits((turn.fract() * 4_294_967_296.0) as u32);
        if balance.push(Abc { a, b, c }, electrical, electrical.sin_cos()) {
            let steps = balance.remove_offsets();
            left.iter_mut().zip(steps).for_each(|(left, step)| *left -= f64::from(step));
        }
    }
    (left, balance)
}

#[test]
fn offsets_are_removed_up_to_their_limit() {
    // Of ten windows, each removes a quarter of what is left, down to 0.2 σ.
    let (left, balance) = removed([0.15, 0.0, -0.1], |_| 10.0);
    assert!(left.iter().all(|left| left.abs() < 0.021), "{left:?}");
    let [a, b, c] = balance.removed_a();
    assert!((a - 0.15).abs() < 0.03 && b.abs() < 0.03 && (c + 0.1).abs() < 0.03, "{:?}", balance.removed_a());
    assert_eq!(balance.imbalance(), None);
    // Beyond 2 σ it stays refused whatever was removed.
    let (left, balance) = removed([0.45, 0.0, 0.0], |_| 10.0);
    assert!((left[0] - 0.25).abs() < 1e-3, "{left:?}");
    let imbalance = balance.imbalance();
    assert!(matches!(imbalance, Some(Imbalance::Offset { phase: Phase::A, .. })), "{imbalance:?}");
}

/// A single window is disturbed by a change of the load.
#[test]
fn a_window_removes_a_quarter_of_the_offset_that_it_has_measured() {
    let mut balance = CurrentBalance::new(LIMITS);
    for k in 0..=u32::from(LIMITS.window) {
        let electrical = Angle::from_counts(k % 16, 4);
        let [a, b, c] = three(10.0, f64::from(electrical.radians())).map(|i| i as f32);
        balance.push(Abc { a: a + 0.16, b, c }, electrical, electrical.sin_cos());
    }
    let [a, b, c] = balance.remove_offsets();
    assert!((a - 0.04).abs() < 1e-3 && b.abs() < 1e-3 && c.abs() < 1e-3, "{a} {b} {c}");
    assert_eq!(balance.removed_a(), [a, b, c]);
}

#[test]
fn currents_without_an_offset_are_left_alone_however_they_vary() {
    // Slowly, at the frequency of the electrical turn and beside it, and through zero.
    for current in [
        |turn: f64| 10.0 + 3.0 * (0.3 * turn).sin(),
        |turn: f64| 10.0 + 2.0 * (5.9 * turn).sin(),
        |turn: f64| 10.0 * (0.11 * turn).sin(),
        |_| 10.0,
    ] {
        let (left, balance) = removed([0.0; 3], current);
        // 0.2 σ are 0.02 A: a quarter of it is the least step.
        assert_eq!((left, balance.removed_a()), ([0.0; 3], [0.0; 3]));
    }
}

#[test]
fn a_vector_that_does_not_turn_with_the_rotor_is_misaligned() {
    let seen = |angle_of: fn(f64) -> f64, order: [usize; 3], amplitude: f64| {
        finding(amplitude, 100.0, [1.0; 3], move |amplitude, angle| {
            let i = three(amplitude, angle_of(angle));
            order.map(|phase| i[phase])
        })
    };
    let misaligned = Some(Imbalance::Misaligned);
    assert_eq!(seen(|angle| angle, [0, 2, 1], 10.0), misaligned, "two phases exchanged");
    assert_eq!(seen(|angle| -angle, [0, 1, 2], 10.0), misaligned, "angle reversed");
    assert_eq!(seen(|angle| angle * 5.0 / 6.0, [0, 1, 2], 10.0), misaligned, "five of six pole pairs");
    let still = seen(|_| 0.5, [0, 1, 2], 10.0);
    assert!(matches!(still, Some(Imbalance::Offset { .. })), "a current that stands still: {still:?}");
    // σ² is 0.01 A², of which the noise of the three sensors is a third; without a current only that is left.
    assert_eq!([0.12, 0.05, 0.0].map(|a| seen(|angle| angle, [0, 2, 1], a)), [misaligned, None, None]);
}

/// Windows of a drive of 320 samples each: the current, whether phases are exchanged, and a noise in the place of
/// 0.05 A.
fn alignment(amplitude: f64, exchanged: bool, noise_a: f64, offset: f64, windows: u32) -> Alignment {
    let mut balance = CurrentBalance::new(LIMITS);
    let mut state = 1_u32;
    let mut noise = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        noise_a * 12_f64.sqrt() * (f64::from(state >> 8) / f64::from(1_u32 << 24) - 0.5)
    };
    for k in 0..=320 * windows {
        let turn = f64::from(k) / 15.9;
        let angle = core::f64::consts::TAU * turn;
        let [a, b, c] = three(amplitude, if exchanged { -angle } else { angle }).map(|i| (i + noise()) as f32);
        let electrical = Angle::from_bits((turn.fract() * 4_294_967_296.0) as u32);
        let _ = balance.push(Abc { a: a + offset as f32, b, c }, electrical, electrical.sin_cos());
    }
    balance.alignment()
}

#[test]
fn noise_and_offsets_do_not_tell_an_alignment() {
    // As large as the noise of a vector of three sensors, and far below what the limits say of the noise.
    assert_eq!(alignment(0.06, false, 0.05, 0.0, 1), Alignment::Aligned);
    assert_eq!(alignment(0.12, true, 0.05, 0.0, 1), Alignment::Misaligned);
    // Sensors of a motor that coasts: noise of any size, and an offset within its limit.
    for (noise_a, offset) in [(0.05, 0.0), (0.03, 0.0), (0.001, 0.19), (0.05, 0.1)] {
        assert_eq!(alignment(0.0, false, noise_a, offset, 7), Alignment::Undecided, "{noise_a} {offset}");
        assert_eq!(alignment(0.0, false, noise_a, offset, 8), Alignment::Unknown, "{noise_a} {offset}");
    }
}

#[test]
fn a_misalignment_ends_with_the_fourth_window_that_is_aligned() {
    let mut balance = CurrentBalance::new(LIMITS);
    let mut window = |backward: bool| {
        for k in 0..320_u32 {
            let angle = core::f64::consts::TAU * f64::from(k) / 16.0;
            let [a, b, c] = three(10.0, if backward { -angle } else { angle }).map(|i| i as f32);
            let electrical = Angle::from_bits((k + 1).wrapping_mul(1 << 28));
            let _ = balance.push(Abc { a, b, c }, electrical, electrical.sin_cos());
        }
        (balance.imbalance(), balance.alignment() == Alignment::Aligned)
    };
    let (wrong, right) = ((Some(Imbalance::Misaligned), false), (None, true));
    let windows = [false, true, false, false, false, false, false].map(&mut window);
    assert_eq!(windows, [right, wrong, wrong, wrong, wrong, right, right]);
}

#[test]
fn field_oriented_currents_are_aligned() {
    // A load that changes its sign, field weakening with a load of any sign, and maximum torque per ampere.
    let axes: [fn(f64) -> (f64, f64); 4] = [
        |angle| (0.0, 10.0 * (0.07 * angle).sin()),
        |angle| (-10.0, 14.1 * (0.07 * angle).sin()),
        |angle| (-3.0, 10.0 * (0.3 * angle).sin()),
        |angle| (-4.0 * (0.07 * angle).sin().abs(), 10.0 * (0.07 * angle).sin()),
    ];
    for (case, axes) in axes.into_iter().enumerate() {
        let imbalance = finding(1.0, 100.0, [1.0; 3], |_, angle| {
            let (d, q) = axes(angle);
            [0.0, 1.0, 2.0].map(|k| {
                let phase = angle - k * core::f64::consts::TAU / 3.0;
                d * phase.cos() - q * phase.sin()
            })
        });
        assert_eq!(imbalance, None, "{case}");
    }
}

#[test]
fn of_two_sensors_offset_and_direction_are_found() {
    let seen = |offset: f64, order: [usize; 2]| {
        finding(10.0, 100.0, [1.0; 3], move |amplitude, angle| {
            let i = three(amplitude, angle);
            let [a, b] = order.map(|phase| i[phase]);
            [a + offset, b, -(a + offset + b)]
        })
    };
    assert_eq!(seen(0.0, [1, 0]), Some(Imbalance::Misaligned));
    // Its own, and that of the sum in its place; noise of three sensors is in it as above.
    let shifted = seen(0.5, [0, 1]);
    assert!(matches!(shifted, Some(Imbalance::Offset { phase: Phase::A | Phase::C, .. })), "{shifted:?}");
}

#[test]
fn nothing_is_concluded_at_standstill_or_from_missing_samples() {
    assert_eq!(finding(10.0, 0.05, [1.0, 0.0, 1.0], three), None);
    assert_eq!(finding(f64::NAN, 100.0, [1.0; 3], three), None);
}

#[test]
fn a_shaft_that_swings_where_a_phase_has_no_current_has_no_open_phase() {
    let mut balance = CurrentBalance::new(LIMITS);
    let mut push = |turn: f64, amplitude: f64| {
        let [a, b, c] = three(amplitude, core::f64::consts::TAU * turn).map(|i| i as f32);
        let electrical = Angle::from_bits((turn.rem_euclid(1.0) * 4_294_967_296.0) as u32);
        balance.push(Abc { a, b, c }, electrical, electrical.sin_cos())
    };
    // Twenty turns, a window, and then a spring: its current at angle zero, where phase a carries none, and hardly
    // any at the other end of the swing.
    let turns = (0..=320_u16).filter(|k| push(f64::from(*k) / 16.0, 10.0)).count();
    let swings = (0..=960_u16).filter(|k| if k % 2 == 0 { push(0.0, 10.0) } else { push(0.0725, 0.5) }).count();
    assert_eq!((turns, swings), (1, 3), "windows");
    assert_eq!((balance.imbalance(), balance.unbalanced_windows()), (None, 0));
}

#[test]
fn without_current_only_the_noise_limits_a_product() {
    // 0.1²/3 A² without a current; with one, twice the tolerance of its square and six deviations more.
    let balance = CurrentBalance::new(LIMITS);
    assert!(balance.follows(0.0034, 0.0, 10.0) && !balance.follows(0.0033, 0.0, 10.0));
    let limit = 0.04 * 10.0 + 0.1 * (0.1 / 3.0 + 6.0);
    assert!(balance.follows(-1.01 * limit, 10.0, 10.0) && !balance.follows(0.99 * limit, 10.0, 10.0));
}

#[test]
fn two_phases_that_explain_the_sum_alike_are_not_named() {
    let named = |first: f32, later: f32| {
        let products = [first, later, 0.0].map(libm::sqrtf);
        matches!(super::named([1.0, 0.0], products, [1.0; 3], 0.5), Imbalance::Gain { phase: Phase::A, .. })
    };
    assert!(named(0.9, 0.6) && !named(0.9, 0.8));
}

#[test]
fn an_alignment_that_was_told_stays_and_one_that_is_unknown_is_told_later() {
    let mut balance = CurrentBalance::new(LIMITS);
    let mut windows = |amplitude_a: f64, count: u32| {
        for k in 1..=count * u32::from(LIMITS.window) {
            let electrical = Angle::from_counts(k % 16, 4);
            let [a, b, c] = three(amplitude_a, f64::from(electrical.radians())).map(|i| i as f32);
            balance.push(Abc { a, b, c }, electrical, electrical.sin_cos());
        }
        balance.alignment()
    };
    assert_eq!([windows(0.0, 7), windows(0.0, 1)], [Alignment::Undecided, Alignment::Unknown]);
    assert_eq!([windows(10.0, 1), windows(0.0, 20)], [Alignment::Aligned; 2]);
}
