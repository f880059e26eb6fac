//! Instructions and bytes of the kernels, one JSON object a line: run it by `cargo xtask measure`.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
mod support;

use core::hint::black_box;

use support::count::Counter;

/// Calls a kernel is averaged over.
const CALLS: u32 = 1000;

main!(run);

fn run() {
    let Some(mut counter) = Counter::new() else {
        say!("instructions are counted on the target only: cargo xtask measure");
        return;
    };
    dot_product(&mut counter);
}

fn dot_product(counter: &mut Counter) {
    let (a, b) = ([0.5_f32; 8], [0.25_f32; 8]);
    let count = counter.instructions_per_call(CALLS, |_| {
        let (a, b) = (black_box(&a), black_box(&b));
        black_box(a.iter().zip(b).map(|(a, b)| a * b).sum::<f32>());
    });
    report("dot product", 8, count, size_of_val(&a));
}

/// One line: the kernel, its size n where it has one, instructions a call, bytes of state.
fn report(name: &str, n: impl Into<Option<usize>>, instructions: u32, bytes: usize) {
    let tail = format_args!(r#""instructions":{instructions},"bytes":{bytes}}}"#);
    match n.into() {
        Some(n) => say!(r#"{{"name":"{name}","n":{n},{tail}"#),
        None => say!(r#"{{"name":"{name}","n":null,{tail}"#),
    }
}
