//! Placeholder of the monitor on the target: prints a recursion's values as bits.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
mod support;

main!(run);

fn run() {
    let mut y = 1.0_f32;
    for k in 0..4 {
        y = 0.75 * y + 0.1;
        say!("estimate {k} {:08x}", y.to_bits());
    }
}
