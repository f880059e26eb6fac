//! The core's own log by `defmt`: a line for every closed segment. Texts stay in the ELF file, the wire carries a few
//! bytes a line. Run by `cargo xtask firmware logging`, which decodes them.
//!
//! The program runs the recording of the example `monitor`. Then it runs the first trace twice more: with lost and
//! saturated samples, and with a sensor that gets stuck.
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
    use bearing_watch::model::Channel;
    use bearing_watch::{Detector, Model};
    use standard_rig::model::{Drive, MODEL, Sample};

    /// A running drive would not restart; but the next trace does not go on from this one.
    fn watch(monitor: &mut Detector<'_, Drive>, samples: impl Iterator<Item = Sample>) {
        for sample in samples {
            if monitor.step(&sample).is_some() {
                monitor.restart();
            }
        }
    }

    // The sensor saturates at half the limit, and no reading repeats itself for so long.
    let mut constants = MODEL.constants().clone();
    let [current, ..] = &mut constants.channels;
    let limit = current.limit;
    *current = Channel { saturation: 0.5 * limit, stuck_samples: 200, ..*current };
    let guarded = match Model::new(Drive, constants) {
        Ok(model) => model,
        Err(error) => return defmt::error!("the model is refused: {}", error),
    };
    let (mut plain, mut strict) = (Detector::new(&MODEL), Detector::new(&guarded));
    watch(&mut plain, standard_rig::samples());
    let first = || standard_rig::samples().take(MODEL.constants().sampling.segment_samples as usize).enumerate();
    watch(
        &mut strict,
        first().map(|(number, sample)| match number % 1000 {
            0 => Sample { current_a: f32::NAN, ..sample },
            500 => Sample { current_a: 0.75 * limit, ..sample },
            _ => sample,
        }),
    );
    watch(
        &mut strict,
        first().map(|(number, sample)| if number < 3000 { sample } else { Sample { current_a: 1.0, ..sample } }),
    );
}
