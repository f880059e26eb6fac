use super::*;
use crate::decide::{Covariates, Discriminant, Feature, Law, Projection};
use crate::plan::{Layout, Memory, Method, RunTime, Structure, testing};
use std::{vec, vec::Vec};

/// 1 %.
const LIMIT: f32 = 4.605_17;

fn plan(coordinates: u8, rising: u8) -> RunTime {
    let plain = testing::regression(Structure::new(1, 1, 0, 1, 0), Method::LeastSquares, Memory::Segment);
    RunTime::of(Layout { features: coordinates, coordinates, rising, classes: 2, ..plain }).unwrap()
}

/// Surprises 0, 0.25, 1, … with a knot at the limit, and the law of known mean and covariance.
fn law(count: usize) -> Law {
    let mut grid: Law = core::array::from_fn(|k| [k as f32, 0.0625 * (k * k) as f32]);
    grid[9][1] = LIMIT;
    let known = Size { freedom: 1e5, factor: 1.0, trained_freedom: 1.0 };
    known.law(&grid, [0, count], LIMIT)
}

/// Healthy: mean 0 and this variance in every coordinate; a defect at 8 in all of them.
fn classifier(coordinates: u8, rising: u8, variance: f32) -> Classifier<RunTime> {
    let (plan, n) = (plan(coordinates, rising), coordinates as usize);
    let rows = |pivot: f32| (0..n).flat_map(move |i| (i..n).map(move |j| if i == j { pivot } else { 0.0 }));
    let mut novelty = Novelty { class: Some(0), factor: rows(variance).collect(), ..Novelty::none(plan) };
    (novelty.knots, novelty.limit, novelty.freedom) = (law(n), LIMIT, 1e5);
    let others = n - rising as usize;
    for (k, law_of_one) in novelty.laws.iter_mut().enumerate() {
        *law_of_one = law(if k == 0 { others } else { 1 });
    }
    Classifier {
        features: vec![Feature::Parameter(0); n],
        covariates: Covariates { list: vec![], map: vec![] },
        projection: Projection { matrix: rows(1.0).collect(), mean: vec![0.0; n], usual: vec![0.0; n] },
        discriminant: Discriminant {
            means: [vec![0.0; n], vec![8.0; n]].concat(),
            factors: rows(variance).collect(),
            log_prior: vec![0.5_f32.ln(); 2],
            costs: vec![0.0, 1.0, 1.0, 0.0],
            reject_cost: f32::INFINITY,
        },
        novelty,
    }
}

fn constants(fewest: u32, mean_weight: f32, covariance_weight: f32) -> CommissioningConstants {
    let limits = CommissioningConstants::new(fewest, 1.0);
    CommissioningConstants { mean_weight, covariance_weight, ..limits }
}

fn started(trained: &Classifier<RunTime>, constants: CommissioningConstants) -> HealthyClass<RunTime> {
    let coordinates = trained.novelty.mean.len() as u8;
    HealthyClass::new(plan(coordinates, trained.novelty.laws.len().saturating_sub(1) as u8), trained, constants)
        .unwrap()
}

/// Standard normal numbers (Box and Muller 1958).
fn noise(seed: u64) -> impl FnMut() -> f32 {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let mut uniform = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 40) as f32 + 0.5) / 16_777_216.0
    };
    move || (-2.0 * uniform().ln()).sqrt() * (core::f32::consts::TAU * uniform()).cos()
}

#[test]
fn one_coordinate_by_hand() {
    let trained = classifier(1, 0, 1.0);
    let mut commissioning = started(&trained, CommissioningConstants { widest: 5.0, ..constants(3, 2.0, 3.0) });
    // m = 0 + 3/3, Ψ = 3 + 2/3·9, κ = 3; then m = 1 − 2/4, Ψ = 9 + 3/4·4, κ = 4; then nothing moves.
    for (z, mean, scatter) in [(3.0, 1.0, 9.0), (-1.0, 0.5, 12.0), (0.5, 0.5, 12.0)] {
        commissioning.add(&trained.novelty, &[z], &[0.0]).unwrap();
        assert!(
            (commissioning.mean()[0] - mean).abs() < 1e-6 && (commissioning.scatter[0] - scatter).abs() < 1e-5,
            "{commissioning:?}"
        );
    }
    let made = commissioning.finish(plan(1, 0), &trained).unwrap();
    // S = 12/6; every class moves by 0.5.
    assert_eq!((commissioning.gathered(), commissioning.weight, commissioning.freedom), (3, 5.0, 6.0));
    assert!((made.novelty.factor[0] - 2.0).abs() < 1e-6);
    assert_eq!(made.discriminant.means, [0.5, 8.5]);
    assert_eq!(made.discriminant.factors, trained.discriminant.factors);
}

/// A coordinate that rises is judged by its own ratio, which has the freedom and the factor of the commissioned law.
#[test]
fn a_rising_coordinate_has_the_factor_of_the_mean_s_error() {
    let trained = classifier(1, 1, 1.0);
    let mut commissioning = started(&trained, CommissioningConstants { widest: 5.0, ..constants(3, 2.0, 3.0) });
    for z in [3.0, -1.0, 0.5] {
        commissioning.add(&trained.novelty, &[z], &[0.0]).unwrap();
    }
    let made = commissioning.finish(plan(1, 1), &trained).unwrap();
    // ν = 6, and 1 + 1/κ = 1.2.
    assert!((made.novelty.freedom - 7.2).abs() < 1e-5, "{}", made.novelty.freedom);
}

/// The posterior of all segments at once (Gelman et al., §3.6) in double precision.
#[test]
fn the_order_of_segments_does_not_matter_and_all_at_once_is_the_same() {
    const N: usize = 25;
    let (trained, mut draw) = (classifier(3, 0, 2.0), noise(3));
    let rows: Vec<[f32; 3]> = (0..N)
        .map(|_| {
            let [a, b, c] = [draw(), draw(), draw()];
            [2.0 + a, a - 0.5 * b, 1.0 + 0.3 * c - a]
        })
        .collect();
    let (kappa, nu, n) = (4.0, 6.0, N as f64);
    let mean = [0, 1, 2].map(|k| rows.iter().map(|row| f64::from(row[k])).sum::<f64>() / n);
    for reversed in [false, true] {
        let mut commissioning = started(&trained, constants(10, kappa as f32, nu as f32));
        for k in 0..N {
            commissioning.add(&trained.novelty, &rows[if reversed { N - 1 - k } else { k }], &[]).unwrap();
        }
        let made = commissioning.finish(plan(3, 0), &trained).unwrap().novelty;
        let [d0, r01, r02, d1, r12, d2] = made.factor[..] else { panic!("six numbers") };
        let covariance = |i: usize, j: usize| match (i, j) {
            (0, 0) => d0,
            (0, 1) => d0 * r01,
            (0, 2) => d0 * r02,
            (1, 1) => d0 * r01 * r01 + d1,
            (1, 2) => d0 * r01 * r02 + d1 * r12,
            _ => d0 * r02 * r02 + d1 * r12 * r12 + d2,
        };
        for i in 0..3 {
            assert!((f64::from(made.mean[i]) - n / (kappa + n) * mean[i]).abs() < 1e-5);
            for j in i..3 {
                let scatter: f64 =
                    rows.iter().map(|row| (f64::from(row[i]) - mean[i]) * (f64::from(row[j]) - mean[j])).sum();
                let prior = if i == j { 2.0 * nu } else { 0.0 };
                let expected = (prior + scatter + kappa * n / (kappa + n) * mean[i] * mean[j]) / (nu + n);
                // Some thirty roundings of numbers near one.
                assert!(
                    (f64::from(covariance(i, j)) - expected).abs() < 1e-5,
                    "{i} {j}: {} {expected}",
                    covariance(i, j)
                );
            }
        }
    }
}

/// The classifier whose healthy covariance is that of so many segments more than one.
fn estimated(known: &Classifier<RunTime>, freedom: u32, draw: &mut impl FnMut() -> f32) -> Classifier<RunTime> {
    let mut trained = known.clone();
    let mut commissioning = started(known, constants(10, 0.0, 1.0));
    // Next to nothing beside the segments.
    each_pivot(&mut commissioning.scatter, known.novelty.mean.len() as u8, |pivot| *pivot = 1e-9);
    let z = |draw: &mut dyn FnMut() -> f32| (0..known.novelty.mean.len()).map(|_| draw()).collect::<Vec<f32>>();
    (0..=freedom).for_each(|_| commissioning.merge(&z(draw), &vec![1.0; known.novelty.mean.len()]));
    trained.novelty.factor = commissioning.scatter;
    let coordinates = known.novelty.mean.len() as u8;
    each_pivot(&mut trained.novelty.factor, coordinates, |pivot| *pivot /= freedom as f32);
    trained
}

/// Mean rate of segments that gates call novel, over drives whose means differ from the trained one by `away` standard
/// deviations. Their variance is a `part` of the trained one, which is known exactly; without a part, it is estimated
/// from as many segments as it counts.
fn rate(
    [coordinates, rising]: [u8; 2],
    (fewest, mean_weight, counted): (u32, f32, u16),
    (away, part): (f32, Option<f32>),
) -> f32 {
    const DRIVES: u64 = 600;
    const JUDGED: usize = 100;
    let covariance_weight = f32::from(counted);
    let known = classifier(coordinates, rising, 1.0 / part.unwrap_or(1.0));
    let (plan, n) = (plan(coordinates, rising), coordinates as usize);
    let mut novel = 0;
    for drive in 0..DRIVES {
        let mut draw = noise(1000 + drive);
        let trained = if part.is_some() { known.clone() } else { estimated(&known, counted.into(), &mut draw) };
        let offset: Vec<f32> = (0..n).map(|_| away * draw()).collect();
        let mut segment = || offset.iter().map(|mean| mean + draw()).collect::<Vec<f32>>();
        let limits = CommissioningConstants { farthest: 1e6, widest: 1e6, ..constants(fewest, 1.0, 1.0) };
        let mut commissioning = started(&trained, CommissioningConstants { mean_weight, covariance_weight, ..limits });
        while commissioning.gathered() < fewest {
            commissioning.add(&trained.novelty, &segment(), &[]).unwrap();
        }
        let made = commissioning.finish(plan, &trained).unwrap().novelty;
        novel += (0..JUDGED).filter(|_| made.judge(&segment(), &[]).surprise >= made.limit).count();
    }
    100.0 * novel as f32 / (DRIVES as usize * JUDGED) as f32
}

#[test]
fn the_rate_is_the_set_one_whatever_the_number_of_segments() {
    // 600 alarms among 60 000 segments. The rates of single gates scatter by 2.5 % for 12 segments of one coordinate,
    // and less for the others: the standard error is at most 0.11 %.
    for ([coordinates, rising], fewest, weight) in [
        ([1, 0], 12, 1),
        ([2, 0], 15, 3),
        ([3, 0], 20, 5),
        ([3, 0], 40, 10),
        ([5, 0], 30, 8),
        ([3, 1], 20, 4),
        ([4, 2], 30, 5),
        ([2, 2], 25, 3),
    ] {
        let percent = rate([coordinates, rising], (fewest, 0.0, weight), (5.0, None));
        std::println!(
            "{coordinates} coordinates, {rising} rising, {fewest} segments, weight {weight}: {percent:.2} % for 1 %"
        );
        assert!((0.75..1.25).contains(&percent), "{percent}");
    }
}

#[test]
fn a_wide_prior_lowers_the_rate_by_its_weight_only() {
    // The trained variance is four times that of the drive, whose mean scatters with it: with weight 2 of 32.
    let percent = rate([3, 0], (30, 0.5, 2), (1.7, Some(0.25)));
    std::println!("a prior of four times the variance: {percent:.2} % for 1 %");
    assert!((0.1..1.0).contains(&percent), "{percent}");
}

#[test]
fn errors_lower_the_weight_of_a_coordinate() {
    let trained = classifier(2, 0, 1.0);
    let mut commissioning = started(&trained, constants(3, 2.0, 3.0));
    commissioning.add(&trained.novelty, &[3.0, 3.0], &[0.0, 3.0]).unwrap();
    // The second one has the weight 1/4: m = 3/4/(2 + 1/4), and x √w = 1.5. Ψ = 3 I + 2/3 (3, 1.5)(3, 1.5)ᵀ.
    let [d, r, below] = commissioning.scatter[..] else { panic!("three numbers") };
    assert!(
        (commissioning.mean()[0] - 1.0).abs() < 1e-6 && (commissioning.mean()[1] - 1.0 / 3.0).abs() < 1e-6,
        "{commissioning:?}"
    );
    assert!(
        (d - 9.0).abs() < 1e-5 && (d * r - 3.0).abs() < 1e-5 && (d * r * r + below - 4.5).abs() < 1e-5,
        "{commissioning:?}"
    );
}

#[test]
fn the_rate_stays_with_errors_in_half_of_the_segments() {
    // Errors of up to four times the variance in one of three coordinates, in gathered and in judged segments.
    let known = classifier(3, 0, 1.0);
    let mut novel = 0;
    for drive in 0..150 {
        let mut draw = noise(5000 + drive);
        let offset = [0; 3].map(|_| 5.0 * draw());
        let mut segment = |k: usize| {
            let error = if k.is_multiple_of(2) { 0.0 } else { (k % 9) as f32 * 0.5 };
            let mut z = offset.map(|mean| mean + draw());
            z[1] += error.sqrt() * draw();
            (z, [0.0, error, 0.0])
        };
        let mut commissioning =
            started(&known, CommissioningConstants { farthest: 1e6, widest: 1e6, ..constants(30, 0.0, 3.0) });
        for k in 0..30 {
            let (z, variances) = segment(k);
            commissioning.add(&known.novelty, &z, &variances).unwrap();
        }
        let made = commissioning.finish(plan(3, 0), &known).unwrap().novelty;
        let judged = (0..200).map(&mut segment);
        novel += judged.filter(|(z, variances)| made.judge(z, variances).surprise >= made.limit).count();
    }
    let percent = 100.0 * novel as f32 / 30_000.0;
    std::println!("errors in half of the segments: {percent:.2} % for 1 %");
    // The prior is exact, which lowers the rate by its weight, 3 of 33.
    assert!((0.6..1.25).contains(&percent), "{percent}");
}

#[test]
fn segments_that_cannot_be_used_are_refused_and_change_nothing() {
    let trained = classifier(2, 0, 1.0);
    let mut commissioning = started(&trained, constants(10, 1.0, 4.0));
    commissioning.add(&trained.novelty, &[0.5, 0.5], &[0.5, 0.0]).unwrap();
    let before = commissioning.clone();
    for (variances, error) in [
        ([0.0, f32::INFINITY], CommissioningError::Missing { coordinate: 1 }),
        ([f32::NAN, 0.0], CommissioningError::Missing { coordinate: 0 }),
        ([0.0, 10.5], CommissioningError::Uncertain { coordinate: 1 }),
    ] {
        assert_eq!(commissioning.add(&trained.novelty, &[0.0, 0.0], &variances), Err(error));
        assert_eq!(commissioning, before);
    }
    assert_eq!(
        commissioning.add(&trained.novelty, &[6.0, 8.5], &[]),
        Err(CommissioningError::TooFar { distance: 108.25_f32.sqrt() })
    );
    for z in [[f32::NAN, 0.0], [f32::INFINITY, 0.0], [1e30, -1e30]] {
        assert!(
            matches!(commissioning.add(&trained.novelty, &z, &[]), Err(CommissioningError::TooFar { .. })),
            "{z:?}"
        );
    }
    assert_eq!(commissioning, HealthyClass { far: 4, ..before });
}

#[test]
fn too_few_too_many_far_and_too_wide_are_refused() {
    let (trained, mut draw) = (classifier(2, 0, 1.0), noise(8));
    let mut commissioning = started(&trained, constants(20, 1.0, 4.0));
    for _ in 0..19 {
        commissioning.add(&trained.novelty, &[draw(), draw()], &[]).unwrap();
    }
    let few = CommissioningError::TooFew { gathered: 19, needed: 20 };
    assert_eq!(commissioning.finish(plan(2, 0), &trained), Err(few));
    commissioning.add(&trained.novelty, &[draw(), draw()], &[]).unwrap();
    assert!(commissioning.finish(plan(2, 0), &trained).is_ok());
    let mut strayed = commissioning.clone();
    (0..3).for_each(|_| assert!(strayed.add(&trained.novelty, &[20.0, 0.0], &[]).is_err()));
    let far = CommissioningError::TooManyFar { far: 3, gathered: 20 };
    assert_eq!(strayed.finish(plan(2, 0), &trained), Err(far));
    // Alternately 3 deviations to both sides: a variance of 9 in one coordinate, a mean of about 5.
    let mut wide = started(&trained, constants(20, 1.0, 4.0));
    for k in 0..20 {
        wide.add(&trained.novelty, &[if k % 2 == 0 { 3.0 } else { -3.0 }, draw()], &[]).unwrap();
    }
    let refused = wide.finish(plan(2, 0), &trained);
    assert!(
        matches!(refused, Err(CommissioningError::TooWide { ratio }) if (4.0..6.5).contains(&ratio)),
        "{refused:?}"
    );
}

#[test]
fn constants_out_of_range_are_refused() {
    let trained = classifier(2, 0, 1.0);
    let refused = |constants| HealthyClass::new(plan(2, 0), &trained, constants).err();
    let good = constants(20, 1.0, 4.0);
    assert_eq!(refused(good), None);
    for bad in [
        CommissioningConstants { mean_weight: -1.0, ..good },
        CommissioningConstants { mean_weight: f32::NAN, ..good },
        CommissioningConstants { covariance_weight: 0.5, ..good },
        CommissioningConstants { covariance_weight: f32::INFINITY, ..good },
        CommissioningConstants { farthest: 0.0, ..good },
        CommissioningConstants { widest: f32::NAN, ..good },
        CommissioningConstants { trained_freedom: 0.0, ..good },
        CommissioningConstants { fewest: MAX_SEGMENTS + 1, ..good },
        // ν = 1 + 3 − 2 + … is too small for a law.
        CommissioningConstants { fewest: 3, covariance_weight: 1.0, ..good },
    ] {
        assert_eq!(refused(bad), Some(CommissioningError::Constants), "{bad:?}");
    }
    let mut unknown = trained.clone();
    unknown.novelty.class = None;
    assert_eq!(HealthyClass::new(plan(2, 0), &unknown, good).err(), Some(CommissioningError::NoHealthyClass));
}
