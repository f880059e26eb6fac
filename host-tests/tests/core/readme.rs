//! The firmware code of README.md, compiled as it stands there and run on the recorded traces of the example.

mod code {
    include!(concat!(env!("OUT_DIR"), "/readme.rs"));
}

use code::{Counts, conclude, interrupt, start};

#[test]
fn counts_become_a_verdict() {
    let (mut detector, mut evidence) = start().expect("the model has no Park convention");
    // Sines and noise, which excite every parameter. What counts is that the chain closes a segment.
    let mut found = None;
    let mut state = 1_u32;
    let mut noise = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 8_388_608.0 - 1.0
    };
    for k in 0..5000_u16 {
        let t = 0.002 * f32::from(k);
        let mut wave = |f: f32, size: f32| (2048.0 + size * ((core::f32::consts::TAU * f * t).sin() + noise())) as u16;
        let counts = Counts {
            phase_a: wave(0.2, 300.0),
            phase_b: wave(0.7, 200.0),
            resolver: k.wrapping_mul(37) % 16_384,
            load: wave(0.5, 150.0),
        };
        let reference = 40.0 * ((core::f32::consts::TAU * 0.2 * t).sin() + noise());
        if let Some(segment) = interrupt(&mut detector, &counts, reference) {
            found = Some(conclude(&mut detector, &mut evidence, segment));
        }
    }
    let (class, alarm) = found.expect("a segment of 5000 samples");
    assert!(["healthy", "spall", "roughness"].contains(&class) && !alarm, "{class}");
}
