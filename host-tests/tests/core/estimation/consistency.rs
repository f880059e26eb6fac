//! Monte Carlo: the core's streaming refined instrumental variables against the truth, the last of three segments
//! counted, from a nominal model a fifth wrong. Bias by a family-wise test at 1 % (Bonferroni over all parameters of
//! all cases) and in shares of the standard deviation; coverage of the 95 % intervals.
//!
//! Beside it, on the same segments: least squares (the core's), and instrumental variables without the prefilter
//! (double precision, with the *true* auxiliary model), which show why the prefilter is there.

use host_tests::oracle::{self, Record};
use host_tests::plants::{PLANTS, Plant};
use host_tests::streams::{Run, least_squares, refined};
use rayon::prelude::*;

/// Runs a case of the long check. The standard error of a mean is then 0.025 sd, so that 0.1 sd is a bias and not
/// chance.
const LONG: u64 = 1600;
/// Runs of the short one, whose limits are wider by the root of their ratio.
const SHORT: u64 = 100;
/// Of these, how many go through instrumental variables without a prefilter, which double precision makes slow.
const PLAIN_RUNS: u64 = 100;

/// Places in [`PLANTS`] and ratios of signal to noise, dB.
const CASES: [(usize, f64); 10] =
    [(0, 10.0), (1, 20.0), (2, 25.0), (3, 10.0), (4, 20.0), (5, 25.0), (7, 20.0), (8, 25.0), (10, 20.0), (11, 25.0)];

/// Deviations from the truth of one method, with the standard deviations it states.
struct Errors(Vec<(Vec<f64>, Vec<f64>)>);

impl Errors {
    /// Of parameter k: mean, spread, share of 95 % intervals that hold the truth.
    fn of(&self, k: usize) -> (f64, f64, f64) {
        let count = self.0.len() as f64;
        let mean = self.0.iter().map(|(error, _)| error[k]).sum::<f64>() / count;
        let square = self.0.iter().map(|(error, _)| (error[k] - mean).powi(2)).sum::<f64>();
        let holds = |(error, sd): &&(Vec<f64>, Vec<f64>)| error[k].abs() <= 1.959_964 * sd[k];
        (mean, (square / (count - 1.0)).sqrt(), self.0.iter().filter(holds).count() as f64 / count)
    }

    /// Largest bias in units of the spread, and largest spread beside another's.
    fn worst(&self, beside: &Self, parameters: usize) -> (f64, f64) {
        (0..parameters).fold((0.0, 0.0), |(bias, wide), k| {
            let ((mean, spread, _), (_, other, _)) = (self.of(k), beside.of(k));
            (f64::max(bias, mean.abs() / spread), f64::max(wide, spread / other))
        })
    }
}

fn run(plant: &Plant, noise: f64, seed: u64) -> [Option<(Vec<f64>, Vec<f64>)>; 3] {
    let structure = plant.structure();
    let length = if plant.rate_hz > 5e3 { 12_000 } else { 5_000 };
    let samples: Vec<_> = plant.source(noise, seed).take(3 * length).collect();
    let truth = oracle::delta(structure, &plant.truth());
    let errors = |delta: &[f32]| truth.iter().zip(delta).map(|(truth, x)| f64::from(*x) - truth).collect::<Vec<_>>();

    let streamed = Run::new(&refined(plant, &samples), &samples, length);
    let estimate = streamed.segments[2].as_ref().expect("an estimate");
    let deviations = (0..truth.len()).map(|k| f64::from(estimate.deviation(k))).collect();

    let setup = least_squares(structure, &samples);
    let mut least = setup.stream(length);
    samples[2 * length..].iter().for_each(|sample| least.step(sample));
    let least = least.closed();
    assert_eq!(least.reason, None);
    let least = errors(least.delta());

    let plain = (seed % 1_000_000 < PLAIN_RUNS).then(|| {
        let record = Record::new(&samples);
        let fit = oracle::instrumental(&record, structure, &plant.truth(), streamed.rows(2)).delta(structure);
        ((&fit.theta - &truth).as_slice().to_vec(), fit.deviations())
    });
    let zeros = vec![0.0; truth.len()];
    [Some((errors(estimate.delta()), deviations)), Some((least, zeros)), plain]
}

fn check(runs: u64) {
    let parameters: usize = CASES.iter().map(|(place, _)| PLANTS[*place].truth().len()).sum();
    // Two-sided 1 % over 46 parameters: the normal quantile of 1 − 0.005/46.
    let limit = 3.698;
    assert_eq!(parameters, 46);
    let wider = (LONG as f64 / runs as f64).sqrt();
    let (most_bias, most_off) = (0.1 * wider, 0.02 * wider);
    println!("{runs} runs a case, {parameters} tests, family-wise 1 %: |score| ≤ {limit}");
    let mut failures = Vec::new();
    for (number, (place, ratio_db)) in CASES.iter().enumerate() {
        let (plant, started) = (&PLANTS[*place], std::time::Instant::now());
        let noise = plant.noise(*ratio_db);
        let base = 1_000_000 * (number as u64 + 1);
        let each: Vec<_> = (0..runs).into_par_iter().map(|seed| run(plant, noise, base + seed)).collect();
        let [streamed, least, plain] =
            [0, 1, 2].map(|method| Errors(each.iter().filter_map(|run| run[method].clone()).collect()));
        let n = plant.truth().len();
        println!("{} {ratio_db} dB, {:.1} s", plant.name, started.elapsed().as_secs_f64());
        for k in 0..n {
            let (mean, spread, coverage) = streamed.of(k);
            let (score, bias) = (mean / spread * (runs as f64).sqrt(), mean / spread);
            let line =
                format!("  parameter {k}: score {score:6.2}, bias/sd {bias:7.3}, coverage {:.1} %", 100.0 * coverage);
            println!("{line}");
            if score.abs() > limit || bias.abs() > most_bias || (coverage - 0.95).abs() > most_off {
                failures.push(format!("{} {line}", plant.name));
            }
        }
        let ((ls_bias, _), (iv_bias, iv_wide)) = (least.worst(&streamed, n), plain.worst(&streamed, n));
        println!(
            "  least squares: bias to {ls_bias:.0} sd; no prefilter: bias to {iv_bias:.2} sd, sd to {iv_wide:.1} times"
        );
        // Least squares is far off everywhere; without the prefilter variance or, in closed loop, bias is many times
        // ours.
        assert!(ls_bias > 4.0 && iv_wide > 4.0, "{}: the data are too easy", plant.name);
        assert!(plant.control.is_none() || iv_bias > 2.0, "{}: the loop carries no noise", plant.name);
    }
    assert!(failures.is_empty(), "{failures:#?}");
}

#[test]
fn the_stream_is_unbiased_where_simpler_methods_fail_short() {
    check(SHORT);
}

#[test]
#[ignore = "minutes of statistics"]
fn the_stream_is_unbiased_where_simpler_methods_fail_long() {
    check(LONG);
}
