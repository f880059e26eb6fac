//! Instructions of the front end.

use core::hint::black_box;

use bearing_watch::drive::{By, Factor, FrontEnd, RawSample};

use super::count::Counter;
use super::decimation::{Spread, spread};
use super::raw::{CONSTANTS, Motor, Sensors};

/// `report` gets name, factor, instructions and bytes of state.
pub fn measure(counter: &mut Counter, report: impl Fn(&str, usize, u32, usize)) {
    let name = ["resolver, 3 currents, 2 further, mean sample", "resolver, 3 currents, 2 further, worst sample"];
    one::<2, 8>(counter, Sensors::Resolver, name, &report);
    let name = ["converter, 2 currents, mean sample", "converter, 2 currents, worst sample"];
    one::<0, 8>(counter, Sensors::Converter, name, &report);
    one::<0, 10>(counter, Sensors::Converter, name, &report);
}

fn one<const FURTHER: usize, const FACTOR: usize>(
    counter: &mut Counter,
    sensors: Sensors,
    names: [&str; 2],
    report: impl Fn(&str, usize, u32, usize),
) where
    By<FACTOR>: Factor,
{
    let Ok(mut front_end) = FrontEnd::<FURTHER, FACTOR>::new(black_box(&CONSTANTS)) else { return };
    let mut motor = Motor::<FURTHER>::new(sensors);
    for _ in 0..1000 {
        black_box(front_end.push(&motor.sample()));
    }
    let samples: [RawSample<FURTHER>; 400] = core::array::from_fn(|_| motor.sample());
    let mut next = samples.iter();
    // Of this number a call takes the sample from the list.
    let Spread { mean, worst } = spread(counter, FACTOR, || {
        if let Some(sample) = next.next() {
            black_box(front_end.push(black_box(sample)));
        }
    });
    let [mean_name, worst_name] = names;
    report(mean_name, FACTOR, mean, size_of_val(&front_end));
    report(worst_name, FACTOR, worst, size_of_val(&front_end));
}
