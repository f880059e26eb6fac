//! Instructions of a sample of the detector, small enough for chips without a floating-point unit: run it by
//! `cargo xtask measure`.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
mod support;

use core::hint::black_box;

use bearing_watch::{Detector, Exchange, Segment};

use support::count::Counter;
use support::{refined, squares};

/// Samples before the first that counts: filters and lags have filled.
const SETTLING: u32 = 100;

/// Samples that count; fewer than a segment.
const CALLS: u32 = 200;

main!(run);

fn run() {
    let Some(mut counter) = Counter::new() else {
        say!("instructions are counted on the target only: cargo xtask measure");
        return;
    };
    let [mut one, mut other] = [(); 2].map(|()| Segment::new(&squares::MODEL));
    let (mut detector, mut spare) = (Detector::with_place(black_box(&squares::MODEL), &mut one), Some(&mut other));
    let mut plant = refined::Plant::new(6);
    let (mut total, mut longest) = (0, 0);
    for number in 0..SETTLING + CALLS {
        let refined::Sample { y, u1, u2 } = plant.sample();
        let sample = squares::Sample { y, u1, u2 };
        let mut closed = Exchange::Open;
        let one = counter.instructions_once(|| {
            closed = black_box(&mut detector).exchange(black_box(&sample), black_box(&mut spare));
        });
        if let Exchange::Closed(place) = closed {
            spare = Some(place);
        }
        if number >= SETTLING {
            (total, longest) = (total + one, one.max(longest));
        }
    }
    let (mean, bytes) = (total / CALLS, size_of_val(&detector));
    say!(r#"{{"name":"LS detector, collect, mean sample","n":8,"instructions":{mean},"bytes":{bytes}}}"#);
    say!(r#"{{"name":"LS detector, collect, longest sample","n":8,"instructions":{longest},"bytes":null}}"#);
}
