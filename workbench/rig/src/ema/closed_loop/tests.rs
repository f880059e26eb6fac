use core::f64::consts::TAU;

use bearing_watch::drive::{Abc, RotorFrame};
use bearing_watch::{Angle, Park};

use super::*;
use crate::ema::{Actuator, EmaCondition, EmaDefect, EmaLoad, EmaState, Logging, Race, SensorErrors};
use crate::{DefectKind, Waveform, trace_seed};

/// Exact sensors, no fluctuation of the load.
const QUIET: EmaScenario = EmaScenario {
    sensors: SensorErrors { resolver_bits: 30, ..SensorErrors::QUIET },
    load_fluctuation_n: 0.0,
    ..EmaScenario::STANDARD
};

/// A slow triangle: ± 8 mm/s, 13 rad/s, upwards for 2.5 s.
const SLOW: EmaScenario =
    EmaScenario { command: Waveform::Triangle, amplitude_m: 0.02, frequency_hz: 0.1, rows: 2400, ..QUIET };

/// 3700 lbf.
const RATED_N: f64 = 3700.0 * 4.448_221_615;

/// Mean current of the second second of a run.
fn mean_current(scenario: &EmaScenario) -> f64 {
    let trace = simulate(scenario, 1).expect("valid");
    trace.current_a[1200..].iter().sum::<f64>() / 1200.0
}

#[test]
fn rated_force_needs_rated_current_in_steady_motion_and_less_at_standstill() {
    let rated = EmaScenario { load: EmaLoad::Constant { force_n: RATED_N }, ..SLOW };
    let screw = RATED_N * 3.81e-3 / TAU;
    let kt = 1.5 * 6.0 * 0.0559;
    let omega = 4.0 * 0.02 * 0.1 * TAU / 3.81e-3;
    let smooth = Actuator { viscous_nm_s_per_rad: 0.0, coulomb_nm: 0.0, ..Actuator::MAXFORCE };
    // With the friction of the screw alone: 15.6 A rms of Table 5.1; λ is rounded to 0.1 %.
    let driving = mean_current(&EmaScenario { actuator: smooth, ..rated });
    assert!((driving / (15.6 * 2.0_f64.sqrt()) - 1.0).abs() < 1.5e-3, "{driving}");
    // The settling of the loops (exp(−25 t) from 1 s on) and the friction's tanh(13) are below 1e-9.
    let close = |current: f64, torque: f64| assert!((current - torque / kt).abs() < 1e-6, "{current} {}", torque / kt);
    close(driving, screw / 0.9);
    close(mean_current(&rated), screw / 0.9 + 0.25 + 2e-3 * omega);
    let down = EmaScenario { amplitude_m: -0.02, ..rated };
    close(mean_current(&down), screw * (2.0 - 1.0 / 0.9) - 0.25 - 2e-3 * omega);
    let still = mean_current(&EmaScenario { frequency_hz: 0.0, ..rated });
    close(still, screw);
    assert!((still - 19.8).abs() < 0.05, "{still}");
}

/// Powers in a state: electrical, copper, friction, load.
fn powers(x: &EmaState, (v, external_n): (DqVoltage, f64), scenario: &EmaScenario) -> [f64; 4] {
    let a = scenario.defect.actuator(&scenario.actuator.at_temperature(scenario.temperature));
    let load_n = external_n + scenario.load.springs_n_per_m() * x.position_m;
    let pulses = scenario.defect.pulses(&scenario.bearing).at(x.angle_rad);
    let metres_per_rad = a.lead_m / TAU;
    let dry = a.coulomb_nm + pulses + (1.0 / a.efficiency - 1.0) * metres_per_rad * load_n.abs();
    let dry_w = x.velocity_rad_s * x.velocity_rad_s.tanh() * dry;
    [
        1.5 * (v.d_v * x.direct_a + v.q_v * x.quadrature_a),
        1.5 * a.r_ohm * (x.direct_a.powi(2) + x.quadrature_a.powi(2)),
        a.viscous_nm_s_per_rad * x.velocity_rad_s.powi(2) + dry_w,
        load_n * metres_per_rad * x.velocity_rad_s,
    ]
}

/// Magnetic and kinetic energy; the springs count as load.
fn stored_j(x: &EmaState, scenario: &EmaScenario) -> f64 {
    let a = &scenario.actuator;
    0.75 * a.l_h * (x.direct_a.powi(2) + x.quadrature_a.powi(2)) + 0.5 * a.inertia_kg_m2() * x.velocity_rad_s.powi(2)
}

#[test]
fn electrical_energy_is_losses_and_work_and_change_of_stored_energy() {
    let defect = EmaDefect::of(DefectKind::SpallAndRoughness, 1.0, Race::Inner);
    for name in ["moog-2-mix", "moog-3", "moog-5-mix", "rit-mix", "rit"] {
        let condition = EmaCondition::named(name).expect("known");
        let scenario = EmaScenario { defect, ..condition.scenario(9) };
        let mut run = Experiment::new(&scenario, 9).expect("valid");
        let start = run.plant.state();
        let [mut electrical, mut copper, mut friction, mut load] = [0.0; 4];
        let step_s = scenario.drive.interval_s / f64::from(run.inner_steps);
        for k in 0..18_000 {
            let t_s = scenario.drive.interval_s * f64::from(k);
            let (_, applied) = run.decide(&scenario, t_s).expect("finite");
            let mut before = run.plant.state();
            run.advance(t_s, applied, |[from, to], plant| {
                // The trapezoidal rule.
                for (x, force) in [(before, from), (plant.state(), to)] {
                    let power = powers(&x, (applied, force), &scenario);
                    let sums = [&mut electrical, &mut copper, &mut friction, &mut load];
                    sums.into_iter().zip(power).for_each(|(sum, power_w)| *sum += 0.5 * step_s * power_w);
                }
                before = plant.state();
            });
        }
        let change = stored_j(&run.plant.state(), &scenario) - stored_j(&start, &scenario);
        let rest = electrical - copper - friction - load - change;
        println!("{name}: {electrical} J = {copper} + {friction} + {load} + {change} + {rest}");
        // The trapezoidal rule has (h/τ)²/12 = 6e-4 of the energy that the current loop (τ = 0.5 ms) moves at its steps
        // and its noise, which is a small part of all energy.
        let scale = copper + friction + load.abs();
        assert!(rest.abs() < 3e-5 * scale && electrical.abs() > 10.0, "{name} {rest} {scale}");
    }
}

#[test]
fn rows_are_samples_of_the_controller() {
    let fast = EmaScenario { logging: Logging { every: 1, hold: 1 }, rows: 1200, ..EmaScenario::STANDARD };
    let slow = EmaScenario { logging: Logging { every: 10, hold: 1 }, rows: 120, ..EmaScenario::STANDARD };
    let held = EmaScenario { logging: Logging { every: 10, hold: 3 }, rows: 120, ..EmaScenario::STANDARD };
    let [fast, slow, held] = [fast, slow, held].map(|scenario| simulate(&scenario, 6).expect("valid").recorded());
    for ((full, (name, tenth)), (_, kept)) in fast.iter().zip(&slow).zip(&held) {
        assert_eq!((full.1.len(), tenth.len(), kept.len()), (1200, 120, 120));
        for k in 0..120 {
            assert_eq!(tenth[k], full.1[10 * k], "{name}");
            let source = if *name == "t_s" { k } else { k / 3 * 3 };
            assert_eq!(kept[k], tenth[source], "{name}");
        }
    }
    let names: Vec<&str> = fast.iter().map(|(name, _)| *name).collect();
    assert_eq!(names.len(), 17);
    assert_eq!(names.iter().collect::<std::collections::HashSet<_>>().len(), 17);
}

#[test]
fn the_core_computes_the_same_currents_from_phases_and_counts() {
    let frame = RotorFrame { pole_pairs: 6, electrical_offset: Angle::ZERO, park: Park::Standard };
    let trace = simulate(&EmaScenario { rows: 1200, ..EmaScenario::STANDARD }, 2).expect("valid");
    for k in 0..trace.len() {
        let [a, b, c] = [&trace.phase_a_a, &trace.phase_b_a, &trace.phase_c_a].map(|phase| phase[k] as f32);
        let dq = frame.transform(Abc { a, b, c }.clarke(), Angle::from_counts(trace.resolver_counts[k], 14));
        // Single precision of currents of up to 15 A: a few roundings of 1e-6.
        assert!((f64::from(dq.q) - trace.current_a[k]).abs() < 1e-5);
        assert!((f64::from(dq.d) - trace.current_d_a[k]).abs() < 1e-5);
    }
}

#[test]
fn the_bridge_applies_its_voltage_at_the_measured_angle() {
    // Coarse angles: a count of 8 bits is 0.15 rad of electrical angle.
    let coarse = EmaScenario { sensors: SensorErrors { resolver_bits: 8, ..SensorErrors::QUIET }, ..QUIET };
    let mut run = Experiment::new(&coarse, 4).expect("valid");
    let mut largest: f64 = 0.0;
    for k in 0..2000 {
        let t_s = f64::from(k) / 12_000.0;
        let angle = run.plant.state().angle_rad;
        let (row, applied) = run.decide(&coarse, t_s).expect("finite");
        let measured = TAU * f64::from(row.resolver_counts) / 256.0;
        // The phase voltage along phase a, from the command at the measured and from the voltage at the true angle.
        let along_a = |v: DqVoltage, theta: f64| v.d_v * (6.0 * theta).cos() - v.q_v * (6.0 * theta).sin();
        let command = DqVoltage { d_v: row.voltage_d_v, q_v: row.voltage_q_v };
        // Rounding of sines of up to 400 rad.
        assert!((along_a(command, measured) - along_a(applied, angle)).abs() < 1e-10, "{k}");
        largest = largest.max((command.q_v - applied.q_v).abs());
        run.advance(t_s, applied, |_, _| {});
    }
    assert!(largest > 0.1, "{largest}");
}

#[test]
fn the_same_seed_repeats_and_every_other_differs() {
    let run = |scenario: &EmaScenario, seed| simulate(scenario, seed).expect("valid");
    let short = EmaScenario { rows: 200, ..EmaScenario::MOOG };
    let seeds = [(1, DefectKind::Healthy, 0), (1, DefectKind::Healthy, 1), (2, DefectKind::Healthy, 0)];
    let traces = seeds.map(|(set, kind, k)| run(&short, trace_seed(set, kind, k)));
    assert_eq!(traces[0], run(&short, trace_seed(1, DefectKind::Healthy, 0)));
    for (one, other) in [(0, 1), (0, 2), (1, 2)] {
        assert_ne!(traces[one].load_n, traces[other].load_n);
        assert_ne!(traces[one].phase_a_a, traces[other].phase_a_a);
        assert_ne!(traces[one].resolver_counts[0], traces[other].resolver_counts[0]);
    }
    // Without load and fluctuation the first row has noise alone, and each seed its own.
    let still = EmaScenario { load_fluctuation_n: 0.0, rows: 1, ..short };
    let [one, other] = [1, 2].map(|seed| run(&still, seed));
    assert!(one.phase_a_a != other.phase_a_a && one.current_a != other.current_a && one.load_n == other.load_n);
    assert!(one.position_m != other.position_m && one.velocity_rad_s != other.velocity_rad_s);
}

#[test]
fn the_drive_follows_its_command_within_stroke_and_voltage() {
    for condition in EmaCondition::ALL {
        for seed in 0..4 {
            let scenario = condition.scenario(seed);
            let rows = 3 * scenario.rows / 10;
            let trace = simulate(&EmaScenario { rows, ..scenario }, seed).expect("valid");
            let limit = 311.0 / 3.0_f64.sqrt();
            let voltage = |k: usize| trace.voltage_d_v[k].hypot(trace.voltage_q_v[k]);
            let peak = (0..rows).map(voltage).fold(0.0, f64::max);
            assert!(peak <= limit * (1.0 + 1e-12), "{} {seed} {peak}", condition.name);
            // All but the squares stay below the limit.
            let square = scenario.command == Waveform::Square;
            assert!(square || peak < 0.97 * limit, "{} {seed} {peak}", condition.name);
            // Stroke of Table 5.1.
            assert!(trace.position_m.iter().all(|x| x.abs() < 0.0762), "{} {seed}", condition.name);
            // A P loop lags by 1/25 s; the mean of the position is that of the command only over whole periods.
            let error = |k: usize| (trace.position_ref_m[k] - trace.position_m[k]).abs();
            let slope = 4.0 * scenario.amplitude_m * scenario.frequency_hz * core::f64::consts::FRAC_PI_2;
            let allowed = if square { 2.2 * scenario.amplitude_m } else { 1.2 * slope / 25.0 };
            assert!((0..rows).all(|k| error(k) < allowed), "{} {seed}", condition.name);
        }
    }
}

#[test]
fn pulses_appear_in_the_current_with_their_mean_and_at_their_order() {
    let up = EmaScenario { load: EmaLoad::Constant { force_n: 2e3 }, ..SLOW };
    let log = Logging { every: 2, hold: 1 };
    for (race, order) in [(Race::Inner, 5.282_06), (Race::Outer, 3.717_94)] {
        let run = |severity: f64| {
            let defect = EmaDefect::of(DefectKind::Spall, severity, race);
            let scenario = EmaScenario { logging: log, rows: 12_000, ..up.with_defect(defect) };
            let trace = simulate(&scenario, 5).expect("valid");
            (trace.current_a[2400..].to_vec(), trace.angle_rad[2400..].to_vec())
        };
        let ((current, angle), (sound, _)) = (run(1.0), run(0.0));
        let points = current.len() as f64;
        let mean = current.iter().zip(&sound).map(|(i, j)| i - j).sum::<f64>() / points;
        // 0.12 N·m · 0.15/2 over Kt. 1.6 s are 3.4 turns, 18 (13) pulses: the mean of a part of a pulse, and the
        // friction that follows the speed, which is B Δω = 1e-3 N·m at most.
        let expected = 0.12 * 0.075 / 0.5031;
        assert!((mean / expected - 1.0).abs() < 0.12, "{race:?} {mean} {expected}");
        let at = |order: f64| {
            let sums = current.iter().zip(&sound).zip(&angle).fold([0.0; 2], |[re, im], ((i, j), theta)| {
                let (sin, cos) = (order * theta).sin_cos();
                [re + (i - j - mean) * cos, im + (i - j - mean) * sin]
            });
            2.0 * sums[0].hypot(sums[1]) / points
        };
        let [below, above] = [at(0.7 * order), at(1.3 * order)];
        println!("{race:?}: mean {mean} A of {expected}, {} A at the order, {below} and {above} beside it", at(order));
        assert!(at(order) > 4.0 * below.max(above), "{race:?}");
    }
}

#[test]
fn hot_actuators_run_too() {
    let scenario = EmaScenario { temperature: 1.0, ..SLOW };
    let hot = mean_current(&EmaScenario { load: EmaLoad::Constant { force_n: 5e3 }, ..scenario });
    let omega = 4.0 * 0.02 * 0.1 * TAU / 3.81e-3;
    let torque = 5e3 * 3.81e-3 / TAU / 0.9 + 0.25 + 2e-3 * omega;
    // λ − 5 %. Settled to 1e-9.
    assert!((hot - torque / (0.95 * 1.5 * 6.0 * 0.0559)).abs() < 1e-6, "{hot}");
}

#[test]
fn a_loop_that_runs_away_is_an_error_not_a_trace() {
    let wild = EmaScenario { actuator: Actuator { rotor_kg_m2: 1e-12, mass_kg: 0.0, ..Actuator::MAXFORCE }, ..QUIET };
    assert!(matches!(simulate(&wild, 0), Err(RigError::Diverged { .. })));
}

/// FNV-1a of the bits of all columns.
fn hash(trace: &EmaTrace) -> u64 {
    let columns = trace.recorded().into_iter().flat_map(|(_, column)| column);
    let bytes = columns.flat_map(|x| x.to_bits().to_le_bytes());
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3))
}

#[test]
fn a_seed_keeps_its_bits() {
    // Without noise all numbers are computed by the rig and by libm: they are the same on every machine.
    let quiet = |scenario: EmaScenario, kind| EmaScenario {
        sensors: SensorErrors::QUIET,
        load_fluctuation_n: 0.0,
        rows: 2000,
        ..scenario.with_defect(EmaDefect::of(kind, 1.0, Race::Inner))
    };
    for (name, kind, bits) in [
        ("mix", DefectKind::Healthy, 0xadfa_bc61_274a_aa78),
        ("moog-3-mix", DefectKind::SpallAndRoughness, 0xa041_a9fe_901a_e34e),
        ("rit-mix", DefectKind::WeakMagnet, 0xa28b_7c37_30ab_abbf),
    ] {
        let seed = trace_seed(1, kind, 0);
        let scenario = quiet(EmaCondition::named(name).expect("known").scenario(seed), kind);
        let found = hash(&simulate(&scenario, seed).expect("valid"));
        assert_eq!(found, bits, "{name}: {found:#x}");
    }
}
