use super::*;
use crate::plan::{Layout, Load, Plan as _, RunTime, ShaftLayout, Signal};
use crate::shaft::orders::blocks::{Blocks, MAX_BLOCKS, TrackedOrder, q16};
use crate::shaft::orders::noise::NoiseLine;
use crate::shaft::orders::slip::{OrderStrength, Search, SlipRange};
use std::vec;
use std::vec::Vec;

/// A repeatable stream of Gaussian numbers.
struct Gauss(u64);

impl Gauss {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / 9_007_199_254_740_992.0
    }

    fn next(&mut self) -> f64 {
        let (radius, turn) = ((-2.0 * (1.0 - self.uniform()).ln()).sqrt(), self.uniform());
        radius * (core::f64::consts::TAU * turn).cos()
    }
}

const ORDER: f32 = 3.717_94;
const POLE: f32 = 0.9;

fn plan() -> RunTime {
    let signal = Signal::channel;
    let shaft = ShaftLayout {
        current: signal(0),
        velocity: Some(signal(1)),
        load: Load::Unknown,
        orders: 1,
        harmonics: 3,
        decimation: 1,
    };
    RunTime::of(Layout { channels: 2, shaft: Some(shaft), features: 1, coordinates: 1, classes: 1, ..Layout::EMPTY })
        .unwrap()
}

fn tracking(slip: f32, log2: i8) -> Tracking<RunTime> {
    Tracking {
        orders: vec![TrackedOrder::new(ORDER, [1.0, 0.8, 0.6])],
        blocks: Blocks {
            controls: [2.5, 4.45, 6.6, 11.6].map(q16),
            cell_turns_log2: log2,
            slip,
            slowest_rad_s: 1.0,
            pole: POLE,
            high_pass: 0.0,
        },
    }
}

/// (5) of the residual: full from a third of the largest speed of [`MOTIONS`] on.
fn excitation(step: f64) -> f64 {
    let q = (step.abs() / 0.0034 - 1.0).clamp(0.0, 1.0);
    q * q * (3.0 - 2.0 * q) * step.signum()
}

/// Turns by `turns(k)` a sample, with a defect of this amplitude and slip; white noise of unit deviation.
fn run(
    seed: u64,
    samples: usize,
    tracking: &Tracking<RunTime>,
    turns: impl Fn(usize) -> f64,
    defect: (f64, f64),
) -> (OrderStrength, u32) {
    let mut gauss = Gauss(seed);
    run_in(|| gauss.next(), samples, tracking, turns, defect)
}

/// The same in this noise.
fn run_in(
    mut noise: impl FnMut() -> f64,
    samples: usize,
    tracking: &Tracking<RunTime>,
    turns: impl Fn(usize) -> f64,
    (amplitude, slip): (f64, f64),
) -> (OrderStrength, u32) {
    let (mut orders, mut sums) = (OrderTracking::<RunTime>::new(plan()), OrderSums::new(plan()));
    let (mut angle, mut filtered, mut last) = (0.0, 0.0, 0_u32);
    for k in 0..samples {
        let step = turns(k);
        angle += step;
        let bits = ((angle * 4_294_967_296.0) as i64).cast_unsigned() as u32;
        let turned = bits.wrapping_sub(last).cast_signed();
        last = bits;
        let excitation = excitation(step);
        let phase = core::f64::consts::TAU * f64::from(ORDER) * (1.0 + slip) * angle;
        filtered = amplitude * excitation * (phase.cos() + 0.8 * (2.0 * phase).cos()) + f64::from(POLE) * filtered;
        let white = (filtered + noise()) as f32;
        orders.step(&mut sums, tracking, turned, (3, Residual { white, excitation: excitation as f32 }));
    }
    let range =
        SlipRange { cell_turns: libm::exp2f(f32::from(tracking.blocks.cell_turns_log2)), slip: tracking.blocks.slip };
    let (noise, line, order) =
        (NoiseLine::new(&sums.noise, &tracking.blocks.controls), &sums.lines[0], &tracking.orders[0]);
    (Search::new(line, &noise, order, &range).strength(line, order, &range), sums.blocks)
}

fn mean_and_deviation(x: &[f64]) -> (f64, f64) {
    let n = x.len() as f64;
    let mean = x.iter().sum::<f64>() / n;
    (mean, (x.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt())
}

/// Turns at sample k.
type Turns = fn(usize) -> f64;

/// Turns a sample: constant, varying, and reversing.
const MOTIONS: [(&str, Turns); 3] = [
    ("constant", |_| 0.0085),
    ("varying", |k| 0.0085 + 0.004 * (k as f64 * 0.003).sin()),
    ("reversing", |k| 0.02 * (k as f64 * 0.003).sin()),
];

#[test]
fn noise_alone_scores_like_a_standard_normal_whatever_the_turns() {
    for (name, turns) in MOTIONS {
        for samples in [4000, 12_000] {
            for slip in [0.0, 0.022] {
                let score =
                    |seed: u64| f64::from(run(seed + 7, samples, &tracking(slip, 1), turns, (0.0, 0.0)).0.score);
                let mut scores: Vec<f64> = (0..200).map(score).collect();
                let (mean, deviation) = mean_and_deviation(&scores);
                scores.sort_by(f64::total_cmp);
                let high = scores[197];
                let what = std::format!("{name}, {samples} samples, slip {slip}: {mean} ± {deviation}, 99 %: {high}");
                std::println!("{what}");
                // Standard errors of 200 scores: 0.07 of the mean, 0.05 of the deviation, 0.27 of the 99 % quantile,
                // which is 2.33 of a standard normal. The approximations of (5) are good to 0.2.
                assert!(mean.abs() < 0.35, "{what}");
                assert!((0.8..1.3).contains(&deviation), "{what}");
                assert!((1.6..3.2).contains(&high), "{what}");
            }
        }
    }
}

/// At constant speed the order's second harmonic lies in a resonance of 5 % damping, where the noise is six times that
/// of other orders.
#[test]
fn a_resonance_counts_for_less_than_a_defect() {
    let find = |seed: u64, amplitude: f64| {
        let (mut white, mut drive, mut states) = (Gauss(seed), Gauss(seed + 1000), [0.0, 0.0]);
        let turns = 0.0085;
        let frequency = core::f64::consts::TAU * 2.0 * f64::from(ORDER) * turns;
        let radius = (-0.05 * frequency).exp();
        // The squared gain at the resonance is 1/(2 (1 − r) sin ω)²; five times unit noise there.
        let size = 5.0_f64.sqrt() * 2.0 * (1.0 - radius) * frequency.sin();
        let noise = move || {
            let [last, before] = states;
            let now = 2.0 * radius * frequency.cos() * last - radius * radius * before + size * drive.next();
            states = [now, last];
            white.next() + now
        };
        f64::from(run_in(noise, 10_000, &tracking(0.022, 1), |_| turns, (amplitude, 0.006)).0.score)
    };
    let of = |amplitude: f64| {
        let mut scores: Vec<f64> = (0..100).map(|seed| find(seed, amplitude)).collect();
        scores.sort_by(f64::total_cmp);
        scores
    };
    let (healthy, defect) = (of(0.0), of(0.06));
    std::println!("median {}, 95 %: {}, a defect's 5 %: {}", healthy[50], healthy[95], defect[5]);
    // With the noise of the control orders alone the median would be 4.5 and the 95 % quantile 6.3; the limit of four
    // times leaves a third of the noise, and blocks next to each other are dependent. Standard errors of 100 scores:
    // 0.2 of the median, 0.3 of the quantile.
    assert!((0.7..2.0).contains(&healthy[50]) && (3.5..5.6).contains(&healthy[95]), "{} {}", healthy[50], healthy[95]);
    // In white noise about 12; the noise of control orders next to the resonance does not lie on a line, and is less
    // certain.
    assert!((6.0..10.0).contains(&defect[5]), "{}", defect[5]);
}

/// A line of amplitude 0.03 has a score of about 9, one of 0.12 a score of about 40.
#[test]
fn slip_and_amplitude_have_errors_like_their_deviations() {
    for (name, turns) in MOTIONS {
        for (log2, slip) in [(0, -0.015), (1, 0.006)] {
            for amplitude in [0.03, 0.12] {
                let find = |seed| run(seed, 10_000, &tracking(0.022, log2), turns, (amplitude, slip)).0;
                let strengths: Vec<OrderStrength> = (0..200).map(find).collect();
                let of = |pick: fn(&OrderStrength) -> f32| {
                    mean_and_deviation(&strengths.iter().map(|strength| f64::from(pick(strength))).collect::<Vec<_>>())
                };
                let rms = |pick: fn(&OrderStrength) -> f32| {
                    let squares = strengths.iter().map(|strength| f64::from(pick(strength)).powi(2));
                    (squares.sum::<f64>() / strengths.len() as f64).sqrt()
                };
                let ((mean, error), deviation) =
                    (of(|strength| strength.slip), rms(|strength| strength.slip_deviation));
                let what = std::format!(
                    "{name}, 2^{log2} turns, amplitude {amplitude}: slip {mean} ± {error}, not {deviation}"
                );
                // Errors of 200 slips scatter by 5 %. (7) counts half of what cancels at constant speed, where the
                // deviation is 1/√(1 + |A|² W̄/σ²) of it, 0.4 at the stronger line.
                assert!((0.35..1.4).contains(&(error / deviation)), "{what}");
                // Four standard errors of the mean, the vertex of a parabola, and a sixth of the slip after reversals.
                let bias = if name == "reversing" { 0.17 } else { 0.02 } * slip;
                assert!((mean - slip).abs() < 0.3 * error + f64::abs(bias), "{what}");
                let ((mean, error), deviation) =
                    (of(|strength| strength.amplitude), rms(|strength| strength.deviation));
                let what =
                    std::format!("{name}, 2^{log2} turns: amplitude {mean} ± {error}, not {amplitude} ± {deviation}");
                // Noise counts fully at a known slip; of the products of neighbours less remains.
                assert!((0.5..1.3).contains(&(error / deviation)), "{what}");
                // The weights of the harmonics and reversals cost up to a twelfth.
                assert!((0.92..1.03).contains(&(mean / amplitude)), "{what}");
            }
        }
    }
}

#[test]
fn the_unit_of_the_weights_does_not_matter() {
    let scored = |weights: [f32; 3]| {
        let mut tracking = tracking(0.022, 1);
        tracking.orders[0].weights = weights;
        run(3, 4000, &tracking, |_| 0.0085, (0.04, 0.006)).0.score
    };
    let (one, other) = (scored([1.0, 0.5, 0.25]), scored([3.0, 1.5, 0.75]));
    assert!(one > 4.0 && (one / other - 1.0).abs() < 1e-5, "{one} {other}"); // roundings
}

/// In cells of ⅛ turn, up to the number of blocks of a long segment at high speed.
#[test]
fn noise_and_defects_keep_their_scores_however_many_blocks_a_segment_has() {
    // A passage takes 16 samples, so that every order has time to close.
    let find =
        |seed, blocks: usize, amplitude| run(seed, 16 * blocks, &tracking(0.0, -3), |_| 0.125 / 16.0, (amplitude, 0.0));
    for blocks in [60_000_u32, 125_000, MAX_BLOCKS] {
        let (noise, closed) = find(5, blocks as usize, 0.0);
        let what = std::format!("{closed} blocks: prominence {}, score {}", noise.prominence, noise.score);
        std::println!("{what}");
        // The last block is still open. (3) has a deviation of 0.006 at the fewest blocks; a normal score of 4 has a
        // probability of 1e-4.
        assert!(closed.abs_diff(blocks) < 3 && (noise.prominence - 1.0).abs() < 0.03, "{what}");
        assert!(noise.score.abs() < 4.0, "{what}");
    }
    let defect = find(6, 125_000, 0.02).0;
    std::println!("defect: score {}, amplitude {}", defect.score, defect.amplitude);
    // Four times the power of one with a score of five; the weights of the harmonics cost up to a twelfth.
    assert!(defect.score > 10.0 && (0.9..1.05).contains(&(defect.amplitude / 0.02)), "{defect:?}");
}

/// The sums after `samples` samples of noise and a line of amplitude 0.2; where `lost` is true, a sample has no
/// residual.
fn sums(samples: usize, log2: i8, turns: impl Fn(usize) -> f64, lost: impl Fn(usize) -> bool) -> OrderSums<RunTime> {
    let (mut orders, mut sums) = (OrderTracking::<RunTime>::new(plan()), OrderSums::new(plan()));
    let (mut gauss, mut angle) = (Gauss(9), 0.0);
    for k in 0..samples {
        angle += turns(k);
        let turned = (turns(k) * 4_294_967_296.0) as i32;
        if lost(k) {
            orders.turn_unwatched(turned);
            continue;
        }
        let phase = core::f64::consts::TAU * f64::from(ORDER) * angle;
        let white = (0.2 * phase.cos() + gauss.next()) as f32;
        orders.step(
            &mut sums,
            &tracking(0.0, log2),
            turned,
            (3, Residual { white, excitation: if turned < 0 { -1.0 } else { 1.0 } }),
        );
    }
    sums
}

#[test]
fn four_blocks_are_the_fewest_that_give_orders() {
    for blocks in 0..6 {
        // Passages of an eighth of a turn; ten samples more find the end of the last one and close it.
        let sums = sums(16 * blocks + 10, -3, |_| 0.125 / 16.0, |_| false);
        let few = Reason::TooFewRows { part: Part::Orders, rows: u32::try_from(blocks).unwrap() };
        assert_eq!(sums.reason(), (blocks < 4).then_some(few), "{blocks}");
    }
}

#[test]
fn a_shaft_that_swings_in_a_cell_closes_blocks_by_the_way_it_goes() {
    // To and fro over a twentieth of a turn, in a cell of half a turn: 3200 samples go 50 times half a turn.
    let swing = |k: usize| if (k / 4).is_multiple_of(2) { 1.0 / 128.0 } else { -1.0 / 128.0 };
    let blocks = sums(3200, -1, swing, |_| false).blocks;
    // Each swing is a part, and while the nine items of one close, the end of a block is not seen: 64 to 72 samples.
    assert!((44..=50).contains(&blocks), "{blocks}");
}

#[test]
fn passages_on_both_sides_of_a_gap_keep_their_phase() {
    // Half a turn a block of 64 samples. Between blocks an eighth of a turn is lost, in which the line turns by 167°.
    let coherent = |lost: fn(usize) -> bool| {
        let sums = sums(40_000, -1, |_| 1.0 / 128.0, lost);
        let [real, _] = sums.lines[0].lags[0][0];
        real / sums.lines[0].pairs[1]
    };
    let (whole, gaps) = (coherent(|_| false), coherent(|k| k % 80 >= 64));
    // Behind each gap the filter of the excitation needs about ten of the 64 samples. Of a line that had not turned on,
    // the part would be negative.
    assert!(whole > 0.0 && gaps > 0.4 * whole, "{gaps} {whole}");
}
