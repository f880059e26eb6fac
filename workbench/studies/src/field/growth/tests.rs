use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::delay::Fleet;
use super::render::{growing, told};
use super::*;
use model::evaluate::Rate;

#[test]
fn laws_grow_from_nothing_to_full_size() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    for law in Law::ALL {
        for _ in 0..20 {
            let (sizes, onset) = law.history(80.0, &mut random);
            assert!((20..250).contains(&onset) && sizes.len() == onset + 82, "{law:?}");
            assert!(sizes[onset - 1] == 0.0 && (sizes[sizes.len() - 1] - 1.0).abs() < 1e-9, "{law:?}");
            let rises = sizes[onset..].windows(2).all(|pair| pair[1] >= pair[0] - 1e-9);
            assert!(rises && sizes.iter().all(|size| (0.0..=1.0 + 1e-9).contains(size)), "{law:?}");
            let before = sizes[..onset].iter().fold(0.0, |most: f64, size| most.max(*size));
            assert_eq!(before > 0.3, law == Law::Repaired, "{law:?} {before}");
        }
    }
}

#[test]
fn shares_by_hand() {
    let asked = |truth, left| Asked { truth, left };
    let covered = asked(10.0, Some([11.0, 8.0, 14.0]));
    let late = asked(20.0, Some([11.0, 8.0, 14.0]));
    let silent = asked(10.0, None);
    let all = [[covered, silent, late], [covered, silent, covered], [late, silent, covered]];
    let first = told(&all, 0);
    assert!(
        first.told == [3, 3] && (first.covered.value - 2.0 / 3.0).abs() < 1e-12 && (first.width - 0.3).abs() < 1e-12
    );
    assert!(told(&all, 1).told == [0, 3] && told(&all, 1).width.is_nan());
    let healthy = [Healthy { runs: 50, growing: 0 }, Healthy { runs: 50, growing: 2 }];
    assert_eq!(growing(&healthy), [0.02, 0.5]);
}

/// Checks shares of the histories of all laws, and the covered ones by `good`.
fn check(draw: &Draw, least_told: [f64; 2], good: impl Fn(Rate) -> bool) {
    println!("{}", text(std::slice::from_ref(draw)));
    for kind in &draw.kinds {
        let all: Vec<Outcome> = kind.grown.iter().flat_map(|(_, outcomes)| outcomes.clone()).collect();
        for (part, least_told) in (1..PARTS.len()).zip(least_told) {
            let asked = told(&all, part);
            let share = asked.told[0] as f64 / asked.told[1] as f64;
            assert!(share > least_told, "{:?} {part}: told in {share}", kind.kind);
            // Where few histories have a time left, it is those whose size chance has made large: without the limits of
            // the size, the same intervals contain the truth in 92 % for the spall and 89 % for roughness.
            assert!(share < 0.4 || good(asked.covered), "{:?} {part}: covered {:?}", kind.kind, asked.covered);
        }
        let [runs, _] = growing(&kind.healthy[0]);
        assert!(runs < 0.02, "{:?}: healthy drives grow after {runs} of the runs", kind.kind);
    }
}

#[test]
fn a_small_fleet_s_intervals_contain_the_truth() {
    let fleet = delay::Settings {
        training: Fleet { units: 18, sessions: 3 },
        records: 4,
        drives: 2,
        healthy: 12,
        defective: 3,
        ..delay::Settings::STANDARD
    };
    let settings = Settings { fleet, histories: 20, ..Settings::STANDARD };
    let draw = draw(delay::conditions()[0], 0, &settings).expect("simulates");
    // Sizes are in deviations at the upper limit of the variance between runs, which 54 runs leave wide: half way to the
    // named size, fewer of the histories have grown beyond doubt.
    check(&draw, [0.1, 0.5], |covered| (0.75..0.995).contains(&covered.value));
}

#[test]
#[ignore = "takes minutes"]
fn the_intervals_contain_the_truth_in_85_to_95_percent_of_the_histories() {
    let draw = draw(delay::conditions()[0], 0, &Settings::STANDARD).expect("simulates");
    // The share of a draw has an interval, which must reach into the goal.
    check(&draw, [0.6; 2], |covered| covered.high > 0.85 && covered.low < 0.95);
}
