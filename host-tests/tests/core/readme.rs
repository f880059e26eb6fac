//! The firmware code of README.md, compiled as it stands there and run on the recorded traces of the example.

mod code {
    include!(concat!(env!("OUT_DIR"), "/readme.rs"));
}

use code::{Counts, conclude, interrupt, start};

#[test]
fn counts_become_a_verdict() {
    let (mut front_end, mut detector, mut evidence) = start().expect("constants of the example");
    // Sines and noise, which excite every parameter. What counts is that the chain closes a segment.
    let mut found = None;
    let mut state = 1_u32;
    let mut noise = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 8_388_608.0 - 1.0
    };
    for number in 0..41_000_u32 {
        let t = 0.000_25 * number as f32;
        let mut wave = |f: f32, size: f32| size * ((core::f32::consts::TAU * f * t).sin() + noise());
        let position = number.wrapping_mul(5) % 16_384;
        let electrical = 6.0 * core::f32::consts::TAU * position as f32 / 16_384.0;
        // A quadrature current only.
        let current = wave(0.2, 300.0);
        let phases =
            [0.0, 1.0, 2.0].map(|k: f32| 2048.5 - current * (electrical - k * core::f32::consts::TAU / 3.0).sin());
        let counts = Counts {
            number,
            phases: phases.map(|counts| counts as u16),
            position: position as u16,
            load: (2048.0 + wave(0.5, 150.0)) as u16,
        };
        if let Some(segment) = interrupt(&mut front_end, &mut detector, &counts, wave(0.2, 40.0)) {
            found = Some(conclude(&mut detector, &mut evidence, segment));
        }
    }
    let (class, alarm) = found.expect("a segment of 5000 samples");
    assert!(["healthy", "spall", "roughness"].contains(&class) && !alarm, "{class}");
    assert!(front_end.faults().is_clear(), "{:?}", front_end.faults());
}
