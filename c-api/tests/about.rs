//! What firmware is told of a model is what the detector then asks for.
#![allow(
    clippy::cast_possible_truncation,
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::unwrap_used,
    reason = "a test fails by a panic"
)]

#[path = "../../examples/support/classifier.rs"]
mod classifier;
#[path = "../../target-tests/examples/support/law.rs"]
mod law;
#[path = "../../examples/support/numbers.rs"]
mod numbers;
#[allow(dead_code, reason = "only its model and plant are used")]
#[path = "../../examples/support/refined.rs"]
mod refined;
#[allow(dead_code, reason = "only its models and plant are used")]
#[path = "../../target-tests/examples/support/shaft.rs"]
mod shaft;
#[allow(dead_code, reason = "other tests use the rest")]
mod support;

use core::mem::MaybeUninit;

use bearing_watch::plan::{Plan, Signals};
use bearing_watch::{Angle, Model};
use bearing_watch_c::*;

use support::{FILE, Memory, bytes, channels, conclude, values};

fn info(state: *const BwState) -> BwInfo {
    let mut info = MaybeUninit::<BwInfo>::uninit();
    // SAFETY: the state is initialised; the place is written if the code says so.
    unsafe {
        assert_eq!(bw_info(state, info.as_mut_ptr()), BwCode::Ok);
        info.assume_init()
    }
}

fn collect<P: Plan>(state: *mut BwState, model: &Model<P>, sample: &P::Sample, angle: Angle) -> BwCode {
    support::collect(state, &channels(model, sample), angle.bits())
}

/// The scores of the orders of a segment whose angles are passed on by `angle`.
fn orders(state: *mut BwState, angle: impl Fn(Angle) -> Angle) -> Vec<u32> {
    let mut plant = shaft::Plant::new(3);
    for _ in 0..shaft::MODEL.constants().sampling.segment_samples {
        let sample: shaft::Sample = plant.motion().into();
        collect(state, &shaft::MODEL, &sample, angle(sample.angle()));
    }
    assert_eq!(conclude(state), BwCode::Report);
    values(state, BwValues::OrderAmplitudes).iter().map(|x| x.to_bits()).collect()
}

#[test]
fn an_angle_is_needed_where_it_changes_a_result() {
    let model = bytes(&shaft::MODEL);
    let (mut memory, mut other) = (Memory::new(), Memory::new());
    let (state, still) = (memory.state(&model).expect("good model"), other.state(&model).expect("good model"));
    let moved = orders(state, |angle| angle) != orders(still, |_| Angle::ZERO);
    assert!(moved && info(state).needs_angle && info(state).orders == 4);
    let mut memory = Memory::new();
    assert!(!info(memory.state(FILE).expect("good model")).needs_angle, "least squares alone");
}

/// The parameters of the third segment if the first one is solved behind `samples` samples of the second one.
fn third(samples: u32) -> Vec<f32> {
    let mut memory = Memory::new();
    let state = memory.state(&bytes(&refined::MODEL)).expect("good model");
    let (mut plant, segment) = (refined::Plant::new(5), info(state).segment_samples);
    for k in 1..=3 * segment {
        collect(state, &refined::MODEL, &plant.sample(), Angle::ZERO);
        // The second one is solved at once, and is another one.
        if k == segment + samples || k == 2 * segment {
            assert_eq!(conclude(state), BwCode::Report);
        }
    }
    assert_eq!(conclude(state), BwCode::Report);
    values(state, BwValues::Parameters)
}

/// By instrumental variables a segment depends on the estimate of the one before, if that comes in time.
#[test]
fn an_estimate_comes_in_time_until_the_handover() {
    let mut memory = Memory::new();
    let handover = info(memory.state(&bytes(&refined::MODEL)).expect("good model")).handover;
    assert!(handover > 0);
    let [at_once, in_time, late] = [0, handover - 1, handover + 1].map(third);
    assert!(at_once == in_time && in_time != late, "{handover}: {at_once:?} {in_time:?} {late:?}");
}
