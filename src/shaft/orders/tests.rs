use super::*;
use crate::plan::{Layout, ShaftLayout};

const TURN: f64 = 4_294_967_296.0;

crate::plan! {
    struct One;
    struct Moved with angle { current: "A", velocity: "rad/s" }
    layout: Layout {
        shaft: Some(ShaftLayout {
            current,
            velocity,
            reference: velocity,
            load: None,
            orders: 1,
            harmonics: 1,
        }),
        features: 1,
        coordinates: 1,
        classes: 1,
        ..Layout::EMPTY
    }
}

type Track = OrderTracking<One>;

const fn tracking(order: f32) -> Tracking<One> {
    let orders = [TrackedOrder::new(order, [1.0, 0.0, 0.0])];
    Tracking { orders, slowest_turn: 1000, block_samples: 100 }
}

fn strength(track: &Track, tracking: &Tracking<One>) -> Result<OrderStrength, Reason> {
    track.sums().strength(tracking, 0)
}

/// Turns of a shaft that speeds up, reverses and comes back, at most 0.03 a sample; 14-bit angles.
fn angle(k: u32) -> u32 {
    let t = f64::from(k) * 1e-3;
    let turns = 12.0 * (0.7 * t).sin() + 2.0 * t;
    ((turns * 16_384.0).floor() as i32).cast_unsigned() << 18
}

#[test]
fn phase_is_that_of_the_turned_way_over_thousands_of_turns_and_reversals() {
    let tracking = tracking(3.717_94);
    let mut track = Track::new(One);
    let (mut last, mut way, mut turned) = (angle(0), 0.0_f64, 0.0_f64);
    for k in 1..2_000_000 {
        let now = angle(k);
        let step = now.wrapping_sub(last).cast_signed();
        last = now;
        way += f64::from(step);
        turned += f64::from(step).abs() / TURN;
        track.step(1, &tracking, step, None);
    }
    assert!(turned > 10_000.0, "{turned}");
    let order = f64::from(tracking.orders[0].order_q16) / 65_536.0;
    let exact = order * (way / TURN);
    let phase = ((track.lines[0].phase >> 16) & 0xFFFF_FFFF) as f64;
    let error = (exact - exact.floor()) - phase / TURN;
    // The oracle adds in double precision: 2e6 roundings of 1e-16 × 4e13 counts stay below 1e-6 turns.
    assert!((error - error.round()).abs() < 1e-5, "{error}");
}

#[test]
fn drag_at_the_order_stands_out_by_the_number_of_blocks() {
    let tracking = tracking(3.717_94);
    for (order, expected) in [(3.717_94_f64, 400.0), (4.1, 0.1)] {
        let mut track = Track::new(One);
        let mut last = angle(0);
        let mut way = 0.0_f64;
        for k in 1..60_000 {
            let now = angle(k);
            let step = now.wrapping_sub(last).cast_signed();
            last = now;
            way += f64::from(step) / TURN;
            // A drag of 0.5 at the order, against the motion.
            let drag = 0.5 * (core::f64::consts::TAU * order * way + 1.0).cos() * f64::from(step.signum());
            track.step(1, &tracking, step, Some(drag as f32));
        }
        let strength = strength(&track, &tracking).unwrap();
        if expected > 1.0 {
            // Every block alike: R is their number (still samples aside), the amplitude what was put in.
            assert!(strength.prominence > expected && (strength.amplitude - 0.5).abs() < 2e-3, "{strength:?}");
        } else {
            assert!(strength.prominence < 3.0 && strength.amplitude < 0.02, "{strength:?}");
        }
    }
}

#[test]
fn amplitude_is_that_of_the_drag_with_few_blocks_too() {
    let tracking = tracking(3.717_94);
    let mut track = Track::new(One);
    let mut way = 0.0_f64;
    // Eight blocks, a fraction of a turn each sample that closes no block at a whole period.
    for _ in 0..800 {
        let step = 43_000_000;
        way += f64::from(step) / TURN;
        let drag = 0.5 * (core::f64::consts::TAU * 3.717_94 * way).cos();
        track.step(1, &tracking, step, Some(drag as f32));
    }
    let strength = strength(&track, &tracking).unwrap();
    // The mirror image at −O leaves 1/(π periods a block) of a block: 3.7 periods, 9 %, of changing phase.
    assert!((strength.amplitude - 0.5).abs() < 0.01 && strength.prominence > 7.8, "{strength:?}");
}

#[test]
fn too_short_and_out_of_range_are_reasons() {
    let tracking = tracking(3.7);
    let mut track = Track::new(One);
    assert_eq!(strength(&track, &tracking), Err(Reason::TooFewRows { part: Part::Orders, rows: 0 }));
    for _ in 0..2000 {
        track.step(1, &tracking, 1 << 20, Some(1e30));
    }
    assert_eq!(strength(&track, &tracking), Err(Reason::NotFinite(Part::Orders)));
    track.next_segment();
    for _ in 0..2000 {
        track.step(1, &tracking, 1 << 20, Some(0.0));
    }
    assert_eq!(strength(&track, &tracking).unwrap().prominence, 0.0);
}

#[test]
fn harmonics_are_those_of_the_angle() {
    for k in 0..1000_u32 {
        let mut line = Line { phase: i64::from(k) << 38, block: [[0.0; 2]; MAX_HARMONICS], sums: LineSums::EMPTY };
        line.add(3, 1.0);
        for (h, [x, y]) in (1_u8..).zip(line.block) {
            let angle = core::f64::consts::TAU * f64::from(k) / 1024.0 * f64::from(h);
            let (dx, dy) = (f64::from(x) - angle.cos(), f64::from(y) + angle.sin());
            // Three times the error of the phasor.
            assert!(dx.abs() < 7e-5 && dy.abs() < 7e-5, "{k} {h}: {x} {y}");
        }
    }
}

#[test]
fn blocks_of_later_orders_end_later() {
    crate::plan! {
        struct Two;
        struct Sample with angle { current: "A", velocity: "rad/s" }
        layout: Layout {
            shaft: Some(ShaftLayout { current, velocity, reference: velocity, load: None, orders: 2, harmonics: 2 }),
            features: 1,
            coordinates: 1,
            classes: 1,
            ..Layout::EMPTY
        }
    }
    let orders = [TrackedOrder::new(3.7, [1.0, 0.5, 0.0]); 2];
    let tracking = Tracking::<Two> { orders, slowest_turn: 1000, block_samples: 100 };
    let mut track = OrderTracking::new(Two);
    for k in 0..1000_u16 {
        track.step(2, &tracking, 1 << 24, Some(f32::from(k % 7)));
    }
    let sums = track.sums();
    assert_eq!((sums.closed(100, 0), sums.closed(100, 1)), ((10, 1000), (9, 901)));
    track.step(2, &tracking, 1 << 24, Some(1.0));
    let sums = track.sums();
    assert_eq!((sums.closed(100, 0), sums.closed(100, 1)), ((10, 1000), (10, 1001)));
    assert_ne!(sums.lines[0], sums.lines[1]);
}
