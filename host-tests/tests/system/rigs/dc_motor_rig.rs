//! The DC motor and its bearing against closed forms.

use host_tests::{difference, peak};
use rig::{
    BearingGeometry, Defect, DefectKind, DefectTorque, Electrical, MotorParameters, Plant, PlantState, Scenario,
    TABLE_2_1, TABLE_2_3, Waveform, simulate,
};

fn plant(motor: &MotorParameters, step_s: f64) -> Plant {
    Plant::new(motor, step_s).expect("valid motor")
}

fn spall(motor: &MotorParameters) -> DefectTorque {
    Defect::full(DefectKind::Spall).torque(motor.kt_nm_per_a, &BearingGeometry::THESIS).expect("valid defect")
}

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
fn a_weak_magnet_turns_faster_unloaded_and_slower_loaded() {
    // ω = (Kt v − R T)/(Kt Ke + R B), i = (B v + Ke T)/(Kt Ke + R B), with Kt and Ke of 0.05 (1 − 0.05 s).
    for severity in [1.0, 0.25] {
        let constant = 0.05 * (1.0 - 0.05 * severity);
        let motor = Defect { kind: DefectKind::WeakMagnet, severity }.motor(&TABLE_2_3);
        for load in [0.0, 0.25] {
            let mut plant = plant(&motor, 1e-4);
            for _ in 0..30_000 {
                plant.step(3.0, |_| load);
            }
            let scale = constant * constant + 0.5 * 1e-4;
            let omega = (constant * 3.0 - 0.5 * load) / scale;
            let current = (1e-4 * 3.0 + constant * load) / scale;
            let state = plant.state();
            // 3 s are 57 time constants (e⁻⁵⁷ is nothing): the rest is rounding, 3e4 steps of 1e-16.
            assert!(
                (state.velocity_rad_s / omega - 1.0).abs() < 1e-11 && (state.current_a / current - 1.0).abs() < 1e-11
            );
            let sound = (0.05 * 3.0 - 0.5 * load) / (0.05 * 0.05 + 0.5 * 1e-4);
            assert_eq!(state.velocity_rad_s > sound, load == 0.0);
        }
    }
}

#[test]
fn a_drive_with_a_weak_magnet_needs_more_current_for_the_same_friction() {
    // A square of no frequency is a constant reference; at rest of all else ω = ref and i = B ω/Kt.
    let constant = Scenario {
        reference_waveform: Waveform::Square,
        reference_frequency_hz: 0.0,
        load_amplitude_nm: 0.0,
        load_fluctuation_nm: 0.0,
        current_noise_a: 0.0,
        velocity_noise_rad_s: 0.0,
        samples: 10_000,
        ..Scenario::STANDARD
    };
    for (kind, kt) in [(DefectKind::Healthy, 0.05), (DefectKind::WeakMagnet, 0.0475)] {
        let trace = simulate(&constant.with_defect(Defect::full(kind)), 1).expect("valid scenario");
        let (velocity, current) = (trace.velocity_rad_s[9999], trace.current_a[9999]);
        // The integrator settles with Ki/(Kp + Ke) = 1.7 1/s: after 20 s e⁻³³ of 40 rad/s, of 40 A.
        assert!((velocity - 40.0).abs() < 1e-10 && (current - 1e-4 * 40.0 / kt).abs() < 1e-10, "{velocity} {current}");
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
