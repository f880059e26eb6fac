//! Calls of the map of the rotor for the example `panic_free`, which is too long for them.

use core::hint::black_box as opaque;

use bearing_watch::Angle;
use bearing_watch::shaft::*;

/// Every public function.
pub fn run() {
    let settings = opaque(RotorSettings { slowest_rad_s: 0.5, memory: 100 });
    let mut map = opaque(RotorMap::<360>::new());
    for k in 0..opaque(2000_u32) {
        let angle = Angle::from_bits(opaque(k.wrapping_mul(0x0123_4567)));
        RotorMap::push(&mut map, &settings, angle, opaque(0.1), opaque(2.0));
    }
    opaque((RotorMap::missing(&map), RotorMap::skipped(&map)));
    if let Some(table) = opaque(RotorMap::table(&map)) {
        opaque(RotorTable::at(&table, Angle::from_bits(opaque(7))));
    }
    let lines = [1, 2, 6, 12].map(|order| opaque(RotorMap::line(&map, opaque(order))).unwrap_or_default());
    for line in &lines {
        opaque((RotorLine::amplitude_a(line), RotorLine::phase_rad(line)));
    }
    let before = opaque([RotorLine { order: 1, cosine_a: 0.1, sine_a: 0.2, deviation_a: 0.01 }; 4]);
    opaque(RotorChange::between(&before, opaque(&lines), &opaque(RotorLimits::USUAL)));
}
