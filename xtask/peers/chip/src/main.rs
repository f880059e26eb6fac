//! Firmware of `cargo xtask measure --peers`: kernels of the core beside those of others, by the same counter.
#![no_std]
#![no_main]

#[path = "../../../../examples/support/count.rs"]
mod count;
#[allow(dead_code, reason = "only its count of single samples is needed")]
#[path = "../../../../target-tests/examples/support/decimation.rs"]
mod decimation;
#[path = "../../../../examples/support/numbers.rs"]
mod numbers;
#[path = "../../../../examples/support/target.rs"]
mod target;

/// Prints one line; formats like `println!`.
macro_rules! say {
    ($($words:tt)*) => { crate::target::say(format_args!($($words)*)) };
}

mod decimators;
mod rls;
mod transforms;

use count::Counter;
use oxictl::adaptive::Rls;
use oxictl::core::adaptive_filters::RlsFilter;
use rls::{Cmsis, HandC, Nalgebra, Ours, OursSolved};

#[cortex_m_rt::entry]
fn main() -> ! {
    if let Some(mut counter) = Counter::new() {
        updates::<8, 9, 36>(&mut counter);
        updates::<15, 16, 120>(&mut counter);
        transforms::run(&mut counter);
        decimators::run(&mut counter);
    }
    target::succeed()
}

fn updates<const N: usize, const M: usize, const P: usize>(counter: &mut Counter) {
    let rows = rls::rows::<N, M>();
    rls::run::<Ours<M, P>, N, M>(counter, &rows);
    rls::run::<OursSolved<N, M, P>, N, M>(counter, &rows);
    rls::run::<HandC<N>, N, M>(counter, &rows);
    rls::run::<Cmsis<N>, N, M>(counter, &rows);
    rls::run::<Nalgebra<N>, N, M>(counter, &rows);
    rls::run::<RlsFilter<f32, N>, N, M>(counter, &rows);
    rls::run::<Rls<f32, N>, N, M>(counter, &rows);
}
