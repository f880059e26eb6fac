//! Hashes of every kernel's results: equal lines on host and target mean equal bits. Run by `cargo xtask test`.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
mod support;

use bearing_watch::decide::{Discriminant, Features, Kind, Projection};
use bearing_watch::estimate::{Forgetting, Triangle, Watch};
use bearing_watch::{
    AlphaBeta, Angle, BlockMean, Estimator, FrontEnd, Guard, Order, Park, Regression, Sample, Shaft, ShaftEstimate,
};

use support::hash::Hash;
use support::numbers::Numbers;
use support::{decimation, streams};

main!(run);

fn run() {
    front_end();
    macro_rules! sizes { ($($m:literal)+) => { $(triangle::<$m, { $m * ($m - 1) / 2 }>();)+ }; }
    sizes!(2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21);
    estimator();
    streams::run(|number, outcomes| {
        let streams::Outcomes { plain, two_level, fading } = outcomes;
        let solved = [plain, two_level, fading].map(|outcome| outcome.solved);
        let (plain, two_level, fading) = (plain.bits, two_level.bits, fading.bits);
        say!("stream {number} {plain:08x}, two levels {two_level:08x}, fading {fading:08x}, solved {solved:?}");
    });
    decision();
    shaft::<4>(1);
    shaft::<1>(3);
    let mut hash = Hash::new();
    decimation::bits(|output| hash.add(output));
    say!("decimation {:08x}", hash.bits());
}

fn front_end() {
    let mut hash = Hash::new();
    let front = FrontEnd { pole_pairs: 6, electrical_offset: Angle::from_bits(12_345), park: Park::Standard };
    let mut numbers = Numbers(1);
    let mut mean = BlockMean::new();
    for k in 0..20_000_u32 {
        let angle = Angle::from_bits(k.wrapping_mul(0x9E37_79B9));
        let sc = angle.sin_cos();
        let dq = front.transform(AlphaBeta::from_two(numbers.next(), numbers.next()), angle);
        let back = Park::Thesis.inverse(dq, sc).inverse_clarke();
        hash.add(&[sc.sin, sc.cos, dq.d, dq.q, back.a, back.b, back.c, angle.radians()]);
        if let Some(mean) = mean.push([dq.d, dq.q], 7) {
            hash.add(&mean);
        }
    }
    say!("front end {:08x}", hash.bits());
}

fn triangle<const M: usize, const P: usize>() {
    let mut hash = Hash::new();
    let mut numbers = Numbers(3);
    let mut plain = Triangle::<M, P>::new(M);
    let mut forgetting = Triangle::<M, P>::new(M);
    for _ in 0..200 {
        let row: [f32; M] = numbers.array();
        plain.update(&row);
        forgetting.update_forgetting(&row, 1.0, Forgetting { lambda: 0.98, floor: 0.5 });
    }
    for triangle in [&plain, &forgetting] {
        hash.add(&triangle.solve());
        hash.add(&triangle.inverse());
        hash.add(&[triangle.residual_sum()]);
    }
    say!("triangle {M:2} {:08x}", hash.bits());
}

fn estimator() {
    let scale = [1.0, 4.0, 0.5, 1.0, 2.0, 1.0, 8.0];
    let base = Regression::new(Order::new(2, 1, 2, 1, 2), true);
    let regression = Regression { scale, guard: Guard::within([4.0; 3]), ..base };
    let mut estimator = Estimator::<7, 21, 4>::new(&regression);
    let (mut numbers, mut y) = (Numbers(7), [0.0_f32; 2]);
    for k in 0..3000 {
        let [u1, u2, e] = numbers.array();
        let next = 1.5 * y[0] - 0.7 * y[1] + 0.5 * u1 - 0.25 * u2 + 0.1 * e + 0.02;
        y = [next, y[0]];
        let measured = if k % 701 == 700 { f32::NAN } else { next };
        estimator.step(&Sample { y: measured, u1, u2 });
    }
    match estimator.estimate() {
        Ok(estimate) => {
            let mut hash = Hash::new();
            hash.add(&estimate.delta);
            hash.add(&estimate.raw());
            hash.add(&estimate.covariance);
            hash.add(&[estimate.variance]);
            let features = Features { index: [5, 0, 6, 2], count: 4 };
            hash.add(&features.extract(&estimate, None::<&ShaftEstimate<0>>).unwrap_or([0.0; 4]));
            say!("estimator {:08x}, {} rows, {} rejected", hash.bits(), estimate.rows, estimate.counts.rejected);
        }
        Err(reason) => say!("estimator: {reason}"),
    }
}

/// Torque balance and bearing orders of three segments.
fn shaft<const K: usize>(harmonics: u8) {
    let (mut hash, mut rows, mut rejected) = (Hash::new(), 0, 0);
    let model = support::shaft::model::<K>(harmonics, 50);
    let mut plant = support::shaft::Plant::new(15);
    let mut shaft = Shaft::new(Some(&model));
    for _ in 0..3 {
        (0..2000).for_each(|_| shaft.step(Some(&model), &plant.motion()));
        let Some(sums) = shaft.sums() else { return };
        shaft.next_segment();
        let ShaftEstimate { friction, orders, counts, reason, .. } = model.conclude(&sums);
        if let Some(reason) = reason {
            say!("shaft: {reason}");
        }
        hash.add(&friction.parameters);
        hash.add(&friction.deviations);
        hash.add(&friction.scores);
        hash.add(&[friction.variance]);
        orders.iter().for_each(|order| hash.add(&[order.prominence, order.amplitude]));
        (rows, rejected) = (rows + friction.rows, rejected + counts.rejected);
    }
    say!("shaft of {K} orders {:08x}, {rows} rows, {rejected} rejected", hash.bits());
}

fn decision() {
    let (mut hash, mut numbers) = (Hash::new(), Numbers(11));
    for kind in [Kind::Linear, Kind::Quadratic] {
        for _ in 0..100 {
            let projection = Projection::<9, 3> {
                matrix: core::array::from_fn(|_| numbers.array()),
                mean: numbers.array(),
                count: 3,
            };
            let discriminant = Discriminant::<3, 3> {
                kind,
                classes: 3,
                mean: core::array::from_fn(|_| numbers.array()),
                whitening: core::array::from_fn(|_| core::array::from_fn(|_| numbers.array())),
                log_normaliser: numbers.array(),
                log_prior: [-1.098_612_3; 3],
                cost: [[0.0, 50.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 0.0]],
                reject_cost: f32::INFINITY,
            };
            if let Some(decision) = discriminant.decide(&projection.project(&numbers.array())) {
                hash.add(&decision.log_likelihoods);
                hash.add(&decision.posteriors);
                hash.add(&decision.expected_costs);
                hash.add(&[f32::from(decision.class)]);
            }
        }
    }
    say!("decision {:08x}", hash.bits());
}
