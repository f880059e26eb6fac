//! The core's own log by `defmt`: a line for every closed segment. Texts stay in the ELF file, the wire carries a few
//! bytes a line. Run by `cargo xtask firmware logging`, which decodes them.
//!
//! First the recording as the example `monitor` has it, then its first trace again: with lost and saturated samples, and
//! with a sensor that gets stuck.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
mod support;

#[cfg(target_os = "none")]
#[path = "support/standard_rig/mod.rs"]
mod standard_rig;

main!(run);

#[cfg(not(target_os = "none"))]
fn run() {
    say!("defmt logs on the target only: cargo xtask firmware logging");
}

#[cfg(target_os = "none")]
fn run() {
    use bearing_watch::{Guard, Model, Regression, Sample};
    use standard_rig::model::{MODEL, Monitor};

    static LIMIT: [f32; 3] = MODEL.regression.guard.limit;
    /// The sensor saturates at half the limit, and no reading repeats itself for so long.
    static GUARDED: Model<6, 5, 5, 3> = Model {
        regression: Regression {
            guard: Guard {
                saturation: [0.5 * LIMIT[0], LIMIT[1], LIMIT[2]],
                stuck_samples: [200, 0, 0],
                ..MODEL.regression.guard
            },
            ..MODEL.regression
        },
        ..MODEL
    };

    /// A running drive would not restart; but the next trace does not go on from this one.
    fn watch(monitor: &mut Monitor, samples: impl Iterator<Item = Sample>) {
        for sample in samples {
            if monitor.step(sample).is_some() {
                monitor.restart();
            }
        }
    }

    let (mut plain, mut strict) = match (Monitor::new(&MODEL), Monitor::new(&GUARDED)) {
        (Ok(plain), Ok(strict)) => (plain, strict),
        (Err(error), _) | (_, Err(error)) => return defmt::error!("the model is refused: {}", error),
    };
    watch(&mut plain, standard_rig::samples());
    let first = || standard_rig::samples().take(MODEL.sampling.segment_samples as usize).enumerate();
    watch(
        &mut strict,
        first().map(|(number, sample)| match number % 1000 {
            0 => Sample { y: f32::NAN, ..sample },
            500 => Sample { y: 0.75 * LIMIT[0], ..sample },
            _ => sample,
        }),
    );
    watch(
        &mut strict,
        first().map(|(number, sample)| if number < 3000 { sample } else { Sample { y: 1.0, ..sample } }),
    );
}
