//! The DC-motor rig against closed forms, and against recordings of an independent simulator.
//!
//! The recordings are read from `../shared/data` beside the workspace, or from the folder that
//! `BEARING_WATCH_DATA` names; without them those tests print a line and pass.

use std::path::PathBuf;

use nalgebra::{DMatrix, DVector};
use workbench::rig::{
    BearingGeometry, CurrentFilter, Defect, DefectKind, DefectTorque, Electrical, MotorParameters, Plant, PlantState,
    RigTrace, Scenario, TABLE_2_1, TABLE_2_3, simulate,
};

const CLASSES: [DefectKind; 3] = [DefectKind::Healthy, DefectKind::Spall, DefectKind::Roughness];

fn plant(motor: &MotorParameters, step_s: f64) -> Plant {
    Plant::new(motor, step_s).expect("valid motor")
}

fn run(scenario: &Scenario, seed: u64) -> RigTrace {
    simulate(scenario, seed).expect("valid scenario")
}

fn spall(motor: &MotorParameters) -> DefectTorque {
    Defect::full(DefectKind::Spall).torque(motor.kt_nm_per_a, &BearingGeometry::THESIS).expect("valid defect")
}

fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len() as f64
}

fn deviation(x: &[f64]) -> f64 {
    let centre = mean(x);
    (x.iter().map(|v| (v - centre).powi(2)).sum::<f64>() / (x.len() - 1) as f64).sqrt()
}

fn difference(x: &[f64], y: &[f64]) -> Vec<f64> {
    x.iter().zip(y).map(|(a, b)| a - b).collect()
}

fn peak(x: impl IntoIterator<Item = f64>) -> f64 {
    x.into_iter().fold(0.0, |most, v| v.abs().max(most))
}

// ---- the motor against closed forms ------------------------------------------------------

#[test]
fn steady_state_balances_voltage_and_torque() {
    for (motor, step_s) in [(TABLE_2_1, 1e-4), (TABLE_2_3, 1e-4)] {
        let (v, load) = (3.0, 0.04);
        let mut plant = plant(&motor, step_s);
        for _ in 0..30_000 {
            plant.step(v, |_| load);
        }
        let (kt, ke, r, b) = (motor.kt_nm_per_a, motor.ke_v_s_per_rad, motor.r_ohm, motor.b_nm_s_per_rad);
        let omega = (kt * v - r * load) / (kt * ke + r * b);
        let current = (b * v + ke * load) / (kt * ke + r * b);
        // 3 s are ≥ 60 time constants (e⁻⁶⁰ is nothing): the rest is rounding, 3e4 steps of 1e-16.
        assert!((plant.state().velocity_rad_s / omega - 1.0).abs() < 1e-11);
        assert!((plant.state().current_a / current - 1.0).abs() < 1e-11);
    }
}

#[test]
fn energy_is_neither_made_nor_lost() {
    // ∫v i = Δ(½ L i² + ½ J ω²) + ∫R i² + ∫B ω² + ∫T ω + ∫(Ke − Kt) ω i, over 20 s of excitation.
    // Inputs are held over two steps, so that Simpson's rule sees smooth integrands.
    let motor = TABLE_2_1;
    let h = 2e-5;
    let mut plant = plant(&motor, h);
    assert_eq!(plant.electrical(), Electrical::BothStates);
    let (mut supplied, mut spent) = (0.0, 0.0);
    for k in 0..500_000 {
        let t = 2.0 * h * f64::from(k);
        let v = 0.8 * (7.0 * t).sin() + 0.5 * (90.0 * t).sin().signum();
        let load = 0.02 * (3.0 * t).cos();
        let powers = |s: &PlantState| {
            let (i, w) = (s.current_a, s.velocity_rad_s);
            let coupling = (motor.ke_v_s_per_rad - motor.kt_nm_per_a) * w * i;
            (v * i, motor.r_ohm * i * i + motor.b_nm_s_per_rad * w * w + load * w + coupling)
        };
        let first = powers(&plant.state());
        let middle = powers(plant.step(v, |_| load));
        let last = powers(plant.step(v, |_| load));
        supplied += h / 3.0 * (first.0 + 4.0 * middle.0 + last.0);
        spent += h / 3.0 * (first.1 + 4.0 * middle.1 + last.1);
    }
    let end = plant.state();
    let stored = 0.5 * (motor.l_h * end.current_a.powi(2) + motor.j_kg_m2 * end.velocity_rad_s.powi(2));
    assert!(supplied > 0.1, "the run must move energy: {supplied} J");
    // Simpson on powers (twice the motor's 1160 rad/s): (2320 h)⁴/180 = 3e-8 of the energy.
    assert!(((stored + spent) / supplied - 1.0).abs() < 1e-7, "{stored} {spent} {supplied}");
}

#[test]
fn table_2_1_has_the_poles_of_the_thesis() {
    // Any free response obeys x(k) = a x(k−1) − d x(k−2), with a = 2 e^{σh} cos βh, d = e^{2σh}.
    let h = 1e-4;
    let mut plant = plant(&TABLE_2_1, h);
    plant.set_state(PlantState { current_a: 1.0, ..PlantState::default() });
    let x: Vec<f64> = (0..4).map(|_| plant.step(0.0, |_| 0.0).current_a).collect();
    let det = x[1] * x[1] - x[0] * x[2];
    let a = (x[1] * x[2] - x[0] * x[3]) / det;
    let d = (x[2] * x[2] - x[1] * x[3]) / det;
    let sigma = d.ln() / (2.0 * h);
    let beta = (a / (2.0 * d.sqrt())).acos() / h;
    // The reference values −556 ± 1019j are rounded to whole numbers.
    assert!((sigma + 556.0).abs() < 0.5, "{sigma}");
    assert!((beta - 1019.0).abs() < 0.5, "{beta}");
}

/// ±0.1 V, four half-waves in the 0.1 s of the thesis' model validation.
fn square_wave(t_s: f64) -> f64 {
    if (t_s / 0.025 + 1e-9).floor() % 2.0 == 0.0 { 0.1 } else { -0.1 }
}

#[test]
fn square_wave_response_is_the_exact_hold_solution() {
    // Between edges: x(t) = x∞ + e^{σt}(cos βt I + sin βt/β (A − σI))(x₀ − x∞), A the matrix of i and ω.
    let (m, h) = (TABLE_2_1, 1e-4);
    let [a11, a12] = [-m.r_ohm / m.l_h, -m.ke_v_s_per_rad / m.l_h];
    let [a21, a22] = [m.kt_nm_per_a / m.j_kg_m2, -m.b_nm_s_per_rad / m.j_kg_m2];
    let sigma = 0.5 * (a11 + a22);
    let beta = (a11 * a22 - a12 * a21 - sigma * sigma).sqrt();
    let scale = m.kt_nm_per_a * m.ke_v_s_per_rad + m.r_ohm * m.b_nm_s_per_rad;
    let mut plant = plant(&m, h);
    let (mut edge, mut from) = (0.0, [0.0, 0.0]);
    let mut now = from;
    let (mut v, mut worst) = (square_wave(0.0), 0.0_f64);
    for k in 0..1000 {
        let t = h * f64::from(k);
        if square_wave(t) != v {
            (v, edge, from) = (square_wave(t), t, now);
        }
        plant.step(v, |_| 0.0);
        let rest = [m.b_nm_s_per_rad * v / scale, m.kt_nm_per_a * v / scale];
        let [di, dw] = [from[0] - rest[0], from[1] - rest[1]];
        let tau = t + h - edge;
        let (cos, sin) = ((beta * tau).cos(), (beta * tau).sin() / beta);
        let decay = (sigma * tau).exp();
        now = [
            rest[0] + decay * (cos * di + sin * ((a11 - sigma) * di + a12 * dw)),
            rest[1] + decay * (cos * dw + sin * (a21 * di + (a22 - sigma) * dw)),
        ];
        let state = plant.state();
        worst = worst.max((state.current_a - now[0]).abs()).max((state.velocity_rad_s - now[1]).abs());
    }
    // Both are exact: rounding on values near 1, 1000 steps.
    assert!(worst < 1e-12, "{worst}");
}

/// The Tustin transfer functions Eq. 2.49–2.51 as difference equations; returns (i, ω).
fn tustin(m: &MotorParameters, t: f64, v: &[f64], load: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let (kt, ke, r, l, j, b) = (m.kt_nm_per_a, m.ke_v_s_per_rad, m.r_ohm, m.l_h, m.j_kg_m2, m.b_nm_s_per_rad);
    let (big_m, n) = (b * l + j * r, b * r + ke * kt);
    // T(z+1)Ψ(z), z² first.
    let psi = [
        4.0 * j * l + 2.0 * t * big_m + t * t * n,
        2.0 * t * t * n - 8.0 * j * l,
        4.0 * j * l - 2.0 * t * big_m + t * t * n,
    ];
    // (z+1)(p z + q) and (z+1)², z² first.
    let pair = |p: f64, q: f64| [p, p + q, q];
    let square = [1.0, 2.0, 1.0];
    let from_v = pair(2.0 * j + b * t, b * t - 2.0 * j);
    let from_load = pair(2.0 * l + r * t, r * t - 2.0 * l);
    let tap = |c: &[f64; 3], x: &[f64], k: usize| {
        let past = |lag: usize| if k >= lag { x[k - lag] } else { 0.0 };
        c[0] * past(0) + c[1] * past(1) + c[2] * past(2)
    };
    let (mut i, mut w) = (vec![0.0; v.len()], vec![0.0; v.len()]);
    for k in 0..v.len() {
        let feed_i = t * tap(&from_v, v, k) + ke * t * t * tap(&square, load, k);
        let feed_w = kt * t * t * tap(&square, v, k) - t * tap(&from_load, load, k);
        i[k] = (feed_i - tap(&[0.0, psi[1], psi[2]], &i, k)) / psi[0];
        w[k] = (feed_w - tap(&[0.0, psi[1], psi[2]], &w, k)) / psi[0];
    }
    (i, w)
}

#[test]
fn tustin_transfer_functions_follow_the_motor() {
    let t = 1e-4;
    let samples = 1001_usize;
    // Sample 0 is zero: Tustin joins samples by straight lines, from rest.
    let at = |k: usize, x: f64| if k == 0 { 0.0 } else { x };
    let v: Vec<f64> = (0..samples).map(|k| at(k, square_wave(t * k as f64))).collect();
    let load: Vec<f64> = (0..samples).map(|k| at(k, 0.05 * square_wave(t * k as f64 + 0.0125))).collect();
    let (i, w) = tustin(&TABLE_2_1, t, &v, &load);

    // The motor under the same straight lines (50 held sub-steps), and under the held samples.
    let respond = |sub_steps: u32| -> (Vec<f64>, Vec<f64>) {
        let mut plant = plant(&TABLE_2_1, t / f64::from(sub_steps));
        let (mut i, mut w) = (vec![0.0], vec![0.0]);
        for k in 1..samples {
            for sub in 0..sub_steps {
                let part = (f64::from(sub) + 0.5) / f64::from(sub_steps);
                let part = if sub_steps == 1 { 1.0 } else { part };
                let line = |x: &[f64]| x[k - 1] + (x[k] - x[k - 1]) * part;
                plant.step(line(&v), |_| line(&load));
            }
            i.push(plant.state().current_a);
            w.push(plant.state().velocity_rad_s);
        }
        (i, w)
    };
    let error = |x: &[f64], y: &[f64]| peak(difference(x, y)) / peak(y.iter().copied());

    let (i_line, w_line) = respond(50);
    // Tustin moves a pole λ by λ(λT)²/12, |λT| = 0.116: 1.1e-3 of |λ|, over a decay time 1/|σ| about
    // 2e-3 of the peak; it is no exact method, so it must not vanish either.
    for relative in [error(&i, &i_line), error(&w, &w_line)] {
        assert!((5e-4..4e-3).contains(&relative), "{relative}");
    }
    let (i_held, w_held) = respond(1);
    // Holding the newer sample leads the straight line by T/2, hence by half the largest change a sample,
    // give or take Tustin's own error above and the rounding of corners.
    for (ours, held, line) in [(&i, &i_held, &i_line), (&w, &w_held, &w_line)] {
        let half_change = 0.5 * peak(difference(&line[1..], &line[..samples - 1]));
        let lead = peak(difference(ours, held)) / half_change;
        assert!((0.7..1.3).contains(&lead), "{lead}");
    }
}

#[test]
fn quasi_static_current_is_the_limit_of_small_inductance() {
    // L/R = 50 µs and 25 µs: five and two and a half steps, far below the motor's 50 ms.
    let h = 1e-5;
    let gap = |l_h: f64| {
        let motor = MotorParameters { l_h, ..TABLE_2_3 };
        let law = spall(&motor);
        let mut both = plant(&motor, h);
        let mut quasi = Plant::with_electrical(&motor, h, Electrical::QuasiStatic).expect("valid motor");
        assert_eq!(both.electrical(), Electrical::BothStates);
        let mut gaps = Vec::new();
        for k in 0..100_000 {
            let v = 3.0 * (6.0 * h * f64::from(k)).sin();
            both.step(v, |s| law.at(s));
            quasi.step(v, |s| law.at(s));
            gaps.push(both.state().velocity_rad_s - quasi.state().velocity_rad_s);
        }
        peak(gaps)
    };
    let (coarse, fine) = (gap(2.5e-5), gap(1.25e-5));
    // The current lags by L/R, so ω is off by (L/R)·|dω/dt| at most: 50 µs × (|Δi| Kt + 0.1 N·m)/J < 0.05.
    assert!((1e-4..0.05).contains(&coarse), "{coarse}");
    // First order in L: half the inductance, half the gap; second-order terms are (L/R)/50 ms = 0.1 %,
    // and a pulse passed with another timing may add some.
    assert!((1.8..2.2).contains(&(coarse / fine)), "{coarse} {fine}");
}

#[test]
fn state_dependent_torques_are_second_order_in_the_step_in_both_modes() {
    // The smooth torques, Coulomb drag through a reversal and ripple with the current; the ends of a
    // spall's pulses have a jump in the second derivative, which would blur the order.
    let motor = MotorParameters { l_h: 4.5e-4, ..TABLE_2_3 };
    let ripple = DefectTorque::Spall { pulse_nm: 0.0, ripple_nm_per_a: 1.5e-3, outer_order: 3.7 };
    let drag = DefectTorque::Coulomb { torque_nm: 0.02 };
    let end = |electrical: Electrical, steps: u32| {
        let mut plant = Plant::with_electrical(&motor, 0.2 / f64::from(steps), electrical).expect("valid motor");
        plant.set_state(PlantState { velocity_rad_s: -20.0, ..PlantState::default() });
        for _ in 0..steps {
            plant.step(2.0, |s| ripple.at(s) + drag.at(s));
        }
        plant.state().velocity_rad_s
    };
    for electrical in [Electrical::QuasiStatic, Electrical::BothStates] {
        let truth = end(electrical, 128_000);
        let [coarse, fine] = [1000, 4000].map(|steps| (end(electrical, steps) - truth).abs());
        // A quarter of the step: 16 times less error for order 2, 4 for order 1, 64 for order 3; the next
        // term of the error shifts the factor by a few per cent at most at |λ|h = 0.2.
        assert!((14.0..18.0).contains(&(coarse / fine)), "{electrical:?}: {coarse:e} {fine:e}");
    }
}

// ---- bearing -----------------------------------------------------------------------------

#[test]
fn bearing_orders_are_those_of_the_thesis_geometry() {
    let orders = BearingGeometry::THESIS.orders();
    let published = [3.71794, 5.28206, 0.41310, 2.74776];
    for (ours, theirs) in [orders.outer, orders.inner, orders.cage, orders.ball].iter().zip(published) {
        // Published to five decimals.
        assert!((ours - theirs).abs() < 6e-6, "{ours} {theirs}");
    }
    // A ball passes either the outer or the inner race's point n times a turn: (1) + (2) = n.
    assert!((orders.outer + orders.inner - 9.0).abs() < 1e-14);
}

// ---- seeds, streams, noise levels --------------------------------------------------------

#[test]
fn a_seed_is_a_trace() {
    let scenario = Scenario::STANDARD.with_defect(Defect::full(DefectKind::Spall));
    let trace = run(&scenario, 11);
    assert_eq!(trace, run(&scenario, 11));
    let other = run(&scenario, 12);
    assert_eq!(trace.velocity_ref_rad_s, other.velocity_ref_rad_s);
    assert_ne!(trace.angle_rad[0], other.angle_rad[0]);
    // Independent fluctuations are √2·0.06 N·m apart; a sample sd of 5000 scatters by 1 %, four of them.
    let apart = deviation(&difference(&trace.load_torque_nm, &other.load_torque_nm));
    assert!((apart / (0.06 * 2.0_f64.sqrt()) - 1.0).abs() < 0.042, "{apart}");
    assert_ne!(trace.current_a[0], other.current_a[0]);
    assert_ne!(trace.velocity_rad_s[0], other.velocity_rad_s[0]);
}

#[test]
fn changing_one_noise_leaves_the_other_draws_alone() {
    let standard = Scenario::STANDARD;
    let base = run(&standard, 3);

    let quiet_current = run(&Scenario { current_noise_a: 0.0, ..standard }, 3);
    assert_ne!(base.current_a, quiet_current.current_a);
    assert_eq!(RigTrace { current_a: Vec::new(), ..base.clone() }, RigTrace { current_a: Vec::new(), ..quiet_current });

    let quiet_velocity = run(&Scenario { velocity_noise_rad_s: 0.0, ..standard }, 3);
    assert_eq!(base.load_torque_nm, quiet_velocity.load_torque_nm);
    assert_eq!(base.angle_rad[0], quiet_velocity.angle_rad[0]);
    assert_eq!(base.current_a[0], quiet_velocity.current_a[0]); // the motor is still at rest

    let smooth_load = run(&Scenario { load_fluctuation_nm: 0.0, ..standard }, 3);
    assert_eq!(base.velocity_rad_s[0], smooth_load.velocity_rad_s[0]); // at rest: noise alone
    assert_eq!(base.current_a[0], smooth_load.current_a[0]);
    assert_eq!(base.angle_rad[0], smooth_load.angle_rad[0]);
    assert_ne!(base.load_torque_nm[0], smooth_load.load_torque_nm[0]);
}

fn correlation(x: &[f64], y: &[f64]) -> f64 {
    let (mx, my) = (mean(x), mean(y));
    let cross: f64 = x.iter().zip(y).map(|(a, b)| (a - mx) * (b - my)).sum();
    cross / ((x.len() - 1) as f64 * deviation(x) * deviation(y))
}

#[test]
fn noise_levels_are_the_stated_ones() {
    // Without a controller, runs with and without a noise differ by that noise alone.
    let open = Scenario {
        proportional_gain_v_s_per_rad: 0.0,
        integral_gain_v_per_rad: 0.0,
        samples: 20_000,
        ..Scenario::STANDARD
    };
    let noisy = run(&open, 21);
    let clean =
        run(&Scenario { current_noise_a: 0.0, velocity_noise_rad_s: 0.0, load_fluctuation_nm: 0.0, ..open }, 21);
    let fluctuating = run(&Scenario { current_noise_a: 0.0, velocity_noise_rad_s: 0.0, ..open }, 21);
    let current = difference(&noisy.current_a, &fluctuating.current_a);
    let velocity = difference(&noisy.velocity_rad_s, &fluctuating.velocity_rad_s);
    let load = difference(&noisy.load_torque_nm, &clean.load_torque_nm);
    // sd of a sample sd: 1/√(2n) = 0.5 %; four of them. The load's lag makes 0.5 % into 0.53 %.
    for (noise, sd) in [(&current, 0.130), (&velocity, 0.55), (&load, 0.06)] {
        assert!((deviation(noise) / sd - 1.0).abs() < 0.021, "{} for {sd}", deviation(noise));
        // The mean within four of its deviations, √1.5 wider for the lagged load.
        assert!(mean(noise).abs() < 4.9 * sd / 20_000_f64.sqrt());
    }
    let lag_one = |x: &[f64]| correlation(&x[1..], &x[..x.len() - 1]);
    // Four deviations of a correlation: 4/√n = 0.028. White, white, AR(1) of pole 0.2.
    assert!(lag_one(&current).abs() < 0.028);
    assert!(lag_one(&velocity).abs() < 0.028);
    assert!((lag_one(&load) - 0.2).abs() < 0.028);
    // No stream repeats another's draws.
    for (one, other) in [(&current, &velocity), (&current, &load), (&velocity, &load)] {
        assert!(correlation(one, other).abs() < 0.028);
    }
}

// ---- against the independent simulator ---------------------------------------------------

fn reference_folder() -> Option<PathBuf> {
    let data = std::env::var_os("BEARING_WATCH_DATA")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/data"), PathBuf::from);
    let folder = data.join("dc_motor_reference");
    if folder.is_dir() {
        return Some(folder);
    }
    println!("skipped: no {}", folder.display());
    None
}

/// The numbers of a comma-separated file by column, its first `labels` columns left out.
fn columns(path: &std::path::Path, labels: usize) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(path).expect("readable file");
    let mut columns: Vec<Vec<f64>> = Vec::new();
    for line in text.lines().skip(1) {
        for (place, field) in line.split(',').skip(labels).enumerate() {
            if columns.len() <= place {
                columns.push(Vec::new());
            }
            columns[place].push(field.trim().parse().expect("a number"));
        }
    }
    columns
}

/// Trace `number` of the reference set; four a class, in the order of [`CLASSES`].
fn reference_trace(folder: &std::path::Path, number: usize) -> RigTrace {
    let c = columns(&folder.join(format!("trace_{number:02}.csv")), 0);
    let [t_s, velocity_ref_rad_s, velocity_rad_s, current_a, load_torque_nm, angle_rad] =
        <[Vec<f64>; 6]>::try_from(c).expect("six columns");
    RigTrace { t_s, velocity_ref_rad_s, velocity_rad_s, current_a, load_torque_nm, angle_rad }
}

/// What is left of a recording once the rig has been driven by its measured columns.
struct Replay {
    angle_error_rad: f64,
    velocity_noise: Vec<f64>,
    current_noise: Vec<f64>,
    /// Change of the filtered current over the inner step before each sample.
    filter_slope: Vec<f64>,
}

fn replay(trace: &RigTrace, kind: DefectKind) -> Replay {
    let law = Defect::full(kind).torque(TABLE_2_3.kt_nm_per_a, &BearingGeometry::THESIS).expect("valid defect");
    let mut plant = plant(&TABLE_2_3, 1e-4);
    plant.set_state(PlantState { angle_rad: trace.angle_rad[0], ..PlantState::default() });
    let mut filter = CurrentFilter::new(1e-4);
    let mut out = Replay { angle_error_rad: 0.0, velocity_noise: vec![], current_noise: vec![], filter_slope: vec![] };
    let (mut integral, mut before) = (0.0, 0.0);
    for k in 0..trace.len() - 1 {
        let state = plant.state();
        out.angle_error_rad = out.angle_error_rad.max((state.angle_rad - trace.angle_rad[k]).abs());
        out.velocity_noise.push(trace.velocity_rad_s[k] - state.velocity_rad_s);
        out.current_noise.push(trace.current_a[k] - filter.output_a());
        out.filter_slope.push(filter.output_a() - before);
        let error = trace.velocity_ref_rad_s[k] - trace.velocity_rad_s[k];
        integral += 0.5 * 0.002 * error;
        let v = 0.25 * error + integral;
        for step in 0..20 {
            let part = (f64::from(step) + 0.5) / 20.0;
            let load = trace.load_torque_nm[k] * (1.0 - part) + trace.load_torque_nm[k + 1] * part;
            let current = plant.step(v, |s| load + law.at(s)).current_a;
            before = filter.output_a();
            filter.update(current);
        }
    }
    out
}

#[test]
fn the_loop_is_wired_as_documented() {
    // The replay has its own gains, sampling order and load path; it needs no recording.
    for (seed, kind) in (40..).zip(DefectKind::ALL) {
        let trace = run(&Scenario::STANDARD.with_defect(Defect::full(kind)), seed);
        let outcome = replay(&trace, kind);
        // Rounding alone, of angles up to 1e2 over 1e5 steps.
        assert!(outcome.angle_error_rad < 1e-9, "{kind:?}: {} rad", outcome.angle_error_rad);
        // Four deviations of a sample sd and of a chance correlation at 5000 samples: 4 % and 0.057.
        assert!((deviation(&outcome.velocity_noise) / 0.55 - 1.0).abs() < 0.04);
        assert!((deviation(&outcome.current_noise) / 0.130 - 1.0).abs() < 0.04);
        assert!(correlation(&outcome.current_noise, &outcome.filter_slope).abs() < 0.057);
    }
}

#[test]
fn rig_retraces_the_recordings_of_the_reference_simulator() {
    let Some(folder) = reference_folder() else { return };
    let (mut velocity, mut current, mut slope) = (Vec::new(), Vec::new(), Vec::new());
    for number in 0..12 {
        let kind = CLASSES[number / 4];
        let trace = reference_trace(&folder, number);
        let outcome = replay(&trace, kind);
        // Recordings carry nine digits: up to 5e-8 in the angle, 5e-9 in the velocity, which through Kp
        // moves the voltage by 1e-9 and adds up at random; 5e-6 leaves an order of magnitude.
        assert!(outcome.angle_error_rad < 5e-6, "trace {number}: {} rad", outcome.angle_error_rad);
        velocity.extend(outcome.velocity_noise);
        current.extend(outcome.current_noise);
        slope.extend(outcome.filter_slope);
        // Power of the check: with another defect the angle is lost altogether.
        let other = if kind == DefectKind::Healthy { DefectKind::Spall } else { DefectKind::Healthy };
        assert!(replay(&trace, other).angle_error_rad > 1.0);
    }
    // 60 000 samples: four deviations of a sample sd are 1.2 %.
    assert!((deviation(&velocity) / 0.55 - 1.0).abs() < 0.012, "{}", deviation(&velocity));
    assert!((deviation(&current) / 0.130 - 1.0).abs() < 0.012, "{}", deviation(&current));
    // The filter's timing: 4/√60 000 = 0.016; half an inner step too early or late gives 0.03 or more.
    assert!(correlation(&current, &slope).abs() < 0.016, "{}", correlation(&current, &slope));
}

/// LS parameters and fit (Eq. 3.2) of `A y = B u1 + C u2` with `[na nb nc 1 1]`, by QR in f64.
fn least_squares(y: &[f64], u1: &[f64], u2: &[f64], [na, nb, nc]: [usize; 3]) -> Vec<f64> {
    let start = na.max(nb).max(nc);
    let rows = y.len() - start;
    let x = DMatrix::from_fn(rows, na + nb + nc, |row, column| {
        let t = row + start - 1;
        match column {
            c if c < na => -y[t - c],
            c if c < na + nb => u1[t - (c - na)],
            c => u2[t - (c - na - nb)],
        }
    });
    let qr = x.qr();
    let target = qr.q().tr_mul(&DVector::from_column_slice(&y[start..]));
    let theta = qr.r().solve_upper_triangular(&target).expect("persistent excitation");

    let mut free = vec![0.0; y.len()];
    for t in 0..y.len() {
        let tap = |x: &[f64], lag: usize| if t >= lag { x[t - lag] } else { 0.0 };
        let a: f64 = (0..na).map(|k| -theta[k] * tap(&free, k + 1)).sum();
        let b: f64 = (0..nb).map(|k| theta[na + k] * tap(u1, k + 1)).sum();
        let c: f64 = (0..nc).map(|k| theta[na + nb + k] * tap(u2, k + 1)).sum();
        free[t] = a + b + c;
    }
    let centre = mean(y);
    let missed: f64 = difference(&free, y).iter().map(|e| e * e).sum();
    let whole: f64 = y.iter().map(|v| (v - centre).powi(2)).sum();
    theta.iter().copied().chain([100.0 * (1.0 - (missed / whole).sqrt())]).collect()
}

fn velocity_error(trace: &RigTrace) -> Vec<f64> {
    difference(&trace.velocity_ref_rad_s, &trace.velocity_rad_s)
}

fn reference_model(trace: &RigTrace) -> Vec<f64> {
    least_squares(&trace.current_a, &trace.velocity_ref_rad_s, &trace.load_torque_nm, [2, 1, 2])
}

fn error_model(trace: &RigTrace) -> Vec<f64> {
    least_squares(&trace.current_a, &velocity_error(trace), &trace.load_torque_nm, [2, 2, 2])
}

/// Both models and the sizes of the signals: 17 numbers a trace.
fn statistics(trace: &RigTrace) -> Vec<f64> {
    let mut all = reference_model(trace);
    all.extend(error_model(trace));
    all.push(deviation(&trace.current_a));
    all.push(deviation(&velocity_error(trace)));
    all.push(deviation(&trace.load_torque_nm));
    all.push(peak(trace.current_a.iter().copied()));
    all
}

/// Student's t of two samples, column by column, with a pooled variance.
fn student(ours: &[Vec<f64>], theirs: &[Vec<f64>]) -> Vec<f64> {
    let column = |rows: &[Vec<f64>], k: usize| -> Vec<f64> { rows.iter().map(|row| row[k]).collect() };
    let (n, m) = (ours.len() as f64, theirs.len() as f64);
    (0..ours[0].len())
        .map(|k| {
            let (x, y) = (column(ours, k), column(theirs, k));
            let squares = (n - 1.0) * deviation(&x).powi(2) + (m - 1.0) * deviation(&y).powi(2);
            (mean(&x) - mean(&y)) / (squares / (n + m - 2.0) * (1.0 / n + 1.0 / m)).sqrt()
        })
        .collect()
}

#[test]
fn rig_agrees_statistically_with_the_reference_simulator() {
    let Some(folder) = reference_folder() else { return };
    let published = [("ls_ref_21211.csv", 0..6), ("ls_err_22211.csv", 6..13)];
    let theirs: Vec<Vec<Vec<f64>>> =
        (0..3).map(|class| (0..4).map(|k| statistics(&reference_trace(&folder, 4 * class + k))).collect()).collect();
    for (file, places) in published {
        for (column, place) in columns(&folder.join(file), 1).iter().zip(places) {
            for (trace, value) in column.iter().enumerate() {
                // The published estimates are reproducible to 1e-5: the oracle itself is sound.
                assert!((theirs[trace / 4][trace % 4][place] / value - 1.0).abs() < 1e-5);
            }
        }
    }

    let ours: Vec<Vec<Vec<f64>>> = (0_u64..)
        .zip(CLASSES)
        .map(|(class, kind)| {
            let scenario = Scenario::STANDARD.with_defect(Defect::full(kind));
            (0..20).map(|k| statistics(&run(&scenario, 100 * class + k))).collect()
        })
        .collect();
    let same: Vec<f64> = (0..3).flat_map(|class| student(&ours[class], &theirs[class])).collect();
    // 51 comparisons, 22 degrees of freedom: |t| > 4.5 has a chance of 51 × 1.8e-4 = 0.9 %.
    assert!(peak(same.iter().copied()) < 4.5, "{same:.2?}");
    // t² has mean 1.1; the comparisons are correlated (some ten independent ones), hence the width.
    let square = mean(&same.iter().map(|t| t * t).collect::<Vec<_>>());
    assert!((0.3..2.5).contains(&square), "{square}");
    // Power of the check: the wrong class is off by far more.
    for class in 0..3 {
        let wrong = student(&ours[class], &theirs[(class + 1) % 3]);
        assert!(peak(wrong) > 15.0);
    }
}
