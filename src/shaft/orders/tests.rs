use super::*;
use crate::plan::{Layout, RunTime, ShaftLayout, Signal};
use crate::shaft::slip::{OrderStrength, SlipRange, SlipSearch};
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
        velocity: signal(1),
        reference: signal(2),
        load: None,
        orders: 1,
        harmonics: 3,
    };
    RunTime::of(Layout { channels: 3, shaft: Some(shaft), features: 1, coordinates: 1, classes: 1, ..Layout::EMPTY })
        .unwrap()
}

fn tracking(slip: f32, log2: i8) -> Tracking<RunTime> {
    Tracking {
        orders: vec![TrackedOrder::new(ORDER, [1.0, 0.8, 0.6])],
        blocks: Blocks {
            controls: [2.5, 4.55, 5.45, 6.5].map(q16),
            cell_turns_log2: log2,
            slip,
            slowest_rad_s: 1.0,
            pole: POLE,
        },
    }
}

/// Turns by `turns(k)` a sample, with a defect of this amplitude and slip; white noise of unit deviation.
fn run(
    seed: u64,
    samples: usize,
    tracking: &Tracking<RunTime>,
    turns: impl Fn(usize) -> f64,
    (amplitude, slip): (f64, f64),
) -> (OrderStrength, u16) {
    let mut orders = OrderTracking::<RunTime>::new(plan());
    let (mut noise, mut angle, mut filtered, mut last) = (Gauss(seed), 0.0, 0.0, 0_u32);
    for k in 0..samples {
        let step = turns(k);
        angle += step;
        let bits = ((angle - angle.floor()) * 4_294_967_296.0) as u64 as u32;
        let turned = bits.wrapping_sub(last).cast_signed();
        last = bits;
        let excitation = if step < 0.0 { -1.0 } else { 1.0 };
        let phase = core::f64::consts::TAU * f64::from(ORDER) * (1.0 + slip) * angle;
        filtered = amplitude * excitation * (phase.cos() + 0.8 * (2.0 * phase).cos()) + f64::from(POLE) * filtered;
        let white = (filtered + noise.next()) as f32;
        orders.step(3, tracking, turned, Residual { white, excitation: excitation as f32 });
    }
    let sums = orders.sums();
    let range =
        SlipRange { cell_turns: libm::exp2f(f32::from(tracking.blocks.cell_turns_log2)), slip: tracking.blocks.slip };
    let mut search = SlipSearch::new();
    loop {
        if let Some(strength) = search.step(&sums.lines[0], &sums.noise, &tracking.orders[0], &range) {
            return (strength, sums.blocks);
        }
    }
}

fn mean_and_deviation(x: &[f64]) -> (f64, f64) {
    let n = x.len() as f64;
    let mean = x.iter().sum::<f64>() / n;
    (mean, (x.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt())
}

#[test]
fn noise_alone_scores_like_a_standard_normal_whatever_the_turns() {
    let back_and_forth = |k: usize| 0.012 * (k as f64 * 0.003).sin();
    for (samples, steady) in [(5000, false), (5000, true), (20_000, true), (60_000, true)] {
        for slip in [0.0, 0.008, 0.022] {
            let scores: Vec<f64> = (0..100)
                .map(|seed| {
                    let turns = |k: usize| if steady { 0.0085 } else { back_and_forth(k) };
                    f64::from(run(seed + 7, samples, &tracking(slip, 1), turns, (0.0, 0.0)).0.score)
                })
                .collect();
            let (mean, deviation) = mean_and_deviation(&scores);
            let most = scores.iter().copied().fold(f64::MIN, f64::max);
            std::eprintln!("{samples} {steady} {slip}: {mean:.2} ± {deviation:.2}, most {most:.2}");
        }
    }
}

#[test]
fn amplitude_and_slip_are_found() {
    for slip in [-0.015, 0.0, 0.006] {
        let found: Vec<OrderStrength> =
            (0..20).map(|seed| run(seed, 10_000, &tracking(0.022, 1), |_| 0.0085, (0.1, slip)).0).collect();
        let (mean, deviation) = mean_and_deviation(&found.iter().map(|f| f64::from(f.slip)).collect::<Vec<_>>());
        let (amplitude, _) = mean_and_deviation(&found.iter().map(|f| f64::from(f.amplitude)).collect::<Vec<_>>());
        std::eprintln!(
            "{slip}: {mean} ± {deviation} ({}), {amplitude} ({})",
            found[0].slip_deviation,
            found[0].deviation
        );
    }
}
