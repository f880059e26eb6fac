//! A whole drive on a recording: counts of the converters at the control rate → front end → detector → alarm.
//!
//! ```text
//! interrupt   row ─► WATCH.sample ─► WATCH.collect
//! main loop   WATCH.advance, a step between two rows ─► verdict, alarm
//! ```
//!
//! The recording is the file `rows.bin` of the working directory, which `bearing-watch replay --rows` writes, and the
//! model is that of `support/actuator` or, with `BEARING_WATCH_MODEL=/path/to/model.rs`, any that was trained with
//! `--front-end`. `cargo xtask pil TRACE --model out.bwm --rust model.rs` does all of it in the emulator, and compares
//! every line with the host's. Of a chip it also prints the instructions of the interrupt, and the stack.
//!
//! The model of `support/actuator` is trained on a simulated actuator, sampled at 10 kHz and decimated to 1 kHz:
//!
//! ```text
//! bearing-watch simulate --rig ema --condition rit-mix --class healthy,spall,roughness --count 30 --seed 1 --out t
//! bearing-watch train --labels t/labels.csv --front-end t/front_end.toml --y current_a --u1 velocity_ref_rad_s \
//!     --u2 load_torque_nm --order 3,3,2,1,1 --angle angle_rad --velocity velocity_rad_s --load load_torque_nm \
//!     --bearing 9,3,17,10 --features drag,viscous,order_inner --shrinkage 0,0.5 --healthy healthy \
//!     --alarm-interval-h 1000 --segment 2400 --identify --model model.bwm --rust model.rs --c model.h
//! ```
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
mod support;

#[path = "support/lines.rs"]
mod lines;
#[path = "support/rows.rs"]
mod rows;

/// Written by `bearing-watch train --front-end … --rust`.
#[allow(dead_code, reason = "rows contain angles, not counts of the position")]
mod model {
    include!(env!("BEARING_WATCH_MODEL_FILE"));
}

use core::hint::black_box;

use lines::Lines;
use model::{FURTHER, WATCH};
use rows::Rows;
use support::count::Counter;

main!(run);

fn run() {
    if let Err(message) = lines::start() {
        return say!("{message}");
    }
    let Some(mut rows) = Rows::<FURTHER>::open() else {
        say!("no recording rows.bin: see cargo xtask pil");
        return;
    };
    let (mut lines, mut cost) = (Lines::default(), Cost::new());
    cost.stack(|cost| {
        for raw in &mut rows {
            // Here both contexts are one interrupt.
            cost.interrupt(|| {
                if WATCH.sample(black_box(raw)) {
                    WATCH.collect();
                }
            });
            lines.advance();
        }
        lines.end();
    });
    cost.print();
}

/// Instructions of the interrupt and bytes of stack, on a chip; the host counts nothing.
struct Cost {
    counter: Option<Counter>,
    sum: u64,
    longest: u32,
    count: u32,
    stack: usize,
}

impl Cost {
    fn new() -> Self {
        Self { counter: Counter::new(), sum: 0, longest: 0, count: 0, stack: 0 }
    }

    fn interrupt(&mut self, work: impl FnOnce()) {
        let Some(counter) = &mut self.counter else { return work() };
        let taken = counter.instructions_once(work);
        self.sum += u64::from(taken);
        self.longest = self.longest.max(taken);
        self.count += 1;
    }

    /// Runs `work` and measures its stack, that of printing included.
    fn stack(&mut self, work: impl FnOnce(&mut Self)) {
        #[cfg(target_os = "none")]
        let stack = support::paint::stack_of(|| work(self));
        #[cfg(not(target_os = "none"))]
        let stack = {
            work(self);
            0
        };
        self.stack = stack;
    }

    fn print(&self) {
        if self.counter.is_some() {
            let Self { sum, longest, count, stack, .. } = self;
            let mean = sum / u64::from(*count).max(1);
            say!("cost: {mean} instructions a row on average, {longest} at most, {count} rows");
            say!("cost: {stack} bytes of stack");
        }
    }
}
