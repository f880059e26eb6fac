//! The smallest program with a whole drive monitor, of the model of `support/actuator`: front end of three currents and
//! a converter, least squares of eight parameters, shaft with four orders, evidence and alarm. `cargo xtask test`
//! prints its flash.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
#[path = "support/footprint.rs"]
mod footprint;
/// Written by `bearing-watch train --front-end … --rust`.
mod model {
    include!(env!("BEARING_WATCH_MODEL_FILE"));
}

use bearing_watch::drive::{PhaseCounts, RawSample};
use bearing_watch::{Detector, Evidence, Verdict};

use model::{DriveFrontEnd, FRONT_END, FURTHER, MODEL, position};

program!(run);

fn run() -> ! {
    let mut detector = Detector::new(&MODEL);
    let mut evidence = Evidence::new(&MODEL);
    let Ok(mut front_end) = DriveFrontEnd::new(&FRONT_END) else {
        loop {
            core::hint::spin_loop();
        }
    };
    let mut number = 0_u32;
    loop {
        let [y, u1, u2] = footprint::inputs();
        number = number.wrapping_add(1);
        let counts = [y, u1, u2].map(|x| {
            let [low, high, ..] = x.to_le_bytes();
            u16::from_le_bytes([low, high])
        });
        let raw: RawSample<FURTHER> = RawSample {
            number,
            currents: PhaseCounts::Three(counts),
            position: position(y.to_bits()),
            further: [u1, u2],
        };
        let Some(clean) = front_end.push(&raw) else { continue };
        if clean.found_late {
            detector.discard();
        }
        if let Some(report) = detector.step(&clean.into()) {
            let alarm = evidence.observe(report.decision.as_ref()).is_some();
            footprint::tell(if alarm { Verdict::Novel } else { report.verdict });
        }
    }
}
