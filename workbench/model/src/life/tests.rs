use std::f64::consts::{PI, TAU};

use super::*;

/// A deep-groove bearing 6204 of the catalogue, with its nine balls or eight.
const BEARING_6204: LoadedBearing = LoadedBearing {
    rating_n: 13_500.0,
    rolling: Rolling::Balls,
    constant_n: 0.0,
    by_torque: None,
    outer_order: Some(3.05),
};

/// A trace of these angles, turns, and load torques at 100 Hz.
fn trace(turns: &[f64], load: impl Fn(usize) -> f64) -> Trace {
    let zeros = vec![0.0; turns.len()];
    let motion = MotionTrace {
        current_a: (0..turns.len()).map(|k| load(k) / 2.0).collect(),
        velocity_rad_s: zeros.clone(),
        load_nm: (0..turns.len()).map(load).collect(),
        angle_rad: turns.iter().map(|turn| turn * TAU).collect(),
        reference_rad_s: vec![],
    };
    Trace { interval_s: Some(0.01), y: zeros, motion: Some(motion), ..Trace::default() }
}

fn turning(samples: usize, by: f64) -> Vec<f64> {
    (0..samples).map(|k| k as f64 * by).collect()
}

fn of(bearing: LoadedBearing, traces: &[Trace]) -> Collective {
    let mut collective = Collective::new(bearing);
    traces.iter().for_each(|trace| collective.take(trace));
    collective
}

/// The worked example of catalogues: C = 13.5 kN, P = 1 kN, 1500 rpm: 13.5³ = 2460.375 million turns, 27 337.5 h.
#[test]
fn a_constant_load_and_speed() {
    // 1500 rpm are a quarter of a turn in 0.01 s.
    let bearing = LoadedBearing { constant_n: 1000.0, ..BEARING_6204 };
    let collective = of(bearing, &[trace(&turning(40_001, 0.25), |_| 0.0)]);
    let life = collective.life().expect("turns");
    assert!((life.turns / 2_460.375e6 - 1.0).abs() < 1e-9, "{life:?}");
    assert!((life.mean_load_n - 1000.0).abs() < 1e-6, "{life:?}");
    // 10 000 turns less the play, in one sample more than there are steps.
    assert!((life.hours.expect("a time") / 27_337.5 - 1.0).abs() < 1e-4, "{life:?}");
    assert!((life.used / (10_000.0 / 2_460.375e6) - 1.0).abs() < 1e-6, "{life:?}");
    let words = collective.lines()[0].clone();
    assert!(words.contains("2 460 million turns or 27 338 h") && words.contains("4.1e-4 % of it used"), "{words}");
}

/// C = 25 kN, P = 2.5 kN: 10^(10/3) = 2154.43 million turns.
#[test]
fn rollers_have_their_exponent() {
    let rollers = LoadedBearing { rating_n: 25e3, rolling: Rolling::Rollers, constant_n: 2500.0, ..BEARING_6204 };
    let life = of(rollers, &[trace(&turning(100, 0.1), |_| 0.0)]).life().expect("turns");
    assert!((life.turns / 2_154.434_69e6 - 1.0).abs() < 1e-8, "{life:?}");
}

/// 40 % of the turns at 2 kN and 60 % at 0.5 kN: (0.4 · 8 + 0.6 · 0.125)^(1/3) = 1.485 064 kN; the torque's sign does
/// not matter, nor the direction of the turns, nor from what the torque is taken.
#[test]
fn a_load_collective_has_the_cubic_mean() {
    let forth = turning(1001, 0.01);
    let back: Vec<f64> = forth.iter().map(|turn| -1.5 * turn).collect();
    let traces = [trace(&forth, |_| 20.0), trace(&back, |_| -5.0)];
    for torque in [Torque::Sensor, Torque::Current(2.0)] {
        let collective = of(LoadedBearing { by_torque: Some((100.0, torque)), ..BEARING_6204 }, &traces);
        let life = collective.life().expect("turns");
        // The play of 0.0005 in 10 turns and in 15.
        assert!((life.mean_load_n / 1485.064 - 1.0).abs() < 1e-4, "{life:?}");
        let classes: Vec<_> = collective.classes().filter(|class| class.2 > 0.0).collect();
        assert_eq!(classes.iter().map(|class| class.2.round()).collect::<Vec<_>>(), [15.0, 10.0]);
        assert!((classes[0].0 - 13_500.0 / 32.0).abs() < 1e-9 && (classes[1].0 - 13_500.0 / 8.0).abs() < 1e-9);
        // Miner: the parts of both traces add up.
        let parts: f64 = traces
            .iter()
            .map(|trace| of(collective.bearing, std::slice::from_ref(trace)).life().expect("turns").used)
            .sum();
        assert!((parts / life.used - 1.0).abs() < 1e-9, "{parts}");
    }
}

/// A load that rises evenly from nothing over the turns has the mean (1/4)^(1/3) of its largest.
#[test]
fn a_rising_load_has_its_integral() {
    let bearing = LoadedBearing { by_torque: Some((100.0, Torque::Sensor)), ..BEARING_6204 };
    let life = of(bearing, &[trace(&turning(20_001, 0.01), |k| k as f64 / 1000.0)]).life().expect("turns");
    assert!((life.mean_load_n / (2000.0 * 0.25_f64.cbrt()) - 1.0).abs() < 1e-4, "{life:?}");
}

/// Harris: a shaft that swings by 90° to and fro reaches 180/90 times as many swings as turns; by 36° none of it is of
/// full paths, as neighbouring balls are 360°/3.05 = 118° of the shaft apart.
#[test]
fn swings_count_as_their_travel_and_short_ones_are_told() {
    let swinging =
        |turns: f64| -> Vec<f64> { (0..=20_000).map(|k| turns / 2.0 * (PI * f64::from(k) / 100.0).cos()).collect() };
    let bearing = LoadedBearing { constant_n: 1000.0, ..BEARING_6204 };
    for (swing, is_short) in [(0.5, false), (0.1, true)] {
        let collective = of(bearing, &[trace(&swinging(swing), |_| 0.0)]);
        // 100 swings to and fro, each 2 ψ less the play of its ends.
        let travel = 200.0 * (swing - 2.0 * PLAY);
        assert!((collective.turns - travel).abs() < 0.01, "{collective:?}");
        let life = collective.life().expect("turns");
        let swings = life.turns / (collective.turns / 100.0);
        assert!((swings / (life.turns * 0.5 / swing) - 1.0).abs() < 0.02, "{life:?}");
        assert_eq!(collective.short.0 > 99.0, is_short, "{collective:?}");
        assert!(!is_short || (collective.short.1 - collective.turns).abs() < 0.01, "{collective:?}");
        let told = collective.lines().concat();
        assert_eq!(told.contains("swings of less than 118°"), is_short, "{told}");
    }
}

#[test]
fn noise_at_rest_is_no_motion_and_a_wrapped_angle_goes_on() {
    let bearing = LoadedBearing { constant_n: 1000.0, ..BEARING_6204 };
    let noise: Vec<f64> = (0..1000).map(|k| 0.0004 * f64::from(k % 2)).collect();
    let still = of(bearing, &[trace(&noise, |_| 0.0)]);
    assert!(still.life().is_none() && still.short.0 == 0.0, "{still:?}");
    let wrapped: Vec<f64> = turning(1001, 0.31).iter().map(|turn| turn.fract()).collect();
    let collective = of(bearing, &[trace(&wrapped, |_| 0.0)]);
    assert!((collective.turns - 310.0).abs() < 0.01 && collective.fast == 0, "{collective:?}");
    let fast = of(bearing, &[trace(&turning(1001, 0.45), |_| 0.0)]);
    assert!(fast.fast == 1000 && fast.lines().concat().contains("record it faster"), "{fast:?}");
}

#[test]
fn what_is_missing_or_out_of_range_is_told() {
    let bearing = LoadedBearing { outer_order: None, by_torque: Some((100.0, Torque::Sensor)), ..BEARING_6204 };
    let gone = |k: usize| if k < 500 { f64::NAN } else { 90.0 };
    let collective = of(bearing, &[trace(&turning(1001, 0.1), gone)]);
    assert!((collective.turns - 50.0).abs() < 0.2 && (collective.without_load - 50.0).abs() < 0.2, "{collective:?}");
    let told = collective.lines().concat();
    for part in ["above C/2", "no torque", "geometry"] {
        assert!(told.contains(part), "{part}: {told}");
    }
    let untimed = Trace { interval_s: None, ..trace(&turning(100, 0.1), |_| 5.0) };
    assert_eq!(of(bearing, &[untimed]).life().expect("turns").hours, None);
    assert!(of(bearing, &[]).lines()[0].starts_with("no nominal life"));
}
