//! Bounds of the validation room by Monte Carlo: on true models they must cover what they claim, on wrong ones they
//! must not.

use model::identify::{Estimate, Method, Options, Structure, Terms, estimate, estimate_with, poles, simulate};
use model::trace::Trace;
use model::validate::correlation::Correlation;
use model::validate::response::{Input, frequency, step};
use model::validate::{Errors, PoleZeroMap, REGION_SIGMAS, Validation, validate};
use nalgebra::Complex;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rig::{Scenario, simulate as record};

/// A second-order system with a lightly damped pair, pole zero of both inputs, and one with two real poles.
const COMPLEX: System = System { order: Structure::new(2, 2, 2, 1, 2), theta: &[-1.5, 0.7, 1.0, 0.5, -0.4, 0.3] };
const REAL: System = System { order: Structure::new(2, 2, 1, 1, 1), theta: &[-1.3, 0.4, 0.5, 0.3, 0.6] };

#[derive(Clone, Copy)]
struct System {
    order: Structure,
    theta: &'static [f64],
}

impl System {
    fn structure(self) -> Structure {
        self.order
    }

    /// The system as if it had been estimated without error.
    fn truth(self) -> Estimate {
        let n = self.theta.len();
        let theta = nalgebra::DVector::from_column_slice(self.theta);
        Estimate::given(self.structure(), theta, nalgebra::DMatrix::zeros(n, n))
    }

    /// Inputs of first-order colour 0.8 and 0.5; A y = B u1 + C u2 + e, or with `color` output noise of that pole.
    fn record(self, samples: usize, seed: u64, noise: f64, color: Option<f64>) -> Trace {
        self.record_with(samples, seed, noise, color, &[1.0])
    }

    /// The same with e replaced by D e.
    fn record_with(self, samples: usize, seed: u64, noise: f64, color: Option<f64>, d: &[f64]) -> Trace {
        const SETTLE: usize = 200;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let n = samples + SETTLE;
        let mut colored = |pole: f64, sd: f64| {
            let mut x = 0.0;
            (0..n)
                .map(|_| {
                    let drawn: f64 = StandardNormal.sample(&mut rng);
                    x = pole * x + drawn * sd;
                    x
                })
                .collect::<Vec<f64>>()
        };
        let (u1, u2) = (colored(0.8, 0.6), colored(0.5, 0.9));
        let v = colored(color.unwrap_or(0.0), noise);
        let ([a, b, c], _) = self.structure().polynomials(self.theta);
        let mut y = vec![0.0; n];
        for t in 5..n {
            let sum = |terms: &[f64], x: &[f64]| terms.iter().enumerate().map(|(k, p)| p * x[t - k]).sum::<f64>();
            let past: f64 = (1..a.len()).map(|k| a[k] * y[t - k]).sum();
            y[t] = sum(&b, &u1) + sum(&c, &u2) - past + if color.is_none() { sum(d, &v) } else { 0.0 };
        }
        if color.is_some() {
            y.iter_mut().zip(&v).for_each(|(y, v)| *y += v);
        }
        let kept = |x: Vec<f64>| x[SETTLE..].to_vec();
        Trace {
            id: "made".into(),
            interval_s: None,
            irregular_steps: 0,
            y: kept(y),
            u1: kept(u1),
            u2: kept(u2),
            motion: None,
            ..Trace::default()
        }
    }
}

#[derive(Default)]
struct Tally {
    lags: usize,
    outside: usize,
    records: usize,
    failed: usize,
}

impl Tally {
    fn add(&mut self, correlations: &[&Correlation], passed: bool) {
        for one in correlations {
            for (value, bound) in one.value.iter().zip(&one.bound).filter(|(_, bound)| **bound > 0.0) {
                self.lags += 1;
                self.outside += usize::from(value.abs() > *bound);
            }
        }
        self.records += 1;
        self.failed += usize::from(!passed);
    }

    fn rates(&self, what: &str) -> (f64, f64) {
        let rate = |n: usize, of: usize| 100.0 * n as f64 / of as f64;
        let (lags, records) = (rate(self.outside, self.lags), rate(self.failed, self.records));
        println!("{what}: {lags:.2} % of {} lags outside, {records:.1} % of {} records fail", self.lags, self.records);
        (lags, records)
    }
}

fn residual_test(
    what: &str,
    system: System,
    method: Method,
    errors: Errors,
    color: Option<f64>,
    runs: u64,
) -> [(f64, f64); 2] {
    let (mut cross, mut auto) = (Tally::default(), Tally::default());
    for seed in 0..runs {
        let trace = system.record(1500, seed, 0.5, color);
        let estimate = estimate(&trace, system.structure(), method).expect("well posed");
        let found = validate(&trace, &estimate, errors, 25).expect("long enough");
        cross.add(&[&found.cross_correlation[0], &found.cross_correlation[1]], found.independence.passed());
        auto.add(&[&found.autocorrelation], found.whiteness.passed());
    }
    [cross.rates(&format!("{what}, cross-correlation")), auto.rates(&format!("{what}, autocorrelation"))]
}

#[test]
fn true_models_lie_outside_in_one_percent_of_lags_short() {
    // 100 records know 1 % to ± 1 (one sd).
    lie_outside_in_one_percent(100, 4.0);
}

#[test]
#[ignore = "statistics of many records"]
fn true_models_lie_outside_in_one_percent_of_lags() {
    // 400 records know 1 % to ± 0.5 (one sd).
    lie_outside_in_one_percent(400, 2.5);
}

/// At most 1 % of the records fail by design.
fn lie_outside_in_one_percent(runs: u64, most_percent: f64) {
    for (what, system) in [("LS, complex poles", COMPLEX), ("LS, real poles", REAL)] {
        for (lags, records) in residual_test(what, system, Method::Ls, Errors::LeastSquares, None, runs) {
            assert!((0.5..=1.5).contains(&lags), "{what}: {lags} %");
            assert!(records <= most_percent, "{what}: {records} % of records fail");
        }
    }
}

#[test]
fn coloured_residuals_of_a_true_model_keep_the_level() {
    let [(lags, records), (white, _)] =
        residual_test("iv4, noise pole 0.9", COMPLEX, Method::Iv4, Errors::Instruments, Some(0.9), 300);
    assert!((0.5..=1.5).contains(&lags), "{lags} %");
    assert!(records <= 3.0, "{records} %");
    assert!(white > 10.0, "residuals of this noise are not white, yet only {white} % of lags say so");
}

/// Output-error estimate by Gauss–Newton from the truth, with slopes by differences of whole simulations.
fn output_error(trace: &Trace, system: System) -> Estimate {
    let structure = system.structure();
    let mut found = system.truth();
    let simulated = |theta: &[f64]| simulate(trace, structure, theta);
    for _ in 0..4 {
        let base = simulated(found.theta.as_slice());
        let slopes = nalgebra::DMatrix::from_columns(
            &(0..found.theta.len())
                .map(|k| {
                    let mut theta = found.theta.clone();
                    theta[k] += 1e-6;
                    let moved = simulated(theta.as_slice());
                    nalgebra::DVector::from_iterator(base.len(), moved.iter().zip(&base).map(|(m, b)| (m - b) / 1e-6))
                })
                .collect::<Vec<_>>(),
        );
        let error = nalgebra::DVector::from_iterator(base.len(), trace.y.iter().zip(&base).map(|(y, b)| y - b));
        found.theta += slopes.svd(true, true).solve(&error, 0.0).expect("decomposed");
    }
    found
}

#[test]
fn simulation_errors_of_a_true_model_keep_the_level() {
    let mut cross = Tally::default();
    for seed in 0..300 {
        let trace = REAL.record(1500, seed, 0.3, Some(0.7));
        let found = validate(&trace, &output_error(&trace, REAL), Errors::Simulation, 25).expect("long enough");
        cross.add(&[&found.cross_correlation[0], &found.cross_correlation[1]], found.independence.passed());
    }
    let (lags, records) = cross.rates("output error, noise pole 0.7, cross-correlation");
    assert!((0.5..=1.5).contains(&lags) && records <= 3.0, "{lags} % of lags, {records} % of records");
}

#[test]
fn prediction_errors_of_a_true_armax_model_keep_the_level() {
    let (mut cross, mut auto) = (Tally::default(), Tally::default());
    for seed in 0..300 {
        let trace = REAL.record_with(1500, seed, 0.3, None, &[1.0, 0.6]);
        let options = Options { noise_order: Some(1), ..Options::default() };
        let estimate = estimate_with(&trace, REAL.structure(), Method::Armax, options).expect("well posed");
        let found = validate(&trace, &estimate, Errors::Prediction, 25).expect("long enough");
        cross.add(&[&found.cross_correlation[0], &found.cross_correlation[1]], found.independence.passed());
        auto.add(&[&found.autocorrelation], found.whiteness.passed());
    }
    for (lags, records) in [cross.rates("armax, cross-correlation"), auto.rates("armax, autocorrelation")] {
        assert!((0.5..=1.5).contains(&lags) && records <= 3.0, "{lags} % of lags, {records} % of records");
    }
}

#[test]
fn wrong_models_fail() {
    const RUNS: u64 = 50;
    let low = Structure::new(1, 1, 1, 1, 2);
    let late = Structure::new(2, 2, 2, 2, 2);
    for (what, structure) in [("order too low", low), ("delay too long", late)] {
        for (method, errors) in [(Method::Ls, Errors::LeastSquares), (Method::Iv4, Errors::Instruments)] {
            let failed = (0..RUNS).filter(|&seed| {
                let trace = COMPLEX.record(1500, seed, 0.5, None);
                let estimate = estimate(&trace, structure, method).expect("well posed");
                !validate(&trace, &estimate, errors, 25).expect("long enough").independence.passed()
            });
            let failed = failed.count();
            println!("{what}, {method:?}: {failed} of {RUNS} fail the independence test");
            assert_eq!(failed as u64, RUNS);
        }
    }
}

/// A healthy trace of the standard rig with the reference or the error of the velocity loop as u1.
fn rig_trace(seed: u64, error: bool) -> Trace {
    let rig = record(&Scenario { samples: 5000, ..Scenario::STANDARD }, seed).expect("a valid scenario");
    let measured = |(r, w): (&f64, &f64)| if error { r - w } else { *r };
    let u1 = rig.velocity_ref_rad_s.iter().zip(&rig.velocity_rad_s).map(measured).collect();
    Trace {
        id: "rig".into(),
        interval_s: Some(0.002),
        irregular_steps: 0,
        y: rig.current_a,
        u1,
        u2: rig.load_torque_nm,
        motion: None,
        ..Trace::default()
    }
}

fn rig_validation(seed: u64, error: bool, order: Structure, method: Method) -> Validation {
    let trace = rig_trace(seed, error);
    let structure = order;
    let errors = if method == Method::Ls { Errors::LeastSquares } else { Errors::Instruments };
    let estimate = estimate(&trace, structure, method).expect("well posed");
    validate(&trace, &estimate, errors, 25).expect("long enough")
}

#[test]
fn the_standard_rig_is_no_low_order_arx_system() {
    let cases = [("error", true, Structure::new(2, 2, 2, 1, 1)), ("reference", false, Structure::new(2, 1, 2, 1, 1))];
    for ((what, error, order), method) in cases.into_iter().flat_map(|c| [(c, Method::Ls), (c, Method::Iv4)]) {
        for seed in 1..=3 {
            let found = rig_validation(seed, error, order, method);
            let test = found.independence;
            println!(
                "u1 = {what}, {method:?}, seed {seed}: {} of {} lags outside ({} allowed), largest {:.1} sd, fit {:.1} %, one-step {:.1} %",
                test.outside,
                test.tested,
                test.allowed,
                test.largest,
                found.simulation_fit_percent,
                found.prediction_fit_percent
            );
            assert!(!test.passed(), "a fit of 87–93 % hides what the residuals tell");
        }
    }
}

/// y under u1 = r − 0.6 y with white equation noise, LS at the true order.
#[test]
fn feedback_is_told_from_a_wrong_model() {
    const RUNS: u64 = 100;
    let system = System { order: Structure::new(1, 1, 1, 1, 1), theta: &[-0.8, 0.5, 0.4] };
    let (mut wrong, mut looped) = (0, 0);
    for seed in 0..RUNS {
        let mut trace = system.record(1500, seed, 0.5, None);
        // The recorded u1 becomes the reference; the noise is what the open loop left over.
        let reference = trace.u1.clone();
        let noise = |t: usize| trace.y[t] - 0.8 * trace.y[t - 1] - 0.5 * reference[t - 1] - 0.4 * trace.u2[t - 1];
        let noise: Vec<f64> = (1..trace.y.len()).map(noise).collect();
        for t in 0..trace.y.len() {
            if t > 0 {
                trace.y[t] = 0.8 * trace.y[t - 1] + 0.5 * trace.u1[t - 1] + 0.4 * trace.u2[t - 1] + noise[t - 1];
            }
            trace.u1[t] = reference[t] - 0.6 * trace.y[t];
        }
        let estimate = estimate(&trace, system.structure(), Method::Ls).expect("well posed");
        let found = validate(&trace, &estimate, Errors::LeastSquares, 25).expect("long enough");
        wrong += usize::from(!found.independence.passed());
        looped += usize::from(!found.feedback.passed());
    }
    println!("closed loop, true order: {wrong} of {RUNS} fail the independence test, {looped} show feedback");
    // At most 1 % fail by design: 5 of 100 have a probability of 0.4 %.
    assert!(wrong < 5 && looped as u64 == RUNS);
}

/// Shares of runs, in percent, whose regions of 1.5 and of 3 σ hold the true root, and of roots not separated.
fn root_coverage(system: System, samples: usize, runs: u64) -> Vec<(String, [f64; 3])> {
    let truth = PoleZeroMap::new(&system.truth(), REGION_SIGMAS);
    let lists = |map: &PoleZeroMap| [map.poles.clone(), map.zeros[0].clone(), map.zeros[1].clone()];
    let mut rows = Vec::new();
    for (list, name) in ["pole", "zero of B", "zero of C"].into_iter().enumerate() {
        for root in lists(&truth)[list].iter().filter(|root| root.at.im >= 0.0) {
            let kind = if root.is_real() { "real" } else { "complex" };
            rows.push((list, root.at, format!("{kind} {name} {:.2}", root.at), [0.0; 3]));
        }
    }
    for seed in 0..runs {
        let trace = system.record(samples, seed, 0.5, None);
        let estimate = estimate(&trace, system.structure(), Method::Ls).expect("well posed");
        let found = lists(&PoleZeroMap::new(&estimate, REGION_SIGMAS));
        for (list, at, _, counts) in &mut rows {
            let distance = |z: Complex<f64>| (z - *at).norm();
            let nearest = found[*list].iter().min_by(|x, y| distance(x.at).total_cmp(&distance(y.at)));
            let nearest = nearest.expect("as many roots as the truth");
            for (count, sigmas) in counts.iter_mut().zip([1.5, REGION_SIGMAS]) {
                *count += 100.0 / runs as f64 * f64::from(u8::from(nearest.covers(*at, sigmas)));
            }
            counts[2] += 100.0 / runs as f64 * f64::from(u8::from(!nearest.separated));
        }
    }
    rows.into_iter().map(|(_, _, name, counts)| (name, counts)).collect()
}

#[test]
fn regions_of_roots_cover_the_truth() {
    for system in [COMPLEX, REAL] {
        for (name, [narrow, wide, close]) in root_coverage(system, 2000, 4000) {
            println!("N = 2000, {name}: 1.5σ {narrow:.1} %, 3σ {wide:.2} %, not separated {close:.1} %");
            // Normal theory: real 86.6 and 99.73 %, complex 67.5 and 98.89 %; 4000 runs know them to ± 0.7 and ± 0.17
            // (one sd).
            let (low, high) = if name.starts_with("real") { (83.6, 89.6) } else { (64.5, 70.5) };
            assert!((low..=high).contains(&narrow), "{name}: {narrow} % within 1.5σ");
            assert!(wide >= 98.5 && close < 1.0, "{name}: {wide} % within 3σ, {close} % not separated");
        }
    }
    for samples in [50, 100, 400] {
        for (name, [_, wide, close]) in root_coverage(REAL, samples, 500) {
            println!("N = {samples}, {name}: 3σ {wide:.1} %, not separated {close:.1} %");
        }
    }
}

#[test]
fn bands_of_responses_cover_the_truth() {
    const RUNS: u64 = 2000;
    const NORMAL_95: f64 = 1.959_964;
    for system in [COMPLEX, REAL] {
        let quantities = |estimate: &Estimate| {
            let mut all = Vec::new();
            for input in [Input::U1, Input::U2] {
                for omega in [0.01, 0.3, 1.0, 2.5] {
                    let at = frequency(estimate, input, omega).expect("a response");
                    all.push((format!("{input:?}, {omega} rad, magnitude"), at.magnitude_db));
                    all.push((format!("{input:?}, {omega} rad, phase"), at.phase_deg));
                }
                let response = step(estimate, input, 60);
                all.extend([2, 5, 15, 59].map(|t| (format!("{input:?}, step at {t}"), response[t])));
            }
            all
        };
        let truth = quantities(&system.truth());
        let mut covered = vec![0; truth.len()];
        for seed in 0..RUNS {
            let trace = system.record(2000, seed, 0.5, None);
            let found = quantities(&estimate(&trace, system.structure(), Method::Ls).expect("well posed"));
            for ((count, (_, found)), (_, truth)) in covered.iter_mut().zip(&found).zip(&truth) {
                let (low, high) = found.band(NORMAL_95);
                // A phase near ±180° may be written either way.
                let off = [0.0, 360.0, -360.0].iter().any(|turn| (low..=high).contains(&(truth.value + turn)));
                *count += usize::from(off);
            }
        }
        for (count, (name, _)) in covered.iter().zip(&truth) {
            let percent = 100.0 * *count as f64 / RUNS as f64;
            println!("order {:?}, {name}: {percent:.1} %", system.order.orders());
            assert!((93.0..=97.0).contains(&percent), "{name}: {percent} %");
        }
    }
}

#[test]
fn near_cancellation_is_told() {
    // One pole and one zero of B and of C too many: (1 + 0.5 q⁻¹) times a first-order system.
    let system = System { order: Structure::new(1, 1, 1, 1, 1), theta: &[-0.8, 1.0, 0.5] };
    let rich = Structure::new(2, 2, 2, 1, 1);
    let right = (0..20).filter(|&seed| {
        let trace = system.record(2000, seed, 0.5, None);
        let estimate = estimate(&trace, rich, Method::Ls).expect("well posed");
        let map = PoleZeroMap::new(&estimate, REGION_SIGMAS);
        let ([a, _, _], _) = rich.polynomials(estimate.theta.as_slice());
        assert_eq!(map.poles.len(), poles(&a).len());
        // The true pole 0.8 must not be called removable.
        let wrong = map.removable.iter().any(|&pole| (map.poles[pole].at.re - 0.8).abs() < 0.1);
        !map.removable.is_empty() && !wrong
    });
    let right = right.count();
    println!("{right} of 20 over-ordered models: the surplus pole, and only it, is told");
    assert!(right >= 19, "{right} of 20");
    let trace = COMPLEX.record(2000, 1, 0.5, None);
    let exact = estimate(&trace, COMPLEX.structure(), Method::Ls).expect("well posed");
    assert_eq!(PoleZeroMap::new(&exact, REGION_SIGMAS).removable, Vec::<usize>::new());
}
