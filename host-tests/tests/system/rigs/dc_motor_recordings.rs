//! The whole DC-motor rig: its noises, its wiring, and recordings of an independent simulator of the same rig.

use host_tests::{columns, data, difference, peak};
use nalgebra::{DMatrix, DVector};
use rig::{
    BearingGeometry, CurrentFilter, Defect, DefectKind, MotorParameters, Plant, PlantState, RigTrace, Scenario,
    TABLE_2_3, simulate, trace_seed,
};

const CLASSES: [DefectKind; 3] = [DefectKind::Healthy, DefectKind::Spall, DefectKind::Roughness];

fn run(scenario: &Scenario, seed: u64) -> RigTrace {
    simulate(scenario, seed).expect("valid scenario")
}

fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len() as f64
}

fn deviation(x: &[f64]) -> f64 {
    let centre = mean(x);
    (x.iter().map(|v| (v - centre).powi(2)).sum::<f64>() / (x.len() - 1) as f64).sqrt()
}

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

#[test]
fn an_old_seed_still_means_its_old_trace() {
    // The last sample of one trace a class, recorded once: velocity, current, load, angle.
    let recorded = [
        (DefectKind::Healthy, [-5.069553608652451, -0.08535017989537746, 0.046507223259923576, 28.17886764873879]),
        (DefectKind::Spall, [-6.420572983893499, 0.07632158008402742, -0.009754640208541752, 56.186283003798266]),
        (DefectKind::Roughness, [-6.6483642189104994, 0.341786799812357, -0.04561237813660951, 52.35545448017709]),
        (DefectKind::Coulomb, [-3.8028624039946672, -0.6287427226989063, 0.009677378823531594, 30.62497867955788]),
    ];
    for (kind, last) in recorded {
        let trace = run(&Scenario::STANDARD.with_defect(Defect::full(kind)), trace_seed(1, kind, 0));
        let columns = [&trace.velocity_rad_s, &trace.current_a, &trace.load_torque_nm, &trace.angle_rad];
        for (column, old) in columns.iter().zip(last) {
            // The same bits but for the platform's logarithm in rare draws of noise: a last bit, kept small by the
            // loop.
            assert!((column.last().expect("sample") - old).abs() < 1e-9, "{kind:?}");
        }
    }
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

/// Trace `number` of the reference set; four a class, in the order of [`CLASSES`].
fn reference_trace(folder: &std::path::Path, number: usize) -> RigTrace {
    let c = columns(&folder.join(format!("trace_{number:02}.csv")), 0);
    let [t_s, velocity_ref_rad_s, velocity_rad_s, current_a, load_torque_nm, angle_rad] =
        <[Vec<f64>; 6]>::try_from(c).expect("six columns");
    RigTrace { t_s, velocity_ref_rad_s, velocity_rad_s, current_a, load_torque_nm, angle_rad, ..RigTrace::default() }
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
    let weak = MotorParameters { kt_nm_per_a: 0.0475, ke_v_s_per_rad: 0.0475, ..TABLE_2_3 };
    let motor = if kind == DefectKind::WeakMagnet { weak } else { TABLE_2_3 };
    let mut plant = Plant::new(&motor, 1e-4).expect("valid motor");
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
    let Some(folder) = data("dc_motor_reference") else { return };
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
    let Some(folder) = data("dc_motor_reference") else { return };
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
