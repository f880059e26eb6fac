//! Placeholder of the kernels on the target: prints their results as bits.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
mod support;

main!(run);

fn run() {
    for x in [0.1_f32, 2.0, 1e-30, 1e30] {
        say!("ln {:08x} {:08x}", x.to_bits(), libm::logf(x).to_bits());
        say!("sqrt {:08x} {:08x}", x.to_bits(), libm::sqrtf(x).to_bits());
    }
}
