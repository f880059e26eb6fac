//! Two phase currents into the rotor frame, sine and cosine given.

use core::hint::black_box;

use bearing_watch::drive::AlphaBeta;
use bearing_watch::{Angle, Park};

use crate::count::Counter;

const CALLS: u32 = 200;
const WORK: &str = "Clarke + Park, sin_cos given";

unsafe extern "C" {
    fn cmsis_clarke_park(ia: f32, ib: f32, sine: f32, cosine: f32, d: *mut f32, q: *mut f32);
}

pub fn run(counter: &mut Counter) {
    let angle = Angle::from_bits(0x2345_6789).sin_cos();
    let (ia, ib) = (1.5_f32, -0.25_f32);

    let mut ours = [0.0; 2];
    let instructions = counter.instructions_per_call(CALLS, |_| {
        let (ia, ib) = black_box((ia, ib));
        let dq = Park::Standard.forward(AlphaBeta::from_two(ia, ib), black_box(angle));
        ours = black_box([dq.d, dq.q]);
    });
    report("bearing-watch", instructions, ours, ours);

    let mut theirs = [0.0; 2];
    let instructions = counter.instructions_per_call(CALLS, |_| {
        let ((ia, ib), angle) = (black_box((ia, ib)), black_box(angle));
        let [d, q] = &mut theirs;
        // SAFETY: d and q are valid for one number each.
        unsafe { cmsis_clarke_park(ia, ib, angle.sin, angle.cos, d, q) };
        black_box(&theirs);
    });
    report("CMSIS-DSP 1.10.3", instructions, theirs, ours);
}

/// The error is the difference from ours.
fn report(who: &str, instructions: u32, result: [f32; 2], ours: [f32; 2]) {
    let error = (result[0] - ours[0]).abs() + (result[1] - ours[1]).abs();
    say!(r#"{{"work":"{WORK}","who":"{who}","instructions":{instructions},"bytes":0,"error":"{error:.1e}"}}"#);
}
