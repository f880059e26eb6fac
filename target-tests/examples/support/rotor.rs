//! Instructions of the map of the rotor.

use core::hint::black_box;

use bearing_watch::Angle;
use bearing_watch::shaft::{RotorChange, RotorLimits, RotorLine, RotorMap, RotorSettings};

use super::count::Counter;

/// Samples over which a call is averaged.
const SAMPLES: u32 = 720;

/// `report` gets name, number, instructions and bytes of state.
pub fn measure(counter: &mut Counter, report: impl Fn(&str, usize, u32, usize)) {
    let settings = RotorSettings { slowest_rad_s: 0.5, memory: 1000 };
    let mut map = RotorMap::<360>::new();
    let at = |k: u32, bins: u32| Angle::from_bits(k.wrapping_mul(u32::MAX / 360).wrapping_mul(bins));
    for (velocity, bins) in [(1.0, 1), (-1.0, u32::MAX)] {
        for k in 0..2 * SAMPLES {
            map.push(&settings, at(k, bins), 0.1, velocity);
        }
    }
    let mut pushed = |bins: u32| {
        counter.instructions_per_call(SAMPLES, |k| {
            black_box(&mut map).push(&settings, black_box(at(k, bins)), black_box(0.1), black_box(1.0));
        })
    };
    let (within, ends) = (pushed(0), pushed(1));
    report("map of the rotor, sample within a bin", 360, within, size_of_val(&map));
    report("map of the rotor, sample that ends a bin", 360, ends, size_of_val(&map));
    let line = counter.instructions_per_call(4, |_| {
        black_box(black_box(&map).line(black_box(6)));
    });
    report("map of the rotor, line of an order", 360, line, size_of::<RotorLine>());
    let lines = [1, 2, 6, 12].map(|order| RotorLine { order, cosine_a: 0.1, sine_a: 0.0, deviation_a: 0.01 });
    let now = lines.map(|line| RotorLine { cosine_a: 0.0, sine_a: 0.1, ..line });
    let change = counter.instructions_once(|| {
        black_box(RotorChange::between(black_box(&lines), black_box(&now), black_box(&RotorLimits::USUAL)));
    });
    report("map of the rotor, what has changed in lines", 4, change, size_of::<RotorChange>());
}
